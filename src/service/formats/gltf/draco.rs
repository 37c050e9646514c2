//! Primitives compressed with `KHR_draco_mesh_compression`.

use std::rc::Rc;

use draco_core::{DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute};
use serde_json::Value;

use super::super::error::ReadError;
use super::super::soup_builder::SoupBuilder;
use super::document::Document;
use super::draco_cache::Decoded;
use super::fault::{GLTF, malformed};

/// Decompresses a primitive.
///
/// # Errors
/// With the place of the primitive.
pub(super) fn decode(
    document: &Document<'_>,
    extension: &Value,
    place: &str,
    builder: &SoupBuilder,
) -> Result<Rc<Decoded>, ReadError> {
    if let Some(known) = document.draco.borrow().get(place) {
        builder.claim_vertices(known.positions.len() as u64 / 3)?;
        builder.claim_triangles(known.triangles.len() as u64)?;
        return Ok(Rc::clone(known));
    }
    let decoded = Rc::new(decompress(document, extension, place, builder)?);
    document.draco.borrow_mut().insert(place.to_owned(), Rc::clone(&decoded));
    Ok(decoded)
}

fn decompress(
    document: &Document<'_>,
    extension: &Value,
    place: &str,
    builder: &SoupBuilder,
) -> Result<Decoded, ReadError> {
    let view = extension.get("bufferView").and_then(Value::as_u64).and_then(|view| usize::try_from(view).ok());
    let view = view.ok_or_else(|| malformed(place, "compressed without bufferView"))?;
    let encoded = document.view(view, place)?.bytes;
    let limits = DecodeLimits::default()
        .with_max_points(document.limits.max_vertices)
        .with_max_faces(document.limits.max_polygons)
        .with_max_decoded_bytes(document.limits.max_bytes_unpacked);
    let mut mesh = Mesh::new();
    let mut buffer = DecoderBuffer::new(encoded).with_limits(limits);
    MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|error| match error.kind() {
        ErrorKind::LimitExceeded => ReadError::TooLarge {
            what: "triangles or vertices at least",
            claimed: document.limits.max_polygons.saturating_add(1),
            limit: document.limits.max_polygons,
        },
        _ => malformed(place, format!("the Draco stream is broken: {error}")),
    })?;
    let n = mesh.num_points();
    // As much as is copied out of the decoder below.
    document.unpack(n as u64 * 24 + mesh.num_faces() as u64 * 12)?;
    builder.claim_vertices(n as u64)?;
    builder.claim_triangles(mesh.num_faces() as u64)?;
    let attribute = |name: &str| -> Option<&PointAttribute> {
        let id = extension.get("attributes")?.get(name)?.as_u64()?;
        mesh.attribute_by_unique_id(u32::try_from(id).ok()?)
    };
    let position = attribute("POSITION").filter(|position| position.num_components() == 3);
    let position = position.ok_or_else(|| malformed(place, "the Draco stream holds no POSITION"))?;
    let full = |attribute: &PointAttribute| match attribute.data_type().byte_length() {
        1 => 255.0,
        2 => 65535.0,
        _ => 1.0,
    };
    let uv = attribute("TEXCOORD_0").filter(|uv| uv.num_components() == 2).map(|uv| {
        let (values, full) = (uv.read_f32s(n, 2), full(uv));
        values.chunks_exact(2).map(|c| [c[0] / full, 1.0 - c[1] / full]).collect()
    });
    let colours = attribute("COLOR_0").filter(|colour| colour.num_components() >= 3).map(|colour| {
        let full = full(colour);
        let has_alpha = colour.num_components() == 4;
        let values = colour.read_f32s(n, 4);
        values
            .chunks_exact(4)
            .map(|c| [c[0] / full, c[1] / full, c[2] / full, if has_alpha { c[3] / full } else { 1.0 }])
            .collect()
    });
    let fours = |name: &str| {
        let attribute = attribute(name).filter(|attribute| attribute.num_components() == 4)?;
        Some(attribute.read_f32s(n, 4).into_iter().map(f64::from).collect::<Vec<_>>())
    };
    let influences = fours("JOINTS_0").zip(fours("WEIGHTS_0"));
    let triangles: Vec<[u32; 3]> = mesh.faces().iter().map(|face| face.map(|point| point.0)).collect();
    if let Some(&index) = triangles.iter().flatten().find(|&&v| v as usize >= n) {
        let (place, index, count) = (place.to_owned(), i64::from(index), n as u64);
        return Err(ReadError::IndexOutOfRange { format: GLTF, place, index, count });
    }
    let positions = position.read_f32s(n, 3).into_iter().map(f64::from).collect();
    Ok(Decoded { positions, colours, uv, influences, triangles })
}
