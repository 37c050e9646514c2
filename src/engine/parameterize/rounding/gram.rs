//! A positive definite quadratic form over integer vectors, and bases of the lattice of all integer vectors.

use crate::engine::numerics::cholesky_lower;

/// A symmetric positive definite matrix, dense.
#[derive(Clone, Debug)]
pub(in crate::engine::parameterize) struct Gram {
    pub(super) n: usize,
    /// n × n, row after row.
    pub(super) rows: Vec<f64>,
}

impl Gram {
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.n..(i + 1) * self.n]
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.rows[i * self.n + j]
    }

    pub(super) fn times(&self, d: &[f64]) -> Vec<f64> {
        (0..self.n).map(|i| dot(self.row(i), d)).collect()
    }

    /// `dᵀ G d`.
    pub(super) fn value(&self, d: &[f64]) -> f64 {
        (0..self.n).map(|i| d[i] * dot(self.row(i), d)).sum()
    }

    pub(super) fn trace(&self) -> f64 {
        (0..self.n).map(|i| self.at(i, i)).sum()
    }

    /// The matrix of scalar products of the vectors of the basis.
    pub(super) fn in_basis(&self, basis: &Basis) -> Self {
        let n = self.n;
        let half = sparse_times(n, &basis.vectors, &self.rows);
        let transposed: Vec<f64> = (0..n * n).map(|k| half[(k % n) * n + k / n]).collect();
        Self { n, rows: sparse_times(n, &basis.vectors, &transposed) }
    }

    /// Lower triangle of the Cholesky factor of the rows and columns in `order`, row after row.
    pub(super) fn cholesky(&self, order: &[usize]) -> Option<Vec<f64>> {
        let m = order.len();
        let rows: Vec<f64> = (0..m * m).map(|k| self.at(order[k / m], order[k % m])).collect();
        cholesky_lower(m, &rows)
    }
}

/// `A B` for square matrices, A mostly zeros.
fn sparse_times(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; n * n];
    for (row, out) in a.chunks(n.max(1)).zip(product.chunks_mut(n.max(1))) {
        for (k, &c) in row.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            for (o, b) in out.iter_mut().zip(&b[k * n..(k + 1) * n]) {
                *o += c * b;
            }
        }
    }
    product
}

/// A basis of Zⁿ: a unimodular integer matrix and its inverse, both dense and exact.
#[derive(Clone, Debug)]
pub(in crate::engine::parameterize) struct Basis {
    pub(super) n: usize,
    /// Row j is the jth vector.
    pub(super) vectors: Vec<f64>,
    /// Row j times an integer vector is its jth coordinate.
    pub(super) dual: Vec<f64>,
}

impl Basis {
    pub(super) fn unit(n: usize) -> Self {
        let mut vectors = vec![0.0; n * n];
        (0..n).for_each(|i| vectors[i * n + i] = 1.0);
        Self { n, dual: vectors.clone(), vectors }
    }

    /// From each integer as a form in the coordinates, and each coordinate as a form in the integers.
    pub(in crate::engine::parameterize) fn from_forms(
        integers: &[Vec<(u32, f64)>],
        coordinates: &[Vec<(u32, f64)>],
    ) -> Self {
        let n = integers.len();
        let (mut vectors, mut dual) = (vec![0.0; n * n], vec![0.0; n * n]);
        for (i, form) in integers.iter().enumerate() {
            form.iter().for_each(|&(j, c)| vectors[j as usize * n + i] = c);
        }
        for (j, form) in coordinates.iter().enumerate() {
            form.iter().for_each(|&(i, c)| dual[j * n + i as usize] = c);
        }
        Self { n, vectors, dual }
    }

    /// `Σ x_j v_j`.
    pub(super) fn combine(&self, x: &[f64]) -> Vec<f64> {
        let mut q = vec![0.0; self.n];
        for (row, &x) in self.vectors.chunks(self.n.max(1)).zip(x) {
            q.iter_mut().zip(row).for_each(|(q, v)| *q += x * v);
        }
        q
    }

    /// Coordinates of a vector, integer or not.
    pub(super) fn coordinates(&self, q: &[f64]) -> Vec<f64> {
        self.dual.chunks(self.n.max(1)).map(|row| dot(row, q)).collect()
    }

    /// A form in the integers as a form in the coordinates.
    pub(super) fn form(&self, form: &[(u32, f64)]) -> Vec<(u32, f64)> {
        let value = |j: usize| form.iter().map(|&(i, c)| c * self.vectors[j * self.n + i as usize]).sum::<f64>();
        (0..self.n).map(|j| (j as u32, value(j))).filter(|&(_, c)| c != 0.0).collect()
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
