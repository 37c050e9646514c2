//! How an attempt ends: with files, with a problem, or with the job back in the queue.

use std::time::Duration;

use bytes::Bytes;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::service::jobs::storage_retry::retry_while_storage_fails;
use crate::service::jobs::worker::hex;
use crate::service::jobs::{Products, Ticket, TicketQueue, Worker};
use crate::service::store::{Artefact, Artefacts, Ending, JobRow, StoreError, jobs, now_ms};
use crate::service::wire::{JobStatus, Problem, ProblemKind, ReportBody, ResultBody};

/// How long a finished run is kept in memory when it cannot be stored; then it is given up and run again later.
const STORE_TIMEOUT: Duration = Duration::from_secs(60);
/// Bounds of the pause before a job is tried again whose storage failed; in between it doubles the time waited so far.
const PAUSES: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(30));

/// A file that was made, on its way into the store.
struct Finished {
    name: &'static str,
    bytes: Bytes,
    artefact: Artefact,
}

impl<Q: TicketQueue + 'static> Worker<Q> {
    /// Publishes what became of an attempt.
    pub(super) async fn end(&self, job: &JobRow, made: Result<Products, Problem>) -> Result<(), StoreError> {
        let ending = match made {
            Ok(products) => self.publish(job, products).await?,
            Err(problem) if problem.kind == ProblemKind::ShuttingDown => {
                return self.put_back(job, job.faulty_since, Duration::ZERO).await;
            }
            Err(problem) => {
                let cancelled = problem.kind == ProblemKind::Cancelled;
                let status = if cancelled { JobStatus::Cancelled } else { JobStatus::Failed };
                tracing::info!(problem = problem.kind.slug(), detail = problem.detail, "the job ends without a result");
                Ending::without_result(status, problem.body(Some(format!("/v1/jobs/{}", job.id))))
            }
        };
        let status = ending.status;
        let keep_ms = i64::try_from(self.config.retention.as_millis()).unwrap_or(i64::MAX);
        let finish = || self.store.finish(job.id, job.attempt, &ending, keep_ms);
        if retry_while_storage_fails(Some(STORE_TIMEOUT), &self.stop, finish).await? {
            metrics::counter!("quadrille_jobs_finished_total", "status" => status.name()).increment(1);
        } else {
            tracing::info!("the job was deleted or taken over; its files are removed");
            self.store.blobs().remove_below(&prefix(job.id, job.attempt)).await?;
        }
        for earlier in 1..job.attempt {
            self.store.blobs().remove_below(&prefix(job.id, earlier)).await?;
        }
        Ok(())
    }

    /// Writes the files under the attempt's own prefix; they become visible with the row.
    async fn publish(&self, job: &JobRow, products: Products) -> Result<Ending, StoreError> {
        let input = products.input(&job.input);
        let result = ResultBody::from(&products.report);
        let mut artefacts = Artefacts::new();
        for Finished { name, bytes, artefact } in self.finished(job, products)? {
            let put = || self.store.blobs().put(&artefact.blob, bytes.clone());
            retry_while_storage_fails(Some(STORE_TIMEOUT), &self.stop, put).await?;
            artefacts.insert(name.to_owned(), artefact);
        }
        Ok(Ending { status: JobStatus::Succeeded, result: Some(result), problem: None, artefacts, input: Some(input) })
    }

    fn finished(&self, job: &JobRow, products: Products) -> Result<Vec<Finished>, StoreError> {
        let report = serde_json::to_vec_pretty(&products.report)
            .map_err(|error| StoreError::Unsupported(format!("the report is not JSON: {error}")))?;
        record(&products.report);
        let files = products.files.into_iter().map(|made| (made.name, made.media_type, made.bytes));
        let files = files.chain([("report.json", "application/json", report)]).map(|(name, media_type, bytes)| {
            let artefact = Artefact {
                blob: format!("{}/{name}", prefix(job.id, job.attempt)),
                sha256: hex(&Sha256::digest(&bytes)),
                bytes: bytes.len() as u64,
                media_type: media_type.to_owned(),
            };
            Finished { name, bytes: Bytes::from(bytes), artefact }
        });
        Ok(files.collect())
    }

    /// The storage failed, which is not the job's fault: it goes back to the queue for a while, and the attempt does not
    /// count. When that has gone on for too long, it ends.
    pub(super) async fn wait(&self, job: &JobRow, error: &StoreError) -> Result<(), StoreError> {
        let now = now_ms();
        let since = job.faulty_since.unwrap_or(now);
        let waited = Duration::from_millis(now.saturating_sub(since).max(0).unsigned_abs());
        if waited >= self.config.storage_patience {
            let detail =
                format!("The storage of this job has failed for {} s; the cause was logged.", waited.as_secs());
            tracing::error!(%error, "the storage has failed for too long");
            return self.end(job, Err(Problem::new(ProblemKind::StorageUnavailable, detail))).await;
        }
        let pause = waited.clamp(PAUSES.0, PAUSES.1);
        tracing::warn!(%error, ?pause, "the storage failed; the job waits");
        retry_while_storage_fails(None, &self.stop, || self.put_back(job, Some(since), pause)).await
    }

    /// Puts a job that is not to blame for the end of this attempt back into the queue; the attempt does not count.
    async fn put_back(&self, job: &JobRow, faulty_since: Option<i64>, pause: Duration) -> Result<(), StoreError> {
        let number = Uuid::now_v7();
        let mut tx = self.store.write().await?;
        if jobs::put_back(&mut tx, job, number, faulty_since).await? {
            self.queue.enqueue(&mut tx, Ticket { job: job.id, number }, job.priority, pause).await?;
            tracing::info!("the job goes back in line");
        }
        tx.commit().await?;
        Ok(())
    }
}

/// The seconds of the stages as metrics, and a line of the log.
fn record(report: &ReportBody) {
    for (stage, ms) in &report.timings_ms {
        let seconds = ms.as_f64().unwrap_or_default() / 1000.0;
        metrics::histogram!("quadrille_stage_seconds", "stage" => stage.clone()).record(seconds);
    }
    let timings = serde_json::json!(report.timings_ms);
    tracing::info!(quads = report.quads.count, level = report.level.name(), timings_ms = %timings, "the job has its result");
}

fn prefix(job: Uuid, attempt: u32) -> String {
    format!("{}/{attempt}", JobRow::blobs(job))
}
