//! `quadrille check`: the certificate alone.

use std::path::PathBuf;

use clap::Args;

use crate::engine::pipeline::Target;
use crate::engine::run::{RunContext, StopReason};
use crate::service::cli::failure::Failure;
use crate::service::cli::files;
use crate::service::cli::folder::Folder;
use crate::service::cli::interrupt;
use crate::service::cli::plan::{quad_format, read_format};
use crate::service::cli::remesh::report_json;
use crate::service::cli::spec_flags::SpecFlags;
use crate::service::config::Config;
use crate::service::formats::read_quads;
use crate::service::jobs::EnginePool;
use crate::service::run::{Input, check_quads, read_limits};
use crate::service::wire::{Problem, ReportBody};

/// Exit code for quads that the certificate refuses.
const NOT_CERTIFIED: u8 = 4;

/// Arguments of `check`.
#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    /// Mesh that the quads were made for
    input: PathBuf,
    /// Quads: .obj, .glb, .ply or .usda
    quads: PathBuf,
    /// Format of the input, instead of its ending
    #[arg(long, value_name = "FORMAT")]
    from: Option<String>,
    /// Format of the quads, instead of their ending
    #[arg(long, value_name = "FORMAT")]
    to: Option<String>,
    /// Threads of the engine; 0: all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Report of the run that made the quads: it says which features were given up
    #[arg(long, value_name = "F")]
    report: Option<PathBuf>,
    #[command(flatten)]
    spec: SpecFlags,
}

pub(super) fn run(args: CheckArgs) -> Result<(), Failure> {
    let mut spec = args.spec.resolve()?.spec;
    let from = read_format(args.from.as_deref(), &args.input)?;
    let to = quad_format(args.to.as_deref().or(files::extension(&args.quads)).unwrap_or_default())?;
    let limits = Config::defaults().limits;
    let mesh = files::read(&args.input, limits.upload_bytes)?;
    let quads = files::read(&args.quads, limits.upload_bytes)?;
    let quads = read_quads(&quads, to).map_err(|error| Problem::from(&error))?;
    if !args.spec.names_target() {
        // What counts as a feature depends on the density: short loose creases are none for large quads.
        spec.target = Target::Quads((quads.quads.len() as u64).max(1));
    }

    let findings = match &args.report {
        Some(path) => Some(read_report(path, limits.upload_bytes)?.findings()),
        None => None,
    };
    let context = RunContext::silent();
    let stop = context.clone();
    let runtime = interrupt::runtime()?;
    runtime.spawn(interrupt::on_signal(move || stop.stop(StopReason::Client)));
    let (run, beside) = (context.clone(), Folder::of(&args.input));
    let certificate = runtime.block_on(EnginePool::new(args.threads).run(&context, move || {
        let input = Input { bytes: &mesh, format: from, beside: &beside, limits: read_limits(&limits) };
        check_quads(&run, &input, &quads, &spec, findings.as_ref())
    }))?;
    files::print(report_json(&certificate)?)?;
    if certificate.certified { Ok(()) } else { Err(Failure::Reported(NOT_CERTIFIED)) }
}

fn read_report(path: &std::path::Path, limit: u64) -> Result<ReportBody, Failure> {
    serde_json::from_slice(&files::read(path, limit)?)
        .map_err(|error| Failure::Usage(format!("{} is no report of this version: {error}", path.display())))
}
