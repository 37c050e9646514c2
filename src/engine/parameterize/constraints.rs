//! The linear conditions of a seamless map, and which unknowns must be integers for an integer-grid map.

use glam::DVec2;

use crate::engine::field::CrossField;
use crate::engine::field::Frames;
use crate::engine::mesh::{TriMesh, next};
use crate::engine::parameterize::corner_forms::{CornerForms, real_parts};
use crate::engine::parameterize::elimination::Elimination;
use crate::engine::parameterize::grid_map::Iso;
use crate::engine::parameterize::map_error::MapError;
use crate::engine::parameterize::reduced::Unknowns;

/// Which coordinate is constant along each feature or boundary halfedge: the one that changes less along it by the
/// gradients of u and v per face.
pub(super) fn iso_lines(mesh: &TriMesh, frames: &Frames, gradients: &[[DVec2; 2]], is_feature: &[bool]) -> Vec<Iso> {
    let of_feature = |h: usize| {
        let [u, v] = gradients[h / 3].map(|gradient| gradient.dot(frames.edge(mesh, h)).abs());
        if v <= u { Iso::V } else { Iso::U }
    };
    (0..mesh.n_halfedges()).map(|h| if is_feature[h] { of_feature(h) } else { Iso::None }).collect()
}

/// Vertices that must lie on integer points: singular ones and corners, sorted.
pub(super) fn special_vertices(mesh: &TriMesh, field: &CrossField, corners: &[u32]) -> Vec<u32> {
    let mut special: Vec<u32> =
        (0..mesh.n_vertices() as u32).filter(|&v| field.quarter_index[v as usize] != 0).collect();
    special.extend(corners);
    special.sort_unstable();
    special.dedup();
    special
}

/// Combinations of unknowns that must be integers.
pub(super) type Integral = Vec<Vec<(u32, f64)>>;

/// Eliminates what a map must hold, so that the unknowns that are left may be chosen freely; and what of them must be
/// integers.
///
/// # Errors
/// Conditions that contradict each other.
pub(super) fn constrain(
    mesh: &TriMesh,
    forms: &CornerForms,
    iso: &[Iso],
    special: &[u32],
) -> Result<(Unknowns, Integral), MapError> {
    let n_real = 2 * forms.n_unknowns;
    let mut rank: Vec<u8> = (0..n_real).map(|x| u8::from(x >= 2 * forms.n_vertices)).collect();
    for &v in special {
        (rank[2 * v as usize], rank[2 * v as usize + 1]) = (2, 2);
    }
    let mut elimination = Elimination::new(rank);
    // Translating all charts together changes nothing: one point is put at the origin.
    let on_iso = || (0..mesh.n_halfedges()).find(|&h| iso[h] != Iso::None).map(|h| mesh.origin(h));
    let origin = special.first().copied().or_else(on_iso).unwrap_or(0);
    elimination.add(&[(2 * origin, 1.0)]);
    elimination.add(&[(2 * origin + 1, 1.0)]);
    for closure in &forms.closures {
        for part in real_parts(closure) {
            elimination.add(&part);
        }
    }
    let coordinate = |h: usize, corner: usize| {
        let [re, im] = real_parts(&forms.corner[corner]);
        if iso[h] == Iso::U { re } else { im }
    };
    let lines: Vec<usize> = (0..mesh.n_halfedges()).filter(|&h| iso[h] != Iso::None && mesh.is_edge_owner(h)).collect();
    for &h in &lines {
        let mut relation = coordinate(h, next(h));
        relation.extend(coordinate(h, h).into_iter().map(|(x, c)| (x, -c)));
        elimination.add(&relation);
    }
    // Whatever must be an integer is a combination of unknowns that then must be integers, too.
    let mut integral: Integral = Vec::new();
    for k in 2 * forms.n_vertices..n_real {
        integral.push(vec![(k as u32, 1.0)]);
    }
    for &v in special {
        integral.push(vec![(2 * v, 1.0)]);
        integral.push(vec![(2 * v + 1, 1.0)]);
    }
    integral.extend(lines.iter().map(|&h| coordinate(h, h)));
    let mut is_integer = vec![false; n_real];
    for form in &integral {
        for (x, _) in elimination.resolve(form) {
            is_integer[x as usize] = true;
        }
    }
    Ok((Unknowns::new(elimination.finish(), &is_integer), integral))
}
