//! The two bodies that `POST /v1/jobs` takes.

use axum::extract::{FromRequest, Multipart, Request};
use axum::http::header;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::openapi::FileBytes;
use crate::service::http::several::Files;
use crate::service::http::upload;
use crate::service::jobs::OrderMesh;
use crate::service::wire::{Problem, ProblemKind, RemeshRequest, ResolvedSpec, Violation};

/// A job as multipart/form-data.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "only its schema is used; the body is read as a stream")]
pub(super) struct JobForm {
    /// OBJ, GLB, glTF, PLY, STL, or a zip of a mesh and the files that it names. The part may repeat: a mesh and these
    /// files, each under its name.
    #[schema(inline, value_type = Vec<FileBytes>, min_items = 1, max_items = 1000)]
    mesh: Vec<Vec<u8>>,
    /// The spec; every field may be left out.
    spec: Option<RemeshRequest>,
}

/// A job on an asset that was uploaded before.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AssetJob {
    /// Id of the asset.
    #[schema(format = Uuid)]
    asset: String,
    /// The spec; every field may be left out.
    #[schema(value_type = Option<RemeshRequest>)]
    #[serde(default)]
    spec: Value,
}

/// What a body asked for; its mesh was read and its spec was judged.
pub(super) struct Submission {
    pub(super) mesh: OrderMesh,
    pub(super) spec: ResolvedSpec,
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
                    let bytes = upload::small(field, upload::SPEC_BYTES).await?;
                    spec = Some(ResolvedSpec::from_json(&bytes)?);
                }
                Some("spec") => return Err(invalid("The part `spec` comes twice.")),
                name => {
                    let name = name.unwrap_or("without a name");
                    return Err(invalid(format!("Unknown part `{name}`; there are only `mesh` and `spec`.")));
                }
            }
        }
        let mesh = files.finish(state).await?;
        Ok(Self { mesh: OrderMesh::New(mesh.accept(state, false).await?), spec: spec.unwrap_or_default() })
    }

    async fn from_json(state: &HttpState, request: Request) -> Result<Self, Problem> {
        let limit = usize::try_from(upload::SPEC_BYTES).unwrap_or(usize::MAX);
        let bytes = axum::body::to_bytes(request.into_body(), limit).await.map_err(|error| {
            Problem::new(ProblemKind::BodyTooLarge, format!("The body cannot be read within {limit} bytes: {error}."))
        })?;
        let body: AssetJob = serde_json::from_slice(&bytes).map_err(|error| invalid(format!("The body: {error}.")))?;
        let spec = ResolvedSpec::from_value(body.spec).map_err(|violations| {
            Problem::invalid_spec(
                violations.into_iter().map(|violation| Violation::under(violation, "/spec")).collect(),
            )
        })?;
        let missing =
            || Problem::new(ProblemKind::NotFound, format!("There is no asset {}; upload it first.", body.asset));
        let id: Uuid = body.asset.parse().map_err(|_| missing())?;
        let asset = state.desk.store.asset(id).await?.filter(|asset| asset.pinned).ok_or_else(missing)?;
        Ok(Self { mesh: OrderMesh::Known(asset), spec })
    }
}
