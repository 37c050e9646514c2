//! The primitives of a mesh: positions, colours, texture coordinates, triangles.

use std::collections::BTreeMap;
use std::rc::Rc;

use glam::{DMat3, DMat4, DVec3};
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
    vertices: BTreeMap<[Option<usize>; 3], Vertices>,
    uv: BTreeMap<usize, Rc<Vec<[f32; 2]>>>,
    normals: BTreeMap<usize, Rc<Vec<[f32; 3]>>>,
}

/// What corners say, per vertex of a primitive.
#[derive(Clone, Copy, Default)]
struct Said<'a> {
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
                let vertices = append_vertices(positions, colours, None, &instance.transform, builder)?;
                let said = Said { uv: decoded.uv.as_deref(), normals: None };
                append_triangles(&decoded.triangles, &vertices, said, instance, false, builder)?;
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

    let order = extension(primitive, "FB_ngon_encoding").and_then(|ngon| ngon.pointer("/extras/vertices")?.as_u64());
    let order = order.and_then(|i| usize::try_from(i).ok());
    let key = [Some(position), colour, order];
    let vertices = match appended.vertices.get(&key) {
        Some(known) => known.clone(),
        None => {
            builder.claim_vertices(positions.count as u64)?;
            let colours = colour.map(|i| read_colours(document, i, positions.count, place)).transpose()?;
            let values = positions.floats()?;
            let order = order.and_then(|i| read_order(document, i, &values));
            let vertices =
                append_vertices(&values, colours.as_deref(), order.as_deref(), &instance.transform, builder)?;
            appended.vertices.insert(key, vertices.clone());
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
    let said = Said { uv: uv.as_deref().map(Vec::as_slice), normals: normals.as_deref().map(Vec::as_slice) };
    append_triangles(&triangles, &vertices, said, instance, is_polygons, builder)
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

/// Texture coordinates with v upwards: glTF counts it downwards from 1.
fn read_uv(document: &Document<'_>, i: usize, count: usize, place: &str) -> Result<Vec<[f32; 2]>, ReadError> {
    let accessor = Accessor::of(document, i, place)?;
    if accessor.count != count || accessor.components != 2 {
        return Err(malformed(accessor.place, "TEXCOORD_0 must be VEC2 with one element per vertex"));
    }
    Ok(accessor.floats()?.chunks_exact(2).map(|c| [c[0] as f32, (1.0 - c[1]) as f32]).collect())
}

/// Normals; none where they are not what they should be: no shape depends on them.
fn read_normals(document: &Document<'_>, i: usize, count: usize, place: &str) -> Option<Vec<[f32; 3]>> {
    let accessor = Accessor::of(document, i, place).ok()?;
    if accessor.count != count || accessor.components != 3 {
        return None;
    }
    let normals = accessor.floats().ok()?;
    Some(normals.as_chunks::<3>().0.iter().map(|n| n.map(|x| x as f32)).collect())
}

/// Which vertex each one is a copy of, as our own writer says it (itself for most); none if that cannot be: copies
/// follow what they are copies of and are at the same place.
fn read_order(document: &Document<'_>, i: usize, positions: &[f64]) -> Option<Vec<u32>> {
    let accessor = Accessor::of(document, i, "/extras").ok()?;
    if 3 * accessor.count != positions.len() || accessor.components != 2 {
        return None;
    }
    let halves = accessor.floats().ok()?;
    let order: Vec<u32> = halves.chunks_exact(2).map(|c| (c[0] + 65536.0 * c[1]) as u32).collect();
    let at = |v: usize| &positions[3 * v..3 * v + 3];
    let is_copy = |(v, &of): (usize, &u32)| {
        let of = of as usize;
        of <= v && order[of] as usize == of && at(of) == at(v)
    };
    order.iter().enumerate().all(is_copy).then_some(order)
}

/// Appends vertices, those only that are no copies.
fn append_vertices(
    positions: &[f64],
    colours: Option<&[[f32; 4]]>,
    order: Option<&[u32]>,
    transform: &DMat4,
    builder: &mut SoupBuilder,
) -> Result<Vertices, ReadError> {
    let first = builder.n_vertices() as u32;
    let is_identity = *transform == DMat4::IDENTITY;
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
        builder.vertex(if is_identity { p } else { transform.transform_point3(p) })?;
        if let Some(&colour) = colours.and_then(|colours| colours.get(i)) {
            builder.colour(colour);
        }
    }
    Ok(if order.is_some() { Vertices::Each(Rc::new(numbers)) } else { Vertices::From(first) })
}

fn append_triangles(
    triangles: &[[u32; 3]],
    vertices: &Vertices,
    said: Said<'_>,
    instance: &Instance,
    is_polygons: bool,
    builder: &mut SoupBuilder,
) -> Result<(), ReadError> {
    // A mirrored instance is inside out.
    let is_mirrored = instance.transform.determinant() < 0.0;
    let directions = DMat3::from_mat4(instance.transform).inverse().transpose();
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
        if let Some(uv) = said.uv {
            builder.uv(corners.iter().map(|&v| uv[v as usize]));
        }
        if let Some(normals) = said.normals {
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
