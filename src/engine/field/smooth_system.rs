//! The linear system of the smoothest crosses.

use crate::engine::field::cross_field::{FieldError, unit};
use crate::engine::field::frames::Frames;
use crate::engine::field::turning::edge_weight;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::{Cholesky, HermitianMatrix};
use faer::c64;

/// The connection Laplacian on faces with fixed faces eliminated.
pub(super) struct System {
    /// Unknown of each face, if it is not fixed.
    pub(super) unknown: Vec<Option<u32>>,
    pub(super) n: usize,
    /// Strictly lower entries between unknowns.
    pub(super) off_diagonal: Vec<(u32, u32, c64)>,
    /// Sum of the edge weights per face.
    pub(super) diagonal: Vec<f64>,
    /// Right-hand side from fixed faces, per unknown.
    pub(super) from_fixed: Vec<c64>,
    pub(super) fixed: Vec<Option<c64>>,
    /// The last factor, for its pattern.
    factor: Option<Cholesky<c64>>,
}

impl System {
    pub(super) fn new(mesh: &TriMesh, frames: &Frames, fixed: &[Option<c64>]) -> Self {
        let mut n = 0;
        let unknown: Vec<Option<u32>> = fixed
            .iter()
            .map(|f| {
                f.is_none().then(|| {
                    n += 1;
                    n - 1
                })
            })
            .collect();
        let mut diagonal = vec![0.0; mesh.n_faces()];
        let mut from_fixed = vec![c64::new(0.0, 0.0); n as usize];
        let mut off_diagonal = Vec::new();
        for h in 0..mesh.n_halfedges() {
            let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) else { continue };
            let (s, t) = (h / 3, t / 3);
            let w = edge_weight(mesh, frames, h, 3 * t);
            diagonal[s] += w;
            diagonal[t] += w;
            // |c_s g − c_t|² with g = e^{4iρ}
            let g = unit(4.0 * frames.transport(mesh, h));
            match (unknown[s], unknown[t]) {
                (Some(a), Some(b)) if a > b => off_diagonal.push((a, b, g.conj() * -w)),
                (Some(a), Some(b)) => off_diagonal.push((b, a, g * -w)),
                (Some(a), None) => from_fixed[a as usize] += fixed[t].unwrap_or(unit(0.0)) * g.conj() * w,
                (None, Some(b)) => from_fixed[b as usize] += fixed[s].unwrap_or(unit(0.0)) * g * w,
                (None, None) => {}
            }
        }
        Self { unknown, n: n as usize, off_diagonal, diagonal, from_fixed, fixed: fixed.to_vec(), factor: None }
    }

    pub(super) fn factor(&mut self, shift: &[f64]) -> Result<&Cholesky<c64>, FieldError> {
        let mut entries = self.off_diagonal.clone();
        for (f, unknown) in self.unknown.iter().enumerate() {
            if let Some(u) = *unknown {
                entries.push((u, u, c64::new(self.diagonal[f] + shift[f], 0.0)));
            }
        }
        let matrix = HermitianMatrix::from_lower(self.n, &entries);
        let factor = match &self.factor {
            Some(last) => last.refactor(&matrix)?,
            None => Cholesky::new(&matrix)?,
        };
        Ok(self.factor.insert(factor))
    }

    /// Solves (A + shift) c = rhs + contributions of the fixed faces; fixed faces keep their cross.
    pub(super) fn solve(&mut self, shift: &[f64], rhs: &[c64]) -> Result<Vec<c64>, FieldError> {
        let mut x = self.from_fixed.clone();
        for (f, unknown) in self.unknown.iter().enumerate() {
            if let Some(u) = *unknown {
                x[u as usize] += rhs[f];
            }
        }
        if self.n > 0 {
            self.factor(shift)?.solve(&mut x);
        }
        Ok(self.spread(&x))
    }

    pub(super) fn spread(&self, x: &[c64]) -> Vec<c64> {
        self.unknown
            .iter()
            .zip(&self.fixed)
            .map(|(unknown, fixed)| match (unknown, fixed) {
                (Some(u), _) => x[*u as usize],
                (None, Some(c)) => *c,
                (None, None) => c64::new(1.0, 0.0),
            })
            .collect()
    }
}
