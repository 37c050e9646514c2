//! The level of quads by name, as in reports, in what a spec accepts, and in problems.

use serde::{Deserialize, Serialize};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::engine::pipeline::Level;
use crate::service::wire::spec::choice::{Choice, choice_schema, choices};

/// Where quads come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the lines below say what each is")]
pub enum LevelName {
    L0,
    L1,
    L2,
    L3,
    L4,
}

choices! { LevelName as "LevelName": "Where quads come from; higher levels are fallbacks.", later [];
    L0 = "L0": "Field and map.";
    L1 = "L1": "Seamless map.";
    L2 = "L2": "Layout.";
    L3 = "L3": "Paired triangles of an isotropic remesh.";
    L4 = "L4": "Every triangle of a remesh split into three quads.";
}

impl LevelName {
    /// As in JSON.
    pub fn name(self) -> &'static str {
        Choice::name(self)
    }
}

impl PartialSchema for LevelName {
    fn schema() -> RefOr<Schema> {
        choice_schema::<Self>()
    }
}

impl ToSchema for LevelName {}

impl From<Level> for LevelName {
    fn from(level: Level) -> Self {
        match level {
            Level::L0 => LevelName::L0,
            Level::L1 => LevelName::L1,
            Level::L2 => LevelName::L2,
            Level::L3 => LevelName::L3,
            Level::L4 => LevelName::L4,
        }
    }
}
