//! The primitives of a mesh: positions, colours, triangles.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::super::error::ReadError;
use super::super::ngon;
use super::super::soup_builder::{SoupBuilder, UNSAID};
use super::accessor::Accessor;
use super::document::{Document, missing};
use super::malformed;
use super::scene::Instance;

/// What an instance has appended so far: primitives that share their positions share the vertices, too.
#[derive(Default)]
struct Appended {
    first_vertex: BTreeMap<(usize, Option<usize>), u32>,
}

/// Appends an instance of a mesh.
pub(super) fn append_mesh(
    document: &Document<'_>,
    instance: &Instance,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    let mesh = document.root.meshes.get(instance.mesh).ok_or_else(|| missing("/nodes", "mesh", instance.mesh))?;
    builder.claim_primitives(mesh.primitives.len() as u64)?;
    let mut appended = Appended::default();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let place = format!("/meshes/{}/primitives/{p}", instance.mesh);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(malformed(place, "an unknown mode"));
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            continue;
        }
        name_material(document, primitive, &place, builder)?;
        if let Some(extension) = extension(primitive, "KHR_draco_mesh_compression") {
            #[cfg(feature = "draco")]
            {
                let decoded = super::draco::decode(document, extension, &place, builder)?;
                let (positions, colours) = (&decoded.positions, decoded.colours.as_deref());
                let first = append_vertices(positions, colours, &instance.transform, builder)?;
                append_triangles(&decoded.triangles, first, instance, false, builder)?;
                continue;
            }
            #[cfg(not(feature = "draco"))]
            if !has_fallback(document, primitive) {
                let _ = extension;
                return Err(ReadError::UnsupportedExtension { name: "KHR_draco_mesh_compression".to_owned() });
            }
        }
        append(document, primitive, mode, &place, instance, &mut appended, builder)?;
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
        builder.material(&material.name.clone().unwrap_or_else(|| format!("material_{index}")));
    } else if !materials.is_empty() {
        builder.material("");
    }
    Ok(())
}

fn extension<'a>(primitive: &'a Primitive, name: &str) -> Option<&'a serde_json::Value> {
    primitive.extensions.as_ref()?.others.get(name)
}

/// Whether a primitive that is compressed comes uncompressed as well.
#[cfg(not(feature = "draco"))]
fn has_fallback(document: &Document<'_>, primitive: &Primitive) -> bool {
    let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).map(|accessor| accessor.value());
    let accessors = position.into_iter().chain(primitive.indices.map(|accessor| accessor.value()));
    let mut views = accessors.map(|i| document.root.accessors.get(i).and_then(|accessor| accessor.buffer_view));
    views.all(|view| view.is_some())
}

fn append(
    document: &Document<'_>,
    primitive: &Primitive,
    mode: Mode,
    place: &str,
    instance: &Instance,
    appended: &mut Appended,
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

    let first = match appended.first_vertex.get(&(position, colour)) {
        Some(&first) => first,
        None => {
            builder.claim_vertices(positions.count as u64)?;
            let colours = colour.map(|i| read_colours(document, i, positions.count, place)).transpose()?;
            let first = append_vertices(&positions.floats()?, colours.as_deref(), &instance.transform, builder)?;
            appended.first_vertex.insert((position, colour), first);
            first
        }
    };
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
    append_triangles(&triangles, first, instance, is_polygons, builder)
}

fn read_colours(document: &Document<'_>, i: usize, count: usize, place: &str) -> Result<Vec<[f32; 4]>, ReadError> {
    let accessor = Accessor::of(document, i, place)?;
    if accessor.count != count || accessor.components < 3 {
        return Err(malformed(accessor.place, "COLOR_0 must be VEC3 or VEC4 with one element per vertex"));
    }
    let colours = accessor.floats()?;
    let colours = colours.chunks_exact(accessor.components);
    Ok(colours.map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, c.get(3).map_or(UNSAID, |&a| a as f32)]).collect())
}

/// Appends vertices; gives the index of the first.
fn append_vertices(
    positions: &[f64],
    colours: Option<&[[f32; 4]]>,
    transform: &DMat4,
    builder: &mut SoupBuilder,
) -> Result<u32, ReadError> {
    let first = builder.n_vertices() as u32;
    let is_identity = *transform == DMat4::IDENTITY;
    for (i, p) in positions.chunks_exact(3).enumerate() {
        let p = DVec3::from_slice(p);
        builder.vertex(if is_identity { p } else { transform.transform_point3(p) })?;
        if let Some(&colour) = colours.and_then(|colours| colours.get(i)) {
            builder.colour(colour);
        }
    }
    Ok(first)
}

fn append_triangles(
    triangles: &[[u32; 3]],
    first: u32,
    instance: &Instance,
    is_polygons: bool,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    // A mirrored instance is inside out.
    let is_mirrored = instance.transform.determinant() < 0.0;
    let mut corners = Vec::new();
    let polygon = |polygon: &[u32]| {
        corners.clear();
        corners.extend(polygon.iter().map(|v| v + first));
        if is_mirrored {
            corners[1..].reverse();
        }
        builder.polygon(&corners)
    };
    let mut triangles = triangles.iter().copied();
    if is_polygons {
        ngon::join(triangles, polygon)
    } else {
        let mut polygon = polygon;
        triangles.try_for_each(|triangle| polygon(&triangle))
    }
}
