//! The table of the routes that are in the OpenAPI document.

use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::service::http::{HttpState, archive, artefacts, assets, events, health, jobs, listing, methods, spec};
use crate::service::wire::ProblemBody;

/// What the document says before its paths.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Quadrille",
        description = "A triangle mesh in, a parameterisation and a certified pure quad mesh out.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
    ),
    servers((url = "/", description = "The server that the document comes from")),
    components(schemas(ProblemBody)),
    tags(
        (name = "jobs", description = "Submit, follow, cancel, delete"),
        (name = "results", description = "Download what a job made"),
        (name = "assets", description = "Upload once, remesh many times"),
        (name = "about", description = "Methods and health"),
    )
)]
struct Frame;

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
