//! What happens to one ticket.

use std::sync::Arc;

use bytes::Bytes;
use sha2::{Digest, Sha256};
use tokio_util::sync::CancellationToken;
use tracing::Instrument;
use uuid::Uuid;

use crate::engine::run::{RunContext, StopReason};
use crate::service::config::JobsConfig;
use crate::service::jobs::recorder::{self, Recorder};
use crate::service::jobs::{Driver, EnginePool, Handler, InputFile, Live, Made, Products, Ticket, TicketQueue};
use crate::service::store::{Artefact, Artefacts, Claim, Ending, JobRow, Store, StoreError, jobs};
use crate::service::wire::{JobStatus, Problem, ProblemKind, ResolvedSpec, ResultBody};

/// Runs jobs one ticket at a time.
#[derive(Clone)]
pub struct Worker<Q> {
    /// Rows and blobs.
    pub store: Store,
    /// Where interrupted jobs go back to.
    pub queue: Q,
    /// Shortcuts within this process.
    pub live: Live,
    /// The engine's threads.
    pub pool: EnginePool,
    /// The road from bytes to files.
    pub driver: Arc<dyn Driver>,
    /// Attempts, retention.
    pub config: JobsConfig,
    /// No new run begins after this.
    pub stop: CancellationToken,
}

impl<Q> std::fmt::Debug for Worker<Q> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Worker").field("config", &self.config).finish_non_exhaustive()
    }
}

impl<Q: TicketQueue + 'static> Handler for Worker<Q> {
    async fn handle(&self, ticket: Ticket) -> Result<(), StoreError> {
        let Claim::Run(job) = self.store.claim(ticket.job, ticket.number).await? else {
            tracing::debug!(job.id = %ticket.job, "a ticket without a job");
            return Ok(());
        };
        self.live.ring(job.id);
        let span = tracing::info_span!("job", job.id = %job.id, attempt = job.attempt, method = job.spec.method.name());
        let result = self.attempt(&job).instrument(span).await;
        self.live.ring(job.id);
        result
    }
}

impl<Q: TicketQueue + 'static> Worker<Q> {
    async fn attempt(&self, job: &JobRow) -> Result<(), StoreError> {
        if job.cancel_requested {
            return self.end(job, Err(Problem::stopped(StopReason::Client))).await;
        }
        let crashes = job.attempt.saturating_sub(job.excused).saturating_sub(1);
        if crashes >= self.config.max_attempts {
            let detail = format!("The worker crashed {crashes} times on this job; it will not be tried again.");
            return self.end(job, Err(Problem::new(ProblemKind::JobCrashed, detail))).await;
        }
        tracing::info!(bytes = job.input.bytes, "the job begins");
        let made = self.run(job).await?;
        self.end(job, made).await
    }

    async fn run(&self, job: &JobRow) -> Result<Result<Products, Problem>, StoreError> {
        let spec = match serde_json::to_value(&job.spec).map(ResolvedSpec::from_value) {
            Ok(Ok(spec)) => spec,
            // Accepted by an older version.
            Ok(Err(violations)) => return Ok(Err(Problem::invalid_spec(violations))),
            Err(_) => return Ok(Err(Problem::internal())),
        };
        let Some(asset) = self.store.asset(job.asset_id).await? else {
            return Ok(Err(Problem::new(ProblemKind::NotFound, "The mesh of this job is gone.")));
        };
        let bytes = self.store.blobs().get(&asset.blob).await?;
        let input = InputFile { bytes, name: asset.name, format: job.input.format.clone() };

        let (listener, said) = recorder::channel();
        let context = RunContext::new(spec.spec.seed, listener);
        let _running = self.live.enter(job.id, context.clone());
        if self.stop.is_cancelled() {
            context.stop(StopReason::Shutdown);
        }
        let books = Recorder {
            store: self.store.clone(),
            live: self.live.clone(),
            job: job.id,
            attempt: job.attempt,
            context: context.clone(),
        };
        let done = CancellationToken::new();
        let over = done.clone().drop_guard();
        let books = tokio::spawn(books.keep(said, done));

        let driver = Arc::clone(&self.driver);
        let run = context.clone();
        let made = self.pool.run(&context, move || driver.run(&run, &input, &spec)).await;

        drop(over);
        let _ = books.await;
        Ok(made)
    }

    /// Publishes what became of an attempt.
    async fn end(&self, job: &JobRow, made: Result<Products, Problem>) -> Result<(), StoreError> {
        let ending = match made {
            Ok(products) => self.publish(job, products).await?,
            Err(problem) if problem.kind == ProblemKind::ShuttingDown => return self.put_back(job).await,
            Err(problem) => {
                let cancelled = problem.kind == ProblemKind::Cancelled;
                let status = if cancelled { JobStatus::Cancelled } else { JobStatus::Failed };
                tracing::info!(problem = problem.kind.slug(), detail = problem.detail, "the job ends without a result");
                Ending::without_result(status, problem.body(Some(format!("/v1/jobs/{}", job.id))))
            }
        };
        let status = ending.status;
        let keep_ms = i64::try_from(self.config.retention.as_millis()).unwrap_or(i64::MAX);
        let held = self.store.finish(job.id, job.attempt, &ending, keep_ms).await?;
        if held {
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
        let report = serde_json::to_vec_pretty(&products.report)
            .map_err(|error| StoreError::Queue(format!("the report is not JSON: {error}")))?;
        let mut files = products.files;
        files.push(Made { name: "report.json", media_type: "application/json", bytes: report });
        let mut artefacts = Artefacts::new();
        for Made { name, media_type, bytes } in files {
            let blob = format!("{}/{name}", prefix(job.id, job.attempt));
            let sha256 = hex(&Sha256::digest(&bytes));
            let artefact = Artefact { blob, sha256, bytes: bytes.len() as u64, media_type: media_type.to_owned() };
            self.store.blobs().put(&artefact.blob, Bytes::from(bytes)).await?;
            artefacts.insert(name.to_owned(), artefact);
        }
        for (stage, ms) in &products.report.timings_ms {
            let seconds = ms.as_f64().unwrap_or_default() / 1000.0;
            metrics::histogram!("quadrille_stage_seconds", "stage" => stage.clone()).record(seconds);
        }
        let timings = serde_json::json!(products.report.timings_ms);
        tracing::info!(quads = result.quads, level = result.level.name(), timings_ms = %timings, "the job has its result");
        Ok(Ending { status: JobStatus::Succeeded, result: Some(result), problem: None, artefacts, input: Some(input) })
    }

    /// An orderly shutdown is not the job's fault: it goes back in line, and the attempt does not count.
    async fn put_back(&self, job: &JobRow) -> Result<(), StoreError> {
        let number = Uuid::now_v7();
        let mut tx = self.store.write().await?;
        if jobs::put_back(&mut tx, job.id, job.attempt, number).await? {
            self.queue.enqueue(&mut tx, Ticket { job: job.id, number }, job.priority).await?;
            tracing::info!("the job goes back in line");
        }
        tx.commit().await?;
        Ok(())
    }
}

fn prefix(job: Uuid, attempt: u32) -> String {
    format!("{}/{attempt}", JobRow::blobs(job))
}

/// Lower-case hexadecimal.
pub(in crate::service) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
