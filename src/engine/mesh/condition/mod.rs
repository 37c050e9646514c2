//! Input conditioning: from the polygons of a file to an oriented 2-manifold without degenerate triangles.
//!
//! triangulate → weld → split at T vertices → pair the sides of edges → drop equal shells → one vertex per fan → orient →
//! mend degenerate triangles. Every step keeps the order of what it leaves alone, so that clean input comes back as it was;
//! every repair is counted; no hole is filled. All lengths are compared with the size of the model or component, so results
//! do not depend on units.

mod condition_soup;
mod degenerate;
#[cfg(test)]
mod degenerate_tests;
mod doubled;
mod draft;
mod edges;
mod editable;
mod error;
mod fans;
#[cfg(test)]
mod non_manifold_tests;
mod orient;
#[cfg(test)]
mod orientation_tests;
mod pairing;
mod patches;
mod shards;
mod shells;
mod t_vertices;
mod tally;
#[cfg(test)]
mod tests;
mod thin;
mod triangulate;
mod weld;

pub use condition_soup::{ConditionOptions, condition};
pub use error::ConditionError;
