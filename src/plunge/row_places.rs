//! Where the rows of a section begin and end, and who makes their stations.

use super::context::PlanContext;
use super::lane::is_wall;
use super::row::RowMaker;
use super::section_layout::{PassageStretch, StretchLayout};
use crate::monitor::Monitor;
use crate::setup::{CutDirection, SectionKind, Tool, tool_of};

/// Gap between the core and the rim at the start of a row, mm.
const START_MARGIN: f64 = 0.05;

/// First and last s of a stretch's rows in cutting order, before the start is moved out of the stock.
pub(super) fn row_ends(
    context: &PlanContext,
    index: usize,
    stretch: &PassageStretch,
    inward: f64,
) -> (f64, f64) {
    let section = context.section(index);
    let Ok(tool) = context.tool_of_section(index) else { return (stretch.from, stretch.to) };
    let before = index.checked_sub(1).map(|i| context.section(i)).filter(|b| b.kind != SectionKind::Opening);
    let hub = &context.workpiece.part.hub;
    let (mut start, end) = if inward > 0.0 { (stretch.from, stretch.to) } else { (stretch.to, stretch.from) };
    let border = if inward > 0.0 { section.from } else { section.to };
    if start == border {
        let open_end = if inward > 0.0 { start >= 1.0 - 1e-9 } else { start <= 1e-9 };
        if open_end {
            // The core stays outside the blank at hub and shroud.
            let out = tool.core_radius().max(0.0) + START_MARGIN;
            start += inward * out / hub.length();
        } else if let Some(previous) = before.and_then(|b| tool_of(context.setup, b.tool).ok()) {
            // Aligns the front rims of the previous, larger cutter and this one.
            let shift = (previous.radius() - tool.radius()).max(0.0) / hub.length();
            let shifted = start - inward * shift;
            if (end - shifted) * inward < 0.0 {
                start = shifted;
            }
        }
    }
    (start, end)
}

/// Maker of the stations of the row at `lambda`, one of `rows` rows of the stretch.
pub(super) fn row_maker<'r>(
    context: &'r PlanContext<'_>,
    layout: &'r StretchLayout<'r>,
    tool: &'r Tool,
    (lambda, rows): (f64, usize),
    feed: CutDirection,
    monitor: &'r Monitor,
) -> RowMaker<'r> {
    let wall_row = is_wall(lambda) || rows == 1;
    RowMaker {
        part: &context.workpiece.part,
        lane: &layout.lane,
        hub: &layout.hub,
        tool,
        lambda,
        direction_sign: feed.sign_along_s(),
        step_limit: context.density.step_limit(&context.setup.plunge, tool, wall_row),
        monitor,
    }
}
