//! Feature curves and boundary loops as polylines that vertices slide along, so that a curve never leaves its place.

use glam::DVec3;

use crate::engine::mesh::{NONE, Surface, closest_on_segment};

/// How far a curve may stray from a chord, relative to the chord's length.
const CLOSE_TO_CHORD: f64 = 0.2;
/// Least cosine between a piece of a curve and the chord that stands for it.
const ALONG_CHORD: f64 = 0.6;

/// A polyline between two vertices that never move (for a loop: the same vertex twice).
#[derive(Clone, Debug)]
struct Chain {
    points: Vec<DVec3>,
    /// Arc length up to each of `points`.
    arc: Vec<f64>,
}

/// An edge of the edited mesh that replaces the piece `t[0]..t[1]` of a chain; `v[i]` stands at `t[i]`.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine::mesh) struct Segment {
    chain: u32,
    pub(in crate::engine::mesh) v: [u32; 2],
    pub(in crate::engine::mesh) t: [f64; 2],
}

/// All chains and the segments that stand for them now. Segments are never removed from the list, only forgotten.
#[derive(Clone, Debug, Default)]
pub(in crate::engine::mesh) struct Curves {
    chains: Vec<Chain>,
    segments: Vec<Segment>,
}

impl Curves {
    /// Chains of feature and boundary edges of a surface, the segment of each halfedge (or `NONE`), and per vertex the
    /// number of its curve edges. `fixed` are vertices where chains end; one more is fixed in every loop without any.
    pub(in crate::engine::mesh) fn trace(surface: &Surface, fixed: &mut [bool]) -> (Self, Vec<u32>) {
        let mesh = &surface.mesh;
        let flags = surface.features.halfedge_flags(mesh);
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); mesh.n_vertices()];
        for h in (0..mesh.n_halfedges()).filter(|&h| flags[h] && mesh.is_edge_owner(h)) {
            around[mesh.origin(h) as usize].push(h as u32);
            around[mesh.target(h) as usize].push(h as u32);
        }
        for (v, edges) in around.iter().enumerate() {
            fixed[v] |= edges.len() != 2 && !edges.is_empty();
        }
        let mut curves = Self::default();
        let mut segment_of = vec![NONE; mesh.n_halfedges()];
        // First the chains between fixed vertices; what is left are loops, which get a fixed vertex each.
        for pass in 0..2 {
            for start in 0..mesh.n_vertices() as u32 {
                if pass == 1 && around[start as usize].iter().any(|&h| segment_of[h as usize] == NONE) {
                    fixed[start as usize] = true;
                }
                if !fixed[start as usize] {
                    continue;
                }
                for &first in &around[start as usize] {
                    if segment_of[first as usize] == NONE {
                        curves.follow(surface, &around, fixed, &mut segment_of, start, first);
                    }
                }
            }
        }
        (curves, segment_of)
    }

    /// Traces one chain from a fixed vertex to the next.
    fn follow(
        &mut self,
        surface: &Surface,
        around: &[Vec<u32>],
        fixed: &[bool],
        segment_of: &mut [u32],
        start: u32,
        first: u32,
    ) {
        let mesh = &surface.mesh;
        let mut chain = Chain { points: vec![mesh.position(start)], arc: vec![0.0] };
        let (mut at, mut edge, mut length) = (start, first as usize, 0.0);
        loop {
            let to = if mesh.origin(edge) == at { mesh.target(edge) } else { mesh.origin(edge) };
            let from = length;
            length += mesh.position(at).distance(mesh.position(to));
            chain.points.push(mesh.position(to));
            chain.arc.push(length);
            segment_of[edge] = self.segments.len() as u32;
            if let Some(twin) = mesh.twin(edge) {
                segment_of[twin] = self.segments.len() as u32;
            }
            self.segments.push(Segment { chain: self.chains.len() as u32, v: [at, to], t: [from, length] });
            if fixed[to as usize] {
                break;
            }
            let next = around[to as usize].iter().find(|&&h| h as usize != edge);
            (at, edge) = (to, *next.expect("a vertex of a chain that is not fixed has two curve edges") as usize);
        }
        self.chains.push(chain);
    }

    /// A segment.
    pub(in crate::engine::mesh) fn segment(&self, s: u32) -> Segment {
        self.segments[s as usize]
    }

    /// Whether two segments are pieces of one chain.
    pub(in crate::engine::mesh) fn same_chain(&self, s: u32, r: u32) -> bool {
        self.segments[s as usize].chain == self.segments[r as usize].chain
    }

    /// The point of segment `s`'s chain at arc length `t`.
    pub(in crate::engine::mesh) fn point(&self, s: u32, t: f64) -> DVec3 {
        let chain = &self.chains[self.segments[s as usize].chain as usize];
        let i = chain.arc.partition_point(|&arc| arc <= t).clamp(1, chain.arc.len() - 1);
        let (t0, t1) = (chain.arc[i - 1], chain.arc[i]);
        let (p0, p1) = (chain.points[i - 1], chain.points[i]);
        if t1 > t0 { p0.lerp(p1, ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)) } else { p0 }
    }

    /// Whether the chord of the chain between `t0` and `t1` (in either order) can stand for it: everywhere within
    /// `tolerance` and a part of its own length, and never turned much against it.
    pub(in crate::engine::mesh) fn chord_is_close(&self, s: u32, t0: f64, t1: f64, tolerance: f64) -> bool {
        let chain = &self.chains[self.segments[s as usize].chain as usize];
        let (t0, t1) = (t0.min(t1), t0.max(t1));
        let (a, b) = (self.point(s, t0), self.point(s, t1));
        let chord = b - a;
        let tolerance = tolerance.min(CLOSE_TO_CHORD * chord.length());
        let first = chain.arc.partition_point(|&arc| arc <= t0);
        let last = chain.arc.partition_point(|&arc| arc < t1).max(first);
        let direction = chord.normalize_or_zero();
        let along = |p: DVec3, q: DVec3| (q - p).dot(direction) >= ALONG_CHORD * p.distance(q);
        let near = |i: usize| closest_on_segment(chain.points[i], a, b).1.distance(chain.points[i]) <= tolerance;
        let mut before = a;
        for i in first..last {
            if !near(i) || !along(before, chain.points[i]) {
                return false;
            }
            before = chain.points[i];
        }
        first == last || along(before, b)
    }

    /// The middle of segment `s`, by arc length.
    pub(in crate::engine::mesh) fn middle(&self, s: u32) -> DVec3 {
        let [t0, t1] = self.segments[s as usize].t;
        self.point(s, 0.5 * (t0 + t1))
    }

    /// Cuts segment `s` at arc length `t`, where vertex `m` stands: `s` keeps the piece at `a`, the new one is returned.
    pub(in crate::engine::mesh) fn split(&mut self, s: u32, a: u32, m: u32, t: f64) -> u32 {
        let old = self.segments[s as usize];
        // A loop of one segment would have both ends at one vertex; surfaces have no such edges.
        let side = usize::from(old.v[1] == a);
        let (mut near, mut far) = (old, old);
        (near.v[1 - side], near.t[1 - side]) = (m, t);
        (far.v[side], far.t[side]) = (m, t);
        self.segments[s as usize] = near;
        self.segments.push(far);
        (self.segments.len() - 1) as u32
    }

    /// Vertex `a` between segments `removed` and `kept` disappears: `kept` reaches to the other end of `removed`.
    pub(in crate::engine::mesh) fn merge(&mut self, removed: u32, kept: u32, a: u32) {
        let removed = self.segments[removed as usize];
        let from = usize::from(removed.v[0] == a);
        let kept = &mut self.segments[kept as usize];
        let side = usize::from(kept.v[1] == a);
        (kept.v[side], kept.t[side]) = (removed.v[from], removed.t[from]);
    }

    /// Moves the vertex `a` between two segments to arc length `t`.
    pub(in crate::engine::mesh) fn slide(&mut self, [s, r]: [u32; 2], a: u32, t: f64) {
        for id in [s, r] {
            let segment = &mut self.segments[id as usize];
            segment.t[usize::from(segment.v[1] == a)] = t;
        }
    }
}
