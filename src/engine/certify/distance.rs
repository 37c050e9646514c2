//! Sampled distances between the quads and the surface.

use crate::engine::certify::Defect;
use crate::engine::certify::shape::corners;
use crate::engine::mesh::{SurfaceIndex, TriMesh};
use crate::engine::numerics::Random;
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// Samples over the area of each side, besides vertices: at least this many,
const MIN_SAMPLES: usize = 2_000;
/// … in between this many per triangle of both sides,
const SAMPLES_PER_FACE: usize = 20;
/// … and at most this many.
const MAX_SAMPLES: usize = 30_000;
/// At most this many vertices of each side are samples.
const VERTICES: usize = 100_000;

/// Distances in model units.
pub(super) struct Distances {
    /// The largest distance of a sample of either side to the other side.
    pub(super) max: f64,
    /// The sample that has it.
    pub(super) farthest: Option<DVec3>,
    /// Mean distance of the samples on the quads' area to the surface.
    pub(super) mean: f64,
    /// Samples of the surface beyond the limit of their face and two of the shortest edges of the quad nearest to them, and
    /// that quad; in order of quads, of each quad the furthest.
    pub(super) far: Vec<(u32, DVec3)>,
}

/// The quads as triangles, each quad as a fan around its centroid, which lies on the bilinear patch of the quad.
pub(super) fn triangulate(quads: &QuadMesh) -> Option<TriMesh> {
    let mut positions = quads.positions.clone();
    let mut faces = Vec::with_capacity(4 * quads.quads.len());
    for (q, quad) in quads.quads.iter().enumerate() {
        let centre = positions.len() as u32;
        positions.push(corners(quads, q).iter().sum::<DVec3>() / 4.0);
        faces.extend((0..4).map(|k| [quad[k], quad[(k + 1) % 4], centre]));
    }
    TriMesh::try_new(positions, faces).ok()
}

/// The sampled two-sided Hausdorff distance. `limit`: per face of the surface, how far samples on it may be from the quads.
pub(super) fn measure(
    ctx: &RunContext,
    surface: &TriMesh,
    surface_index: &SurfaceIndex,
    quads: &TriMesh,
    quad_index: &SurfaceIndex,
    limit: impl Fn(u32) -> f64,
) -> Result<Distances, Cancelled> {
    let faces = surface.n_faces() + quads.n_faces();
    let n = (SAMPLES_PER_FACE * faces).clamp(MIN_SAMPLES, MAX_SAMPLES);
    let over_area = samples(quads, n, 1);
    let of_area = distances(&ctx.part(0, 4), surface_index, &over_area)?;
    let mean = of_area.iter().map(|d| d.0).sum::<f64>() / of_area.len().max(1) as f64;
    let (mut max, mut farthest) = (0.0, None);
    let mut heed = |points: &[(DVec3, u32)], distances: &[(f64, u32)]| {
        for (&(p, _), &(distance, _)) in points.iter().zip(distances) {
            if distance > max {
                (max, farthest) = (distance, Some(p));
            }
        }
    };
    heed(&over_area, &of_area);
    let others =
        [(surface_index, vertices(quads)), (quad_index, samples(surface, n, 2)), (quad_index, vertices(surface))];
    // Each of the four triangles of a quad has one of its sides as its first.
    let side = |f: usize| quads.triangle(f)[0].distance(quads.triangle(f)[1]);
    let edge = |quad: u32| (4 * quad as usize..4 * quad as usize + 4).map(side).fold(f64::INFINITY, f64::min);
    let mut far: Vec<(u32, f64, DVec3)> = Vec::new();
    for (i, (index, points)) in others.into_iter().enumerate() {
        let found = distances(&ctx.part(1 + i, 4), index, &points)?;
        heed(&points, &found);
        if i > 0 {
            // Four triangles make a quad, in order.
            let beyond = points
                .iter()
                .zip(&found)
                .filter(|(point, found)| found.0 > limit(point.1) && found.0 > Defect::far(edge(found.1 / 4)));
            far.extend(beyond.map(|(&(p, _), &(d, face))| (face / 4, d, p)));
        }
    }
    far.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    far.dedup_by_key(|f| f.0);
    Ok(Distances { max, farthest, mean, far: far.into_iter().map(|(quad, _, p)| (quad, p)).collect() })
}

fn distances(ctx: &RunContext, index: &SurfaceIndex, points: &[(DVec3, u32)]) -> Result<Vec<(f64, u32)>, Cancelled> {
    let at = |(i, &(p, _)): (usize, &(DVec3, u32))| {
        if i % 32 == 0 {
            ctx.check()?;
            ctx.step(points.len().div_ceil(32));
        }
        let found = index.closest(p);
        Ok((found.distance, found.face))
    };
    points.par_iter().enumerate().map(at).collect()
}

/// Vertices, at most about [`VERTICES`], each with a face that it belongs to.
fn vertices(mesh: &TriMesh) -> Vec<(DVec3, u32)> {
    let step = mesh.n_vertices().div_ceil(VERTICES).max(1);
    (0..mesh.n_vertices() as u32).step_by(step).map(|v| (mesh.position(v), (mesh.outgoing(v) / 3) as u32)).collect()
}

/// n points spread evenly over the area, one per stratum of equal area in face order, each with its face.
fn samples(mesh: &TriMesh, n: usize, salt: u64) -> Vec<(DVec3, u32)> {
    let total = mesh.total_area();
    let mut points = Vec::with_capacity(n);
    let (mut face, mut area_before) = (0, 0.0);
    for i in 0..n as u64 {
        let [jitter, r, s] = [0, 1, 2].map(|k| Random::at(0, (salt << 32) | (3 * i + k)).unit());
        let wanted = (i as f64 + jitter) / n as f64 * total;
        while face + 1 < mesh.n_faces() && area_before + mesh.area(face) < wanted {
            area_before += mesh.area(face);
            face += 1;
        }
        if face < mesh.n_faces() {
            let [a, b, c] = mesh.triangle(face);
            let r = r.sqrt();
            points.push(((1.0 - r) * a + r * (1.0 - s) * b + r * s * c, face as u32));
        }
    }
    points
}
