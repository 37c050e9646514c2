//! The primitives of a mesh: positions, colours, texture coordinates, triangles.

use std::collections::BTreeMap;
use std::rc::Rc;

use glam::{DMat3, DMat4, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::super::error::ReadError;
use super::super::ngon;
use super::super::soup_builder::SoupBuilder;
use super::accessor::Accessor;
use super::bind::{Binder, Place};
use super::document::{DRACO, Document};
use super::fault::{malformed, missing};
use super::scene::Instance;
use super::values::{read_colours, read_normals, read_order, read_uv};
use super::{draco, influences};
use crate::engine::mesh::Influences;

/// Vertices that were appended so far. Primitives that share their positions share the vertices, too, also those of
/// several nodes that are at the same place, as in the files that are written here.
#[derive(Default)]
pub(super) struct Shared(BTreeMap<Key, Vertices>);

/// What makes vertices the same.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    /// Of positions, colours, the order of copies, joints and weights.
    accessors: Vec<Option<usize>>,
    /// Bits of the numbers of the transform.
    transform: [u64; 16],
    /// The skin, and the joint of those that have none.
    binding: (Option<usize>, Option<u16>),
}

/// What an instance has appended so far.
struct Appended<'a> {
    shared: &'a mut Shared,
    uv: BTreeMap<usize, Rc<Vec<[f32; 2]>>>,
    normals: BTreeMap<usize, Rc<Vec<[f32; 3]>>>,
}

/// Attributes of corners, per vertex of a primitive.
#[derive(Clone, Copy, Default)]
struct CornerAttributes<'a> {
    uv: Option<&'a [[f32; 2]]>,
    normals: Option<&'a [[f32; 3]]>,
}

/// Vertices of a primitive in the soup.
#[derive(Clone)]
enum Vertices {
    /// In their order from this one on.
    From(u32),
    /// One by one: some are copies of others.
    Each(Rc<Vec<u32>>),
}

impl Vertices {
    fn number(&self, v: u32) -> u32 {
        match self {
            Self::From(first) => first + v,
            Self::Each(numbers) => numbers[v as usize],
        }
    }
}

/// Appends an instance of a mesh.
pub(super) fn append_mesh(
    document: &Document<'_>,
    instance: &Instance,
    binder: &mut Binder<'_>,
    shared: &mut Shared,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    let mesh = document.root.meshes.get(instance.mesh).ok_or_else(|| missing("/nodes", "mesh", instance.mesh))?;
    builder.claim_primitives(mesh.primitives.len() as u64)?;
    let mut appended = Appended { shared, uv: BTreeMap::new(), normals: BTreeMap::new() };
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let at = format!("/meshes/{}/primitives/{p}", instance.mesh);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(malformed(at, "an unknown mode"));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            continue;
        }
        name_material(document, primitive, &at, builder)?;
        let place = binder.place(instance, primitive)?;
        if let Some(extension) = extension(primitive, DRACO) {
            let decoded = draco::decode(document, extension, &at, builder)?;
            let (positions, colours) = (&decoded.positions, decoded.colours.as_deref());
            let count = positions.len() / 3;
            let influences = decoded
                .influences
                .as_ref()
                .filter(|_| place.skin.is_some())
                .map(|set| influences::of_vertices(std::slice::from_ref(set), count, &place.joints, &at));
            let influences = influences.transpose()?;
            let attributes = VertexAttributes { colours, influences: influences.as_deref(), order: None };
            let vertices = append_vertices(positions, attributes, &place, builder)?;
            let attributes = CornerAttributes { uv: decoded.uv.as_deref(), normals: None };
            append_triangles(&decoded.triangles, &vertices, attributes, &place.transform, false, builder)?;
            continue;
        }
        append(document, primitive, mode, &at, &place, &mut appended, builder)?;
    }
    Ok(())
}

fn name_material(
    document: &Document<'_>,
    primitive: &Primitive,
    place: &str,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    let materials = &document.root.materials;
    if let Some(index) = primitive.material.map(|material| material.value()) {
        let material = materials.get(index).ok_or_else(|| missing(place, "material", index))?;
        let name = material.name.clone().filter(|name| !name.is_empty());
        builder.material_of_file(index, &name.unwrap_or_else(|| format!("material_{index}")));
    } else if !materials.is_empty() {
        builder.material("");
    }
    Ok(())
}

fn extension<'a>(primitive: &'a Primitive, name: &str) -> Option<&'a serde_json::Value> {
    primitive.extensions.as_ref()?.others.get(name)
}

fn append(
    document: &Document<'_>,
    primitive: &Primitive,
    mode: Mode,
    place: &str,
    at: &Place,
    appended: &mut Appended<'_>,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|accessor| accessor.value());
    let Some(position) = attribute(Semantic::Positions) else {
        return Err(malformed(place, "triangles without POSITION"));
    };
    let colour = attribute(Semantic::Colors(0));
    let positions = Accessor::of(document, position, place)?;
    if positions.components != 3 {
        return Err(malformed(positions.place, "POSITION must be VEC3"));
    }
    let indices = primitive.indices.map(|i| Accessor::of(document, i.value(), place)).transpose()?;
    let n_corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
    let is_list = matches!(mode, Mode::Triangles);
    builder.claim_triangles(if is_list { n_corners / 3 } else { n_corners.saturating_sub(2) } as u64)?;

    let order = extension(primitive, "FB_ngon_encoding").and_then(|ngon| ngon.pointer("/extras/vertices")?.as_u64());
    let order = order.and_then(|i| usize::try_from(i).ok());
    let sets = if at.skin.is_some() { influences::sets(primitive) } else { Vec::new() };
    let accessors = [Some(position), colour, order].into_iter().chain(sets.iter().flatten().copied().map(Some));
    let transform = at.transform.to_cols_array().map(f64::to_bits);
    let key = Key { accessors: accessors.collect(), transform, binding: (at.skin, at.joint) };
    let vertices = match appended.shared.0.get(&key) {
        Some(known) => known.clone(),
        None => {
            builder.claim_vertices(positions.count as u64)?;
            let colours = colour.map(|i| read_colours(document, i, positions.count, place)).transpose()?;
            let values = positions.floats()?;
            let order = order.and_then(|i| read_order(document, i, &values));
            let influences =
                at.skin.map(|_| influences::read(document, &sets, positions.count, &at.joints, place)).transpose()?;
            let attributes = VertexAttributes {
                colours: colours.as_deref(),
                influences: influences.as_deref(),
                order: order.as_deref(),
            };
            let vertices = append_vertices(&values, attributes, at, builder)?;
            appended.shared.0.insert(key, vertices.clone());
            vertices
        }
    };
    let uv = match attribute(Semantic::TexCoords(0)) {
        Some(i) => Some(match appended.uv.get(&i).filter(|known| known.len() == positions.count) {
            Some(known) => Rc::clone(known),
            None => {
                let read = Rc::new(read_uv(document, i, positions.count, place)?);
                appended.uv.insert(i, Rc::clone(&read));
                read
            }
        }),
        None => None,
    };
    let normals = attribute(Semantic::Normals).and_then(|i| match appended.normals.get(&i) {
        Some(known) => Some(Rc::clone(known)).filter(|known| known.len() == positions.count),
        None => {
            let read = Rc::new(read_normals(document, i, positions.count, place)?);
            appended.normals.insert(i, Rc::clone(&read));
            Some(read)
        }
    });
    let indices = indices.map(|indices| indices.indices(positions.count)).transpose()?;
    let corner = |i: usize| indices.as_ref().map_or(i as u32, |indices| indices[i]);
    let mut triangles = Vec::new();
    if is_list {
        triangles.extend((0..n_corners / 3).map(|t| [corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)]));
        builder.dropped(usize::from(!n_corners.is_multiple_of(3)));
    } else {
        for t in 0..n_corners.saturating_sub(2) {
            let [a, b, c] = match (mode, t % 2) {
                (Mode::TriangleFan, _) => [corner(0), corner(t + 1), corner(t + 2)],
                (_, 0) => [corner(t), corner(t + 1), corner(t + 2)],
                _ => [corner(t + 1), corner(t), corner(t + 2)],
            };
            // Strips are stitched together by triangles without area.
            if a == b || b == c || c == a { builder.dropped(1) } else { triangles.push([a, b, c]) }
        }
    }
    let is_polygons = is_list && extension(primitive, "FB_ngon_encoding").is_some();
    let attributes =
        CornerAttributes { uv: uv.as_deref().map(Vec::as_slice), normals: normals.as_deref().map(Vec::as_slice) };
    append_triangles(&triangles, &vertices, attributes, &at.transform, is_polygons, builder)
}

/// What vertices say besides where they are, each list of one per vertex.
#[derive(Clone, Copy)]
struct VertexAttributes<'a> {
    colours: Option<&'a [[f32; 4]]>,
    influences: Option<&'a [Influences]>,
    order: Option<&'a [u32]>,
}

/// Appends vertices, those only that are no copies.
fn append_vertices(
    positions: &[f64],
    attributes: VertexAttributes<'_>,
    place: &Place,
    builder: &mut SoupBuilder,
) -> Result<Vertices, ReadError> {
    let first = builder.n_vertices() as u32;
    let VertexAttributes { colours, influences, order } = attributes;
    let is_identity = place.transform == DMat4::IDENTITY;
    let hangs_on = place.joint.map(Influences::one);
    let mut numbers: Vec<u32> = Vec::new();
    for (i, p) in positions.chunks_exact(3).enumerate() {
        if let Some(order) = order {
            let of = order[i] as usize;
            if of != i {
                numbers.push(numbers[of]);
                continue;
            }
            numbers.push(builder.n_vertices() as u32);
        }
        let p = DVec3::from_slice(p);
        builder.vertex(if is_identity { p } else { place.transform.transform_point3(p) })?;
        if let Some(&colour) = colours.and_then(|colours| colours.get(i)) {
            builder.colour(colour);
        }
        if let Some(influences) = influences.and_then(|of| of.get(i).copied()).or(hangs_on) {
            builder.influences(influences);
        }
    }
    Ok(if order.is_some() { Vertices::Each(Rc::new(numbers)) } else { Vertices::From(first) })
}

fn append_triangles(
    triangles: &[[u32; 3]],
    vertices: &Vertices,
    attributes: CornerAttributes<'_>,
    transform: &DMat4,
    is_polygons: bool,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    // A mirrored instance is inside out.
    let is_mirrored = transform.determinant() < 0.0;
    let directions = DMat3::from_mat4(*transform).inverse().transpose();
    let turned = |n: [f32; 3]| (directions * DVec3::from(n.map(f64::from))).as_vec3().to_array();
    let (mut corners, mut numbers) = (Vec::new(), Vec::new());
    let polygon = |polygon: &[u32]| {
        corners.clear();
        corners.extend_from_slice(polygon);
        if is_mirrored {
            corners[1..].reverse();
        }
        numbers.clear();
        numbers.extend(corners.iter().map(|&v| vertices.number(v)));
        builder.polygon(&numbers)?;
        if let Some(uv) = attributes.uv {
            builder.uv(corners.iter().map(|&v| uv[v as usize]));
        }
        if let Some(normals) = attributes.normals {
            builder.normals(corners.iter().map(|&v| turned(normals[v as usize])));
        }
        Ok(())
    };
    let mut triangles = triangles.iter().copied();
    if is_polygons {
        ngon::join(triangles, polygon)
    } else {
        let mut polygon = polygon;
        triangles.try_for_each(|triangle| polygon(&triangle))
    }
}
