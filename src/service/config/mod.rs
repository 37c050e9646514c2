//! Configuration: embedded `config/default.toml` < file < environment < flags, every value checked at start.
//!
//! All errors are reported at once. Keys of the environment begin with `QUADRILLE_`, nested ones are joined by `__`;
//! those that name no key are ignored, because container platforms set variables of that form on their own.

mod http;
mod load;
mod values;

pub use load::{ConfigError, Override};
pub use values::{Config, EngineConfig, HttpConfig, JobsConfig, LimitsConfig, LogConfig, LogFormat};
