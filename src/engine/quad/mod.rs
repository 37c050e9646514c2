//! Quad meshes.

pub mod extract;
pub mod fill;
pub mod optimise;
mod quad_mesh;

pub use optimise::{OptimiseOptions, optimise};
pub use quad_mesh::{Anchor, QuadDraft, QuadMesh};
