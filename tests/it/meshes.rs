//! Small files, good and bad.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use quadrille::engine::mesh::TriangleSoup;
use quadrille::engine::mesh::shapes::sample;
use serde_json::{Value, json};

/// One of the built-in surfaces.
pub(crate) fn surface(name: &str, triangles: usize) -> TriangleSoup {
    sample(name, triangles, 0.0, 0).expect("a built-in surface")
}

pub(crate) fn obj(soup: &TriangleSoup) -> Vec<u8> {
    let mut text = String::new();
    for p in &soup.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for polygon in soup.polygons() {
        let corners: Vec<_> = polygon.iter().map(|v| (v + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text.into_bytes()
}

/// A glTF document of one indexed triangle mesh, and its buffer.
pub(crate) fn gltf(soup: &TriangleSoup) -> (Value, Vec<u8>) {
    let mut buffer: Vec<u8> =
        soup.positions.iter().flat_map(|p| p.as_vec3().to_array()).flat_map(f32::to_le_bytes).collect();
    let positions = buffer.len();
    buffer.extend(soup.indices.iter().flat_map(|v| v.to_le_bytes()));
    let low = soup
        .positions
        .iter()
        .fold([f32::MAX; 3], |m, p| [m[0].min(p.x as f32), m[1].min(p.y as f32), m[2].min(p.z as f32)]);
    let high = soup
        .positions
        .iter()
        .fold([f32::MIN; 3], |m, p| [m[0].max(p.x as f32), m[1].max(p.y as f32), m[2].max(p.z as f32)]);
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": soup.positions.len(), "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5125, "count": soup.indices.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": buffer.len() - positions},
        ],
        "buffers": [{"byteLength": buffer.len()}],
    });
    (document, buffer)
}

pub(crate) fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = buffer.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let word = |n: usize| u32::try_from(n).expect("small").to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    [
        b"glTF".as_slice(),
        &word(2),
        &word(length),
        &word(json.len()),
        b"JSON",
        &json,
        &word(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

/// The same as one JSON file.
pub(crate) fn embedded(mut document: Value, buffer: &[u8]) -> Vec<u8> {
    document["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{}", STANDARD.encode(buffer)).into();
    document.to_string().into_bytes()
}

pub(crate) fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    use std::io::Write;
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).expect("a name");
        archive.write_all(bytes).expect("bytes");
    }
    archive.finish().expect("an archive").into_inner()
}
