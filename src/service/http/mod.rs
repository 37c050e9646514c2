//! HTTP (docs/contract.md, section 2). `router` is the table of all routes; every answer that is not a success is a problem
//! of the one table in `wire::problem`, also those of extractors, unknown routes, wrong methods and panics.

mod access;
mod archive;
mod artefacts;
mod assets;
mod body;
mod compression;
mod connections;
mod download;
mod events;
mod extract;
mod file_bytes;
mod health;
mod jobs;
mod json;
mod layers;
mod listing;
mod methods;
mod metrics;
mod names;
mod openapi;
mod pages;
mod problem;
mod query;
mod readiness;
mod router;
mod routes;
mod several;
mod spec;
mod state;
mod submit;
mod upload;
mod view;

pub use access::Access;
pub use connections::serve;
pub use readiness::Readiness;
pub use router::{openapi_json, router};
pub use state::HttpState;
