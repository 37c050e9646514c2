//! The engine's only door: a soup and a spec in, quads, map and report out.

mod attempt;
#[cfg(test)]
mod attribute_tests;
mod check;
mod components;
mod costs;
mod error;
#[cfg(test)]
mod field_tests;
mod finding;
mod inspect;
mod judged;
mod make;
mod make_symmetric;
mod outcome;
mod plan;
mod polish;
mod quality;
mod remedies;
#[cfg(test)]
mod remedy_tests;
mod remesh;
mod report;
mod sizing;
mod solve;
mod spec;
mod sure;
mod surface;
mod symmetry;
#[cfg(test)]
mod tests;

pub use crate::engine::attributes::{Preserve, QuadAttributes};
pub use crate::engine::certify::QuadReport;
pub use crate::engine::field::{GivenBranchPoints, GivenField, GivenMatching, GivenVectors};
pub use crate::engine::methods::Level;
pub use crate::engine::problem::{Align, Boundary, Optimise, WorkingMesh};
pub use check::{RunFindings, check};
pub use costs::{Size, plan_of_run, share_of_proof};
pub use error::RemeshError;
pub use inspect::{Inspection, inspect};
pub use outcome::MapOutcome;
pub use remesh::{Outcome, remesh};
pub use report::{BranchReport, FeatureReport, InputReport, MapReport, Repairs, Report, Singularity};
pub use spec::{Effort, FeatureSpec, NonOrientable, RemeshSpec, Symmetry, Target};
pub use symmetry::MirrorPlane;
