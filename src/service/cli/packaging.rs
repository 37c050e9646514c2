//! `quadrille completions` and `quadrille man`: what packages install beside the program.

use std::io::Error;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::{Shell, generate};
use clap_mangen::{Man, generate_to};

use crate::service::cli::failure::Failure;
use crate::service::cli::files;

/// Name of the program in scripts and pages.
const NAME: &str = "quadrille";

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub(super) struct CompletionsArgs {
    /// Shell that is to complete arguments
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub(super) struct ManArgs {
    /// Folder to write the pages of all commands to, one file each
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(super) fn completions(args: &CompletionsArgs, mut program: Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut program, NAME, &mut script);
    files::print(script)
}

pub(super) fn man(args: &ManArgs, program: Command) -> Result<(), Failure> {
    let Some(folder) = &args.output else {
        let mut page = Vec::new();
        let cannot = |error: Error| Failure::Output(format!("cannot write the manual page: {error}"));
        Man::new(program).render(&mut page).map_err(cannot)?;
        return files::print(page);
    };
    let cannot = |error: Error| Failure::Output(format!("cannot write to {}: {error}", folder.display()));
    std::fs::create_dir_all(folder).and_then(|()| generate_to(program, folder)).map_err(cannot)
}
