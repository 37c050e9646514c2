//! Whether the tables of an edited mesh agree with each other, for tests.

use crate::engine::mesh::remesh::edit::EditMesh;

impl EditMesh {
    /// The first disagreement between the tables, if there is one.
    pub(in crate::engine::mesh) fn fault(&self) -> Option<String> {
        for h in (0..3 * self.faces.len()).filter(|&h| self.is_alive(h / 3)) {
            let (a, b) = (self.origin(h), self.target(h));
            if let Some(t) = self.twin(h)
                && (!self.is_alive(t / 3) || (self.origin(t), self.target(t)) != (b, a) || self.twin(t) != Some(h))
            {
                return Some(format!("twin of {h}"));
            }
            if self.twin(h).is_some_and(|t| self.segment(t) != self.segment(h)) {
                return Some(format!("segments at {h}"));
            }
            if let Some(s) = self.segment(h) {
                let segment = self.curves.segment(s);
                if ![[a, b], [b, a]].contains(&segment.v) || segment.t[0] >= segment.t[1] {
                    return Some(format!("segment {segment:?} of {h} from {a} to {b}"));
                }
            }
        }
        (0..self.positions.len() as u32).filter(|&v| self.is_living_vertex(v)).find_map(|v| {
            let h = self.outgoing[v as usize] as usize;
            (!self.is_alive(h / 3) || self.origin(h) != v).then(|| format!("outgoing of {v}"))
        })
    }
}
