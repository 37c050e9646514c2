//! A server in this process, on its own folder and a free port.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use quadrille::service::app::{Role, Running, start, start_with};
use quadrille::service::config::Config;
use tempfile::TempDir;

use crate::client::Client;
use crate::scripted::Scripted;

pub(crate) struct Server {
    running: Running,
    pub(crate) client: Client,
}

/// Fast signs of life, so that a dead worker is found within seconds.
pub(crate) fn config(folder: &Path) -> Config {
    let mut config = Config::for_testing(folder);
    config.engine.threads = 2;
    config.jobs.heartbeat = Duration::from_secs(1);
    config.jobs.missed_heartbeats = 2;
    config.jobs.shutdown_grace = Duration::from_secs(20);
    config
}

impl Server {
    pub(crate) async fn scripted(config: Config) -> Self {
        let running = start_with(config, Role::All, Arc::new(Scripted)).await.expect("the server starts");
        Self { client: Client::new(format!("http://{}", running.address())), running }
    }

    /// With the real engine.
    pub(crate) async fn real(folder: &Path) -> Self {
        let running = start(config(folder), Role::All).await.expect("the server starts");
        Self { client: Client::new(format!("http://{}", running.address())), running }
    }

    pub(crate) async fn stop(self) {
        self.running.stop().await;
    }
}

/// A scripted server on a fresh folder.
pub(crate) async fn scripted() -> (TempDir, Server) {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::scripted(config(folder.path())).await;
    (folder, server)
}
