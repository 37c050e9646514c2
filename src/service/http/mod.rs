//! HTTP (contract.md, section 2). `router` is the table of all routes; every answer that is not a success is a problem
//! of the one table in `wire::problem`, also those of extractors, unknown routes, wrong methods and panics.

mod artefacts;
mod assets;
mod body;
mod connections;
mod download;
mod events;
mod extract;
mod health;
mod jobs;
mod layers;
mod methods;
mod metrics;
mod pages;
mod problem;
mod router;
mod state;
mod submit;
mod upload;
mod view;

pub use connections::serve;
pub use health::Readiness;
pub use router::{openapi_json, router};
pub use state::HttpState;
