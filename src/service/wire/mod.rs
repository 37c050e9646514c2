//! What goes over the wire: the spec, the report, the job object and the problems (docs/contract.md, sections 2 to 4).
//!
//! Nothing of the engine is `Serialize`: these types are the only place where names of the contract are spelt, so the
//! engine may change its own without breaking a client, and a client's spec is judged completely before the engine
//! sees any of it.

mod data;
mod fields;
mod job;
mod level;
mod problem;
mod problem_body;
mod report;
mod spec;
mod violation;
mod warning;

pub(in crate::service) use fields::Fields;
pub use job::{InputBody, JobBody, JobList, JobStatus, ResultBody, Urls};
pub use level::LevelName;
pub use problem::{Problem, ProblemKind, problem_of_fault};
pub use problem_body::{Figures, ProblemBody};
pub use report::{
    FeaturesReportBody, InputReportBody, MapBody, MirrorPlaneBody, QuadsBody, ReportBody, ScaledJacobian,
    SingularityBody, Spread,
};
pub use spec::{
    Accept, Axis, Choice, JobOptions, MethodName, Named, Output, ResolvedSpec, SPEC_BYTES, SpecDocument, SpecSummary,
    SpecTable, SymmetryAxis,
};
pub(in crate::service) use spec::{FIELDS, Field, Flag, FlagText, defaults_of, json_of_field, own_schema};
pub use violation::Violation;
pub use warning::WarningBody;
