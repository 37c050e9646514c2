//! What a worker can have done with bytes. The one driver of the program is the way from bytes to certified files; the
//! trait is here so that the life of a job can be tested without geometry.

use bytes::Bytes;

use crate::engine::run::RunContext;
use crate::service::wire::{InputBody, Problem, ReportBody, ResolvedSpec};

/// An upload.
#[derive(Clone, Debug)]
pub struct InputFile {
    /// The bytes.
    pub bytes: Bytes,
    /// File name that the client gave.
    pub name: Option<String>,
    /// Name of the format that was found when the upload was accepted.
    pub format: Option<String>,
}

/// What a look at an upload found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inspection {
    /// Name of the format.
    pub format: String,
    /// Vertices, where the file was read.
    pub vertices: Option<u64>,
    /// Faces, where the file was read.
    pub faces: Option<u64>,
}

/// One finished file.
#[derive(Clone, Debug)]
pub struct Made {
    /// E.g. `quad-mesh.obj`.
    pub name: &'static str,
    /// Media type.
    pub media_type: &'static str,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// Everything that a run made.
#[derive(Clone, Debug)]
pub struct Products {
    /// The files but the report.
    pub files: Vec<Made>,
    /// The report.
    pub report: ReportBody,
}

impl Products {
    /// What the run found out about the mesh.
    pub fn input(&self, known: &InputBody) -> InputBody {
        InputBody {
            vertices: Some(self.report.input.vertices as u64),
            triangles: Some(self.report.input.triangles as u64),
            components: Some(self.report.input.components as u64),
            ..known.clone()
        }
    }
}

/// The way from bytes to certified files. All functions compute, so they are called on the engine's pool.
pub trait Driver: Send + Sync + 'static {
    /// Whether an upload can be read at all; `whole` asks to read all of it, otherwise its head is enough.
    fn inspect(&self, input: &InputFile, whole: bool) -> Result<Inspection, Problem>;

    /// The whole run; also stops it at the deadline of the spec.
    fn run(&self, context: &RunContext, input: &InputFile, spec: &ResolvedSpec) -> Result<Products, Problem>;

    /// A square PNG of `size` pixels of the quads that `run` wrote as `quad-mesh.ply`.
    fn preview(&self, quads: &[u8], size: u32) -> Result<Vec<u8>, Problem>;
}
