//! The search itself: batches of moves proposed by the derivative, kept only if the energy falls.

use crate::engine::field::branch::curl::{Curl, CurlEnergy};
use crate::engine::field::branch::moves::{Moves, Surroundings};
use crate::engine::field::cross_field::{CrossField, FieldError};
use crate::engine::run::RunContext;

/// What the search may do.
#[derive(Clone, Debug)]
pub struct BranchOptions {
    /// Whether pairs of branch points are created where they save more curl than they cost in rounding, and cancelled
    /// where they do not. Otherwise they only move, and their number never grows. None are created where there are none.
    pub create: bool,
    /// What a quarter of index costs, per quad and relative to `‖X‖²`; [`BranchOptions::PRICE`] is what it was measured at.
    pub price: f64,
}

impl BranchOptions {
    /// What a quarter of index adds to the energy of the rounded map, per quad and relative to `‖X‖²`: two coordinates,
    /// each off by 1/12 in the mean square, times their stiffness in the period matrix (`[kaelberer_2013]` 6.4).
    /// Measured on pairs that were created on six models: 0.15 to 0.5.
    pub const PRICE: f64 = 0.3;
}

/// How long the search may go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::engine::field) enum Effort {
    /// From any field to the best that it can find.
    Full,
    /// From a field that was searched on another mesh: only small moves.
    Touch,
}

/// What the search did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BranchSearch {
    /// Curl energy relative to `‖X‖²` before and after.
    pub energy: [f64; 2],
    /// Branch points before and after.
    pub points: [usize; 2],
    /// Factorisations.
    pub evaluations: usize,
    /// Batches kept.
    pub accepted: usize,
    /// The way down: the start and every batch kept.
    pub curve: Vec<SearchStep>,
}

impl BranchSearch {
    /// Adds what another search did with the result of this one.
    pub fn go_on(&mut self, mut next: Self) {
        if self.evaluations == 0 {
            *self = next;
            return;
        }
        if next.evaluations == 0 {
            return;
        }
        next.curve.iter_mut().for_each(|step| step.evaluations += self.evaluations);
        self.curve.append(&mut next.curve);
        (self.energy[1], self.points[1]) = (next.energy[1], next.points[1]);
        self.evaluations += next.evaluations;
        self.accepted += next.accepted;
    }
}

/// One state of the search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchStep {
    /// Factorisations until here.
    pub evaluations: usize,
    /// Curl energy relative to `‖X‖²`.
    pub energy: f64,
    /// Branch points.
    pub points: usize,
}

/// Faces times factorisations that one search may cost: about six seconds.
const WORK: usize = 1_500_000;
/// Factorisations at most.
const MAX_EVALUATIONS: usize = 80;
/// Factorisations at most where the field was searched before.
const TOUCHES: usize = 3;
/// Share of them for moving what is there, where pairs are created afterwards.
const MOVING_SHARE: f64 = 0.6;
/// Largest batch.
const MAX_BATCH: usize = 64;
/// Single moves that fail in a row before the search ends. With 3, 4, 6 the map of ujoint at 5,000 quads has 0.0080,
/// 0.0074, 0.0069 of curl after 52, 58, 84 factorisations; that of kitten, with 4 and 6, 0.0058 and 0.0057 after 52 and 86.
const MAX_FAILURES: usize = 4;
/// Most edges that a branch point is carried in one batch.
const MAX_STRIDE: usize = 6;
/// A phase ends when this many batches kept together have lowered the cost by less than [`MIN_PROGRESS`] of it.
const WINDOW: usize = 5;
const MIN_PROGRESS: f64 = 0.01;

/// Moves branch points until the energy no longer falls or the work is done. Every batch kept lowers the energy, so a
/// stop leaves the best state in `field`.
///
/// # Errors
/// [`FieldError`] if the run was stopped or a solve failed.
pub(in crate::engine::field) fn search_branch_points(
    ctx: &RunContext,
    around: &Surroundings<'_>,
    field: &mut CrossField,
    options: &BranchOptions,
    effort: Effort,
) -> Result<BranchSearch, FieldError> {
    let mesh = around.mesh;
    let is_full = effort == Effort::Full;
    let limit = (WORK / mesh.n_faces().max(1)).min(if is_full { MAX_EVALUATIONS } else { TOUCHES });
    let curl = Curl::new(mesh, around.frames, around.is_feature);
    if limit < 2 || curl.sides.owner.is_empty() {
        return Ok(BranchSearch::default());
    }
    let rest = field.angle.clone();
    around.turning.relax(mesh, around.frames, field, &rest);
    ctx.check()?;
    let energy = curl.energy(mesh, around.frames, field, None)?;
    let begun = SearchStep { evaluations: 1, energy: energy.value, points: field.singularities().len() };
    let mut done = BranchSearch {
        energy: [begun.energy; 2],
        points: [begun.points; 2],
        evaluations: 1,
        accepted: 0,
        curve: vec![begun],
    };
    // A surface that can do without any branch point keeps its perfect grid: evener squares are not worth its loss.
    let create = options.create && is_full && begun.points > 0;
    let share = if create { MOVING_SHARE } else { 1.0 };
    let first = (share * limit as f64) as usize;
    let mut search = Search { ctx: ctx.span(0.0, share), around, field, energy, rest, done: &mut done, limit: first };
    let start = Pace { batch: MAX_BATCH, stride: if is_full { MAX_STRIDE } else { 1 } };
    let mut moves = Moves::new(mesh, &curl, around);
    search.phase(&mut moves, start)?;
    if create {
        (search.ctx, search.limit) = (ctx.span(share, 1.0), limit);
        moves.price = Some(options.price * around.edge_length.powi(2) / around.frames.total_area(mesh));
        search.phase(&mut moves, Pace { batch: MAX_BATCH / 4, stride: 1 })?;
    }
    done.energy[1] = search.energy.value;
    done.points[1] = field.singularities().len();
    Ok(done)
}

/// How large the steps of a phase are.
struct Pace {
    /// Moves of one batch.
    batch: usize,
    /// Edges that a branch point is carried.
    stride: usize,
}

struct Search<'a> {
    ctx: RunContext,
    around: &'a Surroundings<'a>,
    field: &'a mut CrossField,
    energy: CurlEnergy,
    /// Angles that the alignment asks for.
    rest: Vec<f64>,
    done: &'a mut BranchSearch,
    limit: usize,
}

impl Search<'_> {
    /// Batches until the cost hardly falls any more.
    fn phase(&mut self, moves: &mut Moves<'_>, start: Pace) -> Result<(), FieldError> {
        let Pace { mut batch, mut stride } = start;
        let Surroundings { mesh, frames, turning, .. } = *self.around;
        let curl = moves.curl;
        let (begun, mut failures) = (self.done.evaluations, 0);
        // The first phase counts the evaluation of the field that it starts from.
        let first = usize::from(begun == 1);
        let mut history = vec![moves.cost(self.field, self.energy.value)];
        let mut derivative = curl.derivative(mesh, &self.energy, turning);
        let mut proposed = moves.propose(self.field, &derivative);
        // Rings of bound edges leave constant ψ without energy: beside them the energy jumps where a matching leaves its
        // whole turn, and the derivative is no guide. What failed alone would stand first in every batch again.
        let mut failed: Vec<usize> = Vec::new();
        while self.done.evaluations < self.limit && failures < MAX_FAILURES {
            self.ctx.check()?;
            // It mostly ends long before the limit.
            let left = 1.0 - (self.done.evaluations - begun + first) as f64 / (self.limit - begun + first) as f64;
            self.ctx.advance(1.0 - left * left);
            let chosen = moves.choose(&proposed, batch);
            if chosen.is_empty() {
                break;
            }
            let mut tried = self.field.clone();
            let predicted: f64 = chosen.iter().map(|m| moves.carry(&mut tried, m, &derivative, stride)).sum();
            turning.relax(mesh, frames, &mut tried, &self.rest);
            let next = curl.energy(mesh, frames, &tried, Some(&self.energy.factor))?;
            self.done.evaluations += 1;
            let (cost, last) = (moves.cost(&tried, next.value), history[history.len() - 1]);
            // A batch that gives little of what it promised holds moves that do harm: shorter and fewer ones find them.
            if cost - last < 0.05 * predicted {
                history.push(cost);
                (*self.field, self.energy) = (tried, next);
                let (evaluations, points) = (self.done.evaluations, self.field.singularities().len());
                self.done.curve.push(SearchStep { evaluations, energy: self.energy.value, points });
                self.done.accepted += 1;
                failures = 0;
                batch = (2 * batch).min(MAX_BATCH);
                stride = if cost - last < 0.4 * predicted { (stride + 1).min(MAX_STRIDE) } else { stride };
                derivative = curl.derivative(mesh, &self.energy, turning);
                proposed = moves.propose(self.field, &derivative);
                proposed.retain(|m| !failed.contains(&m.edge));
            } else {
                if stride > 1 {
                    stride /= 2;
                } else if chosen.len() > 1 {
                    batch = (chosen.len() / 3).max(1);
                } else {
                    failures += 1;
                    failed.push(chosen[0].edge);
                    proposed.retain(|m| !moves.share_an_end(m, &chosen[0]));
                }
            }
            let now = history[history.len() - 1];
            if history.len() > WINDOW && history[history.len() - 1 - WINDOW] - now < MIN_PROGRESS * now {
                break;
            }
        }
        Ok(())
    }
}
