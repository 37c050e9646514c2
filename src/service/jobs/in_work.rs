//! Tasks that go on when whoever waits for them is dropped.

use std::collections::BTreeMap;
use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use uuid::Uuid;

use crate::service::store::StoreError;

/// How a task ended; nothing while it runs. Errors are text: several may wait for one task.
type Outcome = watch::Receiver<Option<Result<(), String>>>;

/// Tasks by number, a few at a time. Cheap to clone; dropping the last clone aborts everything.
#[derive(Clone, Debug)]
pub(super) struct InWork {
    tasks: Arc<Mutex<Tasks>>,
    permits: Arc<Semaphore>,
}

#[derive(Debug, Default)]
struct Tasks {
    running: JoinSet<()>,
    outcomes: BTreeMap<Uuid, Outcome>,
}

impl InWork {
    /// At most `permits` tasks run at a time.
    pub(super) fn new(permits: usize) -> Self {
        Self { tasks: Arc::default(), permits: Arc::new(Semaphore::new(permits.max(1))) }
    }

    fn tasks(&self) -> MutexGuard<'_, Tasks> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts `work` unless a task of this number runs already, and waits for its end. Dropping the wait does not stop
    /// the task.
    pub(super) async fn once(
        &self,
        number: Uuid,
        work: impl Future<Output = Result<(), StoreError>> + Send + 'static,
    ) -> Result<(), StoreError> {
        let mut outcome = self.begin(number, work);
        let ended = outcome.wait_for(Option::is_some).await.map(|ended| ended.clone());
        self.tasks().outcomes.remove(&number);
        match ended {
            Ok(Some(result)) => result.map_err(StoreError::Queue),
            // The task was aborted or panicked.
            Ok(None) | Err(_) => Err(StoreError::Queue("the work on a ticket broke off".to_owned())),
        }
    }

    fn begin(&self, number: Uuid, work: impl Future<Output = Result<(), StoreError>> + Send + 'static) -> Outcome {
        let mut tasks = self.tasks();
        while tasks.running.try_join_next().is_some() {}
        if let Some(outcome) = tasks.outcomes.get(&number) {
            return outcome.clone();
        }
        let (sender, outcome) = watch::channel(None);
        let permits = Arc::clone(&self.permits);
        tasks.running.spawn(async move {
            let _permit = permits.acquire_owned().await;
            let ended = work.await.map_err(|error| error.to_string());
            let _ = sender.send(Some(ended));
        });
        tasks.outcomes.insert(number, outcome.clone());
        outcome
    }

    /// Waits until no task runs.
    pub(super) async fn over(&self) {
        let mut running = std::mem::take(&mut self.tasks().running);
        while running.join_next().await.is_some() {}
    }
}
