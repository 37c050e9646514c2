//! The table of all routes, and the OpenAPI document that follows from it.

use std::sync::OnceLock;

use axum::Router;
use axum::http::Uri;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::service::http::{HttpState, artefacts, assets, body, events, health, jobs, layers, methods, pages};
use crate::service::wire::{Problem, ProblemKind};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Quadrille",
        description = "A triangle mesh in, a parameterisation and a certified pure quad mesh out.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
    ),
    tags(
        (name = "jobs", description = "Submit, follow, cancel, delete"),
        (name = "results", description = "Download what a job made"),
        (name = "assets", description = "Upload once, remesh many times"),
        (name = "about", description = "Methods and health"),
    )
)]
struct Document;

fn routes() -> OpenApiRouter<HttpState> {
    OpenApiRouter::with_openapi(Document::openapi())
        .routes(routes!(jobs::submit_job, jobs::list_jobs))
        .routes(routes!(jobs::get_job, jobs::delete_job))
        .routes(routes!(jobs::cancel_job))
        .routes(routes!(events::job_events))
        .routes(routes!(artefacts::quad_mesh))
        .routes(routes!(artefacts::parameterisation))
        .routes(routes!(artefacts::report))
        .routes(routes!(artefacts::preview))
        .routes(routes!(assets::upload_asset))
        .routes(routes!(assets::get_asset, assets::delete_asset))
        .routes(routes!(methods::list_methods))
        .routes(routes!(health::healthz))
        .routes(routes!(health::readyz))
        .routes(routes!(health::metrics))
}

/// The whole HTTP service.
pub fn router(state: HttpState) -> Router {
    let (api, _) = routes().split_for_parts();
    let all = api
        .route("/openapi.json", get(pages::openapi))
        .route("/docs", get(pages::docs))
        .route("/", get(pages::index))
        .fallback(unknown_route)
        .method_not_allowed_fallback(wrong_method)
        .layer(from_fn_with_state(state.clone(), body::guard))
        .with_state(state);
    layers::wrap(all)
}

/// The OpenAPI document of the handlers, as pretty JSON with a final newline: `api/openapi.json`.
pub fn openapi_json() -> String {
    document().to_owned()
}

/// The same, made once.
pub(super) fn document() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let (_, document) = routes().split_for_parts();
        document.to_pretty_json().map(|json| json + "\n").unwrap_or_default()
    })
}

async fn unknown_route(uri: Uri) -> Problem {
    Problem::new(ProblemKind::NotFound, format!("There is no route {}; see /docs.", uri.path()))
}

async fn wrong_method(uri: Uri) -> Problem {
    Problem::new(ProblemKind::MethodNotAllowed, format!("{} exists, but not with this method; see /docs.", uri.path()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checked_in_document_is_the_one_of_the_handlers() {
        let checked_in = include_str!("../../../api/openapi.json");
        assert!(checked_in == document(), "run: quadrille openapi > api/openapi.json");
    }
}
