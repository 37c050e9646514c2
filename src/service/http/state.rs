//! What handlers share.

use std::path::PathBuf;
use std::sync::Arc;

use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

use crate::service::http::{Access, Readiness};
use crate::service::jobs::{Driver, Jobs};

/// What handlers share. Cheap to clone.
#[derive(Clone)]
pub struct HttpState {
    /// Accepts, cancels, deletes; holds the store.
    pub jobs: Jobs,
    /// Reads uploads, draws pictures.
    pub driver: Arc<dyn Driver>,
    /// Who may use the API from a browser.
    pub access: Access,
    /// Folder of uploads on their way in.
    pub uploads: PathBuf,
    /// Whether the storage can be written to.
    pub readiness: Arc<Readiness>,
    /// Uploads that may be read at the same time: each may need many times its size.
    pub readers: Arc<Semaphore>,
    /// The process is stopping: endless answers end.
    pub stop: CancellationToken,
}

impl std::fmt::Debug for HttpState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HttpState").field("uploads", &self.uploads).finish_non_exhaustive()
    }
}
