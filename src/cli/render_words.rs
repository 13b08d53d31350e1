//! Words of the arguments of `vanecut render`.

use glam::UVec2;

use super::Failure;
use crate::error::ErrorCode;
use crate::gpu::image::MAX_SIDE;

/// Word of `--show` for the stock as a solid.
pub const SOLID: &str = "solid";

/// Parses WIDTHxHEIGHT, pixels.
///
/// # Errors
/// When the word is not of this form, or a side is 0 or too long.
pub fn parse_size(word: &str) -> Result<UVec2, Failure> {
    let side = |s: &str| s.parse::<u32>().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    word.split_once(['x', 'X']).and_then(|(w, h)| Some(UVec2::new(side(w)?, side(h)?))).ok_or_else(|| {
        let help = format!("give WIDTHxHEIGHT up to {MAX_SIDE}");
        Failure::input(ErrorCode::Arguments, "not a picture size", help).at(format!("--size {word}"))
    })
}

/// Parses LOW:HIGH, mm: pictures can be compared only with the same colour scale.
///
/// # Errors
/// When the word is not of this form, or the range is empty.
pub fn parse_range(word: &str) -> Result<(f32, f32), Failure> {
    let ends = word.split_once(':').and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    let usable = |(low, high): &(f32, f32)| low.is_finite() && high.is_finite() && low < high;
    ends.filter(usable).ok_or_else(|| {
        let help = "give LOW:HIGH in mm, such as 0.5:4";
        Failure::input(ErrorCode::Arguments, "not a colour scale", help).at(format!("--range {word}"))
    })
}
