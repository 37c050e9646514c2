//! Ctrl-C and SIGTERM: the first asks for an orderly end, the second ends the process at once.

use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::engine::run::{RunContext, StopReason};
use crate::service::cli::failure::Failure;

/// Exit code after an interruption.
pub(super) const INTERRUPTED: u8 = 130;

/// A runtime that serves nothing but signals and timers of a command.
pub(super) fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|error| Failure::Output(format!("cannot start: {error}")))
}

/// Resolves when the process is asked to end.
pub(super) async fn asked_to_end() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut term) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => {}
                _ = term.recv() => {}
            }
            return;
        }
    }
    // Without a handler the signal keeps its default effect, which is to end the process.
    if tokio::signal::ctrl_c().await.is_err() {
        std::future::pending::<()>().await;
    }
}

/// The run that is under way: whoever stops it stops all that come after it, too.
#[derive(Clone, Debug, Default)]
pub(super) struct CurrentRun(Arc<Mutex<Current>>);

#[derive(Debug, Default)]
struct Current {
    context: Option<RunContext>,
    stopped: Option<StopReason>,
}

impl CurrentRun {
    /// A run begins.
    pub(super) fn begin(&self, context: &RunContext) {
        let mut current = self.lock();
        if let Some(reason) = current.stopped {
            context.stop(reason);
        }
        current.context = Some(context.clone());
    }

    /// The run is over; its context is let go.
    pub(super) fn end(&self) {
        self.lock().context = None;
    }

    /// Stops the run and all later ones.
    pub(super) fn stop(&self, reason: StopReason) {
        let mut current = self.lock();
        current.stopped.get_or_insert(reason);
        if let Some(context) = &current.context {
            context.stop(reason);
        }
    }

    /// Whether runs were stopped.
    pub(super) fn is_stopped(&self) -> bool {
        self.lock().stopped.is_some()
    }

    fn lock(&self) -> MutexGuard<'_, Current> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Calls `stop` at the first signal and ends the process at the second.
pub(super) fn on_signal(stop: impl FnOnce() + Send + 'static) -> impl Future<Output = ()> + Send + 'static {
    async move {
        asked_to_end().await;
        stop();
        asked_to_end().await;
        std::process::exit(INTERRUPTED.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_stops_the_run_and_those_that_follow() {
        let runs = CurrentRun::default();
        let (first, second) = (RunContext::silent(), RunContext::silent());
        runs.begin(&first);
        assert!(first.stopped().is_none());
        runs.stop(StopReason::Client);
        runs.end();
        runs.begin(&second);
        assert_eq!([first.stopped(), second.stopped()], [Some(StopReason::Client); 2]);
        assert!(runs.is_stopped());
    }
}
