//! From cross fields to maps.

mod grid_map;

pub use grid_map::{GridMap, Iso, rotate, rotate_integer};
