//! Warnings as JSON: what the engine says in one typed value, in the four members that clients can rely on.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;
use utoipa::openapi::schema::{Object, ObjectBuilder, Type};

use crate::engine::run::{Warning, WarningKind};

/// A soft trouble of a run whose quads are certified nevertheless.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WarningBody {
    /// The kind; stable.
    #[schema(schema_with = code_schema)]
    pub code: String,
    /// For people; may change with every version.
    pub message: String,
    /// The component that it is about, in order of first faces; null if it is about the whole model.
    pub component: Option<u32>,
    /// At most 20 places in model units.
    pub places: Vec<[f64; 3]>,
    /// The numbers of the message by name.
    #[schema(value_type = std::collections::BTreeMap<String, f64>)]
    pub numbers: Map<String, Value>,
}

impl From<&Warning> for WarningBody {
    fn from(warning: &Warning) -> Self {
        let number = |(name, value): (&str, f64)| {
            let whole = value.fract() == 0.0 && value.abs() < 2f64.powi(53);
            (name.to_owned(), if whole { Value::from(value as i64) } else { Value::from(value) })
        };
        Self {
            code: warning.kind.code().to_owned(),
            message: warning.kind.to_string(),
            component: warning.component,
            places: warning.places.iter().map(|place| place.to_array()).collect(),
            numbers: warning.kind.numbers().into_iter().map(number).collect(),
        }
    }
}

impl std::fmt::Display for WarningBody {
    /// One line, as on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: ", self.code)?;
        if let Some(component) = self.component {
            write!(f, "component {component}: ")?;
        }
        write!(f, "{}", self.message)
    }
}

/// The codes with their meaning, from the engine's table.
pub(super) fn code_schema() -> Object {
    let meanings = WarningKind::CODES.iter().map(|(code, meaning)| format!("`{code}`: {}", meaning.trim()));
    ObjectBuilder::new()
        .schema_type(Type::String)
        .enum_values(Some(WarningKind::CODES.iter().map(|(code, _)| *code)))
        .description(Some(meanings.collect::<Vec<_>>().join("\n")))
        .build()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_has_its_code_its_numbers_and_its_places() {
        let kind = WarningKind::Far { edges: 2.5, distance: 0.125 };
        let body = WarningBody::from(&Warning::new(kind, Some(3), &[glam::DVec3::ONE]));
        let json = serde_json::to_value(&body).unwrap();
        assert_eq!(json["code"], "far");
        assert_eq!(json["numbers"], serde_json::json!({"edges": 2.5, "distance": 0.125}));
        assert_eq!((&json["component"], &json["places"]), (&3.into(), &serde_json::json!([[1.0, 1.0, 1.0]])));
        assert!(body.to_string().starts_with("far: component 3: "));
    }
}
