//! The configuration after it was checked.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use serde::Deserialize;

/// Everything that an operator may set.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Address and port of the HTTP server; port 0 is any free port.
    pub listen: SocketAddr,
    /// Folder for what has no place of its own.
    pub data: PathBuf,
    /// Database of the jobs, `sqlite://PATH`.
    pub database_url: String,
    /// Folder of uploads and results.
    pub store: PathBuf,
    /// Who may use the API from a browser.
    pub http: HttpConfig,
    /// The geometry engine.
    pub engine: EngineConfig,
    /// Limits.
    pub limits: LimitsConfig,
    /// Handling of jobs.
    pub jobs: JobsConfig,
    /// Logging.
    pub log: LogConfig,
}

/// Who may use the API from a browser.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HttpConfig {
    /// Origins whose pages may, as browsers write them: scheme, host, and a port other than the scheme's own.
    pub allowed_origins: Vec<String>,
    /// Names that the server is known under besides loopback names and its own address, without port; `*` is every name.
    pub allowed_hosts: Vec<String>,
}

/// The geometry engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EngineConfig {
    /// Threads, at least 1.
    pub threads: usize,
}

/// Limits on requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitsConfig {
    /// Most bytes of one upload, also after unpacking.
    pub upload_bytes: u64,
    /// Most vertices of one mesh.
    pub vertices: u64,
    /// Most triangles of one mesh.
    pub triangles: u64,
    /// Most jobs that may wait.
    pub queued_jobs: u64,
    /// Longest deadline in seconds.
    pub deadline_s: f64,
    /// Most open connections, at least 1.
    pub connections: usize,
    /// How long the head of a request may take, and the pause between two requests.
    pub headers: Duration,
    /// How long a body may send nothing and a client may read nothing.
    pub stalled: Duration,
}

/// Handling of jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobsConfig {
    /// Jobs that run at the same time in this process, at least 1.
    pub workers: usize,
    /// How often a job may begin, at least 1.
    pub max_attempts: u32,
    /// How long jobs and their files are kept after they end.
    pub retention: Duration,
    /// Time between two signs of life of a worker.
    pub heartbeat: Duration,
    /// Missed signs of life after which a worker is taken for dead, at least 1.
    pub missed_heartbeats: u32,
    /// How long a job waits for a storage that fails.
    pub storage_patience: Duration,
    /// How long running jobs and downloads may take to end when the process ends.
    pub shutdown_grace: Duration,
}

/// Logging.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogConfig {
    /// Directives of `tracing_subscriber::filter::Targets`: a level, or a level per target.
    pub filter: String,
    /// Form of a line.
    pub format: LogFormat,
}

/// Form of a log line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// For people.
    #[default]
    Text,
    /// One JSON object per line.
    Json,
}
