//! Vertices that lie on the middle of an open edge of another triangle: the slit between both sides is closed by splitting
//! that triangle, so that its sides can be paired with those beyond.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::FaceTree;
use crate::engine::mesh::closest_on_segment;
use crate::engine::mesh::condition::edges::{apex, origin, runs, sorted_sides, target};
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::triangulate::Triangles;
use crate::engine::run::{Cancelled, RunContext};

/// Distance, relative to the model's diagonal, below which a vertex lies on an edge: such vertices are computed and
/// stored in single precision, whose unit in the last place is 1.2e-7 of a coordinate.
const ON_EDGE: f64 = 1e-6;

/// Splits triangles at the open vertices that lie on their open edges, where an open edge leaves such a vertex along the
/// edge that is split: there the other side of a slit is. O(n log n) for n open edges.
///
/// # Errors
/// If the run was stopped.
pub(super) fn join_t_vertices(
    ctx: &RunContext,
    triangles: &mut Triangles,
    positions: &[DVec3],
    diagonal: f64,
    tally: &mut Tally,
) -> Result<(), Cancelled> {
    let reach = ON_EDGE * diagonal;
    let corners = &triangles.corners;
    let sides = sorted_sides(corners);
    let open: Vec<u32> = runs(&sides).filter(|run| run.len() == 1).map(|run| run[0].1).collect();
    let ends = |h: u32| [origin(corners, h), target(corners, h)];
    let place = |v: u32| positions[v as usize];
    let mut beside: Vec<(u32, u32)> =
        open.iter().flat_map(|&h| [ends(h), [ends(h)[1], ends(h)[0]]]).map(<_>::into).collect();
    beside.sort_unstable();
    let segments = open.iter().map(|&h| ends(h).map(place)).map(|[a, b]| [a, b, b]).collect();
    let tree = FaceTree::of_triangles(segments, &open);
    let is_between = |v: u32, [a, b]: [u32; 2]| {
        let (p, a, b) = (place(v), place(a), place(b));
        closest_on_segment(p, a, b).1.distance(p) <= reach && p.distance(a) > reach && p.distance(b) > reach
    };
    // Whether an open edge leaves v along the edge, towards another vertex on it, its end, or beyond.
    let goes_on_along = |v: u32, edge: [u32; 2]| {
        let start = beside.partition_point(|&(from, _)| from < v);
        let others = beside[start..].iter().take_while(|&&(from, _)| from == v).map(|&(_, to)| to);
        others
            .into_iter()
            .any(|w| edge.contains(&w) || is_between(w, edge) || edge.iter().any(|&e| is_between(e, [v, w])))
    };
    let on_edges = |v: u32| {
        ctx.check()?;
        let mut found = Vec::new();
        tree.closest_where(place(v), reach, |h| {
            found.push(h);
            false
        });
        found.sort_unstable();
        let lies_on = |&h: &u32| is_between(v, ends(h)) && apex(corners, h) != v && goes_on_along(v, ends(h));
        Ok(found.into_iter().filter(lies_on).map(|h| (h, v)).collect())
    };
    let mut vertices: Vec<u32> = beside.iter().map(|&(v, _)| v).collect();
    vertices.dedup();
    let found: Vec<Vec<(u32, u32)>> = vertices.par_iter().map(|&v| on_edges(v)).collect::<Result<_, Cancelled>>()?;
    let mut splits = found.concat();
    if splits.is_empty() {
        return Ok(());
    }
    tally.add("t_vertices_joined", splits.len());
    let along = |&(h, v): &(u32, u32)| (h, place(origin(corners, h)).distance(place(v)));
    splits.sort_by(|s, t| along(s).0.cmp(&along(t).0).then(along(s).1.total_cmp(&along(t).1)).then(s.1.cmp(&t.1)));
    let on = |h: u32| -> Vec<u32> {
        let (from, to) = (splits.partition_point(|s| s.0 < h), splits.partition_point(|s| s.0 <= h));
        splits[from..to].iter().map(|s| s.1).collect()
    };
    let mut split = Triangles::default();
    for (f, &face) in corners.iter().enumerate() {
        let h = 3 * f as u32;
        let before = split.corners.len();
        cut(face, [on(h), on(h + 1), on(h + 2)], &mut split.corners);
        split.polygon.resize(split.polygon.len() + split.corners.len() - before, triangles.polygon[f]);
    }
    *triangles = split;
    Ok(())
}

/// Cuts a triangle at vertices on its sides, given in the order of each side.
fn cut(face: [u32; 3], on: [Vec<u32>; 3], out: &mut Vec<[u32; 3]>) {
    let Some(side) = (0..3).max_by_key(|&k| (on[k].len(), 3 - k)).filter(|&k| !on[k].is_empty()) else {
        out.push(face);
        return;
    };
    let [a, b, c] = [face[side], face[(side + 1) % 3], face[(side + 2) % 3]];
    let [ab, bc, ca] = [&on[side], &on[(side + 1) % 3], &on[(side + 2) % 3]];
    let middle = ab.len() / 2;
    let t = ab[middle];
    cut([a, t, c], [ab[..middle].to_vec(), Vec::new(), ca.clone()], out);
    cut([t, b, c], [ab[middle + 1..].to_vec(), bc.clone(), Vec::new()], out);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::TriangleSoup;
    use crate::engine::mesh::condition::{ConditionOptions, condition};

    fn soup(points: &[[f64; 3]], faces: &[&[u32]]) -> TriangleSoup {
        let positions = points.iter().copied().map(DVec3::from_array).collect();
        let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
        faces.iter().for_each(|face| soup.push_polygon(face));
        soup
    }

    fn joined(soup: &TriangleSoup) -> (usize, usize, usize) {
        let made = condition(&RunContext::silent(), soup, &ConditionOptions::default()).unwrap();
        let topology = made.mesh.topology();
        let again = TriangleSoup::from_triangles(made.mesh.positions().to_vec(), made.mesh.faces());
        let again = condition(&RunContext::silent(), &again, &ConditionOptions::default()).unwrap();
        assert_eq!(again.mesh.faces(), made.mesh.faces(), "what was joined stays joined");
        let n = made.repairs.iter().find(|r| r.0 == "t_vertices_joined").map_or(0, |r| r.1);
        (n, topology.boundaries, topology.components)
    }

    /// Below the line y = 0 one long edge, above it edges between `xs`.
    fn seam(xs: &[f64], shift: f64) -> TriangleSoup {
        let mut points = vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, -2.0, 0.0], [1.0, 2.0, 0.0]];
        points.extend(xs.iter().map(|&x| [x, shift, 0.0]));
        let row: Vec<u32> = [0].into_iter().chain(4..4 + xs.len() as u32).chain([1]).collect();
        let fan: Vec<[u32; 3]> = row.windows(2).map(|w| [w[0], w[1], 3]).collect();
        let mut faces: Vec<&[u32]> = vec![&[1, 0, 2]];
        faces.extend(fan.iter().map(|f| &f[..]));
        soup(&points, &faces)
    }

    #[test]
    fn slits_at_t_vertices_are_closed() {
        assert_eq!(joined(&seam(&[], 0.0)), (0, 1, 1));
        assert_eq!(joined(&seam(&[1.0], 0.0)), (1, 1, 1));
        assert_eq!(joined(&seam(&[0.5, 1.0, 2.75], 1e-7)), (3, 1, 1));
        // A slit that can be seen stays one.
        assert_eq!(joined(&seam(&[1.0], 0.01)), (0, 2, 2));
    }

    #[test]
    fn a_vertex_that_only_touches_an_edge_splits_nothing() {
        let points = [[0., 0., 0.], [2., 0., 0.], [1., -1., 0.], [1., 0., 0.], [0.5, 1., 0.], [1.5, 1., 0.]];
        assert_eq!(joined(&soup(&points, &[&[1, 0, 2], &[3, 5, 4]])), (0, 2, 2));
    }

    #[test]
    fn both_sides_of_a_seam_may_have_vertices_of_their_own() {
        let points =
            [[0., 0., 0.], [3., 0., 0.], [1., -1., 0.], [1., 1., 0.], [1., 0., 0.], [2., 0., 0.], [2., 0., 0.]];
        let faces: [&[u32]; 4] = [&[4, 0, 2], &[1, 4, 2], &[0, 5, 3], &[6, 1, 3]];
        assert_eq!(joined(&soup(&points, &faces)), (2, 1, 1));
    }
}
