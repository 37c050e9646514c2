//! Minimum-deviation flow in a bidirected graph: integers as near as may be to real targets, with sums that vanish.
//!
//! Every variable takes part in at most two sums, with +1 or −1 in each. That is a flow in which an edge may point into
//! both of its ends or out of both, and which changes along walks: a step through an edge changes its value by one so
//! that the sum at the end it comes from is right again, and leaves the other end to the next step. Walks are sought on
//! states (sum, sign of the change it needs), the double cover of the graph. Deviations:
//! feasibility comes from shortest walks between sums that are wrong, not from an evened network simplex, and the
//! optimum from cancelling negative cycles. A cycle that uses an edge twice costs more than the sum of its steps, so
//! what is found is optimal but for such cycles.

use std::collections::BTreeMap;

use crate::engine::numerics::PathSearch;
use crate::engine::parameterize::quantise::labels::{Parents, States};
use crate::engine::run::{Cancelled, RunContext};

/// One integer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    /// The sums that it is a part of, each with its sign; a sum may occur twice.
    pub(super) ends: [Option<(u32, i64)>; 2],
    /// What it is to be near to.
    pub(super) target: f64,
    /// Cost of the square of its deviation.
    pub(super) weight: f64,
    /// Least value.
    pub(super) least: i64,
}

impl Variable {
    /// What a change by one costs here; infinite if it leaves the bounds.
    fn marginal(&self, x: i64, change: i64) -> f64 {
        if x + change < self.least {
            return f64::INFINITY;
        }
        self.weight * change as f64 * (2.0 * (x as f64 - self.target) + change as f64)
    }

    fn cost(&self, x: i64) -> f64 {
        self.weight * (x as f64 - self.target).powi(2)
    }
}

/// A step of a walk.
#[derive(Clone, Copy, Debug)]
struct Arc {
    variable: u32,
    change: i64,
    to: u32,
}

/// Variables and how they hang together.
#[derive(Debug)]
pub(super) struct Flow {
    variables: Vec<Variable>,
    /// Per state, its arcs: `first[s]..first[s + 1]`. State 2 n needs sum n to grow, 2 n + 1 to fall; the last one is
    /// outside of all sums.
    first: Vec<u32>,
    arcs: Vec<Arc>,
}

/// Negative cycles cheaper than this are rounding errors.
const LEAST_GAIN: f64 = 1e-9;
/// Rounds of cycles at most.
const MOST_ROUNDS: usize = 2_000;
/// Each round takes this share of what is left of the progress: there are tens of them.
const SHARE_OF_ROUND: f64 = 0.03;

impl Flow {
    pub(super) fn new(n_sums: usize, variables: Vec<Variable>) -> Self {
        let outside = 2 * n_sums as u32;
        let mut found: Vec<(u32, Arc)> = Vec::with_capacity(4 * variables.len());
        let state = |sum: u32, change: i64| 2 * sum + u32::from(change < 0);
        for (e, variable) in variables.iter().enumerate() {
            for (from, to) in [(0, 1), (1, 0)] {
                for change in [1, -1] {
                    // The end it comes from needs this change; the other end must make up for it.
                    let here = variable.ends[from].map_or(outside, |(sum, sign)| state(sum, sign * change));
                    let there = variable.ends[to].map_or(outside, |(sum, sign)| state(sum, -sign * change));
                    found.push((here, Arc { variable: e as u32, change, to: there }));
                }
            }
        }
        let mut first = vec![0u32; outside as usize + 2];
        for (from, _) in &found {
            first[*from as usize + 1] += 1;
        }
        for s in 1..first.len() {
            first[s] += first[s - 1];
        }
        let mut at = first.clone();
        let mut arcs = vec![Arc { variable: 0, change: 0, to: 0 }; found.len()];
        for (from, arc) in found {
            arcs[at[from as usize] as usize] = arc;
            at[from as usize] += 1;
        }
        Self { variables, first, arcs }
    }

    pub(super) fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Raises a bound; the next solution keeps it.
    pub(super) fn raise(&mut self, variable: usize, least: i64) {
        self.variables[variable].least = least;
    }

    /// What a solution costs.
    #[cfg(test)]
    pub(super) fn cost(&self, x: &[i64]) -> f64 {
        self.variables.iter().zip(x).map(|(variable, &x)| variable.cost(x)).sum()
    }

    /// Values with sums of 0, from `start`; `None` if there are none within the bounds. Each wrong sum costs a search of
    /// its surroundings, each improvement some passes over all arcs.
    pub(super) fn solve(&self, ctx: &RunContext, start: &[i64]) -> Result<Option<Vec<i64>>, Cancelled> {
        let mut x: Vec<i64> = self.variables.iter().zip(start).map(|(variable, &x)| x.max(variable.least)).collect();
        if !self.balance(&ctx.span(0.0, 0.5), &mut x)? {
            return Ok(None);
        }
        self.cancel_cycles(&ctx.span(0.5, 1.0), &mut x)?;
        ctx.advance(1.0);
        Ok(Some(x))
    }

    fn n_states(&self) -> usize {
        self.first.len() - 1
    }

    fn arcs_of(&self, state: u32) -> std::ops::Range<usize> {
        self.first[state as usize] as usize..self.first[state as usize + 1] as usize
    }

    /// The sums.
    fn sums(&self, x: &[i64]) -> Vec<i64> {
        let mut sums = vec![0; self.n_states() / 2];
        for (variable, &x) in self.variables.iter().zip(x) {
            for (sum, sign) in variable.ends.iter().flatten() {
                sums[*sum as usize] += sign * x;
            }
        }
        sums
    }

    /// Makes all sums 0 by shortest walks between wrong ones.
    fn balance(&self, ctx: &RunContext, x: &mut [i64]) -> Result<bool, Cancelled> {
        let mut sums = self.sums(x);
        let mut search = PathSearch::new(self.n_states());
        for sum in 0..sums.len() {
            while sums[sum] != 0 {
                ctx.check()?;
                ctx.advance(sum as f64 / sums.len() as f64);
                let Some((walk, end)) = self.shortest(x, &sums, sum, &mut search) else { return Ok(false) };
                for &a in &walk {
                    let arc = self.arcs[a as usize];
                    x[arc.variable as usize] += arc.change;
                }
                sums[sum] -= sums[sum].signum();
                if let Some(end) = end {
                    sums[end] -= sums[end].signum();
                }
            }
        }
        Ok(true)
    }

    /// The cheapest walk from a wrong sum to another one, or to outside, and that one. Steps that gain something count as
    /// free: gains are for cycles to find.
    fn shortest(
        &self,
        x: &[i64],
        sums: &[i64],
        sum: usize,
        search: &mut PathSearch,
    ) -> Option<(Vec<u32>, Option<usize>)> {
        let outside = self.n_states() as u32 - 1;
        let mut banned: Vec<u32> = Vec::new();
        'search: loop {
            search.clear();
            let source = 2 * sum as u32 + u32::from(sums[sum] > 0);
            search.start(source, 0.0);
            while let Some((distance, state)) = search.nearest() {
                let at = (state / 2) as usize;
                // The walk may end where a sum is wrong the right way; where it began, one unit is taken already.
                let needed = if at == sum { 2 } else { 1 };
                let sign = if state % 2 == 0 { 1 } else { -1 };
                if state == outside || sums[at] * sign >= needed {
                    let walk = search.steps(state);
                    // A walk through an edge twice may leave its bounds.
                    if let Some(bad) = self.leaves_bounds(x, &walk) {
                        banned.push(bad);
                        continue 'search;
                    }
                    return Some((walk, (state != outside).then_some(at)));
                }
                for a in self.arcs_of(state) {
                    let arc = self.arcs[a];
                    let step = self.variables[arc.variable as usize].marginal(x[arc.variable as usize], arc.change);
                    if step.is_finite() && !banned.contains(&(a as u32)) {
                        search.reach(arc.to, distance + step.max(0.0), a as u32, state);
                    }
                }
            }
            return None;
        }
    }

    fn leaves_bounds(&self, x: &[i64], walk: &[u32]) -> Option<u32> {
        let mut change: BTreeMap<u32, i64> = BTreeMap::new();
        for &a in walk {
            let arc = self.arcs[a as usize];
            let sum = change.entry(arc.variable).or_default();
            *sum += arc.change;
        }
        let bad = |&(&e, &by): &(&u32, &i64)| x[e as usize] + by < self.variables[e as usize].least;
        let variable = *change.iter().find(bad)?.0;
        walk.iter().rev().copied().find(|&a| self.arcs[a as usize].variable == variable)
    }

    /// Takes away negative cycles until there are none, or only such as use an edge twice. Only states whose label or
    /// steps have changed are looked at again: the others would change nothing.
    fn cancel_cycles(&self, ctx: &RunContext, x: &mut [i64]) -> Result<(), Cancelled> {
        let n = self.n_states();
        let mut banned = vec![false; self.arcs.len()];
        // Any labels will do to begin with; those of the round before are nearly right.
        let mut distance = vec![0.0f64; n];
        let mut step = vec![f64::NAN; self.arcs.len()];
        let mut dirty = States::new(n);
        let mut parents = Parents::new(n);
        for _ in 0..MOST_ROUNDS {
            ctx.check()?;
            ctx.attempt(SHARE_OF_ROUND).advance(1.0);
            for state in 0..n as u32 {
                for a in self.arcs_of(state) {
                    let arc = self.arcs[a];
                    let now = match banned[a] {
                        true => f64::INFINITY,
                        false => self.variables[arc.variable as usize].marginal(x[arc.variable as usize], arc.change),
                    };
                    if now != std::mem::replace(&mut step[a], now) {
                        dirty.insert(state);
                    }
                }
            }
            parents.clear();
            let mut cycles = Vec::new();
            for pass in 0..n {
                let mut is_still = true;
                let mut next = 0;
                while let Some(state) = dirty.take_from(next) {
                    next = state + 1;
                    let here = distance[state as usize];
                    for a in self.arcs_of(state) {
                        let there = here + step[a];
                        let to = self.arcs[a].to;
                        if there < distance[to as usize] - LEAST_GAIN {
                            distance[to as usize] = there;
                            parents.set(to, (state, a as u32));
                            dirty.insert(to);
                            is_still = false;
                        }
                    }
                }
                if is_still {
                    return Ok(());
                }
                if pass % 4 == 3 {
                    ctx.check()?;
                    cycles = parents.cycles();
                    if !cycles.is_empty() {
                        break;
                    }
                }
            }
            if cycles.is_empty() {
                return Ok(());
            }
            let mut is_changed = false;
            for cycle in cycles {
                if self.gain(x, &cycle) > LEAST_GAIN {
                    is_changed = true;
                    for &a in &cycle {
                        let arc = self.arcs[a as usize];
                        x[arc.variable as usize] += arc.change;
                        // What did not pay may do so now.
                        banned[a as usize] = false;
                    }
                } else if let Some(&a) = cycle.iter().find(|&&a| !banned[a as usize] && self.is_twice(&cycle, a)) {
                    is_changed = true;
                    banned[a as usize] = true;
                }
            }
            if !is_changed {
                return Ok(());
            }
        }
        Ok(())
    }

    /// What is gained by the steps all together; negative if they leave the bounds.
    fn gain(&self, x: &[i64], walk: &[u32]) -> f64 {
        let mut change: BTreeMap<u32, i64> = BTreeMap::new();
        for &a in walk {
            *change.entry(self.arcs[a as usize].variable).or_default() += self.arcs[a as usize].change;
        }
        let gain = |(&e, &by): (&u32, &i64)| {
            let (variable, x) = (&self.variables[e as usize], x[e as usize]);
            if x + by < variable.least { f64::NEG_INFINITY } else { variable.cost(x) - variable.cost(x + by) }
        };
        change.iter().map(gain).sum()
    }

    fn is_twice(&self, walk: &[u32], a: u32) -> bool {
        let variable = self.arcs[a as usize].variable;
        walk.iter().filter(|&&b| self.arcs[b as usize].variable == variable).count() > 1
    }
}
