//! Files of the command line: `-` is a pipe, and results appear all at once or not at all.

use std::io::{IsTerminal, Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use tempfile::NamedTempFile;

use crate::service::cli::failure::Failure;

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

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether files that are there already may be replaced.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct Overwrite {
    /// Replace files that exist; without it a terminal is asked, and otherwise they are kept
    #[arg(short, long)]
    force: bool,
}

impl Overwrite {
    /// Asks about files that exist. Devices and pipes are written to as they are.
    pub(super) fn allow<'a>(self, paths: impl IntoIterator<Item = &'a Path>) -> Result<Existing, Failure> {
        let mut replaced = self.force;
        for path in paths.into_iter().filter(|path| !self.force && !is_pipe(path) && path.is_file()) {
            if !(std::io::stdin().is_terminal() && is_confirmed(path)) {
                return Err(Failure::Usage(format!("{} exists; --force replaces it", path.display())));
            }
            replaced = true;
        }
        Ok(if replaced { Existing::Replace } else { Existing::Keep })
    }
}

fn is_confirmed(path: &Path) -> bool {
    eprint!("quadrille: replace {}? [y/N] ", path.display());
    let mut answer = String::new();
    std::io::stdin().read_line(&mut answer).is_ok() && matches!(answer.trim(), "y" | "Y" | "yes")
}

/// What becomes of a file that is there when a result is to get its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Existing {
    /// It stays, and the result is not written.
    #[default]
    Keep,
    /// The result takes its place.
    Replace,
}

/// Files that are written beside their places and renamed together, so that nobody sees half a result.
#[derive(Default)]
pub(super) struct Outputs {
    existing: Existing,
    ready: Vec<(NamedTempFile, PathBuf)>,
    /// What goes to pipes and devices, which cannot be renamed.
    direct: Vec<(PathBuf, Vec<u8>)>,
}

impl Outputs {
    pub(super) fn new(existing: Existing) -> Self {
        Self { existing, ..Self::default() }
    }

    /// Writes `bytes` beside `path`.
    pub(super) fn add(&mut self, path: &Path, bytes: Vec<u8>) -> Result<(), Failure> {
        if is_pipe(path) || path.exists() && !path.is_file() {
            self.direct.push((path.to_owned(), bytes));
            return Ok(());
        }
        let cannot = |error: std::io::Error| cannot_write(path, &error);
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

    /// Gives all files their names, in the order in which they were added, and fills the pipes.
    pub(super) fn publish(self) -> Result<(), Failure> {
        for (file, path) in self.ready {
            let named = match self.existing {
                Existing::Keep => file.persist_noclobber(&path),
                Existing::Replace => file.persist(&path),
            };
            named.map_err(|error| cannot_write(&path, &error.error))?;
        }
        for (path, bytes) in self.direct {
            let written = if is_pipe(&path) {
                let mut stdout = std::io::stdout().lock();
                stdout.write_all(&bytes).and_then(|()| stdout.flush())
            } else {
                std::fs::OpenOptions::new().write(true).open(&path).and_then(|mut file| file.write_all(&bytes))
            };
            written.map_err(|error| cannot_write(&path, &error))?;
        }
        Ok(())
    }
}

/// What goes to stdout: all of it or a failure.
pub(super) fn print(bytes: Vec<u8>) -> Result<(), Failure> {
    let mut outputs = Outputs::default();
    outputs.add(PIPE.as_ref(), bytes)?;
    outputs.publish()
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    let name = if is_pipe(path) { "to stdout".to_owned() } else { path.display().to_string() };
    Failure::Output(format!("cannot write {name}: {error}"))
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
    fn files_that_exist_are_replaced_only_by_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let write = |existing: Existing, bytes: &[u8]| {
            let mut outputs = Outputs::new(existing);
            outputs.add(&path, bytes.to_vec()).and_then(|()| outputs.publish())
        };
        let force = |force: bool| Overwrite { force }.allow([path.as_path()]);
        assert_eq!(force(false).unwrap(), Existing::Keep);
        write(Existing::Keep, b"first").unwrap();
        assert!(write(Existing::Keep, b"second").is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(force(true).unwrap(), Existing::Replace);
        write(Existing::Replace, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_stay_what_they_are() {
        let null = Path::new("/dev/null");
        let mut outputs = Outputs::new(Overwrite { force: false }.allow([null]).unwrap());
        outputs.add(null, vec![1]).unwrap();
        outputs.publish().unwrap();
        assert!(null.exists() && !null.is_file());
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
