//! `quadrille remesh`: the engine on files, without a server.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::engine::run::{RunContext, StopReason};
use crate::service::cli::failure::Failure;
use crate::service::cli::files::{self, Existing, Outputs};
use crate::service::cli::folder::Folder;
use crate::service::cli::interrupt;
use crate::service::cli::interrupt::{CurrentRun, INTERRUPTED};
use crate::service::cli::plan::Plan;
use crate::service::cli::progress::ProgressMode;
use crate::service::cli::remesh_args::RemeshArgs;
use crate::service::config::{Config, LimitsConfig};
use crate::service::jobs::EnginePool;
use crate::service::run::{Input, Products, Wanted, execute, read_limits};
use crate::service::wire::{Problem, ResolvedSpec};

pub(super) fn run(args: RemeshArgs) -> Result<(), Failure> {
    let plans = Plan::all(&args)?;
    let existing: Vec<_> = plans.iter().map(|plan| args.overwrite.allow(plan.outputs())).collect();
    let session = Session {
        args: &args,
        progress: args.verbosity.progress(args.progress),
        resolved: Arc::new(args.spec.resolve()?),
        limits: Config::defaults().limits,
        runtime: interrupt::runtime()?,
        current: CurrentRun::default(),
    };
    let current = session.current.clone();
    session.runtime.spawn(interrupt::on_signal(move || current.stop(StopReason::Client)));
    let is_batch = plans.len() > 1;
    let mut worst = 0;
    for (plan, existing) in plans.iter().zip(existing) {
        if session.current.is_stopped() {
            worst = worst.max(INTERRUPTED);
            break;
        }
        let outcome = existing.and_then(|existing| session.remesh(plan, existing));
        let name = plan.input.display();
        match outcome {
            Ok(summary) if is_batch => args.verbosity.print(&format!("{name}: {}: {summary}", plan.quads.display())),
            Ok(summary) if args.progress != ProgressMode::None => args.verbosity.print(&summary),
            Ok(_) => {}
            Err(failure) if is_batch => {
                worst = worst.max(failure.exit_code());
                eprintln!("quadrille: {name}: {}", failure.line().unwrap_or_default());
            }
            Err(failure) => return Err(failure),
        }
    }
    if worst == 0 { Ok(()) } else { Err(Failure::Reported(worst)) }
}

/// What all runs of a batch have in common.
struct Session<'a> {
    args: &'a RemeshArgs,
    progress: ProgressMode,
    resolved: Arc<ResolvedSpec>,
    limits: LimitsConfig,
    runtime: tokio::runtime::Runtime,
    current: CurrentRun,
}

impl Session<'_> {
    /// Remeshes one file; gives a line for people.
    fn remesh(&self, plan: &Plan, existing: Existing) -> Result<String, Failure> {
        let start = Instant::now();
        let bytes = files::read(&plan.input, self.limits.upload_bytes)?;
        let products = self.execute(plan, bytes).inspect_err(|problem| self.progress.failed(&problem.to_string()))?;
        for warning in &products.report.warnings {
            self.args.verbosity.warn(&plan.input, &warning.to_string());
        }
        let summary = summary(&products, start.elapsed());
        let details = details(&products);
        self.save(plan, existing, products)?;
        self.args.verbosity.print_details(&details);
        Ok(summary)
    }

    fn execute(&self, plan: &Plan, bytes: Vec<u8>) -> Result<Products, Problem> {
        let wanted = Wanted {
            quads: vec![plan.to],
            map: plan.map.iter().map(|(_, format)| *format).collect(),
            preview: plan.preview.as_ref().map(|_| self.args.preview_size),
        };
        // The bar lives as long as the last handle of the context: it must be gone before anything else is printed.
        let context = RunContext::new(self.resolved.spec.seed, self.progress.observer());
        self.current.begin(&context);
        let (run, resolved, limits) = (context.clone(), Arc::clone(&self.resolved), read_limits(&self.limits));
        let (format, beside) = (plan.from, Folder::of(&plan.input));
        let outcome = self.runtime.block_on(EnginePool::new(self.args.threads).run(&context, move || {
            let input = Input { bytes: &bytes, format, beside: &beside, limits };
            execute(&run, &input, &resolved, &wanted)
        }));
        self.current.end();
        outcome
    }

    /// Everything beside its place first, the quads last: who sees them can rely on the rest.
    fn save(&self, plan: &Plan, existing: Existing, products: Products) -> Result<(), Failure> {
        let mut outputs = Outputs::new(existing);
        if let (Some(path), Some(png)) = (&plan.preview, products.preview) {
            outputs.add(path, png)?;
        }
        if let Some(path) = &plan.report {
            outputs.add(path, report_json(&products.report)?)?;
        }
        if let Some((path, _)) = &plan.map {
            match products.map.into_iter().next() {
                Some((_, bytes)) => outputs.add(path, bytes)?,
                None => {
                    let level = products.report.level.name();
                    let text = format!("no map was made for quads of level {level}; {} is not written", path.display());
                    self.args.verbosity.warn(&plan.input, &text);
                }
            }
        }
        for (_, bytes) in products.quads {
            outputs.add(&plan.quads, bytes)?;
        }
        outputs.publish()
    }
}

/// Indented JSON with a newline at its end.
pub(super) fn report_json(report: &impl serde::Serialize) -> Result<Vec<u8>, Failure> {
    let mut bytes = serde_json::to_vec_pretty(report)
        .map_err(|error| Failure::Output(format!("the report cannot be written as JSON: {error}")))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// What was repaired and how long everything took.
fn details(products: &Products) -> Vec<String> {
    let report = &products.report;
    let pairs = |map: &serde_json::Map<String, serde_json::Value>, unit: &str| {
        let pair = |(name, value): (&String, &serde_json::Value)| match value.as_f64() {
            Some(number) => format!("{name} {number:.0}{unit}"),
            None => format!("{name} {value}"),
        };
        map.iter().map(pair).collect::<Vec<_>>().join(", ")
    };
    let input = &report.input;
    let mut lines = vec![format!(
        "input: {} vertices, {} triangles, {} components, {} boundaries, genus {}, {} sharp edges",
        input.vertices, input.triangles, input.components, input.boundaries, input.genus, input.feature_edges
    )];
    if !input.repairs.is_empty() {
        lines.push(format!("repairs: {}", pairs(&input.repairs, "")));
    }
    lines.push(format!("time: {}", pairs(&report.timings_ms, " ms")));
    lines.push(format!("memory: {} MiB at most", report.peak_memory_bytes >> 20));
    lines
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
