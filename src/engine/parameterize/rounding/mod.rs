//! Rounding by the period matrix: the energy of the best map with integers q is `E* + (q − q*)ᵀ P (q − q*)`
//! (`[kaelberer_2013]` section 6.3), so integers are compared without another solve.
//!
//! The lattice. The thesis rounds the translations between neighbouring branch points and must keep those of points of
//! odd index in the lattice of (1, 1) and (−1, 1), and double those of even index, so that all points are integers
//! (section 4.2.2). Here positions themselves are the unknowns that survive elimination: both coordinates of every branch
//! point and corner, the iso coordinate of every feature line, and the translations of handles that nothing else fixes.
//! Translations between points are `(1 − i) z` around a point of odd index, which is that lattice, and `2 z` around one of
//! even index: both kinds are integers by construction, any integers q are admissible, and the lattice is Zⁿ.
//! Positions against one origin are a poor basis of it, though: searches work in a reduced one, and the figures of the
//! thesis are measured in that of a shortest cut graph ([`PeriodForm`]; `cargo bench -- rounding`).
//!
//! | file | rounding |
//! |---|---|
//! | `greedy` | one at a time, the others follow |
//! | `descend` | steepest single and double steps |
//! | `block_search` | exact over blocks as far as the work allows, with kicks; one block where there are few |
//! | `pulled` | greedy and descent around separations |

mod block_search;
mod candidate;
mod descend;
mod enumeration;
mod gram;
mod greedy;
mod lattice;
mod period_form;
mod periods;
mod pulled;
mod reduction;
#[cfg(test)]
mod tests;

pub(super) use gram::Basis;
pub use period_form::PeriodForm;
pub(super) use periods::Periods;

use crate::engine::parameterize::rounding::block_search::block_search;
use crate::engine::parameterize::rounding::candidate::{Candidate, Guard};
use crate::engine::parameterize::rounding::pulled::pulled;
use crate::engine::parameterize::separation::Separation;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Values that the search by blocks visits, per integer and at most: some hundredths of a second.
const WORK_PER_INTEGER: u64 = 5_000;
const MAX_WORK: u64 = 1_000_000;

impl Periods {
    /// The integers for this scale, and how many separations they violate.
    pub(super) fn round(
        &self,
        ctx: &RunContext,
        scale: f64,
        separations: &[Separation],
    ) -> Result<(Vec<f64>, usize), Cancelled> {
        let target: Vec<f64> = self.optimum.iter().map(|o| scale * o).collect();
        self.nearest(ctx, &target, separations)
    }

    /// Integers near a real optimum, and how many separations they violate. Starts are greedy, in the basis of positions
    /// and in the reduced one; the better of them (fewer violations, then less energy) is improved by blocks, so the
    /// result is never worse than either.
    pub(super) fn nearest(
        &self,
        ctx: &RunContext,
        target: &[f64],
        separations: &[Separation],
    ) -> Result<(Vec<f64>, usize), Cancelled> {
        let positions = pulled(&ctx.span(0.0, 0.4), &self.gram, &self.inverse, target, separations)?;
        let Some(lattice) = &self.lattice else {
            let n_violated = separations.iter().filter(|s| s.is_violated(&positions)).count();
            return Ok((positions, n_violated));
        };
        let basis = &lattice.basis;
        let forms = lattice.separations(separations);
        let guard = Guard::new(self.gram.n, &forms);
        let target = basis.coordinates(target);
        let near = pulled(&ctx.span(0.4, 0.8), &lattice.gram, &lattice.inverse, &target, &forms)?;
        let starts = [basis.coordinates(&positions), near].map(|q| Candidate::new(&lattice.gram, &guard, &target, q));
        let [a, b] = starts;
        let is_first = (a.violated().len(), a.energy) <= (b.violated().len(), b.energy);
        let mut best = if is_first { a } else { b };
        let work = MAX_WORK.min(WORK_PER_INTEGER * best.q.len() as u64);
        block_search(&ctx.span(0.8, 1.0), &lattice.blocks, &mut best, ctx.seed(), work)?;
        let n_violated = best.violated().len();
        Ok((basis.combine(&best.q), n_violated))
    }
}
