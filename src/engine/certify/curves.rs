//! Feature curves and boundary pieces of the surface against chains of quad edges.

use crate::engine::certify::segments::{Segment, SegmentIndex};
use crate::engine::certify::shape::mean;
use crate::engine::certify::{Check, QuadTopology, Violation};
use crate::engine::mesh::{Surface, TriMesh};
use crate::engine::numerics::DisjointSets;
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// A quad edge stands for a point of a curve if the point lies within this part of the mean length of the edges that
/// meet the quad edge.
pub(super) const TOLERANCE: f64 = 0.35;
/// Boundary curves are only compared with boundary edges of the quads; a boundary that zigzags from triangle to triangle
/// is followed at the resolution of the quads, so the tolerance is wider by this factor.
pub(super) const BOUNDARY_SLACK: f64 = 1.7;
/// … and if it makes at most 60 degrees with the curve: the chords of a circle of three edges.
const COSINE: f64 = 0.5;
/// A corner is a vertex of the quads if they are this near, relative to the diagonal …
const CORNER: f64 = 1e-6;
/// … or as near as the coordinates of a file of single precision can be, relative to the largest of them.
const CORNER_WRITTEN: f64 = f32::EPSILON as f64;
/// This part of a curve's samples must be covered by one connected chain.
const COVERED: f64 = 0.95;
/// … and no more samples in a row may be uncovered: about half a quad edge.
const GAP: usize = 5;
/// An edge passes through a vertex of a curve if it comes this near, in parts of its reach.
const LINK: f64 = 0.05;
/// A curve has a direction over the length of a quad edge if its ends are apart by more than this part of that length;
/// where it turns back within less than an edge, no chain of quads can follow its turns.
const STRETCHED: f64 = 0.5;
/// A bay of a boundary with a mouth narrower than this many quad edges has no quad of its own, …
const MOUTH: f64 = 0.5;
/// … if it is at most two edges deep, which is as far as quads may be from the surface: the length of its shore, in edges.
const SHORE: f64 = 4.0;
/// Curves get a sample per tenth of a mean quad edge, at most about so many.
const SAMPLES: f64 = 200_000.0;
/// … and each at least so many.
const LEAST_SAMPLES: f64 = 8.0;

/// What the curve checks found.
pub(super) struct Curves {
    pub(super) violations: Vec<Violation>,
    /// Distance of each sample to the nearest quad edge, in model units.
    pub(super) distances: Vec<f64>,
    /// Per quad vertex, whether a corner of the surface is there.
    pub(super) is_corner: Vec<bool>,
}

/// A maximal chain of feature edges, or of boundary edges, between corners and junctions, or closed.
struct Curve {
    vertices: Vec<u32>,
    is_boundary: bool,
}

/// Per edge of the quads, how far it stands for points: `TOLERANCE` of the mean length of the edges at its ends.
pub(super) fn reaches(quads: &QuadMesh, topology: &QuadTopology) -> Vec<f64> {
    let length = |e: &[u32; 2]| quads.positions[e[0] as usize].distance(quads.positions[e[1] as usize]);
    let mut sum = vec![0.0; quads.positions.len()];
    for e in &topology.edges {
        for &v in e {
            sum[v as usize] += length(e);
        }
    }
    let reach = |&[a, b]: &[u32; 2]| {
        let edges = topology.valence[a as usize] + topology.valence[b as usize];
        TOLERANCE * (sum[a as usize] + sum[b as usize]) / f64::from(edges.max(1))
    };
    topology.edges.iter().map(reach).collect()
}

/// Checks corners, feature curves and boundary pieces.
pub(super) fn check(
    ctx: &RunContext,
    surface: &Surface,
    quads: &QuadMesh,
    topology: &QuadTopology,
    diagonal: f64,
) -> Result<Curves, Cancelled> {
    let (at_corner, is_corner) = match_corners(surface, quads, diagonal);
    let lost = at_corner.iter().filter(|(_, at)| at.is_empty()).map(|&(v, _)| (v, surface.mesh.position(v)));
    let mut violations: Vec<Violation> = Violation::at_places(Check::Corner, lost).into_iter().collect();
    let curves = trace(surface);
    let reach = reaches(quads, topology);
    let segments = |only_boundary: bool| {
        let chosen = (0..topology.edges.len()).filter(|&e| !only_boundary || topology.is_boundary_edge[e]);
        let segment = |e: usize| Segment {
            ends: topology.edges[e].map(|v| quads.positions[v as usize]),
            reach: reach[e] * if only_boundary { BOUNDARY_SLACK } else { 1.0 },
            name: e as u32,
        };
        SegmentIndex::new(chosen.map(segment).collect())
    };
    let (all, boundary) = (segments(false), segments(true));
    let mean_edge = mean(&reach) / TOLERANCE;
    let spans = curves.iter().map(|c| {
        let index = if c.is_boundary { &boundary } else { &all };
        local_edge(surface, index, c).unwrap_or(mean_edge)
    });
    let spans: Vec<f64> = spans.collect();
    let whole: Vec<Vec<DVec3>> = curves.iter().map(|c| c.points(surface)).collect();
    let samples = sample(&curves, &whole, &spans);
    let judged: Vec<(Vec<u32>, f64)> = samples
        .par_iter()
        .enumerate()
        .map(|(i, s)| {
            if i % 32 == 0 {
                ctx.check()?;
            }
            let index = if curves[s.curve].is_boundary { &boundary } else { &all };
            let mut candidates = Vec::new();
            index.reaching(s.position, |segment, _| {
                if s.directions.iter().any(|&d| d == DVec3::ZERO || segment.parallel(d) >= COSINE) {
                    candidates.push(segment.name);
                }
            });
            Ok((candidates, all.distance(s.position)))
        })
        .collect::<Result<_, Cancelled>>()?;
    let (mut torn, mut places, mut start) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()], 0);
    for (c, curve) in curves.iter().enumerate() {
        let end = start + samples[start..].iter().take_while(|s| s.curve == c).count();
        let ends = [curve.vertices[0], curve.vertices[curve.vertices.len() - 1]];
        let ends = ends.map(|v| at_corner.binary_search_by_key(&v, |a| a.0).ok().map(|i| at_corner[i].1.as_slice()));
        let links = links(surface, curve, if curve.is_boundary { &boundary } else { &all });
        let near = |i: usize| (judged[i].0.as_slice(), samples[i].is_in_bay);
        let near: Vec<(&[u32], bool)> = (start..end).map(near).collect();
        if !is_chain(&near, &links, &topology.edges, ends) {
            torn[usize::from(curve.is_boundary)].push(curve.vertices[curve.vertices.len() / 2]);
            let is_lost = |i: usize| judged[i].0.is_empty() && !samples[i].is_in_bay;
            let gaps = (start..end).filter(|&i| is_lost(i) && (i == start || !is_lost(i - 1)));
            places[usize::from(curve.is_boundary)].extend(gaps.map(|i| samples[i].position));
        }
        start = end;
    }
    let [torn_features, torn_boundary] = torn;
    let [at_features, at_boundary] = places;
    violations.extend(Violation::at(Check::FeatureCurve, torn_features).map(|v| v.with_places(at_features)));
    violations.extend(Violation::at(Check::BoundaryCurve, torn_boundary).map(|v| v.with_places(at_boundary)));
    Ok(Curves { violations, distances: judged.iter().map(|j| j.1).collect(), is_corner })
}

/// How near a vertex at `p` must be to a corner to stand for it, in model units; `diagonal` is that of the model.
pub fn corner_reach(diagonal: f64, p: DVec3) -> f64 {
    (CORNER * diagonal).max(CORNER_WRITTEN * p.abs().max_element())
}

/// Per corner of the surface, in order, the vertices of the quads at its place; per quad vertex, whether it is one.
fn match_corners(surface: &Surface, quads: &QuadMesh, diagonal: f64) -> (Vec<(u32, Vec<u32>)>, Vec<bool>) {
    let mut is_corner = vec![false; quads.positions.len()];
    if surface.features.corners.is_empty() {
        return (Vec::new(), is_corner);
    }
    let point = |(v, &p): (u32, &DVec3)| Segment { ends: [p, p], reach: corner_reach(diagonal, p), name: v };
    let index = SegmentIndex::new((0u32..).zip(&quads.positions).map(point).collect());
    let mut matched = Vec::new();
    for &corner in surface.features.corners.iter().filter(|&&v| (v as usize) < surface.mesh.n_vertices()) {
        let mut at = Vec::new();
        index.reaching(surface.mesh.position(corner), |s, _| at.push(s.name));
        for &v in &at {
            is_corner[v as usize] = true;
        }
        matched.push((corner, at));
    }
    (matched, is_corner)
}

/// Cuts the network of feature and boundary edges at corners and junctions.
fn trace(surface: &Surface) -> Vec<Curve> {
    let mesh = &surface.mesh;
    let n = mesh.n_vertices() as u32;
    // Half of each network edge per end: (from, to, on the boundary).
    let mut halves: Vec<(u32, u32, bool)> = Vec::new();
    let interior = surface.features.edges.iter().filter(|e| e.iter().all(|&v| v < n));
    halves.extend(interior.flat_map(|&[a, b]| [(a, b, false), (b, a, false)]));
    let boundary = (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h));
    let boundary = boundary.map(|h| (mesh.origin(h), mesh.target(h)));
    halves.extend(boundary.flat_map(|(a, b)| [(a, b, true), (b, a, true)]));
    halves.sort_unstable();
    let around = |v: u32| {
        let start = halves.partition_point(|h| h.0 < v);
        start..start + halves[start..].partition_point(|h| h.0 == v)
    };
    let is_stop = |v: u32| around(v).len() != 2 || surface.features.is_corner(v);
    let mut seen = vec![false; halves.len()];
    let mut curves = Vec::new();
    // First the chains that begin at a stop, then the closed ones.
    for from_stops in [true, false] {
        for first in 0..halves.len() {
            if seen[first] || (from_stops && !is_stop(halves[first].0)) {
                continue;
            }
            let mut vertices = vec![halves[first].0];
            let mut at = first;
            loop {
                let (from, to, _) = halves[at];
                seen[at] = true;
                let back = around(to).find(|&i| halves[i].1 == from && !seen[i]);
                if let Some(back) = back {
                    seen[back] = true;
                }
                vertices.push(to);
                if to == vertices[0] || is_stop(to) {
                    break;
                }
                let Some(onward) = around(to).find(|&i| !seen[i]) else { break };
                at = onward;
            }
            if vertices.len() > 2 && vertices[0] == vertices[vertices.len() - 1] && !is_stop(vertices[0]) {
                start_where_any_numbering_does(mesh, &mut vertices);
            }
            curves.push(Curve { vertices, is_boundary: halves[first].2 });
        }
    }
    curves
}

/// Turns a closed curve so that it starts at its least vertex by coordinates and goes on to the lesser neighbour: samples
/// are then in the same places whether a component is judged alone or in its model.
fn start_where_any_numbering_does(mesh: &TriMesh, vertices: &mut Vec<u32>) {
    let order = |a: u32, b: u32| {
        let (p, q) = (mesh.position(a).to_array(), mesh.position(b).to_array());
        p.iter().zip(&q).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    vertices.pop();
    let n = vertices.len();
    let least = (0..n).min_by(|&i, &j| order(vertices[i], vertices[j])).unwrap_or(0);
    vertices.rotate_left(least);
    if order(vertices[n - 1], vertices[1 % n]).is_lt() {
        vertices[1..].reverse();
    }
    vertices.push(vertices[0]);
}

struct Sample {
    position: DVec3,
    /// Of the piece of curve at the sample, and of a chord of about a quad edge around it: scan edges zigzag below
    /// that size, and split triangles follow every zigzag. Zero where it turns back within that chord: any direction is
    /// as good there.
    directions: [DVec3; 2],
    curve: usize,
    /// Whether the quads may pass it by; see [`bays`].
    is_in_bay: bool,
}

/// Mean length of the quad edges along a curve, so that a curve is judged alike whatever else the model has: a mean over
/// the whole model would not be the one of its component. `None` where no quad edge is near.
fn local_edge(surface: &Surface, index: &SegmentIndex, curve: &Curve) -> Option<f64> {
    let stride = curve.vertices.len().div_ceil(16);
    let (mut sum, mut n) = (0.0, 0);
    for &v in curve.vertices.iter().step_by(stride) {
        let mut longest: f64 = 0.0;
        index.reaching(surface.mesh.position(v), |segment, _| longest = longest.max(segment.reach));
        if longest > 0.0 {
            sum += longest / TOLERANCE;
            n += 1;
        }
    }
    (n > 0).then(|| sum / f64::from(n))
}

impl Curve {
    fn points(&self, surface: &Surface) -> Vec<DVec3> {
        self.vertices.iter().map(|&v| surface.mesh.position(v)).collect()
    }
}

fn length(points: &[DVec3]) -> f64 {
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// The bays and spits of a boundary curve at the scale of quads with edges of this length, as ranges of its arc length:
/// those with a mouth narrower than `MOUTH` edges, unless they are deeper than quads may be away from the surface; a slit
/// that long has two sides.
fn bays(points: &[DVec3], edge: f64) -> Vec<[f64; 2]> {
    let mut arc = vec![0.0];
    arc.extend(points.windows(2).scan(0.0, |sum, w| {
        *sum += w[0].distance(w[1]);
        Some(*sum)
    }));
    let longest = (SHORE * edge).min(0.5 * arc[points.len() - 1]);
    let mut found = Vec::new();
    let mut at = 0;
    while at + 1 < points.len() {
        let within = arc.partition_point(|&a| a <= arc[at] + longest);
        let is_bay = |&j: &usize| {
            let mouth = points[j].distance(points[at]);
            mouth <= MOUTH * edge && mouth < STRETCHED * (arc[j] - arc[at])
        };
        let end = (at + 1..within).rev().find(is_bay);
        found.extend(end.map(|end| [arc[at], arc[end]]));
        at = end.unwrap_or(at + 1);
    }
    found
}

/// Samples along all curves, in order, evenly by arc length; `lines` are their points, `spans` the lengths of the quad edges
/// along them.
fn sample(curves: &[Curve], lines: &[Vec<DVec3>], spans: &[f64]) -> Vec<Sample> {
    let total: f64 = lines.iter().map(|points| length(points)).sum();
    let coarsest = total / SAMPLES;
    let mut samples = Vec::new();
    for (curve, (points, &mean_edge)) in lines.iter().zip(spans).enumerate() {
        let bays = if curves[curve].is_boundary { bays(points, mean_edge) } else { Vec::new() };
        let spacing = (0.1 * mean_edge).max(coarsest);
        let all = length(points);
        let n = if spacing > 0.0 { (all / spacing).ceil().max(LEAST_SAMPLES) } else { LEAST_SAMPLES };
        let reach = 0.5 * mean_edge;
        let mut walk = [Walk::default(), Walk::default(), Walk::default()];
        for i in 0..n as usize {
            let wanted = (i as f64 + 0.5) / n * all;
            let (before, after) = ((wanted - reach).max(0.0), (wanted + reach).min(all));
            let position = walk[0].to(points, wanted);
            let chord = walk[2].to(points, after) - walk[1].to(points, before);
            let piece = points[walk[0].piece + 1] - points[walk[0].piece];
            let chord = if chord.length() > STRETCHED * (after - before) { chord } else { DVec3::ZERO };
            let directions = [piece, chord].map(DVec3::normalize_or_zero);
            let is_in_bay = bays.get(bays.partition_point(|bay| bay[1] < wanted)).is_some_and(|bay| bay[0] < wanted);
            samples.push(Sample { position, directions, curve, is_in_bay });
        }
    }
    samples
}

/// A place on a polyline that only moves forward.
#[derive(Default)]
struct Walk {
    piece: usize,
    before: f64,
}

impl Walk {
    /// The point at this arc length, not less than the last one asked for.
    fn to(&mut self, points: &[DVec3], wanted: f64) -> DVec3 {
        while self.piece + 2 < points.len() {
            let length = points[self.piece].distance(points[self.piece + 1]);
            if self.before + length >= wanted {
                break;
            }
            self.before += length;
            self.piece += 1;
        }
        let (a, b) = (points[self.piece], points[self.piece + 1]);
        let t = if a == b { 0.0 } else { ((wanted - self.before) / a.distance(b)).clamp(0.0, 1.0) };
        a.lerp(b, t)
    }
}

/// Quad edges that pass through vertices of the curve: quads that follow a curve exactly have edges shorter than the
/// distance of two samples. They hold a chain together, but cover no sample.
fn links(surface: &Surface, curve: &Curve, index: &SegmentIndex) -> Vec<u32> {
    let mut links = Vec::new();
    for &v in &curve.vertices {
        index.reaching(surface.mesh.position(v), |segment, distance| {
            if distance <= LINK * segment.reach {
                links.push(segment.name);
            }
        });
    }
    links
}

/// Whether one connected set of the candidate edges and links covers the samples, but for those in bays, and reaches the
/// ends, where those are corners.
fn is_chain(judged: &[(&[u32], bool)], links: &[u32], edges: &[[u32; 2]], ends: [Option<&[u32]>; 2]) -> bool {
    let mut chosen: Vec<u32> = judged.iter().flat_map(|(c, _)| *c).chain(links).copied().collect();
    chosen.sort_unstable();
    chosen.dedup();
    let mut vertices: Vec<u32> = chosen.iter().flat_map(|&e| edges[e as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let local = |v: u32| vertices.binary_search(&v).ok();
    let mut chains = DisjointSets::new(vertices.len());
    for &e in &chosen {
        let [a, b] = edges[e as usize].map(|v| local(v).map_or(0, |i| i as u32));
        chains.join(a, b);
    }
    let chain = chains.names();
    let mut covered = vec![0usize; vertices.len()];
    for (candidates, _) in judged.iter().filter(|j| !j.1) {
        let mut roots: Vec<usize> =
            candidates.iter().filter_map(|&e| local(edges[e as usize][0])).map(|i| chain[i] as usize).collect();
        roots.sort_unstable();
        roots.dedup();
        for r in roots {
            covered[r] += 1;
        }
    }
    let enough = COVERED * judged.iter().filter(|j| !j.1).count() as f64;
    let longest_gap = |r: usize| {
        let (mut longest, mut gap) = (0, 0);
        for (candidates, _) in judged.iter().filter(|j| !j.1) {
            let is_covered =
                candidates.iter().filter_map(|&e| local(edges[e as usize][0])).any(|i| chain[i] as usize == r);
            gap = if is_covered { 0 } else { gap + 1 };
            longest = longest.max(gap);
        }
        longest
    };
    (0..vertices.len()).any(|r| {
        let touches = |end: Option<&[u32]>| {
            end.is_none_or(|at| at.iter().any(|&v| local(v).is_some_and(|i| chain[i] as usize == r)))
        };
        covered[r] as f64 >= enough && touches(ends[0]) && touches(ends[1]) && longest_gap(r) <= GAP
    })
}
