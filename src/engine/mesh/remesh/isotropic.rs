//! Isotropic remeshing `[botsch_2004]`: split long edges, collapse short ones, flip towards valence 6, relax, project.
//!
//! What the paper leaves open is decided by one rule: no change may take the mesh away from the surface. Each
//! change is tried on the triangles that it makes, against the normals and the distance of the original surface.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::refine::{bisect, make_room};
use crate::engine::mesh::remesh::edit::{EditMesh, Edited};
use crate::engine::mesh::{Surface, SurfaceIndex, SurfacePoint};
use crate::engine::run::{Cancelled, RunContext};

/// What the new triangles should be like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsotropicOptions {
    /// Edge length to aim at, model units, positive. Edges come out between 4/5 and 4/3 of it, shorter where features
    /// or the tolerance demand.
    pub target_edge: f64,
    /// How far triangles may stray from the original surface, model units; also for feature curves and the boundary.
    pub tolerance: f64,
    /// Rounds of split, collapse, flip and relax.
    pub sweeps: usize,
    /// Whether no face may have more than one edge on a feature curve or the boundary and no other edge may join two
    /// vertices of them, as the cross field and the map need it.
    pub room_at_features: bool,
    /// Whether every curve edge will be cut once more at its curve's middle, so that not the edge but each of its halves
    /// must be close to the curve.
    pub halved_curves: bool,
    /// Whether new triangles must agree with the surface's normals however bad the ones were that they replace: where the
    /// surface is folded in itself the triangles then stay as they are.
    pub strict: bool,
    /// No edge is split once there are so many faces (room at features is made regardless).
    pub max_faces: usize,
}

impl IsotropicOptions {
    /// A working mesh for the parameterisation: close to the surface, room at the features.
    pub fn dense(target_edge: f64) -> Self {
        let tolerance = 0.1 * target_edge;
        Self {
            target_edge,
            tolerance,
            sweeps: 4,
            room_at_features: true,
            halved_curves: false,
            strict: false,
            max_faces: 4_000_000,
        }
    }

    /// A coarse mesh whose triangles become quads themselves.
    pub fn coarse(target_edge: f64) -> Self {
        let tolerance = 0.2 * target_edge;
        Self { tolerance, room_at_features: false, halved_curves: true, strict: true, ..Self::dense(target_edge) }
    }
}

/// Sizes relative to the edge length aimed at, for points near the surface. Sizes above 1 let edges grow by splitting less,
/// but no edge longer than the one aimed at is collapsed for them.
pub(in crate::engine) type LocalSize<'a> = &'a (dyn Fn(DVec3) -> f64 + Sync);

/// Cosine of the angle to the original surface from which on a triangle is refused, unless it was worse before.
const MIN_AGREEMENT: f64 = 0.3;
/// Triangles that agree with the surface's normals better than this are believed to lie close to it.
const CLEAR_AGREEMENT: f64 = 0.92;

/// Remeshes `surface` with even, well shaped triangles. `original` is the surface that distances and normals are
/// measured against: `surface` itself or what it was made from. Topology, corners and feature curves stay: corners keep
/// their places and their order, and curves remain chains of edges between the same corners.
///
/// # Errors
/// [`Cancelled`] only.
pub fn remesh_isotropic(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    options: &IsotropicOptions,
) -> Result<Surface, Cancelled> {
    Ok(remesh_with_middles(ctx, surface, original, options, None)?.surface)
}

/// [`remesh_isotropic`], and where the curves are between the ends of their edges.
pub(in crate::engine) fn remesh_with_middles(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    options: &IsotropicOptions,
    size: Option<LocalSize<'_>>,
) -> Result<Edited, Cancelled> {
    let mut work = Remesher::new(ctx, surface, original, *options, size);
    // Much too fine inputs lose most of their edges here, the shortest first, at the price of a few sweeps.
    for (i, fraction) in [0.125, 0.25, 0.5].into_iter().enumerate() {
        ctx.advance(0.1 * i as f64);
        work.collapse_short_edges(0.8 * fraction * options.target_edge)?;
    }
    for sweep in 0..options.sweeps {
        ctx.advance(0.3 + 0.7 * sweep as f64 / options.sweeps as f64);
        work.split_long_edges()?;
        work.collapse_short_edges(0.8 * options.target_edge)?;
        work.flip_edges()?;
        work.relax()?;
    }
    work.flip_edges()?;
    if options.room_at_features {
        let mut parent = vec![0; work.mesh.faces.len()];
        make_room(ctx, &mut work.mesh, &mut parent)?;
    }
    Ok(work.mesh.finish().expect("every operation was asked for and keeps a manifold"))
}

/// The state of one remeshing.
pub(super) struct Remesher<'a> {
    pub(super) ctx: &'a RunContext,
    pub(super) mesh: EditMesh,
    pub(super) original: &'a SurfaceIndex,
    pub(super) options: IsotropicOptions,
    size: Option<LocalSize<'a>>,
    /// Per vertex the size at the place where it came to be; empty where all sizes are 1.
    sizes: Vec<f64>,
    /// Normal of the original surface at each vertex; zero on curves and at corners, where there is not one.
    pub(super) normals: Vec<DVec3>,
}

impl<'a> Remesher<'a> {
    fn new(
        ctx: &'a RunContext,
        surface: &Surface,
        original: &'a SurfaceIndex,
        options: IsotropicOptions,
        size: Option<LocalSize<'a>>,
    ) -> Self {
        let mesh = EditMesh::new(surface);
        let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
        for f in 0..mesh.faces.len() {
            for v in mesh.faces[f] {
                normals[v as usize] += mesh.area_vector(f);
            }
        }
        for (v, normal) in normals.iter_mut().enumerate() {
            let has_none = mesh.fixed[v] || mesh.on_curve[v];
            *normal = if has_none { DVec3::ZERO } else { normal.normalize_or_zero() };
        }
        let mut work = Self { ctx, mesh, original, options, size, sizes: Vec::new(), normals };
        work.size_new_vertices();
        work
    }

    /// Sizes of the vertices that have none yet.
    fn size_new_vertices(&mut self) {
        let Some(size) = self.size else { return };
        let new = &self.mesh.positions[self.sizes.len()..];
        self.sizes.par_extend(new.par_iter().map(|&p| size(p)));
    }

    /// Size at a vertex relative to what the options say.
    pub(super) fn size_of(&self, v: u32) -> f64 {
        self.sizes.get(v as usize).copied().unwrap_or(1.0)
    }

    /// Size at a point relative to what the options say.
    fn size_at(&self, p: DVec3) -> f64 {
        self.size.map_or(1.0, |size| size(p))
    }

    /// How far triangles may stray at a point.
    pub(super) fn tolerance_at(&self, p: DVec3) -> f64 {
        self.options.tolerance * self.size_at(p)
    }

    fn split_long_edges(&mut self) -> Result<(), Cancelled> {
        let first_new = self.mesh.positions.len();
        let longest = 4.0 / 3.0 * self.options.target_edge;
        let mut parent: Vec<u32> = (0..self.mesh.faces.len() as u32).collect();
        let size = |f: usize| self.mesh.faces[f].map(|v| self.size_of(v)).into_iter().fold(f64::INFINITY, f64::min);
        let local: Vec<f64> = match self.size {
            Some(_) => (0..parent.len()).map(|f| if self.mesh.is_alive(f) { size(f) } else { 1.0 }).collect(),
            None => vec![1.0; parent.len()],
        };
        bisect(self.ctx, &mut self.mesh, &mut parent, |f| longest * local[f as usize], self.options.max_faces)?;
        self.normals.resize(self.mesh.positions.len(), DVec3::ZERO);
        self.size_new_vertices();
        let mut fan = Vec::new();
        for v in first_new as u32..self.mesh.positions.len() as u32 {
            if !self.mesh.on_curve[v as usize] {
                self.mesh.fan(v, &mut fan);
                let normal = self.fan_normal(&fan);
                let found = self.project(self.mesh.position(v), normal);
                self.normals[v as usize] = found.map_or(normal, |found| self.original.smooth_normal(&found));
            }
        }
        Ok(())
    }

    /// Whether an edge between `t0` and `t1` can stand for its curve.
    pub(super) fn follows_curve(&self, s: u32, t0: f64, t1: f64) -> bool {
        let curves = &self.mesh.curves;
        let tolerance = self.tolerance_at(curves.point(s, 0.5 * (t0 + t1)));
        if !self.options.halved_curves {
            return curves.chord_is_close(s, t0, t1, tolerance);
        }
        let middle = 0.5 * (t0 + t1);
        curves.chord_is_close(s, t0, middle, tolerance) && curves.chord_is_close(s, middle, t1, tolerance)
    }

    pub(super) fn fan_normal(&self, fan: &[usize]) -> DVec3 {
        fan.iter().map(|&h| self.mesh.area_vector(h / 3)).sum::<DVec3>().normalize_or_zero()
    }

    /// The nearest point of the original surface that faces the same way: never the other side of a thin sheet.
    pub(super) fn project(&self, p: DVec3, normal: DVec3) -> Option<SurfacePoint> {
        let reach = 2.0 * self.options.target_edge;
        self.original.closest_where(p, reach, |f| self.original.normal(f).dot(normal) > MIN_AGREEMENT)
    }

    /// How well the triangle of these vertices, with `moved` (if it is one of them) at `p`, is shaped and agrees with
    /// the normals at its vertices.
    pub(super) fn rate(&self, corners: [u32; 3], moved: u32, p: DVec3, normal: DVec3) -> Rating {
        let points = corners.map(|v| if v == moved { p } else { self.mesh.position(v) });
        let area_vector = (points[1] - points[0]).cross(points[2] - points[0]);
        let unit = area_vector.normalize_or_zero();
        let mut agreement = f64::INFINITY;
        for v in corners {
            let expected = if v == moved { normal } else { self.normals[v as usize] };
            if expected != DVec3::ZERO {
                agreement = agreement.min(unit.dot(expected));
            }
        }
        let sides = (0..3).map(|k| points[k].distance_squared(points[(k + 1) % 3])).sum::<f64>();
        let shape = if sides > 0.0 { 2.0 * 3f64.sqrt() * area_vector.length() / sides } else { 0.0 };
        Rating { points, unit, agreement, shape }
    }

    pub(super) fn rate_as_is(&self, f: usize) -> Rating {
        self.rate(self.mesh.faces[f], crate::engine::mesh::NONE, DVec3::ZERO, DVec3::ZERO)
    }

    /// Whether a new triangle is admissible: not turned against the surface, not far from it, no sliver, where it takes
    /// the place of triangles of which the worst were `before`.
    pub(super) fn is_admissible(&self, new: &Rating, before: &Worst) -> bool {
        if new.shape <= before.shape.min(0.15) {
            return false;
        }
        if new.agreement < CLEAR_AGREEMENT || new.agreement == f64::INFINITY {
            let least = if self.options.strict { MIN_AGREEMENT } else { MIN_AGREEMENT.min(before.agreement) };
            if new.agreement < least {
                return false;
            }
            let centre = (new.points[0] + new.points[1] + new.points[2]) / 3.0;
            // However bad it was: the surface must face the same way near by.
            let least = least.max(0.1);
            let near = self
                .original
                .closest_where(centre, self.tolerance_at(centre), |f| self.original.normal(f).dot(new.unit) > least);
            return near.is_some();
        }
        true
    }
}

/// A triangle that may come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rating {
    pub(super) points: [DVec3; 3],
    pub(super) unit: DVec3,
    /// Least cosine to the surface's normals at the vertices that have one; infinite if none has.
    pub(super) agreement: f64,
    /// 1 for equilateral, 0 for no area.
    pub(super) shape: f64,
}

/// The worst of the triangles that go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Worst {
    pub(super) agreement: f64,
    pub(super) shape: f64,
}

impl Worst {
    pub(super) fn of(ratings: impl Iterator<Item = Rating>) -> Self {
        ratings.fold(Self { agreement: 1.0, shape: 1.0 }, |worst, rating| Self {
            agreement: worst.agreement.min(rating.agreement),
            shape: worst.shape.min(rating.shape),
        })
    }
}
