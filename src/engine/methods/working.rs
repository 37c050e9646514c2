//! The triangles that a map lives on: fine enough for the density, with room between features.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::{LogSize, Surface, straightened, working_mesh};
use crate::engine::problem::{Problem, WorkingMesh};
use crate::engine::run::{Cancelled, RunContext};

/// A working surface and how its corners are numbered on the surface that it stands for.
#[derive(Clone, Debug)]
pub struct Working {
    /// The surface.
    pub surface: Surface,
    /// Per corner of the working surface (sorted), the vertex of the original surface at the same place.
    pub corner_of: BTreeMap<u32, u32>,
    /// Per vertex of the working surface the logarithm of the size of quads; empty if all are to be alike.
    pub log_size: Vec<f64>,
}

/// Longest triangle edge relative to a quad edge: six to nine triangles per quad. Singularities need triangles between
/// them, and time and memory of field and map are in proportion to the number of triangles.
const LONGEST_EDGE: f64 = 0.75;
/// Makes the working surface for the quads of a problem, with at most `max_faces` triangles unless it is the input.
///
/// # Errors
/// [`Cancelled`] only.
pub fn working_surface(ctx: &RunContext, problem: &Problem, max_faces: usize) -> Result<Working, Cancelled> {
    let Problem { surface, index, edge_length, .. } = problem;
    let max_edge = LONGEST_EDGE * edge_length;
    let size = |p: DVec3| problem.log_size_at(p);
    let working = match problem.wishes.working_mesh {
        WorkingMesh::Input => Surface::clone(surface),
        // Numbered by its shape: the quads are not to depend on the numbering of the input.
        WorkingMesh::Auto => {
            let surface = surface.in_canonical_order();
            let surface = straightened(ctx, &surface, index, *edge_length)?.unwrap_or(surface);
            let log_size: Option<LogSize<'_>> = if problem.is_even() { None } else { Some(&size) };
            working_mesh(ctx, &surface, max_edge, log_size, max_faces)?
        }
    };
    let corner_of = corner_map(&working, surface);
    let log_size = match problem.is_even() {
        true => Vec::new(),
        false => working.mesh.positions().par_iter().map(|&p| size(p)).collect(),
    };
    Ok(Working { surface: working, corner_of, log_size })
}

/// Per corner of a remeshed surface, the vertex of the original at the same place.
fn corner_map(remeshed: &Surface, original: &Surface) -> BTreeMap<u32, u32> {
    let key = |p: DVec3| p.to_array().map(f64::to_bits);
    let at: BTreeMap<[u64; 3], u32> =
        original.features.corners.iter().map(|&v| (key(original.mesh.position(v)), v)).collect();
    let corners = remeshed.features.corners.iter();
    corners.filter_map(|&v| at.get(&key(remeshed.mesh.position(v))).map(|&home| (v, home))).collect()
}
