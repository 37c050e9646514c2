//! Files of frame fields, one line of numbers per face of a mesh.
//!
//! * `.rosy`: the number of faces, the degree 4, then per face one direction `x y z`, or all four of them.
//! * `.field` and `.ffield`, as VCG writes them: lines of words and comments after `#`, the number of faces, then per face
//!   `k1 k2 x y z x y z`, or the two vectors alone. k1 and k2 are not used.
//! * `.rawfield`, as Directional writes them: the degree 4 and the number of faces, then per face four vectors in
//!   counter-clockwise order, of which the last two are the first two reversed. `.matching` beside it: the degree and the
//!   number of lines, then `face face vertex vertex k` per edge: vector j of the first face goes on as j + k of the second.

use glam::DVec3;

use crate::engine::pipeline::{GivenMatching, GivenVectors};
use crate::service::formats::error::ReadError;

/// Vectors that are opposite in a file of decimal numbers differ by less than this share of their length.
const SAME: f64 = 1e-3;

/// A format of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFormat {
    /// One direction per face.
    Rosy,
    /// Two vectors per face.
    Field,
    /// Four vectors per face.
    RawField,
}

impl FieldFormat {
    /// The endings of their files.
    pub const ENDINGS: &'static str = ".rosy, .field, .ffield, .rawfield";

    /// The format of files with this ending.
    pub fn from_extension(ending: &str) -> Option<Self> {
        match ending.to_ascii_lowercase().as_str() {
            "rosy" => Some(Self::Rosy),
            "field" | "ffield" => Some(Self::Field),
            "rawfield" => Some(Self::RawField),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rosy => "rosy",
            Self::Field => "field",
            Self::RawField => "rawfield",
        }
    }
}

/// Reads the vectors of a field.
///
/// # Errors
/// [`ReadError`] where the bytes break the rules of the format, and for vectors that are zero or not finite.
pub fn read_field(bytes: &[u8], format: FieldFormat) -> Result<GivenVectors, ReadError> {
    let name = format.name();
    let mut rows = Rows::new(bytes, name)?;
    match format {
        FieldFormat::Rosy => {
            let faces = rows.whole()?;
            rows.degree()?;
            let vectors = rows.of_faces(faces, &[3, 12])?.into_iter().map(|row| vector(name, &row, 0));
            Ok(GivenVectors::Crosses(vectors.collect::<Result<_, _>>()?))
        }
        FieldFormat::Field => {
            let faces = rows.whole()?;
            let frames = rows.of_faces(faces, &[6, 8])?.into_iter().map(|row| {
                let at = row.numbers.len() - 6;
                Ok([vector(name, &row, at)?, vector(name, &row, at + 3)?])
            });
            Ok(GivenVectors::Frames(frames.collect::<Result<_, ReadError>>()?))
        }
        FieldFormat::RawField => {
            rows.degree()?;
            let faces = rows.whole()?;
            let frames = rows.of_faces(faces, &[12])?.into_iter().map(|row| {
                let [a, b, c, d] = [0, 3, 6, 9].map(|at| vector(name, &row, at));
                let [a, b, c, d] = [a?, b?, c?, d?];
                let is_reversed = |x: DVec3, y: DVec3| (x + y).length() <= SAME * x.length();
                if is_reversed(a, c) && is_reversed(b, d) {
                    return Ok([a, b]);
                }
                Err(ReadError::line(name, row.line, "the last two vectors are not the first two reversed"))
            });
            Ok(GivenVectors::Frames(frames.collect::<Result<_, ReadError>>()?))
        }
    }
}

/// Reads the matchings of a `.matching` file.
///
/// # Errors
/// [`ReadError`].
pub fn read_matchings(bytes: &[u8]) -> Result<Vec<GivenMatching>, ReadError> {
    const NAME: &str = "matching";
    let mut rows = Rows::new(bytes, NAME)?;
    rows.degree()?;
    let edges = rows.whole()?;
    let mut found = Vec::new();
    for row in rows.of_faces(edges, &[5])? {
        // A face of −1 is the outside of a boundary edge.
        if row.numbers[0] < 0.0 || row.numbers[1] < 0.0 {
            continue;
        }
        let whole = |k: usize| {
            let number = row.numbers[k];
            let is_index = number.fract() == 0.0 && (0.0..f64::from(u32::MAX)).contains(&number);
            is_index.then_some(number as u32).ok_or_else(|| ReadError::line(NAME, row.line, "not the index of a face"))
        };
        let quarters = row.numbers[4].rem_euclid(4.0);
        if quarters.fract() != 0.0 {
            return Err(ReadError::line(NAME, row.line, "the matching is no whole number"));
        }
        found.push(GivenMatching { from: whole(0)?, to: whole(1)?, quarters: quarters as u8 });
    }
    Ok(found)
}

/// A line of numbers.
struct Row {
    /// Counted from 1.
    line: usize,
    numbers: Vec<f64>,
}

/// The lines of numbers of a file. What stands in line may also be split over lines where only single numbers are read.
struct Rows<'a> {
    name: &'static str,
    lines: std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>,
    /// Numbers of the line that whole numbers are read from.
    begun: std::collections::VecDeque<(usize, f64)>,
}

impl<'a> Rows<'a> {
    fn new(bytes: &'a [u8], name: &'static str) -> Result<Self, ReadError> {
        let text = std::str::from_utf8(bytes)
            .map_err(|error| ReadError::byte(name, error.valid_up_to(), "not text in UTF-8"))?;
        Ok(Self { name, lines: text.lines().enumerate().peekable(), begun: std::collections::VecDeque::new() })
    }

    /// The next line that is neither empty nor a comment nor words.
    fn next(&mut self) -> Result<Option<Row>, ReadError> {
        for (i, text) in self.lines.by_ref() {
            let text = text.split('#').next().unwrap_or_default();
            let mut words = text.split_ascii_whitespace().peekable();
            let is_words = words.peek().is_some_and(|word| {
                let is_number = word.parse::<f64>().is_ok();
                !is_number && word.starts_with(|c: char| c.is_ascii_alphabetic())
            });
            if words.peek().is_none() || is_words {
                continue;
            }
            let number = |word: &str| {
                let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| ReadError::line(self.name, i + 1, format!("{word:?} is no finite number")))
            };
            return Ok(Some(Row { line: i + 1, numbers: words.map(number).collect::<Result<_, _>>()? }));
        }
        Ok(None)
    }

    /// A whole number.
    fn whole(&mut self) -> Result<usize, ReadError> {
        if self.begun.is_empty() {
            let row = self.next()?.ok_or_else(|| ReadError::malformed(self.name, "end of file", "no head"))?;
            self.begun.extend(row.numbers.into_iter().map(|number| (row.line, number)));
        }
        let (line, number) = self.begun.pop_front().unwrap_or((0, -1.0));
        let is_whole = number.fract() == 0.0 && (0.0..f64::from(u32::MAX)).contains(&number);
        is_whole.then_some(number as usize).ok_or_else(|| ReadError::line(self.name, line, "not a whole number"))
    }

    /// The degree, which must be 4.
    fn degree(&mut self) -> Result<(), ReadError> {
        match self.whole()? {
            4 => Ok(()),
            other => {
                let cause = format!("a field of degree {other}; quads need 4");
                Err(ReadError::malformed(self.name, "head", cause))
            }
        }
    }

    /// One row for each of so many faces, each of one of these lengths.
    fn of_faces(mut self, faces: usize, lengths: &[usize]) -> Result<Vec<Row>, ReadError> {
        let mut rows = Vec::new();
        while let Some(row) = self.next()? {
            if !lengths.contains(&row.numbers.len()) {
                let cause = format!("{} numbers instead of {}", row.numbers.len(), lengths[0]);
                return Err(ReadError::line(self.name, row.line, cause));
            }
            if rows.len() == faces {
                return Err(ReadError::line(self.name, row.line, format!("more lines than the {faces} of the head")));
            }
            rows.push(row);
        }
        if rows.len() < faces {
            let cause = format!("{} lines of the {faces} that the head promises", rows.len());
            return Err(ReadError::malformed(self.name, "end of file", cause));
        }
        Ok(rows)
    }
}

/// The vector at some place of a row.
fn vector(name: &'static str, row: &Row, at: usize) -> Result<DVec3, ReadError> {
    let vector = DVec3::from_slice(&row.numbers[at..]);
    if vector == DVec3::ZERO { Err(ReadError::line(name, row.line, "a vector is zero")) } else { Ok(vector) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_every_format_are_read() {
        let rosy = read_field(b"2\n4\n1 0 0\n0 -2.5 1e-1\n", FieldFormat::Rosy).unwrap();
        assert_eq!(rosy, GivenVectors::Crosses(vec![DVec3::X, DVec3::new(0.0, -2.5, 0.1)]));
        let frames = GivenVectors::Frames(vec![[DVec3::X, DVec3::new(0.5, 2.0, 0.0)]]);
        let field =
            b"# frame field\ntarget frame\n1\nk1\t k2\t k1v_x k1v_y k1v_z k2v_x k2v_y k2v_z\n7 8 1 0 0 .5 2 0\n";
        assert_eq!(read_field(field, FieldFormat::Field).unwrap(), frames);
        let raw = b"4 1\n1 0 0 0.5 2 0 -1 0 0 -0.5 -2 0\n";
        assert_eq!(read_field(raw, FieldFormat::RawField).unwrap(), frames);
        let matchings = read_matchings(b"4 3\n0 1 5 6 3\n-1 1 6 7 0\n2 1 1 2 -1\n").unwrap();
        let expected = [(0, 1, 3), (2, 1, 3)].map(|(from, to, quarters)| GivenMatching { from, to, quarters });
        assert_eq!(matchings, expected);
    }

    #[test]
    fn files_that_break_their_rules_are_refused_with_the_line() {
        use FieldFormat::{Field, RawField, Rosy};
        for (bytes, format, place) in [
            (&b""[..], Rosy, "end of file"),
            (b"2\n6\n1 0 0\n1 0 0\n", Rosy, "head"),
            (b"2\n4\n1 0 0\n", Rosy, "end of file"),
            (b"1\n4\n1 0 0\n1 0 0\n", Rosy, "line 4"),
            (b"1\n4\n1 0\n", Rosy, "line 3"),
            (b"1\n4\n0 0 0\n", Rosy, "line 3"),
            (b"1\n4\nnan 0 1\n", Rosy, "line 3"),
            (b"1\n4\n1 x 0\n", Rosy, "line 3"),
            (b"-1\n4\n", Rosy, "line 1"),
            (b"1\n1 0 0 0 1\n", Field, "line 2"),
            (b"4 1\n1 0 0 0 1 0 -1 0 0 0 1 0\n", RawField, "line 2"),
            (b"\xff\xfe", Rosy, "byte 0"),
        ] {
            let error = read_field(bytes, format).unwrap_err().to_string();
            assert!(error.contains(place), "{error}: {place}");
        }
        assert!(read_matchings(b"4 1\n0 1 5 6\n").is_err() && read_matchings(b"4 1\n0 1 5 6 0.5\n").is_err());
    }
}
