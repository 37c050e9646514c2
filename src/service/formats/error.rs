//! Why a file could not be read.

use crate::engine::run::{Blame, Fault};

/// Why a file could not be read: the cause and the place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// There is nothing to work on.
    #[error("the {format} file holds no polygons; send a surface, not points or lines")]
    Empty {
        /// Name of the format.
        format: &'static str,
    },
    /// The bytes belong to no format that is read here.
    #[error("the file is none of OBJ, GLB, glTF, PLY, STL or zip; name its format or convert it")]
    UnknownFormat,
    /// The bytes break the rules of their format.
    #[error("{format}, {place}: {cause}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// Line, byte or JSON pointer.
        place: String,
        /// What is wrong there.
        cause: String,
    },
    /// A polygon names a vertex that does not exist.
    #[error("{format}, {place}: index {index} is out of range, there are {count} vertices")]
    IndexOutOfRange {
        /// Name of the format.
        format: &'static str,
        /// Line, byte or JSON pointer.
        place: String,
        /// The index as the file says it.
        index: i64,
        /// Number of vertices.
        count: u64,
    },
    /// The file claims, or unpacks to, more than the limits allow.
    #[error("{claimed} {what} are more than the limit of {limit}; reduce the model")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much the file claims.
        claimed: u64,
        /// How much is allowed.
        limit: u64,
    },
    /// A glTF extension without which the geometry cannot be understood.
    #[error("the file requires the glTF extension {name}, which is not supported here; export it without")]
    UnsupportedExtension {
        /// Name of the extension.
        name: String,
    },
    /// A buffer that did not come with the file.
    #[error(
        "{uri:?} did not come with the file; put it beside the file, embed it, or use a GLB or a zip that holds both"
    )]
    MissingBuffer {
        /// The URI as the file says it.
        uri: String,
    },
    /// A mesh of quads was expected.
    #[error("{format}: face {face} has {degree} corners instead of 4")]
    NotQuads {
        /// Name of the format.
        format: &'static str,
        /// The face, counted from 0.
        face: u64,
        /// Number of its corners.
        degree: u64,
    },
}

impl ReadError {
    pub(super) fn malformed(format: &'static str, place: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Malformed { format, place: shortened(place.into()), cause: shortened(cause.into()) }
    }

    pub(super) fn line(format: &'static str, line: usize, cause: impl Into<String>) -> Self {
        Self::malformed(format, format!("line {line}"), cause)
    }

    pub(super) fn byte(format: &'static str, byte: usize, cause: impl Into<String>) -> Self {
        Self::malformed(format, format!("byte {byte}"), cause)
    }
}

/// Names and words come from the file and may be of any length.
fn shortened(text: String) -> String {
    match text.char_indices().nth(300) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

impl Blame for ReadError {
    fn fault(&self) -> Fault {
        match self {
            Self::TooLarge { .. } => Fault::Limit,
            _ => Fault::Input,
        }
    }

    fn elements(&self) -> Vec<u64> {
        match self {
            Self::NotQuads { face, .. } => vec![*face],
            _ => Vec::new(),
        }
    }
}
