//! Wall-clock time spent in each stage of a run.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::run::{Observer, Stage};

/// Timer of one stage: how many components are in it now, since when at least one is, and the time before that.
#[derive(Clone, Copy, Debug, Default)]
struct StageTimer {
    active: u32,
    since: Option<Instant>,
    total: Duration,
    was_entered: bool,
}

/// Wall-clock time per stage. The timer of a stage runs while at least one component of the model is in that stage.
/// Stages of different components overlap, so the times may add up to more than the duration of the run; no single time
/// exceeds it.
#[derive(Clone, Debug, Default)]
pub(super) struct StageClock(Arc<Mutex<[StageTimer; Stage::ALL.len()]>>);

impl StageClock {
    fn with(&self, stage: Stage, change: impl FnOnce(&mut StageTimer)) {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut entries[stage as usize]);
    }

    /// Milliseconds spent in each stage that was entered, in the order of [`Stage::ALL`]; running stages count up to
    /// now.
    pub(super) fn timings_ms(&self) -> Vec<(&'static str, f64)> {
        let entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let ms = |entry: &StageTimer| {
            let running = entry.since.map_or(Duration::ZERO, |since| since.elapsed());
            (entry.total + running).as_secs_f64() * 1000.0
        };
        let met = Stage::ALL.iter().zip(entries.iter()).filter(|(_, entry)| entry.was_entered);
        met.map(|(stage, entry)| (stage.name(), ms(entry))).collect()
    }
}

impl Observer for StageClock {
    fn stage_begins(&self, stage: Stage) {
        self.with(stage, |entry| {
            entry.was_entered = true;
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
