//! Exact search for the best values of a few integers while the others stay: the closest vector by branch and bound
//! along the Cholesky factor, nearest values first `[schnorr_1994]`.

use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::rounding::candidate::Candidate;
use crate::engine::parameterize::rounding::gram::{Gram, dot};

/// Some integers, in the order in which the search fixes them, last first.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) integers: Vec<usize>,
    /// `RᵀR` is their part of the matrix; upper triangle, row after row.
    upper: Vec<f64>,
}

impl Block {
    /// `None` if the part of the matrix is numerically indefinite. O(m⁴).
    pub(super) fn new(gram: &Gram, integers: Vec<usize>) -> Option<Self> {
        let order = stiffest_last(gram, integers)?;
        let m = order.len();
        let lower = gram.cholesky(&order)?;
        let upper = (0..m * m).map(|k| lower[(k % m) * m + k / m]).collect();
        Some(Self { integers: order, upper })
    }

    /// The steps to the best values of the integers of the block that break no separation; `None` if they have them.
    /// Exact unless `work`, counted in visited values, runs out: then the best found so far.
    pub(super) fn best_steps(&self, candidate: &mut Candidate<'_>, work: &mut u64) -> Option<Vec<(usize, f64)>> {
        let (m, r) = (self.integers.len(), &self.upper);
        // The energy of steps x is |y + R x|² and what no step changes, with Rᵀ y the slope.
        let mut y = vec![0.0; m];
        for i in 0..m {
            let known: f64 = (0..i).map(|j| r[j * m + i] * y[j]).sum();
            y[i] = (candidate.slope[self.integers[i]] - known) / r[i * m + i];
        }
        let mut bound = dot(&y, &y) - candidate.tolerance();
        let mut best = None;
        let mut x = vec![0.0; m];
        // Per level: the real optimum, the direction and length of the next step away from it, the energy above.
        let (mut centre, mut stride, mut above) = (vec![0.0; m], vec![0.0; m], vec![0.0; m + 1]);
        let mut level = m;
        let mut goes_down = bound > 0.0 && m > 0;
        while *work > 0 {
            *work -= 1;
            if goes_down {
                level -= 1;
                let row = &r[level * m..(level + 1) * m];
                centre[level] = -(y[level] + dot(&row[level + 1..], &x[level + 1..])) / row[level];
                x[level] = centre[level].round();
                stride[level] = if centre[level] > x[level] { 1.0 } else { -1.0 };
            } else {
                // Back to the level above, where the next nearest value is tried.
                level += 1;
                if level >= m {
                    break;
                }
                next(&mut x[level], &mut stride[level]);
            }
            let off = r[level * m + level] * (x[level] - centre[level]);
            let mut energy = above[level + 1] + off * off;
            while level == 0 && energy < bound {
                let steps: Vec<(usize, f64)> =
                    self.integers.iter().copied().zip(x.iter().copied()).filter(|s| s.1 != 0.0).collect();
                if !candidate.breaks(&steps) {
                    (bound, best) = (energy, Some(steps));
                    break;
                }
                // Between separations that hold each other many values may be near enough and none allowed.
                *work = work.saturating_sub(1 + steps.len() as u64);
                if *work == 0 {
                    break;
                }
                next(&mut x[0], &mut stride[0]);
                energy = above[1] + (r[0] * (x[0] - centre[0])).powi(2);
            }
            goes_down = level > 0 && energy < bound;
            above[level] = energy;
        }
        best
    }
}

/// The next nearest integer on the other side.
fn next(x: &mut f64, stride: &mut f64) {
    *x += *stride;
    *stride = -*stride - stride.signum();
}

/// Orders the integers so that the ones that the others can make up for least are fixed first: the bound is met early.
fn stiffest_last(gram: &Gram, mut integers: Vec<usize>) -> Option<Vec<usize>> {
    let mut order = Vec::with_capacity(integers.len());
    while !integers.is_empty() {
        let m = integers.len();
        let rows: Vec<f64> = (0..m * m).map(|k| gram.at(integers[k / m], integers[k % m])).collect();
        let inverse = positive_definite_inverse(m, &rows)?;
        let (at, _) = (0..m).map(|a| (a, inverse[a * m + a])).min_by(|a, b| a.1.total_cmp(&b.1))?;
        order.push(integers.remove(at));
    }
    order.reverse();
    Some(order)
}
