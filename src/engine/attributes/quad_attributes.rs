//! The attributes of quads, and which of them are wanted.

use crate::engine::mesh::Influences;

/// Which attributes of the input are carried to the quads, where the input has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preserve {
    /// Material of each face.
    pub materials: bool,
    /// Colours of the vertices.
    pub vertex_colours: bool,
    /// Texture coordinates of the corners.
    pub uv: bool,
    /// Joints and weights of the vertices.
    pub skin: bool,
}

impl Default for Preserve {
    fn default() -> Self {
        Self { materials: true, vertex_colours: true, uv: true, skin: true }
    }
}

/// Attributes of a quad mesh. A list is empty if the quads have no such attribute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadAttributes {
    /// Index into `material_names` per quad, or empty.
    pub materials: Vec<u32>,
    /// Names of the materials, each of at least one quad; the empty name stands for no material.
    pub material_names: Vec<String>,
    /// Number that the input gives to each of these materials.
    pub material_numbers: Vec<u32>,
    /// RGBA per vertex, 0 to 1, or empty.
    pub colours: Vec<[f32; 4]>,
    /// Texture coordinates per quad, in the order of its corners, v upwards; or empty.
    pub uv: Vec<[[f32; 2]; 4]>,
    /// Joints and weights per vertex, or empty.
    pub skin: Vec<Influences>,
    /// Number of the input's object per quad, or empty if the input has no two.
    pub objects: Vec<u32>,
    /// Unit normals per quad, in the order of its corners, see [`corner_normals`](super::corner_normals); or empty.
    pub normals: Vec<[[f32; 3]; 4]>,
}

impl QuadAttributes {
    /// Whether nothing is carried; normals are no attribute of the input.
    pub fn is_empty(&self) -> bool {
        let of_quads = self.materials.is_empty() && self.uv.is_empty() && self.objects.is_empty();
        of_quads && self.colours.is_empty() && self.skin.is_empty()
    }
}
