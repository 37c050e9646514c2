//! What a file says: polygons for the engine, and what they refer to by number.

use super::looks::Looks;
use crate::engine::mesh::TriangleSoup;
use crate::engine::run::Warning;

/// Characters of a name that are kept.
const LONGEST_NAME: usize = 256;

/// A file that was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Its polygons.
    pub soup: TriangleSoup,
    /// What the polygons' objects, joints and materials are.
    pub scene: Scene,
    /// What the file holds and quads cannot carry.
    pub warnings: Vec<Warning>,
}

/// What the numbers of objects, joints and materials stand for. The engine knows the numbers only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Names of the objects. A single one has all polygons, and the soup says nothing of it.
    pub objects: Vec<ObjectName>,
    /// What the joints are.
    pub skeleton: Skeleton,
    /// What the materials look like.
    pub looks: Looks,
}

impl Scene {
    /// The names to which the numbers of quads refer; quads without numbers are all of the only object, if it is that.
    pub(super) fn names(&self, of_quads: &[u32]) -> &[ObjectName] {
        if of_quads.is_empty() && self.objects.len() != 1 { &[] } else { &self.objects }
    }
}

/// What an object is called: a node of a glTF and its mesh, or an `o` of an OBJ. Empty names are none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectName {
    /// Name of the node.
    pub node: String,
    /// Name of its mesh.
    pub mesh: String,
}

impl ObjectName {
    pub(super) fn new(node: &str, mesh: &str) -> Self {
        Self { node: cut(node), mesh: cut(mesh) }
    }
}

/// A name as it is carried. Objects may share a name of any length, so that copies could outgrow the file by far.
pub(super) fn cut(name: &str) -> String {
    name.chars().take(LONGEST_NAME).collect()
}

/// Joints and the hierarchy in which they hang.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// The joints' nodes and all nodes above them: a forest.
    pub nodes: Vec<SkeletonNode>,
    /// The joints in the order of their numbers; empty if there is no skeleton. No two have the same node.
    pub joints: Vec<Joint>,
}

/// A joint: a node that moves vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Index of its node in [`Skeleton::nodes`].
    pub node: u32,
    /// From the coordinates of the vertices in the pose in which they were bound to those of the joint; by columns, in
    /// model units, finite, the last row 0 0 0 1.
    pub inverse_bind: [f32; 16],
}

/// A node of a skeleton.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkeletonNode {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Index of the node above it; none for roots.
    pub parent: Option<u32>,
    /// Where it stands.
    pub transform: NodeTransform,
}

/// From the coordinates of a node to those of its parent, as the file says it; all numbers are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeTransform {
    /// By columns, the last row 0 0 0 1.
    Matrix([f32; 16]),
    /// First scaled, then rotated, then moved.
    Parts {
        /// In model units.
        translation: Option<[f32; 3]>,
        /// A unit quaternion x y z w.
        rotation: Option<[f32; 4]>,
        /// Factors.
        scale: Option<[f32; 3]>,
    },
}

impl Default for NodeTransform {
    /// None.
    fn default() -> Self {
        Self::Parts { translation: None, rotation: None, scale: None }
    }
}

impl From<TriangleSoup> for Model {
    fn from(soup: TriangleSoup) -> Self {
        Self { soup, ..Self::default() }
    }
}
