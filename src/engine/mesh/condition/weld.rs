//! Which positions are one vertex.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;

use crate::engine::mesh::condition::edges::edge_key;
use crate::engine::mesh::condition::edges::origin;
use crate::engine::mesh::condition::edges::runs;
use crate::engine::mesh::condition::edges::sorted_sides;
use crate::engine::mesh::condition::edges::target;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::triangulate::Triangles;
use crate::engine::numerics::DisjointSets;

/// Distance, relative to the model's diagonal, below which two boundary edges are taken for one.
const CLOSE: f64 = 1e-7;

/// Welds open vertices at exactly the same place, then nearly coincident boundary edges, and drops the triangles that
/// lose a corner by it. Only vertices on an open edge are welded: those of closed parts that merely touch stay apart.
pub(super) fn weld(triangles: &mut Triangles, positions: &[DVec3], diagonal: f64, tally: &mut Tally) {
    let open = open_vertices(&distinct(&triangles.corners), positions.len());
    let into = weld_exact(&open, positions);
    let welded = apply(triangles, &into);
    tally.add("vertices_welded", welded);

    let into = weld_close(&triangles.corners, positions, CLOSE * diagonal);
    let welded = apply(triangles, &into);
    tally.add("vertices_welded_nearly", welded);

    let before = triangles.corners.len();
    let whole: Vec<bool> = triangles.corners.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    triangles.retain(|f| whole[f]);
    tally.add("degenerate_faces_dropped", before - triangles.corners.len());
}

/// Each set of three corners once: a triangle that is there twice does not close its own edges.
fn distinct(corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sets: Vec<[u32; 3]> = corners
        .iter()
        .map(|&face| {
            let mut set = face;
            set.sort_unstable();
            set
        })
        .collect();
    sets.par_sort_unstable();
    sets.dedup();
    sets
}

fn open_vertices(corners: &[[u32; 3]], n: usize) -> Vec<bool> {
    let mut open = vec![false; n];
    for run in runs(&sorted_sides(corners)).filter(|run| run.len() == 1) {
        open[origin(corners, run[0].1) as usize] = true;
        open[target(corners, run[0].1) as usize] = true;
    }
    open
}

/// Per position the lowest open one at the same place (itself if it is not open).
fn weld_exact(open: &[bool], positions: &[DVec3]) -> Vec<u32> {
    // Adding 0 makes -0 and 0 one place.
    let place = |v: u32| (positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sorted: Vec<([u64; 3], u32)> =
        (0..positions.len() as u32).filter(|&v| open[v as usize]).map(|v| (place(v), v)).collect();
    sorted.par_sort_unstable();
    let mut into: Vec<u32> = (0..positions.len() as u32).collect();
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        for &(_, v) in same {
            into[v as usize] = same[0].1;
        }
    }
    into
}

/// Welds the ends of two boundary edges that have both ends closer than `reach` to each other's, and no others, so
/// that thin sheets and fine boundaries keep their vertices.
fn weld_close(corners: &[[u32; 3]], positions: &[DVec3], reach: f64) -> Vec<u32> {
    let sides = sorted_sides(corners);
    let boundary: Vec<u32> = runs(&sides).filter(|run| run.len() == 1).map(|run| run[0].1).collect();
    let mut vertices: Vec<u32> = boundary.iter().flat_map(|&h| [origin(corners, h), target(corners, h)]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut cluster = near(&vertices, positions, reach);
    let mut keyed: Vec<(u64, u32)> = boundary
        .iter()
        .map(|&h| (cluster.find(origin(corners, h)), cluster.find(target(corners, h)), h))
        .filter(|&(a, b, _)| a != b)
        .map(|(a, b, h)| (edge_key(a, b), h))
        .collect();
    keyed.sort_unstable();
    let mut into = DisjointSets::new(positions.len());
    for pair in keyed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() == 2) {
        let [(_, h), (_, t)] = [pair[0], pair[1]];
        for a in [origin(corners, h), target(corners, h)] {
            for b in [origin(corners, t), target(corners, t)] {
                if cluster.find(a) == cluster.find(b) {
                    into.join(a, b);
                }
            }
        }
    }
    into.names()
}

/// Sets of the listed vertices chained by distances below `reach`, among all positions.
fn near(vertices: &[u32], positions: &[DVec3], reach: f64) -> DisjointSets {
    // Cells wider than the reach: a vertex meets at most two per axis.
    let cell = |p: DVec3| (p / (4.0 * reach)).floor().to_array().map(|x| x as i64);
    let mut cells: Vec<([i64; 3], u32)> = vertices.iter().map(|&v| (cell(positions[v as usize]), v)).collect();
    cells.sort_unstable();
    let mut cluster = DisjointSets::new(positions.len());
    for &v in vertices {
        let p = positions[v as usize];
        let (lo, hi) = (cell(p - DVec3::splat(reach)), cell(p + DVec3::splat(reach)));
        for choice in 0..8 {
            let axis = |k: usize| if choice >> k & 1 == 0 { lo[k] } else { hi[k] };
            if (0..3).any(|k| choice >> k & 1 == 1 && lo[k] == hi[k]) {
                continue;
            }
            let wanted = [axis(0), axis(1), axis(2)];
            let start = cells.partition_point(|c| c.0 < wanted);
            // Where so many vertices lie within the reach of one the model has no size: no need to look at all of them.
            for &(_, w) in cells[start..].iter().take(64).take_while(|c| c.0 == wanted) {
                if v < w && positions[w as usize].distance(p) <= reach {
                    cluster.join(v, w);
                }
            }
        }
    }
    cluster
}

/// Renames the corners; returns how many of the vertices in use went into another.
fn apply(triangles: &mut Triangles, into: &[u32]) -> usize {
    let mut used = vec![false; into.len()];
    for corner in triangles.corners.iter_mut().flatten() {
        used[*corner as usize] = true;
        *corner = into[*corner as usize];
    }
    (0..into.len()).filter(|&v| used[v] && into[v] != v as u32).count()
}
