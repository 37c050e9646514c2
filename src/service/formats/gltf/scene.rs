//! Where the meshes stand: the node hierarchy.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::{Node, Root};

use super::super::error::ReadError;
use super::document::missing;
use super::malformed;

/// A mesh at a place of the scene.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    pub(super) mesh: usize,
    pub(super) transform: DMat4,
}

/// The instances of the default scene, in order of the nodes; of all nodes if there is no scene; each mesh once if there
/// are no nodes.
///
/// # Errors
/// If the nodes are no forest: a node with two parents, or a cycle.
pub(super) fn instances(root: &Root) -> Result<Vec<Instance>, ReadError> {
    if root.nodes.is_empty() {
        let identity = DMat4::IDENTITY;
        return Ok((0..root.meshes.len()).map(|mesh| Instance { mesh, transform: identity }).collect());
    }
    let n = root.nodes.len();
    let mut parent = vec![None; n];
    for (i, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|child| child.value()) {
            let slot = parent.get_mut(child).ok_or_else(|| missing(&format!("/nodes/{i}"), "node", child))?;
            if let Some(other) = slot.replace(i) {
                return Err(malformed(format!("/nodes/{child}"), format!("a child of both node {other} and node {i}")));
            }
        }
    }
    // Walking down from the nodes without a parent meets every node unless there is a cycle.
    let mut world = vec![None; n];
    let mut stack: Vec<usize> = (0..n).filter(|&i| parent[i].is_none()).collect();
    while let Some(i) = stack.pop() {
        let above = parent[i].and_then(|p: usize| world[p]).unwrap_or(DMat4::IDENTITY);
        world[i] = Some(above * local(&root.nodes[i]));
        stack.extend(root.nodes[i].children.iter().flatten().map(|child| child.value()));
    }
    if let Some(i) = world.iter().position(Option::is_none) {
        return Err(malformed(format!("/nodes/{i}"), "the node is its own ancestor or descends from one that is"));
    }
    let shown = shown(root)?;
    let nodes = root.nodes.iter().zip(world).zip(shown).filter(|(_, shown)| *shown);
    let instances =
        nodes.filter_map(|((node, world), _)| Some(Instance { mesh: node.mesh?.value(), transform: world? }));
    Ok(instances.collect())
}

/// Which nodes belong to the default scene.
fn shown(root: &Root) -> Result<Vec<bool>, ReadError> {
    let number = root.scene.map_or(0, |scene| scene.value());
    let Some(scene) = root.scenes.get(number) else {
        return if root.scenes.is_empty() {
            Ok(vec![true; root.nodes.len()])
        } else {
            Err(missing("/scene", "scene", number))
        };
    };
    let mut shown = vec![false; root.nodes.len()];
    let mut stack: Vec<usize> = scene.nodes.iter().map(|node| node.value()).collect();
    while let Some(i) = stack.pop() {
        let slot = shown.get_mut(i).ok_or_else(|| missing(&format!("/scenes/{number}"), "node", i))?;
        if !std::mem::replace(slot, true) {
            stack.extend(root.nodes[i].children.iter().flatten().map(|child| child.value()));
        }
    }
    Ok(shown)
}

fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, otherwise: DVec3| v.map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)));
    // Not every writer says a unit quaternion with all digits.
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
