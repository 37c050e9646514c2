//! Compressed views and primitives.

use super::*;

#[test]
fn meshopt_compression() {
    let positions: Vec<[f32; 3]> = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let vertices = ::meshopt::encode_vertex_buffer(&positions).unwrap();
    let triangles = ::meshopt::encode_index_buffer(&[0, 1, 2, 0, 2, 3], 4).unwrap();
    let sequence = ::meshopt::encode_index_sequence(&[0, 1, 2, 0, 2, 3], 4).unwrap();
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        for (mode, stride, indices) in [
            ("TRIANGLES", 4, &triangles),
            ("TRIANGLES", 2, &triangles),
            ("INDICES", 4, &sequence),
            ("INDICES", 2, &sequence),
        ] {
            let bin = [vertices.as_slice(), indices].concat();
            let view = |offset: usize, length: usize, extension: Value| {
                let mut view = json!({"buffer": 1, "byteLength": 0, "extensions": {name: extension}});
                view["extensions"][name]["buffer"] = json!(0);
                view["extensions"][name]["byteOffset"] = json!(offset);
                view["extensions"][name]["byteLength"] = json!(length);
                view
            };
            let mut json = document(
                json!({"attributes": {"POSITION": 0}, "indices": 1}),
                json!([
                    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                    {"bufferView": 1, "componentType": if stride == 4 { 5125 } else { 5123 }, "count": 6, "type": "SCALAR"},
                ]),
                json!([
                    view(0, vertices.len(), json!({"mode": "ATTRIBUTES", "count": 4, "byteStride": 12})),
                    view(vertices.len(), indices.len(), json!({"mode": mode, "count": 6, "byteStride": stride})),
                ]),
                bin.len(),
            );
            json["buffers"]
                .as_array_mut()
                .unwrap()
                .push(json!({"byteLength": 60, "extensions": {name: {"fallback": true}}}));
            json["extensionsRequired"] = json!([name]);
            let sample = (json, bin);
            let soup = read_glb(sample.clone()).unwrap();
            assert_eq!(
                soup.positions,
                positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect::<Vec<_>>()
            );
            // The codec may rotate triangles.
            let sorted: Vec<Vec<u32>> = polygons(&soup)
                .into_iter()
                .map(|mut p| {
                    p.sort_unstable();
                    p
                })
                .collect();
            assert_eq!(sorted, [[0, 1, 2], [0, 2, 3]]);
            let pointer = format!("/bufferViews/0/extensions/{name}");
            let fault = |key: &str, value: Value| {
                read_glb(patched(sample.clone(), &format!("{pointer}/{key}"), value)).unwrap_err().to_string()
            };
            assert!(fault("count", json!(4_000_000_000u64)).contains("4000000000 vertices"));
            assert!(fault("count", json!(5)).contains("/bufferViews/0: the compressed bytes are broken"));
            assert!(fault("byteStride", json!(6)).contains("byteStride 6"));
            assert!(fault("byteLength", json!(100_000)).contains("reach past buffer 0"));
            assert!(fault("mode", json!("OTHER")).contains("OTHER"));
            assert!(fault("filter", json!("OCTAHEDRAL")).contains("OCTAHEDRAL"));
            assert!(fault("buffer", json!(9)).contains("no buffer 9"));
        }
    }
}

#[test]
fn meshopt_filters_and_wide_elements() {
    // 36 words per element: positions with much behind them.
    let wide: Vec<[u32; 36]> =
        (0..3u32).map(|i| std::array::from_fn(|k| if k as u32 == i { 1f32.to_bits() } else { 0 })).collect();
    let encode = |words: &[u32], n: usize| match words.len() / n {
        3 => ::meshopt::encode_vertex_buffer(words.as_chunks::<3>().0).unwrap(),
        _ => {
            #[derive(Clone, Copy)]
            #[expect(dead_code, reason = "read by the encoder as bytes")]
            struct Wide([u32; 36]);
            let wide: Vec<Wide> = words.as_chunks::<36>().0.iter().map(|&words| Wide(words)).collect();
            ::meshopt::encode_vertex_buffer(&wide).unwrap()
        }
    };
    let read = |bin: Vec<u8>, stride: usize, filter: &str| {
        let extension = json!({"buffer": 0, "byteLength": bin.len(), "byteStride": stride, "count": 3,
            "mode": "ATTRIBUTES", "filter": filter});
        let json = document(
            json!({"attributes": {"POSITION": 0}}),
            json!([{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]),
            json!([{"buffer": 0, "byteLength": 3 * stride, "byteStride": stride,
                "extensions": {"EXT_meshopt_compression": extension}}]),
            bin.len(),
        );
        read_glb((json, bin)).unwrap().positions
    };
    assert_eq!(read(encode(wide.as_flattened(), 3), 144, "NONE"), [DVec3::X, DVec3::Y, DVec3::Z]);
    // 3 · 2^-1: mantissa 3, exponent −1 in the highest byte.
    let exponential: Vec<u32> = (0..9).map(|i| if i % 4 == 0 { 3 | 0xFF00_0000 } else { 0 }).collect();
    assert_eq!(read(encode(&exponential, 3), 12, "EXPONENTIAL"), [DVec3::X * 1.5, DVec3::Y * 1.5, DVec3::Z * 1.5]);
}

#[test]
fn broken_draco_streams_are_named() {
    let extension = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let broken = patched(triangle(), "/meshes/0/primitives/0/extensions", extension);
    let broken = patched(broken, "/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    assert!(read_glb(broken).unwrap_err().to_string().contains("/meshes/0/primitives/0: the Draco stream"));
}
