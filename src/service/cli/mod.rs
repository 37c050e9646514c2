//! The command line (docs/contract.md, section 1): `quadrille remesh | check | inspect | sample | serve | worker | demo | …`.
//!
//! Exit codes: 0 certified result; 2 usage or spec; 3 the input was refused; 4 no result within the limits; 5 deadline;
//! 130 cancelled; 70 a bug of ours. Failures are one line on stderr.

mod check;
mod demo;
mod failure;
mod files;
mod folder;
mod inspect;
mod interrupt;
mod packaging;
mod places;
mod plan;
mod progress;
mod remesh;
mod remesh_args;
mod sample;
mod serve;
mod spec_flags;
mod verbosity;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

/// A triangle mesh in, a parameterisation and a certified pure quad mesh out.
#[derive(Debug, Parser)]
#[command(name = "quadrille", version, max_term_width = 120)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Start the server, submit a sample over HTTP, save the results to ./quadrille-demo/ and keep serving
    Demo(demo::DemoArgs),
    /// HTTP server and workers in one process
    Serve(serve::ServeArgs),
    /// A worker only, on the configured database and store
    Worker(serve::ServeArgs),
    /// Remesh a file without a server
    Remesh(Box<remesh_args::RemeshArgs>),
    /// Check quads against the surface they were made for; the certificate as JSON
    Check(check::CheckArgs),
    /// Say what a mesh file holds and what is wrong with it
    Inspect(inspect::InspectArgs),
    /// Write one of the built-in sample surfaces
    Sample(sample::SampleArgs),
    /// Print the fields of a spec with their values, defaults and meaning, as Markdown
    Spec,
    /// Print the OpenAPI document
    Openapi,
    /// Print a script that completes this program's arguments in a shell
    Completions(packaging::CompletionsArgs),
    /// Print the manual page, or write those of all commands into a folder
    Man(packaging::ManArgs),
}

/// Runs the command of this process.
pub fn main() -> ExitCode {
    let outcome = match CommandLine::parse().command {
        Command::Demo(args) => demo::run(args),
        Command::Serve(args) => serve::serve(args),
        Command::Worker(args) => serve::worker(args),
        Command::Remesh(args) => remesh::run(*args),
        Command::Check(args) => check::run(args),
        Command::Sample(args) => sample::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Spec => spec_flags::print_table(),
        Command::Openapi => serve::openapi(),
        Command::Completions(args) => packaging::completions(&args, CommandLine::command()),
        Command::Man(args) => packaging::man(&args, CommandLine::command()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(line) = failure.line() {
                eprintln!("quadrille: {line}");
            }
            ExitCode::from(failure.exit_code())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
