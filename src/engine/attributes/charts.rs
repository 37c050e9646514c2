//! Texture coordinates of quads as seen from the quad: never across a seam.

use std::collections::BTreeSet;

use glam::DVec3;

use crate::engine::attributes::corner_values::CornerValue;
use crate::engine::attributes::origin::Origin;
use crate::engine::mesh::{SurfacePoint, closest_on_triangle, next};

/// Texture coordinates that differ by less, relative to their size, are the same.
const SAME: f32 = 1e-5;
/// How far corners are drawn towards the centre of their quad to see which side of a seam they belong to, relative to
/// their distance from it.
const DRAWN: f64 = 1e-3;
/// The piece of the surface that belongs to a quad reaches this much farther than its corners.
const MARGIN: f64 = 1.2;

/// Texture coordinates at the corners of the faces of a surface.
pub(super) struct Charts<'a> {
    pub(super) origin: &'a Origin<'a>,
    pub(super) uv: Vec<[[f32; 2]; 3]>,
}

impl Charts<'_> {
    /// The coordinates at the corners of a quad whose centre is nearest to `start`; `normal` is the quad's.
    ///
    /// The quad's piece of the surface is what can be reached from there without crossing a seam or leaving its
    /// surroundings. Around the end of a seam such a piece has both sides, so every corner chooses its own face first
    /// from a place slightly inside the quad. Corners of quads that cross a seam get what their own side has nearest.
    pub(super) fn at_corners(&self, corners: [DVec3; 4], start: &SurfacePoint, normal: DVec3) -> [[f32; 2]; 4] {
        let centre = corners.iter().sum::<DVec3>() / 4.0;
        let radius = MARGIN * corners.iter().map(|c| c.distance(centre)).fold(0.0, f64::max) + start.distance;
        let piece = self.reach(start.face, centre, radius, |f| self.origin.faces_along(f, normal));
        corners.map(|corner| self.at_corner(corner, centre, &piece).unwrap_or_else(|| self.value(start)))
    }

    fn at_corner(&self, corner: DVec3, centre: DVec3, piece: &BTreeSet<u32>) -> Option<[f32; 2]> {
        let nearest = |p: DVec3| self.nearest(p, piece);
        let on_surface = nearest(corner)?;
        if piece.len() == 1 {
            return Some(self.value(&on_surface));
        }
        let drawn = nearest(corner + DRAWN * (centre - corner))?;
        let radius = 2.0 * DRAWN * centre.distance(corner);
        let side = self.reach(drawn.face, on_surface.position, radius, |f| piece.contains(&f));
        let mut best: Option<(f64, [f32; 2])> = None;
        for f in side {
            let (weights, p) = closest_on_triangle(on_surface.position, &self.origin.mesh.triangle(f as usize));
            let distance = p.distance_squared(on_surface.position);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, CornerValue::blend(weights, self.uv[f as usize])));
            }
        }
        best.map(|(_, uv)| uv)
    }

    /// The point of a piece of the surface nearest to `p`, in the lowest of several faces.
    fn nearest(&self, p: DVec3, piece: &BTreeSet<u32>) -> Option<SurfacePoint> {
        let mut best: Option<SurfacePoint> = None;
        for &face in piece {
            let (barycentric, position) = closest_on_triangle(p, &self.origin.mesh.triangle(face as usize));
            let distance = p.distance(position);
            if best.is_none_or(|best| distance < best.distance) {
                best = Some(SurfacePoint { face, barycentric, position, distance });
            }
        }
        best
    }

    fn value(&self, at: &SurfacePoint) -> [f32; 2] {
        CornerValue::blend(at.barycentric, self.uv[at.face as usize])
    }

    /// The faces that touch a ball and are joined to `start` by such faces without a seam between them.
    fn reach(&self, start: u32, centre: DVec3, radius: f64, accept: impl Fn(u32) -> bool) -> BTreeSet<u32> {
        let mesh = self.origin.mesh;
        let mut found = BTreeSet::from([start]);
        let mut stack = vec![start];
        while let Some(face) = stack.pop() {
            for h in 3 * face as usize..3 * face as usize + 3 {
                let Some(twin) = mesh.twin(h).filter(|&twin| !self.is_seam(h, twin)) else { continue };
                let other = (twin / 3) as u32;
                if found.contains(&other) || !accept(other) {
                    continue;
                }
                let (_, nearest) = closest_on_triangle(centre, &mesh.triangle(other as usize));
                if nearest.distance(centre) <= radius {
                    found.insert(other);
                    stack.push(other);
                }
            }
        }
        found
    }

    fn is_seam(&self, h: usize, twin: usize) -> bool {
        let uv = |h: usize| self.uv[h / 3][h % 3];
        let differ = |a: [f32; 2], b: [f32; 2]| {
            let size = a.iter().chain(&b).fold(1.0_f32, |size, x| size.max(x.abs()));
            (0..2).any(|i| (a[i] - b[i]).abs() > SAME * size)
        };
        differ(uv(h), uv(next(twin))) || differ(uv(next(h)), uv(twin))
    }
}
