//! The files that a job made.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// One file in the object store.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Artefact {
    /// Where it lies in the object store.
    pub blob: String,
    /// Lower-case hexadecimal SHA-256 of the bytes: the strong entity tag.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
    /// Media type.
    pub media_type: String,
}

/// All files of a job by name, e.g. `quad-mesh.obj`.
pub type Artefacts = BTreeMap<String, Artefact>;
