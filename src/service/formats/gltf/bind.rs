//! What moves a mesh: its skin, or in files with skins else its own node.
//!
//! A skin moves a vertex p by the weighted mean of `world(joint) · inverse bind matrix(joint) · p`; where the node of the
//! mesh stands means nothing then. Meshes are read as they were bound, not as the joints hold them now: only so are the
//! weights what they were made for. That leaves open where the bound mesh stands in the scene, beside meshes without a
//! skin and other skins. It is put where its first joint holds it, by `P = world(joint 0) · inverse bind matrix(joint 0)`,
//! which is no transform at all in most files; skins that share a joint with an earlier one keep their place relative to
//! that. Positions become P · p and inverse bind matrices B · P⁻¹, so that every pose of the joints moves the
//! mesh to where it would have moved it before.
//!
//! All skins of a file become one. A joint that two of them hold is one joint if both were bound alike; else the second is a
//! node of its own just below. Meshes without a skin follow their node: it is a joint with weight 1.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::DMat4;
use gltf::json::mesh::Primitive;

use super::super::error::ReadError;
use super::super::model::{Joint, Skeleton, cut};
use super::super::soup_builder::within;
use super::accessor::Accessor;
use super::document::Document;
use super::fault::missing;
use super::influences;
use super::matrix::{alike, by_columns, is_usable, placement};
use super::scene::{Graph, Instance, skeleton_node};

/// As many as 16 bits can number.
const MOST_JOINTS: u64 = 1 << 16;

/// Where the vertices of a primitive are put and what moves them.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) transform: DMat4,
    /// The skin, if the primitive has joints and weights and its node a skin.
    pub(super) skin: Option<usize>,
    /// Numbers of the skin's joints; empty without one.
    pub(super) joints: Rc<[u16]>,
    /// What vertices without weights hang on; none in files without skins.
    pub(super) joint: Option<u16>,
}

/// Collects the joints of a file.
pub(super) struct Binder<'a> {
    document: &'a Document<'a>,
    graph: &'a Graph,
    /// Whether any mesh has a skin and weights.
    is_skinned: bool,
    skins: BTreeMap<usize, Place>,
    joints: Vec<BoundJoint>,
    /// The first joint of each node.
    first: BTreeMap<usize, usize>,
    /// Joints by node and the bits of their matrices.
    known: BTreeMap<(usize, [u32; 16]), u16>,
}

/// A joint.
struct BoundJoint {
    node: usize,
    /// The inverse bind matrix of the file, and where that puts the mesh.
    declared: DMat4,
    transform: DMat4,
    inverse_bind: [f32; 16],
}

impl<'a> Binder<'a> {
    pub(super) fn new(document: &'a Document<'a>, graph: &'a Graph) -> Self {
        let has_weights = |mesh: &gltf::json::Mesh| mesh.primitives.iter().any(|p| !influences::sets(p).is_empty());
        let has_weights: Vec<bool> = document.root.meshes.iter().map(has_weights).collect();
        let is_skinned = |i: &Instance| {
            let skin = i.skin.and_then(|skin| document.root.skins.get(skin));
            skin.is_some_and(|skin| !skin.joints.is_empty()) && has_weights.get(i.mesh) == Some(&true)
        };
        let is_skinned = graph.instances.iter().any(is_skinned);
        let (skins, first, known) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Self { document, graph, is_skinned, skins, joints: Vec::new(), first, known }
    }

    /// Where a primitive of an instance is put.
    ///
    /// # Errors
    /// If a skin is not what it should be, or there are too many joints.
    pub(super) fn place(&mut self, instance: &Instance, primitive: &Primitive) -> Result<Place, ReadError> {
        if let Some(skin) = instance.skin.filter(|_| !influences::sets(primitive).is_empty()) {
            if let Some(known) = self.skins.get(&skin) {
                return Ok(known.clone());
            }
            let from = instance.node.map_or("/nodes".to_owned(), |node| format!("/nodes/{node}"));
            if let Some(place) = self.bind(skin, &from)? {
                self.skins.insert(skin, place.clone());
                return Ok(place);
            }
        }
        let joint = match instance.node.filter(|_| self.is_skinned) {
            Some(node) => Some(self.joint(node, DMat4::IDENTITY, instance.transform)?),
            None => None,
        };
        Ok(Place { transform: instance.transform, skin: None, joints: Rc::new([]), joint })
    }

    /// Takes the joints of a skin; `None` if it has none.
    fn bind(&mut self, skin: usize, from: &str) -> Result<Option<Place>, ReadError> {
        let json = self.document.root.skins.get(skin).ok_or_else(|| missing(from, "skin", skin))?;
        let place = format!("/skins/{skin}");
        let nodes: Vec<usize> = json.joints.iter().map(|node| node.value()).collect();
        if let Some(&node) = nodes.iter().find(|&&node| node >= self.graph.world.len()) {
            return Err(missing(&place, "node", node));
        }
        let Some(&root) = nodes.first() else { return Ok(None) };
        within("joints", nodes.len() as u64, MOST_JOINTS)?;
        let declared = match json.inverse_bind_matrices {
            Some(i) => Accessor::of(self.document, i.value(), &place)?.matrices(nodes.len())?,
            None => vec![DMat4::IDENTITY.to_cols_array(); nodes.len()],
        };
        let declared: Vec<DMat4> = declared.into_iter().map(sane).collect();
        let shared = nodes
            .iter()
            .zip(&declared)
            .find_map(|(node, inverse)| Some((&self.joints[*self.first.get(node)?], inverse)));
        let transform = match shared {
            Some((joint, inverse)) if alike(&joint.declared, inverse) => joint.transform,
            Some((joint, inverse)) => placement(&(joint.transform * joint.declared.inverse()), inverse),
            None => placement(&self.graph.world[root], &declared[0]),
        };
        let joints = nodes.iter().zip(&declared).map(|(&node, inverse)| self.joint(node, *inverse, transform));
        let joints = joints.collect::<Result<Rc<[u16]>, _>>()?;
        Ok(Some(Place { transform, skin: Some(skin), joint: Some(joints[0]), joints }))
    }

    /// The number of a joint for vertices that were bound by the matrix `declared` and are put somewhere by `transform`.
    fn joint(&mut self, node: usize, declared: DMat4, transform: DMat4) -> Result<u16, ReadError> {
        let bind = match transform == DMat4::IDENTITY || !is_usable(&transform) {
            true => declared,
            false => declared * transform.inverse(),
        };
        let inverse_bind = by_columns(&bind).unwrap_or_else(|| DMat4::IDENTITY.as_mat4().to_cols_array());
        let key = (node, inverse_bind.map(f32::to_bits));
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let like = self.first.get(&node).filter(|&&j| alike(&matrix(self.joints[j].inverse_bind), &bind));
        let number = match like {
            Some(&number) => number,
            None => {
                within("joints", self.joints.len() as u64 + 1, MOST_JOINTS)?;
                self.joints.push(BoundJoint { node, declared, transform, inverse_bind });
                self.joints.len() - 1
            }
        } as u16;
        self.first.entry(node).or_insert(usize::from(number));
        self.known.insert(key, number);
        Ok(number)
    }

    /// The joints with all nodes above them.
    pub(super) fn finish(self) -> Skeleton {
        let mut kept = BTreeSet::new();
        for joint in &self.joints {
            let mut at = Some(joint.node);
            while let Some(node) = at.filter(|&node| kept.insert(node)) {
                at = self.graph.parent[node];
            }
        }
        let number: BTreeMap<usize, u32> = (0..).zip(&kept).map(|(i, &node)| (node, i)).collect();
        let json = &self.document.root.nodes;
        let mut skeleton = Skeleton::default();
        for &node in &kept {
            let parent = self.graph.parent[node].map(|parent| number[&parent]);
            skeleton.nodes.push(skeleton_node(&json[node], parent));
        }
        for (j, joint) in self.joints.iter().enumerate() {
            let mut node = number[&joint.node];
            if self.first.get(&joint.node) != Some(&j) {
                let mut below = skeleton_node(&gltf::json::Node::default(), Some(node));
                below.name = json[joint.node].name.as_deref().map(cut);
                node = skeleton.nodes.len() as u32;
                skeleton.nodes.push(below);
            }
            skeleton.joints.push(Joint { node, inverse_bind: joint.inverse_bind });
        }
        skeleton
    }
}

/// A matrix of a file; one that holds what is no number is none.
fn sane(columns: [f64; 16]) -> DMat4 {
    by_columns(&DMat4::from_cols_array(&columns)).map_or(DMat4::IDENTITY, matrix)
}

fn matrix(columns: [f32; 16]) -> DMat4 {
    DMat4::from_cols_array(&columns.map(f64::from))
}
