//! Optimisation of the positions of a quad draft on its surface.
//!
//! Vertices walk over the triangles (`surface_walker`) or slide along feature curves (`curves`, `chains`); folded quads
//! are turned right side up first (`untangle`), then all are relaxed towards squares (`relax`), and those on curves moved
//! to where the curves bend (`fit`), every single step guarded by the quality of the quads it touches.

mod chains;
mod curves;
mod fit;
mod incidence;
mod relax;
mod sequence;
mod shape;
mod state;
mod surface_walker;
mod untangle;

#[cfg(test)]
mod curve_tests;
#[cfg(test)]
mod tests;

pub(crate) use curves::{Curve, trace_curves};
pub(crate) use sequence::is_sound;
pub(crate) use sequence::mean_edge;
pub use sequence::{OptimiseOptions, optimise};
pub(crate) use shape::ScaledCorner;
pub(crate) use shape::area_vector;
pub(crate) use shape::quality;
pub(crate) use surface_walker::SurfaceWalker;
