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
use crate::service::http::extract::{Id, Query, text};
use crate::service::http::problem::gone;
use crate::service::http::view::job_row;
use crate::service::jobs::{beside, hex};
use crate::service::store::{Artefact, JobRow};
use crate::service::wire::{JobStatus, Problem, ProblemBody, ProblemKind, ReportBody, Urls};

/// Pixels of pictures: drawn on demand from the stored quads.
const SIZES: std::ops::RangeInclusive<u32> = 64..=2048;
const SIZE: u32 = 768;

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
    format: Option<QuadFormatName>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct MapQuery {
    /// Wins over `Accept`; `obj` if neither says anything.
    format: Option<MapFormatName>,
}

#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct PreviewQuery {
    /// Width and height in pixels, 64 to 2048; 768 if left out.
    size: Option<u32>,
}

/// Downloads the quads.
#[utoipa::path(get, path = "/v1/jobs/{id}/quad-mesh", tag = "results", operation_id = "quad_mesh",
    params(("id" = String, Path, description = "Id of the job"), QuadQuery),
    responses(
        (status = 200, description = "The file, with a strong `ETag`", content(
            (String = "model/obj"), (String = "model/gltf-binary"), (String = "application/ply"), (String = "model/vnd.usda"))),
        (status = 206, description = "The range that was asked for"),
        (status = 304, description = "The file is the one of `If-None-Match`"),
        (status = 406, description = "None of the accepted formats", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Not yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The job failed", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "Outside the file", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn quad_mesh(
    State(state): State<HttpState>,
    Id(id): Id,
    Query(query): Query<QuadQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = match query.format {
        Some(QuadFormatName::Obj) => QuadFormat::Obj,
        Some(QuadFormatName::Glb) => QuadFormat::Glb,
        Some(QuadFormatName::Ply) => QuadFormat::Ply,
        Some(QuadFormatName::Usda) => QuadFormat::Usda,
        None => negotiate(&headers, &QuadFormat::ALL, QuadFormat::media_type)?,
    };
    file(&state, id, &format!("quad-mesh.{}", format.extension()), &headers).await
}

/// Downloads the parameterisation.
#[utoipa::path(get, path = "/v1/jobs/{id}/parameterisation", tag = "results", operation_id = "parameterisation",
    params(("id" = String, Path, description = "Id of the job"), MapQuery),
    responses(
        (status = 200, description = "The file, with a strong `ETag`", content(
            (String = "model/obj"), (String = "model/gltf-binary"), (String = "application/json"))),
        (status = 206, description = "The range that was asked for"),
        (status = 304, description = "The file is the one of `If-None-Match`"),
        (status = 404, description = "The run made no map", body = ProblemBody, content_type = "application/problem+json"),
        (status = 406, description = "None of the accepted formats", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Not yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The job failed", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn parameterisation(
    State(state): State<HttpState>,
    Id(id): Id,
    Query(query): Query<MapQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = match query.format {
        Some(MapFormatName::Obj) => MapFormat::Obj,
        Some(MapFormatName::Glb) => MapFormat::Glb,
        Some(MapFormatName::Json) => MapFormat::Json,
        None => negotiate(&headers, &MapFormat::ALL, MapFormat::media_type)?,
    };
    file(&state, id, &format!("parameterisation.{}", format.extension()), &headers).await
}

/// Shows the report.
#[utoipa::path(get, path = "/v1/jobs/{id}/report", tag = "results", operation_id = "report",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The report", body = ReportBody),
        (status = 409, description = "Not yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The job failed", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn report(
    State(state): State<HttpState>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    file(&state, id, "report.json", &headers).await
}

/// Shows a picture of the quads: shaded, with edges, irregular vertices coloured by valence.
#[utoipa::path(get, path = "/v1/jobs/{id}/preview.png", tag = "results", operation_id = "preview",
    params(("id" = String, Path, description = "Id of the job"), PreviewQuery),
    responses(
        (status = 200, description = "The picture", body = Vec<u8>, content_type = "image/png"),
        (status = 409, description = "Not yet", body = ProblemBody, content_type = "application/problem+json"),
        (status = 410, description = "The job failed", body = ProblemBody, content_type = "application/problem+json"),
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
    if download::is_known(&headers, &sha256) {
        return Ok(Download::picture(Bytes::new(), &sha256).not_modified());
    }
    let quads = state.desk.store.blobs().get(&quads.blob).await?;
    let permit = state.readers.acquire().await.map_err(|_| Problem::internal())?;
    let driver = state.driver.clone();
    let picture = Bytes::from(beside(move || driver.preview(&quads, size)).await?);
    drop(permit);
    Download::picture(picture, &sha256).respond(&headers).await
}

async fn file(state: &HttpState, id: Uuid, name: &str, headers: &HeaderMap) -> Result<Response, Problem> {
    let job = job_row(state, id).await?;
    let artefact = match artefact(&job, name)? {
        Ok(artefact) => artefact,
        Err(response) => return Ok(response),
    };
    let shown_in_place = name == "report.json";
    let download = Download {
        source: Source::Blob(state.desk.store.blobs(), &artefact.blob),
        sha256: &artefact.sha256,
        bytes: artefact.bytes,
        media_type: &artefact.media_type,
        file_name: (!shown_in_place).then(|| format!("{id}-{name}")),
    };
    download.respond(headers).await
}

/// The file of a job that has one; otherwise why not: a problem, or the finished answer with the job's own problem.
fn artefact<'j>(job: &'j JobRow, name: &str) -> Result<Result<&'j Artefact, Response>, Problem> {
    match (job.status, &job.problem) {
        (JobStatus::Queued | JobStatus::Running, _) => {
            let detail = format!("The job is {}; follow its events or ask again.", job.status.name());
            Err(Problem { retry_after: Some(2), ..Problem::new(ProblemKind::NotReady, detail) })
        }
        (JobStatus::Failed | JobStatus::Cancelled, Some(problem)) => {
            Ok(Err(gone(&Urls::of(&job.id.to_string()).self_, problem)))
        }
        (JobStatus::Failed | JobStatus::Cancelled, None) => Ok(Err(StatusCode::GONE.into_response())),
        (JobStatus::Succeeded, _) => job.artefacts.get(name).map(Ok).ok_or_else(|| {
            let detail = format!("This run made no {name}; the report says how its quads were made.");
            Problem::new(ProblemKind::NoArtefact, detail)
        }),
    }
}

/// The format that `Accept` likes best; among equals the first of `formats`.
fn negotiate<F: Copy>(
    headers: &HeaderMap,
    formats: &[F],
    media_type: impl Fn(F) -> &'static str,
) -> Result<F, Problem> {
    let Some(accept) = text(headers, "accept") else { return Ok(formats[0]) };
    let mut best: Option<(f32, F)> = None;
    for &format in formats {
        let quality = quality(accept, media_type(format));
        if quality > best.map_or(0.0, |(quality, _)| quality) {
            best = Some((quality, format));
        }
    }
    best.map(|(_, format)| format).ok_or_else(|| {
        let offered: Vec<_> = formats.iter().map(|&format| media_type(format)).collect();
        Problem::new(ProblemKind::NotAcceptable, format!("Offered are {}.", offered.join(", ")))
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
        negotiate(&headers, &QuadFormat::ALL, QuadFormat::media_type).ok().map(QuadFormat::extension)
    }

    #[test]
    fn the_best_liked_format_wins() {
        assert_eq!(negotiated("*/*"), Some("obj"));
        assert_eq!(negotiated("model/gltf-binary"), Some("glb"));
        assert_eq!(negotiated("model/obj;q=0.5, model/vnd.usda"), Some("usda"));
        assert_eq!(negotiated("model/*;q=0.1, application/ply;q=0.2"), Some("ply"));
        assert_eq!(negotiated("model/obj;q=0, model/*;q=0.3"), Some("glb"));
        assert_eq!(negotiated("text/html"), None);
        assert_eq!(negotiate(&HeaderMap::new(), &MapFormat::ALL, MapFormat::media_type).unwrap(), MapFormat::Obj);
    }
}
