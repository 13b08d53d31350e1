//! Standard output.

use std::io::Write;

use super::Failure;
use crate::error::ErrorCode;

/// Number of faults or collisions that are printed; further ones are only counted.
pub const MAX_SHOWN: usize = 20;

/// Prints to standard output. A closed pipe (EPIPE) is not an error.
///
/// # Errors
/// [`Failure::work`] when standard output cannot be written for another reason.
pub fn print_stdout(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            let what = format!("cannot be written ({error})");
            Err(Failure::work(ErrorCode::System, what, "send it elsewhere").at("standard output"))
        }
        _ => Ok(()),
    }
}
