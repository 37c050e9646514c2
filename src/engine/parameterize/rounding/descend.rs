//! Steepest descent by single steps and by double steps of strongly coupled pairs.

use crate::engine::parameterize::rounding::candidate::Candidate;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Pairs coupled less than this, relative to their stiffnesses, are not moved together.
const WEAK: f64 = 0.05;

/// Takes the step that lowers the energy most, at most `steps` times, until none does. A step that violates a
/// separation is not taken.
pub(super) fn descend(ctx: &RunContext, candidate: &mut Candidate<'_>, steps: usize) -> Result<(), Cancelled> {
    let gram = candidate.gram;
    let n = gram.n;
    let p = |i: usize, j: usize| gram.at(i, j);
    let neighbours: Vec<Vec<usize>> =
        (0..n).map(|i| (i + 1..n).filter(|&j| p(i, j).abs() > WEAK * (p(i, i) * p(j, j)).sqrt()).collect()).collect();
    let tolerance = candidate.tolerance();
    for step in 0..steps {
        ctx.check()?;
        // It mostly ends long before the limit.
        let left = 1.0 - step as f64 / steps as f64;
        ctx.advance(1.0 - left * left);
        let mut best: (f64, Vec<(usize, f64)>) = (-tolerance, Vec::new());
        for i in 0..n {
            for s in [1.0, -1.0] {
                let single = candidate.single(i, s);
                if single < best.0 && !candidate.breaks(&[(i, s)]) {
                    best = (single, vec![(i, s)]);
                }
            }
            for &j in &neighbours[i] {
                // No choice of signs does better than this.
                let alone = p(i, i) - 2.0 * candidate.slope[i].abs() + p(j, j) - 2.0 * candidate.slope[j].abs();
                if alone - 2.0 * p(i, j).abs() >= best.0 {
                    continue;
                }
                for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let double = candidate.single(i, s) + candidate.single(j, t) + 2.0 * s * t * p(i, j);
                    if double < best.0 && !candidate.breaks(&[(i, s), (j, t)]) {
                        best = (double, vec![(i, s), (j, t)]);
                    }
                }
            }
        }
        if best.1.is_empty() {
            break;
        }
        candidate.take(&best.1);
    }
    Ok(())
}
