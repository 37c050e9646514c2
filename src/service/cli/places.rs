//! Where results go: to one file, or for a batch to a folder or a pattern in which `{stem}` is the name of the input
//! without its ending.

use std::path::{Path, PathBuf};

use crate::service::cli::failure::Failure;
use crate::service::cli::files::is_pipe;

/// What stands for the name of the input.
const STEM: &str = "{stem}";

/// Whether each input has a place of its own.
pub(super) fn is_for_many(pattern: &Path) -> bool {
    is_folder(pattern) || pattern.to_string_lossy().contains(STEM)
}

/// Whether results go into a folder, under names that are made for them.
pub(super) fn is_folder(pattern: &Path) -> bool {
    pattern.to_string_lossy().ends_with(std::path::is_separator) || pattern.is_dir()
}

/// The place of what is made of `input`; `ending` follows its name in folders.
pub(super) fn place(pattern: &Path, input: &Path, ending: &str) -> Result<PathBuf, Failure> {
    if !is_for_many(pattern) {
        return Ok(pattern.to_owned());
    }
    let stem = input.file_stem().filter(|_| !is_pipe(input)).map(|stem| stem.to_string_lossy());
    let stem = stem.ok_or_else(|| {
        Failure::Usage(format!("{} has no name that could stand in {}", input.display(), pattern.display()))
    })?;
    if is_folder(pattern) {
        return Ok(pattern.join(format!("{stem}.{ending}")));
    }
    Ok(PathBuf::from(pattern.to_string_lossy().replace(STEM, &stem)))
}

/// Makes the folder that results go into, where it is not there yet.
pub(super) fn make_folder(pattern: &Path) -> Result<(), Failure> {
    if !is_folder(pattern) {
        return Ok(());
    }
    std::fs::create_dir_all(pattern)
        .map_err(|error| Failure::Usage(format!("cannot make the folder {}: {error}", pattern.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_input_has_its_place() {
        let place = |pattern: &str, input: &str| {
            place(Path::new(pattern), Path::new(input), "quads.obj").map(|path| path.to_str().unwrap().to_owned())
        };
        assert_eq!(place("a.obj", "in/b.stl").unwrap(), "a.obj");
        assert_eq!(place("no/such/", "in/b.c.stl").unwrap(), "no/such/b.c.quads.obj");
        assert_eq!(place("out/{stem}-{stem}.ply", "in/b.stl").unwrap(), "out/b-b.ply");
        let folder = tempfile::tempdir().unwrap();
        assert!(place(folder.path().to_str().unwrap(), "b.stl").unwrap().ends_with("/b.quads.obj"));
        assert!(place("-", "-").is_ok() && place("no/such/", "-").is_err());
        assert!(is_for_many("{stem}.obj".as_ref()) && !is_for_many("-".as_ref()));
    }
}
