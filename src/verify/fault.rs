//! Faults of a program and their messages, common to plunge and flank programs.

use std::fmt::{Display, Formatter};

use crate::error::{ErrorCode, UserError};
use crate::geometry::Vector;
use crate::monitor::Cancelled;
use crate::part::Impeller;
use crate::setup::{AllowanceSetup, Setup, TILT_TOLERANCE, Tool, falls_short};

/// Kind of a fault, and the meaning of its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The core of a plunge meets stock; value: how far above its bottom, mm.
    CoreContact,
    /// A cut comes nearer to the hub than its allowance; value: the distance, mm.
    HubAllowance,
    /// A cut comes nearer to a blade than its allowance; value: the distance, mm.
    BladeAllowance,
    /// A rapid comes nearer to the blank than the safety distance; value: the distance, mm.
    RapidClearance,
    /// A rapid goes through stock; value: how deep the stock gets into the cutter, mm; none for a thin layer.
    RapidInStock,
    /// In a rapid the tool above its bottom runs into the blank; value: how far above the bottom, mm.
    ToolInBlank,
    /// The shank comes too near to the finished part, or runs into stock; value: the clearance that is
    /// missing, mm.
    ShankCollision,
    /// The holder comes too near to the finished part, or runs into stock; value: the clearance that is
    /// missing, mm. An assumed holder collides with a blade, its allowance, or the hub; no value.
    HolderCollision,
    /// The holder collides with remaining stock; value: how deep the stock gets into it, mm; none for a thin
    /// layer.
    HolderInStock,
    /// The axis tilts beyond the machine's limit; value: the tilt, degrees.
    AxisTilt,
    /// An axis of the machine is beyond its limits; value: its position, mm or degrees.
    AxisLimit,
    /// The axis turns too far in one move; value: the turn, degrees.
    AxisTurn,
    /// A cut engages deeper than the tool is long, or than is plausible for its diameter; value: the depth,
    /// mm.
    TooDeep,
    /// Cuts without a feed rate; value: their number.
    NoFeed,
    /// Cuts while the program has stopped the spindle; value: their number.
    SpindleStopped,
    /// The program cuts nothing of the part.
    CutsNothing,
    /// A tool differs from the one of that number in the setup; value: its diameter, mm.
    ToolDiffers,
    /// A cut cannot be checked, as something is missing.
    NotJudged,
}

impl FaultKind {
    /// Whether a shank or holder is in the way.
    pub fn is_of_assembly(self) -> bool {
        matches!(self, Self::ShankCollision | Self::HolderCollision | Self::HolderInStock)
    }

    /// Noun phrase for `count` faults of this kind.
    pub fn phrase(self, count: usize) -> &'static str {
        let (one, many) = match self {
            Self::CoreContact => ("plunge whose core meets stock", "plunges whose core meets stock"),
            Self::HubAllowance => ("cut below the hub's allowance", "cuts below the hub's allowance"),
            Self::BladeAllowance => ("cut below a blade's allowance", "cuts below a blade's allowance"),
            Self::RapidClearance => ("rapid too near to the blank", "rapids too near to the blank"),
            Self::RapidInStock => ("rapid through stock", "rapids through stock"),
            Self::ToolInBlank => ("rapid with the tool in the blank", "rapids with the tool in the blank"),
            Self::ShankCollision => {
                ("move with the shank too near to the part", "moves with the shank too near to the part")
            }
            Self::HolderCollision => {
                ("move with the holder too near to the part", "moves with the holder too near to the part")
            }
            Self::HolderInStock => ("move with the holder in stock", "moves with the holder in stock"),
            Self::AxisTilt => ("axis beyond the machine's tilt", "axes beyond the machine's tilt"),
            Self::AxisLimit => ("position beyond an axis limit", "positions beyond an axis limit"),
            Self::AxisTurn => ("move that turns the axis too far", "moves that turn the axis too far"),
            Self::TooDeep => ("cut too deep at once", "cuts too deep at once"),
            Self::NoFeed => ("cut without a feed rate", "cuts without a feed rate"),
            Self::SpindleStopped => ("cut with the spindle stopped", "cuts with the spindle stopped"),
            Self::CutsNothing => ("program that cuts nothing", "programs that cut nothing"),
            Self::ToolDiffers => ("tool that differs from the setup", "tools that differ from the setup"),
            Self::NotJudged => ("cut that cannot be judged", "cuts that cannot be judged"),
        };
        if count == 1 { one } else { many }
    }
}

/// A fault of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Line of the program, 0 when there is none.
    pub line: usize,
    /// Kind of fault.
    pub kind: FaultKind,
    /// Measured value: see [`FaultKind`].
    pub value: Option<f64>,
    /// What is wrong.
    pub message: String,
    /// What to do about it; empty where the message says all.
    pub help: String,
    /// The overhang with which a holder in the way would be clear, mm.
    pub overhang: Option<f64>,
}

impl Display for Fault {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self.help.as_str() {
            "" => f.write_str(&self.message),
            help => write!(f, "{}; {help}", self.message),
        }
    }
}

/// Why a program is not judged.
#[derive(Clone, Debug, PartialEq)]
pub enum VerifyError {
    /// It cannot be judged for this fault.
    Program(Fault),
    /// The work was cancelled.
    Cancelled(Cancelled),
}

impl Display for VerifyError {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Program(fault) => fault.fmt(f),
            Self::Cancelled(cancelled) => cancelled.fmt(f),
        }
    }
}

impl std::error::Error for VerifyError {}

impl From<Fault> for VerifyError {
    fn from(fault: Fault) -> Self {
        Self::Program(fault)
    }
}

impl From<Cancelled> for VerifyError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Cancelled(cancelled)
    }
}

impl From<VerifyError> for UserError {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Program(fault) => fault.into(),
            VerifyError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

/// A program that cannot be judged for this fault: it cuts nothing, or lacks a tool.
impl From<Fault> for UserError {
    fn from(fault: Fault) -> Self {
        let code = match fault.kind {
            FaultKind::CutsNothing => ErrorCode::NothingMoves,
            _ => ErrorCode::ProgramTool,
        };
        Self::new(code, fault.message, fault.help)
    }
}

/// A fault before its line is known.
pub(super) struct Finding {
    kind: FaultKind,
    value: Option<f64>,
    message: String,
    help: String,
    overhang: Option<f64>,
}

impl Finding {
    /// A finding that says what is wrong; see [`Self::with_help`].
    pub(super) fn new(kind: FaultKind, value: impl Into<Option<f64>>, what: impl Into<String>) -> Self {
        Self { kind, value: value.into(), message: what.into(), help: String::new(), overhang: None }
    }

    /// Adds what to do about it.
    pub(super) fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: help.into(), ..self }
    }

    /// Adds the overhang with which a holder in the way would be clear, mm.
    pub(super) fn with_overhang(self, overhang: Option<f64>) -> Self {
        Self { overhang, ..self }
    }

    /// The fault in line `line` of the program.
    pub(super) fn at(self, line: usize) -> Fault {
        Fault {
            line,
            kind: self.kind,
            value: self.value,
            message: self.message,
            help: self.help,
            overhang: self.overhang,
        }
    }
}

impl Fault {
    pub(super) fn before_tool(line: usize) -> Self {
        let what = "cuts before any tool is loaded";
        Finding::new(FaultKind::NotJudged, None, what).with_help("add LOADTL and CUTTER before it").at(line)
    }

    pub(super) fn without_diameter(line: usize, tool: &Tool) -> Self {
        let what = format!("tool {} has the diameter {}", tool.number, tool.diameter);
        Finding::new(FaultKind::NotJudged, tool.diameter, what)
            .with_help("give CUTTER/ its diameter")
            .at(line)
    }
}

/// Counts of faults of each kind, in words, the most serious kind first; empty without faults.
pub fn count_by_kind(faults: &[Fault]) -> String {
    let mut kinds: Vec<FaultKind> = faults.iter().map(|fault| fault.kind).collect();
    kinds.sort_unstable();
    let words =
        kinds.chunk_by(|a, b| a == b).map(|same| format!("{} {}", same.len(), same[0].phrase(same.len())));
    words.collect::<Vec<_>>().join(", ")
}

/// The fault of a cut `distance` mm from the finished hub, if it misses its allowance by more than
/// `tolerance` mm.
pub(super) fn near_hub(distance: f64, stock: &AllowanceSetup, tolerance: f64) -> Option<Finding> {
    let allowance = stock.hub_allowance;
    (distance < allowance - tolerance).then(|| {
        let what = format!("comes within {distance:.4} mm of the hub; the allowance is {allowance} mm");
        Finding::new(FaultKind::HubAllowance, distance, what)
    })
}

/// As [`near_hub`], for the finished blades.
pub(super) fn near_blade(distance: f64, stock: &AllowanceSetup, tolerance: f64) -> Option<Finding> {
    let allowance = stock.blade_allowance;
    (distance < allowance - tolerance).then(|| {
        let what = format!("comes within {distance:.4} mm of a blade; the allowance is {allowance} mm");
        Finding::new(FaultKind::BladeAllowance, distance, what)
    })
}

/// The fault of a rapid `distance` mm from the blank, if that is too near.
pub(super) fn rapid_near_blank(distance: f64, stock: &AllowanceSetup) -> Option<Finding> {
    let safety = stock.safety_distance;
    falls_short(distance, safety).then(|| {
        let what =
            format!("moves in rapid {distance:.3} mm from the blank; the safety distance is {safety} mm");
        Finding::new(FaultKind::RapidClearance, distance, what)
    })
}

/// The fault of a rapid down to `distance` mm from what earlier cuts left, negative in it, if that is too
/// near.
pub(super) fn rapid_near_stock(distance: f64, stock: &AllowanceSetup) -> Option<Finding> {
    let safety = stock.safety_distance;
    let (kind, value, what) = if distance < 0.0 {
        let depth = -distance;
        let what =
            format!("comes down in rapid, {depth:.3} mm deep into stock that no cut before it removed");
        (FaultKind::RapidInStock, depth, what)
    } else {
        let what = format!(
            "comes down in rapid to {distance:.3} mm from standing stock; the safety distance is {safety} mm"
        );
        (FaultKind::RapidClearance, distance, what)
    };
    let help = "end the rapid higher, or cut that stock before";
    falls_short(distance, safety).then(|| Finding::new(kind, value, what).with_help(help))
}

/// The fault of a plunge whose core meets stock up to `depth` mm above its bottom, over a share of its area
/// where that is known.
pub(super) fn core_in_stock(depth: f64, area_share: Option<f64>) -> Finding {
    let over = area_share.map_or(String::new(), |share| format!(", over {:.0} % of its area", 100.0 * share));
    let what = format!("interferes: the core meets stock up to {depth:.3} mm above its bottom{over}");
    Finding::new(FaultKind::CoreContact, depth, what)
}

/// The fault of a tool axis beyond the machine's limit in `setup`.
pub(super) fn beyond_machine(part: &Impeller, setup: &Setup, axis: &Vector) -> Option<Finding> {
    let (limit, beyond) = (setup.machine.max_axis_tilt_rad, setup.machine.excess_tilt_rad(part, axis));
    (beyond > TILT_TOLERANCE).then(|| {
        let tilt = (beyond + limit).to_degrees();
        let what = format!(
            "tilts the axis by {tilt:.2}° from the part's; the machine reaches {:.2}°",
            limit.to_degrees()
        );
        Finding::new(FaultKind::AxisTilt, tilt, what)
    })
}

/// The fault of cuts without a feed rate, at `lines`.
pub(super) fn missing_feed(lines: &[usize]) -> Option<Fault> {
    cuts_in_error(FaultKind::NoFeed, lines, "without a feed rate", "give FEDRAT")
}

/// The fault of cuts with a stopped spindle, by the lines of all cuts and those of the moves under feed while
/// it is stopped (ascending).
pub(super) fn stopped_spindle(cuts: impl Iterator<Item = usize>, stopped: &[usize]) -> Option<Fault> {
    let lines: Vec<usize> = cuts.filter(|line| stopped.binary_search(line).is_ok()).collect();
    cuts_in_error(FaultKind::SpindleStopped, &lines, "with the spindle stopped", "give SPINDL with a speed")
}

/// One fault for all cuts in `lines`, which the program makes in a `state` that `remedy` would have ended.
fn cuts_in_error(kind: FaultKind, lines: &[usize], state: &str, remedy: &str) -> Option<Fault> {
    let first = *lines.first()?;
    let count = lines.len();
    let (what, cuts) = match count {
        1 => (format!("cuts {state}"), "it"),
        _ => (format!("cuts {state}, as {} others do", count - 1), "them"),
    };
    Some(Finding::new(kind, count as f64, what).with_help(format!("{remedy} before {cuts}")).at(first))
}

/// The fault of a tool of the program, first used in `line`, that differs from the setup's tool of the same
/// number.
pub(super) fn tool_mismatch(line: usize, tool: &Tool, setup: &Setup) -> Option<Fault> {
    let known = setup.tools.iter().find(|known| known.number == tool.number)?;
    let differs = (known.diameter - tool.diameter).abs() > 1e-3
        || (known.corner_radius - tool.corner_radius).abs() > 1e-3;
    differs.then(|| {
        let what = format!(
            "tool {} is D {} R {} here and D {} R {} in the setup",
            tool.number, tool.diameter, tool.corner_radius, known.diameter, known.corner_radius
        );
        Finding::new(FaultKind::ToolDiffers, tool.diameter, what).with_help("correct one of them").at(line)
    })
}

#[cfg(test)]
mod tests {
    use super::{Fault, FaultKind, count_by_kind};

    #[test]
    fn one_fault_is_named_in_the_singular() {
        let fault = |kind: FaultKind| Fault {
            line: 1,
            kind,
            value: None,
            message: String::new(),
            help: String::new(),
            overhang: None,
        };
        let faults = [FaultKind::CutsNothing, FaultKind::NoFeed, FaultKind::NoFeed].map(fault);
        assert_eq!(count_by_kind(&faults), "2 cuts without a feed rate, 1 program that cuts nothing");
    }
}
