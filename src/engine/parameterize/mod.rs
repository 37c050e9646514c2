//! From cross fields to maps.

mod corner_forms;
mod elimination;
mod grid_map;
mod poisson;
mod reduced;
mod rounding;
mod seamless_map;

pub use grid_map::{GridMap, Iso, rotate, rotate_integer};
pub use seamless_map::{MapError, MapSystem, RoundedIntegers};
