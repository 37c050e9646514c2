//! `quadrille inspect`: what a file holds and what is wrong with it.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::engine::pipeline::RemeshSpec;
use crate::engine::run::{RunContext, StopReason};
use crate::service::cli::failure::Failure;
use crate::service::cli::files::{self, print};
use crate::service::cli::folder::Folder;
use crate::service::cli::interrupt;
use crate::service::cli::plan::read_format;
use crate::service::cli::remesh::report_json;
use crate::service::config::Config;
use crate::service::jobs::EnginePool;
use crate::service::run::{ContentsBody, Input, InspectionBody, SurfaceBody, inspect_file, read_limits};
use crate::service::wire::ProblemKind;

/// Most names that are listed.
const MOST_NAMES: usize = 8;

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(super) struct InspectArgs {
    /// Mesh to look at; - is stdin
    file: PathBuf,
    /// Format of the file, instead of its ending
    #[arg(long, value_name = "FORMAT")]
    from: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Threads of the engine; 0: all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

pub(super) fn run(args: InspectArgs) -> Result<(), Failure> {
    let format = read_format(args.from.as_deref(), &args.file)?;
    let limits = Config::defaults().limits;
    let bytes = files::read(&args.file, limits.upload_bytes)?;
    let context = RunContext::silent();
    let stop = context.clone();
    let runtime = interrupt::runtime()?;
    runtime.spawn(interrupt::on_signal(move || stop.stop(StopReason::Client)));
    let (run, beside) = (context.clone(), Folder::of(&args.file));
    let found = runtime.block_on(EnginePool::new(args.threads).run(&context, move || {
        let input = Input { bytes: &bytes, format, beside: &beside, limits: read_limits(&limits) };
        inspect_file(&run, &input, &RemeshSpec::default())
    }))?;
    print(if args.json { report_json(&found)? } else { text(&args.file, &found).into_bytes() })?;
    match &found.problem {
        None => Ok(()),
        Some(problem) => {
            let kind = ProblemKind::from_type_uri(&problem.type_).unwrap_or(ProblemKind::Internal);
            Err(Failure::Reported(kind.exit_code()))
        }
    }
}

/// The same for people: a word and what it says, line by line.
fn text(path: &Path, found: &InspectionBody) -> String {
    let mut lines = vec![("file", format!("{}: {}, {} bytes", path.display(), found.format, found.bytes))];
    lines.extend(contents(&found.holds));
    match (&found.surface, &found.problem) {
        (Some(surface), _) => lines.extend(described(surface)),
        (None, Some(problem)) => lines.push(("refused", format!("{}: {}", problem.title, problem.detail))),
        (None, None) => {}
    }
    lines.extend(found.warnings.iter().map(|warning| ("warning", warning.to_string())));
    lines.iter().map(|(word, text)| format!("{word:<11}{}\n", text.replace('\n', " "))).collect()
}

fn contents(holds: &ContentsBody) -> Vec<(&'static str, String)> {
    let others = holds.polygons - holds.triangles - holds.quads;
    let mut lines = vec![(
        "polygons",
        format!(
            "{}: {} triangles, {} quads, {others} of more corners; {} vertices",
            holds.polygons, holds.triangles, holds.quads, holds.vertices
        ),
    )];
    let mut list = |word, names: &[String]| {
        if !names.is_empty() {
            let more = if names.len() > MOST_NAMES { ", …" } else { "" };
            let shown = names[..names.len().min(MOST_NAMES)].join(", ");
            lines.push((word, format!("{}: {shown}{more}", names.len())));
        }
    };
    list("objects", &holds.objects);
    list("materials", &holds.materials);
    if !holds.images.is_empty() {
        let shown = holds.images.iter().take(MOST_NAMES).map(|image| {
            format!("{} ({}, {} bytes)", image.name.as_deref().unwrap_or("-"), image.media_type, image.bytes)
        });
        let more = if holds.images.len() > MOST_NAMES { ", …" } else { "" };
        let shown = shown.collect::<Vec<_>>().join(", ");
        lines.push(("images", format!("{}: {shown}{more}", holds.images.len())));
    }
    let carried = [
        (holds.uv, "texture coordinates"),
        (holds.normals, "normals"),
        (holds.vertex_colours, "vertex colours"),
        (holds.joints > 0, "a skin"),
    ];
    let carried: Vec<&str> = carried.into_iter().filter_map(|(is_there, name)| is_there.then_some(name)).collect();
    if !carried.is_empty() {
        lines.push(("has", carried.join(", ")));
    }
    if holds.joints > 0 {
        lines.push(("joints", holds.joints.to_string()));
    }
    if let Some([low, high]) = holds.bounding_box {
        let point = |p: [f64; 3]| p.map(|x| x.to_string()).join(" ");
        lines.push(("box", format!("from {} to {}", point(low), point(high))));
    }
    lines
}

fn described(surface: &SurfaceBody) -> Vec<(&'static str, String)> {
    let input = &surface.input;
    let mut lines = vec![(
        "surface",
        format!(
            "{} vertices, {} triangles, {} components, {} boundary loops, genus {}, {} sharp edges, area {:.6}",
            input.vertices,
            input.triangles,
            input.components,
            input.boundaries,
            input.genus,
            input.feature_edges,
            surface.area
        ),
    )];
    let repairs: Vec<String> =
        input.repairs.iter().map(|(name, count)| format!("{} {count}", name.replace('_', " "))).collect();
    lines.push(("repairs", if repairs.is_empty() { "none needed".to_owned() } else { repairs.join(", ") }));
    lines
}
