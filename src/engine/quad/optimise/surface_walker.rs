//! Moving on the surface to nearest points that are connected to the last one, so that a vertex never jumps to another
//! side of a thin wall and never crosses a feature curve.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::FaceCells;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::closest_on_triangle;

/// Radius of the cells that lead from place to place, in quad edges.
const CELL: f64 = 0.25;
/// Most cells that one step looks at: those of a disc of two quad edges.
const REACH: usize = 64;
/// Faces whose normals agree less than this (cosine) lie on another side.
const SAME_SIDE: f64 = 0.3;
/// Most rounds of averaging of the normals.
const ROUNDS: f64 = 40.0;

/// Walks over the surface with vertices that move: it knows the faces, the barriers between them, and normals at the scale
/// of the quads.
#[derive(Debug)]
pub(crate) struct SurfaceWalker<'a> {
    surface: &'a Surface,
    index: &'a SurfaceIndex,
    /// Faces that are connected, never across a feature edge.
    cells: FaceCells,
    /// Length of a quad's edge.
    scale: f64,
    /// Per face: the unit normal averaged over about a third of a quad, but never across a barrier.
    normals: Vec<DVec3>,
}

impl<'a> SurfaceWalker<'a> {
    /// `scale`: length of a quad's edge.
    pub(crate) fn new(surface: &'a Surface, index: &'a SurfaceIndex, scale: f64) -> Self {
        let barrier = surface.features.halfedge_flags(&surface.mesh);
        let normals = smooth_normals(surface, &barrier, scale);
        let cells = FaceCells::new(&surface.mesh, &barrier, CELL * scale);
        Self { surface, index, cells, scale, normals }
    }

    /// The surface itself.
    pub(crate) fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// Unit normal of a face at the scale of the quads.
    pub(crate) fn normal(&self, face: u32) -> DVec3 {
        self.normals[face as usize]
    }

    /// Whether a face lies on the same side as something with this normal.
    pub(crate) fn agrees(&self, face: u32, normal: DVec3) -> bool {
        self.normal(face).dot(normal) > SAME_SIDE
    }

    /// The point of the surface nearest to `p`, or one up to `reach` further away on the side that agrees with `normal`
    /// (zero: any).
    pub(crate) fn land(&self, p: DVec3, normal: DVec3, reach: f64) -> (u32, DVec3) {
        let nearest = self.index.closest(p);
        let found = if normal == DVec3::ZERO || self.agrees(nearest.face, normal) {
            nearest
        } else {
            self.index.closest_where(p, nearest.distance + reach, |f| self.agrees(f, normal)).unwrap_or(nearest)
        };
        (found.face, found.position)
    }

    /// The point of the surface around face `from` that is nearest to `p`: no further from it than `from` is, in a face that
    /// agrees with `from` and that is reached from there over few cells and no feature curve.
    pub(crate) fn follow(&self, from: u32, p: DVec3) -> (u32, DVec3) {
        let up = self.normal(from);
        let own = closest_on_triangle(p, &self.surface.mesh.triangle(from as usize)).1;
        let (distance, start) = (p.distance(own), self.cells.of(from));
        let is_next = |cell: u32| cell == start || self.cells.neighbours(start).contains(&cell);
        let nearest = self.index.closest_where(p, distance, |f| self.agrees(f, up));
        let Some(nearest) = nearest else { return (from, own) };
        if is_next(self.cells.of(nearest.face)) {
            return (nearest.face, nearest.position);
        }
        let around = self.around(start, own, 2.0 * distance + self.scale, self.cells.of(nearest.face));
        let found = match around.contains(&self.cells.of(nearest.face)) {
            true => Some(nearest),
            false => {
                let is_there = |f: u32| around.contains(&self.cells.of(f)) && self.agrees(f, up);
                self.index.closest_where(p, distance, is_there)
            }
        };
        found.map_or((from, own), |found| (found.face, found.position))
    }

    /// The cells that are reached from one over cells within a ball, nearest by steps first: up to a wanted one, or at most
    /// `REACH`.
    fn around(&self, start: u32, centre: DVec3, radius: f64, wanted: u32) -> Vec<u32> {
        let mut around = vec![start];
        let mut next = 0;
        while let Some(&cell) = around.get(next).filter(|_| around.len() < REACH) {
            next += 1;
            for &other in self.cells.neighbours(cell) {
                let first = self.surface.mesh.triangle(self.cells.faces(other)[0] as usize);
                let is_within = closest_on_triangle(centre, &first).1.distance(centre) <= radius;
                if is_within && !around.contains(&other) {
                    around.push(other);
                    if other == wanted {
                        return around;
                    }
                }
            }
        }
        around
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
        normals.par_iter_mut().enumerate().for_each(|(f, normal)| {
            for h in (3 * f..3 * f + 3).filter(|&h| !barrier[h]) {
                *normal += mesh.twin(h).map_or(DVec3::ZERO, |t| last[t / 3]);
            }
            *normal *= 0.25;
        });
    }
    normals.into_iter().enumerate().map(|(f, n)| n.try_normalize().unwrap_or_else(|| mesh.normal(f))).collect()
}
