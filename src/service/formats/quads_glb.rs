//! Quads as binary glTF.

use serde_json::json;

use super::{glb_container, ngon};
use crate::engine::quad::QuadMesh;

/// Triangles with `FB_ngon_encoding`. Positions are rounded to single precision, the only one glTF knows; vertices stay
/// apart even where they round to the same point.
pub(super) fn write(mesh: &QuadMesh) -> Vec<u8> {
    if mesh.quads.is_empty() {
        // glTF knows no empty mesh.
        return glb_container::write(&json!({"asset": asset()}), Vec::new());
    }
    let (n, m) = (mesh.positions.len(), mesh.quads.len());
    let mut bin = Vec::with_capacity(12 * n + 24 * m);
    let bounds = push_positions(&mut bin, mesh.positions.iter().copied());
    for (quad, first) in mesh.quads.iter().zip(ngon::first_corners(mesh)) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| quad[(first as usize + k) % 4].to_le_bytes());
        for index in [a, b, c, a, c, d] {
            bin.extend_from_slice(&index);
        }
    }
    let json = json!({
        "asset": asset(),
        "extensionsUsed": ["FB_ngon_encoding"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "quads"}],
        "meshes": [{"name": "quads", "primitives": [{
            "attributes": {"POSITION": 0}, "indices": 1, "mode": 4, "extensions": {"FB_ngon_encoding": {}},
        }]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": n, "type": "VEC3", "min": bounds[0], "max": bounds[1]},
            {"bufferView": 1, "componentType": 5125, "count": 6 * m, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 12 * n, "target": 34962},
            {"buffer": 0, "byteOffset": 12 * n, "byteLength": 24 * m, "target": 34963},
        ],
        "buffers": [{"byteLength": bin.len()}],
    });
    glb_container::write(&json, bin)
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
        let back = read_quads(&write_quads(&mesh, QuadFormat::Glb), QuadFormat::Glb).unwrap();
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
        let bytes = write(&QuadMesh::default());
        let error = read_quads(&bytes, QuadFormat::Glb).unwrap_err().to_string();
        assert!(error.contains("no polygons"), "{error}");
    }
}
