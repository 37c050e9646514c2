//! Quads that pass through each other where the surface does not pass through itself: sheets that lie closer together than
//! the quads are large.

use crate::engine::certify::shape::corners;
use crate::engine::mesh::{FaceTree, SurfaceIndex, TriMesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// A crossing of the quads is the surface's own if that crosses itself within this many quad edges.
const NEAR: f64 = 2.0;
/// Corners this near to a plane lie in it: part of the extent of both triangles.
const TOUCHING: f64 = 1e-9;

/// The middles of pairs of quads that share no vertex and pass through each other, in order of the first quad, where the
/// surface does not pass through itself within two edges. Quads that only touch, or overlap in one plane, do not count.
/// `edge_length` is that of the quads in model units. O(n log n).
///
/// # Errors
/// A stop of the run.
pub fn new_crossings(
    ctx: &RunContext,
    surface: &TriMesh,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    edge_length: f64,
) -> Result<Vec<DVec3>, Cancelled> {
    let halves: Vec<[DVec3; 3]> = (0..quads.quads.len()).flat_map(|q| halves(corners(quads, q))).collect();
    let names: Vec<u32> = (0..quads.quads.len() as u32).flat_map(|q| [q; 2]).collect();
    let tree = FaceTree::of_triangles(halves.clone(), &names);
    let of_quad = |q: u32| {
        if q.is_multiple_of(32) {
            ctx.check()?;
        }
        let mut others: Vec<u32> = Vec::new();
        let is_apart = |r: u32| {
            let own = corners(quads, q as usize);
            corners(quads, r as usize).iter().all(|p| !own.contains(p))
        };
        for half in &halves[2 * q as usize..2 * q as usize + 2] {
            tree.meeting(half, |r, other| {
                if r > q && !others.contains(&r) && is_apart(r) && cross(half, other) {
                    others.push(r);
                }
            });
        }
        others.sort_unstable();
        let middle = |r: u32| {
            let sum: DVec3 = corners(quads, q as usize).iter().chain(&corners(quads, r as usize)).sum();
            sum / 8.0
        };
        Ok(others.into_iter().map(middle).collect::<Vec<DVec3>>())
    };
    let found: Vec<Vec<DVec3>> =
        (0..quads.quads.len() as u32).into_par_iter().map(of_quad).collect::<Result<_, Cancelled>>()?;
    let found = found.concat();
    let own = crossings_near(ctx, surface, index, &found, NEAR * edge_length)?;
    Ok(found.into_iter().filter(|p| own.iter().all(|q| p.distance(*q) > NEAR * edge_length)).collect())
}

/// Places near these where the surface passes through itself.
fn crossings_near(
    ctx: &RunContext,
    surface: &TriMesh,
    index: &SurfaceIndex,
    places: &[DVec3],
    reach: f64,
) -> Result<Vec<DVec3>, Cancelled> {
    let mut faces: Vec<u32> = Vec::new();
    for &p in places {
        ctx.check()?;
        index.tree().meeting(&[p - reach, p, p + reach], |f, _| faces.push(f));
        faces.sort_unstable();
        faces.dedup();
    }
    let crossing = |(i, &f): (usize, &u32)| {
        if i % 32 == 0 {
            ctx.check()?;
        }
        let (own, corners) = (surface.triangle(f as usize), surface.face(f as usize));
        let mut is_crossed = false;
        index.tree().meeting(&own, |g, other| {
            let is_apart = || surface.face(g as usize).iter().all(|v| !corners.contains(v));
            is_crossed |= g != f && is_apart() && cross(&own, other);
        });
        Ok(is_crossed.then(|| own.iter().sum::<DVec3>() / 3.0))
    };
    let found: Vec<Option<DVec3>> = faces.par_iter().enumerate().map(crossing).collect::<Result<_, Cancelled>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// A quad as two triangles, along its shorter diagonal.
fn halves([a, b, c, d]: [DVec3; 4]) -> [[DVec3; 3]; 2] {
    if a.distance_squared(c) <= b.distance_squared(d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

/// Whether an edge of one triangle passes through the inside of the other.
fn cross(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let all = a.iter().chain(b);
    let (low, high) = all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let least = TOUCHING * (high - low).length().powi(3);
    let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot(s - p);
    let passes = |edge: [DVec3; 2], t: &[DVec3; 3]| {
        let [p, q] = edge;
        let (above, below) = (volume(t[0], t[1], t[2], p), volume(t[0], t[1], t[2], q));
        if above.abs() <= least || below.abs() <= least || (above > 0.0) == (below > 0.0) {
            return false;
        }
        let side = (0..3).map(|k| volume(p, q, t[k], t[(k + 1) % 3]));
        let side: Vec<f64> = side.collect();
        side.iter().all(|v| *v > least) || side.iter().all(|v| *v < -least)
    };
    let edges = |t: &[DVec3; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(a).into_iter().any(|edge| passes(edge, b)) || edges(b).into_iter().any(|edge| passes(edge, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::certify::tests::{join, split, surface};
    use crate::engine::mesh::Surface;

    fn crossings(surface: &Surface, quads: &QuadMesh) -> Vec<DVec3> {
        let index = SurfaceIndex::new(&surface.mesh);
        new_crossings(&RunContext::silent(), &surface.mesh, &index, quads, 0.05).unwrap()
    }

    /// Two spheres with this distance of their centres.
    fn spheres(apart: f64) -> Surface {
        let sphere = surface("sphere", 600);
        join(&sphere, &sphere, DVec3::new(apart, 0.03, 0.02))
    }

    #[test]
    fn crossings_of_the_surface_are_its_own_and_others_are_new() {
        let diameter = surface("sphere", 600).mesh.diagonal() / 3f64.sqrt();
        let (close, apart) = (spheres(0.8 * diameter), spheres(1.2 * diameter));
        assert_eq!(crossings(&apart, &split(&apart.mesh)), []);
        assert_eq!(crossings(&close, &split(&close.mesh)), [], "the surface passes through itself there");
        let found = crossings(&apart, &split(&close.mesh));
        assert!(found.len() > 20, "{}", found.len());
        // They lie on the circle in which the spheres meet.
        let middle = found.iter().sum::<DVec3>() / found.len() as f64;
        let radius = |p: &DVec3| p.distance(middle);
        let (least, most) = found.iter().map(radius).fold((f64::INFINITY, 0.0f64), |(l, m), r| (l.min(r), m.max(r)));
        assert!(most - least < 0.15 * diameter, "{least} {most}");
    }

    #[test]
    fn touching_is_no_crossing() {
        let [o, x, y, z] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert!(cross(&[o, 2.0 * x, 2.0 * y], &[DVec3::new(0.5, 0.5, -1.0), DVec3::new(0.5, 0.6, 1.0), 3.0 * (x + z)]));
        for other in
            [[o, -x, -y], [0.5 * x, 0.5 * x + z, 0.7 * x + z], [0.2 * (x + y), x + z, y + z], [z, x + z, y + z]]
        {
            assert!(!cross(&[o, x, y], &other), "{other:?}");
        }
    }
}
