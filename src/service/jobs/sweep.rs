//! Housekeeping: jobs whose time is over, tickets that were used up.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::service::jobs::{Desk, TicketQueue};
use crate::service::store::{StoreError, now_ms};

const PAUSE: Duration = Duration::from_secs(30);

/// Sweeps again and again until `stop`.
pub async fn sweep_until(desk: Desk, stop: CancellationToken) {
    loop {
        if let Err(error) = sweep(&desk).await {
            tracing::warn!(%error, "sweeping failed; it will be tried again");
        }
        tokio::select! {
            () = stop.cancelled() => return,
            () = tokio::time::sleep(PAUSE) => {}
        }
    }
}

async fn sweep(desk: &Desk) -> Result<(), StoreError> {
    for id in desk.store.expired_jobs(now_ms()).await? {
        desk.store.delete_job(id).await?;
        tracing::info!(job.id = %id, "the job expired and was removed");
    }
    desk.queue.tidy().await
}
