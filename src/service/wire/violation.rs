//! One field of a request that cannot be used.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// One field that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Violation {
    /// JSON pointer to the field; empty for the whole document.
    pub pointer: String,
    /// What is wrong and what is allowed.
    pub message: String,
}

impl Violation {
    /// A violation at a JSON pointer.
    pub fn new(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), message: message.into() }
    }
}
