//! Hodge stars of a triangle mesh: how cochains are measured.

use crate::engine::calculus::forms::OneForm;
use crate::engine::mesh::{TriMesh, next, prev};

/// A triangle counts as having at least this share of its longest side squared as twice its area: cotangents stay finite.
const LEAST_AREA: f64 = 1e-12;

/// The diagonal Hodge stars: of 0-forms, a third of the areas around (model units squared); of 1-forms, the cotangent weights
/// `½ (cot α + cot β)`; of 2-forms, one over the area.
#[derive(Clone, Debug)]
pub struct Stars {
    /// Per vertex.
    pub vertex: Vec<f64>,
    /// Per halfedge the share of its own triangle in the weight of its edge, half a cotangent.
    pub half: Vec<f64>,
    /// Per face.
    pub face: Vec<f64>,
}

impl Stars {
    /// The stars of the metric of the mesh. O(F).
    pub fn new(mesh: &TriMesh) -> Self {
        let mut stars =
            Self { vertex: vec![0.0; mesh.n_vertices()], half: Vec::new(), face: Vec::with_capacity(mesh.n_faces()) };
        stars.half = Vec::with_capacity(mesh.n_halfedges());
        for f in 0..mesh.n_faces() {
            let corner = mesh.triangle(f);
            let longest = (0..3).map(|k| corner[k].distance_squared(corner[(k + 1) % 3])).fold(0.0, f64::max);
            let twice = mesh.area_vector(f).length().max(LEAST_AREA * longest).max(f64::MIN_POSITIVE);
            for k in 0..3 {
                let [a, b, c] = [corner[k], corner[(k + 1) % 3], corner[(k + 2) % 3]];
                stars.half.push(0.5 * (a - c).dot(b - c) / twice);
                stars.vertex[mesh.face(f)[k] as usize] += twice / 6.0;
            }
            stars.face.push(2.0 / twice);
        }
        stars
    }

    /// The star of a 1-form: per halfedge its integral across the dual edge, which is crossed from left to right.
    pub fn of_one_form(&self, mesh: &TriMesh, form: &OneForm) -> Vec<f64> {
        let weight = |h: usize| self.half[h] + mesh.twin(h).map_or(0.0, |t| self.half[t]);
        (0..mesh.n_halfedges()).map(|h| weight(h) * form.along[h]).collect()
    }

    /// The scalar product `∫ ⟨α, β⟩` of two closed 1-forms; their values are constant vectors on each triangle.
    pub fn product(&self, alpha: &OneForm, beta: &OneForm) -> f64 {
        let term = |h: usize| self.half[h] * alpha.along[h] * beta.along[h];
        (0..self.half.len()).map(term).sum()
    }

    /// The flow of a 1-form out of each vertex, as seen from the first corner of its fan: the integral of the star around
    /// its dual cell. `corner` are the signs of the corners. Zero where the form is co-closed; at boundary vertices, where it
    /// is and nothing flows across the boundary. O(F).
    pub fn divergence(&self, mesh: &TriMesh, corner: &[f64], form: &OneForm) -> Vec<f64> {
        let mut flow = vec![0.0; mesh.n_vertices()];
        for h in 0..mesh.n_halfedges() {
            let p = prev(h);
            flow[mesh.origin(h) as usize] += corner[h] * (self.half[h] * form.along[h] - self.half[p] * form.along[p]);
        }
        flow
    }

    /// Entries of the lower triangle of the Laplacian, to be summed: `xᵀ L x = ∫ |dx|²`. `corner` are the signs of the corners.
    pub(super) fn laplacian(&self, mesh: &TriMesh, corner: &[f64]) -> Vec<(u32, u32, f64)> {
        let mut entries = Vec::with_capacity(3 * mesh.n_halfedges());
        for h in 0..mesh.n_halfedges() {
            let (a, b, w) = (mesh.origin(h), mesh.target(h), self.half[h]);
            entries.push((a, a, w));
            entries.push((b, b, w));
            entries.push((a.max(b), a.min(b), -w * corner[h] * corner[next(h)]));
        }
        entries
    }
}
