//! A started service and its end.

use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::engine::run::StopReason;
use crate::service::jobs::Live;
use crate::service::store::Store;

/// Time beyond the grace in which running jobs are put back into the queue.
const REQUEUE_TIME: Duration = Duration::from_secs(2);

/// A started service. Dropping it aborts everything, as a crash would; [`Running::stop`] ends it in order.
#[derive(Debug)]
pub struct Running {
    address: SocketAddr,
    store: Store,
    live: Live,
    grace: Duration,
    stop: CancellationToken,
    tasks: JoinSet<()>,
}

impl Running {
    pub(super) fn new(store: Store, live: Live, grace: Duration) -> Self {
        let address = SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0));
        Self { address, store, live, grace, stop: CancellationToken::new(), tasks: JoinSet::new() }
    }

    pub(super) fn listens_on(&mut self, address: SocketAddr) {
        self.address = address;
    }

    pub(super) fn stop_token(&self) -> CancellationToken {
        self.stop.clone()
    }

    pub(super) fn add(&mut self, task: impl Future<Output = ()> + Send + 'static) {
        self.tasks.spawn(task);
    }

    /// Where HTTP is served, with the actual port; unspecified for a worker.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Accepts nothing new, stops the runs, puts their jobs back into the queue, and ends; after the grace of the configuration
    /// without more ado: what is running then is found and run again later, as after a crash.
    pub async fn stop(mut self) {
        self.stop.cancel();
        self.live.stop_all(StopReason::Shutdown);
        let drained = async { while self.tasks.join_next().await.is_some() {} };
        if tokio::time::timeout(self.grace + REQUEUE_TIME, drained).await.is_err() {
            tracing::warn!(running = self.live.count(), "ending before everything has come to its end");
        }
        self.tasks.shutdown().await;
        self.store.close().await;
        tracing::info!("stopped");
    }
}
