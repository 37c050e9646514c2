//! Local changes of a manifold that keep it one.

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::next;
use crate::engine::mesh::prev;

/// A [`Draft`] with what is needed to walk around vertices while faces come and go.
#[derive(Debug)]
pub(super) struct Editable {
    pub(super) draft: Draft,
    /// Whether the face still exists.
    pub(super) alive: Vec<bool>,
    /// Any halfedge leaving the vertex, or [`NONE`] if it is gone.
    out: Vec<u32>,
}

impl Editable {
    pub(super) fn new(draft: Draft) -> Self {
        let mut out = vec![NONE; draft.positions.len()];
        for (h, &v) in draft.faces.iter().flatten().enumerate() {
            out[v as usize] = h as u32;
        }
        Self { alive: vec![true; draft.faces.len()], draft, out }
    }

    /// The rest as a draft.
    pub(super) fn finish(mut self) -> Draft {
        self.draft.retain(&self.alive);
        self.draft
    }

    /// The halfedges leaving `v`, one per face, and whether `v` lies on the boundary.
    pub(super) fn fan(&self, v: u32) -> (Vec<u32>, bool) {
        let (start, mut fan) = (self.out[v as usize], Vec::new());
        if start == NONE {
            return (fan, true);
        }
        let mut h = start;
        loop {
            fan.push(h);
            h = self.draft.twin[prev(h as usize)];
            if h == start {
                return (fan, false);
            }
            if h == NONE {
                break;
            }
        }
        let mut h = self.draft.twin[start as usize];
        while h != NONE {
            h = next(h as usize) as u32;
            fan.push(h);
            h = self.draft.twin[h as usize];
        }
        (fan, true)
    }

    /// Vertices joined to `v` by an edge, sorted.
    fn neighbours(&self, fan: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> =
            fan.iter().flat_map(|&h| [self.draft.end(h), self.draft.start(prev(h as usize) as u32)]).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether an edge joins `a` and `b`.
    fn is_joined(&self, a: u32, b: u32) -> bool {
        self.neighbours(&self.fan(a).0).binary_search(&b).is_ok()
    }

    /// Whether the collapse of `h`, its start into its end, keeps a manifold of the same topology: the vertices joined to
    /// both ends are exactly those opposite the edge, and no vertex or component disappears.
    pub(super) fn may_collapse(&self, h: u32) -> bool {
        let d = &self.draft;
        let t = d.twin[h as usize];
        let (u, v) = (d.start(h), d.end(h));
        let ((fan_u, u_open), (fan_v, v_open)) = (self.fan(u), self.fan(v));
        // An open vertex must not leave the boundary, nor two boundaries become one.
        if u_open && (!v_open || t != NONE) {
            return false;
        }
        let sides: &[u32] = if t == NONE { &[h] } else { &[h, t] };
        for &s in sides {
            let (n, p) = (d.twin[next(s as usize)], d.twin[prev(s as usize)]);
            if n == NONE && p == NONE {
                return false;
            }
        }
        let mut apexes: Vec<u32> = sides.iter().map(|&s| d.start(prev(s as usize) as u32)).collect();
        apexes.sort_unstable();
        apexes.dedup();
        let (nu, nv) = (self.neighbours(&fan_u), self.neighbours(&fan_v));
        let common: Vec<u32> = nu.into_iter().filter(|w| nv.binary_search(w).is_ok()).collect();
        // Both ends of valence 3 over the same two vertices: a tetrahedron, or a pair of faces would coincide.
        let cramped = apexes.len() == 2 && fan_u.len() == 3 && fan_v.len() == 3 && !u_open && !v_open;
        apexes.len() == sides.len() && common == apexes && !cramped
    }

    /// Collapses `h`, its start into its end. Only after [`Self::may_collapse`].
    pub(super) fn collapse(&mut self, h: u32) {
        let (u, v) = (self.draft.start(h), self.draft.end(h));
        let t = self.draft.twin[h as usize];
        for g in self.fan(u).0 {
            self.draft.faces[g as usize / 3][g as usize % 3] = v;
        }
        for s in if t == NONE { vec![h] } else { vec![h, t] } {
            let apex = self.draft.start(prev(s as usize) as u32);
            let (n, p) = (self.draft.twin[next(s as usize)], self.draft.twin[prev(s as usize)]);
            self.draft.glue(n, p);
            self.alive[s as usize / 3] = false;
            for x in [n, p].into_iter().filter(|&x| x != NONE) {
                let start = self.draft.start(x);
                self.out[start as usize] = x;
                let end = self.draft.end(x);
                self.out[end as usize] = next(x as usize) as u32;
            }
            debug_assert_ne!(self.out[apex as usize] / 3, s / 3);
        }
        self.out[u as usize] = NONE;
    }

    /// Whether the edge of `h` can be exchanged for the one between the corners opposite it.
    pub(super) fn may_flip(&self, h: u32) -> bool {
        let d = &self.draft;
        let t = d.twin[h as usize];
        if t == NONE {
            return false;
        }
        let (c, e) = (d.start(prev(h as usize) as u32), d.start(prev(t as usize) as u32));
        let outer = [next(h as usize), prev(h as usize), next(t as usize), prev(t as usize)];
        let closed_on_itself = outer.iter().any(|&o| d.twin[o] != NONE && [h / 3, t / 3].contains(&(d.twin[o] / 3)));
        c != e && !closed_on_itself && !self.is_joined(c, e)
    }

    /// Flips the edge of `h`; both faces get the polygon of the face beyond it. Only after [`Self::may_flip`].
    pub(super) fn flip(&mut self, h: u32) {
        let d = &mut self.draft;
        let t = d.twin[h as usize];
        let (f, g) = (h / 3, t / 3);
        let (a, b) = (d.start(h), d.end(h));
        let (c, e) = (d.start(prev(h as usize) as u32), d.start(prev(t as usize) as u32));
        let beyond = |x: usize| d.twin[x];
        let (bc, ca) = (beyond(next(h as usize)), beyond(prev(h as usize)));
        let (ae, eb) = (beyond(next(t as usize)), beyond(prev(t as usize)));
        d.faces[f as usize] = [a, e, c];
        d.faces[g as usize] = [e, b, c];
        d.polygon[f as usize] = d.polygon[g as usize];
        d.glue(3 * f, ae);
        d.glue(3 * f + 1, 3 * g + 2);
        d.glue(3 * f + 2, ca);
        d.glue(3 * g, eb);
        d.glue(3 * g + 1, bc);
        for (v, out) in [(a, 3 * f), (e, 3 * f + 1), (c, 3 * f + 2), (b, 3 * g + 1)] {
            self.out[v as usize] = out;
        }
    }

    /// Takes away face `f` if its vertices stay, or become, ordinary boundary vertices: true if it was done.
    pub(super) fn peel(&mut self, f: u32) -> bool {
        let open: Vec<u32> = (3 * f..3 * f + 3).filter(|&h| self.draft.twin[h as usize] == NONE).collect();
        match *open {
            [h] if self.fan(self.draft.start(prev(h as usize) as u32)).1 => return false,
            [] | [_, _, _] => return false,
            _ => {}
        }
        self.alive[f as usize] = false;
        for v in self.draft.faces[f as usize] {
            self.out[v as usize] = NONE;
        }
        for h in 3 * f..3 * f + 3 {
            let t = self.draft.twin[h as usize];
            if t != NONE {
                self.draft.twin[t as usize] = NONE;
                let (start, end) = (self.draft.start(t), self.draft.end(t));
                self.out[start as usize] = t;
                self.out[end as usize] = next(t as usize) as u32;
            }
        }
        true
    }
}
