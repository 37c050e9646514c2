//! Broken documents and documents that are too large.

use super::*;

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
