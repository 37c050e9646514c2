//! The table of all routes.

use axum::Router;
use axum::http::Uri;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::service::http::openapi::{Frame, document};
use crate::service::http::{
    HttpState, archive, artefacts, assets, body, events, health, jobs, layers, listing, methods, pages, spec,
};
use crate::service::wire::{Problem, ProblemKind};

/// All routes of the document.
pub(super) fn routes() -> OpenApiRouter<HttpState> {
    OpenApiRouter::with_openapi(Frame::openapi())
        .routes(routes!(jobs::submit_job, listing::list_jobs, listing::delete_jobs))
        .routes(routes!(listing::cancel_jobs))
        .routes(routes!(jobs::get_job, jobs::delete_job))
        .routes(routes!(jobs::cancel_job))
        .routes(routes!(spec::job_spec))
        .routes(routes!(events::job_events))
        .routes(routes!(artefacts::quad_mesh))
        .routes(routes!(artefacts::parameterisation))
        .routes(routes!(artefacts::report))
        .routes(routes!(artefacts::preview))
        .routes(routes!(archive::archive))
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
    let access = state.access.clone();
    let all = api
        .route("/openapi.json", get(pages::openapi))
        .route("/docs", get(pages::docs))
        .route("/", get(pages::index))
        .fallback(unknown_route)
        .method_not_allowed_fallback(wrong_method)
        .layer(from_fn_with_state(state.clone(), body::guard))
        .with_state(state);
    layers::wrap(all, &access)
}

/// The OpenAPI document of the handlers, as pretty JSON with a final newline: `api/openapi.json`.
pub fn openapi_json() -> String {
    document().to_owned()
}

async fn unknown_route(uri: Uri) -> Problem {
    Problem::new(ProblemKind::NotFound, format!("There is no route {}; see /docs.", uri.path()))
}

async fn wrong_method(uri: Uri) -> Problem {
    Problem::new(ProblemKind::MethodNotAllowed, format!("{} exists, but not with this method; see /docs.", uri.path()))
}
