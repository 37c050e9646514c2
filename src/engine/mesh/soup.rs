//! What a file says: polygons over positions, nothing proved but that indices are in range.

use std::ops::Range;

use glam::DVec3;

use crate::engine::mesh::influences::Influences;

/// Polygons of any degree over a list of positions, as read from a file. Readers guarantee that every index is below
/// `positions.len()` and that `polygon_ends` is increasing and ends at `indices.len()`; positions may be anything,
/// also NaN, and polygons may be degenerate, duplicate, non-manifold or of mixed orientation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// Vertex positions in model units.
    pub positions: Vec<DVec3>,
    /// Corners of all polygons, one polygon after the other, indices into `positions`.
    pub indices: Vec<u32>,
    /// End of each polygon in `indices`.
    pub polygon_ends: Vec<u32>,
    /// Texture coordinates per corner, parallel to `indices`, v upwards, finite; or empty. They belong to corners, so that
    /// vertices may be welded.
    pub uv: Vec<[f32; 2]>,
    /// Normals per corner, parallel to `indices`, of any length, zero where the file says none; or empty.
    pub normals: Vec<[f32; 3]>,
    /// RGBA per vertex, 0 to 1, or empty.
    pub colours: Vec<[f32; 4]>,
    /// Index into `material_names` per polygon, or empty.
    pub materials: Vec<u32>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Joints and weights per vertex, or empty.
    pub skin: Vec<Influences>,
    /// Number of the object that each polygon belongs to, or empty where there are no two. What objects are called is not
    /// known here.
    pub objects: Vec<u32>,
    /// Triangles that the reader had to leave out because they name a vertex twice or the like, for the report.
    pub dropped_by_reader: usize,
}

impl TriangleSoup {
    /// A soup of triangles.
    pub fn from_triangles(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Self {
        let indices = triangles.iter().flatten().copied().collect();
        let polygon_ends = (1..=triangles.len() as u32).map(|n| 3 * n).collect();
        Self { positions, indices, polygon_ends, ..Self::default() }
    }

    /// Number of polygons.
    pub fn n_polygons(&self) -> usize {
        self.polygon_ends.len()
    }

    /// Where the corners of polygon `p` stand in `indices`.
    pub fn corners_of(&self, p: usize) -> Range<usize> {
        let start = if p == 0 { 0 } else { self.polygon_ends[p - 1] as usize };
        start..self.polygon_ends[p] as usize
    }

    /// Corners of polygon `p`.
    pub fn polygon(&self, p: usize) -> &[u32] {
        &self.indices[self.corners_of(p)]
    }

    /// All polygons in order.
    pub fn polygons(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.n_polygons()).map(|p| self.polygon(p))
    }

    /// Appends a polygon.
    pub fn push_polygon(&mut self, corners: &[u32]) {
        self.indices.extend_from_slice(corners);
        self.polygon_ends.push(self.indices.len() as u32);
    }
}
