//! What no seamless map can follow of a cross field: the energy `E_D` of its curl on the branched covering.
//!
//! The residual `X − ∇z` of the best seamless map z is the cogradient of a nonconforming function ψ with one value per
//! edge: `L ψ = c`, with c the curl of the field over each edge and L the Crouzeix–Raviart stiffness `e_i · e_j / A` on
//! the covering (`[kaelberer_2013]` eq. 6.1). Where grid lines are bound to features or to the boundary the energy is
//! that of the seamless map that is bound to them as well ([`System`]).

use std::f64::consts::FRAC_PI_2;

use faer::c64;
use rayon::prelude::*;

use crate::engine::field::branch::curl_system::{Factor, System};
use crate::engine::field::branch::sides::{Sides, slot};
use crate::engine::field::cross_field::{CrossField, FieldError, unit};
use crate::engine::field::frames::Frames;
use crate::engine::field::turning::Turning;
use crate::engine::mesh::TriMesh;

/// What no matching changes.
#[derive(Clone, Debug)]
pub(super) struct Curl {
    pub(super) sides: Sides,
    /// Length per halfedge.
    length: Vec<f64>,
    /// `‖X‖²`: twice the area.
    norm: f64,
    system: System,
}

/// The energy of one field and the function that carries it.
#[derive(Clone, Debug)]
pub(super) struct CurlEnergy {
    /// `‖X − ∇z‖² / ‖X‖²`, between 0 and 1.
    pub(super) value: f64,
    /// ψ per halfedge, in the chart of its face.
    psi: Vec<c64>,
    /// The field along each halfedge, in the chart of its face.
    along: Vec<c64>,
    pub(super) factor: Factor,
}

/// `i^quarters`.
fn power(quarters: u8) -> c64 {
    match quarters & 3 {
        0 => c64::new(1.0, 0.0),
        1 => c64::new(0.0, 1.0),
        2 => c64::new(-1.0, 0.0),
        _ => c64::new(0.0, -1.0),
    }
}

impl Curl {
    /// `is_bound`: per halfedge, whether a grid line is bound to its edge.
    pub(super) fn new(mesh: &TriMesh, frames: &Frames, is_bound: &[bool]) -> Self {
        let length = (0..mesh.n_halfedges()).map(|h| frames.length(mesh, h)).collect();
        let norm = 2.0 * frames.total_area(mesh);
        let sides = Sides::new(mesh, frames, 1e-9 * norm / mesh.n_faces().max(1) as f64);
        let system = System::new(mesh, &sides, is_bound);
        Self { sides, length, norm, system }
    }

    /// The interior edge of a halfedge.
    pub(super) fn edge_of(&self, h: usize) -> usize {
        self.sides.edge[h] as usize
    }

    /// `i^m` across the owner of every interior edge.
    pub(super) fn turns(&self, field: &CrossField) -> Vec<c64> {
        self.sides.owner.iter().map(|&h| power(field.matching.across(h))).collect()
    }

    /// Solves for the energy. `last` lends its pattern.
    ///
    /// # Errors
    /// [`FieldError`] if the system is not positive definite.
    pub(super) fn energy(
        &self,
        mesh: &TriMesh,
        frames: &Frames,
        field: &CrossField,
        last: Option<&Factor>,
    ) -> Result<CurlEnergy, FieldError> {
        self.energy_with(mesh, frames, field, &self.turns(field), last)
    }

    /// The same with other turns across the edges, which may be any numbers of absolute value 1.
    pub(super) fn energy_with(
        &self,
        mesh: &TriMesh,
        frames: &Frames,
        field: &CrossField,
        turns: &[c64],
        last: Option<&Factor>,
    ) -> Result<CurlEnergy, FieldError> {
        let along: Vec<c64> = (0..mesh.n_halfedges())
            .into_par_iter()
            .map(|h| unit(frames.angle[h] - field.angle[h / 3]) * self.length[h])
            .collect();
        let (psi, factor) = self.system.solve(mesh, &self.sides, turns, &along, last)?;
        let value = psi.iter().zip(&along).map(|(p, a)| (p.conj() * *a).re).sum::<f64>() / self.norm;
        Ok(CurlEnergy { value, psi, along, factor })
    }

    /// The derivative of the energy with respect to the matching of every interior edge, per quarter turn across its
    /// owner, matchings taken as real numbers and the crosses following by `turning`; 0 where a grid line is bound to
    /// the edge. One real solve.
    pub(super) fn derivative(&self, mesh: &TriMesh, energy: &CurlEnergy, turning: &Turning) -> Vec<f64> {
        let CurlEnergy { psi, along, .. } = energy;
        let i = power(1);
        // Per halfedge: what a turn of the cross of its face changes.
        let by_cross = |h: usize| 2.0 * (psi[h].conj() * (i * -1.0) * along[h]).re;
        let by_angle: Vec<f64> =
            (0..mesh.n_faces()).into_par_iter().map(|f| (3 * f..3 * f + 3).map(by_cross).sum()).collect();
        let adjoint = turning.solve(&by_angle);
        let total = |e: usize| {
            let h = self.sides.owner[e];
            let Some(t) = mesh.twin(h).filter(|_| !self.system.is_bound(h)) else { return 0.0 };
            // ψ on the side of t turns with the matching, and with it what L gives there.
            let (f, k) = (t / 3, t % 3);
            let product =
                (0..3).fold(c64::new(0.0, 0.0), |sum, j| sum + psi[3 * f + j] * self.sides.stiffness[f][slot(k, j)]);
            let change = i * psi[t] * -FRAC_PI_2;
            let explicit = by_cross(t) * -FRAC_PI_2 - 2.0 * (change.conj() * product).re;
            let followed = turning.weight(h) * FRAC_PI_2 * (adjoint[t / 3] - adjoint[h / 3]);
            (explicit + followed) / self.norm
        };
        (0..self.sides.owner.len()).into_par_iter().map(total).collect()
    }
}

/// Curl energy of a field relative to `‖X‖²`: the least `‖X − ∇z‖²` over all seamless maps z with its matching, of which
/// one coordinate is constant along every edge that `is_bound` (per halfedge).
///
/// # Errors
/// [`FieldError`] if the solve failed.
pub fn curl_energy(mesh: &TriMesh, frames: &Frames, field: &CrossField, is_bound: &[bool]) -> Result<f64, FieldError> {
    Ok(Curl::new(mesh, frames, is_bound).energy(mesh, frames, field, None)?.value)
}
