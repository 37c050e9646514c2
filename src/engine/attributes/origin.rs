//! A conditioned surface that still knows what it comes from.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::{FaceTree, SurfaceIndex, SurfacePoint, TriMesh, TriangleSoup};

/// Where attributes come from: a soup and the surface that was made of it.
#[derive(Debug)]
pub struct Origin<'a> {
    /// What the file says.
    pub(super) soup: &'a TriangleSoup,
    /// The conditioned surface.
    pub(super) mesh: &'a TriMesh,
    /// Per face of the surface, the polygon of the soup that it comes from.
    pub(super) polygon: &'a [u32],
    /// Normals of the surface.
    index: &'a SurfaceIndex,
    /// Per component of the surface, its faces.
    components: Vec<FaceTree>,
}

impl<'a> Origin<'a> {
    /// `polygon` as in [`Conditioned`](crate::engine::mesh::Conditioned), `index` of `mesh`.
    pub fn new(soup: &'a TriangleSoup, mesh: &'a TriMesh, polygon: &'a [u32], index: &'a SurfaceIndex) -> Self {
        let (component, n) = mesh.components();
        let mut faces: Vec<Vec<u32>> = vec![Vec::new(); n];
        for (f, &c) in (0..).zip(&component) {
            faces[c as usize].push(f);
        }
        let components = faces.par_iter().map(|faces| FaceTree::new(mesh, faces)).collect();
        Self { soup, mesh, polygon, index, components }
    }

    /// The point of a component nearest to `p`. Of the two sides of a thin wall the one that faces along `normal` is
    /// meant, even if the other is nearer by less than `reach`.
    pub(super) fn facing(&self, p: DVec3, component: u32, normal: DVec3, reach: f64) -> Option<SurfacePoint> {
        let own = self.components.get(component as usize)?;
        let nearest = own.closest_where(p, f64::INFINITY, |_| true)?;
        if self.faces_along(nearest.face, normal) {
            return Some(nearest);
        }
        let facing = |f: u32| self.faces_along(f, normal);
        Some(own.closest_where(p, nearest.distance + reach, facing).unwrap_or(nearest))
    }

    pub(super) fn faces_along(&self, face: u32, normal: DVec3) -> bool {
        self.index.normal(face).dot(normal) > 0.0
    }
}
