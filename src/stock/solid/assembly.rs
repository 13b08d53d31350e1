//! Tools as stacks of cylinders and cones about one axis: cutter, shank, holder.

use super::outline::Outline;
use super::part::ToolPart;
use crate::setup::{AssemblyPart, AssemblySegment, Tool};

/// Length of a holder that is not described, mm: beyond any wheel.
const ENDLESS: f64 = 1e5;

/// Length by which slices of a cutter overlap, mm, so that rounding leaves no stock between them.
pub(super) const OVERLAP: f64 = 1e-6;

/// A cylinder or cone of shank or holder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidSegment {
    /// Which part of the tool it belongs to.
    pub part: ToolPart,
    /// Height of its lower end above the tip, mm.
    pub from: f64,
    /// Its length, mm.
    pub length: f64,
    /// Radius at its lower end, mm.
    pub lower: f64,
    /// Radius at its upper end, mm.
    pub upper: f64,
}

impl SolidSegment {
    fn from_segment(described: &AssemblySegment) -> Self {
        let part = match described.part {
            AssemblyPart::Shank => ToolPart::Shank,
            AssemblyPart::Holder => ToolPart::Holder,
        };
        let [lower, upper] = described.radii;
        Self { part, from: described.from, length: described.length, lower, upper }
    }
}

/// A tool: a cutter with flat, rounded, ball-shaped or tapered end, and the stack above it.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidTool {
    /// Number of the tool, for messages.
    pub number: u32,
    /// Radius of the cutter where its corner ends, mm; of a ball its radius.
    pub radius: f64,
    /// Corner radius, mm; 0 for a sharp corner, `radius` for a ball.
    pub corner_radius: f64,
    /// Angle between axis and flank, rad; positive where the cutter widens upwards.
    pub taper_rad: f64,
    /// Height above the tip up to which it cuts, mm.
    pub cutting_length: f64,
    /// Radius of the core, which has no cutting edge, mm; 0 where there is none.
    pub core_radius: f64,
    /// Shank and holder, from the cutter to the spindle.
    pub segments: Vec<SolidSegment>,
}

impl SolidTool {
    /// The assembly of a tool as setups describe it. Without a shank it cuts over its overhang; without a
    /// holder a cylinder of [`Tool::holder_diameter`] begins there.
    pub fn from_tool(tool: &Tool) -> Self {
        Self::assembled(tool, true)
    }

    /// As [`Self::from_tool`], but nothing above the overhang where the holder is not described.
    pub fn described(tool: &Tool) -> Self {
        Self::assembled(tool, false)
    }

    fn assembled(tool: &Tool, assumes_holder: bool) -> Self {
        let described = tool.assembly.segments(tool.overhang);
        let shank = described.iter().find(|segment| segment.part == AssemblyPart::Shank);
        let cutting_length = shank.map_or(tool.overhang, |shank| shank.from).max(tool.corner_radius);
        let mut segments: Vec<SolidSegment> = described.iter().map(SolidSegment::from_segment).collect();
        if tool.assembly.holder.is_empty() && assumes_holder {
            let radius = 0.5 * tool.holder_diameter();
            let (part, from) = (ToolPart::Holder, tool.overhang);
            segments.push(SolidSegment { part, from, length: ENDLESS, lower: radius, upper: radius });
        }
        Self {
            number: tool.number,
            radius: tool.radius(),
            corner_radius: tool.corner_radius.clamp(0.0, tool.radius()),
            taper_rad: tool.assembly.taper_rad.unwrap_or(0.0),
            cutting_length,
            core_radius: tool.core_radius().max(0.0),
            segments,
        }
    }

    /// The cutter as slices from the tip upwards, each with the height of its lower end. Where `rounds` is
    /// true the rounded corner is one slice; otherwise it is a stack of cones within `tolerance`, mm.
    pub(super) fn cutter(&self, rounds: bool, tolerance: f64) -> Vec<(f64, Outline)> {
        let corner = self.corner_radius;
        // The corner ends where it is tangent to the flank.
        let tangent = corner * (1.0 - self.taper_rad.sin());
        let flat = (self.radius - corner).max(0.0);
        let mut slices = Vec::new();
        if corner > 0.0 {
            if flat < 1e-9 * self.radius {
                slices.push((0.0, Outline::ball(corner, tangent + OVERLAP)));
            } else if rounds {
                slices.push((0.0, Outline::rounded(flat, corner, tangent + OVERLAP)));
            } else {
                // Chords of the corner, moved out by half their sagitta: the error is ± that half.
                let angle = std::f64::consts::FRAC_PI_2 - self.taper_rad;
                let step = 2.0 * (1.0 - (2.0 * tolerance / corner).min(0.5)).acos();
                let count = (angle / step).ceil().max(1.0);
                let out = corner * (1.0 + 0.5 * (1.0 - (0.5 * angle / count).cos()));
                let at = |i: f64| {
                    let (sin, cos) = (angle * i / count).sin_cos();
                    (flat + out * sin, (corner - out * cos).max(0.0))
                };
                for i in 0..count as usize {
                    let ((lower, from), (upper, to)) = (at(i as f64), at(i as f64 + 1.0));
                    let lower = if i == 0 { flat } else { lower };
                    if to > from {
                        slices.push((from, Outline::cone(lower, upper, to - from + OVERLAP)));
                    }
                }
            }
        }
        let length = (self.cutting_length - tangent).max(0.0);
        let lower = flat + corner * self.taper_rad.cos();
        let upper = (lower + length * self.taper_rad.tan()).max(0.0);
        slices.push((tangent, Outline::cone(lower, upper, length)));
        slices
    }
}
