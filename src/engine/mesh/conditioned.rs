//! The surface that the quads are made for and measured against.

use crate::engine::mesh::{Features, NONE, TriMesh};
use crate::engine::run::Warning;

/// A conditioned surface. "Same topology as the input" means: as this mesh.
#[derive(Clone, Debug)]
pub struct Conditioned {
    /// Oriented 2-manifold without degenerate triangles, in model units.
    pub mesh: TriMesh,
    /// Per face, the polygon of the soup that it comes from.
    pub polygon: Vec<u32>,
    /// Per vertex, the position of the soup that it comes from.
    pub origin: Vec<u32>,
    /// What was repaired: name (`snake_case`, stable) and how often; only what happened.
    pub repairs: Vec<(&'static str, usize)>,
    /// What the repairs change about the surface.
    pub warnings: Vec<Warning>,
}

/// A conditioned surface together with its feature network.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The surface.
    pub mesh: TriMesh,
    /// Its features.
    pub features: Features,
}

/// One connected component of a surface.
#[derive(Clone, Debug)]
pub struct SurfacePart {
    /// The component.
    pub surface: Surface,
    /// Per vertex of the component, its vertex in the whole.
    pub vertices: Vec<u32>,
    /// Per halfedge of the component, its halfedge in the whole.
    pub halfedges: Vec<u32>,
}

impl Surface {
    /// The connected components, in order of their first faces (as [`TriMesh::components`] numbers them), with the
    /// features that lie on them; faces and vertices keep their order. O(n log n).
    pub fn parts(&self) -> Vec<SurfacePart> {
        let (component_of, n) = self.mesh.components();
        let mut faces: Vec<Vec<[u32; 3]>> = vec![Vec::new(); n];
        let mut vertices: Vec<Vec<u32>> = vec![Vec::new(); n];
        let mut halfedges: Vec<Vec<u32>> = vec![Vec::new(); n];
        let mut local = vec![NONE; self.mesh.n_vertices()];
        let mut home = vec![0usize; self.mesh.n_vertices()];
        for (f, &c) in component_of.iter().enumerate() {
            halfedges[c as usize].extend((3 * f..3 * f + 3).map(|h| h as u32));
            let part = &mut vertices[c as usize];
            faces[c as usize].push(self.mesh.face(f).map(|v| {
                if local[v as usize] == NONE {
                    (local[v as usize], home[v as usize]) = (part.len() as u32, c as usize);
                    part.push(v);
                }
                local[v as usize]
            }));
        }
        let mut features = vec![Features::default(); n];
        let is_vertex = |v: u32| local.get(v as usize).is_some_and(|&l| l != NONE);
        for &[a, b] in self.features.edges.iter().filter(|e| e.iter().all(|&v| is_vertex(v))) {
            let (la, lb) = (local[a as usize], local[b as usize]);
            features[home[a as usize]].edges.push([la.min(lb), la.max(lb)]);
        }
        for &v in self.features.corners.iter().filter(|&&v| is_vertex(v)) {
            features[home[v as usize]].corners.push(local[v as usize]);
        }
        let parts = vertices.into_iter().zip(halfedges).zip(faces).zip(features);
        let part = |(((vertices, halfedges), faces), mut features): (((Vec<u32>, _), Vec<[u32; 3]>), Features)| {
            features.edges.sort_unstable();
            features.corners.sort_unstable();
            let positions = vertices.iter().map(|&v| self.mesh.position(v)).collect();
            let mesh = TriMesh::try_new(positions, faces).expect("a component of a manifold is a manifold");
            SurfacePart { surface: Surface { mesh, features }, vertices, halfedges }
        };
        parts.map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn parts_together_are_the_whole() {
        let (a, b) = (sample_surface("cube", 300).unwrap(), sample_surface("half_pipe", 450).unwrap());
        let n = a.mesh.n_vertices() as u32;
        // Faces of the two in turn, so that no part is a contiguous piece of the whole.
        let mut faces: Vec<[u32; 3]> = Vec::new();
        for f in 0..a.mesh.n_faces().max(b.mesh.n_faces()) {
            faces.extend((f < a.mesh.n_faces()).then(|| a.mesh.face(f)));
            faces.extend((f < b.mesh.n_faces()).then(|| b.mesh.face(f).map(|v| v + n)));
        }
        let positions = [a.mesh.positions(), b.mesh.positions()].concat();
        let shifted = |e: &[u32; 2]| e.map(|v| v + n);
        let edges = a.features.edges.iter().copied().chain(b.features.edges.iter().map(shifted)).collect();
        let corners = a.features.corners.iter().copied().chain(b.features.corners.iter().map(|v| v + n)).collect();
        let whole =
            Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features { edges, corners } };
        let parts = whole.parts();
        assert_eq!(parts.len(), 2);
        let mut edges = Vec::new();
        let mut corners = Vec::new();
        for (part, own) in parts.iter().zip([&a, &b]) {
            assert_eq!(part.surface.mesh.topology(), own.mesh.topology());
            assert_eq!(part.surface.mesh.total_area(), own.mesh.total_area());
            for (v, &home) in (0u32..).zip(&part.vertices) {
                assert_eq!(part.surface.mesh.position(v), whole.mesh.position(home));
            }
            let name = |v: u32| part.vertices[v as usize];
            edges.extend(part.surface.features.edges.iter().map(|e| e.map(name)).map(|[a, b]| [a.min(b), a.max(b)]));
            corners.extend(part.surface.features.corners.iter().map(|&v| name(v)));
        }
        edges.sort_unstable();
        corners.sort_unstable();
        assert_eq!((edges, corners), (whole.features.edges, whole.features.corners));
    }
}
