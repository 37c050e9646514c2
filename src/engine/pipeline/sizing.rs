//! How large the quads are to be where: the wishes of a spec on one surface.

use crate::engine::field::{colour_size, curvature_sizes, graded_sizes};
use crate::engine::mesh::Surface;
use crate::engine::mesh::TriangleSoup;
use crate::engine::pipeline::make::Asked;
use crate::engine::run::{Cancelled, RunContext, Warning, WarningKind};

/// Logarithms of the size per vertex of the surface, relative to the edge length; empty if all quads are to be alike.
/// `origin` is the position of the soup that each vertex comes from. What cannot be heeded is added to the warnings.
pub(super) fn sizes(
    ctx: &RunContext,
    surface: &Surface,
    origin: &[u32],
    soup: &TriangleSoup,
    asked: &Asked<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<f64>, Cancelled> {
    let Asked { spec, edge_length, field } = *asked;
    let mesh = &surface.mesh;
    let mut wanted = vec![0.0; mesh.n_vertices()];
    if spec.adaptive_size > 0.0 {
        let share = 0.01 * spec.adaptive_size;
        let flags = surface.features.halfedge_flags(mesh);
        for (wanted, size) in wanted.iter_mut().zip(curvature_sizes(mesh, &flags, edge_length)) {
            *wanted += share * size;
        }
    }
    if let Some(field) = field {
        wanted.iter_mut().zip(field.sizes(mesh)).for_each(|(wanted, size)| *wanted += size);
    }
    if spec.density_from_vertex_colour {
        if soup.colours.is_empty() {
            warnings.push(WarningKind::NoVertexColours {}.into());
        }
        for (wanted, &position) in wanted.iter_mut().zip(origin) {
            *wanted += soup.colours.get(position as usize).map_or(0.0, |&colour| colour_size(colour));
        }
    }
    let (least, most) = wanted.iter().fold((f64::INFINITY, -f64::INFINITY), |(a, b), &w| (a.min(w), b.max(w)));
    if most - least < LEAST_SPREAD {
        return Ok(Vec::new());
    }
    graded_sizes(ctx, mesh, &wanted, edge_length)
}

/// Sizes that differ less than this (logarithms) are all the same.
const LEAST_SPREAD: f64 = 0.01;
