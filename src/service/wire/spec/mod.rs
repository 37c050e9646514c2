//! The spec of a request (docs/contract.md, section 3): JSON in, a validated [`ResolvedSpec`] or all violations out.

pub(in crate::service) mod choice;
mod document;
mod field;
mod given_field;
mod judge;
mod kinds;
mod lists;
mod method;
mod mirrors;
mod names;
mod one_of;
mod resolved;
mod schema;
mod table;
mod target;
#[cfg(test)]
mod tests;

pub use choice::{Choice, Named};
pub use document::{SpecDocument, SpecSummary};
pub(in crate::service) use field::{Field, Flag, FlagText};
pub(in crate::service) use given_field::json_of_field;
pub use judge::SPEC_BYTES;
pub use method::MethodName;
pub(in crate::service) use method::{defaults_of, own_schema};
pub use names::{Axis, Output, SymmetryAxis};
pub use resolved::{Accept, JobOptions, ResolvedSpec};
pub use schema::SpecTable;
pub(in crate::service) use table::FIELDS;
