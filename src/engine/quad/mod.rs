//! Quad meshes.

pub mod extract;
pub mod fill;
mod quad_mesh;

pub use quad_mesh::{Anchor, QuadDraft, QuadMesh};
