//! Accessors: typed views of buffers, possibly interleaved, normalised, sparse.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::super::error::ReadError;
use super::document::Document;
use super::fault::{GLTF, malformed, missing};

/// An accessor whose ranges are proved to lie in its buffers. Nothing is read or allocated yet.
#[derive(Debug)]
pub(super) struct Accessor<'a> {
    pub(super) place: String,
    pub(super) count: usize,
    pub(super) components: usize,
    pub(super) kind: ComponentType,
    pub(super) normalised: bool,
    /// Bytes and distance of the elements; none means zeros.
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

#[derive(Debug)]
struct Sparse<'a> {
    count: usize,
    index_kind: ComponentType,
    indices: Strided<'a>,
    values: Strided<'a>,
}

impl<'a> Accessor<'a> {
    /// Accessor `i` of the document, which `from` asks for.
    pub(super) fn of(document: &'a Document<'_>, i: usize, from: &str) -> Result<Self, ReadError> {
        let place = format!("/accessors/{i}");
        let json = document.root.accessors.get(i).ok_or_else(|| missing(from, "accessor", i))?;
        let Checked::Valid(kind) = json.component_type else {
            return Err(malformed(place, "an unknown componentType"));
        };
        let kind = kind.0;
        let components = match json.type_ {
            Checked::Valid(Type::Scalar) => 1,
            Checked::Valid(Type::Vec2) => 2,
            Checked::Valid(Type::Vec3) => 3,
            Checked::Valid(Type::Vec4) => 4,
            Checked::Valid(Type::Mat4) => 16,
            _ => return Err(malformed(place, "a type that is neither scalar, vector nor matrix of 4 by 4")),
        };
        let element = components * kind.size();
        let count = usize::try_from(json.count.0).map_err(|_| malformed(&*place, "a count beyond memory"))?;
        let base = match json.buffer_view {
            Some(view) => {
                let offset = json.byte_offset.map_or(0, |offset| offset.0);
                Some(Strided::of(document, view.value(), offset, count, element, &place)?)
            }
            None => None,
        };
        let sparse = match &json.sparse {
            Some(sparse) => {
                let n = usize::try_from(sparse.count.0).ok().filter(|&n| n <= count);
                let n = n.ok_or_else(|| malformed(&*place, "more sparse values than elements"))?;
                let Checked::Valid(index_kind) = sparse.indices.component_type else {
                    return Err(malformed(place, "sparse indices of an unknown componentType"));
                };
                let (view, offset) = (sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0);
                let indices = Strided::of(document, view, offset, n, index_kind.0.size(), &place)?;
                let (view, offset) = (sparse.values.buffer_view.value(), sparse.values.byte_offset.0);
                let values = Strided::of(document, view, offset, n, element, &place)?;
                Some(Sparse { count: n, index_kind: index_kind.0, indices, values })
            }
            None => None,
        };
        Ok(Self { place, count, components, kind, normalised: json.normalized, base, sparse })
    }

    /// All components of all elements, in a row. Claim [`Self::count`] before: without a buffer view it is free to say
    /// anything.
    pub(super) fn floats(&self) -> Result<Vec<f64>, ReadError> {
        let n = self.components;
        let mut values = Vec::new();
        match self.base {
            Some(base) => {
                values.reserve_exact(self.count * n);
                for i in 0..self.count {
                    values.extend((0..n).map(|c| self.component(base, i, c)));
                }
            }
            None => values.resize(self.count * n, 0.0),
        }
        if let Some(sparse) = &self.sparse {
            for i in 0..sparse.count {
                let target = sparse.target(i, self)?;
                for c in 0..n {
                    values[target * n + c] = self.component(sparse.values, i, c);
                }
            }
        }
        Ok(values)
    }

    /// The first n elements, which must be matrices of floats by columns, in a row. Nothing is read behind them: many may
    /// ask for the first ones of a long list.
    pub(super) fn matrices(&self, n: usize) -> Result<Vec<[f64; 16]>, ReadError> {
        let base =
            self.base.filter(|_| self.components == 16 && self.kind == ComponentType::F32 && self.sparse.is_none());
        match base {
            Some(base) if n <= self.count => {
                Ok((0..n).map(|i| std::array::from_fn(|c| self.component(base, i, c))).collect())
            }
            _ => Err(malformed(&*self.place, format!("not the {n} matrices of floats that are asked for"))),
        }
    }

    /// All elements as indices; the first component of each.
    ///
    /// # Errors
    /// If the elements are not unsigned integers, or one is not below `limit`.
    pub(super) fn indices(&self, limit: usize) -> Result<Vec<u32>, ReadError> {
        if self.components != 1 || !matches!(self.kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(malformed(&*self.place, "indices must be unsigned integers"));
        }
        let mut indices = match self.base {
            Some(base) => (0..self.count).map(|i| unsigned(base, i, self.kind)).collect(),
            None => vec![0; self.count],
        };
        if let Some(sparse) = &self.sparse {
            for i in 0..sparse.count {
                indices[sparse.target(i, self)?] = unsigned(sparse.values, i, self.kind);
            }
        }
        match indices.iter().find(|&&index| index as usize >= limit) {
            Some(&index) => Err(self.out_of_range(index, limit)),
            None => Ok(indices),
        }
    }

    fn out_of_range(&self, index: u32, count: usize) -> ReadError {
        let (place, index, count) = (self.place.clone(), i64::from(index), count as u64);
        ReadError::IndexOutOfRange { format: GLTF, place, index, count }
    }

    fn component(&self, from: Strided<'_>, i: usize, c: usize) -> f64 {
        let at = i * from.stride + c * self.kind.size();
        let byte = |k: usize| from.bytes[at + k];
        let (value, full) = match self.kind {
            ComponentType::I8 => (f64::from(byte(0) as i8), 127.0),
            ComponentType::U8 => (f64::from(byte(0)), 255.0),
            ComponentType::I16 => (f64::from(i16::from_le_bytes([byte(0), byte(1)])), 32767.0),
            ComponentType::U16 => (f64::from(u16::from_le_bytes([byte(0), byte(1)])), 65535.0),
            ComponentType::U32 => (f64::from(u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])), 4294967295.0),
            ComponentType::F32 => return f64::from(f32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])),
        };
        if self.normalised { (value / full).max(-1.0) } else { value }
    }
}

impl<'a> Strided<'a> {
    /// Elements of `element` bytes in a view, proved to lie in it.
    fn of(
        document: &'a Document<'_>,
        view: usize,
        offset: u64,
        count: usize,
        element: usize,
        place: &str,
    ) -> Result<Self, ReadError> {
        let view = document.view(view, place)?;
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            return Err(malformed(place, format!("a byteStride of {stride} for elements of {element} bytes")));
        }
        let bytes = usize::try_from(offset).ok().and_then(|offset| view.bytes.get(offset..));
        let length = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(element));
        match (bytes, length) {
            (Some(bytes), Some(length)) if length <= bytes.len() => Ok(Self { bytes, stride }),
            _ => {
                let cause = format!(
                    "{count} elements of {element} bytes, {stride} apart, from byte {offset} reach past their view of {} bytes",
                    view.bytes.len()
                );
                Err(malformed(place, cause))
            }
        }
    }
}

impl Sparse<'_> {
    fn target(&self, i: usize, accessor: &Accessor<'_>) -> Result<usize, ReadError> {
        let target = unsigned(self.indices, i, self.index_kind);
        let in_range = (target as usize) < accessor.count;
        if in_range { Ok(target as usize) } else { Err(accessor.out_of_range(target, accessor.count)) }
    }
}

fn unsigned(from: Strided<'_>, i: usize, kind: ComponentType) -> u32 {
    let byte = |k: usize| from.bytes[i * from.stride + k];
    match kind.size() {
        1 => u32::from(byte(0)),
        2 => u32::from(u16::from_le_bytes([byte(0), byte(1)])),
        _ => u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]),
    }
}
