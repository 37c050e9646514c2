//! Bytes of any format to a model.

use super::beside::{Alone, Beside};
use super::error::ReadError;
use super::format::Format;
use super::model::Model;
use super::soup_builder::ReadLimits;
use super::{archive, gltf, obj, ply, stl};
use crate::engine::mesh::TriangleSoup;

/// Reads polygons of a file that names no others: [`read_model`] without names, joints and warnings.
///
/// # Errors
/// As [`read_model`].
pub fn read_soup(bytes: &[u8], format: Option<Format>, limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    Ok(read_model(bytes, format, &Alone, limits)?.soup)
}

/// Reads a model, with the files beside it that it names; an archive holds its own. Without a format the first bytes tell
/// it. Vertices that a file splits for normals or texture
/// coordinates stay apart; every index of the result is in range.
///
/// # Errors
/// Every fault of the bytes with its cause and place. Nothing is allocated by what a header claims.
pub fn read_model(
    bytes: &[u8],
    format: Option<Format>,
    beside: &dyn Beside,
    limits: &ReadLimits,
) -> Result<Model, ReadError> {
    match format.or_else(|| Format::sniff(bytes)).ok_or(ReadError::UnknownFormat)? {
        Format::Zip => {
            let mesh = archive::open(bytes, limits)?;
            read_single(&mesh.bytes, mesh.format, &mesh.beside, &mesh.limits)
        }
        format => read_single(bytes, format, beside, limits),
    }
}

/// Reads a file that is no archive.
fn read_single(bytes: &[u8], format: Format, beside: &dyn Beside, limits: &ReadLimits) -> Result<Model, ReadError> {
    match format {
        Format::Obj => obj::read(bytes, limits),
        Format::Ply => ply::read(bytes, limits).map(Model::from),
        Format::Stl => stl::read(bytes, limits).map(Model::from),
        Format::Glb | Format::Gltf => gltf::read(bytes, beside, limits),
        Format::Zip => Err(ReadError::malformed("zip", "archive", "an archive in an archive")),
    }
}
