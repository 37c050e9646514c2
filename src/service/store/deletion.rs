//! Removing jobs and assets: rows first, in one transaction, then the blobs that no row names any more.

use uuid::Uuid;

use crate::service::store::{JobRow, Store, StoreError};

/// What became of a request to delete an asset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deleted {
    /// It is gone.
    Yes,
    /// A job that has not finished uses it.
    InUse,
    /// There is no such asset.
    Unknown,
}

impl Store {
    /// Removes a job, its events, its artefacts, and its mesh if that was uploaded for this job only. `false` if there
    /// is no such job. A worker that still runs it loses its hold.
    pub async fn delete_job(&self, id: Uuid) -> Result<bool, StoreError> {
        let mut tx = self.write().await?;
        let asset: Option<String> = sqlx::query_scalar("DELETE FROM remesh_jobs WHERE id = ? RETURNING asset_id")
            .bind(id.to_string())
            .fetch_optional(&mut *tx)
            .await?;
        let Some(asset) = asset else { return Ok(false) };
        let orphan: Option<String> = sqlx::query_scalar(
            "DELETE FROM assets WHERE id = ?1 AND pinned = 0
             AND NOT EXISTS (SELECT 1 FROM remesh_jobs WHERE asset_id = ?1) RETURNING blob",
        )
        .bind(asset)
        .fetch_optional(&mut *tx)
        .await?;
        tx.commit().await?;
        self.blobs().remove_below(&JobRow::blobs(id)).await?;
        if let Some(blob) = orphan {
            self.blobs().remove(&blob).await?;
        }
        Ok(true)
    }

    /// Removes an asset unless a job that has not finished uses it. Finished jobs keep the bytes until they go.
    pub async fn delete_asset(&self, id: Uuid) -> Result<Deleted, StoreError> {
        let mut tx = self.write().await?;
        let in_use: bool = sqlx::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM remesh_jobs WHERE asset_id = ? AND status IN ('queued', 'running'))",
        )
        .bind(id.to_string())
        .fetch_one(&mut *tx)
        .await?;
        if in_use {
            return Ok(Deleted::InUse);
        }
        let known = sqlx::query("UPDATE assets SET pinned = 0 WHERE id = ? AND pinned = 1")
            .bind(id.to_string())
            .execute(&mut *tx)
            .await?;
        if known.rows_affected() == 0 {
            return Ok(Deleted::Unknown);
        }
        let orphan: Option<String> = sqlx::query_scalar(
            "DELETE FROM assets WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM remesh_jobs WHERE asset_id = ?1)
             RETURNING blob",
        )
        .bind(id.to_string())
        .fetch_optional(&mut *tx)
        .await?;
        tx.commit().await?;
        if let Some(blob) = orphan {
            self.blobs().remove(&blob).await?;
        }
        Ok(Deleted::Yes)
    }
}
