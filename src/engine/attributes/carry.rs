//! Sampling the attributes of a surface at the quads that were made for it.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::attributes::charts::Charts;
use crate::engine::attributes::corner_values::blend;
use crate::engine::attributes::origin::Origin;
use crate::engine::attributes::quad_attributes::{Preserve, QuadAttributes};
use crate::engine::mesh::{NONE, SurfacePoint};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};

/// Quads between two looks at the context.
const STRIDE: usize = 64;

/// Brings the attributes that are wanted and that the soup has to quads; `component` is that of the surface per quad.
/// Quads take the material at their centre, vertices the colour and corners the texture coordinates at the nearest
/// point of the surface. O((F + Q) log F).
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
    if materials || uv {
        let work = Work { ctx, origin, quads, component };
        let centres = work.of_quads(|q| Ok(work.under_centre(q)))?;
        if materials {
            let of_quad = |at: &Option<SurfacePoint>| {
                at.as_ref().map_or(0, |at| soup.materials[origin.polygon[at.face as usize] as usize])
            };
            (carried.materials, carried.material_names) =
                only_used(centres.iter().map(of_quad).collect(), &soup.material_names);
        }
        if uv {
            let charts = Charts { origin, uv: origin.corner_values(ctx, |corner| soup.uv[corner])? };
            carried.uv = work.of_quads(|q| {
                let start = centres[q].as_ref();
                Ok(start.map_or([[0.0; 2]; 4], |at| charts.at_corners(work.corners(q), at, work.normal(q))))
            })?;
        }
    }
    if wanted.vertex_colours && !soup.colours.is_empty() {
        carried.colours = colours(ctx, origin, quads, component)?;
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
}

/// The colour of each vertex; of vertices without quads none (white).
fn colours(
    ctx: &RunContext,
    origin: &Origin<'_>,
    quads: &QuadMesh,
    component: &[u32],
) -> Result<Vec<[f32; 4]>, Cancelled> {
    let soup = origin.soup;
    let of_faces = origin.corner_values(ctx, |corner| soup.colours[soup.indices[corner] as usize])?;
    let work = Work { ctx, origin, quads, component };
    let n = quads.positions.len();
    let (mut normals, mut home, mut reach) = (vec![DVec3::ZERO; n], vec![NONE; n], vec![0.0_f64; n]);
    for (q, quad) in quads.quads.iter().enumerate() {
        let (corners, normal) = (work.corners(q), work.normal(q));
        let size = (corners[2] - corners[0]).length().max((corners[3] - corners[1]).length());
        for &v in quad {
            normals[v as usize] += normal;
            home[v as usize] = component[q];
            reach[v as usize] = reach[v as usize].max(size);
        }
    }
    let colour = |v: usize| {
        if v.is_multiple_of(STRIDE) {
            ctx.check()?;
        }
        let at = origin.facing(quads.positions[v], home[v], normals[v], reach[v]);
        Ok(at.map_or([1.0; 4], |at| blend(at.barycentric, of_faces[at.face as usize]).map(|c| c.clamp(0.0, 1.0))))
    };
    (0..n).into_par_iter().map(colour).collect()
}

/// Leaves out the names that no quad has; the others keep their order.
fn only_used(mut materials: Vec<u32>, names: &[String]) -> (Vec<u32>, Vec<String>) {
    let mut number = vec![NONE; names.len()];
    for &m in &materials {
        number[m as usize] = 0;
    }
    let mut kept = Vec::new();
    for (number, name) in number.iter_mut().zip(names).filter(|(number, _)| **number == 0) {
        *number = kept.len() as u32;
        kept.push(name.clone());
    }
    materials.iter_mut().for_each(|m| *m = number[*m as usize]);
    (materials, kept)
}
