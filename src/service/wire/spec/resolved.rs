//! A spec that was judged: what the engine is asked for, and what the service makes of it.

use crate::engine::pipeline::RemeshSpec;
use crate::service::wire::level::LevelName;
use crate::service::wire::spec::names::Output;

/// How the job is handled, apart from the geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct JobOptions {
    /// Seconds of run time, positive.
    pub deadline_s: f64,
    /// Labels for listing.
    pub tags: Vec<String>,
    /// −100 to 100; higher runs earlier.
    pub priority: i32,
}

impl Default for JobOptions {
    fn default() -> Self {
        Self { deadline_s: 300.0, tags: Vec::new(), priority: 0 }
    }
}

/// What a result must reach; `None` accepts anything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accept {
    /// The highest level.
    pub level: Option<LevelName>,
    /// How far the number of quads may be from the target, as a share of it.
    pub count: Option<f64>,
    /// How far quads and surface may be from each other, as a share of the diagonal.
    pub distance: Option<f64>,
}

/// A spec that was found valid. `Default` is the contract's default of every field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResolvedSpec {
    /// What the engine is asked for.
    pub spec: RemeshSpec,
    /// Kind of the resulting mesh; there is one so far.
    pub output: Output,
    /// What the result must reach.
    pub accept: Accept,
    /// How the job is handled.
    pub options: JobOptions,
}
