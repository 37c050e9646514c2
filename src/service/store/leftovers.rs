//! What a process that was killed leaves in the folder of the blobs beside blobs: files that were being written, which
//! the object store names `KEY#N` and shows to nobody, probes, and empty folders.

use std::path::Path;
use std::time::{Duration, SystemTime};

use walkdir::WalkDir;

use crate::service::store::blobs::PROBES;
use crate::service::store::{Store, StoreError};

impl Store {
    /// Removes leftovers that are older than `age`; younger ones may belong to a request that is under way. Returns how
    /// many there were.
    pub async fn remove_leftovers(&self, age: Duration) -> Result<usize, StoreError> {
        let folder = self.blobs().folder().to_owned();
        tokio::task::spawn_blocking(move || sweep(&folder, age))
            .await
            .map_err(|error| StoreError::File { what: "sweeping the store", source: error.into() })
    }
}

fn sweep(folder: &Path, age: Duration) -> usize {
    let probes = folder.join(PROBES);
    let is_old = |entry: &walkdir::DirEntry| {
        let written = entry.metadata().ok().and_then(|meta| meta.modified().ok());
        written.and_then(|written| SystemTime::now().duration_since(written).ok()).is_some_and(|since| since >= age)
    };
    // The age of a folder is taken before its contents go, which makes it young.
    let entries: Vec<_> = WalkDir::new(folder).min_depth(1).contents_first(true).into_iter().flatten().collect();
    let old: Vec<_> = entries.into_iter().filter(is_old).collect();
    let removed = old.iter().filter(|entry| {
        let path = entry.path();
        if entry.file_type().is_dir() {
            // Fails, as it should, unless the folder is empty.
            std::fs::remove_dir(path).is_ok()
        } else {
            (is_unfinished(path) || path.starts_with(&probes)) && std::fs::remove_file(path).is_ok()
        }
    });
    removed.count()
}

fn is_unfinished(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let number = name.and_then(|name| name.rsplit_once('#')).map(|(_, number)| number);
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_old_leftovers_go() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        for inner in ["assets", "jobs/a/1", "jobs/b/1", "ready"] {
            std::fs::create_dir_all(root.join(inner)).unwrap();
        }
        for file in ["assets/x", "assets/x#1", "jobs/b/1/report.json", "ready/y"] {
            std::fs::write(root.join(file), "z").unwrap();
        }
        assert_eq!(sweep(root, Duration::from_secs(60)), 0);
        assert_eq!(sweep(root, Duration::ZERO), 5, "x#1, y, ready, jobs/a/1, jobs/a");
        assert!(root.join("assets/x").exists() && root.join("jobs/b/1/report.json").exists());
        assert!(!root.join("jobs/a").exists() && !root.join("assets/x#1").exists() && !root.join("ready").exists());
    }
}
