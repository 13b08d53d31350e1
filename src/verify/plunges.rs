//! From a program's moves to cuts: where the cutter is when it cuts, and where it flies.

use super::Fault;
use crate::formats::apt::{ClProgram, Motion, Move};
use crate::geometry::{CutterSolid, Point};
use crate::part::{Setup, Tool};

/// One move under feed, with the rapids around it.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Line of the program.
    pub line: usize,
    /// The tool.
    pub tool: Tool,
    /// The cutter at the end of the move.
    pub cutter: CutterSolid,
    /// The cutter along the move; one place for a plunge along the axis, which the column stands for.
    pub swept: Vec<CutterSolid>,
    /// The cutter along the rapids that lead here, and at the retract point.
    pub rapids: Vec<CutterSolid>,
    /// Where the move started.
    pub retract: Point,
    /// Counts tool changes.
    pub section: usize,
    /// Counts jumps within a section that are much longer than a step.
    pub row: usize,
}

/// Spacing of the places looked at along a move, in cutter radii.
const SAMPLE_RADII: f64 = 0.5;
/// Most places looked at along one move.
const MAX_SAMPLES: usize = 200;

/// All cuts of a program. Tools the setup knows by number give the insert width where the program is silent.
///
/// # Errors
/// A cut before any tool.
pub fn cuts_of(program: &ClProgram, setup: &Setup) -> Result<Vec<Cut>, Fault> {
    let tools: Vec<Tool> = program.tools.iter().map(|t| tool_of(t, setup)).collect();
    let mut cuts: Vec<Cut> = Vec::new();
    let mut rapids: Vec<CutterSolid> = Vec::new();
    let mut section = 0;
    let mut row = 0;
    let mut last_tool = None;
    let mut previous: Option<&Move> = None;
    for (index, step) in program.moves.iter().enumerate() {
        let Some(number) = step.tool else {
            if matches!(step.motion, Motion::Feed(_)) && index > 0 {
                return Err(Fault::before_tool(step.line));
            }
            previous = Some(step);
            continue;
        };
        let tool = &tools[number];
        if tool.diameter <= 0.0 {
            return Err(Fault::without_diameter(step.line, tool));
        }
        let at = |p: Point, axis| tool.placed(p, axis);
        let changed = last_tool.is_some_and(|t| t != number);
        if changed {
            section += 1;
            row = 0;
        }
        let from = previous.filter(|p| p.tool == Some(number)).unwrap_or(step);
        let between = |share: f64| {
            at(
                from.tip + (step.tip - from.tip) * share,
                (from.axis + (step.axis - from.axis) * share).normalize(),
            )
        };
        let length = (step.tip - from.tip).norm();
        let samples = ((length / (SAMPLE_RADII * tool.radius())).ceil() as usize).clamp(1, MAX_SAMPLES);
        // Along the axis the cutter stays in its own column: only the lower end counts.
        let travel = step.tip - from.tip;
        let across = (travel - step.axis * travel.dot(&step.axis)).norm();
        let axial = across < 1e-4 * (1.0 + length) && from.axis.angle(&step.axis) < 1e-5;
        match step.motion {
            Motion::Rapid => {
                let upwards = axial && travel.dot(&step.axis) >= 0.0 && previous.is_some();
                let places = if upwards || length == 0.0 { 1..=1 } else { 1..=samples };
                let count = *places.end();
                rapids.extend(places.map(|i| between(i as f64 / count as f64)));
            }
            Motion::Feed(_) => {
                let cutter = at(step.tip, step.axis);
                let swept = if axial && travel.dot(&step.axis) <= 0.0 {
                    vec![cutter]
                } else {
                    (0..=samples).map(|i| between(i as f64 / samples as f64)).collect()
                };
                if let Some(before) = cuts.last().filter(|c| c.section == section)
                    && (step.tip - before.cutter.tip).norm() > 2.5 * tool.radius()
                {
                    row += 1;
                }
                cuts.push(Cut {
                    line: step.line,
                    tool: tool.clone(),
                    cutter,
                    swept,
                    rapids: std::mem::take(&mut rapids),
                    retract: from.tip,
                    section,
                    row,
                });
            }
        }
        last_tool = Some(number);
        previous = Some(step);
    }
    if let Some(last) = cuts.last_mut() {
        last.rapids.append(&mut rapids);
    }
    Ok(cuts)
}

/// The tool of a program, completed by the setup.
pub(super) fn tool_of(tool: &crate::formats::apt::ClTool, setup: &Setup) -> Tool {
    let known =
        setup.tools.iter().find(|t| t.number == tool.number && (t.diameter - tool.diameter).abs() < 1e-6);
    let insert_width =
        tool.insert_width.or(known.map(|t| t.insert_width)).unwrap_or(0.9 * tool.diameter / 2.0);
    Tool {
        number: tool.number,
        diameter: tool.diameter,
        corner_radius: tool.corner_radius,
        insert_width: insert_width.min(tool.diameter / 2.0),
        overhang: tool.overhang.or(known.map(|t| t.overhang)).unwrap_or(4.0 * tool.diameter),
        plunge_feed: tool.feed.or(known.map(|t| t.plunge_feed)).unwrap_or(300.0),
        spindle: tool.spindle.or(known.map(|t| t.spindle)).unwrap_or(1200.0),
    }
}
