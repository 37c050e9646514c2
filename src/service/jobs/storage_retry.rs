//! Repeating what failed because of the storage: a disk that is full, a database that is locked.

use std::future::Future;
use std::time::Duration;

use backon::{ExponentialBuilder, Retryable};
use tokio_util::sync::CancellationToken;

use crate::service::store::StoreError;

const FIRST_PAUSE: Duration = Duration::from_millis(100);
/// Longest time until a storage that works again is found out.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// Repeats `work` while the storage fails, for `at_most` in all or without end, but not after `stop`.
pub(super) async fn retry_while_storage_fails<T, F>(
    at_most: Option<Duration>,
    stop: &CancellationToken,
    work: impl FnMut() -> F,
) -> Result<T, StoreError>
where
    F: Future<Output = Result<T, StoreError>>,
{
    let pauses = ExponentialBuilder::new()
        .with_min_delay(FIRST_PAUSE)
        .with_max_delay(LONGEST_PAUSE)
        .with_total_delay(at_most)
        .without_max_times();
    work.retry(pauses)
        .when(|error| error.is_of_storage() && !stop.is_cancelled())
        .notify(|error, pause| tracing::warn!(%error, ?pause, "the storage failed; trying again"))
        .await
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    async fn attempts(
        at_most: Option<Duration>,
        stopped: bool,
        failures: u32,
        error: fn() -> StoreError,
    ) -> (u32, bool) {
        let (stop, n) = (CancellationToken::new(), AtomicU32::new(0));
        if stopped {
            stop.cancel();
        }
        let work = || async { if n.fetch_add(1, Ordering::Relaxed) < failures { Err(error()) } else { Ok(()) } };
        let done = retry_while_storage_fails(at_most, &stop, work).await.is_ok();
        (n.into_inner(), done)
    }

    #[tokio::test]
    async fn only_a_storage_that_fails_is_tried_again_and_not_after_the_end() {
        let full = || StoreError::Queue("the disk is full".to_owned());
        let ours = || StoreError::Unsupported("a bug".to_owned());
        assert_eq!(attempts(None, false, 2, full).await, (3, true));
        assert_eq!(attempts(None, true, 2, full).await, (1, false));
        assert_eq!(attempts(None, false, 2, ours).await, (1, false));
        let (n, done) = attempts(Some(Duration::from_millis(400)), false, 1000, full).await;
        assert!((2..10).contains(&n) && !done, "{n}");
    }
}
