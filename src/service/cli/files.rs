//! Files of the command line: `-` is a pipe, and results appear all at once or not at all.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::service::cli::Failure;

/// The name that stands for stdin or stdout.
const PIPE: &str = "-";

/// Whether this path stands for a pipe.
pub(super) fn is_pipe(path: &Path) -> bool {
    path.as_os_str() == PIPE
}

/// The ending of the file name, without its dot.
pub(super) fn extension(path: &Path) -> Option<&str> {
    path.extension().and_then(|ending| ending.to_str())
}

/// The whole file or stdin, refused when longer than `limit` bytes.
pub(super) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    let cannot = |error: std::io::Error| Failure::Input(format!("cannot read {}: {error}", path.display()));
    let mut bytes = Vec::new();
    let source: Box<dyn Read> =
        if is_pipe(path) { Box::new(std::io::stdin()) } else { Box::new(std::fs::File::open(path).map_err(cannot)?) };
    source.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > limit {
        return Err(Failure::Input(format!("{} has more than {limit} bytes", path.display())));
    }
    Ok(bytes)
}

/// Refuses a path that cannot become a file, before any work is done.
pub(super) fn check_writable(path: &Path) -> Result<(), Failure> {
    if is_pipe(path) {
        return Ok(());
    }
    if path.is_dir() {
        return Err(Failure::Usage(format!("{} is a folder; name a file", path.display())));
    }
    let folder = folder_of(path);
    if folder.is_dir() {
        Ok(())
    } else {
        Err(Failure::Usage(format!("the folder {} does not exist", folder.display())))
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Files that are written beside their places and renamed together, so that nobody sees half a result.
#[derive(Default)]
pub(super) struct Outputs {
    ready: Vec<(NamedTempFile, PathBuf)>,
    piped: Vec<Vec<u8>>,
}

impl Outputs {
    /// Writes `bytes` beside `path`.
    pub(super) fn add(&mut self, path: &Path, bytes: Vec<u8>) -> Result<(), Failure> {
        if is_pipe(path) {
            self.piped.push(bytes);
            return Ok(());
        }
        let cannot = |error: std::io::Error| Failure::Output(format!("cannot write {}: {error}", path.display()));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".quadrille-");
        #[cfg(unix)]
        {
            // Temporary files are private; a result gets what the umask of the user allows.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut file = builder.tempfile_in(folder_of(path)).map_err(cannot)?;
        file.write_all(&bytes).and_then(|()| file.as_file().sync_all()).map_err(cannot)?;
        self.ready.push((file, path.to_owned()));
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added, and empties the pipes.
    pub(super) fn publish(self) -> Result<(), Failure> {
        for (file, path) in self.ready {
            file.persist(&path)
                .map_err(|error| Failure::Output(format!("cannot write {}: {}", path.display(), error.error)))?;
        }
        let mut stdout = std::io::stdout().lock();
        for bytes in self.piped {
            stdout
                .write_all(&bytes)
                .and_then(|()| stdout.flush())
                .map_err(|error| Failure::Output(format!("cannot write to stdout: {error}")))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_appears_before_everything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.obj"), folder.path().join("b.json"));
        let mut outputs = Outputs::default();
        outputs.add(&a, b"v 0 0 0\n".to_vec()).unwrap();
        outputs.add(&b, b"{}".to_vec()).unwrap();
        assert!(!a.exists() && !b.exists());
        outputs.publish().unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), b"v 0 0 0\n");
        assert_eq!(std::fs::read(&b).unwrap(), b"{}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn an_unfinished_result_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let mut outputs = Outputs::default();
        outputs.add(&folder.path().join("a.obj"), vec![1]).unwrap();
        drop(outputs);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn places_are_judged_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        assert!(check_writable(&folder.path().join("no/such/a.obj")).is_err());
        assert!(check_writable(folder.path()).is_err());
        assert!(check_writable(&folder.path().join("a.obj")).is_ok());
        let file = folder.path().join("b");
        std::fs::write(&file, [0; 11]).unwrap();
        assert!(read(&file, 11).is_ok() && read(&file, 10).is_err());
    }
}
