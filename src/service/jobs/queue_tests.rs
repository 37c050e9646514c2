//! The queue under bad conditions.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use crate::service::config::Config;
use crate::service::jobs::queue::POLL;
use crate::service::jobs::{Handler, SqliteQueue, Ticket, TicketQueue};
use crate::service::store::{Store, StoreError};

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
/// stop fetching because of it.
#[tokio::test(flavor = "multi_thread")]
async fn a_slow_database_does_not_put_the_worker_to_sleep() {
    let folder = tempfile::tempdir().unwrap();
    let mut settings = Config::for_testing(folder.path());
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
        queue
            .enqueue(&mut tx, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0, Duration::ZERO)
            .await
            .unwrap();
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
struct Waiting {
    begun: tokio::sync::Semaphore,
    may_end: tokio::sync::Semaphore,
    ended: std::sync::atomic::AtomicUsize,
}

impl Handler for Waiting {
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
    let mut settings = Config::for_testing(folder.path());
    settings.jobs.heartbeat = Duration::from_secs(1);
    settings.jobs.missed_heartbeats = 1;
    let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
    let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
    let none = || tokio::sync::Semaphore::new(0);
    let handler = Arc::new(Waiting { begun: none(), may_end: none(), ended: 0.into() });
    let stop = CancellationToken::new();
    let working = {
        let (queue, handler, stop) = (queue.clone(), Arc::clone(&handler), stop.clone());
        tokio::spawn(async move { queue.work(handler, stop).await })
    };
    let mut tx = store.write().await.unwrap();
    queue.enqueue(&mut tx, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0, Duration::ZERO).await.unwrap();
    tx.commit().await.unwrap();
    handler.begun.acquire().await.unwrap().forget();

    let workers = |sql: &'static str| sqlx::query_scalar::<_, i64>(sql).fetch_one(store.pool());
    sqlx::query("ALTER TABLE Workers RENAME TO Lost").execute(store.pool()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(1500)).await;
    sqlx::query("ALTER TABLE Lost RENAME TO Workers").execute(store.pool()).await.unwrap();
    let mut moved = 0;
    for _ in 0..1500 {
        // The second worker has the ticket.
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
    assert_eq!((handler.begun.available_permits(), handler.ended.load(std::sync::atomic::Ordering::SeqCst)), (0, 1));
    store.close().await;
}

/// Writes when the end has come.
struct LastWord {
    store: Store,
    stop: CancellationToken,
    begun: tokio::sync::Semaphore,
    written: std::sync::atomic::AtomicUsize,
}

impl Handler for LastWord {
    async fn handle(&self, _: Ticket) -> Result<(), StoreError> {
        self.begun.add_permits(1);
        self.stop.cancelled().await;
        self.store.write().await?.commit().await?;
        self.written.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
        Ok(())
    }
}

/// The queue has a transaction of its own open nearly always, so also when the end comes.
#[tokio::test(flavor = "multi_thread")]
async fn at_the_end_the_queue_is_not_in_the_way_of_the_last_word() {
    for _ in 0..5 {
        let folder = tempfile::tempdir().unwrap();
        let mut settings = Config::for_testing(folder.path());
        settings.jobs.heartbeat = Duration::from_millis(1);
        settings.jobs.missed_heartbeats = 100_000;
        let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
        let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
        let stop = CancellationToken::new();
        let handler = Arc::new(LastWord {
            store: store.clone(),
            stop: stop.clone(),
            begun: tokio::sync::Semaphore::new(0),
            written: 0.into(),
        });
        let mut tx = store.write().await.unwrap();
        for _ in 0..3 {
            queue
                .enqueue(&mut tx, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0, Duration::ZERO)
                .await
                .unwrap();
        }
        tx.commit().await.unwrap();
        let working = {
            let (queue, handler, stop) = (queue.clone(), Arc::clone(&handler), stop.clone());
            tokio::spawn(async move { queue.work(handler, stop).await })
        };
        handler.begun.acquire().await.unwrap().forget();
        stop.cancel();
        working.await.unwrap();
        let written = handler.written.load(std::sync::atomic::Ordering::SeqCst);
        assert_eq!(written, 1 + handler.begun.available_permits(), "all that begun have written");
        // What had not begun is there for the next process.
        let used: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM Jobs WHERE status = 'Done'")
            .fetch_one(store.pool())
            .await
            .unwrap();
        assert_eq!(used, i64::try_from(written).unwrap());
        store.close().await;
    }
}

#[tokio::test]
async fn refused_tickets_come_again_and_used_ones_are_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let settings = Config::for_testing(folder.path());
    let store = Store::open(&settings.database_url, &settings.store).await.unwrap();
    let queue = SqliteQueue::open(store.pool(), &settings.jobs).await.unwrap();
    let tickets = [-7, 7].map(|priority| (Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, priority));
    let mut tx = store.write().await.unwrap();
    for (ticket, priority) in tickets {
        queue.enqueue(&mut tx, ticket, priority, Duration::ZERO).await.unwrap();
    }
    tx.commit().await.unwrap();
    let mut lost = store.write().await.unwrap();
    queue.enqueue(&mut lost, Ticket { job: Uuid::now_v7(), number: Uuid::now_v7() }, 0, Duration::ZERO).await.unwrap();
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
