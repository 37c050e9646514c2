//! Quad meshes.

mod quad_mesh;

pub use quad_mesh::{Anchor, QuadDraft, QuadMesh};
