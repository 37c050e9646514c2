//! Boundary loops of the quads against boundary loops of the surface.

use crate::engine::certify::reach::{BOUNDARY_SLACK, reaches};
use crate::engine::certify::segments::{Segment, SegmentIndex};
use crate::engine::certify::{Check, QuadTopology, Violation};
use crate::engine::mesh::TriMesh;
use crate::engine::quad::QuadMesh;

/// Loops correspond if 99 of 100 vertices and edge midpoints of the one of the quads lie within reach (see
/// `reach::reaches`, with the slack of boundaries) of the one of the surface; that every piece of the surface's loops is
/// covered, the curve check proves. Loops that lie in the same place make several partners possible, so partners are found
/// by matching.
pub(super) fn check(mesh: &TriMesh, quads: &QuadMesh, topology: &QuadTopology) -> Option<Violation> {
    let reach: Vec<f64> = reaches(quads, topology).into_iter().map(|reach| BOUNDARY_SLACK * reach).collect();
    let reach_of = |a: u32, b: u32| topology.edges.binary_search(&[a.min(b), a.max(b)]).map_or(0.0, |e| reach[e]);
    let farthest = reach.iter().copied().fold(0.0, f64::max);
    let mut segments = Vec::new();
    let loops = mesh.boundary_loops();
    for (name, halfedges) in (0u32..).zip(&loops) {
        segments.extend(halfedges.iter().map(|&h| Segment {
            ends: [mesh.position(mesh.origin(h)), mesh.position(mesh.target(h))],
            reach: farthest,
            name,
        }));
    }
    let index = SegmentIndex::new(segments);
    let partners = |round: &Vec<u32>| -> Vec<usize> {
        let mut near: Vec<u32> = Vec::new();
        for (i, &a) in round.iter().enumerate() {
            let b = round[(i + 1) % round.len()];
            let (p, q) = (quads.positions[a as usize], quads.positions[b as usize]);
            for sample in [p, 0.5 * (p + q)] {
                let from = near.len();
                index.reaching(sample, |s, distance| {
                    if distance <= reach_of(a, b) && !near[from..].contains(&s.name) {
                        near.push(s.name);
                    }
                });
            }
        }
        near.sort_unstable();
        let enough = 0.99 * 2.0 * round.len() as f64;
        near.chunk_by(|x, y| x == y).filter(|run| run.len() as f64 >= enough).map(|run| run[0] as usize).collect()
    };
    let partners: Vec<Vec<usize>> = topology.loops.iter().map(partners).collect();
    let mut owner: Vec<Option<usize>> = vec![None; loops.len()];
    let lost = (0..partners.len()).filter(|&i| !augment(i, &partners, &mut owner, &mut vec![false; loops.len()]));
    Violation::at(Check::BoundaryLoop, lost.map(|i| topology.loops[i][0]).collect::<Vec<_>>())
}

/// Finds a partner for loop `i`, moving others to other partners where needed.
fn augment(i: usize, partners: &[Vec<usize>], owner: &mut [Option<usize>], tried: &mut [bool]) -> bool {
    for &j in &partners[i] {
        if std::mem::replace(&mut tried[j], true) {
            continue;
        }
        if owner[j].is_none_or(|other| augment(other, partners, owner, tried)) {
            owner[j] = Some(i);
            return true;
        }
    }
    false
}
