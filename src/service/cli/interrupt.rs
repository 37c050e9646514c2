//! Ctrl-C and SIGTERM: the first asks for an orderly end, the second ends the process at once.

use std::future::Future;

use crate::service::cli::Failure;

/// Exit code after an interruption.
const INTERRUPTED: i32 = 130;

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

/// Calls `stop` at the first signal and ends the process at the second.
pub(super) fn on_signal(stop: impl FnOnce() + Send + 'static) -> impl Future<Output = ()> + Send + 'static {
    async move {
        asked_to_end().await;
        stop();
        asked_to_end().await;
        std::process::exit(INTERRUPTED);
    }
}
