//! Cancellation and progress of one run, with atomics only: the engine has no clock, so runs are reproducible and the
//! caller's timer decides about deadlines.

use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use crate::engine::run::plan::Plan;
use crate::engine::run::scope::Scope;
use crate::engine::run::stage::Stage;

/// Why a run was asked to stop. Of several reasons the one that stands first here counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum StopReason {
    /// The client cancelled.
    Client = 1,
    /// The process is shutting down; the job will be run again.
    Shutdown = 2,
    /// The time after the deadline, in which a result that is there may be finished, has passed, too.
    Overtime = 4,
    /// The deadline of the spec passed: return the best certified result so far, or fail.
    Deadline = 8,
}

impl StopReason {
    const ALL: [StopReason; 4] = [StopReason::Client, StopReason::Shutdown, StopReason::Overtime, StopReason::Deadline];
    /// What stops the last steps of a run.
    const OF_LATE_STEPS: u8 = StopReason::Client as u8 | StopReason::Shutdown as u8 | StopReason::Overtime as u8;
    /// What stops every other step.
    const USUAL: u8 = StopReason::OF_LATE_STEPS | StopReason::Deadline as u8;
}

/// Share of a stage that comes again, relative to that of the same stage at first.
const AGAIN: f64 = 0.5;

/// The run was asked to stop. Never logged as a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the run was stopped ({0:?})")]
pub struct Cancelled(pub StopReason);

/// What the caller hears while a run goes on. Called from any thread of the pool; must be cheap and must not block.
///
/// ```
/// use quadrille::engine::run::{Observer, RunContext, Stage};
///
/// struct Bar(std::sync::mpsc::Sender<u32>);
/// impl Observer for Bar {
///     fn stage_begins(&self, _: Stage) {}
///     fn stage_ends(&self, _: Stage) {}
///     fn progress(&self, thousandths: u32) { self.0.send(thousandths).ok(); }
/// }
/// let (bar, heard) = std::sync::mpsc::channel();
/// RunContext::new(0, Bar(bar)).advance(0.25);
/// assert_eq!(heard.recv(), Ok(250));
/// ```
pub trait Observer: Send + Sync {
    /// A stage began. Stages of different components overlap.
    fn stage_begins(&self, stage: Stage);
    /// A stage ended (also when it failed).
    fn stage_ends(&self, stage: Stage);
    /// The whole run is this far, in thousandths, monotone.
    fn progress(&self, thousandths: u32);
}

/// An observer that listens to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn stage_begins(&self, _: Stage) {}
    fn stage_ends(&self, _: Stage) {}
    fn progress(&self, _: u32) {}
}

impl Observer for Box<dyn Observer> {
    fn stage_begins(&self, stage: Stage) {
        (**self).stage_begins(stage);
    }

    fn stage_ends(&self, stage: Stage) {
        (**self).stage_ends(stage);
    }

    fn progress(&self, thousandths: u32) {
        (**self).progress(thousandths);
    }
}

/// Two listeners to one run.
struct Both {
    first: RunContext,
    second: Box<dyn Observer>,
}

impl Observer for Both {
    fn stage_begins(&self, stage: Stage) {
        self.first.shared.observer.stage_begins(stage);
        self.second.stage_begins(stage);
    }

    fn stage_ends(&self, stage: Stage) {
        self.first.shared.observer.stage_ends(stage);
        self.second.stage_ends(stage);
    }

    fn progress(&self, thousandths: u32) {
        self.first.advance(f64::from(thousandths) / 1000.0);
        self.second.progress(thousandths);
    }
}

pub(super) struct Shared {
    /// The [`StopReason`]s that were given so far, one bit each.
    stop: Arc<AtomicU8>,
    thousandths: AtomicU32,
    observer: Box<dyn Observer>,
}

/// The context of one run: a cheap handle shared by the engine, which asks [`RunContext::check`], and the caller, who
/// may [`RunContext::stop`] it.
///
/// ```
/// use quadrille::engine::run::{Cancelled, RunContext, StopReason};
///
/// let ctx = RunContext::silent();
/// let timer = ctx.clone();
/// assert_eq!(ctx.check(), Ok(()));
/// timer.stop(StopReason::Deadline);
/// assert_eq!(ctx.check(), Err(Cancelled(StopReason::Deadline)));
/// // What finishes a result that is there may go on.
/// assert_eq!(ctx.late().check(), Ok(()));
/// ```
#[derive(Clone)]
pub struct RunContext {
    pub(super) shared: Arc<Shared>,
    pub(super) scope: Arc<Scope>,
    pub(super) plan: Plan,
    pub(super) seed: u64,
    /// The [`StopReason`]s that stop this part of the run, one bit each.
    pub(super) heeds: u8,
}

impl Debug for RunContext {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RunContext").field("seed", &self.seed).field("stopped", &self.stopped()).finish()
    }
}

impl RunContext {
    /// A run with this seed that reports to this observer.
    pub fn new(seed: u64, observer: impl Observer + 'static) -> Self {
        Self::with(Arc::default(), seed, StopReason::USUAL, Box::new(observer))
    }

    fn with(stop: Arc<AtomicU8>, seed: u64, heeds: u8, observer: Box<dyn Observer>) -> Self {
        let shared = Arc::new(Shared { stop, thousandths: AtomicU32::new(0), observer });
        Self { shared, scope: Arc::new(Scope::whole()), plan: Plan::default(), seed, heeds }
    }

    /// The same run, with this seed, heard by one more observer. Whoever stops one of the two contexts stops both.
    pub fn also(&self, seed: u64, observer: impl Observer + 'static) -> Self {
        let both = Both { first: self.clone(), second: Box::new(observer) };
        Self::with(Arc::clone(&self.shared.stop), seed, self.heeds, Box::new(both))
    }

    /// The last steps of the same run, which finish a result that is there: the deadline does not stop them, everything
    /// else does.
    pub fn late(&self) -> Self {
        Self { heeds: StopReason::OF_LATE_STEPS, ..self.clone() }
    }

    /// A run that nobody watches, with seed 0.
    pub fn silent() -> Self {
        Self::new(0, Silent)
    }

    /// The seed of every random choice of the run.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Asks the run to stop at its next check.
    pub fn stop(&self, reason: StopReason) {
        self.shared.stop.fetch_or(reason as u8, Ordering::AcqRel);
    }

    /// The reason why this part of the run is to stop, if it is.
    pub fn stopped(&self) -> Option<StopReason> {
        let given = self.shared.stop.load(Ordering::Acquire) & self.heeds;
        if given == 0 {
            return None;
        }
        StopReason::ALL.into_iter().find(|&reason| given & reason as u8 != 0)
    }

    /// Fails if the run was asked to stop. Every loop that can exceed about 10 ms calls this.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.stopped().map_or(Ok(()), |reason| Err(Cancelled(reason)))
    }

    /// Runs one stage between its `stage_begins` and `stage_ends`, checking for a stop first. The work gets the context
    /// by which it tells how far it is: its share of the progress by the plan of this one. A stage that comes again in
    /// the same work mostly finds little to do, and other ones may follow it: its share is `AGAIN` of that, and what it
    /// has not told at its end is left for them.
    pub fn stage<T, E: From<Cancelled>>(
        &self,
        stage: Stage,
        work: impl FnOnce(&RunContext) -> Result<T, E>,
    ) -> Result<T, E> {
        self.check()?;
        self.shared.observer.stage_begins(stage);
        let comes_again = !self.scope.begins(stage);
        let share = self.plan.share(stage, stage);
        let within = self.attempt(if comes_again { AGAIN * share } else { share });
        let result = work(&within);
        if result.is_ok() && !comes_again {
            within.advance(1.0);
        }
        self.shared.observer.stage_ends(stage);
        result
    }

    /// Tells the observer if the whole run is further than before, in thousandths.
    pub(super) fn heard(&self, thousandths: Option<u32>) {
        if let Some(now) = thousandths
            && self.shared.thousandths.fetch_max(now, Ordering::AcqRel) < now
        {
            self.shared.observer.progress(now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_is_heard_after_the_deadline_too() {
        let ctx = RunContext::silent();
        assert_eq!(ctx.check(), Ok(()));
        ctx.stop(StopReason::Deadline);
        assert_eq!(ctx.check(), Err(Cancelled(StopReason::Deadline)));
        assert!(ctx.stage(Stage::Field, |_| Ok::<_, Cancelled>(())).is_err());
        let late = ctx.late();
        assert_eq!(late.check(), Ok(()));
        ctx.stop(StopReason::Overtime);
        assert_eq!(late.check(), Err(Cancelled(StopReason::Overtime)));
        ctx.stop(StopReason::Client);
        assert_eq!((ctx.stopped(), late.stopped()), (Some(StopReason::Client), Some(StopReason::Client)));
    }

    #[test]
    fn a_second_observer_hears_the_same_run() {
        #[derive(Default)]
        struct Ears(AtomicU32);
        impl Observer for Arc<Ears> {
            fn stage_begins(&self, _: Stage) {
                self.0.fetch_add(10_000, Ordering::Relaxed);
            }
            fn stage_ends(&self, _: Stage) {}
            fn progress(&self, thousandths: u32) {
                self.0.fetch_add(thousandths, Ordering::Relaxed);
            }
        }
        let (first, second) = (Arc::new(Ears::default()), Arc::new(Ears::default()));
        let outer = RunContext::new(1, first.clone());
        let inner = outer.also(2, second.clone());
        inner.stage(Stage::Field, |_| Ok::<_, Cancelled>(())).unwrap();
        inner.advance(0.257);
        inner.advance(0.1);
        for ears in [&first, &second] {
            assert_eq!(ears.0.load(Ordering::Relaxed), 10_257);
        }
        assert_eq!(inner.seed(), 2);
        outer.stop(StopReason::Deadline);
        assert_eq!(inner.check(), Err(Cancelled(StopReason::Deadline)));
        assert_eq!(inner.late().check(), Ok(()));
    }
}
