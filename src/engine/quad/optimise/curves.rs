//! Feature curves and boundary loops of the surface as polylines with arc length.

use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::closest_on_segment;

/// Segments under one bounding box.
const BLOCK: usize = 16;

/// A polyline between two corners, or a closed one without corners.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Surface vertices along the curve; of a closed curve the first one again at the end.
    vertices: Vec<u32>,
    points: Vec<DVec3>,
    /// Length from the start to each of `points`.
    arcs: Vec<f64>,
    closed: bool,
    /// Bounding boxes of every `BLOCK` segments.
    boxes: Vec<(DVec3, DVec3)>,
}

/// A point of a curve that is nearest to another point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestOnCurve {
    pub(crate) distance_squared: f64,
    /// Its arc parameter.
    pub(crate) arc: f64,
}

impl Curve {
    fn new(surface: &Surface, vertices: Vec<u32>, closed: bool) -> Self {
        let points: Vec<DVec3> = vertices.iter().map(|&v| surface.mesh.position(v)).collect();
        let mut arcs = vec![0.0; points.len()];
        for i in 1..points.len() {
            arcs[i] = arcs[i - 1] + points[i].distance(points[i - 1]);
        }
        let bound = |start: usize| {
            let block = &points[start..(start + BLOCK + 1).min(points.len())];
            block.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)))
        };
        let boxes = (0..points.len() - 1).step_by(BLOCK).map(bound).collect();
        Self { vertices, points, arcs, closed, boxes }
    }

    /// Its pieces from point to point.
    pub(crate) fn segments(&self) -> impl Iterator<Item = [DVec3; 2]> {
        self.points.windows(2).map(|w| [w[0], w[1]])
    }

    /// Whether it has no ends.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// The surface vertices at its start and its end.
    pub(crate) fn ends(&self) -> [u32; 2] {
        [self.vertices[0], self.vertices[self.vertices.len() - 1]]
    }

    /// Length of the whole.
    pub(crate) fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// An arc parameter brought into 0 … length, round a closed curve or up to the ends of an open one.
    pub(crate) fn wrap(&self, arc: f64) -> f64 {
        if self.closed { arc.rem_euclid(self.length()).min(self.length()) } else { arc.clamp(0.0, self.length()) }
    }

    /// The point at an arc parameter.
    pub(crate) fn at(&self, arc: f64) -> DVec3 {
        let arc = self.wrap(arc);
        let i = self.segment(arc);
        let length = self.arcs[i + 1] - self.arcs[i];
        let t = if length > 0.0 { ((arc - self.arcs[i]) / length).clamp(0.0, 1.0) } else { 0.0 };
        self.points[i] + t * (self.points[i + 1] - self.points[i])
    }

    /// Arc parameters of at most `most` of its points between `lo` and `hi` (which may lie beyond 0 and length on a closed
    /// curve), evenly chosen; they are not wrapped.
    pub(crate) fn bends_between(&self, lo: f64, hi: f64, most: usize) -> Vec<f64> {
        let mut bends = Vec::new();
        let mut turn = if self.closed { (lo / self.length()).floor() * self.length() } else { 0.0 };
        while turn < hi {
            let first = self.arcs.partition_point(|&a| a + turn <= lo);
            bends.extend(self.arcs[first..].iter().map(|a| a + turn).take_while(|&a| a < hi));
            if !self.closed {
                break;
            }
            turn += self.length();
        }
        let step = bends.len().div_ceil(most.max(1)).max(1);
        bends.into_iter().step_by(step).collect()
    }

    fn segment(&self, arc: f64) -> usize {
        self.arcs.partition_point(|&a| a <= arc).clamp(1, self.arcs.len() - 1) - 1
    }

    /// The point nearest to `p`.
    pub(crate) fn nearest(&self, p: DVec3) -> NearestOnCurve {
        let mut best = NearestOnCurve { distance_squared: f64::INFINITY, arc: 0.0 };
        for (b, &(lo, hi)) in self.boxes.iter().enumerate() {
            if (lo - p).max(p - hi).max(DVec3::ZERO).length_squared() < best.distance_squared {
                let end = ((b + 1) * BLOCK).min(self.points.len() - 1);
                self.nearest_of(p, b * BLOCK..end, &mut best);
            }
        }
        best
    }

    fn nearest_of(&self, p: DVec3, segments: std::ops::Range<usize>, best: &mut NearestOnCurve) {
        for i in segments {
            let (t, position) = closest_on_segment(p, self.points[i], self.points[i + 1]);
            let distance_squared = p.distance_squared(position);
            if distance_squared < best.distance_squared {
                let arc = self.arcs[i] + t * (self.arcs[i + 1] - self.arcs[i]);
                *best = NearestOnCurve { distance_squared, arc };
            }
        }
    }

    /// The arc parameter between `lo` and `hi` (which may lie beyond 0 and length on a closed curve) of the point
    /// nearest to `p`. The answer is not wrapped.
    pub(crate) fn nearest_between(&self, p: DVec3, lo: f64, hi: f64) -> f64 {
        if !self.closed {
            return self.nearest_within(p, lo.max(0.0), hi.min(self.length())).arc;
        }
        let mut best = NearestOnCurve { distance_squared: f64::INFINITY, arc: lo };
        let mut turn = (lo / self.length()).floor() * self.length();
        while turn < hi {
            let (from, to) = ((lo - turn).max(0.0), (hi - turn).min(self.length()));
            let near = self.nearest_within(p, from, to);
            if near.distance_squared < best.distance_squared {
                best = NearestOnCurve { arc: near.arc + turn, ..near };
            }
            turn += self.length();
        }
        best.arc
    }

    fn nearest_within(&self, p: DVec3, lo: f64, hi: f64) -> NearestOnCurve {
        let hi = hi.max(lo);
        let mut best = NearestOnCurve { distance_squared: f64::INFINITY, arc: lo };
        self.nearest_of(p, self.segment(lo)..self.segment(hi) + 1, &mut best);
        let arc = best.arc.clamp(lo, hi);
        NearestOnCurve { distance_squared: p.distance_squared(self.at(arc)), arc }
    }
}

/// All feature curves and boundary loops of a surface, cut at corners and junctions, in order of their lowest start.
pub(crate) fn trace_curves(surface: &Surface) -> Vec<Curve> {
    let mesh = &surface.mesh;
    let boundary = (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h));
    let mut links: Vec<[u32; 2]> = boundary.map(|h| [mesh.origin(h), mesh.target(h)]).collect();
    links.extend_from_slice(&surface.features.edges);
    links.extend(links.clone().into_iter().map(|[a, b]| [b, a]));
    links.sort_unstable();
    links.dedup();
    let of = |v: u32| links.partition_point(|l| l[0] < v)..links.partition_point(|l| l[0] <= v);
    let is_node = |v: u32| of(v).len() != 2 || surface.features.is_corner(v);
    let mut used = vec![false; links.len()];
    let mut curves = Vec::new();
    // Open curves start at nodes; what is then left are closed curves.
    for only_nodes in [true, false] {
        for first in 0..links.len() {
            let start = links[first][0];
            if used[first] || only_nodes && !is_node(start) {
                continue;
            }
            let mut vertices = vec![start];
            let mut link = first;
            loop {
                let [a, b] = links[link];
                used[link] = true;
                used[links.partition_point(|l| *l < [b, a])] = true;
                vertices.push(b);
                match of(b).find(|&l| !used[l] && links[l][1] != a) {
                    Some(next) if !is_node(b) => link = next,
                    _ => break,
                }
            }
            let closed = !only_nodes && vertices.len() > 3 && vertices[vertices.len() - 1] == start;
            curves.push(Curve::new(surface, vertices, closed));
        }
    }
    curves.retain(|c| c.length() > 0.0);
    curves
}
