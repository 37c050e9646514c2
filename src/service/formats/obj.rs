//! Reading Wavefront OBJ.

use std::collections::BTreeMap;

use glam::DVec3;

use super::error::ReadError;
use super::model::{Model, ObjectName};
use super::number::{decimal, integer, words};
use super::soup_builder::{NO_VALUE, ReadLimits, SoupBuilder};

const OBJ: &str = "OBJ";

/// Whether these are the first bytes of an OBJ: text whose first statement is one of OBJ's.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(4096)];
    if head.contains(&0) {
        return false;
    }
    let statement = head.split(|&b| b == b'\n' || b == b'\r').filter_map(|line| words(line).next());
    let mut statements = statement.filter(|word| !word.starts_with(b"#"));
    match statements.next() {
        Some(word) => {
            matches!(
                word,
                b"v" | b"vt" | b"vn" | b"vp" | b"f" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl" | b"l" | b"p"
            )
        }
        // A comment longer than what we look at.
        None => head.starts_with(b"#"),
    }
}

/// Reads polygons of any degree, vertex colours, texture coordinates, normals, materials and the names of objects. Groups
/// and statements that are not known are passed over.
///
/// # Errors
/// [`ReadError`] with the line.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits) -> Result<Model, ReadError> {
    let mut reader = Reader {
        builder: SoupBuilder::new(limits),
        corners: Vec::new(),
        highest: None,
        uv: Named::default(),
        normals: Named::default(),
        objects: BTreeMap::new(),
    };
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let newline = if rest.contains(&b'\n') { b'\n' } else { b'\r' };
    let (mut number, mut joined) = (0, Vec::new());
    while !rest.is_empty() {
        let first = number + 1;
        let mut line = next_line(&mut rest, newline);
        number += 1;
        if line.ends_with(b"\\") {
            joined.clear();
            while let Some(part) = line.strip_suffix(b"\\") {
                joined.extend_from_slice(part);
                joined.push(b' ');
                line = next_line(&mut rest, newline);
                number += 1;
            }
            joined.extend_from_slice(line);
            line = &joined;
        }
        reader.statement(line, first)?;
    }
    reader.finish()
}

fn next_line<'a>(rest: &mut &'a [u8], newline: u8) -> &'a [u8] {
    let end = rest.iter().position(|&b| b == newline).unwrap_or(rest.len());
    let line = &rest[..end];
    *rest = rest.get(end + 1..).unwrap_or_default();
    line.strip_suffix(b"\r").unwrap_or(line)
}

struct Reader {
    builder: SoupBuilder,
    corners: Vec<u32>,
    /// The highest vertex named so far and the line that names it: vertices may follow the faces that name them.
    highest: Option<(u32, usize)>,
    uv: Named<2>,
    normals: Named<3>,
    /// Numbers of the objects by name.
    objects: BTreeMap<Vec<u8>, u32>,
}

/// Values that corners name.
#[derive(Default)]
struct Named<const N: usize> {
    /// In order.
    values: Vec<[f32; N]>,
    /// Per corner the value that it names, [`u32::MAX`] for none; empty as long as no corner names one. Values may follow
    /// the faces that name them.
    of_corner: Vec<u32>,
}

impl<const N: usize> Named<N> {
    /// One more value. What is no number is zero: shape does not depend on it.
    fn value(&mut self, rest: &[u8]) {
        let mut words = words(rest).map(|word| decimal(word).unwrap_or(0.0) as f32);
        self.values.push(std::array::from_fn(|_| words.next().unwrap_or(0.0)));
    }

    /// Notes what a corner names.
    fn name(&mut self, corner: usize, text: &[u8]) {
        let named = match integer(text) {
            Some(index @ 1..) => u32::try_from(index - 1).ok(),
            Some(index @ ..=-1) => u32::try_from(index + self.values.len() as i64).ok(),
            _ => None,
        };
        if let Some(named) = named {
            self.of_corner.resize(corner, u32::MAX);
            self.of_corner.push(named);
        }
    }

    /// The value of each of n corners, zeros for none; `None` if there is no value at all.
    fn of_corners(mut self, n: usize) -> Option<Vec<[f32; N]>> {
        let value = |&named: &u32| self.values.get(named as usize).copied();
        if !self.of_corner.iter().any(|named| value(named).is_some()) {
            return None;
        }
        self.of_corner.resize(n, u32::MAX);
        Some(self.of_corner.iter().map(|named| value(named).unwrap_or([0.0; N])).collect())
    }
}

impl Reader {
    fn statement(&mut self, line: &[u8], number: usize) -> Result<(), ReadError> {
        let line = line.trim_ascii_start();
        match line {
            [b'v', b' ' | b'\t', rest @ ..] => self.vertex(rest, number),
            [b'v', b't', b' ' | b'\t', rest @ ..] => {
                self.uv.value(rest);
                Ok(())
            }
            [b'v', b'n', b' ' | b'\t', rest @ ..] => {
                self.normals.value(rest);
                Ok(())
            }
            [b'f', b' ' | b'\t', rest @ ..] => self.face(rest, number),
            [b'u', b's', b'e', b'm', b't', b'l', b' ' | b'\t', name @ ..] => {
                self.builder.material(&String::from_utf8_lossy(name.trim_ascii()));
                Ok(())
            }
            [b'o', b' ' | b'\t', name @ ..] => {
                self.object(name.trim_ascii());
                Ok(())
            }
            _ if line.contains(&0) => Err(ReadError::line(OBJ, number, "a zero byte; this is not text")),
            _ => Ok(()),
        }
    }

    /// Objects of the same name are one.
    fn object(&mut self, name: &[u8]) {
        match self.objects.get(name) {
            Some(&number) => self.builder.object(number),
            None => {
                let text = String::from_utf8_lossy(name);
                let number = self.builder.new_object(ObjectName::new(&text, &text));
                self.objects.insert(name.to_vec(), number);
            }
        }
    }

    /// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`. The weight w belongs to rational curves, not to polygons.
    fn vertex(&mut self, rest: &[u8], number: usize) -> Result<(), ReadError> {
        let (mut values, mut n) = ([f64::from(NO_VALUE); 7], 0);
        for word in words(rest).take_while(|word| word[0] != b'#').take(7) {
            values[n] = decimal(word).ok_or_else(|| {
                ReadError::line(OBJ, number, format!("{:?} is not a number", String::from_utf8_lossy(word)))
            })?;
            n += 1;
        }
        if n < 3 {
            return Err(ReadError::line(OBJ, number, format!("a vertex with {n} coordinates instead of 3")));
        }
        let [x, y, z, r, g, b, a] = values;
        self.builder.vertex(DVec3::new(x, y, z))?;
        if n >= 6 {
            self.builder.colour([r, g, b, a].map(|c| c as f32));
        }
        Ok(())
    }

    fn face(&mut self, rest: &[u8], number: usize) -> Result<(), ReadError> {
        let n = self.builder.n_vertices();
        self.corners.clear();
        for word in words(rest).take_while(|word| word[0] != b'#') {
            let end = word.iter().position(|&b| b == b'/').unwrap_or(word.len());
            let index = integer(&word[..end]).ok_or_else(|| {
                ReadError::line(OBJ, number, format!("{:?} is not a corner", String::from_utf8_lossy(word)))
            })?;
            let corner = match index {
                1.. => index - 1,
                // −1 is the last vertex before this line.
                ..0 => index + n as i64,
                0 => -1,
            };
            let corner = u32::try_from(corner).map_err(|_| out_of_range(number, index, n))?;
            if self.highest.is_none_or(|(highest, _)| corner > highest) {
                self.highest = Some((corner, number));
            }
            if let Some(text) = word.get(end + 1..) {
                // The corners of this face before this one are no corners of the soup yet.
                let corner = self.builder.n_corners() + self.corners.len();
                let mut names = text.splitn(2, |&b| b == b'/');
                self.uv.name(corner, names.next().unwrap_or_default());
                self.normals.name(corner, names.next().unwrap_or_default());
            }
            self.corners.push(corner);
        }
        self.builder.polygon(&self.corners)?;
        self.uv.of_corner.truncate(self.builder.n_corners());
        self.normals.of_corner.truncate(self.builder.n_corners());
        Ok(())
    }

    fn finish(mut self) -> Result<Model, ReadError> {
        let n = self.builder.n_vertices();
        if let Some((highest, line)) = self.highest.filter(|&(highest, _)| highest as usize >= n) {
            return Err(out_of_range(line, i64::from(highest) + 1, n));
        }
        let n = self.builder.n_corners();
        if let Some(uv) = self.uv.of_corners(n) {
            self.builder.uv(uv.into_iter());
        }
        if let Some(normals) = self.normals.of_corners(n) {
            self.builder.normals(normals.into_iter());
        }
        self.builder.finish_model(OBJ)
    }
}

fn out_of_range(line: usize, index: i64, count: usize) -> ReadError {
    ReadError::IndexOutOfRange { format: OBJ, place: format!("line {line}"), index, count: count as u64 }
}

#[cfg(test)]
mod tests;
