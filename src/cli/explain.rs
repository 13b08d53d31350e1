//! `vanecut explain`: what an error code means, and what to do.

use super::args::ExplainArgs;
use super::failure::Failure;
use super::stdout::print_stdout;
use crate::error::ErrorCode;
use crate::io::table::nearest_note;

/// Prints the entry of one code, or the page of all.
///
/// # Errors
/// [`Failure::input`] when there is no such code.
pub fn run(args: &ExplainArgs) -> Result<(), Failure> {
    let Some(name) = &args.code else { return print_stdout(&ErrorCode::page()) };
    let Some(code) = ErrorCode::named(name) else {
        let known: Vec<&str> = ErrorCode::all().map(ErrorCode::name).collect();
        let help = format!("`vanecut explain` lists them{}", nearest_note(name, &known));
        return Err(Failure::input(ErrorCode::UnknownName, format!("no error has the code {name:?}"), help));
    };
    print_stdout(&format!("{code}\n{}\nWhat to do: {}\n", code.meaning(), code.cure()))
}
