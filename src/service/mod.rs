//! Everything with a socket, a timer or a wire format.

pub mod app;
pub mod cli;
pub mod config;
pub mod formats;
pub mod http;
pub mod jobs;
pub mod preview;
pub mod run;
pub mod store;
pub mod telemetry;
mod time_left;
pub mod wire;
