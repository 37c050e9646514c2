//! Skins, from glTF and to GLB.

use glam::{DMat4, DVec3};
use serde_json::{Value, json};

use super::super::beside::Alone;
use super::super::format::QuadFormat;
use super::super::model::{NodeTransform, Scene};
use super::super::{glb_container, read_quads, write_model};
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::Influences;
use crate::engine::quad::QuadMesh;

/// A file under construction.
struct File {
    json: Value,
    bin: Vec<u8>,
}

impl File {
    /// Without meshes.
    fn new(nodes: Value) -> Self {
        let json = json!({"asset": {"version": "2.0"}, "nodes": nodes, "meshes": [], "skins": [], "accessors": [],
            "bufferViews": [], "buffers": [{}]});
        Self { json, bin: Vec::new() }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// An accessor over bytes of its own.
    fn accessor(&mut self, component: u32, count: usize, kind: &str, bytes: &[u8]) -> usize {
        let (start, length) = (self.bin.len(), bytes.len());
        self.bin.extend_from_slice(bytes);
        let view = self.push("bufferViews", json!({"buffer": 0, "byteOffset": start, "byteLength": length}));
        let normalised = kind == "VEC4" && component == 5123 && count == 4;
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind,
            "normalized": normalised});
        self.push("accessors", accessor)
    }

    /// The unit square as a mesh of two triangles.
    fn square(&mut self, attributes: Value) -> usize {
        let positions = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let mut attributes = attributes;
        attributes["POSITION"] = self.accessor(5126, 4, "VEC3", &positions).into();
        let indices = self.accessor(5121, 6, "SCALAR", &[0, 1, 2, 0, 2, 3]);
        self.push("meshes", json!({"primitives": [{"attributes": attributes, "indices": indices}]}))
    }

    /// The square with four joints and weights per vertex.
    fn skinned_square(&mut self, joints: &[[u8; 4]; 4], weights: &[[f32; 4]; 4]) -> usize {
        let joints = self.accessor(5121, 4, "VEC4", joints.as_flattened());
        let weights = self.accessor(5126, 4, "VEC4", &floats(weights.as_flattened()));
        self.square(json!({"JOINTS_0": joints, "WEIGHTS_0": weights}))
    }

    fn skin(&mut self, joints: &[usize], inverse_bind: &[DMat4]) -> usize {
        let numbers: Vec<f32> = inverse_bind.iter().flat_map(|m| m.as_mat4().to_cols_array()).collect();
        let matrices = self.accessor(5126, inverse_bind.len(), "MAT4", &floats(&numbers));
        self.push("skins", json!({"joints": joints, "inverseBindMatrices": matrices}))
    }

    fn read(&self) -> Result<Model, ReadError> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = self.bin.len().into();
        super::read(&glb_container::write(&json, self.bin.clone()), &Alone, &ReadLimits::default())
    }

    /// Read with something changed.
    fn patched(&self, pointer: &str, value: Value) -> Result<Model, ReadError> {
        let mut json = self.json.clone();
        *json.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value;
        Self { json, bin: self.bin.clone() }.read()
    }
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

const WEIGHTS: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.25, 0.75, 0.0, 0.0], [0.0, 0.5, 0.0, 0.5], [0.5, 0.5, 0.0, 0.0]];
const JOINTS: [[u8; 4]; 4] = [[0, 0, 0, 0], [0, 1, 0, 0], [7, 1, 9, 0], [1, 1, 0, 0]];

/// A hip and a knee below a node that turns them, all with names.
fn leg() -> Value {
    json!([
        {"mesh": 0, "skin": 0, "name": "trousers", "translation": [100, 0, 0]},
        {"children": [2], "name": "z up", "rotation": [-0.5f32.sqrt(), 0, 0, 0.5f32.sqrt()]},
        {"children": [3], "name": "hip", "translation": [0, 0, 3], "scale": [2, 2, 2]},
        {"name": "knee", "matrix": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0.5, 0, 0, 1]},
    ])
}

/// Where the nodes of a skeleton stand.
fn worlds(scene: &Scene) -> Vec<DMat4> {
    let nodes = &scene.skeleton.nodes;
    let local = |node: usize| match nodes[node].transform {
        NodeTransform::Matrix(m) => DMat4::from_cols_array(&m.map(f64::from)),
        NodeTransform::Parts { translation, rotation, scale } => DMat4::from_scale_rotation_translation(
            scale.map_or(DVec3::ONE, |s| DVec3::from(s.map(f64::from))),
            rotation.map_or(glam::DQuat::IDENTITY, |q| glam::DQuat::from_array(q.map(f64::from))),
            translation.map_or(DVec3::ZERO, |t| DVec3::from(t.map(f64::from))),
        ),
    };
    let world = |mut node: usize| {
        let mut world = local(node);
        while let Some(parent) = nodes[node].parent {
            node = parent as usize;
            world = local(node) * world;
        }
        world
    };
    (0..nodes.len()).map(world).collect()
}

/// Where the joints put vertex v.
fn posed(model: &Model, v: usize) -> DVec3 {
    let (worlds, of) = (worlds(&model.scene), model.soup.skin[v]);
    let by_joint = of.joints().into_iter().zip(of.weights()).map(|(joint, weight)| {
        let joint = model.scene.skeleton.joints[joint as usize];
        let bind = DMat4::from_cols_array(&joint.inverse_bind.map(f64::from));
        f64::from(weight) * (worlds[joint.node as usize] * bind).transform_point3(model.soup.positions[v])
    });
    by_joint.sum()
}

fn corner(v: usize) -> DVec3 {
    [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y][v]
}

/// The leg's worlds as its nodes say.
fn leg_worlds() -> [DMat4; 2] {
    let turn = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let hip = turn * DMat4::from_translation(3.0 * DVec3::Z) * DMat4::from_scale(DVec3::splat(2.0));
    let knee = DMat4::from_translation(0.5 * DVec3::X) * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
    [hip, hip * knee]
}

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

/// Two skins that share the hip, one of them bound elsewhere, and a mesh without skin below the knee.
fn crowd() -> File {
    let mut nodes = leg();
    nodes.as_array_mut().unwrap().extend([
        json!({"mesh": 1, "skin": 1, "name": "shoe"}),
        json!({"mesh": 2, "name": "bell", "translation": [0, 0, 7]}),
        json!({"name": "toe", "translation": [0, 1, 0]}),
    ]);
    nodes[3]["children"] = json!([5, 6]);
    let mut file = File::new(nodes);
    file.skinned_square(&JOINTS, &WEIGHTS);
    file.skinned_square(&[[0, 0, 0, 0], [1, 0, 0, 0], [2, 0, 0, 0], [2, 1, 0, 0]], &WEIGHTS);
    file.square(json!({}));
    let [hip, knee] = leg_worlds();
    file.skin(&[2, 3], &[hip.inverse(), knee.inverse()]);
    let bound = DMat4::from_translation(5.0 * DVec3::Y);
    let toe = knee * DMat4::from_translation(DVec3::Y);
    // The toe comes first, so the place of this skin follows from the hip or the knee. The knee was bent since it was bound.
    file.skin(
        &[6, 2, 3],
        &[toe.inverse() * bound, hip.inverse() * bound, DMat4::from_rotation_y(1.0) * knee.inverse() * bound],
    );
    file
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
        let joint = |j: &super::super::model::Joint| (skeleton.nodes[j.node as usize].name.clone(), j.inverse_bind);
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
