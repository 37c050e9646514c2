//! The crosses as a function of the matching: the minimum of `Σ w r² + Σ a (θ − θ₀)²` over the crosses that are not
//! fixed (`[kaelberer_2013]` eq. 5.3–5.4). One real factorisation serves every matching, since a
//! quarter turn changes only the right-hand side.

use std::f64::consts::FRAC_PI_2;

use rayon::prelude::*;

use crate::engine::field::cross_field::{CrossField, FieldError, residual};
use crate::engine::field::frames::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::Cholesky;
use crate::engine::numerics::HermitianMatrix;

/// Keeps the system positive definite where nothing pins the crosses.
const PIN: f64 = 1e-9;

/// The factored system.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    unknown: Vec<Option<u32>>,
    /// Per halfedge that owns an interior edge.
    weight: Vec<f64>,
    alignment: Vec<f64>,
    factor: Option<Cholesky<f64>>,
}

impl Turning {
    /// Factors the system for the crosses that are not fixed. `alignment` is its weight per face.
    pub(super) fn new(
        mesh: &TriMesh,
        frames: &Frames,
        is_fixed: &[bool],
        alignment: &[f64],
    ) -> Result<Self, FieldError> {
        let mut n = 0u32;
        let unknown: Vec<Option<u32>> = is_fixed
            .iter()
            .map(|fixed| {
                (!fixed).then(|| {
                    n += 1;
                    n - 1
                })
            })
            .collect();
        let mut entries: Vec<(u32, u32, f64)> = Vec::new();
        let mut weight = vec![0.0; mesh.n_halfedges()];
        for h in 0..mesh.n_halfedges() {
            let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) else { continue };
            let w = edge_weight(mesh, frames, h, t);
            weight[h] = w;
            let (s, t) = (unknown[h / 3], unknown[t / 3]);
            entries.extend(s.map(|s| (s, s, w)));
            entries.extend(t.map(|t| (t, t, w)));
            if let (Some(s), Some(t)) = (s, t) {
                entries.push((s.max(t), s.min(t), -w));
            }
        }
        for (f, u) in unknown.iter().enumerate() {
            entries.extend(u.map(|u| (u, u, alignment[f] + PIN)));
        }
        let factor =
            if n > 0 { Some(Cholesky::new(&HermitianMatrix::from_lower(n as usize, &entries))?) } else { None };
        Ok(Self { unknown, weight, alignment: alignment.to_vec(), factor })
    }

    /// Weight of the edge of an owner halfedge.
    pub(super) fn weight(&self, h: usize) -> f64 {
        self.weight[h]
    }

    /// Turns the crosses to the minimum for the field's matching; `rest` are the angles that the alignment asks for, modulo
    /// quarter turns. Residuals are taken on the branch nearest to zero: one quarter off at most.
    pub(super) fn relax(&self, mesh: &TriMesh, frames: &Frames, field: &mut CrossField, rest: &[f64]) {
        // Residuals of the two sides of an edge are opposite: each face takes its own.
        let down: Vec<f64> = (0..self.unknown.len())
            .into_par_iter()
            .map(|f| {
                let off = field.angle[f] - rest[f];
                let aligned = self.alignment[f] * (off - FRAC_PI_2 * (off / FRAC_PI_2).round());
                let turned = |h: usize| {
                    let (sign, owner) = match mesh.twin(h) {
                        None => return 0.0,
                        Some(_) if mesh.is_edge_owner(h) => (1.0, h),
                        Some(t) => (-1.0, t),
                    };
                    sign * self.weight[owner] * residual(mesh, frames, &field.angle, &field.matching, owner)
                };
                -(3 * f..3 * f + 3).map(turned).sum::<f64>() - aligned
            })
            .collect();
        for (angle, step) in field.angle.iter_mut().zip(self.solve(&down)) {
            *angle += step;
        }
        field.update_indices(mesh, frames);
    }

    /// Solves with a right-hand side per face; 0 at fixed faces.
    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = self.unknown.iter().zip(rhs).filter_map(|(u, r)| u.map(|_| *r)).collect();
        if let Some(factor) = &self.factor {
            factor.solve(&mut x);
        }
        self.unknown.iter().map(|u| u.map_or(0.0, |u| x[u as usize])).collect()
    }
}

/// Weight of the turn over the edge between the faces of `h` and `t`. Long thin faces would get weights of any size; a
/// bound keeps the matrix well conditioned.
pub(super) fn edge_weight(mesh: &TriMesh, frames: &Frames, h: usize, t: usize) -> f64 {
    let length = frames.length(mesh, h);
    let area = frames.area(mesh, h / 3) + frames.area(mesh, t / 3);
    if area > 0.0 { (3.0 * length * length / area).min(1e4) } else { 1e4 }
}
