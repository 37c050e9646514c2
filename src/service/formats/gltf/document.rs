//! A parsed glTF and the bytes of its buffers, loaded when they are first asked for.

use std::cell::{Cell, OnceCell};

use gltf::json::Root;
use serde_json::Value;

use super::super::beside::Beside;
use super::super::error::ReadError;
use super::super::glb_container;
use super::super::soup_builder::{ReadLimits, within};
use super::draco_cache::DracoCache;
use super::fault::{malformed, missing};
use super::{meshopt, uri};

/// The extension of primitives that are compressed.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";

/// Extensions that change how the surface is stored.
const GEOMETRY: [&str; 4] = ["KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_meshopt_compression", DRACO];

/// Extensions that change nothing about where the surface is.
const HARMLESS: [&str; 9] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "KHR_animation_pointer",
    "FB_ngon_encoding",
];

/// A glTF with its buffers.
pub(super) struct Document<'a> {
    pub(super) root: Root,
    /// What the root was parsed from.
    pub(super) json: &'a [u8],
    pub(super) limits: ReadLimits,
    bin: Option<&'a [u8]>,
    beside: &'a dyn Beside,
    /// Buffers from URIs.
    loaded: Vec<OnceCell<Vec<u8>>>,
    /// Views that had to be decompressed.
    decompressed: Vec<OnceCell<Vec<u8>>>,
    unpacked: Cell<u64>,
    pub(super) draco: DracoCache,
}

/// The bytes of a buffer view.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: Option<usize>,
}

impl<'a> Document<'a> {
    /// Parses the JSON and checks that no extension is required that is not known here.
    pub(super) fn open(bytes: &'a [u8], beside: &'a dyn Beside, limits: &ReadLimits) -> Result<Self, ReadError> {
        let (json, bin) = if bytes.starts_with(b"glTF") {
            let chunks = glb_container::open(bytes)?;
            (chunks.json, chunks.bin)
        } else {
            (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None)
        };
        let root = Root::from_slice(json).map_err(|error| malformed("JSON", error.to_string()))?;
        if !root.asset.version.starts_with("2.") {
            return Err(malformed("/asset/version", format!("version {:?}; only 2 is read", root.asset.version)));
        }
        if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
            return Err(ReadError::UnsupportedExtension { name: name.chars().take(100).collect() });
        }
        let loaded = root.buffers.iter().map(|_| OnceCell::new()).collect();
        let decompressed = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        Ok(Self {
            root,
            json,
            limits: *limits,
            bin,
            beside,
            loaded,
            decompressed,
            unpacked: Cell::new(0),
            draco: DracoCache::default(),
        })
    }

    /// Counts bytes about to be unpacked against the limit.
    pub(super) fn unpack(&self, bytes: u64) -> Result<(), ReadError> {
        self.unpacked.set(self.unpacked.get().saturating_add(bytes));
        within("bytes unpacked", self.unpacked.get(), self.limits.max_bytes_unpacked)
    }

    /// The bytes behind a URI; they count as unpacked.
    pub(super) fn load(&self, uri: &str, place: &str) -> Result<Vec<u8>, ReadError> {
        let left = self.limits.max_bytes_unpacked.saturating_sub(self.unpacked.get());
        let bytes = uri::load(uri, self.beside, place, left)?;
        self.unpack(bytes.len() as u64)?;
        Ok(bytes)
    }

    /// The bytes of buffer `i`, which `from` asks for.
    fn buffer(&self, i: usize, from: &str) -> Result<&[u8], ReadError> {
        let place = format!("/buffers/{i}");
        let json = self.root.buffers.get(i).ok_or_else(|| missing(from, "buffer", i))?;
        let bytes = match (&json.uri, self.bin) {
            (Some(uri), _) => match self.loaded[i].get() {
                Some(bytes) => bytes.as_slice(),
                None => {
                    let bytes = self.load(uri, &place)?;
                    self.loaded[i].get_or_init(|| bytes)
                }
            },
            (None, Some(bin)) if i == 0 => bin,
            _ => return Err(ReadError::MissingBuffer { uri: place }),
        };
        let length = usize::try_from(json.byte_length.0).ok();
        length.and_then(|length| bytes.get(..length)).ok_or_else(|| {
            malformed(
                place,
                format!("truncated: byteLength is {}, there are {} bytes", json.byte_length.0, bytes.len()),
            )
        })
    }

    /// Bytes `offset..offset + length` of buffer `i`.
    pub(super) fn slice(&self, i: usize, offset: u64, length: u64, from: &str) -> Result<&[u8], ReadError> {
        let buffer = self.buffer(i, from)?;
        let range = usize::try_from(offset).ok().zip(offset.checked_add(length).and_then(|end| end.try_into().ok()));
        range.and_then(|(start, end): (usize, usize)| buffer.get(start..end)).ok_or_else(|| {
            let cause = format!("{length} bytes from {offset} reach past buffer {i} of {} bytes", buffer.len());
            malformed(from, cause)
        })
    }

    /// The bytes of buffer view `i`, decompressed if need be, which `from` asks for.
    pub(super) fn view(&self, i: usize, from: &str) -> Result<View<'_>, ReadError> {
        let place = format!("/bufferViews/{i}");
        let json = self.root.buffer_views.get(i).ok_or_else(|| missing(from, "buffer view", i))?;
        let stride = json.byte_stride.map(|stride| stride.0).filter(|&stride| stride > 0);
        if let Some(extension) = meshopt::extension(json) {
            let bytes = match self.decompressed[i].get() {
                Some(bytes) => bytes,
                None => {
                    let bytes = self.decompress(extension, &place)?;
                    self.decompressed[i].get_or_init(|| bytes)
                }
            };
            return Ok(View { bytes, stride });
        }
        let offset = json.byte_offset.map_or(0, |offset| offset.0);
        Ok(View { bytes: self.slice(json.buffer.value(), offset, json.byte_length.0, &place)?, stride })
    }

    /// The bytes of a compressed view; they count as unpacked.
    fn decompress(&self, extension: &Value, place: &str) -> Result<Vec<u8>, ReadError> {
        let compressed = meshopt::Compressed::read(extension, place)?;
        let encoded = self.slice(compressed.buffer, compressed.offset, compressed.length, place)?;
        compressed.judge(&self.limits)?;
        self.unpack(compressed.unpacked_bytes())?;
        compressed.decode(encoded, place)
    }
}

fn is_known(name: &str) -> bool {
    GEOMETRY.contains(&name) || HARMLESS.iter().any(|harmless| name.starts_with(harmless))
}
