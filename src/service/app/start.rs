//! Builds every part, one after another.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use crate::service::app::{AppError, Running};
use crate::service::config::Config;
use crate::service::http::{Access, HttpState, Readiness, router, serve};
use crate::service::jobs::{Driver, EnginePool, Jobs, Live, SqliteQueue, TicketQueue, Worker, sweep_until};
use crate::service::run::{EngineDriver, read_limits};
use crate::service::store::{Store, private_folder};

/// An upload that is older than this was left behind by a process that is gone.
const STALE_UPLOAD: Duration = Duration::from_secs(3600);

/// What a process does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// HTTP and jobs.
    All,
    /// Jobs only.
    Worker,
}

/// Starts the service; see [`Running`] for its end.
pub async fn start(config: Config, role: Role) -> Result<Running, AppError> {
    let limits = read_limits(&config.limits);
    start_with(config, role, Arc::new(EngineDriver { limits })).await
}

/// Starts the service with a driver of one's own; see [`Running`] for its end. Everything that can be wrong with the
/// configuration shows here and not later.
pub async fn start_with(config: Config, role: Role, driver: Arc<dyn Driver>) -> Result<Running, AppError> {
    let store = Store::open(&config.database_url, &config.store).await?;
    let queue = SqliteQueue::open(store.pool(), &config.jobs).await?;
    let live = Live::default();
    let jobs = Jobs {
        store: store.clone(),
        queue: queue.clone(),
        live: live.clone(),
        jobs: config.jobs,
        limits: config.limits,
    };
    let mut running = Running::new(store.clone(), live.clone(), config.jobs.shutdown_grace);
    let stop = running.stop_token();

    if role == Role::All {
        let uploads = uploads_folder(&config.data)?;
        let state = HttpState {
            jobs: jobs.clone(),
            driver: Arc::clone(&driver),
            access: Access::new(&config.http, config.listen.ip()),
            uploads,
            readiness: Arc::new(Readiness::default()),
            readers: Arc::new(Semaphore::new(config.engine.threads.max(2))),
            stop: stop.clone(),
        };
        let (listener, address) = listen(config.listen).await?;
        running.listens_on(address);
        running.add(serve(listener, router(state), config.limits, stop.clone()));
        tracing::info!(%address, "listening");
    }

    let worker = Worker {
        store,
        queue: queue.clone(),
        live,
        pool: EnginePool::new(config.engine.threads),
        driver,
        config: config.jobs,
        stop: stop.clone(),
    };
    let fetching = stop.clone();
    running.add(async move { queue.work(Arc::new(worker), fetching).await });
    running.add(sweep_until(jobs, stop));
    Ok(running)
}

async fn listen(address: SocketAddr) -> Result<(TcpListener, SocketAddr), AppError> {
    let failed = |source| AppError::Listen { address, source };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let actual = listener.local_addr().map_err(failed)?;
    Ok((listener, actual))
}

fn uploads_folder(data: &Path) -> Result<PathBuf, AppError> {
    let folder = data.join("uploads");
    let failed = |source| AppError::Folder { folder: folder.display().to_string(), source };
    private_folder(&folder).map_err(failed)?;
    for entry in std::fs::read_dir(&folder).map_err(failed)?.flatten() {
        let written = entry.metadata().and_then(|meta| meta.modified()).ok();
        let age = written.and_then(|written| SystemTime::now().duration_since(written).ok());
        if age.is_some_and(|age| age > STALE_UPLOAD) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
    Ok(folder)
}
