//! Lists of jobs, page by page, and positions in the queue.

use sqlx::{QueryBuilder, Row, Sqlite, SqliteConnection};
use uuid::Uuid;

use crate::service::store::{JobRow, Store, StoreError};
use crate::service::wire::JobStatus;

/// Which jobs are meant. An empty list means all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Only jobs of one of these statuses.
    pub statuses: Vec<JobStatus>,
    /// Only jobs of one of these methods.
    pub methods: Vec<String>,
    /// Only jobs with one of these tags.
    pub tags: Vec<String>,
    /// Only jobs of this time or later, in milliseconds since 1970.
    pub created_after: Option<i64>,
    /// Only jobs from before this time, in milliseconds since 1970.
    pub created_before: Option<i64>,
    /// Only jobs older than this one.
    pub before: Option<Uuid>,
}

impl JobFilter {
    /// The newest `limit` jobs that pass, newest first.
    fn newest(&self, columns: &'static str, limit: u32) -> QueryBuilder<Sqlite> {
        let mut query = QueryBuilder::<Sqlite>::new("SELECT ");
        query.push(columns).push(" FROM remesh_jobs WHERE 1 = 1");
        if !self.statuses.is_empty() {
            one_of(query.push(" AND status IN "), self.statuses.iter().map(|status| status.name()));
        }
        if !self.methods.is_empty() {
            one_of(query.push(" AND method IN "), self.methods.iter().cloned());
        }
        if !self.tags.is_empty() {
            query.push(" AND id IN (SELECT job_id FROM remesh_tags WHERE tag IN ");
            one_of(&mut query, self.tags.iter().cloned());
            query.push(")");
        }
        if let Some(time) = self.created_after {
            query.push(" AND created_at >= ").push_bind(time);
        }
        if let Some(time) = self.created_before {
            query.push(" AND created_at < ").push_bind(time);
        }
        if let Some(before) = self.before {
            query.push(" AND id < ").push_bind(before.to_string());
        }
        query.push(" ORDER BY id DESC LIMIT ").push_bind(i64::from(limit));
        query
    }
}

fn one_of<'q, T>(query: &mut QueryBuilder<Sqlite>, values: impl Iterator<Item = T>)
where
    T: 'q + sqlx::Encode<'q, Sqlite> + sqlx::Type<Sqlite>,
{
    query.push("(");
    let mut list = query.separated(", ");
    values.for_each(|value| {
        list.push_bind(value);
    });
    query.push(")");
}

impl Store {
    /// The newest `limit` jobs that pass the filter, newest first.
    pub async fn list_jobs(&self, filter: &JobFilter, limit: u32) -> Result<Vec<JobRow>, StoreError> {
        filter.newest("*", limit).build().fetch_all(self.pool()).await?.iter().map(JobRow::read).collect()
    }

    /// The ids of the newest `limit` jobs that pass the filter, newest first.
    pub async fn job_ids(&self, filter: &JobFilter, limit: u32) -> Result<Vec<Uuid>, StoreError> {
        let ids: Vec<String> = filter.newest("id", limit).build_query_scalar().fetch_all(self.pool()).await?;
        Ok(ids.iter().filter_map(|id| id.parse().ok()).collect())
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
