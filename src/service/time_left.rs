//! How long a run still takes, from how far it was when.
//!
//! The engine tells shares of work and has no clock. The speed is taken over the whole run so far and over its last part:
//! the first evens out stages that were cheaper or dearer than expected, the second notices that the rest of the run goes
//! at another pace. The first counts for more until near the end: a slow stretch is mostly one stage that was dearer on
//! this model, and says little of the stages after it. The result is smoothed once more, as the moment at which the run
//! will be over.

use std::collections::VecDeque;
use std::time::Duration;

/// Nothing is told before the run has gone this far and taken this long.
const EARLIEST: (f64, Duration) = (0.02, Duration::from_millis(500));
/// Share of the time so far that counts as the last part.
const LAST_PART: f64 = 0.3;
/// Weight of the speed of the last part against that of the whole, times the square of the progress: early it is one
/// stage of many, near the end what is left is like it.
const WEIGHT_OF_LAST: f64 = 0.8;
/// How soon a new estimate of the end replaces the old one, as a share of the time so far.
const INERTIA: f64 = 0.1;
/// Steps of progress that are remembered.
const REMEMBERED: usize = 256;

/// The estimate of one run.
#[derive(Clone, Debug, Default)]
pub(in crate::service) struct TimeLeft {
    /// Seconds and share of the work, oldest first.
    past: VecDeque<(f64, f64)>,
    /// When the run will be over, in seconds from its start, and when that was estimated.
    end: Option<(f64, f64)>,
}

impl TimeLeft {
    /// Notes that the run is this far, 0 to 1, after this long, and says how many seconds are left if that can be told.
    pub(in crate::service) fn at(&mut self, elapsed: Duration, progress: f64) -> Option<f64> {
        let now = elapsed.as_secs_f64();
        if self.past.back().is_none_or(|last| last.1 < progress) {
            self.past.push_back((now, progress));
            if self.past.len() > REMEMBERED {
                // Every other one, so that the start is never forgotten.
                self.past = self.past.iter().copied().step_by(2).collect();
            }
        }
        if progress >= 1.0 {
            return Some(0.0);
        }
        if progress < EARLIEST.0 || elapsed < EARLIEST.1 {
            return None;
        }
        let from = now * (1.0 - LAST_PART);
        let before = self.past.iter().rev().find(|past| past.0 <= from).copied().unwrap_or_default();
        let (whole, last) = (progress / now, (progress - before.1) / (now - before.0));
        let weight = WEIGHT_OF_LAST * progress * progress;
        let speed = whole.powf(1.0 - weight) * last.max(0.1 * whole).powf(weight);
        let end = now + (1.0 - progress) / speed;
        let end = match self.end {
            None => end,
            Some((old, then)) => old + (end - old) * (1.0 - (-(now - then) / (INERTIA * now)).exp()),
        };
        self.end = Some((end, now));
        Some((end - now).max(0.0))
    }

    /// As [`TimeLeft::at`], in whole seconds for people and programs.
    pub(in crate::service) fn seconds(&mut self, elapsed: Duration, progress: f64) -> Option<u64> {
        self.at(elapsed, progress).map(|seconds| seconds.round() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimates(duration: f64, progress: impl Fn(f64) -> f64) -> Vec<(f64, Option<f64>)> {
        let mut left = TimeLeft::default();
        let times = (1..400).map(|i| f64::from(i) / 400.0 * duration);
        times.map(|t| (t, left.at(Duration::from_secs_f64(t), progress(t / duration)))).collect()
    }

    #[test]
    fn an_even_run_is_estimated_exactly() {
        let told: Vec<_> =
            estimates(40.0, |share| share).into_iter().filter_map(|(t, left)| Some((t, left?))).collect();
        assert!(told.len() > 350);
        assert!(told.iter().all(|&(t, left)| (t + left - 40.0).abs() < 1e-6));
    }

    #[test]
    fn a_run_that_slows_down_is_noticed_in_time() {
        // The first tenth of the time does three tenths of the work.
        let uneven = |share: f64| if share < 0.1 { 3.0 * share } else { 0.3 + (share - 0.1) * 7.0 / 9.0 };
        for (t, left) in estimates(60.0, uneven).into_iter().filter(|(t, _)| (25.0..58.0).contains(t)) {
            let left = left.unwrap();
            assert!((left - (60.0 - t)).abs() < 0.4 * (60.0 - t), "{left} of {} s left", 60.0 - t);
        }
    }

    #[test]
    fn one_slow_stage_is_not_taken_for_the_rest() {
        // Between a fifth and two fifths of the time all goes at half the speed.
        let uneven = |share: f64| match share {
            s if s < 0.2 => 1.5 * s,
            s if s < 0.4 => 0.3 + 0.5 * (s - 0.2),
            s => s,
        };
        for (t, left) in estimates(60.0, uneven).into_iter().filter(|(t, _)| (20.0..58.0).contains(t)) {
            let left = left.unwrap();
            assert!((left - (60.0 - t)).abs() < 0.3 * (60.0 - t), "{left} of {} s left", 60.0 - t);
        }
    }

    #[test]
    fn nothing_is_told_too_early_and_never_less_than_nothing() {
        let mut left = TimeLeft::default();
        assert_eq!(left.at(Duration::from_millis(100), 0.5), None);
        assert_eq!(left.at(Duration::from_secs(3), 0.001), None);
        assert!(left.at(Duration::from_secs(4), 0.1).unwrap() > 0.0);
        assert!(left.at(Duration::from_secs(400), 0.1).unwrap() >= 0.0);
        assert_eq!(left.seconds(Duration::from_secs(500), 1.0), Some(0));
    }
}
