//! The engine's only door: a soup and a spec in, quads, map and report out.

mod report;
mod spec;

pub use crate::engine::certify::QuadReport;
pub use report::{InputReport, Level, MapReport, Repairs, Report, Singularity};
pub use spec::{Align, Boundary, FeatureSpec, Method, Optimise, RemeshSpec, Target, WorkingMesh};
