//! The engine's only door: a soup and a spec in, quads, map and report out.

#[cfg(test)]
mod attribute_tests;
mod check;
mod component;
mod costs;
mod error;
mod finding;
mod finish;
mod inspect;
mod ladder;
mod outcome;
mod remesh;
mod report;
mod road;
mod rounding;
mod sizing;
mod spec;
mod symmetry;
#[cfg(test)]
mod tests;
mod working;

pub use crate::engine::attributes::{Preserve, QuadAttributes};
pub use crate::engine::certify::QuadReport;
pub use crate::engine::methods::quad_cover::RoundingTrial;
pub use crate::engine::parameterize::RoundingStatistics;
pub use check::{RunFindings, check};
pub use costs::{Size, plan_of_run, share_of_proof};
pub use error::RemeshError;
pub use inspect::{Inspection, inspect};
pub use outcome::MapOutcome;
pub use remesh::{Outcome, remesh};
pub use report::{BranchReport, FeatureReport, InputReport, Level, MapReport, Repairs, Report, Singularity};
pub use rounding::rounding_trials;
pub use spec::{Align, Boundary, FeatureSpec, Method, NonOrientable, Optimise, RemeshSpec, Target, WorkingMesh};
