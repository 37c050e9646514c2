//! A problem as JSON.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::service::wire::level::LevelName;
use crate::service::wire::violation::Violation;

/// `application/problem+json` (RFC 9457).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(example = json!({
    "type": "urn:quadrille:problem:invalid-spec", "title": "The spec cannot be used", "status": 422,
    "detail": "target.quads: must be from 1 to 10000000.",
    "errors": [{"pointer": "/target/quads", "message": "must be from 1 to 10000000"}],
}))]
pub struct ProblemBody {
    /// Stable URI of the kind of problem.
    #[serde(rename = "type")]
    pub type_: String,
    /// The kind in words.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// This occurrence in words.
    pub detail: String,
    /// The job or request it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instance: Option<String>,
    /// Stage of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// At most 20 offending elements in the numbering of the input.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<u64>,
    /// All violations of the request.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<Violation>,
    /// Seconds after which a new try makes sense.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retry_after: Option<u32>,
    /// The figures of a result that is not acceptable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub figures: Option<Figures>,
}

/// What a result reached, told when it misses what `accept` asks for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Figures {
    /// The worst level of the components.
    pub level: LevelName,
    /// Quads.
    pub quads: u64,
    /// Quads that were asked for; null where an edge length was.
    pub wanted: Option<u64>,
    /// How far `quads` is from `wanted`, as a share of it.
    pub count_error: Option<f64>,
    /// Largest distance between quads and surface, as a share of the diagonal of the bounding box.
    pub distance: f64,
}
