//! The run itself.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use crate::engine::certify::certify;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::pipeline::{Outcome, RemeshSpec, Size, plan_of_run, remesh, share_of_proof};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{RunContext, Stage, StopReason, Warning, WarningKind};
use crate::service::config::LimitsConfig;
use crate::service::formats::{
    Beside, Format, MapFormat, MapView, Model, QuadFormat, ReadLimits, Scene, read_model, read_quads, write_map,
    write_model,
};
use crate::service::preview::preview_png;
use crate::service::run::accept::judge;
use crate::service::run::deadline::Deadline;
use crate::service::run::memory::peak_bytes;
use crate::service::run::stage_clock::StageClock;
use crate::service::wire::{Problem, ProblemKind, ReportBody, ResolvedSpec, WarningBody, problem_of_fault};

/// Bytes of a file per triangle, about: for the progress of reading it.
const BYTES_OF_A_TRIANGLE: f64 = 40.0;

/// Units of work (milliseconds of one core of the machine that the engine's costs were measured on) in a second.
const UNITS_PER_SECOND: f64 = 1000.0;

/// An upload.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The bytes.
    pub bytes: &'a [u8],
    /// Their format, where it is known; otherwise the first bytes tell it.
    pub format: Option<Format>,
    /// The files that it may name.
    pub beside: &'a dyn Beside,
    /// Limits on what the file may claim.
    pub limits: ReadLimits,
}

/// Which files are wanted.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Formats of the quads. The first one must pass the certificate; a further one that does not hold these quads is
    /// left out with a warning.
    pub quads: Vec<QuadFormat>,
    /// Formats of the parameterisation.
    pub map: Vec<MapFormat>,
    /// Pixels of the sides of a picture.
    pub preview: Option<u32>,
}

impl Wanted {
    fn n_files(&self) -> usize {
        self.quads.len() + self.map.len() + usize::from(self.preview.is_some())
    }
}

/// What a run made: certified, or there would be none.
#[derive(Clone, Debug)]
pub struct Products {
    /// Files of the quads.
    pub quads: Vec<(QuadFormat, Vec<u8>)>,
    /// Files of the parameterisation; none if no component came from a map.
    pub map: Vec<(MapFormat, Vec<u8>)>,
    /// PNG.
    pub preview: Option<Vec<u8>>,
    /// The report.
    pub report: ReportBody,
}

/// Limits of the readers from those of the configuration.
pub fn read_limits(limits: &LimitsConfig) -> ReadLimits {
    ReadLimits {
        max_vertices: limits.vertices,
        max_polygons: limits.triangles,
        max_bytes_unpacked: limits.upload_bytes,
    }
}

/// One run; blocks, so call it on a thread of the engine's pool. The context may be stopped from outside at any time;
/// this function stops it at the deadline. Panics become problems.
///
/// # Errors
/// The problem, with its stage.
pub fn execute(
    context: &RunContext,
    input: &Input<'_>,
    spec: &ResolvedSpec,
    wanted: &Wanted,
) -> Result<Products, Problem> {
    let clock = StageClock::default();
    let ctx = context.also(spec.spec.seed, clock.clone());
    let timer = Deadline::start(ctx.clone(), Duration::from_secs_f64(spec.options.deadline_s));
    let start = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| steps(&ctx, input, spec, wanted)));
    drop(timer);
    let mut products = outcome.unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<String>().map(String::as_str);
        let what = what.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        tracing::error!(panic = what, "the engine panicked");
        Err(Problem::internal())
    })?;
    let timings = clock.timings_ms().into_iter().collect::<Vec<_>>();
    products.report.set_timings(&timings, start.elapsed().as_secs_f64() * 1000.0, peak_bytes());
    Ok(products)
}

fn steps(ctx: &RunContext, input: &Input<'_>, spec: &ResolvedSpec, wanted: &Wanted) -> Result<Products, Problem> {
    let files = wanted.n_files();
    let guess = input.bytes.len() as f64 / BYTES_OF_A_TRIANGLE;
    let ctx = &ctx.planned(plan_of_run(&Size::of(guess, &spec.spec), files));
    let Model { soup, scene, warnings } = ctx.stage(Stage::Read, |_| {
        read_model(input.bytes, input.format, input.beside, &input.limits).map_err(|error| Problem::from(&error))
    })?;
    let size = Size::of(soup.n_polygons() as f64, &spec.spec);
    let ctx = &ctx.planned(plan_of_run(&size, files));
    let asked = RemeshSpec { time_limit: UNITS_PER_SECOND * spec.options.deadline_s, ..spec.spec.clone() };
    let mut outcome = remesh(&ctx.stages(Stage::Condition, Stage::Certify), &soup, &asked)
        .map_err(|error| problem_of_fault(&error, Some(error.stage()), ctx.stopped()))?;
    drop(soup);
    outcome.report.warnings.extend(warnings);
    // A deadline has done its work when the engine hands out what it had by then; a client or an ending process that
    // stopped the run wants no result.
    if let Some(reason @ (StopReason::Client | StopReason::Shutdown)) = ctx.stopped() {
        return Err(Problem::stopped(reason));
    }
    let ctx = &ctx.late();
    judge(&ReportBody::of(&outcome.report), spec)?;
    ctx.stage(Stage::Write, |ctx| write(ctx, outcome, &scene, wanted, share_of_proof(&size, files)))
}

/// Writes all files and certifies what is read back from them: mostly once, which takes the share `proof` of the time.
fn write(ctx: &RunContext, outcome: Outcome, scene: &Scene, wanted: &Wanted, proof: f64) -> Result<Products, Problem> {
    let mut report = ReportBody::of(&outcome.report);
    let index = SurfaceIndex::new(&outcome.surface.mesh);
    let mut quads: Vec<(QuadFormat, Vec<u8>)> = Vec::new();
    let mut proved: Option<QuadMesh> = None;
    let share = (1.0 - proof) / wanted.n_files() as f64;
    for (i, &format) in wanted.quads.iter().enumerate() {
        let before = if proved.is_some() { proof } else { 0.0 } + i as f64 * share;
        ctx.advance(before);
        let bytes = write_model(&outcome.quads, &outcome.attributes, scene, format);
        let again = read_quads(&bytes, format).map_err(|error| not_certified(&error.to_string()))?;
        if proved.as_ref().is_some_and(|proved| *proved == again) {
            quads.push((format, bytes));
            continue;
        }
        let certificate = certify(
            &ctx.span(before + share, before + share + proof),
            &outcome.surface,
            &index,
            &again,
            outcome.report.edge_length,
        )?;
        if certificate.certified {
            quads.push((format, bytes));
            proved.get_or_insert(again);
            continue;
        }
        let why: Vec<String> = certificate.violations.iter().map(ToString::to_string).collect();
        if proved.is_none() {
            return Err(not_certified(&why.join("; ")));
        }
        let name = format.extension();
        let kind = WarningKind::FormatLeftOut { format: name.to_owned(), cause: why.join("; ") };
        report.warnings.push(WarningBody::from(&Warning::from(kind)));
    }
    let map = outcome.map.as_ref().map(|map| MapView {
        positions: &map.positions,
        faces: &map.faces,
        grid: &map.grid,
        scale: map.scale,
        singularities: &map.singularities,
    });
    let mut maps = Vec::new();
    for (i, &format) in wanted.map.iter().enumerate().filter(|_| map.is_some()) {
        ctx.advance(proof + (wanted.quads.len() + i) as f64 * share);
        maps.extend(map.as_ref().map(|view| (format, write_map(view, format))));
    }
    let preview = wanted.preview.map(|size| draw(&outcome.quads, size)).transpose()?;
    Ok(Products { quads, map: maps, preview, report })
}

/// A square PNG of the quads, `size` pixels wide.
pub(super) fn draw(quads: &QuadMesh, size: u32) -> Result<Vec<u8>, Problem> {
    preview_png(quads, size as usize).map_err(|error| {
        tracing::error!(%error, "the picture cannot be encoded");
        Problem::internal()
    })
}

fn not_certified(why: &str) -> Problem {
    tracing::error!(why, "the result was not certified");
    Problem::new(ProblemKind::NoQuadMesh, format!("The quads did not pass the certificate: {why}.")).at(Stage::Certify)
}
