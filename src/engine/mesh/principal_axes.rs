//! Where the area of a surface lies: its centre and its principal axes.

use glam::{DMat3, DVec3};

use crate::engine::mesh::TriMesh;

/// Sweeps of Jacobi's rotations: quadratic convergence needs about five for three rows.
const SWEEPS: usize = 12;

/// The centre of the area of a surface and the axes of its second moments.
#[derive(Clone, Copy, Debug)]
pub struct PrincipalAxes {
    /// The centre, model units.
    pub centre: DVec3,
    /// The axes as columns, a right-handed orthonormal system.
    pub axes: DMat3,
    /// Per axis the area times the squared coordinate along it.
    pub moments: DVec3,
}

/// The principal axes of a surface; of triangles, their centroids count.
pub fn principal_axes(mesh: &TriMesh) -> PrincipalAxes {
    let centroid = |f: usize| mesh.triangle(f).iter().sum::<DVec3>() / 3.0;
    let faces = || (0..mesh.n_faces()).map(|f| (mesh.area(f), centroid(f)));
    let area: f64 = faces().map(|(area, _)| area).sum();
    let centre = faces().map(|(area, p)| p * area).sum::<DVec3>() / area.max(f64::MIN_POSITIVE);
    let mut matrix = [[0.0; 3]; 3];
    for (area, p) in faces() {
        let d = (p - centre).to_array();
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += area * d[i] * d[j];
            }
        }
    }
    let (moments, axes) = eigenvectors(matrix);
    PrincipalAxes { centre, axes, moments }
}

/// Eigenvalues of a symmetric matrix and its eigenvectors as columns, a right-handed orthonormal system, in no order.
pub fn eigenvectors(mut matrix: [[f64; 3]; 3]) -> (DVec3, DMat3) {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut matrix, &mut axes, i, j);
        }
    }
    // Rows of `axes` are columns of the rotation.
    let [x, y, _] = axes.map(DVec3::from);
    (DVec3::from([0, 1, 2].map(|k| matrix[k][k])), DMat3::from_cols(x, y, x.cross(y)))
}

/// Jacobi's rotation that makes entry (i, j) of a symmetric matrix zero; `axes` are turned with it.
fn rotate(m: &mut [[f64; 3]; 3], axes: &mut [[f64; 3]; 3], i: usize, j: usize) {
    if m[i][j].abs() <= f64::EPSILON * (m[i][i].abs() + m[j][j].abs()) {
        return;
    }
    let angle = 0.5 * (2.0 * m[i][j]).atan2(m[i][i] - m[j][j]);
    let (sine, cosine) = angle.sin_cos();
    for k in 0..3 {
        let (a, b) = (m[i][k], m[j][k]);
        (m[i][k], m[j][k]) = (cosine * a + sine * b, cosine * b - sine * a);
    }
    for row in m.iter_mut() {
        let (a, b) = (row[i], row[j]);
        (row[i], row[j]) = (cosine * a + sine * b, cosine * b - sine * a);
    }
    for k in 0..3 {
        let (a, b) = (axes[i][k], axes[j][k]);
        (axes[i][k], axes[j][k]) = (cosine * a + sine * b, cosine * b - sine * a);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetric_matrix_is_put_together_from_its_eigenvectors() {
        for matrix in [[[2.0, 1.0, 0.5], [1.0, -3.0, 0.25], [0.5, 0.25, 1.0]], [[1.0; 3]; 3], [[0.0; 3]; 3]] {
            let (values, axes) = eigenvectors(matrix);
            let again = axes * DMat3::from_diagonal(values) * axes.transpose();
            assert!(again.abs_diff_eq(DMat3::from_cols_array_2d(&matrix), 1e-12), "{matrix:?}");
            assert!((axes.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
