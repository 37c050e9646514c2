//! Logs: one subscriber for the process, to stderr, as text or as JSON lines.

use std::io::stderr;

use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{fmt, registry};

use crate::service::config::{LogConfig, LogFormat};

/// Why logging could not be started.
#[derive(Debug, thiserror::Error)]
#[error("logging cannot be started: {0}")]
pub struct TelemetryError(String);

/// Starts logging; once per process.
pub fn start(config: &LogConfig) -> Result<(), TelemetryError> {
    let filter: Targets = config.filter.parse().map_err(|error| TelemetryError(format!("{error}")))?;
    let registry = registry().with(filter);
    let started = match config.format {
        LogFormat::Text => registry.with(fmt::layer().with_writer(stderr)).try_init(),
        LogFormat::Json => registry.with(fmt::layer().with_writer(stderr).json().flatten_event(true)).try_init(),
    };
    started.map_err(|error| TelemetryError(error.to_string()))
}
