//! The threads of the engine. tokio's threads never compute; these never wait for the network or the disk.

use std::panic::AssertUnwindSafe;

use rayon::ThreadPoolBuilder;
use tokio::sync::oneshot;

use crate::service::wire::Problem;

/// Pools of a fixed number of threads. Every run has a pool of its own: in a shared one, a thread that waits inside a
/// parallel loop of one run may pick up the whole of another run and not come back for minutes, deaf to cancellation.
#[derive(Clone, Copy, Debug)]
pub struct EnginePool {
    threads: usize,
}

impl EnginePool {
    /// Runs get `threads` threads each.
    pub fn new(threads: usize) -> Self {
        Self { threads: threads.max(1) }
    }

    /// Runs `work` on a pool. A panic is a bug of ours for this one call.
    pub async fn run<T: Send + 'static>(
        self,
        work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .thread_name(|n| format!("engine-{n}"))
            .stack_size(16 << 20)
            .build()
            .map_err(|error| {
                tracing::error!(%error, "the engine's threads cannot be started");
                Problem::internal()
            })?;
        let (tell, told) = oneshot::channel();
        let span = tracing::Span::current();
        pool.spawn(move || {
            let _ = tell.send(span.in_scope(|| guarded(work)));
        });
        told.await.unwrap_or_else(|_| Err(Problem::internal()))
    }
}

/// Short computations beside the runs: reading an upload, drawing a picture. They go to tokio's blocking threads, so
/// that they need not wait for a run that has all of the engine's threads.
pub async fn beside<T: Send + 'static>(
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
        let pool = EnginePool::new(2);
        let failed = pool.run(|| -> Result<(), Problem> { panic!("on purpose") }).await;
        assert_eq!(failed.unwrap_err().kind, ProblemKind::Internal);
        assert_eq!(pool.run(|| Ok(rayon::current_num_threads())).await, Ok(2));
        assert!(beside(|| -> Result<(), Problem> { panic!("on purpose") }).await.is_err());
    }
}
