//! What survives a crash: rows in SQLite, bytes in an object store.
//!
//! The table `remesh_jobs` is the truth about a job; a ticket in the queue only says "look at this job". Every write to
//! a running job is conditional on its attempt, so that a worker which was taken for dead cannot overwrite its successor.
//! Artefacts are written under a key of their attempt first and become visible by one update of the row.

mod artefact;
pub(in crate::service) mod assets;
mod blobs;
mod clock;
mod database;
mod database_file;
mod deletion;
mod error;
mod events;
mod folder;
mod job_row;
pub(in crate::service) mod jobs;
mod leftovers;
mod listing;

pub use artefact::{Artefact, Artefacts};
pub use assets::{AssetRow, NewAsset};
pub use blobs::Blobs;
pub use clock::{now_ms, rfc3339};
pub use database::Store;
pub use deletion::Deleted;
pub use error::StoreError;
pub use events::EventRow;
pub(in crate::service) use folder::private_folder;
pub use job_row::{JobRow, NewJob};
pub use jobs::{Cancelling, Claim, Ending, Holding, RunProgress};
pub use listing::JobFilter;
