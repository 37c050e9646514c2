//! The files beside a mesh on the disk: those in its folder and below.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::service::cli::files::{folder_of, is_pipe};
use crate::service::formats::{Beside, ReadError};

/// The folder of a mesh. Nothing outside of it is ever opened, whatever links in it say.
#[derive(Debug)]
pub(super) struct Folder {
    /// Without links; none for what comes through a pipe.
    root: Option<PathBuf>,
}

impl Folder {
    /// The folder in which the file is, by its own path.
    pub(super) fn of(mesh: &Path) -> Self {
        Self { root: if is_pipe(mesh) { None } else { folder_of(mesh).canonicalize().ok() } }
    }
}

impl Beside for Folder {
    fn get(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, ReadError> {
        let Some(root) = &self.root else { return Ok(None) };
        let Ok(place) = root.join(path).canonicalize() else { return Ok(None) };
        // Opening a pipe or a device could wait for ever.
        if !place.starts_with(root) || !place.is_file() {
            return Ok(None);
        }
        let cannot = |error: std::io::Error| {
            let (format, place, cause) = ("file beside the mesh", path.to_owned(), error.to_string());
            ReadError::Malformed { format, place, cause }
        };
        let mut bytes = Vec::new();
        File::open(place)
            .and_then(|file| file.take(limit.saturating_add(1)).read_to_end(&mut bytes))
            .map_err(cannot)?;
        let claimed = bytes.len() as u64;
        if claimed > limit {
            return Err(ReadError::TooLarge { what: "bytes in a file beside the mesh", claimed, limit });
        }
        Ok(Some(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_the_folder_and_below_are_read_and_no_others() {
        let outer = tempfile::tempdir().unwrap();
        let root = outer.path().join("in");
        std::fs::create_dir_all(root.join("below")).unwrap();
        std::fs::write(outer.path().join("secret"), b"no").unwrap();
        std::fs::write(root.join("a.bin"), b"yes").unwrap();
        std::fs::write(root.join("below/b.bin"), b"yes").unwrap();
        let folder = Folder::of(&root.join("mesh.gltf"));
        let get = |path: &str| folder.get(path, 10).unwrap();
        assert_eq!(get("a.bin"), Some(b"yes".to_vec()));
        assert_eq!(get("below/b.bin"), Some(b"yes".to_vec()));
        let absolute = outer.path().join("secret");
        for outside in ["../secret", "below/../../secret", absolute.to_str().unwrap(), "below", ".", "", "missing"] {
            assert_eq!(get(outside), None, "{outside}");
        }
        assert!(matches!(folder.get("a.bin", 2), Err(ReadError::TooLarge { claimed: 3, limit: 2, .. })));
        assert_eq!(Folder::of(Path::new("-")).get("Cargo.toml", 1 << 20).unwrap(), None);
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out() {
        use std::os::unix::fs::symlink;
        let outer = tempfile::tempdir().unwrap();
        let root = outer.path().join("in");
        std::fs::create_dir_all(root.join("below")).unwrap();
        std::fs::write(outer.path().join("secret"), b"no").unwrap();
        std::fs::write(root.join("below/b.bin"), b"yes").unwrap();
        symlink(outer.path(), root.join("up")).unwrap();
        symlink(outer.path().join("secret"), root.join("link.bin")).unwrap();
        symlink("below/b.bin", root.join("inside.bin")).unwrap();
        symlink(&root, outer.path().join("alias")).unwrap();
        // Also where the folder itself is reached through a link.
        for mesh in [root.join("m.gltf"), outer.path().join("alias/m.gltf")] {
            let folder = Folder::of(&mesh);
            assert_eq!(folder.get("up/secret", 10).unwrap(), None);
            assert_eq!(folder.get("link.bin", 10).unwrap(), None);
            assert_eq!(folder.get("inside.bin", 10).unwrap(), Some(b"yes".to_vec()));
        }
    }
}
