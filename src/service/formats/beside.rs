//! What lies beside a file: the buffers and images that it names by relative URIs.

use std::fmt::Debug;

use super::error::ReadError;

/// The files beside a main file: those of its folder, of its archive, or of the same upload.
pub trait Beside: Debug + Sync {
    /// The file at this relative path, of at most `limit` bytes; `None` if it is not there. Paths have `/` between their
    /// parts, none of which is `..`, and no root and no scheme.
    ///
    /// # Errors
    /// If it is there and cannot be had, or is larger.
    fn get(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, ReadError>;
}

/// No files but the main one.
#[derive(Clone, Copy, Debug)]
pub struct Alone;

impl Beside for Alone {
    fn get(&self, _: &str, _: u64) -> Result<Option<Vec<u8>>, ReadError> {
        Ok(None)
    }
}
