//! What happens to one ticket.

use std::sync::Arc;

use bytes::Bytes;
use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use crate::engine::run::{RunContext, StopReason};
use crate::service::config::JobsConfig;
use crate::service::jobs::recorder::{self, Recorder};
use crate::service::jobs::storage_retry::retry_while_storage_fails;
use crate::service::jobs::{Driver, EnginePool, Handler, InputFile, Live, Products, Ticket, TicketQueue, run_blocking};
use crate::service::store::{AssetRow, Claim, JobRow, Store, StoreError};
use crate::service::wire::{Problem, ProblemKind, ResolvedSpec};

/// Runs jobs one ticket at a time.
#[derive(Clone)]
pub struct Worker<Q> {
    /// Rows and blobs.
    pub store: Store,
    /// Where interrupted jobs go back to.
    pub queue: Q,
    /// Runs and changes within this process.
    pub live: Live,
    /// The engine's threads.
    pub pool: EnginePool,
    /// The way from bytes to files.
    pub driver: Arc<dyn Driver>,
    /// Attempts, retention, and how long a failing storage is waited for.
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
        let claim = || self.store.claim(ticket.job, ticket.number);
        let Claim::Run(mut job) = retry_while_storage_fails(None, &self.stop, claim).await? else {
            tracing::debug!(job.id = %ticket.job, "a ticket without a job");
            return Ok(());
        };
        self.live.notify(job.id);
        let span = tracing::info_span!("job", job.id = %job.id, attempt = job.attempt, method = job.method);
        let result = async {
            match self.attempt(&mut job).await {
                Err(error) if error.is_of_storage() => self.wait(&job, &error).await,
                ended => ended,
            }
        }
        .instrument(span)
        .await;
        self.live.notify(ticket.job);
        result
    }
}

impl<Q: TicketQueue + 'static> Worker<Q> {
    async fn attempt(&self, job: &mut JobRow) -> Result<(), StoreError> {
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

    async fn run(&self, job: &mut JobRow) -> Result<Result<Products, Problem>, StoreError> {
        let text = self.store.spec(job.id).await?.unwrap_or_default();
        let spec = match run_blocking(move || ResolvedSpec::from_json(text.as_bytes())).await {
            Ok(spec) => spec,
            // Accepted by an older version.
            Err(problem) => return Ok(Err(problem)),
        };
        let Some(asset) = self.store.asset(job.asset_id).await? else {
            return Ok(Err(Problem::new(ProblemKind::NotFound, "The mesh of this job is gone.")));
        };
        let bytes = self.input(&asset).await?;
        job.faulty_since = None;
        let input = InputFile { bytes, name: asset.name, format: job.input.format.clone() };

        let (listener, steps) = recorder::channel();
        let context = RunContext::new(spec.spec.seed, listener);
        let _running = self.live.enter(job.id, context.clone());
        if self.stop.is_cancelled() {
            context.stop(StopReason::Shutdown);
        }
        let record = Recorder {
            store: self.store.clone(),
            live: self.live.clone(),
            job: job.id,
            attempt: job.attempt,
            before: job.progress,
            context: context.clone(),
        };
        let done = CancellationToken::new();
        let over = done.clone().drop_guard();
        let record = tokio::spawn(record.keep(steps, done));

        let driver = Arc::clone(&self.driver);
        let run = context.clone();
        let made = self.pool.run(&context, move || driver.run(&run, &input, &spec)).await;

        drop(over);
        let _ = record.await;
        Ok(made)
    }

    /// The whole upload.
    async fn input(&self, asset: &AssetRow) -> Result<Bytes, StoreError> {
        let bytes = self.store.blobs().get(&asset.blob).await?;
        let found = bytes.len() as u64;
        if found == asset.bytes {
            return Ok(bytes);
        }
        Err(StoreError::Truncated { key: asset.blob.clone(), found, expected: asset.bytes })
    }
}

/// Lower-case hexadecimal.
pub(in crate::service) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
