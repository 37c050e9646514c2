//! What the stages of some work are expected to cost, and the shares that follow from it.

use crate::engine::run::stage::Stage;

/// What the stages of some work are expected to cost, in any one unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plan {
    costs: [f64; Stage::ALL.len()],
    again: f64,
}

impl Plan {
    /// Stages with their costs; all others cost nothing.
    pub fn new(costs: &[(Stage, f64)]) -> Self {
        let mut plan = Self::default();
        for &(stage, cost) in costs {
            plan.costs[stage as usize] += cost;
        }
        plan
    }

    /// The same plan, with this much kept for stages that come again after the last one.
    pub fn with_repeats(self, again: f64) -> Self {
        Self { again, ..self }
    }

    /// What all of it costs.
    pub fn total(&self) -> f64 {
        self.costs.iter().sum::<f64>() + self.again
    }

    /// What the stages from `first` to `last` cost, as a share of them and all that is to follow.
    pub(super) fn share(&self, first: Stage, last: Stage) -> f64 {
        let from = |stage: usize| self.costs[stage..].iter().sum::<f64>() + self.again;
        let (all, after) = (from(first as usize), from(last as usize + 1));
        if all > 0.0 { (all - after) / all } else { 0.0 }
    }
}
