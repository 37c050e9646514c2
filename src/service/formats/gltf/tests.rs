//! Documents for tests of the reader.

use glam::DVec3;
use serde_json::{Value, json};

use super::super::beside::Alone;
use super::super::glb_container;
use super::*;
use crate::engine::mesh::TriangleSoup;

/// Little-endian bytes of numbers.
macro_rules! bytes {
    ($kind:ty: $($x:expr),* $(,)?) => { [$(($x as $kind).to_le_bytes().as_slice()),*].concat() };
}

mod accessors;
mod compression;
mod faults;
mod geometry;

/// The square 0, x, x + y, y as float positions: 48 bytes.
fn square() -> Vec<u8> {
    bytes!(f32: 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
}

/// One mesh of one primitive over buffer 0, of which each item of `views` is a view and each of `accessors` an accessor.
fn document(primitive: Value, accessors: Value, views: Value, length: usize) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": length}],
    })
}

/// The square without indices or with what `more` puts behind its positions.
fn square_document(primitive: Value, more: &[u8], index: Option<Value>) -> (Value, Vec<u8>) {
    let bin = [square(), more.to_vec()].concat();
    let mut accessors = vec![json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"})];
    accessors.extend(index);
    let views = json!([
        {"buffer": 0, "byteLength": 48},
        {"buffer": 0, "byteOffset": 48, "byteLength": more.len()},
    ]);
    (document(primitive, json!(accessors), views, bin.len()), bin)
}

fn triangle() -> (Value, Vec<u8>) {
    let index = json!({"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"});
    square_document(json!({"attributes": {"POSITION": 0}, "indices": 1}), &bytes!(u16: 0, 1, 2), Some(index))
}

fn read_glb((json, bin): (Value, Vec<u8>)) -> Result<TriangleSoup, ReadError> {
    read(&glb_container::write(&json, bin), &Alone, &ReadLimits::default()).map(|model| model.soup)
}

fn polygons(soup: &TriangleSoup) -> Vec<Vec<u32>> {
    soup.polygons().map(<[u32]>::to_vec).collect()
}

fn patched(mut sample: (Value, Vec<u8>), pointer: &str, value: Value) -> (Value, Vec<u8>) {
    match sample.0.pointer_mut(pointer) {
        Some(slot) => *slot = value,
        None => {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            sample.0.pointer_mut(parent).unwrap()[key] = value;
        }
    }
    sample
}
