//! Quads without a map.

mod split;

pub use split::split_draft;
