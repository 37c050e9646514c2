//! Sampling the attributes of a surface at the quads that were made for it.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::attributes::charts::Charts;
use crate::engine::attributes::corner_values::CornerValue;
use crate::engine::attributes::origin::Origin;
use crate::engine::attributes::quad_attributes::{Preserve, QuadAttributes};
use crate::engine::mesh::Influences;
use crate::engine::mesh::{NONE, SurfacePoint};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};

/// Quads between two looks at the context.
const STRIDE: usize = 64;

/// Brings the attributes that are wanted and that the soup has to quads; `component` is that of the surface per quad.
/// Quads take the material and the object at their centre, vertices the colour and the weights of joints and corners the
/// texture coordinates at the nearest point of the surface. O((F + Q) log F).
///
/// # Errors
/// If the run was stopped.
pub fn carry(
    ctx: &RunContext,
    origin: &Origin<'_>,
    quads: &QuadMesh,
    component: &[u32],
    wanted: Preserve,
) -> Result<QuadAttributes, Cancelled> {
    let soup = origin.soup;
    let materials = wanted.materials && soup.materials.iter().any(|&m| !soup.material_names[m as usize].is_empty());
    let uv = wanted.uv && !soup.uv.is_empty();
    let mut carried = QuadAttributes::default();
    let work = Work { ctx, origin, quads, component };
    if materials || uv || !soup.objects.is_empty() {
        let centres = work.of_quads(|q| Ok(work.under_centre(q)))?;
        let of_polygons = |values: &[u32]| {
            let of_quad =
                |at: &Option<SurfacePoint>| at.map_or(0, |at| values[origin.polygon[at.face as usize] as usize]);
            centres.iter().map(of_quad).collect::<Vec<_>>()
        };
        if materials {
            (carried.materials, carried.material_numbers) = only_used(of_polygons(&soup.materials));
            let name = |&m: &u32| soup.material_names[m as usize].clone();
            carried.material_names = carried.material_numbers.iter().map(name).collect();
        }
        if !soup.objects.is_empty() {
            carried.objects = of_polygons(&soup.objects);
        }
        if uv {
            let charts = Charts { origin, uv: origin.corner_values(ctx, |corner| soup.uv[corner])? };
            carried.uv = work.of_quads(|q| {
                let start = centres[q].as_ref();
                Ok(start.map_or([[0.0; 2]; 4], |at| charts.at_corners(work.corners(q), at, work.normal(q))))
            })?;
        }
    }
    let colours = wanted.vertex_colours && !soup.colours.is_empty();
    let skin = wanted.skin && !soup.skin.is_empty();
    if colours || skin {
        let below = work.under_vertices()?;
        if colours {
            let values = |corner: usize| soup.colours[soup.indices[corner] as usize];
            let made = at_points(&below, &origin.corner_values(ctx, values)?, [1.0; 4]);
            carried.colours = made.into_iter().map(|colour| colour.map(|c| c.clamp(0.0, 1.0))).collect();
        }
        if skin {
            let values = |corner: usize| soup.skin[soup.indices[corner] as usize];
            carried.skin = at_points(&below, &origin.corner_values(ctx, values)?, Influences::one(0));
        }
    }
    Ok(carried)
}

struct Work<'a> {
    ctx: &'a RunContext,
    origin: &'a Origin<'a>,
    quads: &'a QuadMesh,
    component: &'a [u32],
}

impl Work<'_> {
    /// A value per quad, in parallel.
    fn of_quads<T: Send>(&self, value: impl Fn(usize) -> Result<T, Cancelled> + Sync) -> Result<Vec<T>, Cancelled> {
        let checked = |q: usize| {
            if q.is_multiple_of(STRIDE) {
                self.ctx.check()?;
            }
            value(q)
        };
        (0..self.quads.quads.len()).into_par_iter().map(checked).collect()
    }

    fn corners(&self, q: usize) -> [DVec3; 4] {
        self.quads.quads[q].map(|v| self.quads.positions[v as usize])
    }

    /// Along the normal of the quad, as long as twice its area.
    fn normal(&self, q: usize) -> DVec3 {
        let [a, b, c, d] = self.corners(q);
        (c - a).cross(d - b)
    }

    fn under_centre(&self, q: usize) -> Option<SurfacePoint> {
        let corners = self.corners(q);
        let [a, b, c, d] = corners;
        let reach = (c - a).length().max((d - b).length());
        let centre = corners.iter().sum::<DVec3>() / 4.0;
        self.origin.facing(centre, self.component[q], self.normal(q), reach)
    }

    /// The point of the surface at each vertex; of vertices without quads none.
    fn under_vertices(&self) -> Result<Vec<Option<SurfacePoint>>, Cancelled> {
        let quads = self.quads;
        let n = quads.positions.len();
        let (mut normals, mut home, mut reach) = (vec![DVec3::ZERO; n], vec![NONE; n], vec![0.0_f64; n]);
        for (q, quad) in quads.quads.iter().enumerate() {
            let (corners, normal) = (self.corners(q), self.normal(q));
            let size = (corners[2] - corners[0]).length().max((corners[3] - corners[1]).length());
            for &v in quad {
                normals[v as usize] += normal;
                home[v as usize] = self.component[q];
                reach[v as usize] = reach[v as usize].max(size);
            }
        }
        let below = |v: usize| {
            if v.is_multiple_of(STRIDE) {
                self.ctx.check()?;
            }
            Ok(self.origin.facing(quads.positions[v], home[v], normals[v], reach[v]))
        };
        (0..n).into_par_iter().map(below).collect()
    }
}

/// The values of faces at points on them; `otherwise` where there is no point.
fn at_points<T: CornerValue>(points: &[Option<SurfacePoint>], of_faces: &[[T; 3]], otherwise: T) -> Vec<T> {
    let value =
        |at: &Option<SurfacePoint>| at.map_or(otherwise, |at| T::blend(at.barycentric, of_faces[at.face as usize]));
    points.par_iter().map(value).collect()
}

/// The numbers that are there, in order, and per quad the place of its number among them.
fn only_used(mut numbers: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
    let mut used = numbers.clone();
    used.sort_unstable();
    used.dedup();
    numbers.iter_mut().for_each(|m| *m = used.partition_point(|used| used < m) as u32);
    (numbers, used)
}
