use glam::DVec3;
use serde_json::{Value, json};

use super::super::beside::Alone;
use super::super::glb_container;
use super::*;
use crate::engine::mesh::TriangleSoup;

/// Little-endian bytes of numbers.
macro_rules! bytes {
    ($kind:ty: $($x:expr),* $(,)?) => { [$(($x as $kind).to_le_bytes().as_slice()),*].concat() };
}

/// The square 0, x, x + y, y as float positions: 48 bytes.
fn square() -> Vec<u8> {
    bytes!(f32: 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
}

/// One mesh of one primitive over buffer 0, of which each item of `views` is a view and each of `accessors` an accessor.
fn document(primitive: Value, accessors: Value, views: Value, length: usize) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": length}],
    })
}

/// The square without indices or with what `more` puts behind its positions.
fn square_document(primitive: Value, more: &[u8], index: Option<Value>) -> (Value, Vec<u8>) {
    let bin = [square(), more.to_vec()].concat();
    let mut accessors = vec![json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"})];
    accessors.extend(index);
    let views = json!([
        {"buffer": 0, "byteLength": 48},
        {"buffer": 0, "byteOffset": 48, "byteLength": more.len()},
    ]);
    (document(primitive, json!(accessors), views, bin.len()), bin)
}

fn triangle() -> (Value, Vec<u8>) {
    let index = json!({"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"});
    square_document(json!({"attributes": {"POSITION": 0}, "indices": 1}), &bytes!(u16: 0, 1, 2), Some(index))
}

fn read_glb((json, bin): (Value, Vec<u8>)) -> Result<TriangleSoup, ReadError> {
    read(&glb_container::write(&json, bin), &Alone, &ReadLimits::default()).map(|model| model.soup)
}

fn polygons(soup: &TriangleSoup) -> Vec<Vec<u32>> {
    soup.polygons().map(<[u32]>::to_vec).collect()
}

fn patched(mut sample: (Value, Vec<u8>), pointer: &str, value: Value) -> (Value, Vec<u8>) {
    match sample.0.pointer_mut(pointer) {
        Some(slot) => *slot = value,
        None => {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            sample.0.pointer_mut(parent).unwrap()[key] = value;
        }
    }
    sample
}

#[test]
fn normals_turn_with_their_instance_and_may_be_nonsense() {
    let bin = bytes!(f32: 0, 0, 1, 0, 3, 4, 1, 1, 0, 0, 0, 1);
    let normals = json!({"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"});
    let sample = square_document(json!({"attributes": {"POSITION": 0, "NORMAL": 1}}), &bin, Some(normals));
    assert_eq!(read_glb(sample.clone()).unwrap().normals, [[0.0, 0.0, 1.0], [0.0, 3.0, 4.0], [1.0, 1.0, 0.0]]);
    let stretched = read_glb(patched(sample.clone(), "/nodes/0/scale", json!([2, 1, 4]))).unwrap();
    assert_eq!(stretched.normals, [[0.0, 0.0, 0.25], [0.0, 3.0, 1.0], [0.5, 1.0, 0.0]]);
    for (pointer, value) in [("/accessors/1/count", json!(3)), ("/accessors/1/type", json!("VEC2"))] {
        let soup = read_glb(patched(sample.clone(), pointer, value)).unwrap();
        assert!(soup.n_polygons() == 1 && soup.normals.is_empty());
    }
}

#[test]
fn lists_strips_and_fans_with_indices_of_every_size() {
    let soup = read_glb(triangle()).unwrap();
    assert_eq!(soup.positions, [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]);
    assert_eq!(polygons(&soup), [[0, 1, 2]]);
    for (kind, indices) in
        [(5121, bytes!(u8: 0, 1, 3, 2, 2)), (5123, bytes!(u16: 0, 1, 3, 2, 2)), (5125, bytes!(u32: 0, 1, 3, 2, 2))]
    {
        for (mode, expected, dropped) in [
            (4, vec![vec![0, 1, 3]], 1),
            (5, vec![vec![0, 1, 3], vec![3, 1, 2]], 1),
            (6, vec![vec![0, 1, 3], vec![0, 3, 2]], 1),
        ] {
            let index = json!({"bufferView": 1, "componentType": kind, "count": 5, "type": "SCALAR"});
            let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": mode});
            let soup = read_glb(square_document(primitive, &indices, Some(index))).unwrap();
            assert_eq!((polygons(&soup), soup.dropped_by_reader), (expected, dropped), "{kind} {mode}");
        }
    }
    let unindexed = square_document(json!({"attributes": {"POSITION": 0}, "mode": 5}), &[0; 4], None);
    assert_eq!(polygons(&read_glb(unindexed).unwrap()), [[0, 1, 2], [2, 1, 3]]);
    for mode in 0..4 {
        let lines = square_document(json!({"attributes": {"POSITION": 0}, "mode": mode}), &[0; 4], None);
        assert_eq!(read_glb(lines).unwrap_err(), ReadError::Empty { format: "glTF" });
    }
}

#[test]
fn interleaved_and_sparse_accessors() {
    // Position and normal, 24 bytes apart, from byte 4 of the view.
    let bin = bytes!(f32: 9, 1, 2, 3, 0, 0, 1, 4, 5, 6, 0, 0, 1, 7, 8, 9);
    let interleaved = document(
        json!({"attributes": {"POSITION": 0}}),
        json!([{"bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3"}]),
        json!([{"buffer": 0, "byteLength": 64, "byteStride": 24}]),
        64,
    );
    let soup = read_glb((interleaved, bin)).unwrap();
    assert_eq!(soup.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0), DVec3::new(7.0, 8.0, 9.0)]);

    // Zeros but for elements 1 and 2.
    let bin = [bytes!(u16: 1, 2), bytes!(f32: 1, 0, 0, 0, 1, 0)].concat();
    let sparse = json!({
        "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
            "count": 2,
            "indices": {"bufferView": 0, "componentType": 5123},
            "values": {"bufferView": 1},
        },
    });
    let views = json!([{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 24}]);
    let sample = (document(json!({"attributes": {"POSITION": 0}}), json!([sparse]), views, 28), bin);
    assert_eq!(read_glb(sample.clone()).unwrap().positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    let mut outside = sample.clone();
    outside.1[2] = 3;
    assert!(matches!(read_glb(outside), Err(ReadError::IndexOutOfRange { index: 3, count: 3, .. })));
    // Without a view nothing but the limit stands against a count.
    let huge = patched(sample, "/accessors/0/count", json!(4_000_000_000u64));
    assert!(matches!(read_glb(huge), Err(ReadError::TooLarge { .. })));
}

#[test]
fn transforms_instances_and_mirrors() {
    let mut sample = triangle();
    sample.0["nodes"] = json!([
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, (std::f64::consts::FRAC_1_SQRT_2), (std::f64::consts::FRAC_1_SQRT_2)]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
        {"mesh": 0},
    ]);
    sample.0["scenes"] = json!([{"nodes": [3]}, {"nodes": [0]}]);
    sample.0["scene"] = json!(1);
    let soup = read_glb(sample.clone()).unwrap();
    assert_eq!(polygons(&soup), [[0, 1, 2], [4, 6, 5]]);
    assert!((soup.positions[1] - DVec3::new(10.0, 2.0, 0.0)).length() < 1e-12);
    assert_eq!(soup.positions[6], DVec3::new(9.0, 1.0, 5.0));
    // Without scenes every node is shown, without nodes every mesh.
    sample.0.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    assert_eq!(read_glb(sample.clone()).unwrap().n_polygons(), 3);
    sample.0["nodes"] = json!([]);
    assert_eq!(read_glb(sample).unwrap().n_polygons(), 1);
}

#[test]
fn nodes_must_form_a_forest() {
    for (nodes, words) in [
        (json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}]), "ancestor"),
        (json!([{"mesh": 0, "children": [0]}]), "ancestor"),
        (json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]), "both node 1 and node 2"),
        (json!([{"mesh": 0, "children": [7]}]), "no node 7"),
        (json!([{"mesh": 7}]), "no mesh 7"),
    ] {
        let error = read_glb(patched(triangle(), "/nodes", nodes)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // A chain far deeper than the stack of a thread would carry by recursion.
    let n = 100_000;
    let mut nodes: Vec<Value> = (1..n).map(|i| json!({"children": [i]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(read_glb(patched(triangle(), "/nodes", json!(nodes))).unwrap().n_polygons(), 1);
}

#[test]
fn primitives_share_vertices_and_have_materials_and_colours() {
    let colours = bytes!(u16: 65535, 0, 0, 65535, 0, 65535, 0, 0, 0, 0, 13107, 65535, 0, 0, 0, 65535);
    let index = json!({"bufferView": 1, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC4"});
    let coloured = json!({"attributes": {"POSITION": 0, "COLOR_0": 1}, "mode": 6, "material": 1});
    let mut sample = square_document(coloured.clone(), &colours, Some(index));
    sample.0["materials"] = json!([{}, {"name": "red"}]);
    let second = json!({"attributes": {"POSITION": 0, "COLOR_0": 1}, "material": 0});
    let third = json!({"attributes": {"POSITION": 0}});
    sample.0["meshes"][0]["primitives"] = json!([coloured, second, third]);
    let soup = read_glb(sample).unwrap();
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3], [0, 1, 2], [4, 5, 6]]);
    assert_eq!(soup.materials, [0, 0, 1, 2]);
    assert_eq!(soup.material_names, ["red", "material_0", ""]);
    assert_eq!(soup.colours[..3], [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.2, 1.0]]);
    assert_eq!(soup.colours[4..], [[1.0; 4]; 4]);
}

#[test]
fn quantised_positions() {
    let bin = bytes!(i16: -32768, 0, 0, 0, 32767, 0, 0, 0, 0, 16384, 0, 0);
    let sample = |kind: u32, normalised: bool| {
        let mut json = document(
            json!({"attributes": {"POSITION": 0}}),
            json!([{"bufferView": 0, "componentType": kind, "normalized": normalised, "count": 3, "type": "VEC3"}]),
            json!([{"buffer": 0, "byteLength": 24, "byteStride": 8}]),
            24,
        );
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        json["nodes"][0]["scale"] = json!([2, 2, 2]);
        read_glb((json, bin.clone())).unwrap().positions
    };
    assert_eq!(sample(5122, true), [-2.0 * DVec3::X, 2.0 * DVec3::X, DVec3::Y * 2.0 * (16384.0 / 32767.0)]);
    assert_eq!(sample(5122, false)[2], DVec3::Y * 32768.0);
    assert_eq!(sample(5123, false)[0], DVec3::X * 65536.0);
    assert_eq!(sample(5121, true)[0], DVec3::Y * 2.0 * (128.0 / 255.0));
    assert_eq!(sample(5120, true)[1], DVec3::new(-1.0 / 127.0, 1.0, 0.0) * 2.0);
}

#[test]
fn polygons_encoded_as_triangles() {
    let index = json!({"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"});
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1, "extensions": {"FB_ngon_encoding": {}}});
    let sample = square_document(primitive, &bytes!(u16: 0, 1, 2, 0, 2, 3), Some(index));
    assert_eq!(polygons(&read_glb(sample.clone()).unwrap()), [[0, 1, 2, 3]]);
    let mirrored = patched(sample, "/nodes/0/scale", json!([1, 1, -1]));
    assert_eq!(polygons(&read_glb(mirrored).unwrap()), [[0, 3, 2, 1]]);
}

#[test]
fn data_uris_and_text() {
    let (mut json, bin) = triangle();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bin);
    json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
    let text = serde_json::to_vec_pretty(&json).unwrap();
    assert_eq!(read(&text, &Alone, &ReadLimits::default()).unwrap().soup.n_polygons(), 1);
    let few = ReadLimits { max_bytes_unpacked: 50, ..ReadLimits::default() };
    assert!(matches!(read(&text, &Alone, &few), Err(ReadError::TooLarge { what: "bytes unpacked", .. })));
}

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
fn instances_are_bounded_even_where_they_hold_nothing() {
    let mut lines = triangle();
    let line = json!({"attributes": {"POSITION": 0}, "mode": 1});
    lines.0["meshes"][0]["primitives"] = json!(vec![line; 1100]);
    lines.0["nodes"] = json!(vec![json!({"mesh": 0}); 1000]);
    assert!(matches!(read_glb(lines), Err(ReadError::TooLarge { limit: 1_000_000, .. })));
    // Strips of nothing but degenerate triangles.
    let index = json!({"bufferView": 1, "componentType": 5121, "count": 1002, "type": "SCALAR"});
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": 5});
    let mut strips = square_document(primitive, &[0; 1002], Some(index));
    strips.0["nodes"] = json!(vec![json!({"mesh": 0}); 1000]);
    let limits = ReadLimits { max_polygons: 500_000, ..ReadLimits::default() };
    let bytes = glb_container::write(&strips.0, strips.1);
    assert!(matches!(read(&bytes, &Alone, &limits), Err(ReadError::TooLarge { limit: 500_000, .. })));
}

#[test]
fn faults_have_a_place() {
    let fault = |pointer: &str, value: Value| read_glb(patched(triangle(), pointer, value)).unwrap_err().to_string();
    assert!(fault("/accessors/0/count", json!(5)).contains("/accessors/0: 5 elements of 12 bytes"));
    assert!(fault("/accessors/0/byteOffset", json!(u64::MAX)).contains("/accessors/0"));
    assert!(fault("/accessors/0/count", json!(u64::MAX)).contains("/accessors/0"));
    assert!(fault("/accessors/0/type", json!("SCALAR")).contains("VEC3"));
    assert!(fault("/accessors/0/componentType", json!(1)).contains("/accessors/0: an unknown componentType"));
    assert!(fault("/accessors/0/bufferView", json!(3)).contains("/accessors/0: there is no buffer view 3"));
    assert!(fault("/accessors/1/componentType", json!(5126)).contains("/accessors/1"));
    assert!(fault("/bufferViews/0/byteStride", json!(4)).contains("byteStride of 4"));
    assert!(fault("/bufferViews/0/byteLength", json!(1000)).contains("/bufferViews/0: 1000 bytes from 0 reach past"));
    assert!(fault("/bufferViews/0/byteOffset", json!(u64::MAX)).contains("/bufferViews/0"));
    assert!(fault("/bufferViews/0/buffer", json!(2)).contains("/bufferViews/0: there is no buffer 2"));
    assert!(fault("/buffers/0/byteLength", json!(1000)).contains("/buffers/0: truncated"));
    assert!(fault("/buffers/0/uri", json!("elsewhere.bin")).contains("\"elsewhere.bin\" did not come"));
    assert!(
        fault("/meshes/0/primitives/0/attributes/POSITION", json!(9))
            .contains("/meshes/0/primitives/0: there is no accessor 9")
    );
    assert!(fault("/meshes/0/primitives/0/indices", json!(9)).contains("no accessor 9"));
    assert!(fault("/meshes/0/primitives/0/material", json!(9)).contains("no material 9"));
    assert!(fault("/meshes/0/primitives/0/mode", json!(9)).contains("unknown mode"));
    assert!(fault("/meshes/0/primitives/0/attributes", json!({})).contains("without POSITION"));
    assert!(fault("/scenes", json!([{"nodes": [8]}])).contains("no node 8"));
    assert!(fault("/asset/version", json!("1.0")).contains("/asset/version"));
    assert!(fault("/accessors", json!(3)).contains("JSON: invalid type"));
    assert_eq!(
        read_glb(patched(triangle(), "/extensionsRequired", json!(["KHR_materials_unlit", "X_secret"]))).unwrap_err(),
        ReadError::UnsupportedExtension { name: "X_secret".to_owned() }
    );
    let mut outside = triangle();
    outside.1[50] = 4;
    let place = "/accessors/1".to_owned();
    assert_eq!(
        read_glb(outside).unwrap_err(),
        ReadError::IndexOutOfRange { format: "glTF", place, index: 4, count: 4 }
    );
}

#[test]
fn broken_draco_streams_are_named() {
    let extension = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let broken = patched(triangle(), "/meshes/0/primitives/0/extensions", extension);
    let broken = patched(broken, "/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    assert!(read_glb(broken).unwrap_err().to_string().contains("/meshes/0/primitives/0: the Draco stream"));
}
