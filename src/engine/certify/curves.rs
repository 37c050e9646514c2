//! Feature curves and boundary pieces of the surface against chains of quad edges.

use crate::engine::certify::reach::{BOUNDARY_SLACK, TOLERANCE, reaches};
use crate::engine::certify::samples::{local_edge, sample};
use crate::engine::certify::segments::{Segment, SegmentIndex};
use crate::engine::certify::shape::mean;
use crate::engine::certify::trace::{Curve, trace};
use crate::engine::certify::{Check, QuadTopology, Violation};
use crate::engine::mesh::Surface;
use crate::engine::numerics::DisjointSets;
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// A quad edge stands for a point of a curve within its reach if it makes at most 60 degrees with the curve: the chords of
/// a circle of three edges.
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

/// What the curve checks found.
pub(super) struct Curves {
    pub(super) violations: Vec<Violation>,
    /// Distance of each sample to the nearest quad edge, in model units.
    pub(super) distances: Vec<f64>,
    /// Per quad vertex, whether a corner of the surface is there.
    pub(super) is_corner: Vec<bool>,
}

/// What was found for a sample of a curve.
struct JudgedSample {
    /// The quad edges that may stand for it.
    candidates: Vec<u32>,
    /// Its distance from the nearest quad edge.
    distance: f64,
    /// Whether no quad edge need stand for it.
    is_optional: bool,
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
    let index = |edges: Vec<usize>, slack: f64| {
        let segment = |e: usize| Segment {
            ends: topology.edges[e].map(|v| quads.positions[v as usize]),
            reach: reach[e] * slack,
            name: e as u32,
        };
        SegmentIndex::new(edges.into_iter().map(segment).collect())
    };
    let edges = 0..topology.edges.len();
    let all = index(edges.clone().collect(), 1.0);
    let boundary = index(edges.filter(|&e| topology.is_boundary_edge[e]).collect(), BOUNDARY_SLACK);
    let mean_edge = mean(&reach) / TOLERANCE;
    let spans = curves.iter().map(|c| {
        let index = if c.is_boundary { &boundary } else { &all };
        local_edge(surface, index, c).unwrap_or(mean_edge)
    });
    let spans: Vec<f64> = spans.collect();
    let whole: Vec<Vec<DVec3>> = curves.iter().map(|c| c.points(surface)).collect();
    let samples = sample(&curves, &whole, &spans);
    let judged: Vec<JudgedSample> = samples
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
            Ok(JudgedSample { candidates, distance: all.distance(s.position), is_optional: s.is_in_bay })
        })
        .collect::<Result<_, Cancelled>>()?;
    let (mut torn, mut places, mut start) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()], 0);
    for (c, curve) in curves.iter().enumerate() {
        let end = start + samples[start..].iter().take_while(|s| s.curve == c).count();
        let ends = [curve.vertices[0], curve.vertices[curve.vertices.len() - 1]];
        let ends = ends.map(|v| at_corner.binary_search_by_key(&v, |a| a.0).ok().map(|i| at_corner[i].1.as_slice()));
        let links = links(surface, curve, if curve.is_boundary { &boundary } else { &all });
        if !is_chain(&judged[start..end], &links, &topology.edges, ends) {
            torn[usize::from(curve.is_boundary)].push(curve.vertices[curve.vertices.len() / 2]);
            let is_lost = |i: usize| judged[i].candidates.is_empty() && !judged[i].is_optional;
            let gaps = (start..end).filter(|&i| is_lost(i) && (i == start || !is_lost(i - 1)));
            places[usize::from(curve.is_boundary)].extend(gaps.map(|i| samples[i].position));
        }
        start = end;
    }
    let [torn_features, torn_boundary] = torn;
    let [at_features, at_boundary] = places;
    violations.extend(Violation::at(Check::FeatureCurve, torn_features).map(|v| v.with_places(at_features)));
    violations.extend(Violation::at(Check::BoundaryCurve, torn_boundary).map(|v| v.with_places(at_boundary)));
    Ok(Curves { violations, distances: judged.iter().map(|j| j.distance).collect(), is_corner })
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

/// Whether one connected set of the candidate edges and links covers the samples, but for optional ones, and reaches the
/// ends, where those are corners.
fn is_chain(judged: &[JudgedSample], links: &[u32], edges: &[[u32; 2]], ends: [Option<&[u32]>; 2]) -> bool {
    let mut chosen: Vec<u32> = judged.iter().flat_map(|j| &j.candidates).chain(links).copied().collect();
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
    for JudgedSample { candidates, .. } in judged.iter().filter(|j| !j.is_optional) {
        let mut roots: Vec<usize> =
            candidates.iter().filter_map(|&e| local(edges[e as usize][0])).map(|i| chain[i] as usize).collect();
        roots.sort_unstable();
        roots.dedup();
        for r in roots {
            covered[r] += 1;
        }
    }
    let enough = COVERED * judged.iter().filter(|j| !j.is_optional).count() as f64;
    let longest_gap = |r: usize| {
        let (mut longest, mut gap) = (0, 0);
        for JudgedSample { candidates, .. } in judged.iter().filter(|j| !j.is_optional) {
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
