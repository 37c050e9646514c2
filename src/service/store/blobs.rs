//! Bytes by key.

use std::ops::Range;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures_util::stream::BoxStream;
use futures_util::{StreamExt, TryStreamExt};
use object_store::buffered::BufWriter;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{GetOptions, GetRange, ObjectStore, ObjectStoreExt, PutPayload};
use tokio::io::AsyncWriteExt;

use crate::service::store::StoreError;
use crate::service::store::folder::private_folder;

/// Where [`Blobs::probe`] writes.
pub(super) const PROBES: &str = "ready";

/// The object store. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Blobs {
    store: Arc<dyn ObjectStore>,
    folder: PathBuf,
}

impl Blobs {
    /// Blobs in a local folder, which is created. What was written has been synced, with the folders that name it, so a
    /// row may point at it; folders vanish with their last blob.
    pub fn open(folder: &FilePath) -> Result<Self, StoreError> {
        private_folder(folder)
            .map_err(|source| StoreError::File { what: "creating the folder of the store", source })?;
        let store = LocalFileSystem::new_with_prefix(folder)?.with_fsync(true).with_automatic_cleanup(true);
        Ok(Self { store: Arc::new(store), folder: folder.to_owned() })
    }

    /// The folder of all blobs.
    pub(super) fn folder(&self) -> &FilePath {
        &self.folder
    }

    /// Writes a blob at once.
    pub async fn put(&self, key: &str, bytes: Bytes) -> Result<(), StoreError> {
        self.store.put(&Path::from(key), PutPayload::from(bytes)).await?;
        Ok(())
    }

    /// Copies a file into the store without holding it in memory.
    pub async fn put_file(&self, key: &str, file: &FilePath) -> Result<(), StoreError> {
        let failed = |source| StoreError::File { what: "storing an upload", source };
        let mut from = tokio::fs::File::open(file).await.map_err(failed)?;
        let mut to = BufWriter::new(Arc::clone(&self.store), Path::from(key));
        tokio::io::copy(&mut from, &mut to).await.map_err(failed)?;
        to.shutdown().await.map_err(failed)
    }

    /// The whole blob.
    pub async fn get(&self, key: &str) -> Result<Bytes, StoreError> {
        Ok(self.store.get(&Path::from(key)).await?.bytes().await?)
    }

    /// The length of a blob, if it is there.
    pub async fn length(&self, key: &str) -> Result<Option<u64>, StoreError> {
        match self.store.head(&Path::from(key)).await {
            Ok(meta) => Ok(Some(meta.size)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// The bytes of `range`, as a stream.
    pub async fn stream(
        &self,
        key: &str,
        range: Range<u64>,
    ) -> Result<BoxStream<'static, Result<Bytes, StoreError>>, StoreError> {
        if range.is_empty() {
            return Ok(futures_util::stream::empty().boxed());
        }
        let options = GetOptions { range: Some(GetRange::Bounded(range)), ..GetOptions::default() };
        Ok(self.store.get_opts(&Path::from(key), options).await?.into_stream().map_err(StoreError::from).boxed())
    }

    /// Removes a blob; one that is not there is removed already.
    pub async fn remove(&self, key: &str) -> Result<(), StoreError> {
        match self.store.delete(&Path::from(key)).await {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Removes all blobs below a prefix.
    pub async fn remove_below(&self, prefix: &str) -> Result<(), StoreError> {
        let found: Vec<_> = self.store.list(Some(&Path::from(prefix))).try_collect().await?;
        for meta in found {
            self.remove(meta.location.as_ref()).await?;
        }
        Ok(())
    }

    /// Keys below a prefix that were written longer ago than `age`.
    pub async fn older_than(&self, prefix: &str, age: Duration) -> Result<Vec<String>, StoreError> {
        let found: Vec<_> = self.store.list(Some(&Path::from(prefix))).try_collect().await?;
        let now = std::time::SystemTime::now();
        let old = found
            .into_iter()
            .filter(|meta| now.duration_since(meta.last_modified.into()).is_ok_and(|since: Duration| since >= age));
        Ok(old.map(|meta| meta.location.to_string()).collect())
    }

    /// Writes and removes a blob.
    pub async fn probe(&self) -> Result<(), StoreError> {
        let key = format!("{PROBES}/{}", uuid::Uuid::now_v7());
        self.put(&key, Bytes::from_static(b"ready")).await?;
        self.remove(&key).await
    }
}
