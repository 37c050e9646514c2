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
mod tests {
    use super::*;

    const VERTICES: &str = "element vertex 4\nproperty uchar red\nproperty double z\nproperty list uchar short extra\n\
        property float x\nproperty uchar blue\nproperty float y\nproperty uchar green\n";

    fn header(encoding: &str, rest: &str) -> String {
        format!("ply\nformat {encoding} 1.0\ncomment x\nobj_info y\n{rest}end_header\n")
    }

    fn read_bytes(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
        read(bytes, &ReadLimits::default())
    }

    fn binary(big: bool) -> Vec<u8> {
        let faces = "element other 2\nproperty int a\nelement face 2\nproperty float quality\nproperty list uint ushort vertex_index\n";
        let name = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = header(name, &format!("{VERTICES}{faces}")).into_bytes();
        let mut push = |value: &[u8]| {
            let mut value = value.to_vec();
            if big {
                value.reverse();
            }
            bytes.extend(value);
        };
        for [x, y, z] in [[0.0, 0.0, 0.5f32], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]] {
            push(&[255]);
            push(&f64::from(z).to_le_bytes());
            push(&[2]);
            push(&7i16.to_le_bytes());
            push(&(-7i16).to_le_bytes());
            push(&x.to_le_bytes());
            push(&[0]);
            push(&y.to_le_bytes());
            push(&[51]);
        }
        push(&1i32.to_le_bytes());
        push(&2i32.to_le_bytes());
        for corners in [[0u16, 1, 2, 3].as_slice(), &[2, 1, 0]] {
            push(&1f32.to_le_bytes());
            push(&(corners.len() as u32).to_le_bytes());
            corners.iter().for_each(|c| push(&c.to_le_bytes()));
        }
        bytes
    }

    fn check(soup: &TriangleSoup) {
        let z = 0.5;
        let square = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        assert_eq!(soup.positions, square.map(DVec3::from_array));
        assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2, 3].as_slice(), &[2, 1, 0]]);
        assert_eq!(soup.colours, [[1.0, 0.2, 0.0, 1.0]; 4]);
    }

    #[test]
    fn every_encoding_and_order_of_properties() {
        check(&read_bytes(&binary(false)).unwrap());
        check(&read_bytes(&binary(true)).unwrap());
        let faces = "element face 2\nproperty list uchar int vertex_indices\n";
        let body = "255 0.5 0 0 0 0 51\n255 0.5 1 9 1 0 0 51\n255 .5 0 1 0 1 51 255 0.5 0 0 0 1 51\n4 0 1 2 3\n3 2 1 0";
        check(&read_bytes(format!("{}{body}", header("ascii", &format!("{VERTICES}{faces}"))).as_bytes()).unwrap());
    }

    #[test]
    fn strips_are_triangles() {
        let text = header(
            "ascii",
            "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
             element tristrips 1\nproperty list int int vertex_indices\n",
        ) + "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0\n9 0 1 2 3 -1 2 3 4 4";
        let soup = read_bytes(text.as_bytes()).unwrap();
        assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(soup.dropped_by_reader, 1);
    }

    #[test]
    fn every_truncation_is_told() {
        let bytes = binary(false);
        for end in 0..bytes.len() {
            assert!(read_bytes(&bytes[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn claims_are_judged_before_reading() {
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let claim = |count: &str, encoding: &str| {
            let faces = "element face 1\nproperty list uchar int vertex_indices\n";
            let text = header(encoding, &format!("element vertex {count}\n{xyz}{faces}"));
            read_bytes(text.as_bytes()).unwrap_err()
        };
        assert_eq!(
            claim("4000000000", "ascii"),
            ReadError::TooLarge { what: "vertices", claimed: 4_000_000_000, limit: 20_000_000 }
        );
        assert!(claim("19000000", "binary_big_endian").to_string().contains("truncated"));
        assert!(claim("-1", "ascii").to_string().contains("line 5"));
        let idle = header("ascii", "element nothing 18446744073709551615\nelement face 0\nproperty int a\n");
        assert_eq!(read_bytes(idle.as_bytes()).unwrap_err(), ReadError::Empty { format: "PLY" });
    }

    #[test]
    fn faults_have_a_place() {
        let text = |body: &str| {
            let xyz = "property float x\nproperty float y\nproperty float z\n";
            let faces = "element face 1\nproperty list char int vertex_indices\n";
            header("ascii", &format!("element vertex 1\n{xyz}{faces}")) + body
        };
        let fault = |body: &str| read_bytes(text(body).as_bytes()).unwrap_err().to_string();
        let start = text("").len();
        assert_eq!(
            fault("0 0 0 3 0 1 0"),
            format!("PLY, byte {}: index 1 is out of range, there are 1 vertices", start + 9)
        );
        assert_eq!(fault("0 0 0 3 0 -1 0").matches("index -1").count(), 1);
        assert!(fault("0 x 0 3 0 0 0").contains(&format!("byte {}: \"x\"", start + 2)));
        assert!(fault("0 0 0 -3 0 0 0").contains("list of length -3"));
        assert!(fault("0 0 0 3 0 0").contains("truncated"));
    }
}
