//! Bytes of any format to a soup.

use super::error::ReadError;
use super::format::Format;
use super::gltf::{self, NoFiles};
use super::soup_builder::ReadLimits;
use super::{archive, obj, ply, stl};
use crate::engine::mesh::TriangleSoup;

/// Reads polygons. Without a format the first bytes tell it. Vertices that a file splits for normals or texture
/// coordinates stay apart; every index of the result is in range.
///
/// # Errors
/// Every fault of the bytes with its cause and place. Nothing is allocated by what a header claims.
pub fn read_soup(bytes: &[u8], format: Option<Format>, limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    match format.or_else(|| Format::sniff(bytes)).ok_or(ReadError::UnknownFormat)? {
        Format::Zip => archive::read(bytes, limits),
        format => read_single(bytes, format, limits),
    }
}

/// Reads a file that is no archive.
pub(super) fn read_single(bytes: &[u8], format: Format, limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    match format {
        Format::Obj => obj::read(bytes, limits),
        Format::Ply => ply::read(bytes, limits),
        Format::Stl => stl::read(bytes, limits),
        Format::Glb | Format::Gltf => gltf::read(bytes, &NoFiles, limits),
        Format::Zip => Err(ReadError::malformed("zip", "archive", "an archive in an archive")),
    }
}
