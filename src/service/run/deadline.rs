//! The timer of a run.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::engine::run::{RunContext, StopReason};

/// What a result that is there at the deadline may take to be finished: half of what the contract allows (1 s and 10 %),
/// as stopping and storing take their time, too.
const OVERTIME: (Duration, f64) = (Duration::from_millis(500), 0.05);

/// Stops the run with [`StopReason::Deadline`], and a little later with [`StopReason::Overtime`], unless dropped before.
#[derive(Debug)]
pub(super) struct Deadline {
    alive: Option<Sender<()>>,
    timer: Option<JoinHandle<()>>,
}

impl Deadline {
    /// Starts the timer. Without a thread for it the run goes on without a deadline, and the log says so.
    pub(super) fn start(context: RunContext, after: Duration) -> Self {
        let (alive, gone) = channel::<()>();
        let timer = std::thread::Builder::new().name("deadline".to_owned()).spawn(move || {
            let overtime = OVERTIME.0 + after.mul_f64(OVERTIME.1);
            for (time, reason) in [(after, StopReason::Deadline), (overtime, StopReason::Overtime)] {
                if gone.recv_timeout(time) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
                context.stop(reason);
            }
        });
        if let Err(error) = &timer {
            tracing::warn!(%error, "the run goes on without a deadline");
        }
        Self { alive: Some(alive), timer: timer.ok() }
    }
}

impl Drop for Deadline {
    /// Wakes the timer and waits for it: afterwards nobody but the caller holds the context.
    fn drop(&mut self) {
        drop(self.alive.take());
        if let Some(timer) = self.timer.take() {
            // It cannot panic, and if it did there would be nothing to do about it here.
            let _ = timer.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn a_deadline_stops_the_run_unless_it_is_over() {
        let late = RunContext::silent();
        let timer = Deadline::start(late.clone(), Duration::ZERO);
        while late.stopped().is_none() {
            std::thread::yield_now();
        }
        assert_eq!((late.stopped(), late.late().stopped()), (Some(StopReason::Deadline), None));
        let finishing = late.late();
        let start = Instant::now();
        while finishing.stopped().is_none() && start.elapsed() < Duration::from_secs(20) {
            std::thread::yield_now();
        }
        assert_eq!(finishing.stopped(), Some(StopReason::Overtime));
        drop(timer);
        let early = RunContext::silent();
        drop(Deadline::start(early.clone(), Duration::from_secs(3600)));
        assert_eq!(early.stopped(), None);
    }
}
