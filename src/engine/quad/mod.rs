//! Quad meshes.

pub mod extract;
pub mod fill;
pub mod improve;
mod layout;
pub mod optimise;
mod quad_mesh;

pub use improve::{improve_connectivity, reach_out, remove_doublets};
pub use layout::{ArcCourse, LayoutArc, LayoutError, LayoutNode, QuadLayout, Side, quads_of_layout};
pub use optimise::{OptimiseOptions, optimise};
pub use quad_mesh::{Anchor, QuadDraft, QuadMesh};
