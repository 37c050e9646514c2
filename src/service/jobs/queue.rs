//! Dispatch: tickets that say which job to look at next, behind a trait so that another queue can take its place.
//!
//! The rules that make this reliable, each found by breaking it: one ticket per fetch (buffered ones are not kept alive),
//! a fresh worker name for every start (the old name's locks would count as alive), explicit heartbeats, an interval
//! poll of our own (the queue's loses its wake-up for ever when a fetch takes longer than the interval while a heartbeat
//! falls due, as on a busy machine), the final word about a job in our own table and never in the ticket (the queue does
//! not limit the attempts of a ticket that was recovered from a dead worker), the work itself outside of the queue's
//! worker (one heartbeat that fails ends the worker and drops everything inside it).

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
use crate::service::store::StoreError;

const QUEUE: &str = "remesh";
const POLL: Duration = Duration::from_millis(150);
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
    /// Adds a ticket inside the caller's transaction. Priorities are −100 to 100; higher comes earlier.
    fn enqueue(
        &self,
        connection: &mut SqliteConnection,
        ticket: Ticket,
        priority: i32,
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

    async fn one_worker<H: Handler>(&self, hands: Hands<H>, stop: CancellationToken) -> Result<(), WorkerError> {
        let config = Config::default()
            .queue(QUEUE)
            .batch_size(1)
            .heartbeat_interval(self.heartbeat)
            .missed_heartbeats(self.missed_heartbeats);
        let backend = SqliteStorage::<Ticket>::new(&self.pool).with_config(config);
        let name = format!("quadrille-{}", Uuid::now_v7());
        let worker = WorkerBuilder::new(name.as_str())
            .backend(backend)
            .data(hands)
            .layer(ConcurrencyLimitLayer::new(self.concurrency))
            .build(take::<H>)
            .run_until(async move {
                stop.cancelled().await;
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

struct Hands<H> {
    handler: Arc<H>,
    in_work: InWork,
}

impl<H> Clone for Hands<H> {
    fn clone(&self) -> Self {
        Self { handler: Arc::clone(&self.handler), in_work: self.in_work.clone() }
    }
}

async fn take<H: Handler>(ticket: Ticket, hands: Data<Hands<H>>) -> Result<(), BoxDynError> {
    let handler = Arc::clone(&hands.handler);
    let work = async move { handler.handle(ticket).await };
    hands.in_work.once(ticket.number, work).await.map_err(|error| {
        tracing::error!(job.id = %ticket.job, %error, "the ticket goes back to the queue");
        error.into()
    })
}

impl TicketQueue for SqliteQueue {
    async fn enqueue(
        &self,
        connection: &mut SqliteConnection,
        ticket: Ticket,
        priority: i32,
    ) -> Result<(), StoreError> {
        let payload = serde_json::to_vec(&ticket).map_err(|error| StoreError::Queue(error.to_string()))?;
        let task = TaskBuilder::new(payload).priority((priority + 100).max(0).unsigned_abs() as usize).build();
        apalis_sqlite::queries::push_tasks(connection, QUEUE, &[task])
            .await
            .map_err(|error| StoreError::Queue(error.to_string()))
    }

    async fn work<H: Handler>(&self, handler: Arc<H>, stop: CancellationToken) {
        let hands = Hands { handler, in_work: InWork::new(self.concurrency) };
        while !stop.is_cancelled() {
            match self.one_worker(hands.clone(), stop.clone()).await {
                Ok(()) if stop.is_cancelled() => break,
                Ok(()) => tracing::warn!("the worker of the queue ended; starting another one"),
                Err(error) => tracing::warn!(%error, "the worker of the queue failed; starting another one"),
            }
            tokio::time::sleep(RESTART_PAUSE).await;
        }
        hands.in_work.over().await;
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

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::service::config::Config as Settings;
    use crate::service::store::Store;

    /// Notes the tickets; refuses each one the first time.
    #[derive(Default)]
    struct Reluctant(Mutex<Vec<Ticket>>);

    impl Reluctant {
        fn seen(&self) -> Vec<Ticket> {
            self.0.lock().unwrap().clone()
        }
    }

    impl Handler for Reluctant {
        async fn handle(&self, ticket: Ticket) -> Result<(), StoreError> {
            let mut seen = self.0.lock().unwrap();
            let refused = !seen.contains(&ticket);
            seen.push(ticket);
            if refused { Err(StoreError::Queue("on purpose".to_owned())) } else { Ok(()) }
        }
    }

    /// Other writers hold the database for longer than a poll and many heartbeats, again and again; the worker must not
    /// fall asleep over it.
    #[tokio::test(flavor = "multi_thread")]
    async fn a_slow_database_does_not_put_the_worker_to_sleep() {
        let folder = tempfile::tempdir().unwrap();
        let mut settings = Settings::for_testing(folder.path());
        settings.jobs.heartbeat = Duration::from_millis(40);
        settings.jobs.missed_heartbeats = 1000;
        let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
        let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
        let (handler, stop) = (Arc::new(Reluctant::default()), CancellationToken::new());
        let working = {
            let (queue, handler, stop) = (queue.clone(), Arc::clone(&handler), stop.clone());
            tokio::spawn(async move { queue.work(handler, stop).await })
        };
        for round in 1..=5 {
            let mut tx = store.write().await.unwrap();
            tokio::time::sleep(2 * POLL).await;
            queue.enqueue(&mut tx, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0).await.unwrap();
            tx.commit().await.unwrap();
            for _ in 0..3000 {
                if handler.seen().len() >= 2 * round {
                    break;
                }
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
            assert_eq!(handler.seen().len(), 2 * round);
        }
        stop.cancel();
        working.await.unwrap();
        store.close().await;
    }

    /// Says when it begins, and works until it may end.
    struct Patient {
        begun: tokio::sync::Semaphore,
        may_end: tokio::sync::Semaphore,
        ended: std::sync::atomic::AtomicUsize,
    }

    impl Handler for Patient {
        async fn handle(&self, _: Ticket) -> Result<(), StoreError> {
            self.begun.add_permits(1);
            let _permit = self.may_end.acquire().await;
            self.ended.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
            Ok(())
        }
    }

    /// The queue loses its table while a ticket is in work: its worker dies of the next heartbeat, the work does not, is
    /// not begun a second time when the ticket is found again, and is waited for at the end.
    #[tokio::test(flavor = "multi_thread")]
    async fn work_outlives_the_worker_of_the_queue() {
        let folder = tempfile::tempdir().unwrap();
        let mut settings = Settings::for_testing(folder.path());
        settings.jobs.heartbeat = Duration::from_secs(1);
        settings.jobs.missed_heartbeats = 1;
        let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
        let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
        let none = || tokio::sync::Semaphore::new(0);
        let handler = Arc::new(Patient { begun: none(), may_end: none(), ended: 0.into() });
        let stop = CancellationToken::new();
        let working = {
            let (queue, handler, stop) = (queue.clone(), Arc::clone(&handler), stop.clone());
            tokio::spawn(async move { queue.work(handler, stop).await })
        };
        let mut tx = store.write().await.unwrap();
        queue.enqueue(&mut tx, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0).await.unwrap();
        tx.commit().await.unwrap();
        handler.begun.acquire().await.unwrap().forget();

        let workers = |sql: &'static str| sqlx::query_scalar::<_, i64>(sql).fetch_one(store.pool());
        sqlx::query("ALTER TABLE Workers RENAME TO Lost").execute(store.pool()).await.unwrap();
        tokio::time::sleep(Duration::from_millis(1500)).await;
        sqlx::query("ALTER TABLE Lost RENAME TO Workers").execute(store.pool()).await.unwrap();
        let mut moved = 0;
        for _ in 0..1500 {
            // The ticket is in the hands of the second worker.
            moved = workers(
                "SELECT COUNT(*) FROM Jobs JOIN Workers ON lock_by = Workers.id WHERE status = 'Running'
                 AND (SELECT COUNT(*) FROM Workers) > 1 AND Workers.last_seen = (SELECT MAX(last_seen) FROM Workers)",
            )
            .await
            .unwrap();
            if moved > 0 {
                break;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        assert_eq!(moved, 1, "found again");
        stop.cancel();
        tokio::time::sleep(2 * POLL).await;
        assert!(!working.is_finished(), "the work is waited for");
        handler.may_end.add_permits(10);
        working.await.unwrap();
        assert_eq!(
            (handler.begun.available_permits(), handler.ended.load(std::sync::atomic::Ordering::SeqCst)),
            (0, 1)
        );
        store.close().await;
    }

    #[tokio::test]
    async fn refused_tickets_come_again_and_used_ones_are_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings::for_testing(folder.path());
        let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
        let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
        let tickets = [-7, 7].map(|priority| (Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, priority));
        let mut tx = store.write().await.unwrap();
        for (ticket, priority) in tickets {
            queue.enqueue(&mut tx, ticket, priority).await.unwrap();
        }
        tx.commit().await.unwrap();
        let mut lost = store.write().await.unwrap();
        queue.enqueue(&mut lost, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0).await.unwrap();
        lost.rollback().await.unwrap();

        let (handler, stop) = (Arc::new(Reluctant::default()), CancellationToken::new());
        let working = {
            let (queue, handler, stop) = (queue.clone(), Arc::clone(&handler), stop.clone());
            tokio::spawn(async move { queue.work(handler, stop).await })
        };
        for _ in 0..3000 {
            if handler.seen().len() >= 4 {
                break;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        stop.cancel();
        working.await.unwrap();
        let (low, high) = (tickets[0].0, tickets[1].0);
        let seen = handler.seen();
        assert_eq!(seen[0], high, "higher priority first");
        assert_eq!(seen.len(), 4, "each twice, and nothing of the transaction that was rolled back");
        assert_eq!(seen.iter().filter(|&&ticket| ticket == low).count(), 2);
        queue.tidy().await.unwrap();
        let left: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM Jobs").fetch_one(store.pool()).await.unwrap();
        assert_eq!(left, 0);
        store.close().await;
    }
}
