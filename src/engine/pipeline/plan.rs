//! Which attempt comes next: chosen from the table of remedies by what was wrong with the last one, as long as the budget
//! allows. Nothing here depends on the clock, the machine or its load.

use glam::DVec3;

use crate::engine::pipeline::attempt::Attempt;
use crate::engine::pipeline::costs::{Draft, Size, plan_of_try};
use crate::engine::pipeline::remedies::{Case, Diagnosis, REMEDIES, Uses};
use crate::engine::pipeline::spec::Effort;
use crate::engine::problem::{Optimise, Problem};
use crate::engine::run::{Budget, Cancelled, Plan as Costs, RunContext, Stage};

/// What may be spent on a component altogether, relative to the first attempt.
fn factor(effort: Effort) -> f64 {
    match effort {
        Effort::Fast => 1.0,
        Effort::Normal => 3.0,
        Effort::Thorough => 10.0,
    }
}

/// The plan of one component.
#[derive(Debug)]
pub(super) struct Plan {
    asked: Attempt,
    base: Problem,
    places: Vec<DVec3>,
    may_give_up: bool,
    budget: Budget,
    used: Vec<bool>,
    /// The last attempt, what was wrong with it, and how many places.
    last: Option<(Attempt, Diagnosis, usize)>,
    /// Fewest places that failed after an attempt with the base.
    fewest: usize,
    /// Whether the last attempt had smaller quads at some places, and fewer places failed.
    smaller_helped: bool,
}

/// What an attempt is expected to cost.
pub(super) fn costs(attempt: &Attempt) -> Costs {
    let size = Size::of_problem(&attempt.problem);
    let is_map = attempt.method.0.stages().contains(&Stage::Field);
    let draft = match is_map {
        true => Draft::ByMap { searched: attempt.problem.wishes.optimise != Optimise::None },
        false => Draft::Plain,
    };
    plan_of_try(&size, draft)
}

impl Plan {
    pub(super) fn new(asked: Attempt, effort: Effort, may_give_up: bool) -> Self {
        let budget = Budget::of(factor(effort) * costs(&asked).total());
        let base = asked.problem.clone();
        let used = vec![false; REMEDIES.len()];
        Self {
            asked,
            base,
            places: Vec::new(),
            may_give_up,
            budget,
            used,
            last: None,
            fewest: usize::MAX,
            smaller_helped: false,
        }
    }

    /// The next attempt; `None` if nothing more is worth trying or nothing is left to try.
    ///
    /// # Errors
    /// A stop.
    pub(super) fn next(&mut self, ctx: &RunContext) -> Result<Option<Attempt>, Cancelled> {
        let Some((last, diagnosis, _)) = &self.last else {
            let first = self.asked.clone();
            self.budget.spend(costs(&first).total());
            return Ok(Some(first));
        };
        for (remedy, used) in REMEDIES.iter().zip(&mut self.used) {
            let is_spent = *used && !(remedy.uses == Uses::WhileItHelps && self.smaller_helped);
            if is_spent || !remedy.helps.contains(diagnosis) {
                continue;
            }
            let case = Case {
                asked: &self.asked,
                base: &self.base,
                places: &self.places,
                last,
                diagnosis: *diagnosis,
                may_give_up: self.may_give_up,
            };
            let Some(attempt) = (remedy.attempt)(ctx, &case)? else { continue };
            let cost = costs(&attempt).total();
            *used = true;
            if self.budget.allows(cost) {
                self.budget.spend(cost);
                return Ok(Some(attempt));
            }
        }
        Ok(None)
    }

    /// Notes what was wrong with an attempt, and where. Smaller quads at some places stay where that left fewer of them.
    pub(super) fn learn(&mut self, attempt: &Attempt, diagnosis: Diagnosis, places: &[DVec3]) {
        let is_refined = attempt.problem.refined.len() > self.base.refined.len();
        self.smaller_helped = is_refined && places.len() < self.fewest;
        if self.smaller_helped {
            self.base.refined = attempt.problem.refined.clone();
            self.places = places.to_vec();
        } else {
            self.places.extend_from_slice(places);
        }
        if !places.is_empty() {
            self.fewest = self.fewest.min(places.len());
        }
        self.last = Some((attempt.clone(), diagnosis, places.len()));
    }
}
