//! The command line: the same jobs as the window, results to files and stdout, faults as one line
//! on stderr. Exit 0 done, 1 the work itself failed, 2 bad input or arguments.

mod args;
mod bench;
mod open;
mod plan;
mod render;
mod report;
mod verify;

use std::process::ExitCode;

use clap::Parser;

use crate::formats::InputError;
use args::{Arguments, Command};

/// How a command ends badly.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The work itself failed: exit 1.
    Work(String),
    /// Bad input or arguments: exit 2.
    Input(String),
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            eprintln!("vanecut: {}; see `vanecut --help`", first.trim_start_matches("error: "));
            return ExitCode::from(2);
        }
        Err(help) => {
            print!("{help}");
            return ExitCode::SUCCESS;
        }
    };
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Work(what)) => {
            eprintln!("vanecut: {what}");
            ExitCode::from(1)
        }
        Err(Failure::Input(what)) => {
            eprintln!("vanecut: {what}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Failure> {
    match arguments.command {
        None => crate::app::run(arguments.file).map_err(|e| Failure::Work(e.to_string())),
        Some(Command::Plan(a)) => plan::run(&a),
        Some(Command::Verify(a)) => verify::run(&a),
        Some(Command::Render(a)) => render::run(&a),
        Some(Command::Bench) => bench::run(),
    }
}
