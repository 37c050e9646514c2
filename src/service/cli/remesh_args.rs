//! The arguments of `quadrille remesh`.

use std::path::PathBuf;

use clap::Args;

use crate::service::cli::files::Overwrite;
use crate::service::cli::progress::ProgressMode;
use crate::service::cli::spec_flags::SpecFlags;
use crate::service::cli::verbosity::Verbosity;

/// Arguments of `remesh`.
#[derive(Debug, Args)]
pub(super) struct RemeshArgs {
    /// Meshes to read: .obj, .glb, .gltf with what lies beside it, .ply, .stl or .zip; - is stdin. Several are a batch
    #[arg(required = true, value_name = "IN")]
    pub(super) inputs: Vec<PathBuf>,
    /// Quads to write: .obj, .glb, .ply or .usda; - is stdout. For a batch a folder, as in quads/, or a name with {stem}
    /// for that of the input; so are the other files
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Parameterisation to write: .obj, .glb or .json
    #[arg(long, value_name = "F")]
    pub(super) parameterisation: Option<PathBuf>,
    /// Report to write, as JSON
    #[arg(long, value_name = "F")]
    pub(super) report: Option<PathBuf>,
    /// Picture of the quads to write
    #[arg(long, value_name = "F.png")]
    pub(super) preview: Option<PathBuf>,
    /// Pixels of the picture's sides
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub(super) preview_size: u32,
    /// Format of the input, instead of its ending
    #[arg(long, value_name = "FORMAT")]
    pub(super) from: Option<String>,
    /// Format of the quads, instead of their ending
    #[arg(long, value_name = "FORMAT")]
    pub(super) to: Option<String>,
    #[command(flatten)]
    pub(super) overwrite: Overwrite,
    /// Threads of the engine; 0: all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) threads: usize,
    /// How progress is shown on stderr
    #[arg(long, value_enum, default_value_t)]
    pub(super) progress: ProgressMode,
    #[command(flatten)]
    pub(super) verbosity: Verbosity,
    #[command(flatten)]
    pub(super) spec: SpecFlags,
}
