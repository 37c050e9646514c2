//! Several files in one upload: a mesh and what lies beside it, such as a glTF with its buffers and images. They are kept
//! as one archive, which is read like one that was sent.

use std::fs::File;
use std::io::{self, Read};

use axum::extract::multipart::Field;
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;

use crate::service::formats::{Format, pack};
use crate::service::http::HttpState;
use crate::service::http::upload::{Upload, too_large};
use crate::service::jobs::{hex, run_blocking};
use crate::service::store::StoreError;
use crate::service::wire::{Problem, ProblemKind};

/// Far more than a mesh has images.
const MOST_FILES: usize = 1000;
/// Bytes that are hashed at once.
const PIECE: usize = 256 << 10;

/// The files of one upload so far.
#[derive(Debug, Default)]
pub(super) struct Files {
    files: Vec<(String, Upload)>,
    bytes: u64,
}

impl Files {
    /// Streams one more to disk.
    pub(super) async fn receive(&mut self, state: &HttpState, field: Field<'_>) -> Result<(), Problem> {
        let limit = state.jobs.limits.upload_bytes;
        let path = field.file_name().map(relative).unwrap_or_default();
        if self.files.len() == MOST_FILES {
            return Err(invalid(format!("An upload has at most {MOST_FILES} files.")));
        }
        if self.files.iter().any(|(known, _)| *known == path) {
            let detail = "Two parts `mesh` have the same file name; files beside a mesh are known by their names.";
            return Err(invalid(detail.to_owned()));
        }
        let upload = Upload::receive(state, field).await?;
        self.bytes += upload.bytes;
        if self.bytes > limit {
            return Err(too_large(limit));
        }
        self.files.push((path, upload));
        Ok(())
    }

    /// The upload: the file itself, or the archive of all. The first file with the ending of a mesh gives it its name.
    pub(super) async fn finish(mut self, state: &HttpState) -> Result<Upload, Problem> {
        if self.files.len() < 2 {
            let only = self.files.pop().map(|(_, upload)| upload);
            return only.ok_or_else(|| invalid("The part `mesh` with the file is missing.".to_owned()));
        }
        if self.files.iter().any(|(path, _)| path.is_empty()) {
            return Err(invalid("Every one of several files needs a name, inside the folder of the mesh.".to_owned()));
        }
        let leads =
            |path: &str| path.rsplit_once('.').is_some_and(|(_, ending)| Format::from_extension(ending).is_some());
        let name = self.files.iter().find(|(path, _)| leads(path)).and_then(|(_, upload)| upload.name.clone());
        let folder = state.uploads.clone();
        run_blocking(move || {
            let file = NamedTempFile::new_in(folder).map_err(failed)?;
            let (sha256, bytes) = self.pack_into(&file).map_err(failed)?;
            Ok(Upload { file, name, sha256, bytes })
        })
        .await
    }

    /// Hash and length of the archive.
    fn pack_into(&self, archive: &NamedTempFile) -> io::Result<(String, u64)> {
        let opened: io::Result<Vec<_>> =
            self.files.iter().map(|(path, upload)| Ok((path.as_str(), File::open(upload.file.path())?))).collect();
        pack(opened?, archive.as_file())?;
        let (mut hasher, mut bytes) = (Sha256::new(), 0);
        let (mut packed, mut piece) = (File::open(archive.path())?, vec![0; PIECE]);
        loop {
            match packed.read(&mut piece)? {
                0 => return Ok((hex(&hasher.finalize()), bytes)),
                n => {
                    hasher.update(&piece[..n]);
                    bytes += n as u64;
                }
            }
        }
    }
}

fn invalid(detail: String) -> Problem {
    Problem::new(ProblemKind::InvalidRequest, detail)
}

fn failed(source: io::Error) -> Problem {
    StoreError::File { what: "packing an upload", source }.into()
}

/// The path of a file within an upload; empty if it leads out of it. Of a path with a root only the name is kept.
fn relative(name: &str) -> String {
    let parts: Vec<_> = name.split(['/', '\\']).filter(|part| !part.is_empty() && *part != ".").collect();
    let rooted = name.starts_with(['/', '\\']) || parts.first().is_some_and(|part| part.ends_with(':'));
    let parts = if rooted { &parts[parts.len().saturating_sub(1)..] } else { &parts[..] };
    if parts.contains(&"..") {
        return String::new();
    }
    parts.join("/").chars().filter(|c| !c.is_control()).take(1000).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside_the_upload() {
        assert_eq!(relative("textures/a.png"), "textures/a.png");
        assert_eq!(relative("./textures\\a.png"), "textures/a.png");
        assert_eq!(relative("C:\\models\\a.obj"), "a.obj");
        assert_eq!(relative("/etc/passwd"), "passwd");
        assert_eq!(relative("../a.png"), "");
        assert_eq!(relative("a/../../b.png"), "");
        assert_eq!(relative("/"), "");
    }
}
