//! The error of a command, and the one line that it prints.

use std::fmt::{Display, Formatter};
use std::path::Path;

use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::monitor::Cancelled;
use crate::verify::VerifyError;

/// Error of a command: what it prints, and its exit code.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    /// The process's exit code: 1 where the work failed, 2 for bad input or arguments.
    pub exit: u8,
    /// File and line, or the option; empty where there is none.
    place: String,
    error: UserError,
}

impl Failure {
    /// Bad input or arguments: exit code 2.
    pub fn input(code: ErrorCode, what: impl Into<String>, help: impl Into<String>) -> Self {
        UserError::new(code, what, help).into()
    }

    /// The command failed: exit code 1.
    pub fn work(code: ErrorCode, what: impl Into<String>, help: impl Into<String>) -> Self {
        Self::of_work(UserError::new(code, what, help))
    }

    /// The answer of a command to a program that was built without what it needs: exit code 1.
    #[cfg(any(test, not(feature = "window")))]
    pub fn not_built_in(what: &str, help: &str) -> Self {
        Self::work(ErrorCode::NotBuiltIn, format!("this program was built without {what}"), help)
    }

    /// An error that is not one of the input: exit code 1.
    pub fn of_work(error: impl Into<UserError>) -> Self {
        Self { exit: 1, ..error.into().into() }
    }

    /// A program `file` that cannot be judged, for a fault at a line of it, or a cancelled check.
    pub fn of_verify(file: &str, error: VerifyError) -> Self {
        match error {
            VerifyError::Cancelled(cancelled) => cancelled.into(),
            VerifyError::Program(fault) => {
                let line = fault.line;
                Self::from(UserError::from(fault)).at_line(file, line)
            }
        }
    }

    /// The same failure at a place: a file, or an option with its value.
    pub fn at(self, place: impl Into<String>) -> Self {
        Self { place: place.into(), ..self }
    }

    /// The same failure at a line (0: none) of a file.
    pub fn at_line(self, file: &str, line: usize) -> Self {
        self.at(if line > 0 { format!("{file}:{line}") } else { file.to_owned() })
    }

    /// The same failure at a file.
    pub fn at_path(self, path: &Path) -> Self {
        self.at(path.display().to_string())
    }

    /// Its kind.
    pub fn code(&self) -> ErrorCode {
        self.error.code
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self.place.as_str() {
            "" => self.error.fmt(f),
            place => write!(f, "{place}: {}", self.error),
        }
    }
}

impl From<UserError> for Failure {
    fn from(error: UserError) -> Self {
        Self { exit: 2, place: String::new(), error }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        let place = error.place();
        Self::from(UserError::from(error)).at(place)
    }
}

impl From<Cancelled> for Failure {
    fn from(cancelled: Cancelled) -> Self {
        Self::of_work(cancelled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_built_in_is_no_fault_of_the_input() {
        let failure = Failure::not_built_in("pictures", "build it with --features gpu");
        assert_eq!((failure.exit, failure.code()), (1, ErrorCode::NotBuiltIn));
        assert_eq!(
            failure.to_string(),
            "this program was built without pictures; build it with --features gpu"
        );
    }
}
