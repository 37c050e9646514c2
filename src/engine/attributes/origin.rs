//! A conditioned surface that still knows what it comes from.

use glam::DVec3;

use crate::engine::mesh::{SurfaceIndex, SurfacePoint, TriMesh, TriangleSoup};

/// Where attributes come from: a soup and the surface that was made of it.
#[derive(Debug)]
pub struct Origin<'a> {
    /// What the file says.
    pub(super) soup: &'a TriangleSoup,
    /// The conditioned surface.
    pub(super) mesh: &'a TriMesh,
    /// Per face of the surface, the polygon of the soup that it comes from.
    pub(super) polygon: &'a [u32],
    /// Nearest points of the surface.
    pub(super) index: &'a SurfaceIndex,
    /// Component of each face.
    pub(super) component: Vec<u32>,
}

impl<'a> Origin<'a> {
    /// `polygon` as in [`Conditioned`](crate::engine::mesh::Conditioned), `index` of `mesh`.
    pub fn new(soup: &'a TriangleSoup, mesh: &'a TriMesh, polygon: &'a [u32], index: &'a SurfaceIndex) -> Self {
        Self { soup, mesh, polygon, index, component: mesh.components().0 }
    }

    /// The point of a component nearest to `p`. Of the two sides of a thin wall the one that faces along `normal` is
    /// meant, even if the other is nearer by less than `reach`.
    pub(super) fn facing(&self, p: DVec3, component: u32, normal: DVec3, reach: f64) -> Option<SurfacePoint> {
        let is_own = |f: u32| self.component.get(f as usize) == Some(&component);
        let nearest = self.index.closest_where(p, f64::INFINITY, is_own)?;
        if self.faces_along(nearest.face, normal) {
            return Some(nearest);
        }
        let facing = |f: u32| is_own(f) && self.faces_along(f, normal);
        Some(self.index.closest_where(p, nearest.distance + reach, facing).unwrap_or(nearest))
    }

    pub(super) fn faces_along(&self, face: u32, normal: DVec3) -> bool {
        self.index.normal(face).dot(normal) > 0.0
    }
}
