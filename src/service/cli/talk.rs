//! How much a command says on stderr.

use std::path::Path;

use clap::Args;

use crate::service::cli::progress::ProgressMode;

/// How much is said.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct Talk {
    /// Say nothing but why something failed: no progress, no warnings, no summary
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Also say what was repaired and how long every stage took
    #[arg(short, long)]
    verbose: bool,
}

impl Talk {
    /// The progress that is shown.
    pub(super) fn progress(self, asked: ProgressMode) -> ProgressMode {
        if self.quiet { ProgressMode::None } else { asked }
    }

    /// Says a line.
    pub(super) fn say(self, line: &str) {
        if !self.quiet {
            eprintln!("quadrille: {line}");
        }
    }

    /// Says a trouble with an input that did not keep it from becoming quads, on one line.
    pub(super) fn warn(self, input: &Path, warning: &str) {
        self.say(&format!("warning: {}: {}", input.display(), warning.replace('\n', " ")));
    }

    /// Says what only the curious want to know.
    pub(super) fn explain(self, lines: &[String]) {
        if self.verbose {
            lines.iter().for_each(|line| eprintln!("quadrille: {line}"));
        }
    }
}
