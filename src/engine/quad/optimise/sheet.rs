//! Moving on the surface by walking from face to face, so that a vertex never jumps to another sheet and never crosses
//! a feature curve.

use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::closest_on_triangle;

/// Faces looked at without finding a nearer point before a walk ends; enough to go round a vertex of a noisy surface.
const PATIENCE: usize = 10;
/// Most faces that one walk looks at.
const REACH: usize = 600;
/// Faces whose normals agree less than this (cosine) belong to another sheet.
const SAME_SHEET: f64 = 0.3;
/// Most rounds of averaging of the normals.
const ROUNDS: f64 = 40.0;

/// The surface as the moving vertices see it: faces, barriers between them, and normals at the scale of the quads.
#[derive(Debug)]
pub(crate) struct Sheet<'a> {
    surface: &'a Surface,
    /// Per halfedge: boundary or feature edge.
    barrier: Vec<bool>,
    /// Per face: the unit normal averaged over about a third of a quad, but never across a barrier.
    normals: Vec<DVec3>,
}

impl<'a> Sheet<'a> {
    /// `scale`: length of a quad's edge.
    pub(crate) fn new(surface: &'a Surface, scale: f64) -> Self {
        let barrier = surface.features.halfedge_flags(&surface.mesh);
        let normals = smooth_normals(surface, &barrier, scale);
        Self { surface, barrier, normals }
    }

    /// The surface itself.
    pub(crate) fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// Unit normal of a face at the scale of the quads.
    pub(crate) fn normal(&self, face: u32) -> DVec3 {
        self.normals[face as usize]
    }

    /// Whether a face is on the same sheet as something with this normal.
    pub(crate) fn agrees(&self, face: u32, normal: DVec3) -> bool {
        self.normal(face).dot(normal) > SAME_SHEET
    }

    /// The point of the surface nearest to `p`, or one up to `reach` further away on a sheet that agrees with `normal`
    /// (zero: any).
    pub(crate) fn land(&self, index: &SurfaceIndex, p: DVec3, normal: DVec3, reach: f64) -> (u32, DVec3) {
        let nearest = index.closest(p);
        let found = if normal == DVec3::ZERO || self.agrees(nearest.face, normal) {
            nearest
        } else {
            index.closest_where(p, nearest.distance + reach, |f| self.agrees(f, normal)).unwrap_or(nearest)
        };
        (found.face, found.position)
    }

    /// The point nearest to `p` that a walk from face `from` finds: it goes on as long as it comes nearer, and stays
    /// on the sheet and within the feature curves around `from`.
    pub(crate) fn follow(&self, from: u32, p: DVec3) -> (u32, DVec3) {
        let mesh = &self.surface.mesh;
        let up = self.normal(from);
        let look = |face: u32| {
            let position = closest_on_triangle(p, &mesh.triangle(face as usize)).1;
            (p.distance_squared(position), position)
        };
        let (mut least, position) = look(from);
        let mut best = (from, position);
        let mut seen = Vec::with_capacity(64);
        let mut frontier = Vec::with_capacity(64);
        seen.push(from);
        frontier.push((least, from));
        let mut patience = PATIENCE;
        while let Some(next) = (0..frontier.len()).min_by(|&i, &j| frontier[i].0.total_cmp(&frontier[j].0)) {
            let (distance, face) = frontier.swap_remove(next);
            if distance > least {
                patience -= 1;
                if patience == 0 {
                    break;
                }
            }
            if seen.len() > REACH {
                break;
            }
            for h in 3 * face as usize..3 * face as usize + 3 {
                let Some(twin) = mesh.twin(h).filter(|_| !self.barrier[h]) else { continue };
                let across = (twin / 3) as u32;
                if seen.contains(&across) {
                    continue;
                }
                seen.push(across);
                if !self.agrees(across, up) {
                    continue;
                }
                let (distance, position) = look(across);
                if distance < least {
                    least = distance;
                    best = (across, position);
                    patience = PATIENCE;
                }
                frontier.push((distance, across));
            }
        }
        best
    }
}

fn smooth_normals(surface: &Surface, barrier: &[bool], scale: f64) -> Vec<DVec3> {
    let mesh = &surface.mesh;
    let n = mesh.n_faces();
    let mut normals: Vec<DVec3> = (0..n).map(|f| mesh.area_vector(f)).collect();
    let spacing_squared = mesh.total_area() / n.max(1) as f64;
    let rounds = if spacing_squared > 0.0 { 0.1 * scale * scale / spacing_squared } else { 0.0 };
    for _ in 0..rounds.clamp(0.0, ROUNDS) as usize {
        let last = normals.clone();
        for (f, normal) in normals.iter_mut().enumerate() {
            for h in (3 * f..3 * f + 3).filter(|&h| !barrier[h]) {
                *normal += mesh.twin(h).map_or(DVec3::ZERO, |t| last[t / 3]);
            }
            *normal *= 0.25;
        }
    }
    normals.into_iter().enumerate().map(|(f, n)| n.try_normalize().unwrap_or_else(|| mesh.normal(f))).collect()
}
