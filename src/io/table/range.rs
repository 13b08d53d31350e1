//! The values that a number may have.

/// Allowed values of a number.
#[derive(Clone, Copy)]
pub enum NumberRange {
    /// Both ends allowed.
    Between(f64, f64),
    /// Lower end not allowed, upper end allowed.
    Above(f64, f64),
    /// Neither end allowed.
    Within(f64, f64),
}

impl NumberRange {
    pub(super) fn holds(self, x: f64) -> bool {
        match self {
            Self::Between(a, b) => a <= x && x <= b,
            Self::Above(a, b) => a < x && x <= b,
            Self::Within(a, b) => a < x && x < b,
        }
    }

    /// Checks that `x` is in the range.
    ///
    /// # Errors
    /// When it is not: what to give instead.
    pub fn check(self, x: f64) -> Result<(), String> {
        if self.holds(x) { Ok(()) } else { Err(self.help()) }
    }

    /// What to give.
    pub(super) fn help(self) -> String {
        match self {
            Self::Between(a, b) => format!("give a number from {a} to {b}"),
            Self::Above(a, b) => format!("give a number greater than {a} and at most {b}"),
            Self::Within(a, b) => format!("give a number between {a} and {b}"),
        }
    }
}
