//! Reading Universal Scene Description as text, as far as quads are written to it.

use std::collections::BTreeMap;

use glam::DVec3;

use super::error::ReadError;
use super::number::{decimal, integer};
use super::soup_builder::{ReadLimits, SoupBuilder};
use crate::engine::mesh::TriangleSoup;

const USDA: &str = "USDA";
/// Attribute of our own meshes: which vertex of the whole each point is. Meshes share vertices in it.
pub(super) const VERTICES: &str = "quadrille:vertices";

/// Reads all `Mesh` prims as polygons. Transforms, references and time samples are beyond this reader.
///
/// # Errors
/// [`ReadError`] with the line.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
    if !bytes.starts_with(b"#usda ") {
        return Err(ReadError::byte(USDA, 0, "the file does not begin with \"#usda \""));
    }
    let mut tokens = Tokens { bytes, at: 0 };
    let mut builder = SoupBuilder::new(limits);
    let (mut meshes, mut mesh, mut previous) = (Vec::new(), Prim::default(), [b"".as_slice(), b""]);
    let mut depth = 0i64;
    while let Some(token) = tokens.next()? {
        match (previous, token) {
            ([_, b"def"], b"Mesh") => meshes.push(std::mem::take(&mut mesh)),
            ([b"points", b"="], b"[") => mesh.points = tokens.points()?,
            ([b"faceVertexCounts", b"="], b"[") => mesh.counts = tokens.list(integer)?,
            ([b"faceVertexIndices", b"="], b"[") => mesh.indices = tokens.list(integer)?,
            ([name, b"="], b"[") if name == VERTICES.as_bytes() => mesh.vertices = tokens.list(integer)?,
            ([b"xformOpOrder", b"="], b"[") => return Err(tokens.fail("transforms are not supported; bake them")),
            (_, b"{") => depth += 1,
            (_, b"}") => depth -= 1,
            _ => {}
        }
        previous = [previous[1], token];
    }
    if depth != 0 {
        return Err(tokens.fail("truncated: the braces do not match"));
    }
    meshes.push(mesh);
    let joined = joined(&meshes);
    for p in joined.iter().flatten() {
        builder.vertex(*p)?;
    }
    for mesh in meshes {
        let numbers: Vec<u32> = match joined {
            Some(_) => mesh.vertices.iter().map(|&v| v as u32).collect(),
            None => {
                builder.claim_vertices(mesh.points.len() as u64)?;
                let first = builder.n_vertices() as u32;
                mesh.points.iter().try_for_each(|&p| builder.vertex(p))?;
                (first..).take(mesh.points.len()).collect()
            }
        };
        mesh.finish(&numbers, &mut builder, &tokens)?;
    }
    builder.finish(USDA)
}

/// The vertices of the whole, where all meshes say which of them their points are, and agree about where they are.
fn joined(meshes: &[Prim]) -> Option<Vec<DVec3>> {
    let mut vertices = BTreeMap::new();
    for mesh in meshes {
        let numbered = mesh.vertices.len() == mesh.points.len();
        for (&number, &p) in mesh.vertices.iter().zip(&mesh.points).filter(|_| numbered) {
            if *vertices.entry(number).or_insert(p) != p {
                return None;
            }
        }
        if !numbered {
            return None;
        }
    }
    vertices.keys().copied().eq(0..vertices.len() as i64).then(|| vertices.into_values().collect())
}

#[derive(Default)]
struct Prim {
    points: Vec<DVec3>,
    /// Per point, or empty.
    vertices: Vec<i64>,
    counts: Vec<i64>,
    indices: Vec<i64>,
}

impl Prim {
    /// Appends the polygons of a mesh whose points have these numbers.
    fn finish(self, numbers: &[u32], builder: &mut SoupBuilder, tokens: &Tokens<'_>) -> Result<(), ReadError> {
        let (mut rest, mut corners) = (self.indices.as_slice(), Vec::new());
        for count in self.counts {
            let polygon = usize::try_from(count).ok().and_then(|count| rest.split_at_checked(count));
            let (polygon, after) =
                polygon.ok_or_else(|| tokens.fail("faceVertexCounts asks for more indices than there are"))?;
            corners.clear();
            for &index in polygon {
                let number = usize::try_from(index).ok().and_then(|index| numbers.get(index));
                corners.push(*number.ok_or_else(|| {
                    let (place, count) = ("faceVertexIndices".to_owned(), numbers.len() as u64);
                    ReadError::IndexOutOfRange { format: USDA, place, index, count }
                })?);
            }
            builder.polygon(&corners)?;
            rest = after;
        }
        if rest.is_empty() { Ok(()) } else { Err(tokens.fail("more faceVertexIndices than faceVertexCounts asks for")) }
    }
}

/// Words, punctuation and strings (as one token with their quotes); comments are passed over.
struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    fn fail(&self, cause: impl Into<String>) -> ReadError {
        let line = 1 + self.bytes[..self.at.min(self.bytes.len())].iter().filter(|&&b| b == b'\n').count();
        ReadError::line(USDA, line, cause)
    }

    fn next(&mut self) -> Result<Option<&'a [u8]>, ReadError> {
        loop {
            let rest = &self.bytes[self.at..];
            let Some(&byte) = rest.first() else { return Ok(None) };
            let length = match byte {
                b'#' => {
                    self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                _ if byte.is_ascii_whitespace() || byte == b',' || byte == b';' => {
                    self.at += 1;
                    continue;
                }
                b'"' | b'\'' | b'@' => {
                    let triple = [byte; 3];
                    let quote = if rest.starts_with(&triple) { triple.as_slice() } else { &triple[..1] };
                    string_length(rest, quote).ok_or_else(|| self.fail("a string without an end"))?
                }
                _ if PUNCTUATION.contains(&byte) => 1,
                _ => {
                    let ends = |&b: &u8| b.is_ascii_whitespace() || PUNCTUATION.contains(&b) || b",;\"'@#".contains(&b);
                    rest.iter().position(ends).unwrap_or(rest.len())
                }
            };
            self.at += length;
            return Ok(Some(&rest[..length]));
        }
    }

    /// The points up to the closing bracket.
    fn points(&mut self) -> Result<Vec<DVec3>, ReadError> {
        let numbers = self.list(decimal)?;
        let (points, rest) = numbers.as_chunks::<3>();
        if rest.is_empty() {
            Ok(points.iter().copied().map(DVec3::from_array).collect())
        } else {
            Err(self.fail("a list of points whose length is no multiple of 3"))
        }
    }

    /// The numbers up to the closing bracket, brackets of tuples passed over.
    fn list<T>(&mut self, parse: fn(&[u8]) -> Option<T>) -> Result<Vec<T>, ReadError> {
        let mut items = Vec::new();
        loop {
            match self.next()?.ok_or_else(|| self.fail("a list without an end"))? {
                b"]" => return Ok(items),
                b"(" | b")" => {}
                token => items.push(parse(token).ok_or_else(|| {
                    self.fail(format!("{:?} is not a number", String::from_utf8_lossy(&token[..token.len().min(40)])))
                })?),
            }
        }
    }
}

/// Length of the string at the start of `text`, with its quotes.
fn string_length(text: &[u8], quote: &[u8]) -> Option<usize> {
    let mut at = quote.len();
    loop {
        match text.get(at..)? {
            [] => return None,
            rest if rest.starts_with(quote) => return Some(at + quote.len()),
            [b'\\', ..] => at += 2,
            _ => at += 1,
        }
    }
}

const PUNCTUATION: &[u8] = b"()[]{}=";

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "#usda 1.0\n( doc = \"\"\"points = [\\\"\"\n\"\"\" )\ndef Xform \"x\" {\ndef Mesh \"m\" (kind = \"a\") {\n\
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1e0, 0), (0, 1, 0)] # points\n\
        int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n}\n}\n";

    #[test]
    fn several_meshes_are_one_soup() {
        let text = format!("{SQUARE}{}", SQUARE.split_once('\n').unwrap().1);
        let soup = read(text.as_bytes(), &ReadLimits::default()).unwrap();
        assert_eq!(soup.positions.len(), 8);
        assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2, 3], [4, 5, 6, 7]]);
    }

    #[test]
    fn faults_are_told_with_their_line() {
        let fault = |from: &str, to: &str| {
            let text = SQUARE.replacen(from, to, 1);
            assert_ne!(text, SQUARE);
            read(text.as_bytes(), &ReadLimits::default()).unwrap_err().to_string()
        };
        assert!(fault("[0, 1, 2, 3]", "[0, 1, 2, 4]").contains("index 4"));
        assert!(fault("[4]", "[5]").contains("more indices"));
        assert!(fault("[4]", "[3]").contains("more faceVertexIndices"));
        assert!(fault("(0, 1, 0)]", "(0, 1)]").contains("multiple of 3"));
        assert!(fault("1e0", "one").contains("line 6: \"one\""));
        assert!(fault("\n}\n", "\nuniform token[] xformOpOrder = [\"a\"]").contains("transforms"));
        assert!(fault("#usda", "#usdc").contains("byte 0"));
    }
}
