//! Uploaded meshes, each stored once.

use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};
use uuid::Uuid;

use crate::service::store::{Blobs, Store, StoreError, now_ms};

/// A mesh whose bytes lie in the object store already.
#[derive(Clone, Debug)]
pub struct NewAsset {
    /// UUIDv7.
    pub id: Uuid,
    /// Lower-case hexadecimal SHA-256 of the bytes.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
    /// Name of the format.
    pub format: Option<String>,
    /// File name that the client gave.
    pub name: Option<String>,
    /// Vertices as read, where the mesh was read.
    pub vertices: Option<u64>,
    /// Faces as read, where the mesh was read.
    pub faces: Option<u64>,
    /// Where the bytes lie.
    pub blob: String,
    /// Kept until it is deleted, and not only as long as a job uses it.
    pub pinned: bool,
}

/// A stored mesh.
#[derive(Clone, Debug)]
pub struct AssetRow {
    /// UUIDv7.
    pub id: Uuid,
    /// Lower-case hexadecimal SHA-256 of the bytes.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
    /// Name of the format.
    pub format: Option<String>,
    /// File name that the client gave first.
    pub name: Option<String>,
    /// Vertices as read.
    pub vertices: Option<u64>,
    /// Faces as read.
    pub faces: Option<u64>,
    /// Where the bytes lie.
    pub blob: String,
    /// Uploaded as an asset, and not only as the mesh of a job.
    pub pinned: bool,
    /// Milliseconds since 1970.
    pub created_at: i64,
}

impl AssetRow {
    fn read(row: &SqliteRow) -> Result<Self, StoreError> {
        let id: String = row.try_get("id")?;
        let count = |n: Option<i64>| n.map(i64::unsigned_abs);
        let bytes: i64 = row.try_get("bytes")?;
        Ok(Self {
            id: id.parse().map_err(|_| StoreError::Damaged {
                id: id.clone(),
                column: "assets.id",
                detail: "not a UUID".to_owned(),
            })?,
            sha256: row.try_get("sha256")?,
            bytes: bytes.unsigned_abs(),
            format: row.try_get("format")?,
            name: row.try_get("name")?,
            vertices: count(row.try_get("vertices")?),
            faces: count(row.try_get("faces")?),
            blob: row.try_get("blob")?,
            pinned: row.try_get("pinned")?,
            created_at: row.try_get("created_at")?,
        })
    }
}

/// An asset in the database.
#[derive(Clone, Debug)]
pub(in crate::service) struct Adopted {
    pub(in crate::service) asset: AssetRow,
    /// A blob that no row names once the transaction is over; to be removed then.
    pub(in crate::service) unused: Option<String>,
}

impl Store {
    /// The asset `id`, also one that lives only as long as a job uses it.
    pub async fn asset(&self, id: Uuid) -> Result<Option<AssetRow>, StoreError> {
        let row =
            sqlx::query("SELECT * FROM assets WHERE id = ?").bind(id.to_string()).fetch_optional(self.pool()).await?;
        row.as_ref().map(AssetRow::read).transpose()
    }

    /// Adds an asset, or finds the one with the same bytes.
    pub async fn add_asset(&self, new: &NewAsset) -> Result<AssetRow, StoreError> {
        let mut tx = self.write().await?;
        let Adopted { asset, unused } = adopt(&mut tx, self.blobs(), new).await?;
        tx.commit().await?;
        if let Some(blob) = unused {
            self.blobs().remove(&blob).await?;
        }
        Ok(asset)
    }
}

/// Adds an asset, or finds the one with the same bytes, inside a transaction. If the blob of that one was lost, the new
/// one takes its place.
pub(in crate::service) async fn adopt(
    connection: &mut SqliteConnection,
    blobs: &Blobs,
    new: &NewAsset,
) -> Result<Adopted, StoreError> {
    let signed = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
    let row = sqlx::query(
        "INSERT INTO assets (id, sha256, bytes, format, name, vertices, faces, blob, pinned, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
         ON CONFLICT (sha256) DO UPDATE SET pinned = MAX(pinned, excluded.pinned) RETURNING *",
    )
    .bind(new.id.to_string())
    .bind(&new.sha256)
    .bind(signed(new.bytes))
    .bind(&new.format)
    .bind(&new.name)
    .bind(new.vertices.map(signed))
    .bind(new.faces.map(signed))
    .bind(&new.blob)
    .bind(new.pinned)
    .bind(now_ms())
    .fetch_one(&mut *connection)
    .await?;
    let mut asset = AssetRow::read(&row)?;
    if asset.blob == new.blob {
        return Ok(Adopted { asset, unused: None });
    }
    if blobs.length(&asset.blob).await? == Some(asset.bytes) {
        return Ok(Adopted { asset, unused: Some(new.blob.clone()) });
    }
    tracing::warn!(asset.id = %asset.id, "the bytes of an asset were lost and have been uploaded again");
    sqlx::query("UPDATE assets SET blob = ? WHERE id = ?")
        .bind(&new.blob)
        .bind(asset.id.to_string())
        .execute(connection)
        .await?;
    let lost = std::mem::replace(&mut asset.blob, new.blob.clone());
    Ok(Adopted { asset, unused: Some(lost) })
}
