//! The command line: the same jobs as the window. Results go to files and stdout, errors as one line to
//! stderr. Exit code 0: success, 1: the command failed, 2: bad input or arguments.

mod args;
mod assess;
#[cfg(feature = "gpu")]
mod assess_pictures;
mod bench;
mod bench_flank;
#[cfg(feature = "gpu")]
mod bench_frames;
mod bench_growth;
mod bench_stock;
mod bench_wheel;
mod convert;
mod curve;
mod flank;
mod html;
mod open;
mod plan;
#[cfg(feature = "gpu")]
mod plot;
mod post;
#[cfg(feature = "gpu")]
mod render;
#[cfg(feature = "gpu")]
mod render_flank;
#[cfg(feature = "gpu")]
mod render_solid;
mod report;
mod sheet;
mod stock;
mod study;
mod verify;
mod watch;
#[cfg(not(feature = "gpu"))]
mod without_gpu;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::io::InputError;
use args::{Arguments, Command};
#[cfg(not(feature = "gpu"))]
use without_gpu::{assess_pictures, render};

/// Error of a command.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command failed: exit code 1.
    Work(String),
    /// Bad input or arguments: exit code 2.
    Input(String),
}

impl Failure {
    /// Bad input at a line of a file (0: no line number).
    pub fn at(file: &str, line: usize, what: &str) -> Self {
        let line = if line > 0 { format!(":{line}") } else { String::new() };
        Self::Input(format!("{file}{line}: {what}"))
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Prints to standard output. A closed pipe (EPIPE) is not an error.
///
/// # Errors
/// [`Failure::Work`] when standard output cannot be written for another reason.
pub(crate) fn print_stdout(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("standard output: cannot be written ({error}); send it elsewhere")))
        }
        _ => Ok(()),
    }
}

/// Prints one line to stderr, with control characters in `what` replaced by spaces.
fn print_error(what: &str) {
    let line: String = what.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // A closed stderr is ignored.
    let _ = writeln!(std::io::stderr(), "vanecut: {line}");
}

/// An error of clap as one line: the fault, then its tip.
fn usage_error(error: &clap::Error) -> String {
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
    match tips.first() {
        Some(tip) => format!("{fault}; {}", tip.trim_start_matches("tip: ")),
        None => format!("{fault}; see `vanecut --help`"),
    }
}

/// Parses the arguments of this process and runs the command; returns the exit code.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => {
            print_error(&usage_error(&error));
            return ExitCode::from(2);
        }
        Err(help) => return exit_code(print_stdout(&help.to_string())),
    };
    exit_code(run(arguments))
}

fn exit_code(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Work(what)) => {
            print_error(&what);
            ExitCode::from(1)
        }
        Err(Failure::Input(what)) => {
            print_error(&what);
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Failure> {
    match arguments.command {
        None if arguments.file.as_ref().is_some_and(|file| !file.exists()) => {
            let name = arguments.file.unwrap_or_default();
            Err(Failure::Input(format!("{}: no such file or command; see `vanecut --help`", name.display())))
        }
        None => open_window(arguments.file),
        Some(Command::Plan(a)) => plan::run(&a),
        Some(Command::Flank(a)) => flank::run(&a),
        Some(Command::Assess(a)) => assess::run(&a),
        Some(Command::Verify(a)) => verify::run(&a),
        Some(Command::Post(a)) => post::run(&a),
        Some(Command::Stock(a)) => stock::run(&a),
        Some(Command::Render(a)) => render::run(&a),
        Some(Command::Convert(a)) => convert::run(&a),
        Some(Command::Study(a)) => study::run(&a),
        Some(Command::Bench(a)) => bench::run(&a),
    }
}

/// Opens the window, with a file if one is given.
#[cfg(feature = "window")]
fn open_window(file: Option<std::path::PathBuf>) -> Result<(), Failure> {
    crate::app::run(file).map_err(|e| Failure::Work(e.to_string()))
}

#[cfg(not(feature = "window"))]
fn open_window(_: Option<std::path::PathBuf>) -> Result<(), Failure> {
    Err(Failure::Work(
        "this program was built without its window; give a command (`vanecut --help`), or build it with \
         --features window"
            .to_owned(),
    ))
}
