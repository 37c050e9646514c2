//! How much a command says on stderr.

use std::path::Path;

use clap::Args;

use crate::service::cli::progress::ProgressMode;

/// How much is printed.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct Verbosity {
    /// Say nothing but why something failed: no progress, no warnings, no summary
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Also say what was repaired and how long every stage took
    #[arg(short, long)]
    verbose: bool,
}

impl Verbosity {
    /// The progress that is shown.
    pub(super) fn progress(self, asked: ProgressMode) -> ProgressMode {
        if self.quiet { ProgressMode::None } else { asked }
    }

    /// Prints a line.
    pub(super) fn print(self, line: &str) {
        if !self.quiet {
            eprintln!("quadrille: {line}");
        }
    }

    /// Prints a warning about an input, on one line.
    pub(super) fn warn(self, input: &Path, warning: &str) {
        self.print(&format!("warning: {}: {}", input.display(), warning.replace('\n', " ")));
    }

    /// Prints details that are asked for with `--verbose`.
    pub(super) fn print_details(self, lines: &[String]) {
        if self.verbose {
            lines.iter().for_each(|line| eprintln!("quadrille: {line}"));
        }
    }
}
