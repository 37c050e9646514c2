//! What Draco primitives were decompressed to, kept with the document: the instances of a mesh share it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// The primitives decompressed so far, by their JSON pointers.
pub(super) type DracoCache = RefCell<BTreeMap<String, Rc<Decoded>>>;

/// A decompressed primitive.
#[derive(Debug)]
pub(super) struct Decoded {
    /// Three per vertex.
    pub(super) positions: Vec<f64>,
    pub(super) colours: Option<Vec<[f32; 4]>>,
    /// With v upwards.
    pub(super) uv: Option<Vec<[f32; 2]>>,
    /// Four joint numbers and four weights per vertex.
    pub(super) influences: Option<(Vec<f64>, Vec<f64>)>,
    /// In range.
    pub(super) triangles: Vec<[u32; 3]>,
}
