//! Closed strips of triangles: loops of the dual graph.

use crate::engine::mesh::{TriMesh, next, prev};

/// A side of a strip, as seen along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Bank {
    Left,
    Right,
}

/// A simple closed curve as the triangles that it runs through, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Strip {
    /// The halfedges that are crossed outwards, in order: the face of each is entered across the one before it.
    pub(super) crossed: Vec<usize>,
}

impl Strip {
    /// The faces in order.
    pub(super) fn faces(&self) -> impl Iterator<Item = usize> + '_ {
        self.crossed.iter().map(|h| h / 3)
    }

    /// Per face of the strip the halfedge that is not crossed, and the bank that it belongs to.
    pub(super) fn banks(&self, mesh: &TriMesh) -> Vec<(usize, Bank)> {
        let n = self.crossed.len();
        let of = |i: usize| {
            let out = self.crossed[i];
            let into = mesh.twin(self.crossed[(i + n - 1) % n]);
            // The edges that are crossed share the vertex between them, which lies on the other bank.
            if into == Some(prev(out)) { (next(out), Bank::Left) } else { (prev(out), Bank::Right) }
        };
        (0..n).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn the_strip_around_a_vertex_has_it_on_its_left() {
        let mesh = sample_surface("sphere", 500).unwrap().mesh;
        // The fan is counter-clockwise, so the vertex lies to the left.
        let crossed: Vec<usize> = mesh.fan(7).map(prev).collect();
        let strip = Strip { crossed };
        let outer: Vec<usize> = mesh.fan(7).map(next).collect();
        let banks = strip.banks(&mesh);
        assert!(banks.iter().all(|&(h, bank)| outer.contains(&h) && bank == Bank::Right), "{banks:?}");
    }
}
