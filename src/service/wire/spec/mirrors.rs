//! Mirror planes: those across some axes, or those that the model has.

use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

use crate::engine::pipeline::Symmetry;
use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, FlagText, Kind, Values, json};
use crate::service::wire::spec::names::Axis;
use crate::service::wire::spec::one_of::{SomeOf, some_of};

const AUTO: &str = "auto";
const AXES: SomeOf<Axis> = some_of::<Axis>();
const HELP: &str = "Planes that the model nearly has, in any direction, up to three at right angles to each other.";

/// A list of axes, or `auto`.
pub(super) struct Mirrors;

impl Values for Mirrors {
    fn allowed(&self) -> String {
        format!("{}, or `{AUTO}`", AXES.allowed())
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        let mut choices = AXES.choices();
        choices.push((AUTO, HELP));
        choices
    }

    fn schema(&self) -> RefOr<Schema> {
        let auto = ObjectBuilder::new().schema_type(Type::String).enum_values(Some([AUTO])).description(Some(HELP));
        OneOfBuilder::new().item(AXES.schema()).item(auto).into()
    }

    fn components(&self) -> Vec<Component> {
        AXES.components()
    }

    fn flag_text(&self) -> FlagText {
        FlagText::NamesOr(AUTO)
    }
}

impl Kind for Mirrors {
    type Value = Symmetry;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Symmetry> {
        if !json.trim_start().starts_with('"') {
            return AXES.read(json, violations).map(Symmetry::Across);
        }
        if violations.parse::<String>(json)? == AUTO {
            return Some(Symmetry::Auto);
        }
        violations.add("", format!("must be a list of x, y, z, or {AUTO}"));
        None
    }

    fn write(&self, value: &Symmetry) -> serde_json::Result<Box<RawValue>> {
        match value {
            Symmetry::Across(axes) => AXES.write(axes),
            Symmetry::Auto => json(&AUTO),
        }
    }
}
