//! Quads that can be changed: slots of quads, and the slots at every vertex.

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;

/// A slot without a quad.
pub(crate) const DEAD: [u32; 4] = [NONE; 4];

/// New contents of slots. Applying it swaps them with the old contents, so applying it twice changes nothing.
pub(crate) type Change = Vec<(u32, [u32; 4])>;

/// The quads round a vertex, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fan {
    /// Slots of the quads.
    pub(crate) quads: Vec<u32>,
    /// Far ends of the edges: spoke `i` is on the clockwise side of quad `i`; an open fan has one more at the end.
    pub(crate) spokes: Vec<u32>,
    /// Whether the fan goes all the way round.
    pub(crate) closed: bool,
}

/// A quad mesh under change.
#[derive(Clone, Debug)]
pub(crate) struct QuadNet {
    pub(crate) quads: Vec<[u32; 4]>,
    /// Slots of the quads at each vertex, sorted.
    pub(crate) at: Vec<Vec<u32>>,
    pub(crate) anchors: Vec<Anchor>,
    feature_edges: Vec<[u32; 2]>,
}

impl QuadNet {
    pub(crate) fn new(draft: &QuadDraft) -> Self {
        let mut at = vec![Vec::new(); draft.mesh.positions.len()];
        for (q, quad) in draft.mesh.quads.iter().enumerate() {
            quad.iter().filter(|&&v| v != NONE).for_each(|&v| at[v as usize].push(q as u32));
        }
        let mut feature_edges = draft.feature_edges.clone();
        feature_edges.sort_unstable();
        Self { quads: draft.mesh.quads.clone(), at, anchors: draft.anchors.clone(), feature_edges }
    }

    /// A new vertex without quads.
    pub(crate) fn add_vertex(&mut self, anchor: Anchor) -> u32 {
        self.at.push(Vec::new());
        self.anchors.push(anchor);
        self.at.len() as u32 - 1
    }

    /// A new slot without a quad.
    pub(crate) fn add_slot(&mut self) -> u32 {
        self.quads.push(DEAD);
        self.quads.len() as u32 - 1
    }

    pub(crate) fn n_vertices(&self) -> usize {
        self.at.len()
    }

    pub(crate) fn is_feature(&self, a: u32, b: u32) -> bool {
        self.feature_edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// Whether `v` may be anywhere on the surface.
    pub(crate) fn is_free(&self, v: u32) -> bool {
        self.anchors[v as usize] == Anchor::Surface
    }

    /// Which corner of the quad in slot `q` is `v`.
    pub(crate) fn corner(&self, q: u32, v: u32) -> usize {
        self.quads[q as usize].iter().position(|&w| w == v).unwrap_or(0)
    }

    /// Swaps the contents of slots.
    pub(crate) fn apply(&mut self, change: &mut Change) {
        for (slot, contents) in change {
            let old = std::mem::replace(&mut self.quads[*slot as usize], *contents);
            for v in old.into_iter().filter(|&v| v != NONE) {
                self.at[v as usize].retain(|q| q != slot);
            }
            for &v in contents.iter().filter(|&&v| v != NONE) {
                let list = &mut self.at[v as usize];
                if let Err(place) = list.binary_search(slot) {
                    list.insert(place, *slot);
                }
            }
            *contents = old;
        }
    }

    /// The fan of `v`; `None` if its quads do not form one.
    pub(crate) fn fan(&self, v: u32) -> Option<Fan> {
        let list = &self.at[v as usize];
        let sides: Vec<(u32, u32)> = list
            .iter()
            .map(|&q| {
                let (quad, k) = (&self.quads[q as usize], self.corner(q, v));
                (quad[(k + 1) % 4], quad[(k + 3) % 4])
            })
            .collect();
        // The first quad of an open fan has no quad before it.
        let lone = (0..sides.len()).find(|&i| sides.iter().all(|s| s.1 != sides[i].0));
        let start = lone.unwrap_or(0);
        let mut fan = Fan { quads: Vec::new(), spokes: Vec::new(), closed: lone.is_none() };
        let mut i = start;
        for _ in 0..sides.len() {
            fan.quads.push(list[i]);
            fan.spokes.push(sides[i].0);
            match (0..sides.len()).find(|&j| sides[j].0 == sides[i].1) {
                Some(next) if next != start => i = next,
                Some(_) => break,
                None => {
                    fan.spokes.push(sides[i].1);
                    break;
                }
            }
        }
        let mut ends = fan.spokes.clone();
        ends.sort_unstable();
        let whole = fan.quads.len() == list.len() && !list.is_empty();
        (whole && ends.windows(2).all(|w| w[0] != w[1])).then_some(fan)
    }

    /// Number of quads at `v`.
    pub(crate) fn valence(&self, v: u32) -> usize {
        self.at[v as usize].len()
    }

    /// The quad in the slot on the left of the edge from `a` to `b`.
    pub(crate) fn left_of(&self, a: u32, b: u32) -> Option<u32> {
        let quads = self.at[a as usize].iter();
        quads.copied().find(|&q| self.quads[q as usize][(self.corner(q, a) + 1) % 4] == b)
    }

    /// All vertices of the quads before and after a change that has not been applied yet (or has been: it is the same).
    pub(crate) fn touched(&self, change: &Change) -> Vec<u32> {
        let slots = change.iter().flat_map(|(slot, contents)| [self.quads[*slot as usize], *contents]);
        let mut vertices: Vec<u32> = slots.flatten().filter(|&v| v != NONE).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Applies a change if the quads stay a manifold of the same topology without new doublets; tells whether it did.
    /// Every change replaces a disk by a disk or shrinks a quad's diagonal, so it is enough that all fans stay fans.
    pub(crate) fn try_apply(&mut self, change: &mut Change) -> bool {
        let touched = self.touched(change);
        let before: Vec<(usize, Option<bool>)> =
            touched.iter().map(|&v| (self.valence(v), self.fan(v).map(|f| f.closed))).collect();
        if before.iter().any(|b| b.1.is_none()) {
            return false;
        }
        self.apply(change);
        let simple = change.iter().all(|&(slot, _)| self.is_simple(slot));
        let sound = simple
            && touched.iter().zip(&before).all(|(&v, &(valence, closed))| match self.fan(v) {
                Some(fan) => closed == Some(fan.closed) && (!fan.closed || fan.quads.len() >= valence.min(3)),
                None => self.at[v as usize].is_empty() && closed == Some(true) && self.is_free(v),
            });
        if !sound {
            self.apply(change);
        }
        sound
    }

    /// The draft with the quads as they are now at these positions; vertices that are no longer used are left out.
    pub(crate) fn into_draft(self, positions: &[DVec3], draft: &QuadDraft) -> QuadDraft {
        let mut number = vec![NONE; self.n_vertices()];
        let mut used = QuadDraft::default();
        for (v, number) in number.iter_mut().enumerate() {
            if !self.at[v].is_empty() {
                *number = used.mesh.positions.len() as u32;
                used.mesh.positions.push(positions[v]);
                used.anchors.push(self.anchors[v]);
            }
        }
        let renamed = |v: u32| number[v as usize];
        used.mesh.quads = self.quads.iter().filter(|&&q| q != DEAD).map(|q| q.map(renamed)).collect();
        let edges = draft.feature_edges.iter().map(|e| e.map(renamed));
        used.feature_edges = edges.filter(|e| !e.contains(&NONE)).collect();
        used
    }

    /// Whether the quad in a slot has four different vertices and shares at most two with every other quad.
    fn is_simple(&self, slot: u32) -> bool {
        let quad = &self.quads[slot as usize];
        if *quad == DEAD {
            return true;
        }
        let distinct = (0..4).all(|k| quad[k + 1..].iter().all(|v| *v != quad[k]));
        let shared = |q: &u32| *q != slot && self.quads[*q as usize].iter().filter(|v| quad.contains(v)).count() > 2;
        distinct && quad.iter().all(|&v| !self.at[v as usize].iter().any(&shared))
    }
}
