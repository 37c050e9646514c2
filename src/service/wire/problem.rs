//! The one table of problems: slug, HTTP status, exit code of the command line and title (RFC 9457).

use crate::engine::run::{Blame, Cancelled, Fault, Stage, StopReason};
use crate::service::formats::ReadError;
use crate::service::wire::problem_body::{Figures, ProblemBody};
use crate::service::wire::violation::Violation;

/// Most offending elements that a problem lists.
const MAX_ELEMENTS: usize = 20;

macro_rules! problems {
    ($($(#[$doc:meta])* $kind:ident = ($slug:literal, $status:literal, $exit:literal, $title:literal);)*) => {
        /// The kinds of problems; stable.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum ProblemKind { $($(#[$doc])* $kind,)* }

        impl ProblemKind {
            /// All kinds.
            pub const ALL: &'static [ProblemKind] = &[$(ProblemKind::$kind,)*];

            /// The stable last part of the problem's `type`.
            pub fn slug(self) -> &'static str {
                match self { $(ProblemKind::$kind => $slug,)* }
            }

            /// HTTP status code.
            pub fn status(self) -> u16 {
                match self { $(ProblemKind::$kind => $status,)* }
            }

            /// Exit code of the command line.
            pub fn exit_code(self) -> u8 {
                match self { $(ProblemKind::$kind => $exit,)* }
            }

            /// The title, the same for every occurrence.
            pub fn title(self) -> &'static str {
                match self { $(ProblemKind::$kind => $title,)* }
            }
        }
    };
}

problems! { // slug, status, exit code, title
    /// Malformed JSON, multipart or query.
    InvalidRequest = ("invalid-request", 400, 2, "The request cannot be understood");
    /// A spec with violations, all of them in `errors`.
    InvalidSpec = ("invalid-spec", 422, 2, "The spec cannot be used");
    /// No reader for this content.
    UnknownFormat = ("unknown-format", 415, 3, "The mesh format is not supported");
    /// The file breaks the rules of its format.
    UnreadableMesh = ("unreadable-mesh", 422, 3, "The mesh file cannot be read");
    /// The file needs an extension that this version cannot decode.
    UnsupportedExtension = ("unsupported-extension", 422, 3, "The mesh file needs an extension that is not supported");
    /// The surface cannot be used.
    MeshRejected = ("mesh-rejected", 422, 3, "The mesh cannot be remeshed");
    /// More bytes, vertices or triangles than allowed.
    MeshTooLarge = ("mesh-too-large", 413, 3, "The mesh is too large");
    /// The request body exceeds the limit.
    BodyTooLarge = ("body-too-large", 413, 3, "The request body is too large");
    /// The body of a request stopped coming.
    RequestTimeout = ("request-timeout", 408, 2, "The request did not arrive in time");
    /// No result within the limits.
    NoQuadMesh = ("no-quad-mesh-found", 422, 4, "No quad mesh satisfies the request");
    /// The deadline passed before there was a certified result.
    DeadlineExceeded = ("deadline-exceeded", 504, 5, "The run took too long");
    /// The client cancelled.
    Cancelled = ("cancelled", 410, 130, "The job was cancelled");
    /// The process is stopping.
    ShuttingDown = ("shutting-down", 503, 130, "The service is shutting down");
    /// Too many jobs wait.
    QueueFull = ("queue-full", 503, 4, "The service is busy");
    /// No such route, job or asset.
    NotFound = ("not-found", 404, 2, "There is no such thing here");
    /// The route exists, the method does not.
    MethodNotAllowed = ("method-not-allowed", 405, 2, "The method is not allowed here");
    /// The result misses what the spec's `accept` asks for; `figures` say by how much.
    NotAcceptable = ("not-acceptable", 422, 4, "The result is not acceptable");
    /// None of the formats in `Accept` can be produced.
    FormatNotOffered = ("format-not-offered", 406, 2, "None of the accepted formats can be produced");
    /// A page of another origin wants to change something.
    ForeignOrigin = ("foreign-origin", 403, 2, "Pages of this origin may not do this");
    /// The request names a host that is not this server.
    ForeignHost = ("foreign-host", 421, 2, "The request was meant for another host");
    /// The artefact does not exist yet.
    NotReady = ("not-ready", 409, 4, "The result does not exist yet");
    /// The job failed, so there is no artefact.
    JobFailed = ("job-failed", 410, 4, "The job has no result");
    /// The run made no such artefact, e.g. no parameterisation.
    NoArtefact = ("no-artefact", 404, 4, "The job made no such artefact");
    /// Same idempotency key, other body.
    IdempotencyConflict = ("idempotency-conflict", 422, 2, "The idempotency key was used for another request");
    /// A range outside the file.
    RangeNotSatisfiable = ("range-not-satisfiable", 416, 2, "The range lies outside the file");
    /// The asset is in use.
    AssetInUse = ("asset-in-use", 409, 2, "The asset is used by a job that has not finished");
    /// A run brought the worker down again and again.
    JobCrashed = ("job-crashed", 500, 70, "The job stopped its worker again and again");
    /// Database or object store cannot be reached.
    StorageUnavailable = ("storage-unavailable", 503, 70, "The storage cannot be reached");
    /// A bug of ours.
    Internal = ("internal", 500, 70, "Something went wrong on our side");
}

impl ProblemKind {
    /// The stable `type` URI.
    pub fn type_uri(self) -> String {
        format!("urn:quadrille:problem:{}", self.slug())
    }

    /// The kind with this `type` URI.
    pub fn from_type_uri(uri: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.type_uri() == uri)
    }
}

/// One occurrence of a problem.
///
/// ```
/// use quadrille::service::wire::{Problem, ProblemKind};
///
/// let problem = Problem::new(ProblemKind::QueueFull, "1000 jobs wait.");
/// let body = problem.body(Some("/v1/jobs".to_owned()));
/// assert_eq!((body.status, body.type_.as_str()), (503, "urn:quadrille:problem:queue-full"));
/// assert_eq!(problem.to_string(), "The service is busy: 1000 jobs wait.");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Its kind.
    pub kind: ProblemKind,
    /// What happened this time, with the numbers, and what to do.
    pub detail: String,
    /// The stage of the run, where there was one.
    pub stage: Option<&'static str>,
    /// At most 20 offending elements in the numbering of the input.
    pub elements: Vec<u64>,
    /// Violations of the request.
    pub errors: Vec<Violation>,
    /// Seconds after which a new try makes sense.
    pub retry_after: Option<u32>,
    /// The figures of a result that is not acceptable. Boxed: problems travel in every `Result`.
    pub figures: Option<Box<Figures>>,
}

impl Problem {
    /// A problem with a detail and nothing else.
    pub fn new(kind: ProblemKind, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self { kind, detail, stage: None, elements: Vec::new(), errors: Vec::new(), retry_after: None, figures: None }
    }

    /// The same at a stage.
    pub fn at(mut self, stage: Stage) -> Self {
        self.stage = Some(stage.name());
        self
    }

    /// The same for a document that lies at `prefix` of a larger one.
    pub fn under(mut self, prefix: &str) -> Self {
        for violation in &mut self.errors {
            violation.pointer.insert_str(0, prefix);
        }
        self
    }

    /// A bug of ours: the cause goes to the log, not to the client.
    pub fn internal() -> Self {
        Self::new(ProblemKind::Internal, "The cause was logged. The same request may fail again; please report it.")
    }

    /// The problem of a run that was stopped.
    pub fn stopped(reason: StopReason) -> Self {
        match reason {
            StopReason::Client => Self::new(ProblemKind::Cancelled, "The run was cancelled before it had a result."),
            StopReason::Deadline | StopReason::Overtime => Self::new(
                ProblemKind::DeadlineExceeded,
                "The deadline passed before there was a certified result; raise deadline_s or lower the target.",
            ),
            StopReason::Shutdown => Self::new(ProblemKind::ShuttingDown, "The process stopped; the job runs again."),
        }
    }

    /// The body of the answer. `instance` is the path of the job or the id of the request.
    pub fn body(&self, instance: Option<String>) -> ProblemBody {
        ProblemBody {
            type_: self.kind.type_uri(),
            title: self.kind.title().to_owned(),
            status: self.kind.status(),
            detail: self.detail.clone(),
            instance,
            stage: self.stage.map(str::to_owned),
            elements: self.elements.clone(),
            errors: self.errors.clone(),
            retry_after: self.retry_after,
            figures: self.figures.as_deref().copied(),
        }
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.kind.title(), self.detail)?;
        if let Some(stage) = self.stage {
            write!(f, " (stage {stage})")?;
        }
        if !self.elements.is_empty() {
            write!(f, " (at {:?})", self.elements)?;
        }
        if self.errors.len() > 1 {
            for error in &self.errors {
                write!(f, "; {}: {}", error.pointer, error.message)?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Problem {}

/// Maps a failure of the engine to a problem: the only place where faults meet status codes.
pub fn problem_of_fault(error: &dyn Blame, stage: Option<Stage>, stopped: Option<StopReason>) -> Problem {
    let kind = match error.fault() {
        Fault::Input => ProblemKind::MeshRejected,
        Fault::Request => ProblemKind::InvalidSpec,
        Fault::Unsatisfiable => ProblemKind::NoQuadMesh,
        Fault::Limit => ProblemKind::MeshTooLarge,
        // Where a run happened to be when it was stopped is not where anything is wrong.
        Fault::Cancelled => {
            let mut problem = Problem::stopped(stopped.unwrap_or(StopReason::Client));
            if let Some(tried) = error.tried() {
                problem.detail = format!("{} Tried so far: {tried}.", problem.detail);
            }
            return problem;
        }
        Fault::Internal => return Problem { stage: stage.map(Stage::name), ..Problem::internal() },
    };
    let mut elements = error.elements();
    elements.truncate(MAX_ELEMENTS);
    let message = error.to_string();
    let pointer = format!("/{}", error.spec_field());
    let errors =
        if kind == ProblemKind::InvalidSpec { vec![Violation::new(pointer, message.clone())] } else { Vec::new() };
    Problem { stage: stage.map(Stage::name), elements, errors, ..Problem::new(kind, sentence(&message)) }
}

impl From<Cancelled> for Problem {
    fn from(cancelled: Cancelled) -> Self {
        Self::stopped(cancelled.0)
    }
}

impl From<&ReadError> for Problem {
    /// Files have kinds of problems of their own; who is to blame does not tell them apart.
    fn from(error: &ReadError) -> Self {
        let kind = match error {
            ReadError::UnknownFormat => ProblemKind::UnknownFormat,
            ReadError::TooLarge { .. } => ProblemKind::MeshTooLarge,
            ReadError::UnsupportedExtension { .. } => ProblemKind::UnsupportedExtension,
            _ => ProblemKind::UnreadableMesh,
        };
        let mut elements = error.elements();
        elements.truncate(MAX_ELEMENTS);
        Problem { elements, ..Problem::new(kind, sentence(&error.to_string())) }.at(Stage::Read)
    }
}

/// Errors start in lower case and have no full stop; a detail is a sentence.
fn sentence(message: &str) -> String {
    let mut letters = message.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    let stop = if message.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}

#[cfg(test)]
mod tests;
