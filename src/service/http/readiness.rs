//! Whether the storage takes work.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tokio::sync::Mutex;

use crate::service::jobs::run_blocking;
use crate::service::store::{Store, StoreError};
use crate::service::wire::{Problem, ProblemKind};

/// How long a result is used again: writing is not free, and anyone may ask.
const CACHED_FOR: Duration = Duration::from_secs(1);
/// Longest wait for the storage; what is slower cannot take work.
const PROBE_TIMEOUT: Duration = Duration::from_secs(3);

/// Whether the storage can be written to, found out by writing.
#[derive(Debug, Default)]
pub struct Readiness(Mutex<Option<(Instant, Result<(), Problem>)>>);

impl Readiness {
    pub(super) async fn check(&self, store: &Store, uploads: PathBuf) -> Result<(), Problem> {
        let mut last = self.0.lock().await;
        if let Some((at, found)) = &*last
            && at.elapsed() < CACHED_FOR
        {
            return found.clone();
        }
        let probes = async {
            run_blocking(move || probe(&uploads)).await?;
            Ok(store.probe().await?)
        };
        let slow = |_| Err(Problem::new(ProblemKind::StorageUnavailable, "The storage does not answer in time."));
        let found = tokio::time::timeout(PROBE_TIMEOUT, probes).await.unwrap_or_else(slow);
        *last = Some((Instant::now(), found.clone()));
        found
    }
}

fn probe(uploads: &Path) -> Result<(), Problem> {
    let written = tempfile::tempfile_in(uploads).and_then(|mut file| file.write_all(b"ready"));
    written.map_err(|source| StoreError::File { what: "writing to the folder of uploads", source }.into())
}
