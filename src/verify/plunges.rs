//! Groups the moves of a program into cuts, each with the rapids around it.

use super::Fault;
use crate::geometry::{CutterSolid, Point, Vector};
use crate::plunge::SectionPlan;
use crate::setup::{Setup, Tool};
use crate::toolpath::{ClProgram, ClTool, Motion, Move, is_axial};

/// Spacing of the samples along a move, in cutter radii.
const SAMPLE_RADII: f64 = 0.5;
/// Largest number of samples along one move.
const MAX_SAMPLES: usize = 200;
/// A move under feed after a plunge is its lead-out, and not a cut, if more than this share of it goes up the
/// axis.
const LEAVING_SHARE: f64 = 0.5;
/// Distance of two tips from which on a new row begins where the program names no rows, in cutter radii: a
/// step is at most one radius, and a stepover usually 4/3.
const NEW_ROW_RADII: f64 = 2.5;

/// One move under feed, with the rapids around it.
#[derive(Clone, Debug)]
pub struct ProgramCut {
    /// Line of the program.
    pub line: usize,
    /// The tool.
    pub tool: Tool,
    /// Index of the tool in the program.
    pub tool_index: usize,
    /// The cutter at the end of the move.
    pub cutter: CutterSolid,
    /// The cutter sampled along the move; only its end for a plunge along the axis, whose column contains the
    /// rest.
    pub swept: Vec<CutterSolid>,
    /// The rapids before the cut; of the last cut of a tool those after it, too.
    pub rapids: Vec<Rapid>,
    /// The cutter along the move under feed by which it leaves the stock beside it, off it and up; empty
    /// without.
    pub lead_out: Vec<CutterSolid>,
    /// Index of its move in the program.
    pub index: usize,
    /// Where the move started.
    pub retract: Point,
    /// Whether the program gives it a feed rate.
    pub has_feed: bool,
    /// Index of the section that the program names; otherwise the number of tool changes before it.
    pub section: usize,
    /// The row that the program names; otherwise the number of jumps before it within the section that are
    /// much longer than a step.
    pub row: usize,
}

/// One move in rapid.
#[derive(Clone, Copy, Debug)]
pub struct Rapid {
    /// Line of the program.
    pub line: usize,
    /// Tip and axis where it starts, if the program says so: not after a tool change.
    pub from: Option<(Point, Vector)>,
    /// Tip and axis where it ends.
    pub to: (Point, Vector),
}

impl Rapid {
    /// Whether the cutter only retracts along its own axis, or does not move.
    pub fn is_retract(&self) -> bool {
        let Some((from, axis)) = self.from else { return true };
        let travel = self.to.0 - from;
        is_axial(&travel, &axis, &self.to.1) && travel.dot(&self.to.1) >= 0.0
    }

    /// Whether the cutter comes down along its own axis.
    pub fn is_approach(&self) -> bool {
        let Some((from, axis)) = self.from else { return false };
        let travel = self.to.0 - from;
        is_axial(&travel, &axis, &self.to.1) && travel.dot(&self.to.1) < 0.0
    }
}

impl ProgramCut {
    /// Whether the plunge went down to its end along the axis, and nothing else.
    fn is_plunge(&self) -> bool {
        self.swept.len() == 1 && self.lead_out.is_empty()
    }

    /// Whether a move from `from` to `cutter` goes on where this plunge was interrupted: further down in its
    /// own column, after no other move than back in it.
    fn is_continued_by(&self, from: &Point, cutter: &CutterSolid, rapids: &[Rapid]) -> bool {
        let own = |tip: &Point| is_axial(&(tip - self.cutter.tip), &self.cutter.axis, &cutter.axis);
        let below_start = |tip: &Point| (self.retract - tip).dot(&cutter.axis) >= 0.0;
        self.is_plunge()
            && own(&cutter.tip)
            && own(from)
            && (cutter.tip - self.cutter.tip).dot(&cutter.axis) < 0.0
            && below_start(from)
            && rapids.iter().all(|rapid| rapid.is_retract())
    }
}

/// All cuts of a program. Where the program gives no insert width, that of the setup's tool of the same
/// number is used. A plunge that is interrupted to break the chip is one cut, and so is one with a move under
/// feed that leaves it, up and off the stock.
///
/// # Errors
/// When a cut comes before any tool, or a tool has no diameter; the fault names the line.
pub fn cuts_of(program: &ClProgram, setup: &Setup) -> Result<Vec<ProgramCut>, Fault> {
    let tools: Vec<Tool> = program.tools.iter().map(|t| t.completed(setup)).collect();
    let mut cuts: Vec<ProgramCut> = Vec::new();
    let mut rapids: Vec<Rapid> = Vec::new();
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
        if last_tool.is_some_and(|t| t != number) {
            // The retract after the last cut of a tool belongs to that tool.
            if let Some(last) = cuts.last_mut() {
                last.rapids.append(&mut rapids);
            }
            // A tool that only makes rapids has no section.
            if cuts.last().is_some_and(|last| last.section == section) {
                section += 1;
            }
            row = 0;
        }
        let start = previous.filter(|p| p.tool == Some(number));
        match step.motion {
            Motion::Rapid => {
                let from = start.map(|from| (from.tip, from.axis));
                rapids.push(Rapid { line: step.line, from, to: (step.tip, step.axis) });
            }
            Motion::Feed(feed) => {
                let from = start.unwrap_or(step);
                let cutter = at(step.tip, step.axis);
                let travel = step.tip - from.tip;
                let samples = (travel.norm() / (SAMPLE_RADII * tool.radius())).ceil() as usize;
                let samples = samples.clamp(1, MAX_SAMPLES);
                let between = |share: f64| {
                    let axis = from.axis + (step.axis - from.axis) * share;
                    at(from.tip + travel * share, axis.try_normalize(1e-9).unwrap_or(step.axis))
                };
                // Along the axis the cutter stays in its own column: only the lower end counts.
                let down = is_axial(&travel, &from.axis, &step.axis) && travel.dot(&step.axis) <= 0.0;
                let swept = if down {
                    vec![cutter]
                } else {
                    (0..=samples).map(|i| between(i as f64 / samples as f64)).collect()
                };
                let leaves = rapids.is_empty()
                    && from.axis.angle(&step.axis) < 1e-9
                    && travel.dot(&step.axis) > LEAVING_SHARE * travel.norm()
                    && !is_axial(&travel, &from.axis, &step.axis);
                let same_section = cuts.last_mut().filter(|c| c.section == section);
                match same_section {
                    Some(cut) if leaves && cut.is_plunge() => {
                        cut.swept.extend_from_slice(&swept);
                        cut.lead_out = swept;
                        (last_tool, previous) = (Some(number), Some(step));
                        continue;
                    }
                    Some(cut) if cut.is_continued_by(&from.tip, &cutter, &rapids) => {
                        // Those rapids only went back in the column of the plunge.
                        rapids.clear();
                        cut.has_feed &= feed.is_some();
                        (cut.line, cut.index, cut.cutter, cut.swept) =
                            (step.line, index, cutter, vec![cutter]);
                        (last_tool, previous) = (Some(number), Some(step));
                        continue;
                    }
                    _ => {}
                }
                if let Some(before) = cuts.last().filter(|c| c.section == section)
                    && (step.tip - before.cutter.tip).norm() > NEW_ROW_RADII * tool.radius()
                {
                    row += 1;
                }
                cuts.push(ProgramCut {
                    line: step.line,
                    tool: tool.clone(),
                    tool_index: number,
                    cutter,
                    swept,
                    rapids: std::mem::take(&mut rapids),
                    lead_out: Vec::new(),
                    index,
                    retract: from.tip,
                    has_feed: feed.is_some(),
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

/// The sections that `program` names; assigns the cuts to them. `None`, with `cuts` unchanged, where it names
/// none, or where they do not match its cuts.
pub(super) fn named_sections(
    program: &ClProgram,
    setup: &Setup,
    cuts: &mut [ProgramCut],
) -> Option<Vec<SectionPlan>> {
    let mut tools: Vec<Option<usize>> = vec![None; program.sections.len()];
    let mut places = Vec::with_capacity(cuts.len());
    for cut in cuts.iter() {
        let index = cut.index;
        let row = program.rows[..program.rows.partition_point(|row| row.first_move <= index)].last()?;
        let section = program.sections.get(row.section)?;
        let tool = *tools[row.section].get_or_insert(cut.tool_index);
        if tool != cut.tool_index || (section.diameter - cut.tool.diameter).abs() > 1e-6 {
            return None;
        }
        places.push((row.section, row.row));
    }
    for (cut, (section, row)) in cuts.iter_mut().zip(&places) {
        (cut.section, cut.row) = (*section, *row);
    }
    let named = program.sections.iter().zip(tools).enumerate().map(|(index, (section, tool))| {
        let described = tool.map_or_else(
            || ClTool { diameter: section.diameter, ..ClTool::default() },
            |tool| program.tools[tool].clone(),
        );
        let mut rows: Vec<usize> = places.iter().filter(|p| p.0 == index).map(|p| p.1).collect();
        rows.sort_unstable();
        rows.dedup();
        SectionPlan {
            tool: described.completed(setup),
            from: section.from,
            to: section.to,
            feed: section.feed,
            rows: rows.len(),
            kind: section.kind,
            added: None,
        }
    });
    Some(named.collect()).filter(|sections: &Vec<SectionPlan>| !sections.is_empty())
}
