//! The faces of an embedded graph, numbered, and the surface that they make.

use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;

/// Faces in order of their lowest dart.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    /// Per dart, the face to its left; unspecified for dead darts.
    pub(super) of: Vec<u32>,
    /// Per face, its lowest dart.
    pub(super) first: Vec<u32>,
    /// Per face, its degree (number of darts).
    pub(super) len: Vec<u32>,
    /// Per face, whether it lies outside of the surface, beyond a boundary loop.
    pub(super) outside: Vec<bool>,
}

impl Faces {
    pub(super) fn new(graph: &EmbeddedGraph) -> Self {
        let mut faces = Self { of: vec![u32::MAX; graph.n_darts() as usize], ..Self::default() };
        for d in 0..graph.n_darts() {
            if !graph.is_alive(d) || faces.of[d as usize] != u32::MAX {
                continue;
            }
            let (mut len, mut outside) = (0, false);
            for e in graph.face(d) {
                faces.of[e as usize] = faces.first.len() as u32;
                outside |= graph.outside[e as usize];
                len += 1;
            }
            faces.first.push(d);
            faces.len.push(len);
            faces.outside.push(outside);
        }
        faces
    }

    /// The lowest darts (not the face numbers) of the faces of the surface whose degree satisfies `wanted`; faces outside
    /// of the boundary are left out.
    pub(super) fn inside(&self, wanted: impl Fn(u32) -> bool) -> Vec<u32> {
        (0..self.first.len()).filter(|&f| !self.outside[f] && wanted(self.len[f])).map(|f| self.first[f]).collect()
    }
}

/// Edge count and topological invariants of one connected component of a graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Numbers {
    /// Number of edges.
    pub(super) arcs: usize,
    /// Euler characteristic V − E + F of the surface; faces outside of the boundary do not count.
    pub(super) euler: i64,
    /// Number of boundary loops.
    pub(super) boundaries: usize,
}

/// Component of each dart (`u32::MAX`: dead), and the counts of all components, in order of their lowest dart.
pub(super) fn components(graph: &EmbeddedGraph) -> (Vec<u32>, Vec<Numbers>) {
    let mut component = vec![u32::MAX; graph.n_darts() as usize];
    let mut numbers: Vec<Numbers> = Vec::new();
    let mut stack = Vec::new();
    for seed in 0..graph.n_darts() {
        if !graph.is_alive(seed) || component[seed as usize] != u32::MAX {
            continue;
        }
        let c = numbers.len() as u32;
        let mut count = Numbers::default();
        component[seed as usize] = c;
        stack.push(seed);
        while let Some(d) = stack.pop() {
            // Each node is counted once, at its lowest dart; each edge once, at the even one of its two darts.
            count.euler += i64::from(graph.around(d).all(|e| d <= e));
            if d.is_multiple_of(2) {
                count.arcs += 1;
                count.euler -= 1;
            }
            for e in [d ^ 1, graph.ccw(d)] {
                if component[e as usize] == u32::MAX {
                    component[e as usize] = c;
                    stack.push(e);
                }
            }
        }
        numbers.push(count);
    }
    let faces = Faces::new(graph);
    for (&first, &outside) in faces.first.iter().zip(&faces.outside) {
        let count = &mut numbers[component[first as usize] as usize];
        if outside {
            count.boundaries += 1;
        } else {
            count.euler += 1;
        }
    }
    (component, numbers)
}
