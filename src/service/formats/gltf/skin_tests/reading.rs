//! Skins are read: joints, weights, where they put their meshes, and what is wrong with them.

use super::*;

#[test]
fn joints_weights_and_the_skeleton_of_every_type() {
    let binds = leg_worlds().map(|world| world.inverse());
    let expected = [
        Influences::one(0),
        Influences::of([(0, 0.25), (1, 0.75)]).unwrap(),
        Influences::of([(0, 0.5), (1, 0.5)]).unwrap(),
        Influences::one(1),
    ];
    let wide: Vec<u8> = JOINTS.as_flattened().iter().flat_map(|&j| u16::from(j).to_le_bytes()).collect();
    let bytes: Vec<u8> = WEIGHTS.as_flattened().iter().map(|w| (w * 255.0).round() as u8).collect();
    let shorts: Vec<u8> =
        WEIGHTS.as_flattened().iter().flat_map(|w| ((w * 65535.0).round() as u16).to_le_bytes()).collect();
    for (wide_joints, kind, weights) in
        [(false, 5126, floats(WEIGHTS.as_flattened())), (true, 5121, bytes), (true, 5123, shorts)]
    {
        let mut file = File::new(leg());
        let joints = if wide_joints {
            file.accessor(5123, 4, "VEC4", &wide)
        } else {
            file.accessor(5121, 4, "VEC4", JOINTS.as_flattened())
        };
        file.json["accessors"][joints]["normalized"] = false.into();
        let weights = file.accessor(kind, 4, "VEC4", &weights);
        file.json["accessors"][weights]["normalized"] = (kind != 5126).into();
        file.square(json!({"JOINTS_0": joints, "WEIGHTS_0": weights}));
        file.skin(&[2, 3], &binds);
        let model = file.read().unwrap();
        // Where the node of the mesh stands means nothing.
        assert_eq!(model.soup.positions, [0, 1, 2, 3].map(corner));
        for (made, expected) in model.soup.skin.iter().zip(&expected) {
            assert!(made.difference(expected) < 0.003, "{kind}: {made:?} instead of {expected:?}");
        }
        let Scene { objects, skeleton, .. } = &model.scene;
        assert_eq!(objects[0].node, "trousers");
        assert!(model.soup.objects.is_empty() && model.warnings.is_empty());
        let nodes: Vec<_> = skeleton.nodes.iter().map(|n| (n.name.as_deref().unwrap(), n.parent)).collect();
        assert_eq!(nodes, [("z up", None), ("hip", Some(0)), ("knee", Some(1))]);
        assert_eq!(skeleton.joints.iter().map(|j| j.node).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(skeleton.joints[1].inverse_bind, binds[1].as_mat4().to_cols_array());
        assert!(matches!(skeleton.nodes[1].transform, NodeTransform::Parts { scale: Some([2.0, 2.0, 2.0]), .. }));
        assert!(matches!(skeleton.nodes[2].transform, NodeTransform::Matrix(_)));
        (0..4).for_each(|v| assert!(posed(&model, v).distance(corner(v)) < 1e-5));
    }
}

#[test]
fn what_was_bound_elsewhere_is_put_where_its_joints_hold_it() {
    // Bound before anything was turned, scaled and moved, and the knee is bent since.
    let binds = [DMat4::from_translation(-DVec3::Z), DMat4::from_translation(DVec3::new(-0.3, 0.0, -1.0))];
    let mut file = File::new(leg());
    file.skinned_square(&JOINTS, &WEIGHTS);
    file.skin(&[2, 3], &binds);
    let model = file.read().unwrap();
    let [hip, knee] = leg_worlds();
    let place = hip * binds[0];
    for v in 0..4 {
        assert!(model.soup.positions[v].distance(place.transform_point3(corner(v))) < 1e-5, "{v}");
        let knee_weight = model.soup.skin[v].weight_of(1);
        let by_hip = (1.0 - knee_weight) * (hip * binds[0]).transform_point3(corner(v));
        let expected = by_hip + knee_weight * (knee * binds[1]).transform_point3(corner(v));
        assert!(posed(&model, v).distance(expected) < 1e-5, "{v}");
    }
    assert!(model.soup.positions[1].distance(corner(1)) > 1.0);
}

#[test]
fn weights_that_mean_nothing_are_treated_sanely() {
    let weights = [[f32::NAN, -1.0, 0.0, f32::INFINITY], [0.0; 4], [3.0, 1.0, f32::NAN, -5.0], [0.0, 0.0, 1e-30, 0.0]];
    // The joint of a weight that is none may be anything.
    let joints = [[0, 1, 0, 1], [1, 200, 0, 0], [1, 0, 99, 99], [0, 0, 1, 0]];
    let mut file = File::new(leg());
    file.skinned_square(&joints, &weights);
    file.skin(&[2, 3], &leg_worlds().map(|world| world.inverse()));
    let skin = file.read().unwrap().soup.skin;
    assert_eq!(skin[..2], [Influences::one(0); 2]);
    assert_eq!(skin[2], Influences::of([(1, 0.75), (0, 0.25)]).unwrap());
    assert_eq!(skin[3], Influences::one(1));
}

#[test]
fn faults_of_skins_have_a_place() {
    let mut file = File::new(leg());
    file.skinned_square(&JOINTS, &WEIGHTS);
    file.skin(&[2, 3], &leg_worlds().map(|world| world.inverse()));
    file.json["skins"][0]["name"] = "leg".into();
    for (pointer, value, words) in [
        ("/skins/0/joints", json!([2, 9]), "/skins/0: there is no node 9"),
        ("/skins/0/joints", json!([2]), "joint 1, there are 1 joints"),
        ("/skins/0/joints", json!([2, 3, 1]), "not the 3 matrices"),
        ("/skins/0/inverseBindMatrices", json!(77), "/skins/0: there is no accessor 77"),
        ("/skins/0/inverseBindMatrices", json!(0), "not the 2 matrices"),
        ("/nodes/0/skin", json!(3), "/nodes/0: there is no skin 3"),
        ("/accessors/0/count", json!(3), "JOINTS must be"),
        ("/accessors/0/count", json!(4_000_000_000u64), "reach past"),
        ("/accessors/0/type", json!("VEC3"), "JOINTS must be"),
        ("/accessors/0/componentType", json!(5120), "JOINTS must be"),
        ("/accessors/1/type", json!("VEC2"), "WEIGHTS must be"),
        ("/accessors/1/componentType", json!(5125), "WEIGHTS must be"),
    ] {
        let error = file.patched(pointer, value).unwrap_err().to_string();
        assert!(error.contains(words), "{pointer}: {error}");
    }
    let mut many = File::new(json!(vec![json!({}); 70_000]));
    many.json["nodes"][0] = json!({"mesh": 0, "skin": 0});
    many.skinned_square(&JOINTS, &WEIGHTS);
    many.push("skins", json!({"joints": (1..70_000).collect::<Vec<_>>()}));
    assert!(matches!(many.read(), Err(ReadError::TooLarge { what: "joints", .. })));
    // A skin without joints is none, joints without a skin move nothing.
    let plain = |pointer, value| file.patched(pointer, value).unwrap();
    for model in
        [plain("/skins/0/joints", json!([])), plain("/nodes/0", json!({"mesh": 0, "translation": [100, 0, 0]}))]
    {
        assert!(model.soup.skin.is_empty() && model.scene.skeleton.joints.is_empty());
        assert_eq!(model.soup.positions[0], 100.0 * DVec3::X);
    }
    // A matrix that cannot be inverted places nothing.
    let mut flat = File::new(leg());
    flat.skinned_square(&JOINTS, &WEIGHTS);
    flat.skin(&[2, 3], &[DMat4::ZERO, DMat4::NAN]);
    assert_eq!(flat.read().unwrap().soup.positions, [0, 1, 2, 3].map(corner));
}

#[test]
fn skins_become_one_and_what_has_none_follows_its_node() {
    let file = crowd();
    let model = file.read().unwrap();
    let Model { soup, scene, .. } = &model;
    assert_eq!((soup.positions.len(), soup.skin.len()), (12, 12));
    assert_eq!(scene.objects.iter().map(|o| o.node.as_str()).collect::<Vec<_>>(), ["trousers", "shoe", "bell"]);
    assert_eq!(soup.objects, [0, 0, 1, 1, 2, 2]);
    // Those of the first skin, what the second adds, and the node of the bell.
    let skeleton = &scene.skeleton;
    assert_eq!(skeleton.joints.len(), 5);
    let name = |j: usize| skeleton.nodes[skeleton.joints[j].node as usize].name.as_deref().unwrap();
    assert_eq!([0, 1, 2, 3, 4].map(name), ["hip", "knee", "toe", "knee", "bell"]);
    let second = &skeleton.nodes[skeleton.joints[3].node as usize];
    assert_eq!(second.parent, Some(skeleton.joints[1].node));
    for v in 0..4 {
        assert!(soup.positions[4 + v].distance(corner(v) + 5.0 * DVec3::Y) < 1e-5, "the skins share their space");
        assert!(posed(&model, v).distance(soup.positions[v]) < 1e-5);
        assert!(posed(&model, 8 + v).distance(soup.positions[8 + v]) < 1e-5);
        assert_eq!(soup.skin[8 + v], Influences::one(4));
    }
    // The toe is the first joint of the second skin.
    assert_eq!(soup.skin[4], Influences::one(2));
    assert_eq!(soup.skin[5], Influences::of([(0, 0.25), (2, 0.75)]).unwrap());
}
