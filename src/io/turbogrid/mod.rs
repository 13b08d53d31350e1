//! TurboGrid parts as exported by BladeGen: an `.inf` file and its `.curve` files.
//!
//! `.inf`: `Key: value` lines, `!` starts a comment; unknown keys are skipped.
//!
//! ```text
//! Axis of Rotation: Z            or X, Y; mapped to Z by cyclic permutation
//! Number of Blade Sets: 12       number of main blades
//! Geometry Units: MM             MM, CM, M, IN or FT
//! Hub Data File: hub.curve       relative to the folder of the .inf file
//! Shroud Data File: shroud.curve
//! Profile Data File: profile.curve
//! ```
//!
//! Hub and shroud: `x y z` per line, upstream to downstream; r is the distance from the axis.
//! Profile: `## Main Blade` names a blade, `# Profile 1 at 0.0000%` starts a section (hub to tip),
//! then one closed loop of `x y z` with an optional `le`, `te`, `te1` or `te2`. Coordinates are in the
//! frame of the part.

mod inf;
mod profile;

use std::path::Path;

use super::InputError;
use super::source::{Source, name_of, read_bytes, stem_of, text_lossy};
use crate::error::ErrorCode;
use crate::part::{CurveDescription, PartDescription};
use inf::{Inf, TurboGridFrame};

/// Reads a part from its `.inf` file and the files that it names. Errors name the file they are in.
pub(super) fn read(path: &Path) -> Result<PartDescription, InputError> {
    let name = name_of(path);
    let source = Source::new(&name, ErrorCode::PartFile);
    let bytes = read_bytes(path)?;
    let text = text_lossy(source, &bytes)?;
    let inf = Inf::parse(source, &text);
    let frame = TurboGridFrame::from_inf(&inf)?;
    let (count, count_line) = inf.need("number of blade sets", "Number of Blade Sets: 12")?;
    let blade_count = source.blades(count_line, count)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (hub, hub_line) = inf.flowpath(folder, "hub", frame)?;
    let (shroud, shroud_line) = inf.flowpath(folder, "shroud", frame)?;
    let (profile, profile_line) = inf.data_file(folder, "profile")?;
    let (main, splitters) = profile::read(&profile, profile_line, frame, [&hub, &shroud])?;
    Ok(PartDescription {
        name: stem_of(&name),
        hub: CurveDescription::Points(hub),
        shroud: CurveDescription::Points(shroud),
        blade_count,
        main,
        splitters,
        hub_line,
        shroud_line,
        count_line,
        notes: Vec::new(),
        roles_by_shape: false,
    })
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests make their own files")]
mod tests;
