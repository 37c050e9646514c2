//! Curves that zigzag from triangle to triangle, drawn straight on the surface.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::{Surface, SurfaceIndex, TriMesh};
use crate::engine::run::{Cancelled, RunContext};

/// Cosine of 20 degrees. A curve vertex is part of a zigzag if the curve turns there by more than this angle.
const ZIGZAG_TURN_COS: f64 = 0.94;
/// Cosine of 30 degrees. An edge is a crease if the normals of its two faces differ by at least this angle. A feature
/// curve along other edges (a border of materials, say) does not mark the shape, so its vertices may move off it.
const CREASE_ANGLE_COS: f64 = 0.866;
/// Weights λ and μ of the two steps of a smoothing pass `[taubin_1995]`: the first shrinks, the second expands. Together
/// they keep the low frequencies of a curve.
const TAUBIN_WEIGHTS: [f64; 2] = [0.5, -0.53];
/// Minimum and maximum number of smoothing passes. In between, it is chosen such that smoothing reaches about half a
/// quad edge along the curve: n passes reach √n of its segments.
const PASS_BOUNDS: [f64; 2] = [4.0, 50.0];
/// No vertex moves further than this part of a quad edge.
const MAX_DISPLACEMENT: f64 = 0.25;
/// Cosine of 60 degrees: the normal of a face must stay within this angle of its original direction.
const MAX_NORMAL_TURN_COS: f64 = 0.5;

/// The surface with the zigzags of its feature curves drawn straight at the scale of quads with edges of `edge_length`
/// (model units): borders of materials run from triangle to triangle, and quads cannot follow every turn of theirs. Vertices
/// move along the surface, by at most a quarter of an edge; corners, creases, the boundary and curves that turn by less
/// than 20 degrees at every vertex stay. `None` where there is nothing to be done. `index` is the index of the mesh. O(V).
///
/// # Errors
/// [`Cancelled`] only.
pub fn straightened(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    edge_length: f64,
) -> Result<Option<Surface>, Cancelled> {
    let mesh = &surface.mesh;
    let neighbours = curve_neighbours(surface);
    let start = mesh.positions();
    let turns = |v: u32| {
        let [a, b] = neighbours[v as usize]?.map(|w| start[w as usize]);
        let p = start[v as usize];
        Some((p - a).normalize_or_zero().dot((b - p).normalize_or_zero()) < ZIGZAG_TURN_COS)
    };
    let zigzag: Vec<bool> = (0..mesh.n_vertices() as u32).map(|v| turns(v) == Some(true)).collect();
    let may_move = |v: &u32| {
        neighbours[*v as usize].is_some_and(|ends| zigzag[*v as usize] || ends.iter().any(|&w| zigzag[w as usize]))
    };
    let moving: Vec<u32> = (0..mesh.n_vertices() as u32).filter(may_move).collect();
    if !zigzag.contains(&true) {
        return Ok(None);
    }
    let step = |v: &u32| neighbours[*v as usize].map_or(0.0, |[a, _]| start[a as usize].distance(start[*v as usize]));
    let mean = moving.iter().map(step).sum::<f64>() / moving.len() as f64;
    let passes = (0.5 * edge_length / mean).powi(2).clamp(PASS_BOUNDS[0], PASS_BOUNDS[1]) as usize;
    let mut positions = start.to_vec();
    for weight in (0..passes).flat_map(|_| TAUBIN_WEIGHTS) {
        let moved = |(i, &v): (usize, &u32)| {
            if i % 32 == 0 {
                ctx.check()?;
            }
            let here = positions[v as usize];
            let Some(ends) = neighbours[v as usize] else { return Ok(here) };
            let middle = ends.map(|w| positions[w as usize]).into_iter().sum::<DVec3>() / 2.0;
            let to = here + weight * (middle - here) - start[v as usize];
            let to = start[v as usize] + to.clamp_length_max(MAX_DISPLACEMENT * edge_length);
            let there = index.closest(to).position;
            Ok(if turns_face_too_far(mesh, &positions, v, there) { here } else { there })
        };
        let new: Vec<DVec3> = moving.par_iter().enumerate().map(moved).collect::<Result<_, Cancelled>>()?;
        moving.iter().zip(new).for_each(|(&v, p)| positions[v as usize] = p);
    }
    // The check above moves one vertex at a time, but neighbours move together. So faces may still have turned too far:
    // reset all of their vertices, until there is no such face.
    loop {
        ctx.check()?;
        let bad = |f: &usize| {
            let now = area(mesh.face(*f).map(|v| positions[v as usize]));
            now.dot(mesh.normal(*f)) <= MAX_NORMAL_TURN_COS * now.length()
        };
        let bad: Vec<usize> = (0..mesh.n_faces()).into_par_iter().filter(bad).collect();
        let back: Vec<u32> = bad.into_iter().flat_map(|f| mesh.face(f)).collect();
        let back: Vec<u32> = back.into_iter().filter(|&v| positions[v as usize] != start[v as usize]).collect();
        if back.is_empty() {
            break;
        }
        back.into_iter().for_each(|v| positions[v as usize] = start[v as usize]);
    }
    let mesh = TriMesh::try_new(positions, mesh.faces().to_vec()).ok();
    Ok(mesh.map(|mesh| Surface { mesh, features: surface.features.clone() }))
}

/// Per vertex, its two neighbours on the feature curve; `None` unless it is inside a curve that is no crease.
fn curve_neighbours(surface: &Surface) -> Vec<Option<[u32; 2]>> {
    let mesh = &surface.mesh;
    let flags = surface.features.halfedge_flags(mesh);
    let of = |v: u32| {
        if mesh.is_boundary_vertex(v) || surface.features.is_corner(v) {
            return None;
        }
        let mut ends = mesh.fan(v).filter(|&h| flags[h]);
        let pair = [ends.next()?, ends.next()?];
        let is_flat =
            |h: usize| mesh.twin(h).is_some_and(|t| mesh.normal(h / 3).dot(mesh.normal(t / 3)) > CREASE_ANGLE_COS);
        (ends.next().is_none() && pair.into_iter().all(is_flat)).then(|| pair.map(|h| mesh.target(h)))
    };
    (0..mesh.n_vertices() as u32).map(of).collect()
}

/// Whether moving `v` to `p` would put the normal of one of its faces 60 degrees or more off the original one.
fn turns_face_too_far(mesh: &TriMesh, positions: &[DVec3], v: u32, p: DVec3) -> bool {
    mesh.fan(v).any(|h| {
        let corners = mesh.face(h / 3).map(|w| if w == v { p } else { positions[w as usize] });
        let now = area(corners);
        now.dot(mesh.normal(h / 3)) <= MAX_NORMAL_TURN_COS * now.length()
    })
}

fn area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::Features;
    use crate::engine::mesh::shapes::sample_surface;

    /// A surface with the edges between the faces on either side of a plane as its only features.
    fn cut_by_a_plane(name: &str) -> Surface {
        let mesh = sample_surface(name, 3000).unwrap().mesh;
        let normal = DVec3::new(0.35, 0.2, 0.9).normalize();
        let side = |f: usize| (mesh.triangle(f).iter().sum::<DVec3>() / 3.0).dot(normal) > 0.05;
        let border = |&h: &usize| mesh.is_edge_owner(h) && mesh.twin(h).is_some_and(|t| side(h / 3) != side(t / 3));
        let mut edges: Vec<[u32; 2]> = (0..mesh.n_halfedges())
            .filter(border)
            .map(|h| [mesh.origin(h).min(mesh.target(h)), mesh.origin(h).max(mesh.target(h))])
            .collect();
        edges.sort_unstable();
        Surface { features: Features { edges, corners: Vec::new() }, mesh }
    }

    fn length(surface: &Surface) -> f64 {
        let ends = surface.features.edges.iter().map(|e| e.map(|v| surface.mesh.position(v)));
        ends.map(|[a, b]| a.distance(b)).sum()
    }

    #[test]
    fn zigzags_become_straight_and_stay_on_the_surface() {
        for name in ["sphere", "torus"] {
            let rough = cut_by_a_plane(name);
            let index = SurfaceIndex::new(&rough.mesh);
            let edge = (rough.mesh.total_area() / 600.0).sqrt();
            let even = straightened(&RunContext::silent(), &rough, &index, edge).unwrap().unwrap();
            assert_eq!((&even.features, even.mesh.faces()), (&rough.features, rough.mesh.faces()));
            assert!(length(&even) < 0.88 * length(&rough), "{name}: {} of {}", length(&even), length(&rough));
            for (p, q) in even.mesh.positions().iter().zip(rough.mesh.positions()) {
                assert!(p.distance(*q) <= 1.01 * MAX_DISPLACEMENT * edge);
                assert!(index.closest(*p).distance < 1e-9);
            }
            let upright = |f: usize| even.mesh.normal(f).dot(rough.mesh.normal(f)) > MAX_NORMAL_TURN_COS - 1e-9;
            assert!((0..rough.mesh.n_faces()).all(upright), "{name}");
        }
    }

    #[test]
    fn creases_and_smooth_curves_stay() {
        for name in ["cube", "gear", "plate_with_holes", "half_pipe", "sphere"] {
            let surface = sample_surface(name, 3000).unwrap();
            let index = SurfaceIndex::new(&surface.mesh);
            assert!(straightened(&RunContext::silent(), &surface, &index, 0.1).unwrap().is_none(), "{name}");
        }
    }
}
