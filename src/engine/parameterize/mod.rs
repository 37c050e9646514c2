//! From cross fields to maps.

mod constraints;
mod corner_forms;
mod elimination;
mod generators;
#[cfg(test)]
mod given_tests;
mod grid_map;
mod map_aim;
mod map_error;
mod measure;
mod poisson;
mod quantise;
mod reduced;
mod rounding;
mod seamless_map;
mod separation;
mod shortest_cut;
#[cfg(test)]
mod tests;
mod untangle;

pub use grid_map::{GridMap, Iso, rotate, rotate_integer};
pub use map_aim::{MapAim, Precision};
pub use map_error::MapError;
pub use measure::{MapMeasures, gradients, measure_map, seam_residual};
pub use quantise::{Flow, Variable};
pub use rounding::PeriodForm;
pub use seamless_map::{MapSystem, RoundedIntegers};
pub use untangle::untangle;
