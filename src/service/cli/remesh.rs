//! `quadrille remesh`: the engine on a file, without a server.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use crate::engine::run::{RunContext, StopReason};
use crate::service::cli::files::{self, Outputs};
use crate::service::cli::progress::ProgressMode;
use crate::service::cli::spec_flags::SpecFlags;
use crate::service::cli::{Failure, interrupt};
use crate::service::config::Config;
use crate::service::formats::{Format, MapFormat, QuadFormat};
use crate::service::jobs::EnginePool;
use crate::service::run::{Input, Products, Wanted, execute, read_limits};

/// Arguments of `remesh`.
#[derive(Debug, Args)]
pub(super) struct RemeshArgs {
    /// Mesh to read: .obj, .glb, .gltf, .ply, .stl or .zip; - is stdin
    input: PathBuf,
    /// Quads to write: .obj, .glb, .ply or .usda; - is stdout
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Parameterisation to write: .obj, .glb or .json
    #[arg(long, value_name = "F")]
    parameterisation: Option<PathBuf>,
    /// Report to write, as JSON
    #[arg(long, value_name = "F")]
    report: Option<PathBuf>,
    /// Picture of the quads to write
    #[arg(long, value_name = "F.png")]
    preview: Option<PathBuf>,
    /// Pixels of the picture's sides
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=4096))]
    preview_size: u32,
    /// Format of the input, instead of its ending
    #[arg(long, value_name = "FORMAT")]
    from: Option<String>,
    /// Format of the quads, instead of their ending
    #[arg(long, value_name = "FORMAT")]
    to: Option<String>,
    /// Threads of the engine; 0: all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// How progress is shown on stderr
    #[arg(long, value_enum, default_value_t)]
    progress: ProgressMode,
    #[command(flatten)]
    spec: SpecFlags,
}

/// What is read and written, judged before any work.
struct Plan {
    from: Option<Format>,
    to: QuadFormat,
    map: Option<(PathBuf, MapFormat)>,
}

impl Plan {
    fn of(args: &RemeshArgs) -> Result<Self, Failure> {
        let outputs = [Some(&args.output), args.parameterisation.as_ref(), args.report.as_ref(), args.preview.as_ref()];
        let outputs: Vec<&PathBuf> = outputs.into_iter().flatten().collect();
        for (i, path) in outputs.iter().enumerate() {
            files::check_writable(path)?;
            if outputs[..i].contains(path) {
                return Err(Failure::Usage(format!("{} is named twice", path.display())));
            }
        }
        let from = match &args.from {
            Some(name) => Some(known(Format::from_extension(name), name, "obj, glb, gltf, ply, stl, zip")?),
            None => files::extension(&args.input).and_then(Format::from_extension),
        };
        let to = args.to.as_deref().or(files::extension(&args.output)).unwrap_or_default();
        let to = known(QuadFormat::from_extension(to), to, "obj, glb, ply, usda")?;
        let map = match &args.parameterisation {
            None => None,
            Some(path) => {
                let name = files::extension(path).unwrap_or_default();
                Some((path.clone(), known(MapFormat::from_extension(name), name, "obj, glb, json")?))
            }
        };
        Ok(Self { from, to, map })
    }
}

/// The format, or the names that are known.
pub(super) fn known<T>(format: Option<T>, name: &str, names: &str) -> Result<T, Failure> {
    format.ok_or_else(|| Failure::Usage(format!("{name:?} is no format known here; use one of {names}")))
}

pub(super) fn run(args: RemeshArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let plan = Plan::of(&args)?;
    let resolved = args.spec.resolve()?;
    let limits = Config::defaults().limits;
    let bytes = files::read(&args.input, limits.upload_bytes)?;

    let context = RunContext::new(resolved.spec.seed, args.progress.observer());
    let stop = context.clone();
    let runtime = interrupt::runtime()?;
    let signals = runtime.spawn(interrupt::on_signal(move || stop.stop(StopReason::Client)));
    let wanted = Wanted {
        quads: vec![plan.to],
        map: plan.map.iter().map(|(_, format)| *format).collect(),
        preview: args.preview.as_ref().map(|_| args.preview_size),
    };
    let deadline = Duration::from_secs_f64(resolved.options.deadline_s);
    let (run, from) = (context.clone(), plan.from);
    let outcome = runtime.block_on(EnginePool::new(args.threads).run(&context, move || {
        let input = Input { bytes: &bytes, format: from, limits: read_limits(&limits) };
        execute(&run, &input, &resolved.spec, &wanted, deadline)
    }));
    signals.abort();
    // The bar lives as long as the last handle: it must be gone before anything else is printed.
    drop((context, runtime));
    match outcome {
        Ok(products) => {
            let summary = summary(&products, start.elapsed());
            for warning in products.report.warnings.iter().filter(|_| args.progress != ProgressMode::None) {
                eprintln!("warning: {warning}");
            }
            save(&args, plan, products)?;
            if args.progress != ProgressMode::None {
                eprintln!("quadrille: {summary}");
            }
            Ok(())
        }
        Err(problem) => {
            args.progress.failed(&problem.to_string());
            Err(problem.into())
        }
    }
}

/// Everything beside its place first, the quads last: who sees them can rely on the rest.
fn save(args: &RemeshArgs, plan: Plan, products: Products) -> Result<(), Failure> {
    let mut outputs = Outputs::default();
    if let (Some(path), Some(png)) = (&args.preview, products.preview) {
        outputs.add(path, png)?;
    }
    if let Some(path) = &args.report {
        outputs.add(path, report_json(&products.report)?)?;
    }
    if let Some((path, _)) = plan.map {
        match products.map.into_iter().next() {
            Some((_, bytes)) => outputs.add(&path, bytes)?,
            None => eprintln!(
                "quadrille: no parameterisation was made: the quads are of level {}; {} is not written",
                products.report.level.name(),
                path.display()
            ),
        }
    }
    for (_, bytes) in products.quads {
        outputs.add(&args.output, bytes)?;
    }
    outputs.publish()
}

/// Indented JSON with a newline at its end.
pub(super) fn report_json(report: &impl serde::Serialize) -> Result<Vec<u8>, Failure> {
    let mut bytes = serde_json::to_vec_pretty(report)
        .map_err(|error| Failure::Output(format!("the report cannot be written as JSON: {error}")))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// One line for people.
fn summary(products: &Products, took: Duration) -> String {
    let report = &products.report;
    let quads = &report.quads;
    format!(
        "{} certified quads, {} irregular vertices inside, level {}, scaled Jacobian from {:.2} (mean {:.2}), \
         distance {:.3} % of the diagonal, {:.1} s",
        quads.count,
        quads.irregular_interior,
        report.level.name(),
        quads.scaled_jacobian.min,
        quads.scaled_jacobian.mean,
        100.0 * quads.hausdorff.max,
        took.as_secs_f64()
    )
}
