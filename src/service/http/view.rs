//! Rows as clients see them.

use std::time::Duration;

use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::extract::no_job;
use crate::service::store::{JobRow, rfc3339};
use crate::service::wire::{JobBody, Problem, Urls};

/// Polling interval: changes by other processes are not signalled, they are seen only when the row is read again.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// The job object.
pub(super) async fn job_body(state: &HttpState, job: JobRow) -> Result<JobBody, Problem> {
    let queue_position = state.jobs.store.queue_position(&job).await?;
    let id = job.id.to_string();
    Ok(JobBody {
        status: job.status,
        stage: job.stage,
        progress: f64::from(job.progress) / 1000.0,
        seconds_left: job.seconds_left,
        queue_position,
        attempt: job.attempt,
        created_at: rfc3339(job.created_at),
        started_at: job.started_at.map(rfc3339),
        finished_at: job.finished_at.map(rfc3339),
        expires_at: job.expires_at.map(rfc3339),
        input: job.input,
        result: job.result,
        problem: job.problem,
        tags: job.tags,
        spec: job.spec,
        urls: Urls::of(&id),
        id,
    })
}

/// The row of a job.
pub(super) async fn job_row(state: &HttpState, id: Uuid) -> Result<JobRow, Problem> {
    state.jobs.store.job(id).await?.ok_or_else(|| no_job(id))
}

/// Waits until the job is finished, the timeout has passed or the server shuts down; returns the job's row at that
/// time, which need not be final.
pub(super) async fn wait_for_job(state: &HttpState, id: Uuid, timeout: Duration) -> Result<JobRow, Problem> {
    let mut changes = state.jobs.live.subscribe();
    let deadline = tokio::time::Instant::now() + timeout;
    loop {
        let job = job_row(state, id).await?;
        if job.status.is_final() || tokio::time::Instant::now() >= deadline || state.stop.is_cancelled() {
            return Ok(job);
        }
        let next_poll = (tokio::time::Instant::now() + POLL_INTERVAL).min(deadline);
        let changed = async {
            // `recv` also fails if this receiver lagged and lost messages; the row is read again in that case, too.
            while changes.recv().await.is_ok_and(|changed| changed != id) {}
        };
        tokio::select! {
            () = changed => {}
            () = state.stop.cancelled() => {}
            () = tokio::time::sleep_until(next_poll) => {}
        }
    }
}
