//! Greedy rounding and descent, with violated separations pulled to their bound.

use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::rounding::candidate::{Candidate, Guard};
use crate::engine::parameterize::rounding::descend::descend;
use crate::engine::parameterize::rounding::gram::{Gram, dot};
use crate::engine::parameterize::rounding::greedy::greedy;
use crate::engine::parameterize::rounding::lattice::MANY_INTEGERS;
use crate::engine::parameterize::separation::Separation;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Times that violated separations are pulled apart.
const MAX_PULLS: usize = 6;
/// Stiffness of a pulled separation relative to the mean stiffness of an integer.
const SPRING: f64 = 20.0;
/// Each pull takes this share of what is left of the progress: there are mostly fewer than allowed.
const SHARE_OF_PULL: f64 = 0.4;

/// Rounds greedily and descends. Separations that the result violates are pulled to their bound by a stiff spring and
/// everything is rounded again, a few times; the result is the first with the fewest violations.
pub(super) fn pulled(
    ctx: &RunContext,
    gram: &Gram,
    inverse: &[f64],
    target: &[f64],
    separations: &[Separation],
) -> Result<Vec<f64>, Cancelled> {
    let guard = Guard::new(gram.n, separations);
    let steps = if gram.n > MANY_INTEGERS { 100 } else { 20 * gram.n.max(50) };
    let mut pulled: Vec<usize> = Vec::new();
    let mut best: Option<(usize, Vec<f64>)> = None;
    let mut start = greedy(&ctx.span(0.0, 0.2), inverse, target)?;
    ctx.advance(0.2);
    for pull in 0.. {
        let ctx = &ctx.attempt(SHARE_OF_PULL);
        let mut candidate = Candidate::new(gram, &guard, target, start);
        descend(&ctx.span(0.0, 0.4), &mut candidate, steps)?;
        ctx.advance(0.4);
        let violated = candidate.violated();
        let n_violated = violated.len();
        if best.as_ref().is_none_or(|b| n_violated < b.0) {
            best = Some((n_violated, candidate.q));
        }
        if n_violated == 0 || pull == if gram.n > MANY_INTEGERS { 2 } else { MAX_PULLS } {
            break;
        }
        pulled.extend(violated);
        pulled.sort_unstable();
        pulled.dedup();
        let forms: Vec<&Separation> = pulled.iter().map(|&k| &separations[k]).collect();
        let Some((inverse, optimum)) = pull_apart(gram, target, &forms) else { break };
        start = greedy(&ctx.span(0.7, 1.0), &inverse, &optimum)?;
        ctx.advance(1.0);
    }
    Ok(best.map_or_else(Vec::new, |b| b.1))
}

/// Inverse and optimum of the energy with a stiff spring on each of these separations.
fn pull_apart(gram: &Gram, target: &[f64], separations: &[&Separation]) -> Option<(Vec<f64>, Vec<f64>)> {
    let n = gram.n;
    let stiffness = SPRING * gram.trace() / n.max(1) as f64;
    let mut matrix = gram.rows.clone();
    let mut b = gram.times(target);
    for separation in separations {
        let length = separation.value(target).max(1.0);
        for &(i, c) in &separation.form {
            for &(j, d) in &separation.form {
                matrix[i as usize * n + j as usize] += stiffness * c * d;
            }
            b[i as usize] += stiffness * c * length;
        }
    }
    let inverse = positive_definite_inverse(n, &matrix)?;
    let optimum = inverse.chunks(n.max(1)).map(|row| dot(row, &b)).collect();
    Some((inverse, optimum))
}
