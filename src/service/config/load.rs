//! Merges the layers and checks the result.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

use config::{Environment, File, FileFormat};
use serde_json::Value;

use crate::service::config::http::{Names, is_host, is_origin};
use crate::service::config::{Config, EngineConfig, HttpConfig, JobsConfig, LimitsConfig, LogConfig, LogFormat};
use crate::service::wire::{Fields, Violation};

const DEFAULTS: &str = include_str!("../../../config/default.toml");

/// All reasons why the configuration cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the configuration cannot be used:{}", .0.iter().map(|v| format!("\n  {}: {}", v.pointer, v.message)).collect::<String>())]
pub struct ConfigError(pub Vec<Violation>);

impl ConfigError {
    fn whole(error: impl std::fmt::Display) -> Self {
        Self(vec![Violation::new("configuration", error.to_string())])
    }
}

/// A flag: dotted key and value.
pub type Override = (&'static str, String);

/// The keys as they may come in, before they are checked.
#[derive(Default)]
struct Raw {
    listen: String,
    data: String,
    database_url: String,
    store: String,
    allowed_origins: Names,
    allowed_hosts: Names,
    threads: usize,
    upload_bytes: u64,
    vertices: u64,
    triangles: u64,
    queued_jobs: u64,
    deadline_s: f64,
    connections: usize,
    headers_s: u64,
    stalled_s: u64,
    workers: usize,
    max_attempts: u32,
    retention_s: u64,
    heartbeat_ms: u64,
    missed_heartbeats: u32,
    storage_patience_s: u64,
    shutdown_grace_s: u64,
    filter: String,
    format: LogFormat,
}

impl Config {
    /// The configuration of this process: `file`, its environment, and flags.
    pub fn load(file: Option<&Path>, flags: &[Override]) -> Result<Self, ConfigError> {
        Self::from_layers(
            file,
            std::env::vars_os().filter_map(|(k, v)| Some((k.into_string().ok()?, v.into_string().ok()?))),
            flags,
        )
    }

    /// The embedded defaults.
    pub fn defaults() -> Self {
        Self::from_layers(None, [], &[]).expect("the embedded defaults are valid, which a test checks")
    }

    /// The embedded defaults on any free loopback port, with everything kept under `data`.
    pub fn for_testing(data: &Path) -> Self {
        let flags = [("listen", "127.0.0.1:0".to_owned()), ("data", data.to_string_lossy().into_owned())];
        Self::from_layers(None, [], &flags).expect("the embedded defaults are valid, which a test checks")
    }

    /// The same with an explicit environment.
    fn from_layers(
        file: Option<&Path>,
        environment: impl IntoIterator<Item = (String, String)>,
        flags: &[Override],
    ) -> Result<Self, ConfigError> {
        let known = known_keys();
        let environment = environment.into_iter().filter(|(name, _)| known.iter().any(|key| env_name(key) == *name));
        let mut builder = config::Config::builder().add_source(File::from_str(DEFAULTS, FileFormat::Toml));
        if let Some(path) = file {
            builder = builder.add_source(File::from(path).format(FileFormat::Toml));
        }
        let source = Environment::with_prefix("QUADRILLE")
            .prefix_separator("_")
            .separator("__")
            .source(Some(environment.collect()));
        builder = builder.add_source(source);
        for (key, value) in flags {
            builder = builder.set_override(*key, value.as_str()).map_err(ConfigError::whole)?;
        }
        let merged = builder.build().and_then(config::Config::try_deserialize::<Value>).map_err(ConfigError::whole)?;
        Self::from_value(merged).map_err(ConfigError)
    }

    fn from_value(mut merged: Value) -> Result<Self, Vec<Violation>> {
        let mut violations = Vec::new();
        let mut raw = Raw::default();
        for (table, read) in SECTIONS {
            let value = if table.is_empty() {
                let mut top = merged.clone();
                if let Value::Object(object) = &mut top {
                    object.retain(|key, _| !SECTIONS.iter().any(|(table, _)| table == key));
                }
                top
            } else {
                merged.get_mut(*table).map(Value::take).unwrap_or_default()
            };
            let value = typed(value).to_string();
            let pointer = if table.is_empty() { String::new() } else { format!("/{table}") };
            let mut fields = Fields::of(&value, &pointer, &mut violations);
            read(&mut fields, &mut raw);
            fields.finish();
        }
        let config = raw.check(&mut violations);
        for violation in &mut violations {
            violation.pointer = violation.pointer.trim_start_matches('/').replace('/', ".");
        }
        config.filter(|_| violations.is_empty()).ok_or(violations)
    }
}

type Section = (&'static str, fn(&mut Fields<'_, '_>, &mut Raw));

/// The tables of the file; the first is its top.
const SECTIONS: &[Section] = &[
    ("", |fields, raw| {
        fields.read("listen", &mut raw.listen);
        fields.read("data", &mut raw.data);
        fields.read("database_url", &mut raw.database_url);
        fields.read("store", &mut raw.store);
    }),
    ("http", |fields, raw| {
        fields.read("allowed_origins", &mut raw.allowed_origins);
        fields.read("allowed_hosts", &mut raw.allowed_hosts);
    }),
    ("engine", |fields, raw| fields.read("threads", &mut raw.threads)),
    ("limits", |fields, raw| {
        fields.read("upload_bytes", &mut raw.upload_bytes);
        fields.read("vertices", &mut raw.vertices);
        fields.read("triangles", &mut raw.triangles);
        fields.read("queued_jobs", &mut raw.queued_jobs);
        fields.read("deadline_s", &mut raw.deadline_s);
        fields.read("connections", &mut raw.connections);
        fields.read("headers_s", &mut raw.headers_s);
        fields.read("stalled_s", &mut raw.stalled_s);
    }),
    ("jobs", |fields, raw| {
        fields.read("workers", &mut raw.workers);
        fields.read("max_attempts", &mut raw.max_attempts);
        fields.read("retention_s", &mut raw.retention_s);
        fields.read("heartbeat_ms", &mut raw.heartbeat_ms);
        fields.read("missed_heartbeats", &mut raw.missed_heartbeats);
        fields.read("storage_patience_s", &mut raw.storage_patience_s);
        fields.read("shutdown_grace_s", &mut raw.shutdown_grace_s);
    }),
    ("log", |fields, raw| {
        fields.read("filter", &mut raw.filter);
        fields.read("format", &mut raw.format);
    }),
];

impl Raw {
    /// The configuration, or `None` with at least one violation.
    fn check(self, violations: &mut Vec<Violation>) -> Option<Config> {
        let mut refuse = |wrong: bool, key: &str, message: &str| {
            if wrong {
                violations.push(Violation::new(key, message));
            }
        };
        let listen = self.listen.parse();
        refuse(listen.is_err(), "listen", "must be an address and a port such as 127.0.0.1:8620");
        refuse(self.data.is_empty(), "data", "must be a folder");
        let data = PathBuf::from(&self.data);
        let database_url = if self.database_url.is_empty() {
            format!("sqlite://{}", data.join("jobs.sqlite").display())
        } else {
            self.database_url
        };
        refuse(!database_url.starts_with("sqlite:"), "database_url", "this version knows only sqlite://PATH");
        let store = self.store.strip_prefix("file://").unwrap_or(&self.store);
        refuse(store.contains("://"), "store", "this version knows only a local folder");
        let store = if store.is_empty() { data.join("objects") } else { PathBuf::from(store) };
        let Names(allowed_origins) = self.allowed_origins;
        let Names(allowed_hosts) = self.allowed_hosts;
        refuse(
            !allowed_origins.iter().all(|origin| is_origin(origin)),
            "http.allowed_origins",
            "must be origins as browsers write them, such as https://models.example.org",
        );
        refuse(
            !allowed_hosts.iter().all(|host| is_host(host)),
            "http.allowed_hosts",
            "must be names or addresses without scheme and port, such as quadrille.example.org, or *",
        );
        refuse(self.threads > 1024, "engine.threads", "must be at most 1024; 0 takes all cores");
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        let threads = if self.threads == 0 { cores } else { self.threads };
        refuse(self.upload_bytes == 0, "limits.upload_bytes", "must be at least 1");
        let indices = 1..=u64::from(u32::MAX / 4);
        refuse(!indices.contains(&self.vertices), "limits.vertices", "must be from 1 to 1073741823");
        refuse(!indices.contains(&self.triangles), "limits.triangles", "must be from 1 to 1073741823");
        refuse(
            !(self.deadline_s > 0.0 && self.deadline_s <= 86_400.0),
            "limits.deadline_s",
            "must be above 0 and at most 86400",
        );
        refuse(!(1..=100_000).contains(&self.connections), "limits.connections", "must be from 1 to 100000");
        refuse(!(1..=3600).contains(&self.headers_s), "limits.headers_s", "must be from 1 to 3600");
        refuse(!(1..=3600).contains(&self.stalled_s), "limits.stalled_s", "must be from 1 to 3600");
        refuse(!(1..=64).contains(&self.workers), "jobs.workers", "must be from 1 to 64");
        refuse(!(1..=100).contains(&self.max_attempts), "jobs.max_attempts", "must be from 1 to 100");
        refuse(self.retention_s == 0, "jobs.retention_s", "must be at least 1");
        refuse(!(100..=600_000).contains(&self.heartbeat_ms), "jobs.heartbeat_ms", "must be from 100 to 600000");
        refuse(!(1..=100).contains(&self.missed_heartbeats), "jobs.missed_heartbeats", "must be from 1 to 100");
        refuse(self.storage_patience_s > 604_800, "jobs.storage_patience_s", "must be at most 604800");
        refuse(self.shutdown_grace_s > 3600, "jobs.shutdown_grace_s", "must be at most 3600");
        let filter = self.filter.parse::<tracing_subscriber::filter::Targets>();
        refuse(filter.is_err(), "log.filter", "must be directives such as info,quadrille=debug");
        Some(Config {
            listen: listen.ok()?,
            data,
            database_url,
            store,
            http: HttpConfig { allowed_origins, allowed_hosts },
            engine: EngineConfig { threads },
            limits: LimitsConfig {
                upload_bytes: self.upload_bytes,
                vertices: self.vertices,
                triangles: self.triangles,
                queued_jobs: self.queued_jobs,
                deadline_s: self.deadline_s,
                connections: self.connections,
                headers: Duration::from_secs(self.headers_s),
                stalled: Duration::from_secs(self.stalled_s),
            },
            jobs: JobsConfig {
                workers: self.workers,
                max_attempts: self.max_attempts,
                retention: Duration::from_secs(self.retention_s),
                heartbeat: Duration::from_millis(self.heartbeat_ms),
                missed_heartbeats: self.missed_heartbeats,
                storage_patience: Duration::from_secs(self.storage_patience_s),
                shutdown_grace: Duration::from_secs(self.shutdown_grace_s),
            },
            log: LogConfig { filter: self.filter, format: self.format },
        })
    }
}

/// The dotted keys of the embedded file, which names every key there is.
fn known_keys() -> Vec<String> {
    let mut keys = Vec::new();
    let mut table = String::new();
    for line in DEFAULTS.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            table = format!("{name}.");
        } else if let Some((key, _)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) {
            keys.push(format!("{table}{key}"));
        }
    }
    keys
}

fn env_name(key: &str) -> String {
    format!("QUADRILLE_{}", key.replace('.', "__").to_ascii_uppercase())
}

/// Keys whose values are text even where it reads as a number.
const TEXTS: &[&str] =
    &["listen", "data", "database_url", "store", "allowed_origins", "allowed_hosts", "filter", "format"];

/// Flags and the environment are text: numbers among them become numbers.
fn typed(mut table: Value) -> Value {
    if let Value::Object(fields) = &mut table {
        for (key, value) in fields.iter_mut() {
            let textual = TEXTS.contains(&key.as_str());
            let number = value.as_str().filter(|_| !textual).and_then(|text| text.parse::<serde_json::Number>().ok());
            if let Some(number) = number {
                *value = Value::Number(number);
            }
        }
    }
    table
}

#[cfg(test)]
mod tests;
