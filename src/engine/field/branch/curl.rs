//! What no seamless map can follow of a cross field: the energy `E_D` of its curl on the branched covering.
//!
//! The residual `X − ∇z` of the best seamless map z is the cogradient of a nonconforming function ψ with one value per
//! interior edge (zero on the boundary): `L ψ = c`, with c the curl of the field over each edge and L the
//! Crouzeix–Raviart stiffness `e_i · e_j / A` on the covering, a Hermitian matrix on the surface whose entries carry
//! `i^m` (`[kaelberer_2013]` eq. 6.1). Features count as ordinary edges: the
//! energy is that of the seamless map before its grid lines are bound to them.

use std::f64::consts::FRAC_PI_2;

use faer::c64;

use crate::engine::field::cross_field::{CrossField, FieldError, unit};
use crate::engine::field::frames::Frames;
use crate::engine::field::turning::Turning;
use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::Cholesky;
use crate::engine::numerics::HermitianMatrix;

/// Shift of the diagonal relative to its mean: without boundary and branch points constants have no energy.
const PIN: f64 = 1e-10;

/// The pattern of the system, which no matching changes.
#[derive(Clone, Debug)]
pub(super) struct Curl {
    /// Interior edge per halfedge, [`NONE`] at the boundary.
    edge: Vec<u32>,
    /// The halfedge that owns each interior edge.
    pub(super) owner: Vec<usize>,
    /// `e_i · e_j / A` per face, for the slots (0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0).
    stiffness: Vec<[f64; 6]>,
    /// Length per interior edge.
    length: Vec<f64>,
    /// `‖X‖²`: twice the area.
    norm: f64,
}

/// The energy of one field and the function that carries it.
#[derive(Clone, Debug)]
pub(super) struct CurlEnergy {
    /// `‖X − ∇z‖² / ‖X‖²`, between 0 and 1.
    pub(super) value: f64,
    psi: Vec<c64>,
    pub(super) factor: Cholesky<c64>,
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

/// Slot of the stiffness of two halfedges of a face.
fn slot(i: usize, j: usize) -> usize {
    const SLOTS: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    SLOTS[i][j]
}

impl Curl {
    pub(super) fn new(mesh: &TriMesh, frames: &Frames) -> Self {
        let mut edge = vec![NONE; mesh.n_halfedges()];
        let mut owner = Vec::with_capacity(mesh.n_edges());
        for h in 0..mesh.n_halfedges() {
            if let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) {
                (edge[h], edge[t]) = (owner.len() as u32, owner.len() as u32);
                owner.push(h);
            }
        }
        let length = owner.iter().map(|&h| frames.length(mesh, h)).collect();
        let norm = 2.0 * frames.total_area(mesh);
        let least = 1e-9 * norm / mesh.n_faces().max(1) as f64;
        let stiffness = (0..mesh.n_faces())
            .map(|f| {
                let area = frames.area(mesh, f).max(least);
                frames.side_products(mesh, f).map(|product| product / area)
            })
            .collect();
        Self { edge, owner, stiffness, length, norm }
    }

    /// The interior edge of a halfedge.
    pub(super) fn edge_of(&self, h: usize) -> usize {
        self.edge[h] as usize
    }

    /// `i^m` across the owner of every interior edge.
    pub(super) fn turns(&self, field: &CrossField) -> Vec<c64> {
        self.owner.iter().map(|&h| power(field.matching.across(h))).collect()
    }

    /// Factor of the value of ψ on the side of halfedge `h`, relative to the side of the edge's owner.
    fn side(&self, mesh: &TriMesh, turns: &[c64], h: usize) -> c64 {
        if mesh.is_edge_owner(h) { power(0) } else { turns[self.edge[h] as usize].conj() }
    }

    /// The field along an edge as seen from its two faces, in their own charts.
    fn along(&self, mesh: &TriMesh, frames: &Frames, field: &CrossField, e: usize) -> (c64, c64) {
        let h = self.owner[e];
        let t = mesh.twin(h).unwrap_or(h);
        let seen = |face: usize, angle: f64| unit(angle - field.angle[face]) * self.length[e];
        (seen(h / 3, frames.angle[h]), seen(t / 3, frames.angle[h] + frames.transport(mesh, h)))
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
        last: Option<&Cholesky<c64>>,
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
        last: Option<&Cholesky<c64>>,
    ) -> Result<CurlEnergy, FieldError> {
        let n = self.owner.len();
        let mut entries: Vec<(u32, u32, c64)> = Vec::with_capacity(6 * mesh.n_faces() + n);
        for f in 0..mesh.n_faces() {
            for i in 0..3 {
                for j in 0..3 {
                    let (a, b) = (self.edge[3 * f + i], self.edge[3 * f + j]);
                    if a == NONE || b == NONE || a < b || a == b && i != j {
                        continue;
                    }
                    let (g, k) = (self.side(mesh, turns, 3 * f + i), self.side(mesh, turns, 3 * f + j));
                    entries.push((a, b, g.conj() * k * self.stiffness[f][slot(i, j)]));
                }
            }
        }
        let mean = self.stiffness.iter().map(|s| s[0] + s[1] + s[2]).sum::<f64>() / n.max(1) as f64;
        entries.extend((0..n as u32).map(|e| (e, e, c64::new(PIN * mean, 0.0))));
        let matrix = HermitianMatrix::from_lower(n, &entries);
        let factor = match last {
            Some(last) => last.refactor(&matrix)?,
            None => Cholesky::new(&matrix)?,
        };
        let curl: Vec<c64> = (0..n)
            .map(|e| {
                let (s, t) = self.along(mesh, frames, field, e);
                s - turns[e] * t
            })
            .collect();
        let mut psi = curl.clone();
        factor.solve(&mut psi);
        let value = curl.iter().zip(&psi).map(|(c, p)| (c.conj() * *p).re).sum::<f64>() / self.norm;
        Ok(CurlEnergy { value, psi, factor })
    }

    /// The derivative of the energy with respect to the matching of every interior edge, per quarter turn across its
    /// owner, matchings taken as real numbers and the crosses following by `turning`. One real
    /// solve.
    pub(super) fn derivative(
        &self,
        mesh: &TriMesh,
        frames: &Frames,
        field: &CrossField,
        energy: &CurlEnergy,
        turning: &Turning,
    ) -> Vec<f64> {
        let (i, turns) = (power(1), self.turns(field));
        let mut by_angle = vec![0.0; mesh.n_faces()];
        let mut derivative = Vec::with_capacity(self.owner.len());
        for (e, &h) in self.owner.iter().enumerate() {
            let t = mesh.twin(h).unwrap_or(h);
            let (at_s, at_t) = self.along(mesh, frames, field, e);
            let turned = turns[e] * at_t;
            let psi = energy.psi[e];
            by_angle[h / 3] += 2.0 * (psi.conj() * (i * -1.0) * at_s).re;
            by_angle[t / 3] += 2.0 * (psi.conj() * i * turned).re;
            // ψ on the side of t, and what L gives there.
            let value = |h: usize| match self.edge[h] {
                NONE => c64::new(0.0, 0.0),
                e => self.side(mesh, &turns, h) * energy.psi[e as usize],
            };
            let (f, k) = (t / 3, t % 3);
            let product =
                (0..3).fold(c64::new(0.0, 0.0), |sum, j| sum + value(3 * f + j) * self.stiffness[f][slot(k, j)]);
            let change = i * value(t) * -FRAC_PI_2;
            let explicit = 2.0 * (psi.conj() * i * turned).re * -FRAC_PI_2 - 2.0 * (change.conj() * product).re;
            derivative.push(explicit);
        }
        let adjoint = turning.solve(&by_angle);
        for (e, &h) in self.owner.iter().enumerate() {
            let t = mesh.twin(h).unwrap_or(h);
            derivative[e] += turning.weight(h) * FRAC_PI_2 * (adjoint[t / 3] - adjoint[h / 3]);
            derivative[e] /= self.norm;
        }
        derivative
    }
}

/// Curl energy of a field relative to `‖X‖²`: the least `‖X − ∇z‖²` over all seamless maps z with its matching.
///
/// # Errors
/// [`FieldError`] if the solve failed.
pub fn curl_energy(mesh: &TriMesh, frames: &Frames, field: &CrossField) -> Result<f64, FieldError> {
    Ok(Curl::new(mesh, frames).energy(mesh, frames, field, None)?.value)
}
