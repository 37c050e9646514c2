//! The certificate alone, for quads from anywhere.

use serde::Serialize;

use crate::engine::pipeline::{RemeshSpec, RunFindings, check};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{RunContext, Stage};
use crate::service::formats::read_model;
use crate::service::run::Input;
use crate::service::wire::{Problem, QuadsBody, problem_of_fault};

/// Places told per failed check.
const MOST_WITNESSES: usize = 10;

/// One failed check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FailedCheck {
    /// What is wrong, how often and where.
    pub message: String,
    /// How often.
    pub count: usize,
    /// The first places, by index; of what, the message says.
    pub witnesses: Vec<u32>,
}

/// The certificate as JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CertificateBody {
    /// Whether no check failed.
    pub certified: bool,
    /// The checks that failed.
    pub violations: Vec<FailedCheck>,
    /// Measures of the quads.
    pub quads: QuadsBody,
}

/// Certifies `quads` against the surface of `input`, conditioned and with features as `spec` says, and with what the
/// report of the run that made them found.
///
/// # Errors
/// The problem why the input cannot be used, with its stage.
pub fn check_quads(
    ctx: &RunContext,
    input: &Input<'_>,
    quads: &QuadMesh,
    spec: &RemeshSpec,
    findings: Option<&RunFindings>,
) -> Result<CertificateBody, Problem> {
    let model = ctx.stage(Stage::Read, |_| {
        read_model(input.bytes, input.format, input.beside, &input.limits).map_err(|error| Problem::from(&error))
    })?;
    let certificate = check(ctx, &model.soup, quads, spec, findings)
        .map_err(|error| problem_of_fault(&error, Some(error.stage()), ctx.stopped()))?;
    let failed = certificate.violations.iter().map(|violation| FailedCheck {
        message: violation.to_string(),
        count: violation.count,
        witnesses: violation.witnesses.iter().take(MOST_WITNESSES).copied().collect(),
    });
    Ok(CertificateBody {
        certified: certificate.certified,
        violations: failed.collect(),
        quads: (&certificate.measures).into(),
    })
}
