//! The command line: the same jobs as the window. Results go to files and stdout, errors as one line to
//! stderr. Exit code 0: success, 1: the command failed, 2: bad input or arguments.

mod args;
mod assess;
mod bench;
mod bench_flank;
#[cfg(feature = "gpu")]
mod bench_frames;
mod bench_growth;
mod bench_measure;
mod bench_stock;
mod bench_wheel;
mod channels;
mod convert;
mod curve;
mod edits;
mod explain;
mod failure;
mod flank;
mod machine_figures;
mod open;
mod output;
mod output_folder;
mod plan;
mod post;
#[cfg(feature = "gpu")]
mod render;
#[cfg(feature = "gpu")]
mod render_flank;
#[cfg(feature = "gpu")]
mod render_solid;
#[cfg(feature = "gpu")]
mod render_words;
mod stdout;
mod stock;
mod study;
mod verify;
mod watch;
#[cfg(not(feature = "gpu"))]
mod without_gpu;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::error::ErrorCode;
use args::{Arguments, CliCommand};
use failure::Failure;
use stdout::print_stdout;
#[cfg(not(feature = "gpu"))]
use without_gpu::render;

/// Environment variable that adds the codes of errors to their lines.
const CODES_VARIABLE: &str = "VANECUT_ERROR_CODES";

/// Prints a failure as one line to stderr, with control characters replaced by spaces; with
/// [`CODES_VARIABLE`] its code follows in brackets.
fn print_error(failure: &Failure) {
    let line = failure.to_string();
    let mut line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if std::env::var_os(CODES_VARIABLE).is_some_and(|value| value == "1") {
        line.push_str(&format!(" [{}]", failure.code()));
    }
    // A closed stderr is ignored.
    let _ = writeln!(std::io::stderr(), "vanecut: {line}");
}

/// An error of clap: the fault, then its tip.
fn usage_error(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let said: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|l| !l.is_empty())
        .collect();
    let (tips, fault): (Vec<&str>, Vec<&str>) = said.into_iter().partition(|line| line.starts_with("tip: "));
    let fault = fault.join(" ");
    let fault = fault.trim_start_matches("error: ");
    let help = tips.first().map_or("see `vanecut --help`", |tip| tip.trim_start_matches("tip: "));
    Failure::input(ErrorCode::Arguments, fault, help)
}

/// Parses the arguments of this process and runs the command; returns the exit code.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => return exit_code(Err(usage_error(&error))),
        Err(help) => return exit_code(print_stdout(&help.to_string())),
    };
    exit_code(run(arguments))
}

fn exit_code(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            print_error(&failure);
            ExitCode::from(failure.exit)
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Failure> {
    match arguments.command {
        None if arguments.file.as_ref().is_some_and(|file| !file.exists()) => {
            let name = arguments.file.unwrap_or_default();
            let what = "no such file or command";
            Err(Failure::input(ErrorCode::Arguments, what, "see `vanecut --help`").at_path(&name))
        }
        None => open_window(arguments.file),
        Some(CliCommand::Plan(a)) => plan::run(&a),
        Some(CliCommand::Flank(a)) => flank::run(&a),
        Some(CliCommand::Assess(a)) => assess::run(&a),
        Some(CliCommand::Verify(a)) => verify::run(&a),
        Some(CliCommand::Post(a)) => post::run(&a),
        Some(CliCommand::Stock(a)) => stock::run(&a),
        Some(CliCommand::Render(a)) => render::run(&a),
        Some(CliCommand::Convert(a)) => convert::run(&a),
        Some(CliCommand::Study(a)) => study::run(&a),
        Some(CliCommand::Bench(a)) => bench::run(&a),
        Some(CliCommand::Explain(a)) => explain::run(&a),
    }
}

/// Opens the window, with a file if one is given.
#[cfg(feature = "window")]
fn open_window(file: Option<std::path::PathBuf>) -> Result<(), Failure> {
    crate::app::run(file).map_err(Failure::of_work)
}

#[cfg(not(feature = "window"))]
fn open_window(_: Option<std::path::PathBuf>) -> Result<(), Failure> {
    let help = "give a command (`vanecut --help`), or build it with --features window";
    Err(Failure::not_built_in("its window", help))
}
