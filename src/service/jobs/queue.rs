//! Dispatch: tickets that say which job to look at next, behind a trait so that another queue can take its place.
//!
//! The rules that make this reliable, each found by breaking it: one ticket per fetch (buffered ones are not kept alive),
//! a fresh worker name for every start (the old name's locks would count as alive), explicit heartbeats, an interval
//! poll of our own (the queue's loses its wake-up for ever when a fetch takes longer than the interval while a heartbeat
//! falls due, as on a busy machine), the final word about a job in our own table and never in the ticket (the queue does
//! not limit the attempts of a ticket that was recovered from a dead worker), the work itself outside of the queue's
//! worker (one heartbeat that fails ends the worker and drops everything inside it), the queue's worker told to stop
//! only when nothing is in work (from then on it leaves its own transactions as they are, write lock and all, until its
//! tasks have ended, which then cannot put their jobs back).

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use apalis::prelude::{BoxDynError, Data, TaskBuilder, WorkerBuilder, WorkerError};
use apalis_sqlite::{Config, SqlitePool, SqliteStorage};
use serde::{Deserialize, Serialize};
use sqlx::SqliteConnection;
use tokio_util::sync::CancellationToken;
use tower::limit::ConcurrencyLimitLayer;
use uuid::Uuid;

use crate::service::config::JobsConfig;
use crate::service::jobs::in_work::InWork;
use crate::service::jobs::patience::patiently;
use crate::service::store::StoreError;

const QUEUE: &str = "remesh";
pub(super) const POLL: Duration = Duration::from_millis(150);
/// Pause after a worker of the queue died, e.g. because the database was locked for too long.
const RESTART_PAUSE: Duration = Duration::from_millis(500);

/// Permission to start one attempt of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ticket {
    /// The job.
    pub job: Uuid,
    /// Must equal the ticket in the job's row; an older ticket starts nothing.
    pub number: Uuid,
}

/// What is done with a ticket. An error gives the ticket back to the queue.
pub trait Handler: Send + Sync + 'static {
    /// Does the work of one ticket.
    fn handle(&self, ticket: Ticket) -> impl Future<Output = Result<(), StoreError>> + Send;
}

/// A queue of tickets.
pub trait TicketQueue: Send + Sync {
    /// Adds a ticket inside the caller's transaction, which is handed out after `pause`. Priorities are −100 to 100;
    /// higher comes earlier.
    fn enqueue(
        &self,
        connection: &mut SqliteConnection,
        ticket: Ticket,
        priority: i32,
        pause: Duration,
    ) -> impl Future<Output = Result<(), StoreError>> + Send;

    /// Hands tickets to `handler` until `stop`, then waits for those in work.
    fn work<H: Handler>(&self, handler: Arc<H>, stop: CancellationToken) -> impl Future<Output = ()> + Send;

    /// Forgets tickets that were used up, and gives those another chance that failed too often: the word about a job is
    /// in our table.
    fn tidy(&self) -> impl Future<Output = Result<(), StoreError>> + Send;
}

/// The queue in the same SQLite file as the jobs.
#[derive(Clone, Debug)]
pub struct SqliteQueue {
    pool: SqlitePool,
    heartbeat: Duration,
    missed_heartbeats: usize,
    concurrency: usize,
}

impl SqliteQueue {
    /// Prepares the tables of the queue.
    pub async fn open(pool: &SqlitePool, config: &JobsConfig) -> Result<Self, StoreError> {
        SqliteStorage::migrations().run(pool).await?;
        Ok(Self {
            pool: pool.clone(),
            heartbeat: config.heartbeat,
            missed_heartbeats: config.missed_heartbeats as usize,
            concurrency: config.workers,
        })
    }

    /// Gives back the tickets that a worker of this process had fetched and not begun, and would never begin: nobody
    /// need wait until it is taken for dead. Those that it had begun are still in work.
    async fn release(&self, worker: &str) -> Result<(), StoreError> {
        sqlx::query(
            "UPDATE Jobs SET status = 'Pending', lock_by = NULL, lock_at = NULL WHERE lock_by = ? AND status = 'Queued'",
        )
        .bind(worker)
        .execute(&self.pool)
        .await?;
        Ok(())
    }

    async fn one_worker<H: Handler>(&self, name: &str, shared: Shared<H>) -> Result<(), WorkerError> {
        let close = shared.close.clone();
        let config = Config::default()
            .queue(QUEUE)
            .batch_size(1)
            .heartbeat_interval(self.heartbeat)
            .missed_heartbeats(self.missed_heartbeats);
        let backend = SqliteStorage::<Ticket>::new(&self.pool).with_config(config);
        let worker = WorkerBuilder::new(name)
            .backend(backend)
            .data(shared)
            .layer(ConcurrencyLimitLayer::new(self.concurrency))
            .build(take::<H>)
            .run_until(async move {
                close.cancelled().await;
                Ok::<(), WorkerError>(())
            });
        let mut worker = std::pin::pin!(worker);
        loop {
            // Every turn polls the worker whether it was woken or not: fetches, heartbeats, acknowledgements.
            tokio::select! {
                ended = &mut worker => return ended,
                () = tokio::time::sleep(POLL) => {}
            }
        }
    }
}

struct Shared<H> {
    handler: Arc<H>,
    in_work: InWork,
    /// Nothing new is begun after this.
    stop: CancellationToken,
    /// Nothing is in work after this.
    close: CancellationToken,
}

impl<H> Clone for Shared<H> {
    fn clone(&self) -> Self {
        Self {
            handler: Arc::clone(&self.handler),
            in_work: self.in_work.clone(),
            stop: self.stop.clone(),
            close: self.close.clone(),
        }
    }
}

async fn take<H: Handler>(ticket: Ticket, shared: Data<Shared<H>>) -> Result<(), BoxDynError> {
    if shared.stop.is_cancelled() {
        // Kept until the end, or it would be fetched again and again.
        shared.close.cancelled().await;
        return Err("the ticket came during the shutdown".into());
    }
    let handler = Arc::clone(&shared.handler);
    let work = async move { handler.handle(ticket).await };
    let done = shared.in_work.once(ticket.number, work).await;
    if let Err(error) = &done {
        tracing::error!(job.id = %ticket.job, %error, "the ticket goes back to the queue");
        // The queue hands it out again at once.
        let _ = tokio::time::timeout(RESTART_PAUSE, shared.stop.cancelled()).await;
    }
    Ok(done?)
}

impl TicketQueue for SqliteQueue {
    async fn enqueue(
        &self,
        connection: &mut SqliteConnection,
        ticket: Ticket,
        priority: i32,
        pause: Duration,
    ) -> Result<(), StoreError> {
        let payload = serde_json::to_vec(&ticket).map_err(|error| StoreError::Queue(error.to_string()))?;
        let priority = (priority + 100).max(0).unsigned_abs() as usize;
        let task = TaskBuilder::new(payload).priority(priority).run_after(pause).build();
        apalis_sqlite::queries::push_tasks(connection, QUEUE, &[task])
            .await
            .map_err(|error| StoreError::Queue(error.to_string()))
    }

    async fn work<H: Handler>(&self, handler: Arc<H>, stop: CancellationToken) {
        let in_work = InWork::new(self.concurrency);
        let shared = Shared { handler, in_work, stop: stop.clone(), close: CancellationToken::new() };
        let workers = async {
            loop {
                let name = format!("quadrille-{}", Uuid::now_v7());
                let ended = self.one_worker(&name, shared.clone()).await;
                if shared.close.is_cancelled() {
                    break;
                }
                match ended {
                    Ok(()) => tracing::warn!("the worker of the queue ended; starting another one"),
                    Err(error) => tracing::warn!(%error, "the worker of the queue failed; starting another one"),
                }
                tokio::time::sleep(RESTART_PAUSE).await;
                // The next worker cannot begin either before the database can be written to.
                let _ = patiently(None, &shared.close, || self.release(&name)).await;
            }
        };
        // Both in one task: `take` either begins its work before this looks, or sees that the end has come.
        let end = async {
            stop.cancelled().await;
            shared.in_work.over().await;
            shared.close.cancel();
        };
        tokio::join!(workers, end);
    }

    async fn tidy(&self) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM Jobs WHERE job_type = ? AND status IN ('Done', 'Killed')")
            .bind(QUEUE)
            .execute(&self.pool)
            .await?;
        sqlx::query(
            "UPDATE Jobs SET status = 'Pending', attempts = 0, lock_by = NULL, lock_at = NULL, done_at = NULL
             WHERE job_type = ? AND status = 'Failed' AND attempts >= max_attempts",
        )
        .bind(QUEUE)
        .execute(&self.pool)
        .await?;
        // Locks of tickets point at workers, so only workers without any ticket go.
        sqlx::query(
            "DELETE FROM Workers WHERE worker_type = ? AND last_seen < strftime('%s', 'now') - 3600
             AND NOT EXISTS (SELECT 1 FROM Jobs WHERE lock_by = Workers.id)",
        )
        .bind(QUEUE)
        .execute(&self.pool)
        .await?;
        Ok(())
    }
}
