//! What the stages cost: the figures behind the shares of progress.

use std::path::Path;

use quadrille::engine::pipeline::Target;
use quadrille::engine::run::{RunContext, Stage};
use quadrille::service::config::Config;
use quadrille::service::formats::{Alone, MapFormat, QuadFormat};
use quadrille::service::run::{Input, Wanted, execute, read_limits};
use quadrille::service::wire::ResolvedSpec;

use crate::model::number;

/// Quads from which on a run is of the next class of size.
const CLASSES: [f64; 3] = [0.0, 3_000.0, 12_000.0];

/// One run.
struct Run {
    triangles: f64,
    quads: f64,
    ms: [f64; Stage::ALL.len()],
}

impl Run {
    fn total(&self) -> f64 {
        self.ms.iter().sum()
    }
}

/// Runs the command.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let (mut sizes, mut models) = (vec![1000, 5000, 20_000], Vec::new());
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--quads" => {
                let list = rest.next().ok_or("--quads wants numbers with commas between them")?;
                sizes = list.split(',').map(number).collect::<Result<_, _>>()?;
            }
            model => models.push(model),
        }
    }
    println!("{:20} {:>7} {:>7} {:>8} {}", "model", "tris", "quads", "ms", names());
    let mut runs = Vec::new();
    for model in models {
        for &quads in &sizes {
            match measured(Path::new(model), quads) {
                Ok(run) => {
                    let name = Path::new(model).file_stem().map(|s| s.to_string_lossy().into_owned());
                    let ms: String = run.ms.iter().map(|ms| format!("{ms:>10.0}")).collect();
                    let (name, total) = (name.unwrap_or_default(), run.total());
                    println!("{name:20} {:7} {:7} {total:8.0} {ms}", run.triangles, run.quads);
                    runs.push(run);
                }
                Err(problem) => println!("{model}, {quads} quads: {problem}"),
            }
        }
    }
    shares(&runs);
    costs(&runs);
    Ok(())
}

fn names() -> String {
    Stage::ALL.iter().map(|stage| format!("{:>10}", stage.name())).collect()
}

/// Milliseconds of a run that writes all files, as a worker's does.
fn measured(model: &Path, quads: u64) -> Result<Run, String> {
    let bytes = std::fs::read(model).map_err(|e| e.to_string())?;
    let mut spec = ResolvedSpec::default();
    spec.spec.target = Target::Quads(quads);
    spec.options.deadline_s = 3600.0;
    let formats = vec![QuadFormat::Ply, QuadFormat::Obj, QuadFormat::Glb, QuadFormat::Usda];
    let wanted = Wanted { quads: formats, map: MapFormat::ALL.to_vec(), preview: None };
    let limits = read_limits(&Config::defaults().limits);
    let input = Input { bytes: &bytes, format: None, beside: &Alone, limits };
    let products = execute(&RunContext::silent(), &input, &spec, &wanted);
    let report = products.map_err(|problem| problem.to_string())?.report;
    let ms = |stage: Stage| report.timings_ms.get(stage.name()).and_then(|ms| ms.as_f64()).unwrap_or_default();
    Ok(Run { triangles: report.input.triangles as f64, quads: quads as f64, ms: Stage::ALL.map(ms) })
}

/// Prints the mean share of each stage by class of size, in per cent.
fn shares(runs: &[Run]) {
    println!("\n{:20} {:>24} {}", "shares, %", "runs", names());
    for (i, &from) in CLASSES.iter().enumerate() {
        let to = CLASSES.get(i + 1).copied().unwrap_or(f64::INFINITY);
        let class: Vec<&Run> = runs.iter().filter(|run| (from..to).contains(&run.quads)).collect();
        let share =
            |stage: usize| class.iter().map(|run| run.ms[stage] / run.total()).sum::<f64>() / class.len() as f64;
        let line: String = (0..Stage::ALL.len()).map(|stage| format!("{:>10.1}", 100.0 * share(stage))).collect();
        println!("{:20} {:24} {line}", format!("from {from} quads"), class.len());
    }
}

/// Prints milliseconds per thousand triangles and per thousand quads. Runs count alike, however long they took.
fn costs(runs: &[Run]) {
    println!("\n{:20} {:>16} {:>16}", "ms per thousand", "triangles", "quads");
    for stage in Stage::ALL {
        let (mut tt, mut tq, mut qq, mut t, mut q) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for run in runs {
            let weight = 1.0 / run.total().powi(2);
            let (x, y, ms) = (run.triangles / 1000.0, run.quads / 1000.0, run.ms[stage as usize]);
            tt += weight * x * x;
            tq += weight * x * y;
            qq += weight * y * y;
            t += weight * x * ms;
            q += weight * y * ms;
        }
        // The least squares of costs that are not negative: of both, or of one alone.
        let determinant = tt * qq - tq * tq;
        let both = ((t * qq - q * tq) / determinant, (q * tt - t * tq) / determinant);
        let (per_triangle, per_quad) = match both {
            (a, b) if a >= 0.0 && b >= 0.0 => (a, b),
            (a, _) if a < 0.0 => (0.0, q / qq),
            _ => (t / tt, 0.0),
        };
        println!("{:20} {per_triangle:16.2} {per_quad:16.2}", stage.name());
    }
}
