//! A binary glTF under construction: its bytes, and the views and accessors that say what they are.

use serde_json::{Value, json};

/// A file under construction.
pub(super) struct File {
    pub(super) bin: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

impl File {
    /// A view of all bytes from `start` on; its number. What is neither of vertices nor indices has no target.
    pub(super) fn view(&mut self, start: usize, target: Option<u32>) -> usize {
        let mut view = json!({"buffer": 0});
        if start > 0 {
            view["byteOffset"] = start.into();
        }
        view["byteLength"] = (self.bin.len() - start).into();
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    /// Fills up to where numbers may stand.
    pub(super) fn align(&mut self) {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
    }

    pub(super) fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    pub(super) fn floats(&mut self, values: impl Iterator<Item = f32>, count: usize, kind: &str) -> usize {
        let start = self.bin.len();
        self.bin.extend(values.flat_map(f32::to_le_bytes));
        let view = self.view(start, Some(34962));
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}))
    }
}

/// What every file says about itself.
pub(super) fn asset() -> Value {
    json!({"version": "2.0", "generator": concat!("Quadrille ", env!("CARGO_PKG_VERSION"))})
}

/// Appends positions in single precision; gives their minimum and maximum.
pub(super) fn push_positions(bin: &mut Vec<u8>, positions: impl Iterator<Item = glam::DVec3>) -> [[f32; 3]; 2] {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for position in positions {
        for (k, x) in position.as_vec3().to_array().into_iter().enumerate() {
            low[k] = low[k].min(x);
            high[k] = high[k].max(x);
            bin.extend_from_slice(&x.to_le_bytes());
        }
    }
    [low, high]
}
