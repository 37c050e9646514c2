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
    /// Per vertex its row, if it is not held.
    row: Vec<Option<u32>>,
    factor: Cholesky<f64>,
}

impl Laplacian {
    /// Factors the matrix. Branch points are held whatever `is_held` says; if then none is and constants are harmonic, the
    /// first vertex is held. O(F^1.5).
    ///
    /// # Errors
    /// [`CalculusError::Solve`] if triangles are so thin that the matrix is not positive definite in floating point.
    pub fn new(mesh: &TriMesh, stars: &Stars, signs: &Signs, is_held: &[bool]) -> Result<Self, CalculusError> {
        let corner = signs.corners(mesh);
        let mut held: Vec<bool> =
            (0..mesh.n_vertices()).map(|v| is_held[v] || signs.is_branch(mesh, v as u32)).collect();
        if !held.contains(&true) && !held.is_empty() && signs.trivialisation(mesh).is_some() {
            held[0] = true;
        }
        let mut n = 0;
        let row: Vec<Option<u32>> = held
            .iter()
            .map(|&held| {
                (!held).then(|| {
                    n += 1;
                    n - 1
                })
            })
            .collect();
        // Rows rise with vertices, so that the lower triangle stays the lower one.
        let free = |&(r, c, w): &(u32, u32, f64)| Some((row[r as usize]?, row[c as usize]?, w));
        let entries: Vec<_> = stars.laplacian(mesh, &corner).iter().filter_map(free).collect();
        let factor = Cholesky::new(&HermitianMatrix::from_lower(n as usize, &entries))?;
        Ok(Self { corner, row, factor })
    }

    /// Signs of the corners.
    pub fn corners(&self) -> &[f64] {
        &self.corner
    }

    /// The function with `L x = right` at all vertices that are not held, and zero at those.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = (0..right.len()).filter(|&v| self.row[v].is_some()).map(|v| right[v]).collect();
        self.factor.solve(&mut x);
        self.row.iter().map(|row| row.map_or(0.0, |i| x[i as usize])).collect()
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
