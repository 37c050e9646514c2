//! Why the store failed.

use std::path::PathBuf;

use crate::service::wire::{Problem, ProblemKind};

/// A failure of the database or of the object store; never the client's fault.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The database refused or could not be reached.
    #[error("the database failed: {0}")]
    Database(#[from] sqlx::Error),
    /// The schema could not be brought up to date.
    #[error("the database could not be migrated: {0}")]
    Migration(#[from] sqlx::migrate::MigrateError),
    /// The object store refused or could not be reached.
    #[error("the object store failed: {0}")]
    Blob(#[from] object_store::Error),
    /// A file of our own could not be used.
    #[error("{what} failed: {source}")]
    File {
        /// What was tried.
        what: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file of the database was removed or replaced while it was open.
    #[error("the file {0} of the database is not the one that was opened; put it back or restart")]
    Replaced(PathBuf),
    /// A blob does not have the length that its row says.
    #[error("the blob {key} has {found} bytes instead of {expected}")]
    Truncated {
        /// Where it lies.
        key: String,
        /// Its length.
        found: u64,
        /// The length in the row.
        expected: u64,
    },
    /// A column does not hold what we once wrote there.
    #[error("column {column} of job {id} is damaged: {detail}")]
    Damaged {
        /// The job.
        id: String,
        /// The column.
        column: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// The configured address of the database or store is not one that this build knows.
    #[error("{0}")]
    Unsupported(String),
    /// The dispatch queue refused a ticket.
    #[error("the queue failed: {0}")]
    Queue(String),
}

impl StoreError {
    /// Whether it may work again later: a full disk, a locked database, a lost blob. Otherwise it is a bug of ours.
    pub fn is_of_storage(&self) -> bool {
        !matches!(self, StoreError::Damaged { .. } | StoreError::Unsupported(_) | StoreError::Migration(_))
    }
}

impl From<StoreError> for Problem {
    /// The cause goes to the log, not to the client.
    fn from(error: StoreError) -> Self {
        tracing::error!(%error, "the store failed");
        if error.is_of_storage() {
            let detail = "The cause was logged. Try again in a few seconds.";
            Problem { retry_after: Some(5), ..Problem::new(ProblemKind::StorageUnavailable, detail) }
        } else {
            Problem::internal()
        }
    }
}
