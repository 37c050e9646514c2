//! What the ways of rounding cost on one model, and what the period matrix predicts (`[kaelberer_2013]` sections 6.3.3
//! and 6.4).

use rayon::prelude::*;

use crate::engine::numerics::Random;
use crate::engine::numerics::positive_definite_inverse;
use crate::engine::parameterize::rounding::Periods;
use crate::engine::parameterize::rounding::candidate::{Candidate, Guard};
use crate::engine::parameterize::rounding::direct::{direct, expected};
use crate::engine::parameterize::rounding::gram::Basis;
use crate::engine::parameterize::rounding::greedy::{Next, greedy};
use crate::engine::parameterize::rounding::r_search::r_search;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Mean energies of ways of rounding over random real optima, relative to ½‖X‖², without separations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoundingStatistics {
    /// Number of integers.
    pub n_integers: usize,
    /// Every integer to its nearest, in the basis of a shortest cut graph; over more optima, for a few stiff directions
    /// make its mean settle slowly.
    pub direct: f64,
    /// Iterative greedy rounding as the thesis describes `[bommes_2009]`'s, in the same basis.
    pub greedy: f64,
    /// The search of the thesis for r = 1, 2, 3, in the same basis, from direct rounding, each from the last.
    pub r_search: [f64; 3],
    /// The search of this engine.
    pub search: f64,
    /// What the trace of the period matrix predicts for direct rounding.
    pub predicted_direct: f64,
    /// What the reduced period matrix predicts for the search: 0.9/12 of the sum of the squared diagonal of its Cholesky
    /// factor. Direct rounding of positions where there are too many integers for a reduced one.
    pub predicted_search: f64,
}

/// Optima that are rounded directly for each that is searched.
const MORE_DIRECT: u64 = 20;
/// Energy after the search relative to what nearest planes leave in the reduced basis. Measured on random optima of
/// many models.
const SEARCHED: f64 = 0.9;

impl Periods {
    /// Energy that rounding is expected to add, in the units of the period matrix, whatever the density. Direct rounding
    /// leaves 1/12 of the trace. Rounding along nearest planes, in which every integer makes up for those fixed before
    /// it, leaves 1/12 of the trace of what the matrix has left of each direction when the ones fixed later are free:
    /// the squared diagonal of the Cholesky factor, in the reduced basis. The search leaves a little less.
    pub(in crate::engine::parameterize) fn predicted(&self) -> f64 {
        let Some(lattice) = &self.lattice else { return expected(&self.gram) };
        let n = self.gram.n;
        let factor = lattice.gram.cholesky(&(0..n).collect::<Vec<_>>()).unwrap_or_default();
        SEARCHED / 12.0 * factor.iter().step_by(n + 1).map(|d| d * d).sum::<f64>()
    }

    /// Rounds `offsets` optima that are uniform modulo 1 in the basis. Energies are multiplied by `unit`.
    pub(in crate::engine::parameterize) fn statistics(
        &self,
        ctx: &RunContext,
        basis: &Basis,
        unit: f64,
        offsets: usize,
    ) -> Result<RoundingStatistics, Cancelled> {
        let n = self.gram.n;
        let gram = self.gram.in_basis(basis);
        let mut statistics = RoundingStatistics {
            n_integers: n,
            predicted_direct: unit * expected(&gram),
            predicted_search: unit * self.predicted(),
            ..RoundingStatistics::default()
        };
        let Some(inverse) = positive_definite_inverse(n, &gram.rows) else { return Ok(statistics) };
        let guard = Guard::default();
        let energies: Vec<[f64; 6]> = (0..offsets as u64)
            .into_par_iter()
            .map(|offset| {
                let mut random = Random::new(ctx.seed() ^ (offset << 32));
                let target: Vec<f64> = (0..n).map(|_| random.unit()).collect();
                let nearest = direct(&target);
                let off: f64 = (0..MORE_DIRECT)
                    .map(|_| gram.value(&(0..n).map(|_| random.unit() - 0.5).collect::<Vec<_>>()))
                    .sum();
                let greedy = greedy(ctx, &inverse, &target, Next::LeastIncrease)?;
                let greedy = Candidate::new(&gram, &guard, &target, greedy).energy;
                let mut candidate = Candidate::new(&gram, &guard, &target, nearest);
                let mut energies = [(candidate.energy + off) / (MORE_DIRECT + 1) as f64, greedy, 0.0, 0.0, 0.0, 0.0];
                for r in 1..=3 {
                    r_search(ctx, &mut candidate, r)?;
                    energies[r + 1] = candidate.energy;
                }
                let target = basis.combine(&target);
                let (q, _) = self.nearest(ctx, &target, &[])?;
                energies[5] = self.gram.value(&q.iter().zip(&target).map(|(q, t)| q - t).collect::<Vec<_>>());
                Ok(energies)
            })
            .collect::<Result<_, Cancelled>>()?;
        let mean = |k: usize| unit * energies.iter().map(|e| e[k]).sum::<f64>() / offsets.max(1) as f64;
        statistics.direct = mean(0);
        statistics.greedy = mean(1);
        statistics.r_search = [2, 3, 4].map(mean);
        statistics.search = mean(5);
        Ok(statistics)
    }
}
