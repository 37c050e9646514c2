//! Connected components apart, each with its share of the quads.

use crate::engine::mesh::Features;
use crate::engine::mesh::NONE;
use crate::engine::mesh::Surface;
use crate::engine::mesh::TriMesh;

/// One connected component of a surface and its density.
#[derive(Clone, Debug)]
pub(super) struct Component {
    pub(super) surface: Surface,
    /// Length of a quad edge in model units.
    pub(super) edge_length: f64,
    /// Area over squared edge length.
    pub(super) quads: f64,
}

impl Component {
    /// The component without its interior features; `None` if it has none. Corners of the boundary stay.
    pub(super) fn without_features(&self) -> Option<Self> {
        if self.surface.features.edges.is_empty() {
            return None;
        }
        let mut bare = self.clone();
        bare.surface.features.edges.clear();
        bare.surface.features.corners.retain(|&v| self.surface.mesh.is_boundary_vertex(v));
        Some(bare)
    }
}

/// Fewest quads that a component gets: fewer cannot show its shape.
const MIN_QUADS: f64 = 24.0;

/// Splits a surface; components in order of their first faces, faces and vertices in their order.
pub(super) fn split(surface: &Surface, edge_length: f64) -> Vec<Component> {
    let (component_of, n) = surface.mesh.components();
    if n == 1 {
        return vec![with_density(surface.clone(), edge_length)];
    }
    let mut faces: Vec<Vec<[u32; 3]>> = vec![Vec::new(); n];
    let mut positions = vec![Vec::new(); n];
    let mut local = vec![NONE; surface.mesh.n_vertices()];
    let mut home = vec![NONE; surface.mesh.n_vertices()];
    for (f, &c) in component_of.iter().enumerate() {
        let face = surface.mesh.face(f).map(|v| {
            if local[v as usize] == NONE {
                local[v as usize] = positions[c as usize].len() as u32;
                home[v as usize] = c;
                positions[c as usize].push(surface.mesh.position(v));
            }
            local[v as usize]
        });
        faces[c as usize].push(face);
    }
    let mut features = vec![Features::default(); n];
    for &[a, b] in &surface.features.edges {
        let (la, lb) = (local[a as usize], local[b as usize]);
        features[home[a as usize] as usize].edges.push([la.min(lb), la.max(lb)]);
    }
    for &v in &surface.features.corners {
        features[home[v as usize] as usize].corners.push(local[v as usize]);
    }
    let parts = positions.into_iter().zip(faces).zip(features);
    parts
        .map(|((positions, faces), mut features)| {
            features.edges.sort_unstable();
            features.corners.sort_unstable();
            let mesh = TriMesh::try_new(positions, faces).expect("a component of a manifold is a manifold");
            with_density(Surface { mesh, features }, edge_length)
        })
        .collect()
}

fn with_density(surface: Surface, edge_length: f64) -> Component {
    let area = surface.mesh.total_area();
    let edge_length = edge_length.min((area / MIN_QUADS).sqrt());
    Component { surface, edge_length, quads: area / (edge_length * edge_length) }
}
