//! Why a command of the program ends without success.

use crate::service::wire::Problem;

/// Why a command ends without success.
#[derive(Debug)]
pub(super) enum Failure {
    /// An invalid command line, or another user error that is detected before any work starts.
    Usage(String),
    /// A file that cannot be read.
    Input(String),
    /// A result that cannot be written.
    Output(String),
    /// Printed already; only the exit code is left.
    Reported(u8),
    /// A problem of the run.
    Problem(Problem),
}

impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        Failure::Problem(problem)
    }
}

impl Failure {
    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Failure::Usage(_) => 2,
            Failure::Input(_) => 3,
            Failure::Output(_) => 4,
            Failure::Reported(code) => *code,
            Failure::Problem(problem) => problem.kind.exit_code(),
        }
    }

    /// The error message for a person, on a single line; `None` if it has been printed already.
    pub(super) fn line(&self) -> Option<String> {
        match self {
            Failure::Usage(line) | Failure::Input(line) | Failure::Output(line) => Some(line.replace('\n', " ")),
            Failure::Reported(_) => None,
            Failure::Problem(problem) => Some(problem.to_string().replace('\n', " ")),
        }
    }
}
