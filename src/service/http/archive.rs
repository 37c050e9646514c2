//! `/v1/jobs/{id}/archive.zip`: all files of a job in one, packed while they are sent.
//!
//! Pieces are read and sent by tokio's own threads and packed on its blocking ones, so that neither a slow client nor a
//! large file keeps a thread or the whole archive in memory.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures_util::stream::{BoxStream, try_unfold};
use futures_util::{Stream, TryStreamExt};
use sha2::{Digest, Sha256};
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

use crate::service::http::HttpState;
use crate::service::http::artefacts::{all_artefacts, single};
use crate::service::http::compression::shrinks;
use crate::service::http::download::{insert, known_tag, tag};
use crate::service::http::extract::Id;
use crate::service::http::file_bytes::FileBytes;
use crate::service::http::names::{Disposition, content_disposition, file_name};
use crate::service::http::view::job_row;
use crate::service::jobs::{hex, run_blocking};
use crate::service::store::{Artefact, Blobs, StoreError};
use crate::service::wire::Problem;

/// Bytes that are packed at once.
const PIECE: usize = 256 << 10;
/// Level of deflate: most of the gain for the least time.
const LEVEL: i64 = 3;

/// Downloads all files of a job: the quads and the parameterisation in every format, and the report.
#[utoipa::path(get, path = "/v1/jobs/{id}/archive.zip", tag = "results", operation_id = "archive",
    params(("id" = Uuid, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The archive", headers(("ETag" = String), ("Content-Disposition" = String)),
            content((inline(FileBytes) = "application/octet-stream"), (inline(FileBytes) = "application/zip"))),
        (status = 304, description = "The archive is the one of `If-None-Match`"),
    ))]
pub(super) async fn archive(
    State(state): State<HttpState>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = job_row(&state, id).await?;
    let artefacts = match all_artefacts(&job)? {
        Ok(artefacts) => artefacts,
        Err(response) => return Ok(response),
    };
    let files: VecDeque<_> =
        artefacts.iter().map(|(name, artefact)| (file_name(&job, name), artefact.clone())).collect();
    let named: Vec<_> = files.iter().map(|(name, artefact)| format!("{} {name}", artefact.sha256)).collect();
    let sha256 = hex(&Sha256::digest(format!("{}\n{}", named.join("\n"), env!("CARGO_PKG_VERSION"))));
    let known = known_tag(&headers, &sha256);
    let mut response = match &known {
        Some(_) => StatusCode::NOT_MODIFIED.into_response(),
        None => Body::from_stream(packed(state.jobs.store.blobs().clone(), files)).into_response(),
    };
    let name = content_disposition(Disposition::Attachment, &file_name(&job, "archive.zip"));
    insert(&mut response, header::ETAG, &known.unwrap_or_else(|| tag(&sha256)));
    insert(&mut response, header::CONTENT_TYPE, single(&headers, "application/zip"));
    insert(&mut response, header::VARY, "accept");
    insert(&mut response, header::CACHE_CONTROL, "private, max-age=3600");
    insert(&mut response, header::CONTENT_DISPOSITION, &name);
    Ok(response)
}

/// The bytes of the archive, as they come to be.
fn packed(blobs: Blobs, files: VecDeque<(String, Artefact)>) -> impl Stream<Item = Result<Bytes, StoreError>> {
    let sink = Sink::default();
    let packer = Packer { blobs, files, open: None, zip: Some(ZipWriter::new_stream(sink.clone())), sink };
    try_unfold(packer, |mut packer| async move { Ok(packer.next().await?.map(|bytes| (bytes, packer))) })
}

/// What was packed and not sent yet.
#[derive(Clone, Default)]
struct Sink(Arc<Mutex<Vec<u8>>>);

impl Sink {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

type Zip = ZipWriter<StreamWriter<Sink>>;

struct Packer {
    blobs: Blobs,
    /// Files that have not begun.
    files: VecDeque<(String, Artefact)>,
    /// The rest of the file that has.
    open: Option<BoxStream<'static, Result<Bytes, StoreError>>>,
    /// `None` once the archive is complete.
    zip: Option<Zip>,
    sink: Sink,
}

impl Packer {
    /// The next bytes of the archive; `None` at its end.
    async fn next(&mut self) -> Result<Option<Bytes>, StoreError> {
        while self.zip.is_some() {
            if let Some(rest) = &mut self.open {
                let piece = piece_of(rest).await?;
                if piece.is_empty() {
                    self.open = None;
                } else {
                    self.pack(move |mut zip| zip.write_all(&piece).map(|()| Some(zip))).await?;
                }
            } else if let Some((name, artefact)) = self.files.pop_front() {
                self.open = Some(self.blobs.stream(&artefact.blob, 0..artefact.bytes).await?);
                self.pack(move |mut zip| Ok(zip.start_file(name, options(&artefact)).map(|()| Some(zip))?)).await?;
            } else {
                self.pack(|zip| Ok(zip.finish().map(|_| None)?)).await?;
            }
            let bytes = self.sink.take();
            if !bytes.is_empty() {
                return Ok(Some(Bytes::from(bytes)));
            }
        }
        Ok(None)
    }

    /// Lets the writer work on a blocking thread of tokio.
    async fn pack(
        &mut self,
        work: impl FnOnce(Zip) -> io::Result<Option<Zip>> + Send + 'static,
    ) -> Result<(), StoreError> {
        let Some(zip) = self.zip.take() else { return Ok(()) };
        let failed = |source| StoreError::File { what: "packing an archive", source };
        let packed = run_blocking(move || Ok(work(zip))).await;
        self.zip = packed.unwrap_or_else(|_| Err(io::ErrorKind::Other.into())).map_err(failed)?;
        Ok(())
    }
}

fn options(artefact: &Artefact) -> SimpleFileOptions {
    let method = if shrinks(&artefact.media_type) { CompressionMethod::Deflated } else { CompressionMethod::Stored };
    let level = (method == CompressionMethod::Deflated).then_some(LEVEL);
    let large = artefact.bytes > u64::from(u32::MAX);
    // No time of day: the same files are the same archive.
    let time = zip::DateTime::default();
    SimpleFileOptions::default()
        .compression_method(method)
        .compression_level(level)
        .large_file(large)
        .last_modified_time(time)
}

/// The next bytes of a file, so many that a change of threads pays; empty at its end.
async fn piece_of(rest: &mut BoxStream<'static, Result<Bytes, StoreError>>) -> Result<Vec<u8>, StoreError> {
    let mut piece = Vec::new();
    while piece.len() < PIECE {
        match rest.try_next().await? {
            Some(bytes) => piece.extend_from_slice(&bytes),
            None => break,
        }
    }
    Ok(piece)
}
