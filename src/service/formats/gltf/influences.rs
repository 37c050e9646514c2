//! Joints and weights of vertices.

use gltf::json::accessor::ComponentType;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::super::error::ReadError;
use super::accessor::Accessor;
use super::document::Document;
use super::fault::malformed;
use crate::engine::mesh::Influences;

/// Sets of four that are read; more are not seen in the field.
const MOST_SETS: u32 = 4;

/// The accessors of joints and weights, set by set.
pub(super) fn sets(primitive: &Primitive) -> Vec<[usize; 2]> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|accessor| accessor.value());
    let set = |n| Some([attribute(Semantic::Joints(n))?, attribute(Semantic::Weights(n))?]);
    (0..MOST_SETS).map_while(set).collect()
}

/// Joints and weights of `count` vertices, a number that was claimed; `joints` are the numbers of the skin's joints.
///
/// # Errors
/// If the accessors are not what they should be, or a vertex hangs on a joint that the skin does not have.
pub(super) fn read(
    document: &Document<'_>,
    sets: &[[usize; 2]],
    count: usize,
    joints: &[u16],
    place: &str,
) -> Result<Vec<Influences>, ReadError> {
    let mut values = Vec::with_capacity(sets.len());
    for &[numbers, weights] in sets {
        let numbers = Accessor::of(document, numbers, place)?;
        let is_integer = matches!(numbers.kind, ComponentType::U8 | ComponentType::U16) && !numbers.normalised;
        if numbers.count != count || numbers.components != 4 || !is_integer {
            return Err(malformed(numbers.place, "JOINTS must be VEC4 of unsigned bytes or shorts, one per vertex"));
        }
        let weights = Accessor::of(document, weights, place)?;
        let is_weight = matches!(weights.kind, ComponentType::F32 | ComponentType::U8 | ComponentType::U16);
        if weights.count != count || weights.components != 4 || !is_weight {
            return Err(malformed(weights.place, "WEIGHTS must be VEC4 of floats or fractions, one per vertex"));
        }
        values.push((numbers.floats()?, weights.floats()?));
    }
    of_vertices(&values, count, joints, place)
}

/// Four joint numbers and weights per vertex and set, as a file says them. Weights that are no positive numbers are none;
/// vertices without any hang on the skin's first joint; sums need not be 1.
///
/// # Errors
/// If a vertex hangs on a joint that the skin does not have.
pub(super) fn of_vertices(
    sets: &[(Vec<f64>, Vec<f64>)],
    count: usize,
    joints: &[u16],
    place: &str,
) -> Result<Vec<Influences>, ReadError> {
    let otherwise = Influences::one(joints.first().copied().unwrap_or(0));
    let of_vertex = |v: usize| {
        let own = 4 * v..4 * v + 4;
        let pairs = sets.iter().flat_map(|(numbers, weights)| numbers[own.clone()].iter().zip(&weights[own.clone()]));
        let mut outside = None;
        let pairs = pairs.filter(|(_, weight)| **weight > 0.0).filter_map(|(&number, &weight)| {
            let joint = joints.get(number as usize).copied();
            outside = outside.or(joint.is_none().then_some(number));
            Some((joint?, weight))
        });
        let influences = Influences::of(pairs).unwrap_or(otherwise);
        match outside {
            Some(number) => {
                let cause =
                    format!("vertex {v} hangs on joint {number}, there are {} joints in its skin", joints.len());
                Err(malformed(place, cause))
            }
            None => Ok(influences),
        }
    };
    (0..count).map(of_vertex).collect()
}
