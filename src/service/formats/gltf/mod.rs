//! Reading glTF 2.0: JSON or GLB, all that bears on where the surface is. Materials, animations, cameras and morph
//! targets are passed over; skinned meshes are read in their bind pose.
//!
//! The crate `gltf` parses the JSON, without its validation, which refuses every required extension it was not compiled
//! with. So nothing is trusted here: every index, offset, stride and count is checked where it is used.

mod accessor;
mod document;
#[cfg(feature = "draco")]
mod draco;
mod meshopt;
mod primitive;
mod scene;
mod uri;

use super::error::ReadError;
use super::soup_builder::{ReadLimits, SoupBuilder};
use crate::engine::mesh::TriangleSoup;
use document::Document;
pub(super) use uri::{Files, NoFiles};

const GLTF: &str = "glTF";

/// Reads all instances of all meshes of the default scene into one soup.
///
/// # Errors
/// With the JSON pointer of the faulty element.
pub(super) fn read(bytes: &[u8], files: &dyn Files, limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    let document = Document::open(bytes, files, limits)?;
    let mut builder = SoupBuilder::new(limits);
    for instance in scene::instances(&document.root)? {
        primitive::append_mesh(&document, &instance, &mut builder)?;
    }
    builder.finish(GLTF)
}

fn malformed(place: impl Into<String>, cause: impl Into<String>) -> ReadError {
    ReadError::malformed(GLTF, place, cause)
}

#[cfg(test)]
mod tests;
