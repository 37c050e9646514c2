//! The timer of a run.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use crate::engine::run::{RunContext, StopReason};

/// Stops the run with [`StopReason::Deadline`] unless dropped before.
#[derive(Debug)]
pub(super) struct Deadline {
    _wakes_the_timer_when_dropped: Sender<()>,
}

impl Deadline {
    /// Starts the timer. Without a thread for it the run goes on without a deadline, and the log says so.
    pub(super) fn start(context: RunContext, after: Duration) -> Self {
        let (alive, gone) = channel::<()>();
        let timer = std::thread::Builder::new().name("deadline".to_owned()).spawn(move || {
            if gone.recv_timeout(after) == Err(RecvTimeoutError::Timeout) {
                context.stop(StopReason::Deadline);
            }
        });
        if let Err(error) = timer {
            tracing::warn!(%error, "the run goes on without a deadline");
        }
        Self { _wakes_the_timer_when_dropped: alive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_stops_the_run_unless_it_is_over() {
        let late = RunContext::silent();
        let timer = Deadline::start(late.clone(), Duration::ZERO);
        while late.stopped().is_none() {
            std::thread::yield_now();
        }
        assert_eq!(late.stopped(), Some(StopReason::Deadline));
        drop(timer);
        let early = RunContext::silent();
        drop(Deadline::start(early.clone(), Duration::from_secs(3600)));
        assert_eq!(early.stopped(), None);
    }
}
