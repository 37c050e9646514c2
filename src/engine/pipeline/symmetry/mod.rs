//! Exact mirror symmetry: one half of the surface is solved, and its quads, its map and itself are mirrored and welded.
//!
//! The mirror plane lies across one of the axes, through the origin or through the middle of the model, whichever the
//! model agrees with better. What is certified is the surface of the half at larger coordinates and its image; how far
//! that is from the model is measured before anything is solved.

mod fold;
mod halve;
mod mirror;
#[cfg(test)]
mod tests;
mod unfold;

pub(super) use fold::{Fold, fold};
pub(super) use unfold::{unfold_map, unfold_quads, unfold_surface};
