//! The skeleton of a binary glTF that is written.

use serde_json::Value;
use serde_json::json;

use super::glb_file::File;
use super::model::{NodeTransform, Skeleton, SkeletonNode};
use crate::engine::mesh::Influences;

/// Appends joints and weights of vertices; gives the accessors of `JOINTS_0` and `WEIGHTS_0`.
pub(super) fn push_influences(
    file: &mut File,
    influences: impl Iterator<Item = Influences> + Clone,
    count: usize,
    n_joints: usize,
) -> [usize; 2] {
    let start = file.bin.len();
    let is_small = n_joints <= 256;
    for joint in influences.clone().flat_map(|one| one.joints()) {
        let bytes = joint.to_le_bytes();
        file.bin.extend_from_slice(if is_small { &bytes[..1] } else { &bytes });
    }
    let view = file.view(start, Some(34962));
    let kind = if is_small { 5121 } else { 5123 };
    let joints = file.accessor(json!({"bufferView": view, "componentType": kind, "count": count, "type": "VEC4"}));
    [joints, file.floats(influences.flat_map(|one| one.weights()), count, "VEC4")]
}

/// The nodes of a skeleton and its skin; `first` is the number of the first one among all nodes. Joints without a common
/// ancestor get one: glTF asks for it.
pub(super) fn push_skeleton(file: &mut File, skeleton: &Skeleton, first: usize) -> Written {
    let n = skeleton.nodes.len();
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut roots = Vec::new();
    for (i, node) in skeleton.nodes.iter().enumerate() {
        match node.parent {
            Some(parent) => children[parent as usize].push(first + i),
            None => roots.push(first + i),
        }
    }
    let mut nodes: Vec<Value> =
        skeleton.nodes.iter().zip(&children).map(|(node, below)| written(node, below)).collect();
    if roots.len() > 1 {
        nodes.push(json!({"name": "skeleton", "children": roots}));
        roots = vec![first + n];
    }
    let start = file.bin.len();
    file.bin.extend(skeleton.joints.iter().flat_map(|joint| joint.inverse_bind).flat_map(f32::to_le_bytes));
    let view = file.view(start, None);
    let count = skeleton.joints.len();
    let matrices = file.accessor(json!({"bufferView": view, "componentType": 5126, "count": count, "type": "MAT4"}));
    let joints: Vec<usize> = skeleton.joints.iter().map(|joint| first + joint.node as usize).collect();
    Written { nodes, roots, skin: json!({"joints": joints, "inverseBindMatrices": matrices}) }
}

/// A skeleton as JSON.
pub(super) struct Written {
    pub(super) nodes: Vec<Value>,
    /// Numbers of the nodes that the scene has to show.
    pub(super) roots: Vec<usize>,
    pub(super) skin: Value,
}

fn written(node: &SkeletonNode, children: &[usize]) -> Value {
    let mut json = json!({});
    if let Some(name) = &node.name {
        json["name"] = name.as_str().into();
    }
    match node.transform {
        NodeTransform::Matrix(matrix) => json["matrix"] = matrix.as_slice().into(),
        NodeTransform::Parts { translation, rotation, scale } => {
            let parts: [(&str, Option<Value>); 3] = [
                ("translation", translation.map(|v| v.as_slice().into())),
                ("rotation", rotation.map(|v| v.as_slice().into())),
                ("scale", scale.map(|v| v.as_slice().into())),
            ];
            for (name, value) in parts {
                if let Some(value) = value {
                    json[name] = value;
                }
            }
        }
    }
    if !children.is_empty() {
        json["children"] = children.into();
    }
    json
}
