//! Exact mirror symmetry: one half of the surface is solved, and its quads, its map and itself are mirrored and welded.
//!
//! A mirror plane lies across one of the axes, through the origin or through the middle of the model, whichever the
//! model agrees with better; or it is found in any direction, and then the model is turned until it lies across an axis,
//! and its quads are turned back: they are their own image bit for bit in the turned frame. What is certified is the surface of the half at larger coordinates and its image; how far
//! that is from the model is measured before anything is solved.

mod find;
mod fold;
mod halve;
mod mirror;
mod planes;
#[cfg(test)]
mod tests;
mod unfold;

pub(super) use find::{FoundPlane, find_planes};
pub(super) use fold::{Fold, MOST, fold};
pub use planes::MirrorPlane;
pub(super) use planes::{Planes, turned};
pub(super) use unfold::{unfold_map, unfold_quads, unfold_surface};
