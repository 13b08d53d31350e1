//! Whether a tool meets the table that carries the part, wherever the axes are between two steps.
//!
//! The table is a disc, fixed in the frame of the program as the part is. The tool is its cutter up to the
//! overhang, and above it, up to the spindle's nose, a holder that is assumed to have twice its diameter.

use super::course::{Pose, even_turn};
use super::model::{AxisSide, MachineTable, MachineTool};
use super::step::{MachineStep, StepMotion};
use crate::geometry::Point;
use crate::toolpath::ClTool;

/// Largest way of the tip and turn of the axis from one place that is looked at to the next, mm and rad.
const STEP: (f64, f64) = (5.0, 2.0 * std::f64::consts::PI / 180.0);
/// Spacing of the places along the tool, mm.
const ALONG: f64 = 5.0;

/// A part of a tool below the upper face of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TableContact {
    /// Index of the step, and of its tool.
    pub step: usize,
    pub tool: usize,
    /// Whether it is the holder, not the cutter.
    pub is_holder: bool,
    /// How far below, mm.
    pub depth: f64,
}

/// The first contact of a motion with the table; `tools` are those of its program, `lengths` theirs from the
/// gauge point to the tip, mm.
pub(super) fn table_contact(
    machine: &MachineTool,
    steps: &[MachineStep],
    tools: &[ClTool],
    lengths: &[f64],
) -> Option<TableContact> {
    let table = machine.table?;
    let first = &machine.rotary[0];
    let centre = if first.side == AxisSide::Table { first.point } else { machine.part.origin };
    let centre = Point::new(centre.x, centre.y, table.top) - machine.part.origin.coords;
    let mut before: Option<&MachineStep> = None;
    for (index, step) in steps.iter().enumerate() {
        let from = before.filter(|_| step.motion != StepMotion::Approach).map_or(step.pose, |b| b.pose);
        before = Some(step);
        let (Some(tool), Some(&length)) = (tools.get(step.tool), lengths.get(step.tool)) else { continue };
        let body = ToolBody { tool, length, table, centre };
        if !body.may_be_below(&from) && !body.may_be_below(&step.pose) {
            continue;
        }
        let (way, turn) = ((step.pose.tip - from.tip).norm(), from.axis.angle(&step.pose.axis));
        let count = (way / STEP.0).max(turn / STEP.1).ceil().clamp(1.0, 1e4) as usize;
        for k in 1..=count {
            let share = k as f64 / count as f64;
            let tip = from.tip + (step.pose.tip - from.tip) * share;
            let axis = even_turn(&from.axis, &step.pose.axis, share);
            if let Some((is_holder, depth)) = body.contact(&Pose { tip, axis, ..step.pose }) {
                return Some(TableContact { step: index, tool: step.tool, is_holder, depth });
            }
        }
    }
    None
}

/// A tool above a table, in program coordinates.
struct ToolBody<'a> {
    tool: &'a ClTool,
    length: f64,
    table: MachineTable,
    centre: Point,
}

impl ToolBody<'_> {
    /// Whether any part of the tool may be lower than the table's upper face.
    fn may_be_below(&self, pose: &Pose) -> bool {
        let lowest = pose.tip.z.min(pose.tip.z + pose.axis.z * self.length);
        lowest - self.tool.diameter < self.centre.z
    }

    /// The deepest place below the upper face, within the table's radius: whether it is on the holder, and
    /// how deep.
    fn contact(&self, pose: &Pose) -> Option<(bool, f64)> {
        let overhang = self.tool.overhang.unwrap_or(self.length).min(self.length);
        let slant = (1.0 - pose.axis.z * pose.axis.z).max(0.0).sqrt();
        let count = (self.length / ALONG).ceil().max(1.0) as usize;
        let places = (0..=count).map(|k| self.length * k as f64 / count as f64);
        let below = |along: f64| {
            let is_holder = along > overhang;
            let radius = if is_holder { self.tool.diameter } else { 0.5 * self.tool.diameter };
            let at = pose.tip + pose.axis * along;
            let off = (at.x - self.centre.x).hypot(at.y - self.centre.y) - radius;
            let depth = self.centre.z - (at.z - radius * slant);
            (off < self.table.radius && depth > 0.0).then_some((is_holder, depth))
        };
        places.filter_map(below).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
