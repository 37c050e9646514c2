//! Combinatorics on a mesh: rotations across edges, indices, cut graphs. No lengths.

mod cut_graph;
mod matching;

pub use cut_graph::{CutGraph, Segment, cut_and_comb};
pub use matching::{Matching, Singularity};
