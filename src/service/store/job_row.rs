//! A job as it lies in the database.

use serde::de::DeserializeOwned;
use sqlx::Row;
use sqlx::sqlite::SqliteRow;
use uuid::Uuid;

use crate::service::store::{Artefacts, StoreError};
use crate::service::wire::{InputBody, JobStatus, ProblemBody, ResultBody, SpecDocument, SpecSummary};

/// What must be known to accept a job.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// UUIDv7, so ids are in order of creation.
    pub id: Uuid,
    /// The ticket that may start the job.
    pub ticket: Uuid,
    /// The spec.
    pub spec: SpecDocument,
    /// The mesh.
    pub asset_id: Uuid,
    /// What is known of the mesh.
    pub input: InputBody,
    /// The client's key, where one was given.
    pub idempotency_key: Option<String>,
    /// Hash of all that makes two requests the same.
    pub fingerprint: String,
}

/// One job.
#[derive(Clone, Debug)]
pub struct JobRow {
    /// UUIDv7.
    pub id: Uuid,
    /// Where the job is in its life.
    pub status: JobStatus,
    /// Stage of the run.
    pub stage: Option<String>,
    /// Thousandths.
    pub progress: u32,
    /// Seconds that the run is expected to take from here on; only while it runs.
    pub seconds_left: Option<u64>,
    /// How often a worker began.
    pub attempt: u32,
    /// Attempts that ended by an orderly shutdown or because the storage failed.
    pub excused: u32,
    /// Since when its storage fails, in milliseconds since 1970.
    pub faulty_since: Option<i64>,
    /// Whether a client asked to cancel.
    pub cancel_requested: bool,
    /// Higher runs earlier.
    pub priority: i32,
    /// Name of the method.
    pub method: String,
    /// The spec in short; see [`Store::spec`](crate::service::store::Store::spec) for the whole of it.
    pub spec: SpecSummary,
    /// Labels.
    pub tags: Vec<String>,
    /// The mesh.
    pub asset_id: Uuid,
    /// What is known of the mesh.
    pub input: InputBody,
    /// The result in numbers.
    pub result: Option<ResultBody>,
    /// Why there is none.
    pub problem: Option<ProblemBody>,
    /// The files.
    pub artefacts: Artefacts,
    /// Hash of all that makes two requests the same.
    pub fingerprint: String,
    /// Milliseconds since 1970.
    pub created_at: i64,
    /// Milliseconds since 1970; the first attempt.
    pub started_at: Option<i64>,
    /// Milliseconds since 1970.
    pub finished_at: Option<i64>,
    /// Milliseconds since 1970.
    pub expires_at: Option<i64>,
}

impl JobRow {
    /// Key prefix of everything that the job's attempts write.
    pub fn blobs(id: Uuid) -> String {
        format!("jobs/{id}")
    }

    pub(super) fn read(row: &SqliteRow) -> Result<Self, StoreError> {
        let id: String = row.try_get("id")?;
        let damaged = |column, detail: String| StoreError::Damaged { id: id.clone(), column, detail };
        let status: String = row.try_get("status")?;
        let artefacts: Option<Artefacts> = optional_json(row, &id, "artefacts")?;
        Ok(Self {
            id: uuid_of(&id).ok_or_else(|| damaged("id", "not a UUID".to_owned()))?,
            status: JobStatus::from_name(&status).ok_or_else(|| damaged("status", status.clone()))?,
            stage: row.try_get("stage")?,
            progress: row.try_get("progress")?,
            seconds_left: row.try_get::<Option<i64>, _>("seconds_left")?.and_then(|seconds| seconds.try_into().ok()),
            attempt: row.try_get("attempt")?,
            excused: row.try_get("excused")?,
            faulty_since: row.try_get("faulty_since")?,
            cancel_requested: row.try_get("cancel_requested")?,
            priority: row.try_get("priority")?,
            method: row.try_get("method")?,
            spec: json(row, &id, "spec")?,
            tags: json(row, &id, "tags")?,
            asset_id: uuid_of(row.try_get("asset_id")?).ok_or_else(|| damaged("asset_id", "not a UUID".to_owned()))?,
            input: json(row, &id, "input")?,
            result: optional_json(row, &id, "result")?,
            problem: optional_json(row, &id, "problem")?,
            artefacts: artefacts.unwrap_or_default(),
            fingerprint: row.try_get("fingerprint")?,
            created_at: row.try_get("created_at")?,
            started_at: row.try_get("started_at")?,
            finished_at: row.try_get("finished_at")?,
            expires_at: row.try_get("expires_at")?,
        })
    }
}

fn uuid_of(text: &str) -> Option<Uuid> {
    text.parse().ok()
}

fn json<T: DeserializeOwned>(row: &SqliteRow, id: &str, column: &'static str) -> Result<T, StoreError> {
    parse(row.try_get(column)?, id, column)
}

fn optional_json<T: DeserializeOwned>(
    row: &SqliteRow,
    id: &str,
    column: &'static str,
) -> Result<Option<T>, StoreError> {
    let text: Option<&str> = row.try_get(column)?;
    text.map(|text| parse(text, id, column)).transpose()
}

fn parse<T: DeserializeOwned>(text: &str, id: &str, column: &'static str) -> Result<T, StoreError> {
    serde_json::from_str(text).map_err(|error| StoreError::Damaged {
        id: id.to_owned(),
        column,
        detail: error.to_string(),
    })
}
