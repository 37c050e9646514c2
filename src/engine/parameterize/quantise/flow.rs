//! Minimum-deviation flow in a bidirected graph: integers as near as may be to real targets, with sums that vanish.
//!
//! Every variable occurs in at most two balance equations, each time with the coefficient +1 or −1. So the equations
//! are the nodes and the variables the edges of a bidirected graph: an edge may point into both of its ends, or out of
//! both. Solutions are changed by augmenting walks: each step changes the value of one edge by ±1, which balances the
//! node that the step leaves and passes the imbalance on to the node that it enters. Walks are searched for in the
//! double cover of the graph, whose states are pairs (node, sign of the change that the node needs).
//!
//! Differences from `[coudert_osmont_2024]`: a feasible solution is found by successive cheapest walks between unbalanced
//! nodes, not by a network simplex, and the optimum by cancelling negative cycles. The cost is quadratic, so a cycle that
//! changes an edge twice in the same direction costs more than the sum of its steps. The result is optimal except for
//! improvements that need such a cycle.

use std::collections::BTreeMap;

use crate::engine::numerics::PathSearch;
use crate::engine::parameterize::quantise::labels::{Parents, States};
use crate::engine::run::{Cancelled, RunContext};

/// An integer variable: an edge of the graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// The nodes (balance equations) in which it occurs, each with its coefficient ±1; a node may occur twice.
    pub ends: [Option<(u32, i64)>; 2],
    /// What it is to be near to.
    pub target: f64,
    /// Cost of the square of its deviation.
    pub weight: f64,
    /// Lower bound of its value.
    pub least: i64,
}

impl Variable {
    /// What a change by one costs here; infinite if it leaves the bounds.
    fn marginal_cost(&self, x: i64, change: i64) -> f64 {
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

/// The problem as a graph: the variables, and for each state the arcs out of it.
#[derive(Debug)]
pub struct Flow {
    variables: Vec<Variable>,
    /// Offsets: the arcs out of state `s` are `first[s]..first[s + 1]`. State 2 n: node n needs a positive change; 2 n + 1: a
    /// negative one. The last state stands for the free end of edges that have only one node.
    first: Vec<u32>,
    arcs: Vec<Arc>,
}

/// A cost counts as lower only if it is lower by more than this; smaller differences are rounding errors.
const MIN_GAIN: f64 = 1e-9;
/// Rounds of cancelling negative cycles at most; after that, the solution is returned as it is.
const MAX_ROUNDS: usize = 2_000;
/// Each round takes this share of what is left of the progress: there are tens of them.
const SHARE_OF_ROUND: f64 = 0.03;

impl Flow {
    /// The graph of `n_sums` balance equations, numbered from 0, and these variables.
    pub fn new(n_sums: usize, variables: Vec<Variable>) -> Self {
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

    /// Values that satisfy all balance equations, found from `start`; `None` if there are none within the bounds. Every
    /// unit of imbalance costs at least one local search for a walk, every improvement some passes over all arcs.
    ///
    /// # Errors
    /// [`Cancelled`] if the run was stopped.
    pub fn solve(&self, ctx: &RunContext, start: &[i64]) -> Result<Option<Vec<i64>>, Cancelled> {
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

    /// Per node, the left-hand side of its balance equation; 0 if balanced.
    fn imbalances(&self, x: &[i64]) -> Vec<i64> {
        let mut sums = vec![0; self.n_states() / 2];
        for (variable, &x) in self.variables.iter().zip(x) {
            for (sum, sign) in variable.ends.iter().flatten() {
                sums[*sum as usize] += sign * x;
            }
        }
        sums
    }

    /// Makes `x` satisfy all balance equations by cheapest walks between unbalanced nodes; false if it cannot.
    fn balance(&self, ctx: &RunContext, x: &mut [i64]) -> Result<bool, Cancelled> {
        let mut sums = self.imbalances(x);
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

    /// The cheapest walk from an unbalanced node to another one or to the state outside, and the node at its end
    /// (`None`: outside). Negative step costs count as 0: `cancel_cycles` exploits them later.
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
                // The walk may end at a node whose imbalance the arriving unit reduces. At the source this takes an
                // imbalance of at least 2: the start of the walk uses up one unit already.
                let needed = if at == sum { 2 } else { 1 };
                let sign = if state % 2 == 0 { 1 } else { -1 };
                if state == outside || sums[at] * sign >= needed {
                    let walk = search.steps(state);
                    // A walk through an edge twice may leave its bounds.
                    if let Some(bad) = self.arc_breaking_bound(x, &walk) {
                        banned.push(bad);
                        continue 'search;
                    }
                    return Some((walk, (state != outside).then_some(at)));
                }
                for a in self.arcs_of(state) {
                    let arc = self.arcs[a];
                    let step =
                        self.variables[arc.variable as usize].marginal_cost(x[arc.variable as usize], arc.change);
                    if step.is_finite() && !banned.contains(&(a as u32)) {
                        search.reach(arc.to, distance + step.max(0.0), a as u32, state);
                    }
                }
            }
            return None;
        }
    }

    fn arc_breaking_bound(&self, x: &[i64], walk: &[u32]) -> Option<u32> {
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
        for _ in 0..MAX_ROUNDS {
            ctx.check()?;
            ctx.attempt(SHARE_OF_ROUND).advance(1.0);
            for state in 0..n as u32 {
                for a in self.arcs_of(state) {
                    let arc = self.arcs[a];
                    let now = match banned[a] {
                        true => f64::INFINITY,
                        false => {
                            self.variables[arc.variable as usize].marginal_cost(x[arc.variable as usize], arc.change)
                        }
                    };
                    if now != std::mem::replace(&mut step[a], now) {
                        dirty.insert(state);
                    }
                }
            }
            parents.clear();
            let mut cycles = Vec::new();
            for pass in 0..n {
                let mut has_converged = true;
                let mut next = 0;
                while let Some(state) = dirty.take_from(next) {
                    next = state + 1;
                    let here = distance[state as usize];
                    for a in self.arcs_of(state) {
                        let there = here + step[a];
                        let to = self.arcs[a].to;
                        if there < distance[to as usize] - MIN_GAIN {
                            distance[to as usize] = there;
                            parents.set(to, (state, a as u32));
                            dirty.insert(to);
                            has_converged = false;
                        }
                    }
                }
                if has_converged {
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
                if self.gain(x, &cycle) > MIN_GAIN {
                    is_changed = true;
                    for &a in &cycle {
                        let arc = self.arcs[a as usize];
                        x[arc.variable as usize] += arc.change;
                        // What did not pay may do so now.
                        banned[a as usize] = false;
                    }
                } else if let Some(&a) = cycle.iter().find(|&&a| !banned[a as usize] && self.uses_edge_twice(&cycle, a))
                {
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

    /// Decrease of the cost by all steps together; −∞ if a value would fall below its lower bound.
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

    fn uses_edge_twice(&self, walk: &[u32], a: u32) -> bool {
        let variable = self.arcs[a as usize].variable;
        walk.iter().filter(|&&b| self.arcs[b as usize].variable == variable).count() > 1
    }
}
