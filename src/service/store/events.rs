//! What happened to a job, in order: the memory behind `Last-Event-ID`.

use serde_json::Value;
use sqlx::{Row, SqliteConnection};
use uuid::Uuid;

use crate::service::store::{Store, StoreError};

/// One event of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventRow {
    /// Number of the event within its job, from 1.
    pub seq: i64,
    /// `progress`, `stage`, or the final status.
    pub kind: String,
    /// JSON.
    pub data: String,
}

impl Store {
    /// Events of a job after number `after`, in order, at most 500.
    pub async fn events_after(&self, job: Uuid, after: i64) -> Result<Vec<EventRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT seq, kind, data FROM remesh_events WHERE job_id = ? AND seq > ? ORDER BY seq LIMIT 500",
        )
        .bind(job.to_string())
        .bind(after)
        .fetch_all(self.pool())
        .await?;
        rows.iter()
            .map(|row| {
                Ok(EventRow { seq: row.try_get("seq")?, kind: row.try_get("kind")?, data: row.try_get("data")? })
            })
            .collect()
    }
}

/// Appends an event inside a transaction.
pub(super) async fn append(
    connection: &mut SqliteConnection,
    job: Uuid,
    kind: &str,
    data: &Value,
) -> Result<(), StoreError> {
    sqlx::query(
        "INSERT INTO remesh_events (job_id, seq, kind, data)
         SELECT ?1, COALESCE(MAX(seq), 0) + 1, ?2, ?3 FROM remesh_events WHERE job_id = ?1",
    )
    .bind(job.to_string())
    .bind(kind)
    .bind(data.to_string())
    .execute(connection)
    .await?;
    Ok(())
}
