//! The values of a PLY.

use glam::DVec3;

use super::super::error::ReadError;
use super::super::number::decimal;
use super::super::soup_builder::{NO_VALUE, ReadLimits, SoupBuilder};
use super::PLY;
use super::header::{Element, Encoding, Scalar, parse};
use crate::engine::mesh::TriangleSoup;

/// Reads vertices, faces and triangle strips, whatever the order of elements and properties; others are passed over.
///
/// # Errors
/// With the byte.
pub(in super::super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    let header = parse(bytes)?;
    let mut values = Values { bytes, at: header.end, encoding: header.encoding };
    let mut builder = SoupBuilder::new(limits);
    let n = header.elements.iter().filter(|element| element.name == "vertex").map(|element| element.count);
    let n = n.fold(0, u64::saturating_add);
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        match element.name.as_str() {
            "vertex" => {
                builder.claim_vertices(element.count)?;
                values.claim(element)?;
                read_vertices(element, &mut values, &mut builder)?;
            }
            "face" | "tristrips" if corners_of(element).is_some() => {
                if element.name == "face" {
                    builder.claim_triangles(element.count)?;
                }
                values.claim(element)?;
                read_faces(element, &mut values, n, &mut builder)?;
            }
            _ => {
                values.claim(element)?;
                for _ in 0..element.count {
                    for property in &element.properties {
                        values.skip(property.length, property.item)?;
                    }
                }
            }
        }
    }
    builder.finish(PLY)
}

fn read_vertices(element: &Element, values: &mut Values<'_>, builder: &mut SoupBuilder) -> Result<(), ReadError> {
    // The slot of each property in x y z r g b a, and what its values are divided by.
    let slots: Vec<Option<(usize, f64)>> = element
        .properties
        .iter()
        .map(|property| {
            let full = match property.item {
                Scalar::U8 => 255.0,
                Scalar::U16 => 65535.0,
                _ => 1.0,
            };
            let slot = match property.name.as_str() {
                "x" => (0, 1.0),
                "y" => (1, 1.0),
                "z" => (2, 1.0),
                "red" | "diffuse_red" | "r" => (3, full),
                "green" | "diffuse_green" | "g" => (4, full),
                "blue" | "diffuse_blue" | "b" => (5, full),
                "alpha" | "diffuse_alpha" | "a" => (6, full),
                _ => return None,
            };
            property.length.is_none().then_some(slot)
        })
        .collect();
    let has = |slot: usize| slots.iter().flatten().any(|&(s, _)| s == slot);
    if !(has(0) && has(1) && has(2)) {
        return Err(ReadError::malformed(PLY, "header", "the vertices lack x, y or z"));
    }
    let coloured = has(3) && has(4) && has(5);
    for _ in 0..element.count {
        let mut vertex = [f64::from(NO_VALUE); 7];
        for (property, slot) in element.properties.iter().zip(&slots) {
            match slot {
                Some((slot, full)) => vertex[*slot] = values.next(property.item)? / full,
                None => values.skip(property.length, property.item)?,
            }
        }
        let [x, y, z, r, g, b, a] = vertex;
        builder.vertex(DVec3::new(x, y, z))?;
        if coloured {
            builder.colour([r, g, b, a].map(|c| c as f32));
        }
    }
    Ok(())
}

fn corners_of(element: &Element) -> Option<usize> {
    let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    element.properties.iter().position(|property| property.length.is_some() && is_corners(&property.name))
}

fn read_faces(element: &Element, values: &mut Values<'_>, n: u64, builder: &mut SoupBuilder) -> Result<(), ReadError> {
    let is_strips = element.name == "tristrips";
    let corner_list = corners_of(element);
    let mut corners = Vec::new();
    for _ in 0..element.count {
        for (p, property) in element.properties.iter().enumerate() {
            let (Some(length), true) = (property.length, corner_list == Some(p)) else {
                values.skip(property.length, property.item)?;
                continue;
            };
            corners.clear();
            for _ in 0..values.length(length)? {
                let at = values.at;
                let index = values.next(property.item)?;
                if is_strips && index == -1.0 {
                    push_strip(&corners, builder)?;
                    corners.clear();
                } else if index >= 0.0 && index < n as f64 && index.fract() == 0.0 {
                    corners.push(index as u32);
                } else {
                    let place = format!("byte {at}");
                    return Err(ReadError::IndexOutOfRange { format: PLY, place, index: index as i64, count: n });
                }
            }
            if is_strips {
                push_strip(&corners, builder)?;
            } else {
                builder.polygon(&corners)?;
            }
        }
    }
    Ok(())
}

fn push_strip(strip: &[u32], builder: &mut SoupBuilder) -> Result<(), ReadError> {
    for (i, window) in strip.windows(3).enumerate() {
        let [a, b, c] = [window[0], window[1], window[2]];
        if a == b || b == c || c == a {
            builder.dropped(1);
        } else {
            builder.polygon(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] })?;
        }
    }
    Ok(())
}

struct Values<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Values<'_> {
    /// Fails if the elements cannot fit into the bytes that are left.
    fn claim(&self, element: &Element) -> Result<(), ReadError> {
        let left = (self.bytes.len() - self.at) as u64;
        let least = element.count.saturating_mul(element.least_size(self.encoding) as u64);
        // The last value of a text needs no blank behind it.
        if least > left + 1 {
            let cause =
                format!("truncated: {} {:?} elements do not fit into {left} bytes", element.count, element.name);
            return Err(ReadError::byte(PLY, self.at, cause));
        }
        Ok(())
    }

    fn next(&mut self, kind: Scalar) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            return self.next_word();
        }
        let mut value = [0; 8];
        let size = kind.size();
        let stored = self.bytes.get(self.at..self.at + size).ok_or_else(|| self.truncated())?;
        value[..size].copy_from_slice(stored);
        if self.encoding == Encoding::BigEndian {
            value[..size].reverse();
        }
        self.at += size;
        let [a, b, c, d, ..] = value;
        Ok(match kind {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(value),
        })
    }

    fn next_word(&mut self) -> Result<f64, ReadError> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(|| self.truncated())?;
        let rest = &rest[start..];
        self.at += start;
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let value = decimal(&rest[..end]).ok_or_else(|| {
            let word = String::from_utf8_lossy(&rest[..end.min(40)]);
            ReadError::byte(PLY, self.at, format!("{word:?} is not a number"))
        })?;
        self.at += end;
        Ok(value)
    }

    fn length(&mut self, kind: Scalar) -> Result<u64, ReadError> {
        let at = self.at;
        let length = self.next(kind)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= f64::from(u32::MAX) {
            Ok(length as u64)
        } else {
            Err(ReadError::byte(PLY, at, format!("a list of length {length}")))
        }
    }

    fn skip(&mut self, length: Option<Scalar>, item: Scalar) -> Result<(), ReadError> {
        let n = length.map_or(Ok(1), |kind| self.length(kind))?;
        for _ in 0..n {
            self.next(item)?;
        }
        Ok(())
    }

    fn truncated(&self) -> ReadError {
        ReadError::byte(PLY, self.bytes.len(), "truncated: values are missing")
    }
}

#[cfg(test)]
mod tests;
