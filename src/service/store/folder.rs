//! Folders that only their owner may look into.

use std::fs::DirBuilder;
use std::io;
use std::path::Path;

/// Makes a folder and what is missing above it, closed to other users: uploads may be confidential. One that exists
/// keeps the rights that its owner gave it.
pub(in crate::service) fn private_folder(folder: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn new_folders_are_closed_to_others_and_old_ones_stay_as_they_are() {
        let rights = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let folder = tempfile::tempdir().unwrap();
        let (data, inner) = (folder.path().join("data"), folder.path().join("data/objects"));
        private_folder(&inner).unwrap();
        assert_eq!((rights(&data), rights(&inner)), (0o700, 0o700));
        std::fs::set_permissions(&data, PermissionsExt::from_mode(0o755)).unwrap();
        private_folder(&data).unwrap();
        assert_eq!(rights(&data), 0o755);
    }
}
