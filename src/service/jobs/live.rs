//! What this process knows about jobs without asking the database: the contexts of running ones, and that a row changed.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;
use uuid::Uuid;

use crate::engine::run::{RunContext, StopReason};

/// Running contexts, and a channel that says which jobs changed. Cheap to clone. Only a shortcut: what another process
/// changes is found by polling.
#[derive(Clone, Debug)]
pub struct Live {
    running: Arc<Mutex<BTreeMap<Uuid, RunContext>>>,
    changes: broadcast::Sender<Uuid>,
}

impl Default for Live {
    fn default() -> Self {
        Self { running: Arc::default(), changes: broadcast::channel(1024).0 }
    }
}

impl Live {
    fn running(&self) -> MutexGuard<'_, BTreeMap<Uuid, RunContext>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A run of `job` begins; it can be stopped until the answer is dropped.
    pub fn enter(&self, job: Uuid, context: RunContext) -> Running {
        self.running().insert(job, context.clone());
        Running { live: self.clone(), job, context }
    }

    /// Stops the run of `job`, if it runs here.
    pub fn stop(&self, job: Uuid, reason: StopReason) {
        if let Some(context) = self.running().get(&job) {
            context.stop(reason);
        }
    }

    /// Stops every run.
    pub fn stop_all(&self, reason: StopReason) {
        self.running().values().for_each(|context| context.stop(reason));
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.running().len()
    }

    /// Tells all subscribers that the row of `job` changed.
    pub fn notify(&self, job: Uuid) {
        let _ = self.changes.send(job);
    }

    /// Receives every change from now on; a slow receiver may miss some, and is told that it did.
    pub fn subscribe(&self) -> broadcast::Receiver<Uuid> {
        self.changes.subscribe()
    }
}

/// A run in this process, known as such until this is dropped. Dropping it before the run is over stops the run.
#[derive(Debug)]
pub struct Running {
    live: Live,
    job: Uuid,
    context: RunContext,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.context.stop(StopReason::Shutdown);
        self.live.running().remove(&self.job);
    }
}
