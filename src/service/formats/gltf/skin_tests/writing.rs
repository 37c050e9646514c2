//! Skins are written to GLB and read again.

use super::*;

#[test]
fn skins_names_and_positions_survive_being_written() {
    let mut file = crowd();
    for m in 0..3 {
        let ngon = json!({"FB_ngon_encoding": {}});
        file.json["meshes"][m]["primitives"][0]["extensions"] = ngon;
        file.json["meshes"][m]["name"] = format!("mesh {m}").into();
    }
    file.json["extensionsUsed"] = json!(["FB_ngon_encoding"]);
    let mut model = file.read().unwrap();
    for p in &mut model.soup.positions {
        *p = p.as_vec3().as_dvec3();
    }
    let quads = model.soup.polygons().map(|p| p.try_into().unwrap()).collect();
    let mesh = QuadMesh { positions: model.soup.positions.clone(), quads };
    let attributes = QuadAttributes {
        skin: model.soup.skin.clone(),
        objects: model.soup.objects.clone(),
        // A seam makes copies of vertices.
        uv: vec![[[0.0; 2]; 4], [[0.25; 2]; 4], [[0.5; 2]; 4]],
        ..QuadAttributes::default()
    };
    let bytes = write_model(&mesh, &attributes, &model.scene, QuadFormat::Glb);
    let again = super::read(&bytes, &Alone, &ReadLimits::default()).unwrap();
    assert_eq!(again.soup.positions, mesh.positions);
    assert_eq!(again.soup.skin, model.soup.skin);
    assert_eq!(again.soup.objects, model.soup.objects);
    assert_eq!(again.scene.objects, model.scene.objects);
    let joints = |model: &Model| {
        let skeleton = &model.scene.skeleton;
        let joint = |j: &Joint| (skeleton.nodes[j.node as usize].name.clone(), j.inverse_bind);
        skeleton.joints.iter().map(joint).collect::<Vec<_>>()
    };
    assert_eq!(joints(&again), joints(&model));
    (0..12).for_each(|v| assert!(posed(&again, v).distance(posed(&model, v)) < 1e-9));
    // Once more, it is the same file.
    let twice = write_model(&mesh, &attributes, &again.scene, QuadFormat::Glb);
    assert_eq!(super::read(&twice, &Alone, &ReadLimits::default()).unwrap(), again);
    // Without a skeleton weights mean nothing, without weights a skeleton.
    for (attributes, scene) in [(&attributes, Scene::default()), (&QuadAttributes::default(), model.scene.clone())] {
        let bytes = write_model(&mesh, attributes, &scene, QuadFormat::Glb);
        assert!(super::read(&bytes, &Alone, &ReadLimits::default()).unwrap().soup.skin.is_empty());
        assert_eq!(read_quads(&bytes, QuadFormat::Glb).unwrap().positions, mesh.positions);
    }
}

#[test]
fn skins_without_a_common_root_get_one_and_animations_are_told() {
    let nodes = json!([{"mesh": 0, "skin": 0}, {"name": "a"}, {"name": "b", "translation": [1, 0, 0]}]);
    let mut file = File::new(nodes);
    file.skinned_square(&JOINTS, &WEIGHTS);
    file.skin(&[1, 2], &[DMat4::IDENTITY, DMat4::from_translation(-DVec3::X)]);
    file.json["animations"] = json!([{"channels": [], "samplers": []}]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{}]);
    let model = file.read().unwrap();
    assert_eq!(model.warnings.len(), 2, "{:?}", model.warnings);
    assert_eq!(model.warnings.len(), 2);
    assert!(model.warnings.iter().all(|w| matches!(w.kind, WarningKind::AttributesLost { .. })));
    let mesh = QuadMesh { positions: model.soup.positions.clone(), quads: vec![[0, 1, 2, 3]] };
    let attributes = QuadAttributes { skin: model.soup.skin.clone(), ..QuadAttributes::default() };
    let bytes = write_model(&mesh, &attributes, &model.scene, QuadFormat::Glb);
    let again = super::read(&bytes, &Alone, &ReadLimits::default()).unwrap();
    let names: Vec<_> = again.scene.skeleton.nodes.iter().map(|n| n.name.as_deref().unwrap()).collect();
    assert_eq!(names, ["a", "b", "skeleton"]);
    assert_eq!(again.soup.skin, model.soup.skin);
    let twice = write_model(&mesh, &attributes, &again.scene, QuadFormat::Glb);
    assert_eq!(super::read(&twice, &Alone, &ReadLimits::default()).unwrap(), again);
}
