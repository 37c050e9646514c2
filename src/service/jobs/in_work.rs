//! Work that does not end with who waits for it.

use std::collections::BTreeMap;
use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use uuid::Uuid;

use crate::service::store::StoreError;

/// How a piece of work ended; nothing while it goes on. Errors are told as text: several may wait.
type Told = watch::Receiver<Option<Result<(), String>>>;

/// Pieces of work by number, a few at a time. Cheap to clone; dropping the last clone aborts everything.
#[derive(Clone, Debug)]
pub(super) struct InWork {
    pieces: Arc<Mutex<Pieces>>,
    places: Arc<Semaphore>,
}

#[derive(Debug, Default)]
struct Pieces {
    running: JoinSet<()>,
    told: BTreeMap<Uuid, Told>,
}

impl InWork {
    /// `places` at a time.
    pub(super) fn new(places: usize) -> Self {
        Self { pieces: Arc::default(), places: Arc::new(Semaphore::new(places.max(1))) }
    }

    fn pieces(&self) -> MutexGuard<'_, Pieces> {
        self.pieces.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does `work` unless the same number is being worked on, and waits for its end. Who stops waiting does not stop the
    /// work.
    pub(super) async fn once(
        &self,
        number: Uuid,
        work: impl Future<Output = Result<(), StoreError>> + Send + 'static,
    ) -> Result<(), StoreError> {
        let mut told = self.begin(number, work);
        let ended = told.wait_for(Option::is_some).await.map(|ended| ended.clone());
        self.pieces().told.remove(&number);
        match ended {
            Ok(Some(result)) => result.map_err(StoreError::Queue),
            // Whoever should tell is gone.
            Ok(None) | Err(_) => Err(StoreError::Queue("the work on a ticket broke off".to_owned())),
        }
    }

    fn begin(&self, number: Uuid, work: impl Future<Output = Result<(), StoreError>> + Send + 'static) -> Told {
        let mut pieces = self.pieces();
        while pieces.running.try_join_next().is_some() {}
        if let Some(told) = pieces.told.get(&number) {
            return told.clone();
        }
        let (tell, told) = watch::channel(None);
        let places = Arc::clone(&self.places);
        pieces.running.spawn(async move {
            let _place = places.acquire_owned().await;
            let ended = work.await.map_err(|error| error.to_string());
            let _ = tell.send(Some(ended));
        });
        pieces.told.insert(number, told.clone());
        told
    }

    /// Waits until nothing is in work.
    pub(super) async fn over(&self) {
        let mut running = std::mem::take(&mut self.pieces().running);
        while running.join_next().await.is_some() {}
    }
}
