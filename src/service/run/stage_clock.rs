//! The seconds of every stage.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::run::{Observer, Stage};

/// One stage: how often it is under way now, since when, and how long it was before.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    active: u32,
    since: Option<Instant>,
    total: Duration,
    seen: bool,
}

/// A clock per stage. It runs while at least one component of the model is in that stage, so the sum may exceed the
/// time of the run, but no stage does.
#[derive(Clone, Debug, Default)]
pub(super) struct StageClock(Arc<Mutex<[Entry; Stage::ALL.len()]>>);

impl StageClock {
    fn with(&self, stage: Stage, change: impl FnOnce(&mut Entry)) {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut entries[stage as usize]);
    }

    /// Stages that were met, in order, with their milliseconds.
    pub(super) fn timings_ms(&self) -> Vec<(&'static str, f64)> {
        let entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let ms = |entry: &Entry| {
            let running = entry.since.map_or(Duration::ZERO, |since| since.elapsed());
            (entry.total + running).as_secs_f64() * 1000.0
        };
        let met = Stage::ALL.iter().zip(entries.iter()).filter(|(_, entry)| entry.seen);
        met.map(|(stage, entry)| (stage.name(), ms(entry))).collect()
    }
}

impl Observer for StageClock {
    fn stage_begins(&self, stage: Stage) {
        self.with(stage, |entry| {
            entry.seen = true;
            entry.active += 1;
            entry.since.get_or_insert_with(Instant::now);
        });
    }

    fn stage_ends(&self, stage: Stage) {
        self.with(stage, |entry| {
            entry.active = entry.active.saturating_sub(1);
            if entry.active == 0 {
                entry.total += entry.since.take().map_or(Duration::ZERO, |since| since.elapsed());
            }
        });
    }

    fn progress(&self, _: u32) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_listed_in_order_and_only_when_met() {
        let clock = StageClock::default();
        for stage in [Stage::Write, Stage::Field, Stage::Field] {
            clock.stage_begins(stage);
        }
        for stage in [Stage::Field, Stage::Write, Stage::Field] {
            clock.stage_ends(stage);
        }
        let names: Vec<_> = clock.timings_ms().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["field", "write"]);
        assert!(clock.0.lock().unwrap().iter().all(|entry| entry.since.is_none()));
    }
}
