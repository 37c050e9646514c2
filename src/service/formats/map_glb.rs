//! Parameterisations as binary glTF.

use serde_json::json;

use super::glb_container;
use super::glb_file::{asset, push_positions};
use super::map_view::MapView;

/// Three vertices per triangle, so that every corner has its own coordinates.
pub(super) fn write(map: &MapView<'_>) -> Vec<u8> {
    if map.faces.is_empty() {
        return glb_container::write(&json!({"asset": asset()}), Vec::new());
    }
    let n = 3 * map.faces.len();
    let mut bin = Vec::with_capacity(20 * n);
    let bounds = push_positions(&mut bin, map.faces.iter().flatten().map(|&v| map.positions[v as usize]));
    for uv in &map.grid.uv {
        // glTF counts v downwards from 1.
        bin.extend_from_slice(&(uv.x as f32).to_le_bytes());
        bin.extend_from_slice(&((1.0 - uv.y) as f32).to_le_bytes());
    }
    let json = json!({
        "asset": asset(),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "parameterisation"}],
        "meshes": [{"name": "parameterisation", "primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "mode": 4,
        }], "extras": {"grid_units_per_model_unit": map.scale}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": n, "type": "VEC3", "min": bounds[0], "max": bounds[1]},
            {"bufferView": 1, "componentType": 5126, "count": n, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 12 * n, "target": 34962},
            {"buffer": 0, "byteOffset": 12 * n, "byteLength": 8 * n, "target": 34962},
        ],
        "buffers": [{"byteLength": bin.len()}],
    });
    glb_container::write(&json, bin)
}

#[cfg(test)]
mod tests {
    use super::super::map::tests::with_square;
    use super::super::read_soup;
    use super::super::soup_builder::ReadLimits;
    use super::*;

    #[test]
    fn every_corner_has_its_own_coordinates() {
        with_square(|map| {
            let bytes = write(map);
            let soup = read_soup(&bytes, None, &ReadLimits::default()).unwrap();
            assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2], [3, 4, 5]]);
            let corners = map.faces.iter().flatten().map(|&v| map.positions[v as usize].as_vec3().as_dvec3());
            assert!(soup.positions.iter().copied().eq(corners));
            let uv = glb_container::open(&bytes).unwrap().bin.unwrap()[72..].as_chunks::<8>().0;
            for (bytes, uv) in uv.iter().zip(&map.grid.uv) {
                let [a, b, c, d, e, f, g, h] = *bytes;
                let (u, v) = (f32::from_le_bytes([a, b, c, d]), f32::from_le_bytes([e, f, g, h]));
                assert_eq!((f64::from(u), 1.0 - f64::from(v)), (uv.x, uv.y));
            }
        });
    }
}
