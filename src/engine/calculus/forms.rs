//! 1-forms.

use crate::engine::calculus::chain::Step;
use crate::engine::calculus::signs::Signs;
use crate::engine::mesh::{TriMesh, next};

/// A 1-form, perhaps with signs.
#[derive(Clone, Debug, PartialEq)]
pub struct OneForm {
    /// Per halfedge the integral along it, on the sheet of its own triangle.
    pub along: Vec<f64>,
}

impl OneForm {
    /// The form that vanishes.
    pub fn zero(mesh: &TriMesh) -> Self {
        Self { along: vec![0.0; mesh.n_halfedges()] }
    }

    /// The differential of a function with a value per vertex; `corner` are the signs of its corners (all 1 without signs).
    pub fn differential(mesh: &TriMesh, corner: &[f64], function: &[f64]) -> Self {
        let at = |h: usize| corner[h] * function[mesh.origin(h) as usize];
        Self { along: (0..mesh.n_halfedges()).map(|h| at(next(h)) - at(h)).collect() }
    }

    /// Per face the sum around it; zero where the form is closed.
    pub fn curl(&self) -> Vec<f64> {
        self.along.as_chunks::<3>().0.iter().map(|[a, b, c]| a + b + c).collect()
    }

    /// Sets the value along `h` and along its twin.
    pub fn set(&mut self, mesh: &TriMesh, signs: &Signs, h: usize, value: f64) {
        self.along[h] = value;
        if let Some(t) = mesh.twin(h) {
            self.along[t] = -signs.across(h) * value;
        }
    }

    /// Adds to the value along `h` and along its twin.
    pub fn add_along(&mut self, mesh: &TriMesh, signs: &Signs, h: usize, value: f64) {
        self.set(mesh, signs, h, self.along[h] + value);
    }

    /// Adds a multiple of another form.
    pub fn add(&mut self, factor: f64, other: &Self) {
        self.along.iter_mut().zip(&other.along).for_each(|(a, b)| *a += factor * b);
    }

    /// The largest deviation of twins from each other, up to the signs.
    pub fn mismatch(&self, mesh: &TriMesh, signs: &Signs) -> f64 {
        let of = |h: usize| mesh.twin(h).map_or(0.0, |t| (self.along[t] + signs.across(h) * self.along[h]).abs());
        (0..mesh.n_halfedges()).map(of).fold(0.0, f64::max)
    }

    /// The integral along a chain of edges, for forms without signs.
    pub fn integral(&self, chain: &[Step]) -> f64 {
        chain
            .iter()
            .map(|step| if step.is_reversed { -self.along[step.halfedge] } else { self.along[step.halfedge] })
            .sum()
    }

    /// `∫ α ∧ β` over the surface for closed forms: constant vectors on each triangle.
    pub fn wedge(&self, other: &Self) -> f64 {
        let term = |f: usize| {
            let (a, b) = (&self.along[3 * f..], &other.along[3 * f..]);
            0.5 * (a[0] * b[1] - a[1] * b[0])
        };
        (0..self.along.len() / 3).map(term).sum()
    }
}
