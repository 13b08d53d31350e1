//! Contents of a part file in mm and radians about Z, before trimming, extension and validation. Readers
//! produce it, [`crate::part::Impeller::build`] turns it into a part.

use crate::error::{ErrorCode, UserError};
pub use crate::geometry::Meridional;
use crate::geometry::Point;

/// A meridional curve as a file gives it, inlet → outlet.
#[derive(Clone, Debug, PartialEq)]
pub enum CurveDescription {
    /// Points to interpolate.
    Points(Vec<Meridional>),
    /// A clamped cubic (or lower, with fewer control points) B-spline; `knots` may be empty: uniform.
    BSpline {
        /// Control points, at least two.
        control: Vec<Meridional>,
        /// Degree 1, 2 or 3.
        degree: usize,
        /// Full knot vector (`control.len() + degree + 1` values) or empty for uniform clamped.
        knots: Vec<f64>,
    },
}

/// Camber and thickness at one span of a blade that is given by angles.
#[derive(Clone, Debug, PartialEq)]
pub struct CamberSpan {
    /// Span fraction: 0 hub, 1 shroud.
    pub span: f64,
    /// Fraction of the channel's meridional arc length at the leading edge (0 for main blades).
    pub leading_edge: f64,
    /// Angular position θ of the leading edge, rad.
    pub theta_leading_edge: f64,
    /// (fraction from LE to TE, blade angle β from the meridional direction in rad; dθ = tan β dm / r).
    pub angle: Vec<(f64, f64)>,
    /// (fraction from LE to TE, thickness normal to the camber line in mm).
    pub thickness: Vec<(f64, f64)>,
}

/// A blade as a file gives it.
#[derive(Clone, Debug, PartialEq)]
pub enum BladeDescription {
    /// Span sections hub → tip; each side runs LE → TE. Both lists have the same length ≥ 2.
    Sections {
        /// Points of the suction side, per section.
        suction: Vec<Vec<Point>>,
        /// Points of the pressure side, per section.
        pressure: Vec<Vec<Point>>,
        /// Line of the file at which the blade starts.
        line: usize,
    },
    /// Camber angle and thickness per span (two or more spans, hub → tip).
    Camber {
        /// The spans.
        spans: Vec<CamberSpan>,
        /// Line of the file at which the blade starts.
        line: usize,
    },
}

/// Contents of a part file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartDescription {
    /// Name of the part: the file's own, else the file stem.
    pub name: String,
    /// Hub, inlet → outlet; may run far past the blades.
    pub hub: CurveDescription,
    /// Shroud, inlet → outlet; may run far past the blades.
    pub shroud: CurveDescription,
    /// Number of main blades around the wheel.
    pub blade_count: usize,
    /// The main blade.
    pub main: BladeDescription,
    /// Splitters of one pitch (zero or one is supported by the planner).
    pub splitters: Vec<BladeDescription>,
    /// Lines of the file, for messages: hub, shroud, blade count.
    pub hub_line: usize,
    /// See `hub_line`.
    pub shroud_line: usize,
    /// See `hub_line`.
    pub count_line: usize,
    /// Assumptions made where the file is ambiguous, one line each, for the user to confirm.
    pub notes: Vec<String>,
    /// Whether the names of the file's bodies make no wheel, so that their shapes decided the roles.
    pub roles_by_shape: bool,
}

impl PartDescription {
    /// Largest diameter of the main blade, or of the channel where the blade follows from it, mm.
    pub fn diameter(&self) -> f64 {
        let largest = |points: &mut dyn Iterator<Item = f64>| 2.0 * points.fold(0.0, f64::max);
        match &self.main {
            BladeDescription::Sections { suction, pressure, .. } => {
                let points = suction.iter().chain(pressure).flatten();
                largest(&mut points.map(|p| Meridional::from_point(p).r))
            }
            BladeDescription::Camber { .. } => {
                let points = |curve: &CurveDescription| match curve {
                    CurveDescription::Points(points) => points.clone(),
                    CurveDescription::BSpline { control, .. } => control.clone(),
                };
                largest(&mut points(&self.hub).iter().chain(&points(&self.shroud)).map(|p| p.r))
            }
        }
    }
}

/// Why a description is not a valid impeller; the caller adds the file name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}; {help}")]
pub struct PartError {
    /// Its kind.
    pub code: ErrorCode,
    /// Line of the part file, 0 when the fault has no line.
    pub line: usize,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

impl PartError {
    /// A fault at `line` (0: none).
    pub fn new(code: ErrorCode, line: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { code, line, message: message.into(), help: help.into() }
    }

    /// The same error with help for a part whose curves and sections were found in surfaces, so that no file
    /// has a line of them.
    pub(super) fn of_surfaces(self, part: &PartDescription) -> Self {
        let help = match self.code {
            _ if part.hub_line != 0 || self.line != 0 => return self,
            ErrorCode::CurvesSwapped => {
                "if the file has both, exchange their roles; else the line found along the blade tips is not \
                 theirs: add the surface of revolution through them to the file, named `Shroud`"
            }
            ErrorCode::BladeTooShort => {
                "curves and sections were found in the file's surfaces: where tips or trailing edges are not \
                 turned, add the surface of revolution through the tips to the file, named `Shroud`"
            }
            _ => return self,
        };
        Self { help: help.to_owned(), ..self }
    }
}

impl From<PartError> for UserError {
    fn from(error: PartError) -> Self {
        Self::new(error.code, error.message, error.help)
    }
}
