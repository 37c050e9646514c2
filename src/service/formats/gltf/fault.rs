//! What is wrong with a glTF, with the JSON pointer of the faulty element.

use super::super::error::ReadError;

/// The name of the format in errors.
pub(super) const GLTF: &str = "glTF";

/// The error of an element that breaks the rules.
pub(super) fn malformed(place: impl Into<String>, cause: impl Into<String>) -> ReadError {
    ReadError::malformed(GLTF, place, cause)
}

/// The error of an index that leads nowhere.
pub(super) fn missing(from: &str, what: &str, i: usize) -> ReadError {
    ReadError::Malformed { format: GLTF, place: from.to_owned(), cause: format!("there is no {what} {i}") }
}
