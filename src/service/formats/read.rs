//! Bytes of any format to a soup.

use super::error::ReadError;
use super::format::Format;
use super::soup_builder::ReadLimits;
use super::{obj, ply, stl};
use crate::engine::mesh::TriangleSoup;

/// Reads polygons. Without a format the first bytes tell it. Vertices that a file splits for normals or texture
/// coordinates stay apart; every index of the result is in range.
///
/// # Errors
/// Every fault of the bytes with its cause and place. Nothing is allocated by what a header claims.
pub fn read_soup(bytes: &[u8], format: Option<Format>, limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    match format.or_else(|| Format::sniff(bytes)).ok_or(ReadError::UnknownFormat)? {
        Format::Obj => obj::read(bytes, limits),
        Format::Ply => ply::read(bytes, limits),
        Format::Stl => stl::read(bytes, limits),
        Format::Glb | Format::Gltf | Format::Zip => Err(ReadError::UnknownFormat),
    }
}
