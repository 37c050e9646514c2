//! Laplacian with signs and values that are given, factored once for all right-hand sides.

use crate::engine::calculus::error::CalculusError;
use crate::engine::calculus::forms::OneForm;
use crate::engine::calculus::signs::Signs;
use crate::engine::calculus::stars::Stars;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::{Cholesky, HermitianMatrix};

/// The cotangent Laplacian of functions that change their sign with the sheet `[pinkall_1993]`, zero at the vertices that are
/// held.
#[derive(Clone, Debug)]
pub struct Laplacian {
    corner: Vec<f64>,
    is_held: Vec<bool>,
    factor: Cholesky<f64>,
}

impl Laplacian {
    /// Factors the matrix. Branch points are held whatever `is_held` says; if then none is and constants are harmonic, the
    /// first vertex is held. O(F^1.5).
    ///
    /// # Errors
    /// [`CalculusError::Solve`] if triangles are so thin that the matrix is not positive definite in floating point.
    pub fn new(mesh: &TriMesh, stars: &Stars, signs: &Signs, is_held: &[bool]) -> Result<Self, CalculusError> {
        let (corner, is_held, matrix) = matrix(mesh, stars, signs, is_held);
        Ok(Self { corner, is_held, factor: Cholesky::new(&matrix)? })
    }

    /// As [`Laplacian::new`] on the same mesh with other signs: the order of elimination is kept.
    ///
    /// # Errors
    /// As [`Laplacian::new`].
    pub fn with_signs(
        &self,
        mesh: &TriMesh,
        stars: &Stars,
        signs: &Signs,
        is_held: &[bool],
    ) -> Result<Self, CalculusError> {
        let (corner, is_held, matrix) = matrix(mesh, stars, signs, is_held);
        Ok(Self { corner, is_held, factor: self.factor.refactor(&matrix)? })
    }

    /// Signs of the corners.
    pub fn corners(&self) -> &[f64] {
        &self.corner
    }

    /// The function with `L x = right` at all vertices that are not held, and zero at those.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = right.iter().zip(&self.is_held).map(|(r, held)| if *held { 0.0 } else { *r }).collect();
        self.factor.solve(&mut x);
        x
    }

    /// The form `ω + df` that differs from a closed form by a differential and is co-closed at all vertices that are not held.
    /// One step of refinement brings the divergence down to rounding.
    pub fn harmonic(&self, mesh: &TriMesh, stars: &Stars, closed: &OneForm) -> OneForm {
        let mut form = closed.clone();
        for _ in 0..2 {
            let f = self.solve(&stars.divergence(mesh, &self.corner, &form));
            form.add(1.0, &OneForm::differential(mesh, &self.corner, &f));
        }
        form
    }
}

/// Signs of the corners, what is held, and the matrix: held rows are those of the identity, with zeros where others have
/// entries, so that the pattern is the same whatever is held.
fn matrix(
    mesh: &TriMesh,
    stars: &Stars,
    signs: &Signs,
    is_held: &[bool],
) -> (Vec<f64>, Vec<bool>, HermitianMatrix<f64>) {
    let corner = signs.corners(mesh);
    let n = mesh.n_vertices();
    let mut held: Vec<bool> = (0..n).map(|v| is_held[v] || signs.is_branch(mesh, v as u32)).collect();
    if !held.contains(&true) && !held.is_empty() && signs.trivialisation(mesh).is_some() {
        held[0] = true;
    }
    let mut entries = stars.laplacian(mesh, &corner);
    entries.iter_mut().filter(|e| held[e.0 as usize] || held[e.1 as usize]).for_each(|e| e.2 = 0.0);
    entries.extend((0..n).filter(|&v| held[v]).map(|v| (v as u32, v as u32, 1.0)));
    (corner, held, HermitianMatrix::from_lower(n, &entries))
}
