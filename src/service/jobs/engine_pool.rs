//! The threads of the engine. tokio's threads never compute; these never wait for the network or the disk.

use std::panic::AssertUnwindSafe;
use std::time::Duration;

use rayon::ThreadPoolBuilder;
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep};

use crate::engine::run::{RunContext, StopReason};
use crate::service::wire::Problem;

/// Stack of an engine thread: recursive algorithms of libraries must not end the process.
const STACK_BYTES: usize = 16 << 20;
/// How long a run that was told to stop may take to notice. Few steps cannot look at their context (a factorisation, a
/// reader); the run is over for its client then, and its threads end by themselves.
const STOP_TIMEOUT: Duration = Duration::from_millis(300);
/// Between two looks at whether a run was told to stop.
const STOP_POLL: Duration = Duration::from_millis(50);

/// Pools of a fixed number of threads. Every run has a pool of its own: in a shared one, a thread that waits inside a
/// parallel loop of one run may pick up the whole of another run and not come back for minutes, in which it notices no
/// cancellation.
#[derive(Clone, Copy, Debug)]
pub struct EnginePool {
    threads: usize,
}

impl EnginePool {
    /// Runs get `threads` threads each; 0 are all cores.
    pub fn new(threads: usize) -> Self {
        Self { threads }
    }

    /// Does the work of one run on a pool. A panic is a bug of ours for this one call. A run that was stopped for good
    /// (not by its deadline alone) ends within 0.3 s, whether its work has noticed or not.
    pub async fn run<T: Send + 'static>(
        self,
        context: &RunContext,
        work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .thread_name(|n| format!("engine-{n}"))
            .stack_size(STACK_BYTES)
            .build()
            .map_err(|error| {
                tracing::error!(%error, "the engine's threads cannot be started");
                Problem::internal()
            })?;
        let (tell, told) = oneshot::channel();
        let (span, late) = (tracing::Span::current(), context.late());
        pool.spawn(move || {
            let _ = tell.send(span.in_scope(|| guarded(work)));
        });
        tokio::select! {
            biased;
            done = told => done.unwrap_or_else(|_| Err(Problem::internal())),
            reason = stopped_long_ago(&late) => {
                tracing::warn!(?reason, "the engine has not noticed that it was stopped; its threads are left to end");
                Err(Problem::stopped(reason))
            }
        }
    }
}

/// Resolves when a run was told to stop and [`STOP_TIMEOUT`] has passed since.
async fn stopped_long_ago(context: &RunContext) -> StopReason {
    let mut since: Option<(Instant, StopReason)> = None;
    loop {
        sleep(STOP_POLL).await;
        if let Some(reason) = context.stopped() {
            let (start, first) = *since.get_or_insert((Instant::now(), reason));
            if start.elapsed() >= STOP_TIMEOUT {
                return first;
            }
        }
    }
}

/// Short computations that belong to no run: reading an upload, drawing a picture. They go to tokio's blocking threads,
/// so that they need not wait for a run that has all of the engine's threads.
pub async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let span = tracing::Span::current();
    tokio::task::spawn_blocking(move || span.in_scope(|| guarded(work)))
        .await
        .unwrap_or_else(|_| Err(Problem::internal()))
}

fn guarded<T>(work: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    std::panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<String>().map(String::as_str);
        let what = what.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        tracing::error!(panic = what, "the engine panicked");
        Err(Problem::internal())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::wire::ProblemKind;

    #[tokio::test]
    async fn a_panic_is_a_problem_of_one_call_only() {
        let (pool, ctx) = (EnginePool::new(2), RunContext::silent());
        let failed = pool.run(&ctx, || -> Result<(), Problem> { panic!("on purpose") }).await;
        assert_eq!(failed.unwrap_err().kind, ProblemKind::Internal);
        assert_eq!(pool.run(&ctx, || Ok(rayon::current_num_threads())).await, Ok(2));
        assert!(run_blocking(|| -> Result<(), Problem> { panic!("on purpose") }).await.is_err());
    }

    #[tokio::test]
    async fn a_run_that_does_not_notice_its_stop_is_over_for_its_client() {
        let (end, ended) = std::sync::mpsc::channel::<()>();
        for (reason, kind) in [
            (StopReason::Client, ProblemKind::Cancelled),
            (StopReason::Shutdown, ProblemKind::ShuttingDown),
            (StopReason::Overtime, ProblemKind::DeadlineExceeded),
        ] {
            let ctx = RunContext::silent();
            let (end_of_work, wait) = std::sync::mpsc::channel::<()>();
            ctx.stop(reason);
            let start = Instant::now();
            let stopped = EnginePool::new(1).run(&ctx, move || Ok(wait.recv().is_ok())).await;
            assert_eq!(stopped.unwrap_err().kind, kind);
            assert!(start.elapsed() < Duration::from_secs(5));
            drop(end_of_work);
        }
        // The deadline alone leaves time to finish what is there.
        let ctx = RunContext::silent();
        ctx.stop(StopReason::Deadline);
        std::thread::spawn(move || {
            std::thread::sleep(2 * STOP_TIMEOUT);
            drop(end);
        });
        assert_eq!(EnginePool::new(1).run(&ctx, move || Ok(ended.recv().is_err())).await, Ok(true));
    }
}
