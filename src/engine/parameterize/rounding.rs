//! Rounding by the period matrix: the energy of the best map with integers q is `E* + (q − q*)ᵀ P (q − q*)`
//! ([kaelberer_2013] section 6.3; algorithms.md D.1), so integers are compared without another solve.

use rayon::prelude::*;

use crate::engine::numerics::Cholesky;
use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::reduced::Reduced;
use crate::engine::parameterize::separation::Separation;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// The period matrix and the real optimum for unit scale.
#[derive(Clone, Debug)]
pub(super) struct Periods {
    pub(super) n: usize,
    /// Dense, row after row, symmetric positive definite.
    pub(super) matrix: Vec<f64>,
    /// Its inverse.
    pub(super) inverse: Vec<f64>,
    /// Real optimum of the integers for scale 1; it grows in proportion to the scale.
    pub(super) optimum: Vec<f64>,
}

/// Times that violated separations are pulled apart.
const MAX_PULLS: usize = 6;
/// With more integers than this, fewer pulls and steps: each pull inverts a dense matrix.
const MANY_INTEGERS: usize = 400;
/// Stiffness of a pulled separation relative to the mean stiffness of an integer.
const SPRING: f64 = 20.0;

/// Columns solved for at once.
const CHUNK: usize = 16;

impl Periods {
    /// The Schur complement of the continuous unknowns. n solves with the factor; `None` if the complement is not
    /// positive definite.
    pub(super) fn new(ctx: &RunContext, reduced: &Reduced, factor: &Cholesky<f64>) -> Result<Option<Self>, Cancelled> {
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
        // The matrix is positive definite in theory; rounding errors of the solves are of the order of the last bits
        // of its largest entries.
        let largest = (0..n).map(|i| matrix[i * n + i]).fold(0.0, f64::max);
        for i in 0..n {
            matrix[i * n + i] += 1e-12 * largest;
        }
        let Some(inverse) = positive_definite_inverse(n, &matrix) else { return Ok(None) };
        let optimum = (0..n).map(|i| dot(&inverse[i * n..(i + 1) * n], &b)).collect();
        Ok(Some(Self { n, matrix, inverse, optimum }))
    }

    /// Energy above the real optimum at this scale.
    pub(super) fn excess(&self, scale: f64, q: &[f64]) -> f64 {
        let d: Vec<f64> = q.iter().zip(&self.optimum).map(|(q, o)| q - scale * o).collect();
        (0..self.n).map(|i| d[i] * dot(&self.matrix[i * self.n..(i + 1) * self.n], &d)).sum()
    }

    /// Fixes the unknown nearest to an integer, one at a time, the others following to their new optimum
    /// ([bommes_2009]'s greedy rounding without solves), then improves by single and double steps. Separations that the
    /// result violates are pulled to their bound by a stiff spring and everything is rounded again, a few times; the
    /// returned number counts those that stay violated.
    pub(super) fn round(
        &self,
        ctx: &RunContext,
        scale: f64,
        separations: &[Separation],
    ) -> Result<(Vec<f64>, usize), Cancelled> {
        let target: Vec<f64> = self.optimum.iter().map(|o| scale * o).collect();
        let mut q = self.greedy(ctx, &self.inverse, &target)?;
        self.descend(ctx, scale, separations, &mut q)?;
        let mut pulled: Vec<usize> = Vec::new();
        let mut best = (violated(separations, &q).len(), q.clone());
        for _ in 0..if self.n > MANY_INTEGERS { 2 } else { MAX_PULLS } {
            let violated = violated(separations, &q);
            if violated.len() < best.0 {
                best = (violated.len(), q.clone());
            }
            if violated.is_empty() {
                break;
            }
            pulled.extend(violated);
            pulled.sort_unstable();
            pulled.dedup();
            let Some((inverse, optimum)) = self.pull(&target, separations, &pulled) else { break };
            q = self.greedy(ctx, &inverse, &optimum)?;
            self.descend(ctx, scale, separations, &mut q)?;
        }
        let last = violated(separations, &q).len();
        Ok(if last < best.0 { (q, last) } else { (best.1, best.0) })
    }

    /// Inverse and optimum of the energy with a stiff spring on each pulled separation.
    fn pull(&self, target: &[f64], separations: &[Separation], pulled: &[usize]) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = self.n;
        let stiffness = SPRING * (0..n).map(|i| self.matrix[i * n + i]).sum::<f64>() / n.max(1) as f64;
        let mut matrix = self.matrix.clone();
        let mut b: Vec<f64> = (0..n).map(|i| dot(&self.matrix[i * n..(i + 1) * n], target)).collect();
        for separation in pulled.iter().map(|&k| &separations[k]) {
            let length = separation.value(target).max(1.0);
            for &(i, c) in &separation.form {
                for &(j, d) in &separation.form {
                    matrix[i as usize * n + j as usize] += stiffness * c * d;
                }
                b[i as usize] += stiffness * c * length;
            }
        }
        let inverse = positive_definite_inverse(n, &matrix)?;
        let optimum = (0..n).map(|i| dot(&inverse[i * n..(i + 1) * n], &b)).collect();
        Some((inverse, optimum))
    }

    fn greedy(&self, ctx: &RunContext, inverse: &[f64], target: &[f64]) -> Result<Vec<f64>, Cancelled> {
        let n = self.n;
        let mut q = target.to_vec();
        let mut covariance = inverse.to_vec();
        let mut open: Vec<usize> = (0..n).collect();
        while !open.is_empty() {
            ctx.check()?;
            let nearest = open
                .iter()
                .enumerate()
                .min_by(|(_, a), (_, b)| (q[**a] - q[**a].round()).abs().total_cmp(&(q[**b] - q[**b].round()).abs()));
            let Some((at, &i)) = nearest else { break };
            open.swap_remove(at);
            let step = q[i].round() - q[i];
            let row: Vec<f64> = covariance[i * n..(i + 1) * n].to_vec();
            let variance = row[i].max(1e-300);
            for &j in &open {
                q[j] += step * row[j] / variance;
            }
            q[i] = q[i].round();
            for &j in &open {
                let factor = row[j] / variance;
                // Columns of fixed unknowns are never read again; whole rows go faster than picking the open ones.
                for (c, r) in covariance[j * n..(j + 1) * n].iter_mut().zip(&row) {
                    *c -= factor * r;
                }
            }
        }
        Ok(q)
    }

    /// Single steps ±1 and double steps of strongly coupled pairs while the energy falls (r-search with r ≤ 2). A step
    /// that violates a separation is not taken.
    fn descend(
        &self,
        ctx: &RunContext,
        scale: f64,
        separations: &[Separation],
        q: &mut [f64],
    ) -> Result<(), Cancelled> {
        let n = self.n;
        let p = |i: usize, j: usize| self.matrix[i * n + j];
        let mut gradient: Vec<f64> = {
            let d: Vec<f64> = q.iter().zip(&self.optimum).map(|(q, o)| q - scale * o).collect();
            (0..n).map(|i| 2.0 * dot(&self.matrix[i * n..(i + 1) * n], &d)).collect()
        };
        let neighbours: Vec<Vec<usize>> = (0..n)
            .map(|i| (0..n).filter(|&j| j > i && p(i, j).abs() > 0.05 * (p(i, i) * p(j, j)).sqrt()).collect())
            .collect();
        let mut concerns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        for (k, separation) in separations.iter().enumerate() {
            for &(i, c) in &separation.form {
                concerns[i as usize].push((k, c));
            }
        }
        let mut value: Vec<f64> = separations.iter().map(|s| s.value(q)).collect();
        // Whether these steps lower a separation below its bound.
        let mut change = vec![0.0; separations.len()];
        let mut breaks = |value: &[f64], steps: &[(usize, f64)]| {
            let concerned = || steps.iter().flat_map(|&(i, s)| concerns[i].iter().map(move |&(k, c)| (k, s * c)));
            concerned().for_each(|(k, by)| change[k] += by);
            concerned().fold(false, |is_broken, (k, _)| {
                let by = std::mem::take(&mut change[k]);
                is_broken || by < 0.0 && value[k] + by < 1.0
            })
        };
        let steps = if n > MANY_INTEGERS { 100 } else { 20 * n.max(50) };
        let tolerance = 1e-12 * (1.0 + self.matrix.first().map_or(0.0, |p| p.abs()));
        for _ in 0..steps {
            ctx.check()?;
            let mut best: (f64, Vec<(usize, f64)>) = (-tolerance, Vec::new());
            for i in 0..n {
                for s in [1.0, -1.0] {
                    let single = p(i, i) + s * gradient[i];
                    if single < best.0 && !breaks(&value, &[(i, s)]) {
                        best = (single, vec![(i, s)]);
                    }
                }
                for &j in &neighbours[i] {
                    // No choice of signs does better than this.
                    let alone = p(i, i) - gradient[i].abs() + p(j, j) - gradient[j].abs();
                    if alone - 2.0 * p(i, j).abs() >= best.0 {
                        continue;
                    }
                    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                        let double = p(i, i) + s * gradient[i] + p(j, j) + t * gradient[j] + 2.0 * s * t * p(i, j);
                        if double < best.0 && !breaks(&value, &[(i, s), (j, t)]) {
                            best = (double, vec![(i, s), (j, t)]);
                        }
                    }
                }
            }
            if best.1.is_empty() {
                break;
            }
            for (i, s) in best.1 {
                q[i] += s;
                for &(k, c) in &concerns[i] {
                    value[k] += s * c;
                }
                for (j, g) in gradient.iter_mut().enumerate() {
                    *g += 2.0 * s * p(i, j);
                }
            }
        }
        Ok(())
    }
}

fn violated(separations: &[Separation], q: &[f64]) -> Vec<usize> {
    (0..separations.len()).filter(|&k| separations[k].value(q) < 0.5).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
