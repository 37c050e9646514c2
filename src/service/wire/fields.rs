//! Reads a JSON object field by field, so that all violations are found and not only the first.
//!
//! serde stops at the first error of a document. Here every field is deserialised on its own and its error is noted
//! under its JSON pointer; what is left over at the end is an unknown field.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::service::wire::Violation;

/// The fields of one object that have not been read yet.
pub(in crate::service) struct Fields<'a> {
    object: Map<String, Value>,
    pointer: &'a str,
    known: Vec<&'static str>,
    violations: &'a mut Vec<Violation>,
}

impl<'a> Fields<'a> {
    /// Starts on `value`, which lies at the JSON pointer `pointer`; anything but an object is a violation.
    pub(in crate::service) fn of(value: Value, pointer: &'a str, violations: &'a mut Vec<Violation>) -> Self {
        let object = match value {
            Value::Object(object) => object,
            Value::Null => Map::new(),
            other => {
                violations.push(Violation::new(pointer, format!("must be an object, not {}", kind(&other))));
                Map::new()
            }
        };
        Self { object, pointer, known: Vec::new(), violations }
    }

    /// The raw value of the field `name`; `null` counts as absent.
    pub(in crate::service) fn raw(&mut self, name: &'static str) -> Option<Value> {
        self.known.push(name);
        self.object.shift_remove(name).filter(|value| !value.is_null())
    }

    /// Reads the field `name` into `slot`, which keeps its default when the field is absent or wrong.
    pub(in crate::service) fn read<T: DeserializeOwned>(&mut self, name: &'static str, slot: &mut T) {
        let Some(value) = self.raw(name) else { return };
        match serde_json::from_value(value) {
            Ok(read) => *slot = read,
            Err(error) => self.violations.push(Violation::new(format!("{}/{name}", self.pointer), error.to_string())),
        }
    }

    /// Every field that nobody asked for is a violation.
    pub(in crate::service) fn finish(self) {
        for (name, _) in self.object {
            let escaped = name.replace('~', "~0").replace('/', "~1");
            let message = format!("unknown field; known are {}", self.known.join(", "));
            self.violations.push(Violation::new(format!("{}/{escaped}", self.pointer), message));
        }
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}
