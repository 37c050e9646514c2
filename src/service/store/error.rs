//! Why the store failed.

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

impl From<StoreError> for Problem {
    /// The cause goes to the log, not to the client.
    fn from(error: StoreError) -> Self {
        tracing::error!(%error, "the store failed");
        match error {
            StoreError::Damaged { .. } | StoreError::Unsupported(_) | StoreError::Migration(_) => Problem::internal(),
            _ => Problem {
                retry_after: Some(5),
                ..Problem::new(ProblemKind::StorageUnavailable, "The cause was logged. Try again in a few seconds.")
            },
        }
    }
}
