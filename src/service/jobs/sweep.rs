//! Removes what is no longer needed: expired jobs, used tickets, files that no row names.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::service::jobs::{Jobs, TicketQueue};
use crate::service::store::{StoreError, now_ms};

const PAUSE: Duration = Duration::from_secs(30);
/// Blobs without a row that are younger than this may belong to a request that is under way.
const ORPHAN_AGE: Duration = Duration::from_secs(3600);
/// Every so many sweeps the whole store is gone through, beginning with the first.
const THOROUGH: u32 = 120;

/// Sweeps again and again until `stop`.
pub async fn sweep_until(jobs: Jobs, stop: CancellationToken) {
    for n in 0u32.. {
        if let Err(error) = sweep(&jobs, n.is_multiple_of(THOROUGH)).await {
            tracing::warn!(%error, "sweeping failed; it will be tried again");
        }
        tokio::select! {
            () = stop.cancelled() => return,
            () = tokio::time::sleep(PAUSE) => {}
        }
    }
}

async fn sweep(jobs: &Jobs, thorough: bool) -> Result<(), StoreError> {
    for id in jobs.store.expired_jobs(now_ms()).await? {
        jobs.store.delete_jobs(&[id]).await?;
        tracing::info!(job.id = %id, "the job expired and was removed");
    }
    if thorough {
        let orphans = jobs.store.remove_orphans(ORPHAN_AGE).await?;
        let leftovers = jobs.store.remove_leftovers(ORPHAN_AGE).await?;
        if orphans + leftovers > 0 {
            tracing::info!(orphans, leftovers, "files and folders that nothing names were removed");
        }
        jobs.queue.tidy().await?;
    }
    Ok(())
}
