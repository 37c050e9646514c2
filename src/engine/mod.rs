//! The engine: a building of floors, each module uses only floors below it.
//!
//! ```text
//! run ← numerics ← mesh ← topology ← calculus ← field ← parameterize ← quad ← problem ← methods ┐
//!                                                         attributes, certify, render ┴← pipeline
//! ```
//!
//! Stages are functions from plain results to a plain result, with the [`run::RunContext`] first. All methods end in
//! the same doors and share one extractor, one certificate and one report. `tests/architecture.rs` holds the plan.

pub mod attributes;
pub mod calculus;
pub mod certify;
pub mod field;
pub mod mend;
pub mod mesh;
pub mod methods;
pub mod numerics;
pub mod parameterize;
pub mod pipeline;
pub mod problem;
pub mod quad;
pub mod render;
pub mod run;
pub mod topology;
