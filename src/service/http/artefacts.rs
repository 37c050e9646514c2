//! The files of a job: quads, parameterisation, report, picture.

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use crate::service::formats::{MapFormat, QuadFormat};
use crate::service::http::HttpState;
use crate::service::http::download::{self, Download, Source};
use crate::service::http::extract::{Id, text};
use crate::service::http::file_bytes::FileBytes;
use crate::service::http::names::{Disposition, file_name};
use crate::service::http::problem::gone;
use crate::service::http::query::Query;
use crate::service::http::view::job_row;
use crate::service::jobs::{hex, run_blocking};
use crate::service::store::{Artefact, Artefacts, JobRow};
use crate::service::wire::{JobStatus, Problem, ProblemKind, ReportBody, Urls};

/// Pixels of pictures: drawn on demand from the stored quads.
const SIZES: std::ops::RangeInclusive<u32> = 64..=2048;
const SIZE: u32 = 768;

/// Bytes of any kind.
const BYTES: &str = "application/octet-stream";

/// Formats of quads.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum QuadFormatName {
    Obj,
    Glb,
    Ply,
    Usda,
}

/// Formats of parameterisations.
#[derive(Clone, Copy, Debug, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum MapFormatName {
    Obj,
    Glb,
    Json,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct QuadQuery {
    /// Wins over `Accept`; `obj` if neither says anything.
    #[param(inline)]
    format: Option<QuadFormatName>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct MapQuery {
    /// Wins over `Accept`; `obj` if neither says anything.
    #[param(inline)]
    format: Option<MapFormatName>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct PreviewQuery {
    /// Width and height in pixels, 64 to 2048; 768 if left out.
    #[param(minimum = 64, maximum = 2048)]
    size: Option<u32>,
}

/// Downloads the quads.
#[utoipa::path(get, path = "/v1/jobs/{id}/quad-mesh", tag = "results", operation_id = "quad_mesh",
    params(("id" = Uuid, Path, description = "Id of the job"), QuadQuery,
        ("Range" = Option<String>, Header, description = "`bytes=FIRST-LAST`")),
    responses(
        (status = 200, description = "The file", headers(("ETag" = String), ("Content-Disposition" = String)), content(
            (inline(FileBytes) = "application/octet-stream"), (inline(FileBytes) = "model/obj"),
            (inline(FileBytes) = "model/gltf-binary"), (inline(FileBytes) = "application/ply"),
            (inline(FileBytes) = "model/vnd.usda"))),
        (status = 206, description = "The range that was asked for"),
        (status = 304, description = "The file is the one of `If-None-Match`"),
    ))]
pub(super) async fn quad_mesh(
    State(state): State<HttpState>,
    Id(id): Id,
    Query(query): Query<QuadQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let named = query.format.map(|name| match name {
        QuadFormatName::Obj => QuadFormat::Obj,
        QuadFormatName::Glb => QuadFormat::Glb,
        QuadFormatName::Ply => QuadFormat::Ply,
        QuadFormatName::Usda => QuadFormat::Usda,
    });
    let (format, media_type) = negotiate(named, &headers, &QuadFormat::ALL, QuadFormat::media_type)?;
    file(&state, id, &format!("quad-mesh.{}", format.extension()), media_type, &headers).await
}

/// Downloads the parameterisation.
#[utoipa::path(get, path = "/v1/jobs/{id}/parameterisation", tag = "results", operation_id = "parameterisation",
    params(("id" = Uuid, Path, description = "Id of the job"), MapQuery,
        ("Range" = Option<String>, Header, description = "`bytes=FIRST-LAST`")),
    responses(
        (status = 200, description = "The file", headers(("ETag" = String), ("Content-Disposition" = String)), content(
            (inline(FileBytes) = "application/octet-stream"), (inline(FileBytes) = "model/obj"),
            (inline(FileBytes) = "model/gltf-binary"), (inline(FileBytes) = "application/json"))),
        (status = 206, description = "The range that was asked for"),
        (status = 304, description = "The file is the one of `If-None-Match`"),
    ))]
pub(super) async fn parameterisation(
    State(state): State<HttpState>,
    Id(id): Id,
    Query(query): Query<MapQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let named = query.format.map(|name| match name {
        MapFormatName::Obj => MapFormat::Obj,
        MapFormatName::Glb => MapFormat::Glb,
        MapFormatName::Json => MapFormat::Json,
    });
    let (format, media_type) = negotiate(named, &headers, &MapFormat::ALL, MapFormat::media_type)?;
    file(&state, id, &format!("parameterisation.{}", format.extension()), media_type, &headers).await
}

/// Shows the report.
#[utoipa::path(get, path = "/v1/jobs/{id}/report", tag = "results", operation_id = "report",
    params(("id" = Uuid, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The report", body = ReportBody, headers(("ETag" = String))),
    ))]
pub(super) async fn report(
    State(state): State<HttpState>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    file(&state, id, "report.json", "application/json", &headers).await
}

/// Shows a picture of the quads: shaded, with edges, irregular vertices coloured by valence.
#[utoipa::path(get, path = "/v1/jobs/{id}/preview.png", tag = "results", operation_id = "preview",
    params(("id" = Uuid, Path, description = "Id of the job"), PreviewQuery),
    responses(
        (status = 200, description = "The picture", headers(("ETag" = String)), content(
            (inline(FileBytes) = "application/octet-stream"), (inline(FileBytes) = "image/png"))),
    ))]
pub(super) async fn preview(
    State(state): State<HttpState>,
    Id(id): Id,
    Query(query): Query<PreviewQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let size = query.size.unwrap_or(SIZE);
    if !SIZES.contains(&size) {
        let detail = format!("size must be from {} to {} pixels, not {size}.", SIZES.start(), SIZES.end());
        return Err(Problem::new(ProblemKind::InvalidRequest, detail));
    }
    let job = job_row(&state, id).await?;
    let quads = match artefact(&job, "quad-mesh.ply")? {
        Ok(artefact) => artefact,
        Err(response) => return Ok(response),
    };
    // The same version draws the same quads the same, so the tag is known before the picture is.
    let sha256 = hex(&Sha256::digest(format!("{} {size} {}", quads.sha256, env!("CARGO_PKG_VERSION"))));
    let (name, media_type) = (file_name(&job, "preview.png"), single(&headers, "image/png"));
    if let Some(known) = download::known_tag(&headers, &sha256) {
        return Ok(Download::picture(Bytes::new(), &sha256, media_type, name).not_modified(&known));
    }
    let quads = state.jobs.store.blobs().get(&quads.blob).await?;
    let permit = state.readers.acquire().await.map_err(|_| Problem::internal())?;
    let driver = state.driver.clone();
    let picture = Bytes::from(run_blocking(move || driver.preview(&quads, size)).await?);
    drop(permit);
    Download::picture(picture, &sha256, media_type, name).respond(&headers).await
}

async fn file(
    state: &HttpState,
    id: Uuid,
    name: &str,
    media_type: &str,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let job = job_row(state, id).await?;
    let artefact = match artefact(&job, name)? {
        Ok(artefact) => artefact,
        Err(response) => return Ok(response),
    };
    let download = Download {
        source: Source::Blob(state.jobs.store.blobs(), &artefact.blob),
        sha256: &artefact.sha256,
        bytes: artefact.bytes,
        media_type,
        file_name: file_name(&job, name),
        disposition: if name == "report.json" { Disposition::Inline } else { Disposition::Attachment },
    };
    download.respond(headers).await
}

/// The file of a job that has one; otherwise why not: a problem, or the finished answer with the job's own problem.
fn artefact<'j>(job: &'j JobRow, name: &str) -> Result<Result<&'j Artefact, Response>, Problem> {
    let artefacts = match all_artefacts(job)? {
        Ok(artefacts) => artefacts,
        Err(response) => return Ok(Err(response)),
    };
    artefacts.get(name).map(Ok).ok_or_else(|| {
        let detail = format!("This run made no {name}; the report says how its quads were made.");
        Problem::new(ProblemKind::NoArtefact, detail)
    })
}

/// The files of a job that has any; otherwise why not: a problem, or the finished answer with the job's own problem.
pub(super) fn all_artefacts(job: &JobRow) -> Result<Result<&Artefacts, Response>, Problem> {
    match (job.status, &job.problem) {
        (JobStatus::Queued | JobStatus::Running, _) => {
            let detail = format!("The job is {}; follow its events or ask again.", job.status.name());
            Err(Problem { retry_after: Some(2), ..Problem::new(ProblemKind::NotReady, detail) })
        }
        (JobStatus::Failed | JobStatus::Cancelled, Some(problem)) => {
            Ok(Err(gone(&Urls::of(&job.id.to_string()).self_, problem)))
        }
        (JobStatus::Failed | JobStatus::Cancelled, None) => Ok(Err(StatusCode::GONE.into_response())),
        (JobStatus::Succeeded, _) => Ok(Ok(&job.artefacts)),
    }
}

/// The media type of a file that there is in one form: its own, unless the client asks for bytes only.
pub(super) fn single(headers: &HeaderMap, media_type: &'static str) -> &'static str {
    negotiate(None, headers, &[()], |()| media_type).map_or(media_type, |((), liked)| liked)
}

/// The format that was named, or else the one that `Accept` likes best, among equals the first of `formats`; with the
/// media type of the answer. Whoever wants bytes without a type gets the first format.
fn negotiate<F: Copy>(
    named: Option<F>,
    headers: &HeaderMap,
    formats: &[F],
    media_type: impl Fn(F) -> &'static str,
) -> Result<(F, &'static str), Problem> {
    let typed = |format| (format, media_type(format));
    let Some(accept) = text(headers, "accept").filter(|_| named.is_none()) else {
        return Ok(typed(named.unwrap_or(formats[0])));
    };
    let offered: Vec<_> = formats.iter().map(|&format| typed(format)).chain([(formats[0], BYTES)]).collect();
    let mut best: Option<(f32, (F, &'static str))> = None;
    for &offer in &offered {
        let quality = quality(accept, offer.1);
        if quality > best.map_or(0.0, |(quality, _)| quality) {
            best = Some((quality, offer));
        }
    }
    best.map(|(_, offer)| offer).ok_or_else(|| {
        let offered: Vec<_> = offered.iter().map(|&(_, media_type)| media_type).collect();
        Problem::new(ProblemKind::FormatNotOffered, format!("Offered are {}.", offered.join(", ")))
    })
}

/// How much an `Accept` header likes a media type: the weight of its most specific range (RFC 9110, 12.5.1).
fn quality(accept: &str, media_type: &str) -> f32 {
    let family = media_type.split('/').next().unwrap_or_default();
    let mut best = (0, 0.0);
    for range in accept.split(',') {
        let mut parts = range.split(';').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(1.0, |q| q.trim().parse().unwrap_or(0.0));
        let specific = match name {
            name if name.eq_ignore_ascii_case(media_type) => 3,
            name if name.strip_suffix("/*").is_some_and(|f| f.eq_ignore_ascii_case(family)) => 2,
            "*/*" => 1,
            _ => 0,
        };
        if specific > best.0 {
            best = (specific, weight);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn negotiated(accept: &str) -> Option<&'static str> {
        let mut headers = HeaderMap::new();
        headers.insert("accept", accept.parse().unwrap());
        let found = negotiate(None, &headers, &QuadFormat::ALL, QuadFormat::media_type).ok()?;
        (found.1 == found.0.media_type() || found.1 == BYTES).then(|| found.0.extension())
    }

    #[test]
    fn the_best_liked_format_wins() {
        assert_eq!(negotiated("*/*"), Some("obj"));
        assert_eq!(negotiated("model/gltf-binary"), Some("glb"));
        assert_eq!(negotiated("model/obj;q=0.5, model/vnd.usda"), Some("usda"));
        assert_eq!(negotiated("model/*;q=0.1, application/ply;q=0.2"), Some("ply"));
        assert_eq!(negotiated("model/obj;q=0, model/*;q=0.3"), Some("glb"));
        assert_eq!(negotiated("text/html"), None);
        assert_eq!(negotiated("application/octet-stream"), Some("obj"));
        let silent = HeaderMap::new();
        let map = |named| negotiate(named, &silent, &MapFormat::ALL, MapFormat::media_type).unwrap();
        assert_eq!(map(None), (MapFormat::Obj, "model/obj"));
        assert_eq!(map(Some(MapFormat::Json)), (MapFormat::Json, "application/json"));
    }
}
