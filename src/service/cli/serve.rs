//! `quadrille serve`, `worker` and `openapi`.

use std::path::PathBuf;

use clap::Args;

use crate::service::app::{self, AppError, Role};
use crate::service::cli::failure::Failure;
use crate::service::cli::files::print;
use crate::service::cli::interrupt;
use crate::service::config::{Config, Override};
use crate::service::http;
use crate::service::telemetry;

/// Arguments of `serve` and `worker`: the configuration.
#[derive(Debug, Default, Args)]
pub(super) struct ServeArgs {
    /// Configuration file (TOML); single keys are overridden by QUADRILLE_… variables and by flags
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Address and port [default: 127.0.0.1:8620]
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(super) listen: Option<String>,
    /// Folder of the database and the store
    #[arg(long, value_name = "FOLDER")]
    pub(super) data: Option<String>,
    /// Database, sqlite://PATH
    #[arg(long, value_name = "URL")]
    pub(super) database_url: Option<String>,
    /// Folder of uploads and results
    #[arg(long, value_name = "FOLDER")]
    pub(super) store: Option<String>,
    /// Threads of the engine; 0: all cores
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<String>,
    /// Jobs that run at the same time
    #[arg(long, value_name = "N")]
    pub(super) workers: Option<String>,
    /// Log filter such as info,quadrille=debug
    #[arg(long, value_name = "FILTER")]
    pub(super) log: Option<String>,
    /// text or json
    #[arg(long, value_name = "FORMAT")]
    pub(super) log_format: Option<String>,
}

impl ServeArgs {
    /// The checked configuration; `defaults` are weaker than flags and stronger than everything else.
    pub(super) fn config(&self, defaults: &[Override]) -> Result<Config, Failure> {
        let flags = [
            ("listen", &self.listen),
            ("data", &self.data),
            ("database_url", &self.database_url),
            ("store", &self.store),
            ("engine.threads", &self.threads),
            ("jobs.workers", &self.workers),
            ("log.filter", &self.log),
            ("log.format", &self.log_format),
        ];
        let mut all = defaults.to_vec();
        all.extend(flags.into_iter().filter_map(|(key, value)| Some((key, value.clone()?))));
        Config::load(self.config.as_deref(), &all).map_err(|error| Failure::Usage(error.to_string()))
    }
}

pub(super) fn serve(args: ServeArgs) -> Result<(), Failure> {
    until_asked_to_end(&args, Role::All)
}

pub(super) fn worker(args: ServeArgs) -> Result<(), Failure> {
    until_asked_to_end(&args, Role::Worker)
}

fn until_asked_to_end(args: &ServeArgs, role: Role) -> Result<(), Failure> {
    let config = args.config(&[])?;
    telemetry::start(&config.log).map_err(|error| Failure::Usage(error.to_string()))?;
    let runtime = interrupt::runtime()?;
    let ended = runtime.block_on(async {
        let running = app::start(config, role).await?;
        interrupt::asked_to_end().await;
        running.stop().await;
        Ok(())
    });
    // A computation that is still under way, such as the reading of an upload, has nobody to answer any more.
    runtime.shutdown_background();
    ended
}

impl From<AppError> for Failure {
    fn from(error: AppError) -> Self {
        Failure::Usage(error.to_string())
    }
}

pub(super) fn openapi() -> Result<(), Failure> {
    print(http::openapi_json().into_bytes())
}
