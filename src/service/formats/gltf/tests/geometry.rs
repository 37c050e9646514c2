//! Positions, normals, colours and polygons of primitives, where their nodes put them.

use super::*;

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
fn polygons_encoded_as_triangles() {
    let index = json!({"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"});
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1, "extensions": {"FB_ngon_encoding": {}}});
    let sample = square_document(primitive, &bytes!(u16: 0, 1, 2, 0, 2, 3), Some(index));
    assert_eq!(polygons(&read_glb(sample.clone()).unwrap()), [[0, 1, 2, 3]]);
    let mirrored = patched(sample, "/nodes/0/scale", json!([1, 1, -1]));
    assert_eq!(polygons(&read_glb(mirrored).unwrap()), [[0, 3, 2, 1]]);
}
