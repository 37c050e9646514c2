//! Which edges must come out as quad edges, and which vertices as quad vertices.
//!
//! Seeds (sharp dihedral angles, material borders, edges named by the user) → growth along less sharp edges that go
//! straight on → short loose chains away → corners. The boundary is always kept and never listed.

mod corners;
mod cycles;
mod detect;
mod network;
mod prune;
mod relief;
mod seeds;
#[cfg(test)]
mod tests;
mod thin;

pub use detect::{Detected, FeatureOptions, detect_features, detect_features_and_detail, features_of_edges};
