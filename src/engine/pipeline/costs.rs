//! What the stages of a run are expected to cost, from which the shares of its progress follow.

use crate::engine::pipeline::spec::{RemeshSpec, Target};
use crate::engine::problem::Problem;
use crate::engine::run::{Plan, Stage};

/// Milliseconds per thousand triangles and per thousand quads. `cargo bench -- stages MODEL.obj …` fits and prints them; what
/// stands here was set by hand from the medians of 38 models of one part at 5,000 quads. Optimisation, certificate and
/// writing stand below that, which counts what they do again; the field stands above it, since it varies most. Only the
/// ratios count.
const COSTS: [(Stage, f64, f64); Stage::ALL.len()] = [
    (Stage::Read, 0.4, 0.0),
    (Stage::Condition, 2.5, 5.0),
    (Stage::Features, 1.0, 15.0),
    (Stage::Refine, 4.0, 170.0),
    (Stage::Field, 0.0, 1200.0),
    (Stage::Map, 0.0, 140.0),
    (Stage::Round, 0.0, 140.0),
    (Stage::Extract, 0.0, 9.0),
    (Stage::Fallback, 2.0, 50.0),
    (Stage::Optimise, 12.0, 230.0),
    (Stage::Certify, 7.0, 70.0),
    (Stage::Write, 0.2, 20.0),
];
/// Share of the field that is left where no branch points are searched for.
const FIELD_ALONE: f64 = 0.23;
/// What mending and judging once more costs, relative to the first time.
const AGAIN: f64 = 0.75;

/// A try at a component gets this share of what is left: most components need no second one.
pub(super) const FIRST_TRY: f64 = 0.95;

/// What a model, or one component of it, is expected to cost.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Triangles of the input.
    pub triangles: f64,
    /// Quads that are asked for.
    pub quads: f64,
}

impl Size {
    /// A model of so many triangles; where the spec asks for an edge length, the number of quads is a guess.
    pub fn of(triangles: f64, spec: &RemeshSpec) -> Self {
        let quads = match spec.target {
            Target::Quads(n) => n as f64,
            Target::EdgeLength(_) => 0.25 * triangles,
        };
        Self { triangles, quads }
    }

    pub(super) fn of_problem(problem: &Problem) -> Self {
        Self { triangles: problem.surface.mesh.n_faces() as f64, quads: problem.quads }
    }

    fn cost(&self, stage: Stage) -> f64 {
        let (_, per_triangle, per_quad) = COSTS[stage as usize];
        (per_triangle * self.triangles + per_quad * self.quads) / 1000.0
    }
}

/// A run from a file's bytes to `files` files.
pub fn plan_of_run(size: &Size, files: usize) -> Plan {
    let engine = plan_of_model(size, &RemeshSpec::default()).total();
    let write = size.cost(Stage::Certify) + files as f64 * size.cost(Stage::Write);
    Plan::new(&[(Stage::Read, size.cost(Stage::Read)), (Stage::Condition, engine), (Stage::Write, write)])
}

/// Share of the proof of what was written in the writing of `files` files.
pub fn share_of_proof(size: &Size, files: usize) -> f64 {
    let proof = size.cost(Stage::Certify);
    proof / (proof + files as f64 * size.cost(Stage::Write))
}

/// The engine's part: all components together.
pub(super) fn plan_of_model(size: &Size, spec: &RemeshSpec) -> Plan {
    let draft = Draft::ByMap { searched: spec.searches() };
    let components = plan_of_try(size, draft).total() / FIRST_TRY;
    let once = [Stage::Condition, Stage::Features, Stage::Certify, Stage::Write].map(|stage| (stage, size.cost(stage)));
    Plan::new(&[&once[..], &[(Stage::Refine, components)]].concat())
}

/// Where a try at a component gets its quads from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Draft {
    /// From a map, whose branch points are searched for or not.
    ByMap { searched: bool },
    /// Without a map.
    Plain,
}

/// One try at a component.
pub(super) fn plan_of_try(size: &Size, draft: Draft) -> Plan {
    use Stage::{Certify, Extract, Fallback, Field, Map, Optimise, Refine, Round};
    let field = match draft {
        Draft::ByMap { searched: false } => FIELD_ALONE,
        _ => 1.0,
    };
    let before: &[Stage] = match draft {
        Draft::ByMap { .. } => &[Refine, Field, Map, Round, Extract],
        Draft::Plain => &[Fallback],
    };
    let cost = |&stage: &Stage| (stage, size.cost(stage) * if stage == Field { field } else { 1.0 });
    let stages: Vec<(Stage, f64)> = before.iter().chain(&[Optimise, Certify]).map(cost).collect();
    Plan::new(&stages).with_repeats(AGAIN * (size.cost(Optimise) + size.cost(Certify)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_row_for_every_stage_in_order() {
        assert_eq!(COSTS.map(|(stage, ..)| stage), Stage::ALL);
    }

    #[test]
    fn a_larger_model_costs_more_and_a_search_too() {
        let (small, large) = (Size { triangles: 1e4, quads: 1e3 }, Size { triangles: 1e5, quads: 2e4 });
        let total = |size: &Size, searched| plan_of_try(size, Draft::ByMap { searched }).total();
        assert!(total(&small, false) < total(&small, true) && total(&small, true) < total(&large, true));
        let spec = RemeshSpec::default();
        assert!(plan_of_run(&small, 1).total() > plan_of_model(&small, &spec).total());
        assert!(plan_of_run(&small, 7).total() > plan_of_run(&small, 1).total());
    }
}
