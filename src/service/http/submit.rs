//! The two bodies that `POST /v1/jobs` takes.

use axum::extract::{FromRequest, Multipart, Request};
use axum::http::header;
use futures_util::TryStreamExt;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::file_bytes::FileBytes;
use crate::service::http::several::Files;
use crate::service::http::spec::Text;
use crate::service::http::upload;
use crate::service::jobs::JobMesh;
use crate::service::wire::{Fields, Problem, ProblemKind, ResolvedSpec, SPEC_BYTES, SpecDocument};

/// What a JSON body may have around the spec.
const AROUND_SPEC: usize = 1 << 10;

/// A job as multipart/form-data.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "only its schema is used; the body is read as a stream")]
pub(super) struct JobForm {
    /// OBJ, GLB, glTF, PLY, STL, or a zip of a mesh and the files that it names. The part may repeat: a mesh and these
    /// files, each under its name.
    #[schema(inline, value_type = Vec<FileBytes>, min_items = 1, max_items = 1000)]
    mesh: Vec<Vec<u8>>,
    /// The spec; every field may be left out.
    spec: Option<ResolvedSpec>,
}

/// A job on an asset that was uploaded before.
///
/// Only its schema is used; the body is read field by field.
#[derive(Debug, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AssetJob {
    /// Id of the asset.
    #[schema(format = Uuid)]
    asset: String,
    /// The spec; every field may be left out.
    spec: Option<ResolvedSpec>,
}

/// What a body asked for; its mesh was read and its spec was judged.
pub(super) struct Submission {
    pub(super) mesh: JobMesh,
    pub(super) spec: SpecDocument,
}

fn invalid(detail: impl Into<String>) -> Problem {
    Problem::new(ProblemKind::InvalidRequest, detail)
}

impl Submission {
    pub(super) async fn read(state: &HttpState, request: Request) -> Result<Self, Problem> {
        upload::judge_length(state, request.headers())?;
        let media_type = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
        let media_type = media_type.and_then(|value| value.split(';').next()).unwrap_or_default().trim();
        if media_type.eq_ignore_ascii_case("multipart/form-data") {
            Self::from_form(state, request).await
        } else if media_type.eq_ignore_ascii_case("application/json") {
            Self::from_json(state, request).await
        } else {
            Err(invalid(
                "Send multipart/form-data with the file in the part `mesh` and an optional JSON part `spec`, or \
                 application/json with `asset` and `spec`.",
            ))
        }
    }

    async fn from_form(state: &HttpState, request: Request) -> Result<Self, Problem> {
        let (mut files, mut spec) = (Files::default(), None);
        let mut multipart =
            Multipart::from_request(request, state).await.map_err(|rejection| invalid(rejection.body_text()))?;
        while let Some(field) = upload::next_field(&mut multipart).await? {
            match field.name() {
                Some("mesh") => files.receive(state, field).await?,
                Some("spec") if spec.is_none() => {
                    // Judged at once: a client with a wrong spec need not send its mesh.
                    let chunks = field.map_err(|error| upload::broken(&error));
                    let text = Text::receive(state, chunks, SPEC_BYTES).await?;
                    spec = Some(text.read(state, |text| SpecDocument::of(&ResolvedSpec::from_json(text)?)).await?);
                }
                Some("spec") => return Err(invalid("The part `spec` comes twice.")),
                name => {
                    let name = name.unwrap_or("without a name");
                    return Err(invalid(format!("Unknown part `{name}`; there are only `mesh` and `spec`.")));
                }
            }
        }
        let mesh = files.finish(state).await?;
        let spec = spec.map_or_else(|| SpecDocument::of(&ResolvedSpec::default()), Ok)?;
        Ok(Self { mesh: JobMesh::New(mesh.accept(state, false).await?), spec })
    }

    async fn from_json(state: &HttpState, request: Request) -> Result<Self, Problem> {
        let chunks = request.into_body().into_data_stream();
        let broken = |error: axum::Error| invalid(format!("The body cannot be read: {error}."));
        let text = Text::receive(state, chunks.map_err(broken), SPEC_BYTES + AROUND_SPEC).await?;
        let (asset, spec) = text.read(state, read_asset_job).await?;
        let missing = || Problem::new(ProblemKind::NotFound, "There is no asset with this id; upload it first.");
        let id: Uuid = asset.parse().map_err(|_| missing())?;
        let asset = state.jobs.store.asset(id).await?.filter(|asset| asset.pinned).ok_or_else(missing)?;
        Ok(Self { mesh: JobMesh::Known(asset), spec })
    }
}

/// The id of the asset, and the spec.
fn read_asset_job(text: &[u8]) -> Result<(String, SpecDocument), Problem> {
    let text = std::str::from_utf8(text).map_err(|error| invalid(format!("The body is not JSON: {error}.")))?;
    let mut errors = Vec::new();
    let mut fields = Fields::of(text, "", &mut errors);
    let mut asset: Option<String> = None;
    fields.read("asset", &mut asset);
    let spec = fields.take("spec").unwrap_or_default();
    fields.finish();
    let Some(asset) = asset.filter(|_| errors.is_empty()) else {
        return Err(Problem { errors, ..invalid("The body must be an object with `asset` and perhaps `spec`.") });
    };
    let spec = ResolvedSpec::from_json(spec.as_bytes()).map_err(|problem| problem.under("/spec"))?;
    Ok((asset, SpecDocument::of(&spec)?))
}
