//! Readers and writers: part files, setup, CL programs, plans.

/// A fault in something a user gave us. Shown as `FILE:LINE: what; cure`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct InputError {
    /// File as the user named it; empty when the fault is in no file.
    pub file: String,
    /// 1-based line, 0 when there is none.
    pub line: usize,
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub cure: String,
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.file.is_empty(), self.line) {
            (true, _) => write!(f, "{}; {}", self.what, self.cure),
            (false, 0) => write!(f, "{}: {}; {}", self.file, self.what, self.cure),
            (false, line) => write!(f, "{}:{line}: {}; {}", self.file, self.what, self.cure),
        }
    }
}
