//! Quads against the surface beneath them, one by one and with their neighbours.

use crate::engine::certify::judge::{Defect, QuadJudge, Stance};
use crate::engine::certify::shape::{corners, mean};
use crate::engine::certify::{Check, QuadTopology, Violation};
use crate::engine::mesh::{FaceTree, Surface, SurfaceIndex, SurfacePoint};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// An edge lies on a feature if its ends are this near to it, in its own length and in mean edges, …
const ON_FEATURE: f64 = 0.1;
/// … and its middle, in its own length: no further than a chord may be from the curve that it stands for.
const SAGITTA: f64 = 0.35;

/// Judges every quad of a connected component by [`QuadJudge`], at the scale of their mean edge; distances also by
/// `edge_length`, the one asked for. Then every pair of adjacent quads, except at features, where the surface itself may
/// turn as far as it likes. Places are the centres of quads.
pub(super) fn check(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    topology: &QuadTopology,
    edge_length: f64,
) -> Result<Vec<Violation>, Cancelled> {
    let foot = |(i, &p): (usize, &DVec3)| {
        if i % 32 == 0 {
            ctx.check()?;
        }
        Ok(index.closest(p))
    };
    let feet: Vec<SurfacePoint> = quads.positions.par_iter().enumerate().map(foot).collect::<Result<_, Cancelled>>()?;
    let judge = QuadJudge::new(surface, index, mean_edge(quads, topology)).reaching(edge_length);
    let stance = |(q, quad): (usize, &[u32; 4])| {
        if q % 32 == 0 {
            ctx.check()?;
        }
        Ok(judge.stance_over(&corners(quads, q), &quad.map(|v| feet[v as usize])))
    };
    let stances: Vec<Stance> = quads.quads.par_iter().enumerate().map(stance).collect::<Result<_, Cancelled>>()?;
    let mut defects: Vec<Option<Defect>> = stances.iter().map(|s| s.defect).collect();
    let lie = |&(q, r, _): &(usize, usize, [u32; 2])| judge.lie_on_each_other(&stances[q], &stances[r]);
    let lying: Vec<(usize, usize, [u32; 2])> = adjacent(quads).into_iter().filter(lie).collect();
    let features = if lying.is_empty() { FaceTree::of_triangles(Vec::new(), &[]) } else { feature_tree(surface) };
    for (q, r, edge) in lying {
        if !is_on(&features, edge.map(|v| quads.positions[v as usize]), judge.edge_length()) {
            let leans = |q: usize| stances[q].area.normalize_or_zero().dot(stances[q].up);
            defects[if leans(q) < leans(r) { q } else { r }].get_or_insert(Defect::Flipped);
        }
    }
    let of = |defect: Defect, check: Check| {
        let found = (0u32..).zip(&defects).filter(|(_, d)| **d == Some(defect)).map(|(q, _)| q);
        let centre = |q: u32| corners(quads, q as usize).iter().sum::<DVec3>() / 4.0;
        Violation::at_places(check, found.map(|q| (q, centre(q))))
    };
    let all = [
        (Defect::Flipped, Check::Flipped),
        (Defect::ZeroArea, Check::ZeroArea),
        (Defect::Folded, Check::Folded),
        (Defect::Far, Check::Far),
    ];
    Ok(all.into_iter().filter_map(|(defect, check)| of(defect, check)).collect())
}

/// Mean length of the edges.
pub(super) fn mean_edge(quads: &QuadMesh, topology: &QuadTopology) -> f64 {
    let length = |e: &[u32; 2]| quads.positions[e[0] as usize].distance(quads.positions[e[1] as usize]);
    mean(&topology.edges.iter().map(length).collect::<Vec<_>>())
}

/// The feature edges of a surface.
fn feature_tree(surface: &Surface) -> FaceTree {
    let n = surface.mesh.n_vertices() as u32;
    let edges = surface.features.edges.iter().filter(|e| e.iter().all(|&v| v < n));
    let segments: Vec<[DVec3; 3]> = edges.map(|&[a, b]| [a, b, b].map(|v| surface.mesh.position(v))).collect();
    let names: Vec<u32> = (0..segments.len() as u32).collect();
    FaceTree::of_triangles(segments, &names)
}

/// Whether an edge between these points lies on one of the features.
fn is_on(features: &FaceTree, [a, b]: [DVec3; 2], mean_edge: f64) -> bool {
    let length = a.distance(b);
    let is_near = |p: DVec3, reach: f64| features.closest_where(p, reach, |_| true).is_some();
    let ends = ON_FEATURE * length.min(mean_edge);
    is_near(a, ends) && is_near(b, ends) && is_near(a.midpoint(b), SAGITTA * length)
}

/// The pairs of quads that share an edge, and the edge.
fn adjacent(quads: &QuadMesh) -> Vec<(usize, usize, [u32; 2])> {
    let side = |q: usize, k: usize| {
        let (a, b) = (quads.quads[q][k], quads.quads[q][(k + 1) % 4]);
        (a.min(b), a.max(b), q)
    };
    let mut sides: Vec<(u32, u32, usize)> =
        (0..quads.quads.len()).flat_map(|q| (0..4).map(move |k| (q, k))).map(|(q, k)| side(q, k)).collect();
    sides.sort_unstable();
    let pairs = sides.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1));
    pairs.map(|w| (w[0].2, w[1].2, [w[0].0, w[0].1])).collect()
}
