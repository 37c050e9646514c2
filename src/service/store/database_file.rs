//! Whether the database is still the file that was opened.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use crate::service::store::StoreError;

/// A file that was there when the database was opened. SQLite goes on writing to a file that was unlinked or replaced,
/// and everything written after that is lost.
#[derive(Clone, Debug)]
pub(super) struct DatabaseFile {
    path: PathBuf,
    number: Option<(u64, u64)>,
}

impl DatabaseFile {
    /// The file that lies at `path` now.
    pub(super) fn at(path: &Path) -> Result<Self, StoreError> {
        let file = std::fs::metadata(path)
            .map_err(|source| StoreError::File { what: "finding the file of the database", source })?;
        Ok(Self { path: path.to_owned(), number: number(&file) })
    }

    /// Fails if another file, or none, lies there now. The file is only looked at and never opened: closing it would
    /// release the locks that SQLite holds on it for the whole process.
    pub(super) fn check(&self) -> Result<(), StoreError> {
        let same = std::fs::metadata(&self.path).is_ok_and(|file| number(&file) == self.number);
        if same { Ok(()) } else { Err(StoreError::Replaced(self.path.clone())) }
    }
}

/// The device and the number of the file on it, where the system has them.
fn number(file: &Metadata) -> Option<(u64, u64)> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Some((file.dev(), file.ino()))
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        None
    }
}
