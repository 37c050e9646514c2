//! Pages of jobs and the line of the waiting ones.

use sqlx::{QueryBuilder, Row, Sqlite, SqliteConnection};
use uuid::Uuid;

use crate::service::store::{JobRow, Store, StoreError};
use crate::service::wire::JobStatus;

/// Which jobs a page shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Only jobs of this status.
    pub status: Option<JobStatus>,
    /// Only jobs of this method.
    pub method: Option<String>,
    /// Only jobs with this tag.
    pub tag: Option<String>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
}

impl Store {
    /// The newest `limit` jobs that pass the filter, newest first.
    pub async fn list_jobs(&self, filter: &JobFilter, limit: u32) -> Result<Vec<JobRow>, StoreError> {
        let mut query = QueryBuilder::<Sqlite>::new("SELECT * FROM remesh_jobs WHERE 1 = 1");
        if let Some(status) = filter.status {
            query.push(" AND status = ").push_bind(status.name());
        }
        if let Some(method) = &filter.method {
            query.push(" AND method = ").push_bind(method);
        }
        if let Some(tag) = &filter.tag {
            query.push(" AND id IN (SELECT job_id FROM remesh_tags WHERE tag = ").push_bind(tag).push(")");
        }
        if let Some(before) = filter.before {
            query.push(" AND id < ").push_bind(before.to_string());
        }
        query.push(" ORDER BY id DESC LIMIT ").push_bind(i64::from(limit));
        query.build().fetch_all(self.pool()).await?.iter().map(JobRow::read).collect()
    }

    /// How many waiting jobs a worker takes before this one; `None` unless it waits itself.
    pub async fn queue_position(&self, job: &JobRow) -> Result<Option<u64>, StoreError> {
        if job.status != JobStatus::Queued {
            return Ok(None);
        }
        let before: i64 = sqlx::query_scalar(
            "SELECT COUNT(*) FROM remesh_jobs
             WHERE status = 'queued' AND (priority > ?1 OR (priority = ?1 AND id < ?2))",
        )
        .bind(job.priority)
        .bind(job.id.to_string())
        .fetch_one(self.pool())
        .await?;
        Ok(Some(before.unsigned_abs()))
    }

    /// Number of waiting jobs, inside a transaction.
    pub async fn waiting(&self, connection: &mut SqliteConnection) -> Result<u64, StoreError> {
        let n: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM remesh_jobs WHERE status = 'queued'")
            .fetch_one(connection)
            .await?;
        Ok(n.unsigned_abs())
    }

    /// Number of jobs per status, statuses without jobs left out.
    pub async fn count_jobs(&self) -> Result<Vec<(JobStatus, u64)>, StoreError> {
        let rows =
            sqlx::query("SELECT status, COUNT(*) AS n FROM remesh_jobs GROUP BY status").fetch_all(self.pool()).await?;
        let mut counts = Vec::new();
        for row in &rows {
            let n: i64 = row.try_get("n")?;
            counts.extend(JobStatus::from_name(row.try_get("status")?).map(|status| (status, n.unsigned_abs())));
        }
        Ok(counts)
    }

    /// Finished jobs whose time is over.
    pub async fn expired_jobs(&self, now_ms: i64) -> Result<Vec<Uuid>, StoreError> {
        let ids: Vec<String> = sqlx::query_scalar("SELECT id FROM remesh_jobs WHERE expires_at <= ? LIMIT 100")
            .bind(now_ms)
            .fetch_all(self.pool())
            .await?;
        Ok(ids.iter().filter_map(|id| id.parse().ok()).collect())
    }
}
