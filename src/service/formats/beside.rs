//! What lies beside a file: the buffers and images that it names by relative URIs.

use std::fmt::Debug;

use super::error::ReadError;

/// Reads the external files of a main file: the other files of its folder, of its archive or of the same upload.
pub trait Beside: Debug + Sync {
    /// Reads the file at a relative path; `None` if there is no such file. Precondition: `path` separates its components
    /// by `/`, has no `..` component, is not absolute and has no URI scheme.
    ///
    /// # Errors
    /// If the file exists but cannot be read, or if it is larger than `limit` bytes.
    fn get(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, ReadError>;
}

/// There are no external files: every lookup gives `None`.
#[derive(Clone, Copy, Debug)]
pub struct Alone;

impl Beside for Alone {
    fn get(&self, _: &str, _: u64) -> Result<Option<Vec<u8>>, ReadError> {
        Ok(None)
    }
}
