//! The job object (docs/contract.md, section 2). Times are RFC 3339 in UTC, ids are UUIDv7.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::service::wire::warning::code_schema;
use crate::service::wire::{LevelName, ProblemBody, ReportBody, SpecSummary, WarningBody};

/// Where a job is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobStatus {
    /// Waits for a worker.
    Queued,
    /// A worker has it.
    Running,
    /// Has a certified result.
    Succeeded,
    /// Has a problem.
    Failed,
    /// Was cancelled by a client.
    Cancelled,
}

impl JobStatus {
    /// As in JSON, in the database and in event names.
    pub fn name(self) -> &'static str {
        match self {
            JobStatus::Queued => "queued",
            JobStatus::Running => "running",
            JobStatus::Succeeded => "succeeded",
            JobStatus::Failed => "failed",
            JobStatus::Cancelled => "cancelled",
        }
    }

    /// The status of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        use JobStatus::{Cancelled, Failed, Queued, Running, Succeeded};
        [Queued, Running, Succeeded, Failed, Cancelled].into_iter().find(|status| status.name() == name)
    }

    /// Whether the job will not change any more.
    pub fn is_final(self) -> bool {
        !matches!(self, JobStatus::Queued | JobStatus::Running)
    }
}

/// What is known of the uploaded mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct InputBody {
    /// Lower-case hexadecimal SHA-256 of the upload.
    pub sha256: String,
    /// Bytes of the upload.
    pub bytes: u64,
    /// Name of the file, without its folder; null if the client gave none.
    pub name: Option<String>,
    /// `obj`, `glb`, `gltf`, `ply`, `stl` or `zip`; null while unknown.
    pub format: Option<String>,
    /// Vertices after conditioning; null before the run.
    pub vertices: Option<u64>,
    /// Triangles after conditioning; null before the run.
    pub triangles: Option<u64>,
    /// Components after conditioning; null before the run.
    pub components: Option<u64>,
}

/// The result in a few numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ResultBody {
    /// Quads.
    pub quads: u64,
    /// Vertices of the quad mesh.
    pub vertices: u64,
    /// Irregular interior vertices.
    pub irregular_vertices: u64,
    /// Whether the certificate passed.
    pub certified: bool,
    /// The worst level of the components.
    pub level: LevelName,
    /// Codes of the warnings, each once; the report has the rest.
    #[serde(default)]
    #[schema(schema_with = codes_schema)]
    pub warnings: Vec<String>,
}

fn codes_schema() -> utoipa::openapi::schema::Array {
    utoipa::openapi::schema::ArrayBuilder::new().items(code_schema()).build()
}

impl From<&ReportBody> for ResultBody {
    fn from(report: &ReportBody) -> Self {
        Self {
            quads: report.quads.count as u64,
            vertices: report.quads.vertices as u64,
            irregular_vertices: report.quads.irregular_interior as u64,
            certified: report.certified,
            level: report.level,
            warnings: codes(&report.warnings),
        }
    }
}

fn codes(warnings: &[WarningBody]) -> Vec<String> {
    let codes: std::collections::BTreeSet<&String> = warnings.iter().map(|warning| &warning.code).collect();
    codes.into_iter().cloned().collect()
}

/// Where to go from here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Urls {
    /// The job.
    #[serde(rename = "self")]
    pub self_: String,
    /// The whole spec.
    pub spec: String,
    /// Its events.
    pub events: String,
    /// POST here to cancel.
    pub cancel: String,
    /// The quads.
    pub quad_mesh: String,
    /// The parameterisation.
    pub parameterisation: String,
    /// The report.
    pub report: String,
    /// The picture.
    pub preview: String,
    /// All files in one.
    pub archive: String,
}

impl Urls {
    /// The paths of the job `id`.
    pub fn of(id: &str) -> Self {
        let job = format!("/v1/jobs/{id}");
        Self {
            spec: format!("{job}/spec"),
            events: format!("{job}/events"),
            cancel: format!("{job}/cancel"),
            quad_mesh: format!("{job}/quad-mesh"),
            parameterisation: format!("{job}/parameterisation"),
            report: format!("{job}/report"),
            preview: format!("{job}/preview.png"),
            archive: format!("{job}/archive.zip"),
            self_: job,
        }
    }
}

/// A job as clients see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobBody {
    /// UUIDv7.
    #[schema(format = Uuid)]
    pub id: String,
    /// Where the job is in its life.
    pub status: JobStatus,
    /// Stage of the run; null unless running.
    pub stage: Option<String>,
    /// 0 to 1, never falls.
    pub progress: f64,
    /// Seconds that the run is expected to take from here on; null unless running, and while that is unknown.
    pub seconds_left: Option<u64>,
    /// How many jobs are before this one; null unless queued.
    pub queue_position: Option<u64>,
    /// How often a worker began, from 0.
    pub attempt: u32,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub created_at: String,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub started_at: Option<String>,
    /// RFC 3339.
    #[schema(format = DateTime)]
    pub finished_at: Option<String>,
    /// RFC 3339; after it the job and its files are removed.
    #[schema(format = DateTime)]
    pub expires_at: Option<String>,
    /// The spec with all defaults filled in; long lists are given by their length.
    pub spec: SpecSummary,
    /// The uploaded mesh.
    pub input: InputBody,
    /// The result, once there is one.
    pub result: Option<ResultBody>,
    /// Why there is none.
    pub problem: Option<ProblemBody>,
    /// Labels.
    pub tags: Vec<String>,
    /// Where to go from here.
    pub urls: Urls,
}

/// One page of jobs, newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobList {
    /// The jobs.
    pub jobs: Vec<JobBody>,
    /// Give it as `cursor` for the next page; null on the last one.
    pub next_cursor: Option<String>,
}
