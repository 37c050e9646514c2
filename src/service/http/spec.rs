//! Specs on their way in and out.
//!
//! A spec may carry megabytes of edges or strokes. Long ones wait in a file until a reader is free, and are judged on
//! tokio's blocking threads, so that neither many nor slow clients cost memory or time of others.

use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures_util::{Stream, StreamExt};
use tempfile::NamedTempFile;
use tokio::io::AsyncWriteExt;

use crate::service::http::HttpState;
use crate::service::http::extract::{Id, no_job};
use crate::service::jobs::run_blocking;
use crate::service::store::StoreError;
use crate::service::wire::{Problem, ProblemBody, ProblemKind, ResolvedSpec};

/// Up to this length a spec is kept in memory and judged at once.
const SHORT: usize = 64 << 10;
/// How many times the limit is received, and thrown away, before a client is cut off.
const DISCARDED_LIMITS: usize = 4;

/// A text that was received but not looked at.
pub(super) enum Text {
    Short(Vec<u8>),
    Long(NamedTempFile),
}

impl Text {
    /// Receives a text of at most `limit` bytes.
    pub(super) async fn receive(
        state: &HttpState,
        chunks: impl Stream<Item = Result<Bytes, Problem>>,
        limit: usize,
    ) -> Result<Self, Problem> {
        let failed = |source| Problem::from(StoreError::File { what: "writing a spec", source });
        let mut chunks = std::pin::pin!(chunks);
        let (mut short, mut long, mut length) = (Vec::new(), None, 0);
        while let Some(chunk) = chunks.next().await.transpose()? {
            length += chunk.len();
            if length > limit {
                // A client that is cut off while it sends may never see the answer.
                if length > limit.saturating_mul(DISCARDED_LIMITS) {
                    break;
                }
                continue;
            }
            if long.is_none() && length > SHORT {
                let file = NamedTempFile::new_in(&state.uploads).map_err(failed)?;
                let mut to = tokio::fs::File::from_std(file.reopen().map_err(failed)?);
                to.write_all(&short).await.map_err(failed)?;
                long = Some((file, to));
            }
            match &mut long {
                Some((_, to)) => to.write_all(&chunk).await.map_err(failed)?,
                None => short.extend_from_slice(&chunk),
            }
        }
        if length > limit {
            let detail = format!("The spec exceeds the limit of {limit} bytes.");
            return Err(Problem::new(ProblemKind::BodyTooLarge, detail));
        }
        let Some((file, mut to)) = long else { return Ok(Text::Short(short)) };
        to.flush().await.map_err(failed)?;
        Ok(Text::Long(file))
    }

    /// Reads it where that disturbs nobody.
    pub(super) async fn read<T: Send + 'static>(
        self,
        state: &HttpState,
        read: impl FnOnce(&[u8]) -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let file = match self {
            Text::Short(bytes) => return read(&bytes),
            Text::Long(file) => file,
        };
        let _permit = state.readers.acquire().await.map_err(|_| Problem::internal())?;
        run_blocking(move || {
            let failed = |source| Problem::from(StoreError::File { what: "reading a spec", source });
            read(&std::fs::read(file.path()).map_err(failed)?)
        })
        .await
    }
}

/// Shows the whole spec of a job, with all defaults and with the lists that job objects give by their length.
#[utoipa::path(get, path = "/v1/jobs/{id}/spec", tag = "jobs", operation_id = "job_spec",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The spec", body = ResolvedSpec),
        (status = 404, description = "No such job", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn job_spec(State(state): State<HttpState>, Id(id): Id) -> Result<Response, Problem> {
    let text = state.jobs.store.spec(id).await?.ok_or_else(|| no_job(id))?;
    Ok(([(header::CONTENT_TYPE, "application/json")], text).into_response())
}
