//! Reading STL.

use glam::DVec3;

use super::error::ReadError;
use super::number::{decimal, words};
use super::soup_builder::{ReadLimits, SoupBuilder};
use crate::engine::mesh::TriangleSoup;

const STL: &str = "STL";

/// Whether the count behind the 80 bytes of title fits the length exactly: text never does by chance, and binary files
/// whose title begins with "solid" are common.
pub(super) fn claims_binary_length(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|n| n > 0 && 84 + 50 * n == bytes.len() as u64)
}

fn count(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..84)?.try_into().ok()?;
    Some(u64::from(u32::from_le_bytes(count)))
}

/// Reads triangles, three new vertices each.
///
/// # Errors
/// With the line or byte.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    let head = &bytes[..bytes.len().min(1024)];
    let is_text =
        head.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !head.contains(&0);
    if is_text && !claims_binary_length(bytes) { read_text(bytes, limits) } else { read_binary(bytes, limits) }
}

fn read_binary(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    let n = count(bytes).ok_or_else(|| ReadError::byte(STL, bytes.len(), "truncated inside the header"))?;
    let mut builder = SoupBuilder::new(limits);
    builder.claim_triangles(n)?;
    builder.claim_vertices(3 * n)?;
    let triangles = usize::try_from(50 * n).ok().and_then(|size| bytes[84..].get(..size)).ok_or_else(|| {
        ReadError::byte(STL, 80, format!("truncated: {n} triangles do not fit into {} bytes", bytes.len()))
    })?;
    for triangle in triangles.chunks_exact(50) {
        let first = builder.n_vertices() as u32;
        for corner in triangle[12..48].chunks_exact(12) {
            let x = |k: usize| f32::from_le_bytes([corner[k], corner[k + 1], corner[k + 2], corner[k + 3]]);
            builder.vertex(DVec3::new(x(0).into(), x(4).into(), x(8).into()))?;
        }
        builder.polygon(&[first, first + 1, first + 2])?;
    }
    builder.finish(STL)
}

fn read_text(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    let mut builder = SoupBuilder::new(limits);
    let mut corners = Vec::new();
    let mut last = 0;
    for (i, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let mut words = words(line);
        let Some(word) = words.next() else { continue };
        last = i + 1;
        if word.eq_ignore_ascii_case(b"vertex") {
            let mut position = [0.0; 3];
            for x in &mut position {
                let number = words.next().and_then(decimal);
                *x = number.ok_or_else(|| ReadError::line(STL, i + 1, "a vertex needs three numbers"))?;
            }
            corners.push(builder.n_vertices() as u32);
            builder.vertex(DVec3::from_array(position))?;
        } else if word.eq_ignore_ascii_case(b"endloop") {
            builder.polygon(&corners)?;
            corners.clear();
        } else if !STATEMENTS.iter().any(|statement| word.eq_ignore_ascii_case(statement)) {
            let word = String::from_utf8_lossy(&word[..word.len().min(40)]);
            return Err(ReadError::line(STL, i + 1, format!("{word:?} is no statement of STL")));
        }
    }
    if corners.is_empty() { builder.finish(STL) } else { Err(ReadError::line(STL, last, "truncated inside a facet")) }
}

const STATEMENTS: [&[u8]; 6] = [b"solid", b"facet", b"outer", b"endfacet", b"endsolid", b"color"];

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid vertex thing\r\n facet normal 0 0 1\n  outer loop\n   VERTEX 0 0 0\n   vertex 1e0 0 0\n\
        vertex 0 1 nan\n endloop\n endfacet\nendsolid vertex thing\n";

    fn binary(title: &[u8], n: u32) -> Vec<u8> {
        let mut bytes = title.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(n.to_le_bytes());
        for x in [0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0, 0]);
        bytes
    }

    #[test]
    fn text_and_binary() {
        let text = read(TEXT.as_bytes(), &ReadLimits::default()).unwrap();
        assert_eq!(text.positions[..2], [DVec3::ZERO, DVec3::X]);
        assert!(text.positions[2].z.is_nan());
        for title in [b"binary".as_slice(), b"solid in name only"] {
            let soup = read(&binary(title, 1), &ReadLimits::default()).unwrap();
            assert_eq!(soup.positions, [DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, 0.5)]);
            assert_eq!(soup.polygon(0), [0, 1, 2]);
        }
    }

    #[test]
    fn faults_have_a_place() {
        let fault = |bytes: &[u8]| read(bytes, &ReadLimits::default()).unwrap_err().to_string();
        assert!(fault(&binary(b"x", 2)).contains("byte 80: truncated: 2 triangles"));
        assert!(fault(&binary(b"x", 1)[..70]).contains("truncated"));
        assert!(fault(TEXT.replace("1e0", "one").as_bytes()).contains("line 5"));
        assert!(fault(TEXT.split(" endloop").next().unwrap().as_bytes()).contains("line 6: truncated"));
        assert!(fault(TEXT.replace("outer", "inner").as_bytes()).contains("line 3: \"inner\""));
        assert!(fault(&binary(b"x", u32::MAX)).contains("4294967295 triangles are more than"));
        assert_eq!(fault(b"solid nothing\nendsolid nothing\n"), ReadError::Empty { format: "STL" }.to_string());
    }
}
