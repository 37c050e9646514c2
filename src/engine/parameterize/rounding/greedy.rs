//! Iterative greedy rounding.

use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Fixes one unknown at a time, the one nearest to an integer first, the others following to their new optimum (`[bommes_2009]`'s greedy rounding without
/// solves). `inverse` is that of the matrix, n × n. O(n³).
pub(super) fn greedy(ctx: &RunContext, inverse: &[f64], target: &[f64]) -> Result<Vec<f64>, Cancelled> {
    let n = target.len();
    let mut q = target.to_vec();
    let mut covariance = inverse.to_vec();
    let mut open: Vec<usize> = (0..n).collect();
    while !open.is_empty() {
        ctx.check()?;
        let left = open.len() as f64 / n as f64;
        ctx.advance(1.0 - left * left);
        let off = |i: usize| (q[i] - q[i].round()).abs();
        let nearest = open.iter().enumerate().min_by(|(_, a), (_, b)| off(**a).total_cmp(&off(**b)));
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
