//! Buffer views compressed with `EXT_meshopt_compression` or its successor `KHR_meshopt_compression`.

use gltf::json::buffer;
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use serde_json::Value;

use super::super::error::ReadError;
use super::super::soup_builder::{ReadLimits, within};
use super::fault::malformed;

/// The extension of a compressed view.
pub(super) fn extension(view: &buffer::View) -> Option<&Value> {
    let extensions = &view.extensions.as_ref()?.others;
    extensions.get("EXT_meshopt_compression").or_else(|| extensions.get("KHR_meshopt_compression"))
}

/// What the extension says about a compressed view.
pub(super) struct Compressed<'a> {
    /// Where its bytes are.
    pub(super) buffer: usize,
    pub(super) offset: u64,
    pub(super) length: u64,
    count: u64,
    stride: u64,
    mode: &'a str,
    filter: &'a str,
}

impl<'a> Compressed<'a> {
    /// # Errors
    /// With the place of the view.
    pub(super) fn read(extension: &'a Value, place: &str) -> Result<Self, ReadError> {
        let number = |name: &str| extension.get(name).and_then(Value::as_u64);
        let needed = |name: &str| number(name).ok_or_else(|| malformed(place, format!("compressed without {name}")));
        Ok(Self {
            count: needed("count")?,
            stride: needed("byteStride")?,
            buffer: usize::try_from(needed("buffer")?).map_err(|_| malformed(place, "no such buffer"))?,
            offset: number("byteOffset").unwrap_or(0),
            length: needed("byteLength")?,
            mode: extension.get("mode").and_then(Value::as_str).unwrap_or_default(),
            filter: extension.get("filter").and_then(Value::as_str).unwrap_or("NONE"),
        })
    }

    /// Whether as many elements are allowed as it says it has.
    pub(super) fn judge(&self, limits: &ReadLimits) -> Result<(), ReadError> {
        if self.mode == "ATTRIBUTES" {
            within("vertices", self.count, limits.max_vertices)
        } else {
            within("indices", self.count, limits.max_polygons.saturating_mul(3))
        }
    }

    pub(super) fn unpacked_bytes(&self) -> u64 {
        self.count.saturating_mul(self.stride)
    }

    /// The bytes of the view.
    ///
    /// # Errors
    /// With the place of the view.
    pub(super) fn decode(&self, encoded: &[u8], place: &str) -> Result<Vec<u8>, ReadError> {
        let Self { mode, stride, filter, .. } = *self;
        let (n, broken) = (self.count as usize, || malformed(place, "the compressed bytes are broken"));
        match (mode, stride, filter) {
            ("ATTRIBUTES", 4..=256, _) if stride.is_multiple_of(4) => {
                let words = decode_words(encoded, n, stride as usize / 4).ok_or_else(broken)?;
                filtered(words, stride, filter, place)
            }
            // The decoder asserts whole triangles.
            ("TRIANGLES", 2, "NONE") if n.is_multiple_of(3) => {
                Ok(bytes_of_u16(&decode_index_buffer(encoded, n).map_err(|_| broken())?))
            }
            ("TRIANGLES", 4, "NONE") if n.is_multiple_of(3) => {
                Ok(bytes_of_u32(&decode_index_buffer(encoded, n).map_err(|_| broken())?))
            }
            ("INDICES", 2, "NONE") => Ok(bytes_of_u16(&decode_index_sequence(encoded, n).map_err(|_| broken())?)),
            ("INDICES", 4, "NONE") => Ok(bytes_of_u32(&decode_index_sequence(encoded, n).map_err(|_| broken())?)),
            _ => {
                let cause = format!("no compression of mode {mode:?}, byteStride {stride}, filter {filter:?}");
                Err(malformed(place, cause))
            }
        }
    }
}

/// Decoded attributes as machine words, `words` (1 to 64) per element. The decoder wants a type of the size of an
/// element, and arrays have a default value only up to 32 items, hence the pairs.
fn decode_words(encoded: &[u8], n: usize, words: usize) -> Option<Vec<u32>> {
    #[derive(Clone, Default)]
    #[repr(C)]
    struct Pair<A, B>(A, B);
    macro_rules! by_size {
        ($($size:literal)*) => {
            match words {
                $($size => Some(decode_vertex_buffer::<[u32; $size]>(encoded, n).ok()?.concat()),)*
                $(_ if words == 32 + $size => {
                    let elements = decode_vertex_buffer::<Pair<[u32; 32], [u32; $size]>>(encoded, n).ok()?;
                    let parts = elements.iter().flat_map(|element| element.0.iter().chain(&element.1));
                    Some(parts.copied().collect())
                })*
                _ => None,
            }
        };
    }
    by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32)
}

fn filtered(words: Vec<u32>, stride: u64, filter: &str, place: &str) -> Result<Vec<u8>, ReadError> {
    match (filter, stride) {
        ("NONE", _) => Ok(bytes_of_u32(&words)),
        ("EXPONENTIAL", _) => {
            // Each word is decoded by itself, whatever the stride.
            let mut words: Vec<[u32; 1]> = words.into_iter().map(|word| [word]).collect();
            decode_filter_exp(&mut words);
            Ok(bytes_of_u32(words.as_flattened()))
        }
        ("COLOR", 4) => {
            let mut colours: Vec<[u8; 4]> = words.into_iter().map(u32::to_ne_bytes).collect();
            decode_filter_color(&mut colours);
            Ok(colours.concat())
        }
        ("COLOR", 8) => {
            let halves = |word: u32| {
                let [a, b, c, d] = word.to_ne_bytes();
                [u16::from_ne_bytes([a, b]), u16::from_ne_bytes([c, d])]
            };
            let pairs = words.chunks_exact(2).map(|pair| (halves(pair[0]), halves(pair[1])));
            let mut colours: Vec<[u16; 4]> = pairs.map(|([r, g], [b, a])| [r, g, b, a]).collect();
            decode_filter_color(&mut colours);
            Ok(bytes_of_u16(colours.as_flattened()))
        }
        _ => Err(malformed(place, format!("the filter {filter:?} is not one for positions or colours"))),
    }
}

fn bytes_of_u16(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_ne_bytes()).collect()
}

fn bytes_of_u32(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_ne_bytes()).collect()
}
