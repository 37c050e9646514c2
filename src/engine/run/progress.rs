//! How far a run is: a tree of scopes, each of which owns a share of the one above.
//!
//! A scope tells how far its own work is, and knows nothing of what is around it. What it tells is added to every scope
//! above it: what runs side by side adds up, and the whole never falls. A stage takes its share of what is *left* of the
//! scope that it runs in, by the costs of the [`Plan`]: stages that are skipped, end early or come again move the shares
//! of those that follow, and nothing is ever told twice. The result of a run does not depend on any of it.

use std::sync::Arc;

use crate::engine::run::context::RunContext;
use crate::engine::run::plan::Plan;
use crate::engine::run::scope::Scope;
use crate::engine::run::stage::Stage;

impl RunContext {
    /// The work of this context is at least this far, 0 to 1.
    pub fn advance(&self, done: f64) {
        self.heard(self.scope.raise(done));
    }

    /// One of `n` equal steps of the work is done; they may run side by side.
    pub fn step(&self, n: usize) {
        self.heard(self.scope.add_one_of(n));
    }

    /// The part of the work between these two values of [`RunContext::advance`]; what comes before it is done.
    pub fn span(&self, from: f64, to: f64) -> Self {
        self.advance(from);
        self.within(self.scope.part(to - from))
    }

    /// Part `i` of `n` equal ones that follow each other.
    pub fn part(&self, i: usize, n: usize) -> Self {
        let n = n.max(1) as f64;
        self.span(i as f64 / n, (i + 1) as f64 / n)
    }

    /// A try that may fail, or may not be the last: its share of what is left. What it has not used at its end is left for
    /// others.
    pub fn attempt(&self, share: f64) -> Self {
        self.within(self.scope.part_of_rest(share))
    }

    /// Parts that run side by side and share what is left by these weights.
    pub fn side_by_side(&self, weights: &[f64]) -> Vec<Self> {
        let all = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        weights.iter().map(|weight| self.attempt(weight / all)).collect()
    }

    /// The same work, whose stages from now on share what is left by this plan.
    pub fn planned(&self, plan: Plan) -> Self {
        Self { plan, ..self.clone() }
    }

    /// The part of the work that is made of these stages of its plan.
    pub fn stages(&self, first: Stage, last: Stage) -> Self {
        self.attempt(self.plan.share(first, last))
    }

    fn within(&self, scope: Arc<Scope>) -> Self {
        Self { scope, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::engine::run::{Cancelled, Observer, StopReason};

    #[derive(Clone, Default)]
    struct Heard(Arc<Mutex<Vec<u32>>>);

    impl Observer for Heard {
        fn stage_begins(&self, _: Stage) {}
        fn stage_ends(&self, _: Stage) {}
        fn progress(&self, thousandths: u32) {
            self.0.lock().unwrap().push(thousandths);
        }
    }

    impl Heard {
        fn last(&self) -> u32 {
            self.0.lock().unwrap().iter().copied().max().unwrap_or_default()
        }
    }

    fn run() -> (RunContext, Heard) {
        let heard = Heard::default();
        (RunContext::new(0, heard.clone()), heard)
    }

    #[test]
    fn progress_never_falls_and_ends_at_the_whole() {
        let (ctx, heard) = run();
        for done in [0.1, 0.4, 0.2, 0.4, 0.9, 0.3, 2.0] {
            ctx.advance(done);
        }
        ctx.step(3);
        assert_eq!(*heard.0.lock().unwrap(), [100, 400, 900, 1000]);
    }

    #[test]
    fn spans_nest_and_keep_to_their_share() {
        let (ctx, heard) = run();
        let half = ctx.span(0.2, 0.7);
        assert_eq!(heard.last(), 200, "what comes before a span is done");
        let quarter = half.part(1, 2);
        assert_eq!(heard.last(), 450);
        quarter.advance(0.5);
        assert_eq!(heard.last(), 575);
        quarter.advance(7.0);
        quarter.step(1);
        half.step(1);
        assert_eq!(heard.last(), 700, "nobody tells more than is its own");
        ctx.advance(0.6);
        assert_eq!(heard.last(), 700);
    }

    #[test]
    fn what_runs_side_by_side_adds_up() {
        let (ctx, heard) = run();
        ctx.advance(0.2);
        let parts = ctx.side_by_side(&[3.0, 1.0]);
        parts[0].advance(0.5);
        assert_eq!(heard.last(), 500);
        std::thread::scope(|threads| {
            for part in parts.iter().flat_map(|part| vec![part; 10]) {
                threads.spawn(|| (0..100).for_each(|_| part.step(1000)));
            }
        });
        assert!((998..=1000).contains(&heard.last()), "{}", heard.last());
    }

    #[test]
    fn stages_share_what_is_left() {
        let (ctx, heard) = run();
        let plan = Plan::new(&[(Stage::Field, 6.0), (Stage::Map, 2.0), (Stage::Certify, 1.0)]).with_repeats(1.0);
        assert_eq!(plan.total(), 10.0);
        let ctx = ctx.planned(plan);
        let stage = |stage| ctx.stage(stage, |_| Ok::<_, Cancelled>(()));
        stage(Stage::Field).unwrap();
        assert_eq!(heard.last(), 600);
        // The map is skipped: half of what is left.
        stage(Stage::Certify).unwrap();
        assert_eq!(heard.last(), 800);
        stage(Stage::Certify).unwrap();
        assert_eq!(heard.last(), 800, "what comes again and has nothing to tell leaves its share to others");
        let again = |ctx: &RunContext| {
            ctx.advance(1.0);
            Ok::<_, Cancelled>(())
        };
        ctx.stage(Stage::Certify, again).unwrap();
        assert_eq!(heard.last(), 850, "half of the share that it had at first");
    }

    #[test]
    fn tries_that_fail_never_reach_the_whole() {
        let (ctx, heard) = run();
        let plan = Plan::new(&[(Stage::Field, 1.0), (Stage::Map, 1.0)]);
        for _ in 0..20 {
            let attempt = ctx.attempt(0.8).planned(plan);
            let field = attempt.stage(Stage::Field, |ctx| {
                ctx.advance(0.9);
                Ok::<_, Cancelled>(())
            });
            assert!(field.is_ok());
            let failed = attempt.stage(Stage::Map, |ctx| {
                ctx.advance(0.1);
                Err::<(), _>(Cancelled(StopReason::Client))
            });
            assert!(failed.is_err());
        }
        assert!((900..1000).contains(&heard.last()), "{}", heard.last());
        let steps = heard.0.lock().unwrap();
        assert_eq!((steps[0], steps[1], steps[2]), (360, 400, 440), "what a failed stage has not used is left");
    }
}
