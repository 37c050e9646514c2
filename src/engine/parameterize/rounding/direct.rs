//! Direct rounding: every integer to its nearest, whatever the others do. What the thesis measures the others by.

use crate::engine::parameterize::rounding::gram::Gram;

/// Rounds every coordinate.
pub(super) fn direct(target: &[f64]) -> Vec<f64> {
    target.iter().map(|t| t.round()).collect()
}

/// Expected energy of direct rounding if the optimum lies anywhere with equal probability: every error is uniform in
/// [−½, ½], hence has variance 1/12 (`[kaelberer_2013]` section 6.4).
pub(super) fn expected(gram: &Gram) -> f64 {
    gram.trace() / 12.0
}
