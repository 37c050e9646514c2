//! Removing jobs and assets: rows first, in one transaction, then the blobs that no row names any more.

use std::time::Duration;

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
    /// Removes jobs, their events, their artefacts, and their meshes if those were uploaded for these jobs only. The
    /// answer has the jobs that there were. A worker that still runs one loses its hold.
    pub async fn delete_jobs(&self, ids: &[Uuid]) -> Result<Vec<Uuid>, StoreError> {
        let mut tx = self.write().await?;
        let (mut deleted, mut orphans) = (Vec::new(), Vec::new());
        for &id in ids {
            let asset: Option<String> = sqlx::query_scalar("DELETE FROM remesh_jobs WHERE id = ? RETURNING asset_id")
                .bind(id.to_string())
                .fetch_optional(&mut *tx)
                .await?;
            let Some(asset) = asset else { continue };
            let orphan: Option<String> = sqlx::query_scalar(
                "DELETE FROM assets WHERE id = ?1 AND pinned = 0
                 AND NOT EXISTS (SELECT 1 FROM remesh_jobs WHERE asset_id = ?1) RETURNING blob",
            )
            .bind(asset)
            .fetch_optional(&mut *tx)
            .await?;
            deleted.push(id);
            orphans.extend(orphan);
        }
        tx.commit().await?;
        for &id in &deleted {
            self.blobs().remove_below(&JobRow::blobs(id)).await?;
        }
        for blob in &orphans {
            self.blobs().remove(blob).await?;
        }
        Ok(deleted)
    }

    /// Removes blobs that no row names and that are older than `age`: left behind by a process that died between a row
    /// and its blob. Returns how many there were.
    pub async fn remove_orphans(&self, age: Duration) -> Result<usize, StoreError> {
        let mut removed = 0;
        for key in self.blobs().older_than("assets", age).await? {
            let known: bool = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM assets WHERE blob = ?)")
                .bind(&key)
                .fetch_one(self.pool())
                .await?;
            removed += self.remove_unless(known, &key).await?;
        }
        for key in self.blobs().older_than("jobs", age).await? {
            let known: bool = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM remesh_jobs WHERE id = ?)")
                .bind(key.split('/').nth(1))
                .fetch_one(self.pool())
                .await?;
            removed += self.remove_unless(known, &key).await?;
        }
        Ok(removed)
    }

    async fn remove_unless(&self, known: bool, key: &str) -> Result<usize, StoreError> {
        if known {
            return Ok(0);
        }
        self.blobs().remove(key).await?;
        Ok(1)
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

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;
    use crate::service::store::NewAsset;

    #[tokio::test]
    async fn only_blobs_that_nothing_names_are_orphans() {
        let folder = tempfile::tempdir().unwrap();
        let url = format!("sqlite://{}", folder.path().join("jobs.sqlite").display());
        let store = Store::open(&url, &folder.path().join("objects")).await.unwrap();
        let id = Uuid::now_v7();
        let asset = NewAsset {
            id,
            sha256: "00".to_owned(),
            bytes: 1,
            format: None,
            name: None,
            vertices: None,
            faces: None,
            blob: format!("assets/{id}"),
            pinned: true,
        };
        for key in [&asset.blob, "assets/lost", "jobs/0/1/quad-mesh.obj"] {
            store.blobs().put(key, Bytes::from_static(b"x")).await.unwrap();
        }
        store.add_asset(&asset).await.unwrap();
        assert_eq!(store.remove_orphans(Duration::from_secs(60)).await.unwrap(), 0);
        assert_eq!(store.remove_orphans(Duration::ZERO).await.unwrap(), 2);
        assert_eq!(store.blobs().get(&asset.blob).await.unwrap(), "x");
        assert!(store.blobs().get("assets/lost").await.is_err());
        assert_eq!(store.delete_asset(id).await.unwrap(), Deleted::Yes);
        assert!(store.blobs().get(&asset.blob).await.is_err());
        store.close().await;
    }
}
