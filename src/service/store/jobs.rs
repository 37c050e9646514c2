//! The life of a job: accepted, claimed, noted, finished. Every write here is conditional on the state it expects.

use serde_json::{Value, json};
use sqlx::SqliteConnection;
use sqlx::sqlite::SqliteRow;
use uuid::Uuid;

use crate::service::store::{Artefacts, JobRow, NewJob, Store, StoreError, events, now_ms};
use crate::service::wire::{InputBody, JobStatus, ProblemBody, ResultBody};

/// What a ticket leads to.
#[derive(Debug)]
pub enum Claim {
    /// The job is now running as attempt `attempt` of the row.
    Run(Box<JobRow>),
    /// Finished, deleted, or started by a newer ticket: nothing to do.
    Stale,
}

/// Whether a worker still holds its job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holding {
    /// Yes; whether a client asked to cancel.
    Held {
        /// Whether a client asked to cancel.
        cancel: bool,
    },
    /// No: deleted, or taken over by another attempt.
    Lost,
}

/// How far a running attempt is.
#[derive(Clone, Copy, Debug)]
pub struct RunProgress {
    /// Name of the stage that began last.
    pub stage: Option<&'static str>,
    /// Thousandths.
    pub progress: u32,
    /// Seconds that the run is expected to take from here on.
    pub seconds_left: Option<u64>,
}

/// What a request to cancel did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cancelling {
    /// The job had not begun and is cancelled now.
    Done,
    /// The job runs; its worker was told.
    Asked,
    /// The job was finished already, which is left as it is.
    Finished,
    /// There is no such job.
    Unknown,
}

/// How a job ends.
#[derive(Clone, Debug)]
pub struct Ending {
    /// A final status.
    pub status: JobStatus,
    /// The result in numbers.
    pub result: Option<ResultBody>,
    /// Why there is none.
    pub problem: Option<ProblemBody>,
    /// The files.
    pub artefacts: Artefacts,
    /// What the run found out about the mesh.
    pub input: Option<InputBody>,
}

impl Ending {
    /// A job that ends without a result.
    pub fn without_result(status: JobStatus, problem: ProblemBody) -> Self {
        Self { status, result: None, problem: Some(problem), artefacts: Artefacts::new(), input: None }
    }
}

impl Store {
    /// The job `id`.
    pub async fn job(&self, id: Uuid) -> Result<Option<JobRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM remesh_jobs WHERE id = ?")
            .bind(id.to_string())
            .fetch_optional(self.pool())
            .await?;
        row.as_ref().map(JobRow::read).transpose()
    }

    /// The whole spec of the job `id` as JSON.
    pub async fn spec(&self, id: Uuid) -> Result<Option<String>, StoreError> {
        let spec = sqlx::query_scalar("SELECT spec FROM remesh_specs WHERE job_id = ?").bind(id.to_string());
        Ok(spec.fetch_optional(self.pool()).await?)
    }

    /// Starts the job if `ticket` is the one that may.
    pub async fn claim(&self, id: Uuid, ticket: Uuid) -> Result<Claim, StoreError> {
        let mut tx = self.write().await?;
        let row: Option<SqliteRow> = sqlx::query(
            "UPDATE remesh_jobs
             SET status = 'running', attempt = attempt + 1, stage = NULL, seconds_left = NULL, started_at = COALESCE(started_at, ?3)
             WHERE id = ?1 AND ticket = ?2 AND status IN ('queued', 'running') RETURNING *",
        )
        .bind(id.to_string())
        .bind(ticket.to_string())
        .bind(now_ms())
        .fetch_optional(&mut *tx)
        .await?;
        tx.commit().await?;
        Ok(match row {
            Some(row) => Claim::Run(Box::new(JobRow::read(&row)?)),
            None => Claim::Stale,
        })
    }

    /// Notes how far a running attempt is, with the events that led there.
    pub async fn note(
        &self,
        id: Uuid,
        attempt: u32,
        progress: &RunProgress,
        happened: &[(&'static str, Value)],
    ) -> Result<Holding, StoreError> {
        let mut tx = self.write().await?;
        let cancel: Option<bool> = sqlx::query_scalar(
            "UPDATE remesh_jobs SET stage = COALESCE(?3, stage), progress = MAX(progress, ?4), seconds_left = ?5
             WHERE id = ?1 AND attempt = ?2 AND status = 'running' RETURNING cancel_requested",
        )
        .bind(id.to_string())
        .bind(attempt)
        .bind(progress.stage)
        .bind(progress.progress)
        .bind(progress.seconds_left.map(|seconds| i64::try_from(seconds).unwrap_or(i64::MAX)))
        .fetch_optional(&mut *tx)
        .await?;
        let Some(cancel) = cancel else { return Ok(Holding::Lost) };
        for (kind, data) in happened {
            events::append(&mut tx, id, kind, data).await?;
        }
        tx.commit().await?;
        Ok(Holding::Held { cancel })
    }

    /// Ends a running attempt; `false` if it does not hold the job any more, and then nothing was changed.
    pub async fn finish(&self, id: Uuid, attempt: u32, ending: &Ending, keep_ms: i64) -> Result<bool, StoreError> {
        let now = now_ms();
        let mut tx = self.write().await?;
        let done = sqlx::query(
            "UPDATE remesh_jobs SET status = ?3, stage = NULL, seconds_left = NULL, result = ?4, problem = ?5, artefacts = ?6,
             input = COALESCE(?7, input), finished_at = ?8, expires_at = ?9,
             progress = CASE WHEN ?3 = 'succeeded' THEN 1000 ELSE progress END
             WHERE id = ?1 AND attempt = ?2 AND status = 'running'",
        )
        .bind(id.to_string())
        .bind(attempt)
        .bind(ending.status.name())
        .bind(ending.result.as_ref().map(|body| json!(body).to_string()))
        .bind(ending.problem.as_ref().map(|body| json!(body).to_string()))
        .bind(json!(ending.artefacts).to_string())
        .bind(ending.input.as_ref().map(|body| json!(body).to_string()))
        .bind(now)
        .bind(now.saturating_add(keep_ms))
        .execute(&mut *tx)
        .await?;
        if done.rows_affected() == 0 {
            return Ok(false);
        }
        events::append(&mut tx, id, ending.status.name(), &Value::Null).await?;
        tx.commit().await?;
        Ok(true)
    }

    /// Cancels waiting jobs at once, and sets the flag that the workers of running ones look at; `problem` is what their
    /// jobs show.
    pub async fn request_cancel(
        &self,
        ids: &[Uuid],
        problem: impl Fn(Uuid) -> ProblemBody,
        keep_ms: i64,
    ) -> Result<Vec<Cancelling>, StoreError> {
        let mut tx = self.write().await?;
        let mut done = Vec::with_capacity(ids.len());
        for &id in ids {
            done.push(cancel(&mut tx, id, &problem(id), keep_ms).await?);
        }
        tx.commit().await?;
        Ok(done)
    }
}

async fn cancel(
    connection: &mut SqliteConnection,
    id: Uuid,
    problem: &ProblemBody,
    keep_ms: i64,
) -> Result<Cancelling, StoreError> {
    let now = now_ms();
    let done = sqlx::query(
        "UPDATE remesh_jobs SET status = 'cancelled', cancel_requested = 1, problem = ?2, finished_at = ?3,
         expires_at = ?4 WHERE id = ?1 AND status = 'queued'",
    )
    .bind(id.to_string())
    .bind(json!(problem).to_string())
    .bind(now)
    .bind(now.saturating_add(keep_ms))
    .execute(&mut *connection)
    .await?;
    if done.rows_affected() > 0 {
        events::append(connection, id, JobStatus::Cancelled.name(), &Value::Null).await?;
        return Ok(Cancelling::Done);
    }
    let asked = sqlx::query("UPDATE remesh_jobs SET cancel_requested = 1 WHERE id = ? AND status = 'running'")
        .bind(id.to_string())
        .execute(&mut *connection)
        .await?;
    let known: bool = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM remesh_jobs WHERE id = ?)")
        .bind(id.to_string())
        .fetch_one(connection)
        .await?;
    Ok(match (asked.rows_affected() > 0, known) {
        (true, _) => Cancelling::Asked,
        (false, true) => Cancelling::Finished,
        (false, false) => Cancelling::Unknown,
    })
}

/// Accepts a job inside a transaction; the caller adds the ticket to the same one.
pub(in crate::service) async fn insert(connection: &mut SqliteConnection, job: &NewJob) -> Result<(), StoreError> {
    sqlx::query(
        "INSERT INTO remesh_jobs (id, status, ticket, priority, method, spec, tags, asset_id, input, idempotency_key,
         fingerprint, created_at) VALUES (?, 'queued', ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id.to_string())
    .bind(job.ticket.to_string())
    .bind(job.spec.priority)
    .bind(job.spec.method)
    .bind(json!(job.spec.summary).to_string())
    .bind(json!(job.spec.tags).to_string())
    .bind(job.asset_id.to_string())
    .bind(json!(job.input).to_string())
    .bind(&job.idempotency_key)
    .bind(&job.fingerprint)
    .bind(now_ms())
    .execute(&mut *connection)
    .await?;
    sqlx::query("INSERT INTO remesh_specs (job_id, spec) VALUES (?, ?)")
        .bind(job.id.to_string())
        .bind(&job.spec.text)
        .execute(&mut *connection)
        .await?;
    for tag in &job.spec.tags {
        sqlx::query("INSERT OR IGNORE INTO remesh_tags (tag, job_id) VALUES (?, ?)")
            .bind(tag)
            .bind(job.id.to_string())
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}

/// The job that this idempotency key made.
pub(in crate::service) async fn by_key(
    connection: &mut SqliteConnection,
    key: &str,
) -> Result<Option<JobRow>, StoreError> {
    let row =
        sqlx::query("SELECT * FROM remesh_jobs WHERE idempotency_key = ?").bind(key).fetch_optional(connection).await?;
    row.as_ref().map(JobRow::read).transpose()
}

/// Puts the job of a running attempt back into the queue under a new ticket without counting it as a crash, inside a
/// transaction; `false` if it does not hold the job any more. `faulty_since`: since when its storage fails.
pub(in crate::service) async fn put_back(
    connection: &mut SqliteConnection,
    job: &JobRow,
    ticket: Uuid,
    faulty_since: Option<i64>,
) -> Result<bool, StoreError> {
    let done = sqlx::query(
        "UPDATE remesh_jobs
         SET status = 'queued', stage = NULL, seconds_left = NULL, ticket = ?3, excused = excused + 1, faulty_since = ?4
         WHERE id = ?1 AND attempt = ?2 AND status = 'running'",
    )
    .bind(job.id.to_string())
    .bind(job.attempt)
    .bind(ticket.to_string())
    .bind(faulty_since)
    .execute(connection)
    .await?;
    Ok(done.rows_affected() > 0)
}
