//! The density: quads of the whole model, or the length of their edges.

use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder};
use utoipa::openapi::{Ref, RefOr, Schema};

use crate::engine::pipeline::Target;
use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, Kind, Values, json};
use crate::service::wire::spec::kinds::{Number, Whole};

const SCHEMA: &str = "TargetBody";
const QUADS: Whole<u64> = Whole { low: 1, high: 10_000_000 };
const EDGE_LENGTH: Number = Number::above(0.0);

/// `{"quads": N}` or `{"edge_length": L}`.
pub(super) struct Density;

impl Values for Density {
    fn allowed(&self) -> String {
        format!("`{{\"quads\": N}}`, {}, or `{{\"edge_length\": L}}`, {}", QUADS.allowed(), EDGE_LENGTH.allowed())
    }

    fn schema(&self) -> RefOr<Schema> {
        Ref::from_schema_name(SCHEMA).into()
    }

    fn components(&self) -> Vec<Component> {
        let member = |name: &str, schema: RefOr<Schema>, help: &str| {
            ObjectBuilder::new().property(name, schema).required(name).description(Some(help))
        };
        let schema = OneOfBuilder::new()
            .item(member("quads", QUADS.schema(), "Quads of the whole model."))
            .item(member("edge_length", EDGE_LENGTH.schema(), "Edge length in model units."))
            .description(Some("The density asked for."));
        vec![(SCHEMA.to_owned(), schema.into())]
    }
}

impl Kind for Density {
    type Value = Target;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Target> {
        let (quads, edge_length) =
            violations.object(json, |fields| (fields.take("quads"), fields.take("edge_length")))?;
        match (quads, edge_length) {
            (Some(quads), None) => QUADS.read(quads, &mut violations.below("quads")).map(Target::Quads),
            (None, Some(length)) => {
                EDGE_LENGTH.read(length, &mut violations.below("edge_length")).map(Target::EdgeLength)
            }
            _ => {
                violations.add("", "must have exactly one of quads, edge_length");
                None
            }
        }
    }

    fn write(&self, value: &Target) -> serde_json::Result<Box<RawValue>> {
        json(&match *value {
            Target::Quads(quads) => serde_json::json!({ "quads": quads }),
            Target::EdgeLength(length) => serde_json::json!({ "edge_length": length }),
        })
    }
}
