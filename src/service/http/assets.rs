//! `/v1/assets`: upload once, remesh many times.

use axum::Json;
use axum::extract::{FromRequest, Multipart, Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::extract::Id;
use crate::service::http::file_bytes::FileBytes;
use crate::service::http::several::Files;
use crate::service::http::upload;
use crate::service::store::{AssetRow, Deleted, rfc3339};
use crate::service::wire::{Problem, ProblemKind};

/// An asset as multipart/form-data.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "only its schema is used; the body is read as a stream")]
struct AssetForm {
    /// OBJ, GLB, glTF, PLY, STL, or a zip of a mesh and the files that it names. The part may repeat: a mesh and these
    /// files, each under its name.
    #[schema(inline, value_type = Vec<FileBytes>, min_items = 1, max_items = 1000)]
    mesh: Vec<Vec<u8>>,
}

/// A stored mesh.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct AssetBody {
    /// UUIDv7.
    #[schema(format = Uuid)]
    id: String,
    /// Lower-case hexadecimal SHA-256 of the bytes; the same bytes are the same asset.
    sha256: String,
    /// Length in bytes.
    bytes: u64,
    /// `obj`, `glb`, `gltf`, `ply`, `stl` or `zip`.
    format: Option<String>,
    /// Name of the file that was uploaded first.
    name: Option<String>,
    /// Vertices as read; null if the file was too large to be read while it was uploaded.
    vertices: Option<u64>,
    /// Faces as read; null if the file was too large to be read while it was uploaded.
    faces: Option<u64>,
    /// RFC 3339.
    #[schema(format = DateTime)]
    created_at: String,
}

impl From<AssetRow> for AssetBody {
    fn from(asset: AssetRow) -> Self {
        Self {
            id: asset.id.to_string(),
            sha256: asset.sha256,
            bytes: asset.bytes,
            format: asset.format,
            name: asset.name,
            vertices: asset.vertices,
            faces: asset.faces,
            created_at: rfc3339(asset.created_at),
        }
    }
}

fn no_asset(id: Uuid) -> Problem {
    Problem::new(ProblemKind::NotFound, format!("There is no asset {id}."))
}

/// Uploads a mesh for later jobs. The same bytes lead to the same asset.
#[utoipa::path(post, path = "/v1/assets", tag = "assets", operation_id = "upload_asset",
    request_body(content = AssetForm, content_type = "multipart/form-data"),
    responses(
        (status = 200, description = "These bytes are known", body = AssetBody),
        (status = 201, description = "Stored", body = AssetBody),
    ))]
pub(super) async fn upload_asset(State(state): State<HttpState>, request: Request) -> Result<Response, Problem> {
    upload::judge_length(&state, request.headers())?;
    let invalid = |detail: String| Problem::new(ProblemKind::InvalidRequest, detail);
    let mut multipart =
        Multipart::from_request(request, &state).await.map_err(|rejection| invalid(rejection.body_text()))?;
    let mut files = Files::default();
    while let Some(field) = upload::next_field(&mut multipart).await? {
        match field.name() {
            Some("mesh") => files.receive(&state, field).await?,
            name => {
                let name = name.unwrap_or("without a name");
                return Err(invalid(format!("Send only parts `mesh`, not `{name}`.")));
            }
        }
    }
    let new = files.finish(&state).await?.accept(&state, true).await?;
    let asset = state.jobs.store.add_asset(&new).await?;
    let status = if asset.id == new.id { StatusCode::CREATED } else { StatusCode::OK };
    let location = format!("/v1/assets/{}", asset.id);
    Ok((status, [(header::LOCATION, location)], Json(AssetBody::from(asset))).into_response())
}

/// Shows an asset.
#[utoipa::path(get, path = "/v1/assets/{id}", tag = "assets", operation_id = "get_asset",
    params(("id" = Uuid, Path, description = "Id of the asset")),
    responses(
        (status = 200, description = "The asset", body = AssetBody),
    ))]
pub(super) async fn get_asset(State(state): State<HttpState>, Id(id): Id) -> Result<Json<AssetBody>, Problem> {
    let asset = state.jobs.store.asset(id).await?.filter(|asset| asset.pinned);
    asset.map(|asset| Json(asset.into())).ok_or_else(|| no_asset(id))
}

/// Deletes an asset that no waiting or running job uses.
#[utoipa::path(delete, path = "/v1/assets/{id}", tag = "assets", operation_id = "delete_asset",
    params(("id" = Uuid, Path, description = "Id of the asset")),
    responses(
        (status = 204, description = "Gone"),
    ))]
pub(super) async fn delete_asset(State(state): State<HttpState>, Id(id): Id) -> Result<StatusCode, Problem> {
    match state.jobs.store.delete_asset(id).await? {
        Deleted::Yes => Ok(StatusCode::NO_CONTENT),
        Deleted::Unknown => Err(no_asset(id)),
        Deleted::InUse => {
            let detail = "A job that has not finished uses this asset; cancel it or wait.";
            Err(Problem::new(ProblemKind::AssetInUse, detail))
        }
    }
}
