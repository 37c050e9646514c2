//! Collapses of edges, and when they keep a manifold and its feature network.

use crate::engine::mesh::remesh::edit::EditMesh;
use crate::engine::mesh::{NONE, next, prev};

impl EditMesh {
    /// Whether the collapse of `h`, its origin into its target, keeps a manifold with the same topology and feature chains.
    /// `fan_a`, `fan_b` are the fans of the two.
    pub(in crate::engine::mesh) fn may_collapse(&self, h: usize, fan_a: &[usize], fan_b: &[usize]) -> bool {
        let (a, b, c) = (self.origin(h), self.target(h), self.apex(h));
        if self.fixed[a as usize] {
            return false;
        }
        if self.on_curve[a as usize] {
            let Some(s) = self.segment(h) else { return false };
            // Its other curve edge must go on along the same chain, and must not be in one of the faces that vanish:
            // that would leave a curve across a face's side.
            let Some((other, to)) = self.other_segment(fan_a, s) else { return false };
            if !self.curves.same_chain(s, other) || to == c || self.twin(h).is_some_and(|t| to == self.apex(t)) {
                return false;
            }
        } else if self.segment(h).is_some() {
            return false;
        }
        // Link condition: nothing is adjacent to both ends but the apices; and a face is left at each apex.
        let d = self.twin(h).map(|t| self.apex(t));
        for n in self.neighbours(fan_a).filter(|&n| n != c && Some(n) != d && n != b) {
            if self.neighbours(fan_b).any(|m| m == n) {
                return false;
            }
        }
        let open = |h: usize| self.twin[next(h)] == NONE && self.twin[prev(h)] == NONE;
        if open(h) || self.twin(h).is_some_and(open) {
            return false;
        }
        // A tetrahedron has nothing to spare; no other closed fan this small passes the link condition.
        let closed = |fan: &[usize]| self.twin[prev(fan[fan.len() - 1])] != NONE;
        let mut fan_c = Vec::new();
        for apex in [Some(c), d].into_iter().flatten() {
            self.fan(apex, &mut fan_c);
            if closed(&fan_c) && fan_c.len() <= 3 {
                return false;
            }
        }
        true
    }

    /// The curve edge that leaves the fan's vertex and is not `s`, and the vertex at its other end.
    pub(in crate::engine::mesh) fn other_segment(&self, fan: &[usize], s: u32) -> Option<(u32, u32)> {
        let closing = fan.last().map(|&h| prev(h)).filter(|&h| self.twin[h] == NONE);
        let leaving = fan.iter().map(|&h| (self.segment[h], self.target(h)));
        leaving.chain(closing.map(|h| (self.segment[h], self.origin(h)))).find(|&(r, _)| r != NONE && r != s)
    }

    /// Collapses `h`: its origin, whose fan is `fan_a`, into its target. Ask [`EditMesh::may_collapse`] before.
    pub(in crate::engine::mesh) fn collapse(&mut self, h: usize, fan_a: &[usize]) {
        let (a, b) = (self.origin(h), self.target(h));
        if let Some(s) = self.segment(h)
            && let Some((other, _)) = self.other_segment(fan_a, s)
        {
            self.curves.merge(s, other, a);
        }
        for &x in fan_a {
            self.faces[x / 3][x % 3] = b;
        }
        let sides = [Some(h), self.twin(h)];
        for side in sides.into_iter().flatten() {
            let apex = self.apex(side);
            let (p, q) = (next(side), prev(side));
            let (x, y) = (self.twin[p], self.twin[q]);
            let segment = if self.segment[p] != NONE { self.segment[p] } else { self.segment[q] };
            for (one, other) in [(x, y), (y, x)] {
                if one != NONE {
                    self.twin[one as usize] = other;
                    self.segment[one as usize] = segment;
                }
            }
            // `x` runs from the apex to an end of the collapsed edge on the side of `h`, the other way on its twin's.
            for one in [x, y].into_iter().filter(|&one| one != NONE) {
                for leaving in [one as usize, next(one as usize)] {
                    let v = self.origin(leaving);
                    if v == b || v == apex {
                        self.outgoing[v as usize] = leaving as u32;
                    }
                }
            }
        }
        for side in sides.into_iter().flatten() {
            self.faces[side / 3] = [NONE; 3];
        }
        self.outgoing[a as usize] = NONE;
    }
}
