//! Quads as binary glTF.

use serde_json::{Value, json};

use super::corner_uv::CornerUv;
use super::{glb_container, ngon};
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// Triangles with `FB_ngon_encoding`. Positions are rounded to single precision, the only one glTF knows; vertices stay
/// apart even where they round to the same point.
///
/// Where vertices have copies for the sake of texture coordinates, the primitives' attribute `_VERTEX` holds the low
/// and the high half of the index of the vertex itself; the extras of `FB_ngon_encoding` name its accessor.
pub(super) fn write(mesh: &QuadMesh, attributes: &QuadAttributes) -> Vec<u8> {
    if mesh.quads.is_empty() {
        // glTF knows no empty mesh.
        return glb_container::write(&json!({"asset": asset()}), Vec::new());
    }
    let uv = (!attributes.uv.is_empty()).then(|| CornerUv::of(mesh, &attributes.uv));
    let copies = uv.as_ref().map_or(&[][..], |uv| uv.copies(mesh));
    let vertices = || (0..mesh.positions.len()).chain(copies.iter().map(|&v| v as usize));
    let (n, m) = (mesh.positions.len() + copies.len(), mesh.quads.len());
    let mut file = File { bin: Vec::with_capacity(12 * n + 24 * m), views: Vec::new(), accessors: Vec::new() };

    let bounds = push_positions(&mut file.bin, vertices().map(|v| mesh.positions[v]));
    let view = file.view(0, 34962);
    file.accessor(json!({
        "bufferView": view, "componentType": 5126, "count": n, "type": "VEC3", "min": bounds[0], "max": bounds[1],
    }));
    let groups = push_indices(&mut file, mesh, attributes, uv.as_ref());

    let mut shared = json!({"POSITION": 0});
    if !attributes.colours.is_empty() {
        let colours = vertices().flat_map(|v| attributes.colours[v]);
        shared["COLOR_0"] = file.floats(colours, n, "VEC4").into();
    }
    if let Some(uv) = &uv {
        // glTF counts v downwards from 1.
        shared["TEXCOORD_0"] = file.floats(uv.values.iter().flat_map(|&[u, v]| [u, 1.0 - v]), n, "VEC2").into();
    }
    let mut ngon = json!({});
    if let Some(uv) = uv.as_ref().filter(|_| !copies.is_empty()) {
        let start = file.bin.len();
        file.bin.extend(uv.vertex.iter().flat_map(|v| v.to_le_bytes()));
        let view = file.view(start, 34962);
        let accessor = file.accessor(json!({"bufferView": view, "componentType": 5123, "count": n, "type": "VEC2"}));
        shared["_VERTEX"] = accessor.into();
        ngon = json!({"extras": {"vertices": accessor}});
    }
    let (materials, material_of) = materials(attributes);
    let primitive = |(material, indices): (Option<u32>, usize)| {
        let mut primitive = json!({
            "attributes": shared, "indices": indices, "mode": 4, "extensions": {"FB_ngon_encoding": ngon},
        });
        if let Some(number) = material.and_then(|m| material_of[m as usize]) {
            primitive["material"] = number.into();
        }
        primitive
    };
    let primitives: Vec<Value> = groups.into_iter().map(primitive).collect();
    let mut json = json!({
        "asset": asset(),
        "extensionsUsed": ["FB_ngon_encoding"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "quads"}],
        "meshes": [{"name": "quads", "primitives": primitives}],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.bin.len()}],
    });
    if !materials.is_empty() {
        json["materials"] = materials.into();
    }
    glb_container::write(&json, file.bin)
}

/// A file under construction.
struct File {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// A view of all bytes from `start` on; its number.
    fn view(&mut self, start: usize, target: u32) -> usize {
        let length = self.bin.len() - start;
        self.views.push(match start {
            0 => json!({"buffer": 0, "byteLength": length, "target": target}),
            _ => json!({"buffer": 0, "byteOffset": start, "byteLength": length, "target": target}),
        });
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: impl Iterator<Item = f32>, count: usize, kind: &str) -> usize {
        let start = self.bin.len();
        self.bin.extend(values.flat_map(f32::to_le_bytes));
        let view = self.view(start, 34962);
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}))
    }
}

/// Appends the triangles of all quads, material after material; gives the accessor of each.
fn push_indices(
    file: &mut File,
    mesh: &QuadMesh,
    attributes: &QuadAttributes,
    uv: Option<&CornerUv>,
) -> Vec<(Option<u32>, usize)> {
    let start = file.bin.len();
    let material = |q: usize| attributes.materials.get(q).copied();
    let mut order: Vec<usize> = (0..mesh.quads.len()).collect();
    order.sort_by_key(|&q| material(q));
    // Which quads follow each other decides where they may start.
    let first = if attributes.materials.is_empty() {
        ngon::first_corners(mesh)
    } else {
        let quads = order.iter().map(|&q| mesh.quads[q]).collect();
        ngon::first_corners(&QuadMesh { positions: mesh.positions.clone(), quads })
    };
    for (&q, first) in order.iter().zip(first) {
        let quad = uv.map_or(mesh.quads[q], |uv| uv.corners[q]);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| quad[(first as usize + k) % 4].to_le_bytes());
        for index in [a, b, c, a, c, d] {
            file.bin.extend_from_slice(&index);
        }
    }
    let view = file.view(start, 34963);
    let mut before = 0;
    let groups = order.chunk_by(|&q, &r| material(q) == material(r)).map(|group| {
        let mut accessor = json!({"bufferView": view});
        if before > 0 {
            accessor["byteOffset"] = (24 * before).into();
        }
        before += group.len();
        accessor["componentType"] = 5125.into();
        accessor["count"] = (6 * group.len()).into();
        accessor["type"] = "SCALAR".into();
        (material(group[0]), file.accessor(accessor))
    });
    groups.collect()
}

/// The materials of the file, which are names only, and per material of the quads its number there.
fn materials(attributes: &QuadAttributes) -> (Vec<Value>, Vec<Option<usize>>) {
    let mut written = Vec::new();
    let number = attributes.material_names.iter().map(|name| {
        // Left to itself, glTF takes surfaces for polished metal.
        let matt = json!({"name": name, "pbrMetallicRoughness": {"metallicFactor": 0.0}});
        (!name.is_empty()).then(|| {
            written.push(matt);
            written.len() - 1
        })
    });
    let number = number.collect();
    (written, number)
}

pub(super) fn asset() -> serde_json::Value {
    json!({"version": "2.0", "generator": concat!("Quadrille ", env!("CARGO_PKG_VERSION"))})
}

/// Appends positions in single precision; gives their minimum and maximum.
pub(super) fn push_positions(bin: &mut Vec<u8>, positions: impl Iterator<Item = glam::DVec3>) -> [[f32; 3]; 2] {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for position in positions {
        for (k, x) in position.as_vec3().to_array().into_iter().enumerate() {
            low[k] = low[k].min(x);
            high[k] = high[k].max(x);
            bin.extend_from_slice(&x.to_le_bytes());
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::super::format::QuadFormat;
    use super::super::quads::tests::cube;
    use super::super::{read_quads, write_quads};
    use super::*;

    #[test]
    fn quads_come_back_but_for_their_first_corner() {
        let mesh = cube(4);
        let back =
            read_quads(&write_quads(&mesh, &QuadAttributes::default(), QuadFormat::Glb), QuadFormat::Glb).unwrap();
        let rounded: Vec<_> = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
        assert_eq!(back.positions, rounded);
        // Near 12345 single precision has steps of a thousandth: no two vertices may have become one.
        assert_eq!(back.quads.len(), mesh.quads.len());
        for (a, b) in mesh.quads.iter().zip(&back.quads) {
            let turned = (0..4).map(|k| [0, 1, 2, 3].map(|i| a[(i + k) % 4]));
            assert!(turned.into_iter().any(|turned| turned == *b));
        }
    }

    #[test]
    fn no_quads_are_a_valid_file() {
        let bytes = write(&QuadMesh::default(), &QuadAttributes::default());
        let error = read_quads(&bytes, QuadFormat::Glb).unwrap_err().to_string();
        assert!(error.contains("no polygons"), "{error}");
    }
}
