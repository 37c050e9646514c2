//! Skins, from glTF and to GLB: a leg of two joints with a square on them, and where the joints put it.

use glam::{DMat4, DVec3};
use serde_json::{Value, json};

use super::super::beside::Alone;
use super::super::format::QuadFormat;
use super::super::model::{Joint, NodeTransform, Scene};
use super::super::{glb_container, read_quads, write_model};
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::Influences;
use crate::engine::quad::QuadMesh;

mod reading;
mod writing;

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
