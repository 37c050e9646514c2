//! Where the meshes stand: the node hierarchy.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::{Node, Root};

use super::super::error::ReadError;
use super::super::model::{NodeTransform, SkeletonNode, cut};
use super::fault::{malformed, missing};
use super::matrix::by_columns;

/// A mesh at a place of the scene.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    /// None in files without nodes.
    pub(super) node: Option<usize>,
    pub(super) mesh: usize,
    pub(super) skin: Option<usize>,
    /// Where the node stands; what has a skin is put elsewhere, see [`super::bind`].
    pub(super) transform: DMat4,
}

/// The nodes of a file.
#[derive(Debug, Default)]
pub(super) struct Graph {
    /// The meshes to show, in order of the nodes.
    pub(super) instances: Vec<Instance>,
    /// Per node, from its coordinates to those of the scene.
    pub(super) world: Vec<DMat4>,
    /// The node above each node.
    pub(super) parent: Vec<Option<usize>>,
}

/// The nodes and the instances of the default scene; of all nodes if there is no scene; each mesh once if there are no
/// nodes.
///
/// # Errors
/// If the nodes are no forest: a node with two parents, or a cycle.
pub(super) fn graph(root: &Root) -> Result<Graph, ReadError> {
    if root.nodes.is_empty() {
        let instance = |mesh| Instance { node: None, mesh, skin: None, transform: DMat4::IDENTITY };
        return Ok(Graph { instances: (0..root.meshes.len()).map(instance).collect(), ..Graph::default() });
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
    let world: Vec<DMat4> = world.into_iter().flatten().collect();
    let shown = shown(root)?;
    let nodes = root.nodes.iter().enumerate().filter(|(i, _)| shown[*i]);
    let instances = nodes.filter_map(|(i, node)| {
        let skin = node.skin.map(|skin| skin.value());
        Some(Instance { node: Some(i), mesh: node.mesh?.value(), skin, transform: world[i] })
    });
    Ok(Graph { instances: instances.collect(), world, parent })
}

/// A node as it is carried to other files. Numbers that single precision does not hold mean no transform.
pub(super) fn skeleton_node(node: &Node, parent: Option<u32>) -> SkeletonNode {
    let finite = |v: [f32; 3]| v.iter().all(|x| x.is_finite()).then_some(v);
    let transform = match node.matrix {
        Some(matrix) => {
            let matrix = by_columns(&DMat4::from_cols_array(&matrix.map(f64::from)));
            matrix.map_or(NodeTransform::default(), NodeTransform::Matrix)
        }
        None => NodeTransform::Parts {
            translation: node.translation.and_then(finite),
            rotation: node.rotation.map(|q| unit(q.0).as_quat().to_array()).filter(|q| q.iter().all(|x| x.is_finite())),
            scale: node.scale.and_then(finite),
        },
    };
    SkeletonNode { name: node.name.as_deref().map(cut), parent, transform }
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
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| unit(q.0));
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}

/// Not every writer says a unit quaternion with all digits.
fn unit(q: [f32; 4]) -> DQuat {
    let rotation = DQuat::from_array(q.map(f64::from));
    if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY }
}
