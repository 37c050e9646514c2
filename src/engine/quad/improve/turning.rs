//! The other ways to part two adjacent quads.

use std::collections::BTreeMap;

use crate::engine::quad::QuadDraft;

/// Two quads, or what is to replace them.
pub(super) type Pair = [[u32; 4]; 2];

/// Sides and edges of the quads of a draft while pairs of adjacent quads are replaced.
pub(super) struct Turning<'a> {
    draft: &'a QuadDraft,
    /// Quad and corner from which each side starts.
    sides: BTreeMap<[u32; 2], (u32, u32)>,
    /// Number of edges at each vertex, and whether it is on the boundary.
    valence: Vec<(u32, bool)>,
}

impl<'a> Turning<'a> {
    pub(super) fn new(draft: &'a QuadDraft) -> Self {
        let mut sides = BTreeMap::new();
        for (q, quad) in (0u32..).zip(&draft.mesh.quads) {
            for k in 0..4 {
                sides.insert([quad[k], quad[(k + 1) % 4]], (q, k as u32));
            }
        }
        let mut valence = vec![(0, false); draft.mesh.positions.len()];
        for &[a, b] in sides.keys() {
            valence[a as usize].0 += 1;
            if !sides.contains_key(&[b, a]) {
                valence[b as usize].0 += 1;
                valence[a as usize].1 = true;
                valence[b as usize].1 = true;
            }
        }
        Self { draft, sides, valence }
    }

    /// For each edge of quad `q` that may be turned: the quad across it, and both ways to part the hexagon that the two
    /// make up. The result is a manifold in which no two edges join the same vertices and no vertex inside has only two.
    pub(super) fn ways(&self, q: usize) -> Vec<(usize, Pair)> {
        let quad = self.draft.mesh.quads[q];
        let mut ways = Vec::new();
        for k in 0..4 {
            let [a, b, c, d] = std::array::from_fn(|i| quad[(k + i) % 4]);
            let Some(&(other, at)) = self.sides.get(&[b, a]) else { continue };
            let across = self.draft.mesh.quads[other as usize];
            let [e, f] = [2, 3].map(|i| across[(at as usize + i) % 4]);
            if self.draft.feature_edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
                || ![a, b].iter().all(|&v| self.may_lose(v))
            {
                continue;
            }
            // The hexagon is b, c, d, a, e, f.
            let turned = [((c, e), [[c, d, a, e], [e, f, b, c]]), ((d, f), [[d, a, e, f], [f, b, c, d]])];
            for ((from, to), pair) in turned {
                let is_new =
                    from != to && !self.sides.contains_key(&[from, to]) && !self.sides.contains_key(&[to, from]);
                let is_simple = |quad: &[u32; 4]| (1..4).all(|i| !quad[..i].contains(&quad[i]));
                if is_new && pair.iter().all(is_simple) {
                    ways.push((other as usize, pair));
                }
            }
        }
        ways
    }

    fn may_lose(&self, v: u32) -> bool {
        let (edges, is_boundary) = self.valence[v as usize];
        edges > if is_boundary { 2 } else { 3 }
    }
}
