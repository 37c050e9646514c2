//! Shares of the progress of a run, with atomics only.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use crate::engine::run::stage::Stage;

/// The whole run in units of progress.
const WHOLE: u64 = 1 << 40;
/// Smaller advances are not worth the atomics.
const MIN_ADVANCE: u64 = WHOLE >> 14;
/// What rounding shares to whole units comes to, at most.
const ROUNDING: u64 = WHOLE >> 20;

/// A share of the progress of a run.
#[derive(Debug)]
pub(super) struct Scope {
    share: u64,
    /// How much of it was told, by itself or from below.
    told: AtomicU64,
    /// The stages that have begun in it, one bit each.
    begun: AtomicU32,
    above: Option<Arc<Scope>>,
}

impl Scope {
    fn new(share: u64, above: Option<Arc<Scope>>) -> Self {
        Self { share, told: AtomicU64::new(0), begun: AtomicU32::new(0), above }
    }

    /// The scope of a whole run.
    pub(super) fn whole() -> Self {
        Self::new(WHOLE, None)
    }

    /// A part of this share of the whole scope, or of what is left of it if that is less.
    pub(super) fn part(self: &Arc<Self>, share: f64) -> Arc<Self> {
        let share = (share.clamp(0.0, 1.0) * self.share as f64) as u64;
        self.part_of(share)
    }

    /// A part of this share of what is left.
    pub(super) fn part_of_rest(self: &Arc<Self>, share: f64) -> Arc<Self> {
        let share = (share.clamp(0.0, 1.0) * self.left() as f64) as u64;
        self.part_of(share)
    }

    fn part_of(self: &Arc<Self>, share: u64) -> Arc<Self> {
        Arc::new(Self::new(share.min(self.left()), Some(self.clone())))
    }

    /// Notes that a stage begins; whether it is the first time.
    pub(super) fn begins(&self, stage: Stage) -> bool {
        let bit = 1 << stage as u32;
        self.begun.fetch_or(bit, Ordering::AcqRel) & bit == 0
    }

    fn left(&self) -> u64 {
        self.share - self.told.load(Ordering::Acquire)
    }

    /// At least this share of the scope is done. Where that is news, says how far the whole run is, in thousandths.
    pub(super) fn raise(&self, done: f64) -> Option<u32> {
        let to = (done.clamp(0.0, 1.0) * self.share as f64) as u64;
        if done < 1.0 && to < self.told.load(Ordering::Acquire) + MIN_ADVANCE {
            return None;
        }
        let more = to.saturating_sub(self.told.fetch_max(to, Ordering::AcqRel));
        (more > 0).then(|| self.tell(more))
    }

    /// One of `n` equal parts of the scope is done. Where that is news, says how far the whole run is, in thousandths.
    pub(super) fn add_one_of(&self, n: usize) -> Option<u32> {
        let more = self.add(self.share / n.max(1) as u64);
        (more > 0).then(|| self.tell(more))
    }

    /// Adds to what was told as far as the share goes; returns by how much.
    fn add(&self, more: u64) -> u64 {
        let sum = |told: u64| told.saturating_add(more).min(self.share);
        let mut before = self.told.load(Ordering::Acquire);
        while let Err(now) = self.told.compare_exchange_weak(before, sum(before), Ordering::AcqRel, Ordering::Acquire) {
            before = now;
        }
        sum(before) - before
    }

    /// Adds to all scopes above, and says how far the whole run is.
    fn tell(&self, mut more: u64) -> u32 {
        let mut scope = self;
        while let Some(above) = &scope.above {
            more = above.add(more);
            scope = above;
        }
        ((scope.told.load(Ordering::Acquire) + ROUNDING) * 1000 / WHOLE) as u32
    }
}
