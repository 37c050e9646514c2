//! The period matrix: the energy of the best map as a function of its integers.

use rayon::prelude::*;

use crate::engine::numerics::Cholesky;
use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::reduced::Reduced;
use crate::engine::parameterize::rounding::gram::{Gram, dot};
use crate::engine::parameterize::rounding::lattice::Lattice;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// The period matrix and the real optimum for unit scale.
#[derive(Clone, Debug)]
pub(in crate::engine::parameterize) struct Periods {
    pub(super) gram: Gram,
    /// Its inverse, n × n.
    pub(super) inverse: Vec<f64>,
    /// Real optimum of the integers for scale 1; it grows in proportion to the scale.
    pub(in crate::engine::parameterize) optimum: Vec<f64>,
    /// The same integers in a reduced basis, unless there are too many.
    pub(super) lattice: Option<Lattice>,
}

/// Columns solved for at once.
const CHUNK: usize = 16;

impl Periods {
    /// The Schur complement of the continuous unknowns. n solves with the factor; `None` if the complement is not
    /// positive definite.
    pub(in crate::engine::parameterize) fn new(
        ctx: &RunContext,
        reduced: &Reduced,
        factor: &Cholesky<f64>,
    ) -> Result<Option<Self>, Cancelled> {
        let solves = ctx.span(0.0, 0.7);
        let (n, nz) = (reduced.b_q.len(), reduced.b_z.len());
        let columns: Vec<usize> = (0..n).collect();
        let blocks: Vec<Vec<f64>> = columns
            .par_chunks(CHUNK)
            .map(|chunk| {
                ctx.check()?;
                let mut w = vec![0.0; nz * chunk.len()];
                for (column, &j) in w.chunks_mut(nz.max(1)).zip(chunk) {
                    for &(i, v) in &reduced.zq[j] {
                        column[i as usize] = v;
                    }
                }
                factor.solve(&mut w);
                let mut block = Vec::with_capacity(n * chunk.len());
                for column in w.chunks(nz.max(1)) {
                    block
                        .extend(reduced.zq.iter().map(|c| c.iter().map(|&(i, v)| v * column[i as usize]).sum::<f64>()));
                }
                block.resize(n * chunk.len(), 0.0);
                solves.step(n.div_ceil(CHUNK));
                Ok(block)
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut matrix = reduced.qq.clone();
        for (j, column) in blocks.iter().flat_map(|b| b.chunks(n.max(1))).enumerate() {
            for (i, v) in column.iter().enumerate() {
                matrix[i * n + j] -= v;
            }
        }
        let mut z = reduced.b_z.clone();
        factor.solve(&mut z);
        let b: Vec<f64> = (0..n)
            .map(|j| reduced.b_q[j] - reduced.zq[j].iter().map(|&(i, v)| v * z[i as usize]).sum::<f64>())
            .collect();
        Self::from_matrix(ctx, Gram { n, rows: matrix }, &b)
    }

    /// The energy `qᵀ P q − 2 bᵀ q`, up to a constant.
    pub(super) fn from_matrix(ctx: &RunContext, mut gram: Gram, b: &[f64]) -> Result<Option<Self>, Cancelled> {
        let n = gram.n;
        // The matrix is positive definite in theory; rounding errors of the solves are of the order of the last bits
        // of its largest entries.
        let largest = (0..n).map(|i| gram.at(i, i)).fold(0.0, f64::max);
        for i in 0..n {
            gram.rows[i * n + i] += 1e-12 * largest;
            for j in 0..i {
                let mean = 0.5 * (gram.at(i, j) + gram.at(j, i));
                (gram.rows[i * n + j], gram.rows[j * n + i]) = (mean, mean);
            }
        }
        let Some(inverse) = positive_definite_inverse(n, &gram.rows) else { return Ok(None) };
        let optimum = inverse.chunks(n.max(1)).map(|row| dot(row, b)).collect();
        ctx.check()?;
        ctx.advance(0.8);
        let lattice = Lattice::reduced(&gram);
        Ok(Some(Self { gram, inverse, optimum, lattice }))
    }

    /// Takes from the optimum what regularisation left there: one step with the residual of the whole system, after which
    /// the map of the optimum is the projection of the field to about 1e-12 instead of 1e-9.
    pub(in crate::engine::parameterize) fn refine(&mut self, reduced: &Reduced, factor: &Cholesky<f64>) -> &[f64] {
        let z = reduced.solve_continuous(factor, 1.0, &self.optimum);
        let n = self.optimum.len();
        let residual: Vec<f64> = (0..n)
            .map(|j| {
                let coupled = reduced.zq[j].iter().map(|&(i, v)| v * z[i as usize]).sum::<f64>();
                reduced.b_q[j] - coupled - dot(&reduced.qq[j * n..][..n], &self.optimum)
            })
            .collect();
        let steps: Vec<f64> = self.inverse.chunks(n.max(1)).map(|row| dot(row, &residual)).collect();
        self.optimum.iter_mut().zip(steps).for_each(|(optimum, step)| *optimum += step);
        &self.optimum
    }

    /// Energy above the real optimum at this scale.
    pub(in crate::engine::parameterize) fn excess(&self, scale: f64, q: &[f64]) -> f64 {
        let d: Vec<f64> = q.iter().zip(&self.optimum).map(|(q, o)| q - scale * o).collect();
        self.gram.value(&d)
    }
}
