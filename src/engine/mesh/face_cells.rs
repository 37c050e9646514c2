//! Faces joined to connected cells of about one size, so that what is asked of a neighbourhood costs the same however fine the
//! triangles are.

use glam::DVec3;

use crate::engine::mesh::{NONE, TriMesh};

/// Faces that turn by more than 120 degrees (cosine) are the two sides of a sheet that is thinner than a cell.
const SHARP: f64 = -0.5;

/// A partition of the faces of a mesh, and which of its cells are neighbours.
#[derive(Clone, Debug)]
pub struct FaceCells {
    of_face: Vec<u32>,
    /// Faces by cell, and per cell where its faces start.
    faces: Vec<u32>,
    first_face: Vec<u32>,
    neighbours: Vec<u32>,
    first_neighbour: Vec<u32>,
}

impl FaceCells {
    /// Joins faces whose centroids lie within `radius` (model units) of the one that starts the cell; neither cells nor
    /// neighbourhoods go across a `barrier` (per halfedge). O(F log F).
    pub fn new(mesh: &TriMesh, barrier: &[bool], radius: f64) -> Self {
        let n = mesh.n_faces();
        let middle = |f: usize| mesh.triangle(f).iter().sum::<DVec3>() / 3.0;
        let mut of_face = vec![NONE; n];
        let (mut faces, mut first_face) = (Vec::with_capacity(n), vec![0]);
        for seed in 0..n {
            if of_face[seed] != NONE {
                continue;
            }
            let (cell, at, normal) = (first_face.len() as u32 - 1, middle(seed), mesh.normal(seed));
            of_face[seed] = cell;
            let mut next = faces.len();
            faces.push(seed as u32);
            while let Some(&f) = faces.get(next) {
                next += 1;
                let f = 3 * f as usize;
                for g in (f..f + 3).filter(|&h| !barrier[h]).filter_map(|h| mesh.twin(h)).map(|t| t / 3) {
                    let is_near = || middle(g).distance(at) <= radius && mesh.normal(g).dot(normal) >= SHARP;
                    if of_face[g] == NONE && is_near() {
                        of_face[g] = cell;
                        faces.push(g as u32);
                    }
                }
            }
            first_face.push(faces.len() as u32);
        }
        let across = (0..mesh.n_halfedges()).filter(|&h| !barrier[h]);
        let mut links: Vec<(u32, u32)> = across
            .filter_map(|h| Some((of_face[h / 3], of_face[mesh.twin(h)? / 3])))
            .filter(|&(a, b)| a != b)
            .collect();
        links.sort_unstable();
        links.dedup();
        let cells = first_face.len() as u32 - 1;
        let first_neighbour = (0..=cells).map(|cell| links.partition_point(|l| l.0 < cell) as u32).collect();
        let neighbours = links.into_iter().map(|l| l.1).collect();
        Self { of_face, faces, first_face, neighbours, first_neighbour }
    }

    /// The number of cells.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.first_face.len() - 1
    }

    /// The cell of a face.
    pub fn of(&self, face: u32) -> u32 {
        self.of_face[face as usize]
    }

    /// The faces of a cell.
    pub fn faces(&self, cell: u32) -> &[u32] {
        &self.faces[self.first_face[cell as usize] as usize..self.first_face[cell as usize + 1] as usize]
    }

    /// The cells that share an edge with a cell, in order.
    pub fn neighbours(&self, cell: u32) -> &[u32] {
        let (from, to) = (self.first_neighbour[cell as usize], self.first_neighbour[cell as usize + 1]);
        &self.neighbours[from as usize..to as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn cells_are_a_connected_partition_and_stop_at_barriers() {
        let surface = sample_surface("cube", 4000).unwrap();
        let (mesh, barrier) = (&surface.mesh, surface.features.halfedge_flags(&surface.mesh));
        let cells = FaceCells::new(mesh, &barrier, 0.1);
        assert!((50..1000).contains(&cells.len()));
        let mut seen = vec![0; mesh.n_faces()];
        for cell in 0..cells.len() as u32 {
            for &f in cells.faces(cell) {
                seen[f as usize] += 1;
                assert_eq!(cells.of(f), cell);
                // A cube's faces differ in their normals: no cell has two of them.
                assert!(mesh.normal(f as usize).dot(mesh.normal(cells.faces(cell)[0] as usize)) > 0.99);
            }
            for &other in cells.neighbours(cell) {
                assert!(cells.neighbours(other).contains(&cell), "neighbours are mutual");
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        // Cells smaller than the faces are the faces.
        assert_eq!(FaceCells::new(mesh, &barrier, 0.0).len(), mesh.n_faces());
    }
}
