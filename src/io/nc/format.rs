//! Numbers as controls read them.

use std::fmt::Write;

/// How numbers are written.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberFormat {
    /// Decimals of lengths, mm.
    pub decimals: usize,
    /// Decimals of angles, degrees.
    pub angle_decimals: usize,
    /// Decimals of the components of a vector.
    pub vector_decimals: usize,
    /// Decimals of feed rates, mm/min.
    pub feed_decimals: usize,
    /// A comma instead of the point.
    pub comma: bool,
    /// A sign before positive numbers too.
    pub plus: bool,
    /// Zeros at the end are left out, the point stays.
    pub short: bool,
    /// First block number and its step; `None`: no block numbers.
    pub numbers: Option<(u32, u32)>,
}

impl NumberFormat {
    /// Appends `word` and `x` with `decimals`.
    pub fn push(&self, out: &mut String, word: &str, x: f64, decimals: usize) {
        out.push_str(word);
        // Rounded first, so that no number is −0.
        let scale = 10f64.powi(decimals as i32);
        let rounded = (x * scale).round() / scale;
        let x = if rounded == 0.0 { 0.0 } else { rounded };
        if self.plus && x >= 0.0 {
            out.push('+');
        }
        let start = out.len();
        // Writing to a string does not fail.
        let _ = write!(out, "{x:.decimals$}");
        if decimals == 0 {
            if !self.plus {
                out.push('.');
            }
            return;
        }
        if self.short {
            let kept = out.trim_end_matches('0').len();
            out.truncate(kept.max(start));
            if self.plus && out.ends_with('.') {
                out.push('0');
            }
        }
        if self.comma
            && let Some(point) = out.get(start..).and_then(|text| text.find('.'))
        {
            out.replace_range(start + point..=start + point, ",");
        }
    }

    /// `x` with `decimals`.
    pub fn text(&self, x: f64, decimals: usize) -> String {
        let mut out = String::new();
        self.push(&mut out, "", x, decimals);
        out
    }
}
