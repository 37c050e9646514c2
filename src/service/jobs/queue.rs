//! Dispatch: tickets that say which job to look at next, behind a trait so that another queue can take its place.
//!
//! The engine is apalis, whose tables only apalis writes to: tickets are pushed, given back and cleared by its own
//! functions. The rules that make this reliable, each found by breaking it:
//!
//! * One ticket per fetch: those that a worker fetched ahead are not kept alive.
//! * A fresh worker name for every start: the locks of the old name would count as alive.
//! * Explicit heartbeats, and a polling strategy that is always registered with the waker ([`Every`]).
//! * The state of a job is decided by our own table and never by the ticket, which may therefore be tried without limit.
//! * The work itself runs outside of the queue's worker: one heartbeat that fails ends the worker and drops everything
//!   inside it.
//! * The queue's worker is told to stop only when no task runs: from then on it leaves its own transactions as they are,
//!   with their write lock, until its tasks have ended, which then cannot put their jobs back.

use std::future::Future;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use apalis::prelude::{
    BackendExt, BoxDynError, Data, PollSnapshot, PollStrategy, TaskBuilder, WorkerBuilder, WorkerError,
};
use apalis_core::backend::{Vacuum, WorkerFilter};
use apalis_sqlite::{Config, SqlitePool, SqliteStorage, queries};
use serde::{Deserialize, Serialize};
use sqlx::SqliteConnection;
use tokio::time::{Interval, MissedTickBehavior};
use tokio_util::sync::CancellationToken;
use tower::limit::ConcurrencyLimitLayer;
use uuid::Uuid;

use crate::service::config::JobsConfig;
use crate::service::jobs::in_work::InWork;
use crate::service::jobs::storage_retry::retry_while_storage_fails;
use crate::service::store::StoreError;

const QUEUE: &str = "remesh";
pub(super) const POLL: Duration = Duration::from_millis(150);
/// Of a ticket: as many as the queue can count. How often a job is tried is written in our own table.
const ATTEMPTS: usize = i32::MAX as usize;
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

    /// Removes used tickets.
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

    /// Gives back the tickets of a worker of this process that has ended: nobody need wait until it is taken for dead.
    /// What it had begun goes on and is not begun again ([`InWork::once`]).
    async fn release(&self, worker: &str) -> Result<(), StoreError> {
        let only = WorkerFilter::Only(worker.to_owned());
        queries::reenqueue_orphaned(&self.pool, 0, QUEUE, &only).await?;
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
        WorkerBuilder::new(name)
            .backend(backend.poll_with_strategy(Every::new(POLL)))
            .data(shared)
            .layer(ConcurrencyLimitLayer::new(self.concurrency))
            .build(take::<H>)
            .run_until(async move {
                close.cancelled().await;
                Ok::<(), WorkerError>(())
            })
            .await
    }
}

/// Wakes the worker of the queue at equal intervals. The strategy of that kind that the queue brings along is not
/// registered with the waker in the poll in which its interval ends; where a fetch outlasts the interval, nothing wakes the
/// worker after that.
#[derive(Debug)]
struct Every(Interval);

impl Every {
    fn new(pause: Duration) -> Self {
        let mut interval = tokio::time::interval(pause);
        interval.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Self(interval)
    }
}

impl PollStrategy for Every {
    fn poll_drive(&mut self, context: &mut Context<'_>, _: &PollSnapshot) -> Poll<Option<()>> {
        let mut due = Poll::Pending;
        while self.0.poll_tick(context).is_ready() {
            due = Poll::Ready(Some(()));
        }
        due
    }
}

struct Shared<H> {
    handler: Arc<H>,
    in_work: InWork,
    /// Nothing new is begun after this.
    stop: CancellationToken,
    /// No task runs after this.
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
        let task = TaskBuilder::new(payload).priority(priority).run_after(pause).max_attempts(ATTEMPTS).build();
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
                let _ = retry_while_storage_fails(None, &shared.close, || self.release(&name)).await;
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
        let mut storage = SqliteStorage::<Ticket>::new(&self.pool);
        storage.vacuum().await.map_err(|error| StoreError::Queue(error.to_string()))?;
        Ok(())
    }
}
