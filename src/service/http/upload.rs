//! Uploads: streamed to disk, hashed on the way, judged before they are accepted.

use std::path::Path;

use axum::extract::Multipart;
use axum::extract::multipart::{Field, MultipartError};
use axum::http::{HeaderMap, StatusCode, header};
use bytes::Bytes;
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;
use tokio::io::AsyncWriteExt;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::jobs::{InputFile, hex, run_blocking};
use crate::service::store::{NewAsset, StoreError};
use crate::service::wire::{Problem, ProblemKind, SPEC_BYTES};

/// Uploads up to this size are read completely before they are accepted, so that the uploader hears of a fault at once.
const READ_AT_ONCE: u64 = 64 << 20;
/// What the other parts of a multipart body may add to the mesh.
const AROUND: u64 = 1 << 20;
/// How much of a larger upload is looked at.
const HEAD: usize = 1 << 20;

/// An upload in a file that vanishes when it is dropped.
#[derive(Debug)]
pub(super) struct Upload {
    pub(super) file: NamedTempFile,
    pub(super) name: Option<String>,
    pub(super) sha256: String,
    pub(super) bytes: u64,
}

/// Refuses a body that says itself that it is too long, before it is sent.
pub(super) fn judge_length(state: &HttpState, headers: &HeaderMap) -> Result<(), Problem> {
    let limit = state.jobs.limits.upload_bytes;
    let length = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    match length {
        Some(length) if length > limit.saturating_add(SPEC_BYTES as u64 + AROUND) => Err(too_large(limit)),
        _ => Ok(()),
    }
}

pub(super) fn too_large(limit: u64) -> Problem {
    Problem::new(ProblemKind::BodyTooLarge, format!("The upload exceeds the limit of {limit} bytes."))
}

/// A multipart body that cannot be read.
pub(super) fn broken(error: &MultipartError) -> Problem {
    if error.status() == StatusCode::PAYLOAD_TOO_LARGE {
        return Problem::new(ProblemKind::BodyTooLarge, error.body_text());
    }
    Problem::new(ProblemKind::InvalidRequest, format!("The multipart body cannot be read: {}.", error.body_text()))
}

/// The next part of a multipart body.
pub(super) async fn next_field(multipart: &mut Multipart) -> Result<Option<Field<'_>>, Problem> {
    multipart.next_field().await.map_err(|error| broken(&error))
}

impl Upload {
    /// Streams a part to disk.
    pub(super) async fn receive(state: &HttpState, mut field: Field<'_>) -> Result<Self, Problem> {
        let limit = state.jobs.limits.upload_bytes;
        let failed = |source| Problem::from(StoreError::File { what: "writing an upload", source });
        let name = field.file_name().and_then(base_name);
        let file = NamedTempFile::new_in(&state.uploads).map_err(failed)?;
        let mut to = tokio::fs::File::from_std(file.reopen().map_err(failed)?);
        let (mut hasher, mut bytes) = (Sha256::new(), 0u64);
        while let Some(chunk) = field.chunk().await.map_err(|error| broken(&error))? {
            bytes += chunk.len() as u64;
            if bytes > limit {
                return Err(too_large(limit));
            }
            hasher.update(&chunk);
            to.write_all(&chunk).await.map_err(failed)?;
        }
        to.flush().await.map_err(failed)?;
        Ok(Self { file, name, sha256: hex(&hasher.finalize()), bytes })
    }

    /// Reads the upload, refuses what cannot be read, and puts the bytes into the object store.
    pub(super) async fn accept(self, state: &HttpState, pinned: bool) -> Result<NewAsset, Problem> {
        let whole = self.bytes <= READ_AT_ONCE;
        let permit = state.readers.acquire().await.map_err(|_| Problem::internal())?;
        let failed = |source| Problem::from(StoreError::File { what: "reading an upload", source });
        let bytes = if whole {
            Bytes::from(tokio::fs::read(self.file.path()).await.map_err(failed)?)
        } else {
            head(self.file.path()).await.map_err(failed)?
        };
        let input = InputFile { bytes: bytes.clone(), name: self.name.clone(), format: None };
        let driver = state.driver.clone();
        let found = run_blocking(move || driver.inspect(&input, whole)).await?;
        drop(permit);
        let id = Uuid::now_v7();
        let blob = format!("assets/{id}");
        if whole {
            state.jobs.store.blobs().put(&blob, bytes).await?;
        } else {
            state.jobs.store.blobs().put_file(&blob, self.file.path()).await?;
        }
        metrics::counter!("quadrille_upload_bytes_total").increment(self.bytes);
        Ok(NewAsset {
            id,
            sha256: self.sha256,
            bytes: self.bytes,
            format: Some(found.format),
            name: self.name,
            vertices: found.vertices,
            faces: found.faces,
            blob,
            pinned,
        })
    }
}

async fn head(file: &Path) -> std::io::Result<Bytes> {
    use tokio::io::AsyncReadExt;
    let mut bytes = Vec::with_capacity(HEAD);
    tokio::fs::File::open(file).await?.take(HEAD as u64).read_to_end(&mut bytes).await?;
    Ok(Bytes::from(bytes))
}

/// The last part of a name that a client gave; it is only ever shown and looked at for its ending.
fn base_name(name: &str) -> Option<String> {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let clean: String = last.chars().filter(|c| !c.is_control()).take(200).collect();
    (!clean.is_empty()).then_some(clean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_part_of_a_name_is_kept() {
        assert_eq!(base_name("../../etc/bunny.obj").as_deref(), Some("bunny.obj"));
        assert_eq!(base_name("C:\\models\\bunny.obj").as_deref(), Some("bunny.obj"));
        assert_eq!(base_name("a/"), None);
        assert_eq!(base_name("a\r\nb.obj").as_deref(), Some("ab.obj"));
    }
}
