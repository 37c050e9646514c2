//! The header of a PLY: which elements follow, and how they are stored.

use super::super::error::ReadError;
use super::super::number::words;
use super::PLY;

/// How the values behind the header are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        match name {
            b"char" | b"int8" => Some(Self::I8),
            b"uchar" | b"uint8" => Some(Self::U8),
            b"short" | b"int16" => Some(Self::I16),
            b"ushort" | b"uint16" => Some(Self::U16),
            b"int" | b"int32" => Some(Self::I32),
            b"uint" | b"uint32" => Some(Self::U32),
            b"float" | b"float32" => Some(Self::F32),
            b"double" | b"float64" => Some(Self::F64),
            _ => None,
        }
    }

    /// Bytes of a binary value.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    /// Type of the length, if the property is a list.
    pub(super) length: Option<Scalar>,
    pub(super) item: Scalar,
}

/// An element and how many of it there are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one element takes.
    pub(super) fn least_size(&self, encoding: Encoding) -> usize {
        let sizes = self.properties.iter().map(|property| match encoding {
            // A digit and a blank.
            Encoding::Ascii => 2,
            _ => property.length.unwrap_or(property.item).size(),
        });
        sizes.sum()
    }
}

/// A parsed header.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the values begin.
    pub(super) end: usize,
}

/// Parses the header.
///
/// # Errors
/// With the line.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, ReadError> {
    let (mut encoding, mut elements, mut at, mut number) = (None, Vec::<Element>::new(), 0, 0);
    loop {
        number += 1;
        let fail = |cause: &str| ReadError::line(PLY, number, cause);
        let rest = &bytes[at..];
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let end = end.ok_or_else(|| fail("truncated: the header does not end"))?;
        let line: Vec<&[u8]> = words(&rest[..end]).collect();
        at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        match line.as_slice() {
            [b"ply"] if number == 1 => {}
            _ if number == 1 => return Err(fail("the file does not begin with \"ply\"")),
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, b"1.0"] => {
                encoding = Some(match *name {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(fail("an unknown format")),
                });
            }
            [b"element", name, count] => {
                let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                let count = count.ok_or_else(|| fail("the number of elements is not a number"))?;
                elements.push(Element { name: text(name), count, properties: Vec::new() });
            }
            [b"property", kind @ .., name] => {
                let scalar = |name: &[u8]| Scalar::named(name).ok_or_else(|| fail("an unknown type of property"));
                let (length, item) = match kind {
                    [item] => (None, scalar(item)?),
                    [b"list", length, item] => (Some(scalar(length)?), scalar(item)?),
                    _ => return Err(fail("a property without type or name")),
                };
                let element = elements.last_mut().ok_or_else(|| fail("a property before any element"))?;
                element.properties.push(Property { name: text(name), length, item });
            }
            [b"end_header"] => {
                let encoding = encoding.ok_or_else(|| fail("the header names no format"))?;
                return Ok(Header { encoding, elements, end: at });
            }
            _ => return Err(fail("an unknown statement in the header")),
        }
    }
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}
