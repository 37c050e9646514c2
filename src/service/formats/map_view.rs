//! What is written of a parameterisation, in whatever format.

use glam::DVec3;

use crate::engine::parameterize::GridMap;
use crate::engine::pipeline::Singularity;

/// A parameterisation to write.
#[derive(Clone, Copy, Debug)]
pub struct MapView<'a> {
    /// Vertices of the working mesh in model units.
    pub positions: &'a [DVec3],
    /// Its triangles.
    pub faces: &'a [[u32; 3]],
    /// The map, for the corners and halfedges of these triangles.
    pub grid: &'a GridMap,
    /// Grid units per model unit.
    pub scale: f64,
    /// The singularities.
    pub singularities: &'a [Singularity],
}
