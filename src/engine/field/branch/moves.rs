//! What a search may do in one step: quarters of index carried along edges.

use crate::engine::field::branch::curl::Curl;
use crate::engine::field::cross_field::CrossField;
use crate::engine::field::frames::Frames;
use crate::engine::field::turning::Turning;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;

/// Branch points are not brought nearer to each other than this many quad edges.
const MIN_DISTANCE: f64 = 1.0;
/// Moves in one batch are at least this many rings apart.
const RINGS: usize = 4;

/// What the search is to respect.
pub(in crate::engine::field) struct Surroundings<'a> {
    pub(in crate::engine::field) mesh: &'a TriMesh,
    pub(in crate::engine::field) frames: &'a Frames,
    /// Features and boundary, per halfedge: matchings there stay.
    pub(in crate::engine::field) is_feature: &'a [bool],
    /// Which crosses follow a matching, and how freely.
    pub(in crate::engine::field) turning: &'a Turning,
    /// Length of a quad edge in the frames' metric.
    pub(in crate::engine::field) edge_length: f64,
}

/// A quarter of index carried over an edge, and on from there as long as the derivative promises more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Move {
    pub(super) edge: usize,
    /// Turn across the owner of the edge.
    quarters: i32,
    /// Predicted change of energy and price by the first edge.
    gain: f64,
}

/// The moves of one mesh. Matchings at features and at the boundary stay: they follow from the angles there.
pub(super) struct Moves<'a> {
    mesh: &'a TriMesh,
    pub(super) curl: &'a Curl,
    edge_length: f64,
    frames: &'a Frames,
    /// What a quarter of index costs, in units of the energy; without a price the number of branch points never grows.
    pub(super) price: Option<f64>,
    /// Per vertex: at a feature or at the boundary.
    blocked: Vec<bool>,
}

impl<'a> Moves<'a> {
    pub(super) fn new(mesh: &'a TriMesh, curl: &'a Curl, around: &Surroundings<'a>) -> Self {
        let mut blocked = vec![false; mesh.n_vertices()];
        for h in (0..mesh.n_halfedges()).filter(|&h| around.is_feature[h] || mesh.is_boundary(h)) {
            blocked[mesh.origin(h) as usize] = true;
            blocked[mesh.target(h) as usize] = true;
        }
        Self { mesh, curl, edge_length: around.edge_length, frames: around.frames, price: None, blocked }
    }

    /// Energy and price.
    pub(super) fn cost(&self, field: &CrossField, energy: f64) -> f64 {
        let quarters: u32 = field.quarter_index.iter().map(|q| q.unsigned_abs()).sum();
        energy + self.price.unwrap_or(0.0) * f64::from(quarters)
    }

    /// Turns the matchings of a move and of the edges after it; returns the predicted change.
    pub(super) fn carry(&self, field: &mut CrossField, m: &Move, derivative: &[f64], stride: usize) -> f64 {
        let mesh = self.mesh;
        let h = self.curl.sides.owner[m.edge];
        let before = [mesh.origin(h), mesh.target(h)].map(|v| field.quarter_index[v as usize]);
        self.turn(field, h, m.quarters);
        let (from, to) = (mesh.origin(h), mesh.target(h));
        m.gain
            + match before {
                [1 | -1, 0] => self.walk(field, (from, to), before[0], derivative, stride),
                [0, 1 | -1] => self.walk(field, (to, from), before[1], derivative, stride),
                // A new pair walks apart.
                [0, 0] => {
                    self.walk(field, (from, to), -m.quarters, derivative, stride)
                        + self.walk(field, (to, from), m.quarters, derivative, stride)
                }
                _ => 0.0,
            }
    }

    /// Carries the charge that came over an edge on for up to `stride` − 1 edges, each time over the one that promises
    /// most; returns the predicted change.
    fn walk(
        &self,
        field: &mut CrossField,
        (from, mut at): (u32, u32),
        charge: i32,
        derivative: &[f64],
        stride: usize,
    ) -> f64 {
        let mesh = self.mesh;
        let points: Vec<u32> = field.singularities().iter().map(|s| s.vertex).collect();
        let mut path = vec![from, at];
        let mut gain = 0.0;
        for _ in 1..stride {
            let step = mesh
                .fan(at)
                .filter_map(|h| {
                    let to = mesh.target(h);
                    let is_free = !self.blocked[to as usize] && field.quarter_index[to as usize] == 0;
                    if !is_free || path.contains(&to) || self.is_too_near(&points, to, at) {
                        return None;
                    }
                    // Turning the matching across h by k puts k at its origin and takes it from its target.
                    let across_owner = if mesh.is_edge_owner(h) { -charge } else { charge };
                    Some((derivative[self.curl.edge_of(h)] * f64::from(across_owner), h))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some((change, h)) = step.filter(|s| s.0 < 0.0) else { break };
            self.turn(field, h, -charge);
            gain += change;
            at = mesh.target(h);
            path.push(at);
        }
        gain
    }

    fn turn(&self, field: &mut CrossField, h: usize, quarters: i32) {
        field.matching.turn(self.mesh, h, quarters.rem_euclid(4) as u8);
        field.quarter_index[self.mesh.origin(h) as usize] += quarters;
        field.quarter_index[self.mesh.target(h) as usize] -= quarters;
    }

    /// All moves that promise a gain, best first.
    pub(super) fn propose(&self, field: &CrossField, derivative: &[f64]) -> Vec<Move> {
        let mesh = self.mesh;
        let points: Vec<u32> = field.singularities().iter().map(|s| s.vertex).collect();
        let mut moves: Vec<Move> = Vec::new();
        for (edge, (&h, &d)) in self.curl.sides.owner.iter().zip(derivative).enumerate() {
            let (a, b) = (mesh.origin(h), mesh.target(h));
            if self.blocked[a as usize] || self.blocked[b as usize] {
                continue;
            }
            let quarters = if d > 0.0 { -1 } else { 1 };
            let (old_a, old_b) = (field.quarter_index[a as usize], field.quarter_index[b as usize]);
            let (new_a, new_b) = (old_a + quarters, old_b - quarters);
            let grows = |old: i32, new: i32| new.abs() > old.abs() && new.abs() > 1;
            if grows(old_a, new_a) || grows(old_b, new_b) {
                continue;
            }
            let more = new_a.abs() + new_b.abs() - old_a.abs() - old_b.abs();
            let gain = match self.price {
                None if more > 0 => continue,
                price => price.unwrap_or(0.0) * f64::from(more) - d.abs(),
            };
            let is_too_near = || {
                (new_a != 0 && old_a == 0 && self.is_too_near(&points, a, b))
                    || (new_b != 0 && old_b == 0 && self.is_too_near(&points, b, a))
            };
            if gain < 0.0 && !is_too_near() {
                moves.push(Move { edge, quarters, gain });
            }
        }
        moves.sort_by(|m, n| m.gain.total_cmp(&n.gain).then(m.edge.cmp(&n.edge)));
        moves
    }

    /// Whether a branch point that comes to `to` from `from` gets too near to another one, and nearer than it was.
    fn is_too_near(&self, points: &[u32], to: u32, from: u32) -> bool {
        let least = MIN_DISTANCE * self.edge_length * self.frames.size(to);
        let (to_at, from_at) = (self.mesh.position(to), self.mesh.position(from));
        points.iter().filter(|&&p| p != from && p != to).any(|&p| {
            let p = self.mesh.position(p);
            p.distance(to_at) < least && p.distance(to_at) < p.distance(from_at)
        })
    }

    /// Whether two moves go over one edge, or over two with a vertex in common.
    pub(super) fn share_an_end(&self, a: &Move, b: &Move) -> bool {
        let [a, b] = [a, b].map(|m| self.curl.sides.owner[m.edge]).map(|h| [self.mesh.origin(h), self.mesh.target(h)]);
        a.iter().any(|v| b.contains(v))
    }

    /// The best moves whose neighbourhoods do not touch.
    pub(super) fn choose(&self, moves: &[Move], batch: usize) -> Vec<Move> {
        let mesh = self.mesh;
        let mut taken = vec![false; mesh.n_vertices()];
        let mut chosen: Vec<Move> = Vec::new();
        for m in moves {
            if chosen.len() == batch {
                break;
            }
            let h = self.curl.sides.owner[m.edge];
            let ends = [mesh.origin(h), mesh.target(h)];
            if ends.iter().any(|&v| taken[v as usize]) {
                continue;
            }
            let mut ring: Vec<u32> = ends.to_vec();
            let mut seen: Vec<u32> = ring.clone();
            for _ in 0..RINGS {
                let mut next = Vec::new();
                for &v in &ring {
                    for h in mesh.fan(v) {
                        for w in [mesh.target(h), mesh.origin(prev(h))] {
                            if !seen.contains(&w) {
                                seen.push(w);
                                next.push(w);
                            }
                        }
                    }
                }
                ring = next;
            }
            for v in seen {
                taken[v as usize] = true;
            }
            chosen.push(*m);
        }
        chosen
    }
}
