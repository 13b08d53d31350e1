//! Checks any cutter-location program against a part.
//!
//! The checks are independent of the planner: they use only the tool positions of the program.

mod assembly;
mod channels;
mod fault;
mod flank;
mod plunges;
mod report;
mod summary;
mod taper;
mod verdict;

use std::collections::BTreeSet;

use rayon::prelude::*;

pub use assembly::AssemblyDistances;
pub use assembly::unjudged_tools;
use assembly::{holder_in_stock, judge_moves, step_to};
use channels::{channels_of, nearest_channel};
pub use fault::{Fault, FaultKind, VerifyError, count_by_kind};
use fault::{
    Finding, beyond_machine, core_in_stock, missing_feed, near_blade, near_hub, rapid_near_blank,
    rapid_near_stock, stopped_spindle, tool_mismatch,
};
pub use flank::{FlankVerdict, FlankVerifier, Uncovered, verify_flank};
use plunges::named_sections;
pub use plunges::{ProgramCut, Rapid, cuts_of};
pub use report::{PlungeReport, report_plunges};
pub use summary::{Summary, time_of_channels_s};
use taper::{TAPER_TOLERANCE, judge_tapers};
pub use verdict::{JudgedCut, PlungeVerdict};

use crate::cutting::approach::ApproachRule;
use crate::cutting::assembly::{AssemblySurroundings, STOCK_TOLERANCE};
use crate::cutting::contact::{
    BlankTop, Columns, CoreContact, Earlier, Engagement, PlungeColumn, core_contact, engagement,
};
use crate::cutting::link::LinkMove;
use crate::cutting::retract::{NearBottom, RetractSurface};
use crate::geometry::{Circle, CutterSolid, Meridional, Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller, Workpiece};
use crate::plunge::SectionPlan;
use crate::setup::{ClearanceSetup, CutDirection, SectionKind, Setup, Tool, falls_short};
use crate::toolpath::ClProgram;

/// Tolerance of distances in a program with six decimals, mm.
const PROGRAM_TOLERANCE: f64 = 2e-6;
/// Turn of the axis above which its direction in a rapid is ambiguous, rad.
const MAX_RAPID_TURN_RAD: f64 = 175.0 * std::f64::consts::PI / 180.0;

/// Progress at which the cuts are measured, and shank and holder remain.
const CUTS_DONE: f64 = 0.6;

/// Measurements of one cut.
struct Measured {
    contact: CoreContact,
    hub: f64,
    blade: f64,
    retract: Option<f64>,
    /// Height above the tip at which the cutter has left the blank, mm, and height of the stock that this cut
    /// removes, mm; the latter only where it may exceed the overhang of the tool.
    top: f64,
    engaged: f64,
    /// Engagement of the whole circumference.
    engagement: Engagement,
    /// Contact of the core where the tool has left the stock beside it.
    lead_out: CoreContact,
    holder_in_stock: Option<Fault>,
    rapids: Vec<Fault>,
}

/// Checks `program` against `workpiece` with the allowances of `setup`. Where the program gives no insert
/// width, that of the setup's tool is used.
///
/// ```
/// use vanecut::{io, monitor::Monitor, setup::Setup, verify};
/// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
/// # let part = vanecut::part::Impeller::build(&part)?;
/// // A plunge of D 20 to the axis of rotation, straight through the hub.
/// let text = b"LOADTL/1\nCUTTER/20\nRAPID\nGOTO/0,0,500,0,0,1\nFEDRAT/300,MMPM\nGOTO/0,0,0,0,0,1\nFINI";
/// let program = io::apt::read_apt_bytes("through.apt", text)?;
/// let setup = Setup::for_part(&part);
/// let workpiece = setup.allowances.workpiece_of(part);
/// let verdict = verify::verify(&workpiece, &setup, &program, &Monitor::default())?;
/// assert!(!verdict.faults.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the program has no cuts, or a cut cannot be checked because no tool with a diameter comes before it:
/// the fault names the line; when cancelled.
pub fn verify(
    workpiece: &Workpiece,
    setup: &Setup,
    program: &ClProgram,
    monitor: &Monitor,
) -> Result<PlungeVerdict, VerifyError> {
    let Workpiece { part, channel, blank, finished } = workpiece;
    let mut cuts = cuts_of(program, setup)?;
    let Some(first_line) = cuts.first().map(|cut| cut.line) else {
        let what = "the program cuts nothing: it has no move under feed";
        let help = "give a program with FEDRAT before its cuts";
        return Err(Finding::new(FaultKind::CutsNothing, None, what).with_help(help).at(0).into());
    };
    let sections = match named_sections(program, setup, &mut cuts) {
        Some(sections) => sections,
        None => sections_of(part, &cuts),
    };
    let top = BlankTop::new(blank);
    let columns: Columns =
        cuts.iter().map(|c| PlungeColumn::new(c.cutter, c.tool.core_radius(), &top)).collect();
    let found = |cut: &ProgramCut| (nearest_channel(part, channel, &cut.cutter.tip), 1.0);
    let turns = channels_of(&cuts.par_iter().map(found).collect::<Vec<_>>());

    let rounding = PROGRAM_TOLERANCE.max(program.rounding);
    let measuring = monitor.span(0.0, CUTS_DONE);
    let count = measuring.steps(cuts.len());
    let measured: Vec<Measured> = (0..cuts.len())
        .into_par_iter()
        .map(|k| {
            count.begin()?;
            let cut = &cuts[k];
            let back = -part.pitch() * turns[k] as f64;
            let worst = |f: &dyn Fn(&CutterSolid) -> f64| {
                cut.swept.iter().map(|c| f(&rotate_cutter(c, back))).fold(f64::INFINITY, f64::min)
            };
            let earlier = columns.before(k);
            let whole = PlungeColumn::new(cut.cutter, cut.tool.radius(), &top);
            let deep = whole.top > cut.tool.overhang;
            let (retract, rapids) = check_rapids(cut, earlier, (blank, &top), setup);
            let left = |cutter: &CutterSolid| {
                let column = PlungeColumn::new(*cutter, cut.tool.core_radius(), &top);
                core_contact(&column, columns.before(k + 1), blank)
            };
            let contact = core_contact(&columns.as_slice()[k], earlier, blank);
            // Between nearly parallel plunges stock stands that steeply that rounding decides how high it
            // meets a core.
            let rounded = contact.interferes().then(|| {
                let core = (cut.tool.core_radius() - rounding).max(0.0);
                core_contact(&PlungeColumn::new(cut.cutter, core, &top), earlier, blank)
            });
            let lead_out = cut.lead_out.iter().map(left).max_by(|a, b| a.depth.total_cmp(&b.depth));
            Ok(Measured {
                contact: rounded.filter(|rounded| !rounded.interferes()).unwrap_or(contact),
                hub: worst(&|c| finished.hub_clearance(c)),
                blade: worst(&|c| finished.blade_clearance(c)),
                retract,
                top: whole.top,
                lead_out: lead_out.unwrap_or_default(),
                engagement: engagement(&whole, earlier, blank),
                engaged: if deep { core_contact(&whole, earlier, blank).depth } else { 0.0 },
                holder_in_stock: holder_in_stock(cut, k, &columns, blank).map(|finding| finding.at(cut.line)),
                rapids,
            })
        })
        .collect::<Result<_, Cancelled>>()?;

    let mut judged = Vec::with_capacity(cuts.len());
    let mut faults = Vec::new();
    for (k, (cut, seen)) in cuts.iter().zip(measured.iter()).enumerate() {
        let here = rotate_cutter(&cut.cutter, -part.pitch() * turns[k] as f64);
        let contact = seen.contact;
        let found = [
            near_hub(seen.hub, &setup.allowances, rounding),
            near_blade(seen.blade, &setup.allowances, rounding),
            beyond_machine(part, setup, &here.axis),
            contact.interferes().then(|| core_in_stock(contact.depth, Some(contact.area_share))),
            (!contact.interferes() && seen.lead_out.interferes())
                .then(|| core_in_stock(seen.lead_out.depth, Some(seen.lead_out.area_share))),
            (seen.engaged > cut.tool.overhang + STOCK_TOLERANCE).then(|| too_deep(seen.engaged, &cut.tool)),
        ];
        faults.extend(found.into_iter().flatten().map(|finding| finding.at(cut.line)));
        faults.extend(seen.holder_in_stock.clone());
        faults.extend_from_slice(&seen.rapids);
        judged.push(JudgedCut {
            tip: here.tip,
            axis: here.axis,
            channel_offset: turns[k],
            section: cut.section,
            row: cut.row,
            contact,
            engagement: seen.engagement,
            hub_clearance: seen.hub,
            blade_clearance: seen.blade,
            retract_clearance: seen.retract,
        });
    }
    // The bottom of a plunge at the rim may end beyond the blank, with the blank beside the tool.
    let passes_blank = |cut: &ProgramCut| {
        let whole = PlungeColumn::new(cut.cutter, cut.tool.radius(), &top);
        let depth = core_contact(&whole, columns.before(0), blank).depth;
        depth > 0.0 && depth <= cut.tool.overhang
    };
    if !cuts.iter().any(|cut| bottom_in_blank(&cut.cutter, blank)) && !cuts.iter().any(passes_blank) {
        let what = "the program cuts nothing of the part: no cut reaches the blank";
        let finding = Finding::new(FaultKind::CutsNothing, None, what);
        faults.push(finding.with_help("check its units and its origin").at(first_line));
    }
    let without: Vec<usize> = cuts.iter().filter(|cut| !cut.has_feed).map(|cut| cut.line).collect();
    faults.extend(missing_feed(&without));
    faults.extend(stopped_spindle(cuts.iter().map(|cut| cut.line), &program.stopped_spindle_lines));
    for index in 0..program.tools.len() {
        let first = cuts.iter().find(|cut| cut.tool_index == index);
        faults.extend(first.and_then(|cut| tool_mismatch(cut.line, &cut.tool, setup)));
    }
    let around = AssemblySurroundings::new(finished, setup);
    let (assembly, found) = judge_moves(program, setup, &around, &monitor.span(CUTS_DONE, 1.0))?;
    faults.extend(found);
    let steps =
        (0..program.moves.len()).filter_map(|k| Some((step_to(&program.moves, k)?, program.moves[k].line)));
    let tools: Vec<Tool> = program.tools.iter().map(|tool| tool.completed(setup)).collect();
    let tolerances = [TAPER_TOLERANCE; 2];
    faults.extend(judge_tapers(steps, &tools, (finished, setup), tolerances, &monitor.silent())?);
    faults.sort_by_key(|fault| fault.line);
    let deepest_plunge = measured.iter().map(|seen| seen.top).fold(0.0, f64::max);
    let channels = turns.iter().collect::<BTreeSet<_>>().len();
    Ok(PlungeVerdict { cuts: judged, sections, channels, deepest_plunge, assembly, faults })
}

/// Whether the bottom of a cutter is in the blank: its centre, or a sample of its rim.
fn bottom_in_blank(cutter: &CutterSolid, blank: &Blank) -> bool {
    let within = |p: &Point| blank.depth(Meridional::from_point(p)) > 0.0;
    let rim = Circle::new(&cutter.tip, &cutter.axis, cutter.radius);
    let on_rim = |i: u32| rim.point_and_derivative((std::f64::consts::FRAC_PI_6 * f64::from(i)).sin_cos()).0;
    within(&cutter.tip) || (0..12).any(|i| within(&on_rim(i)))
}

/// The fault of a cut that removes stock up to `depth` mm above the bottom of `tool`.
fn too_deep(depth: f64, tool: &Tool) -> Finding {
    let what = format!(
        "cuts {depth:.1} mm deep at once, but tool {} is {:.1} mm long below its holder",
        tool.number, tool.overhang
    );
    let help = format!("cut in steps, or give an overhang of {} mm", depth.ceil());
    Finding::new(FaultKind::TooDeep, depth, what).with_help(help)
}

/// Least distance of the bottom to the blank in the rapids of a cut, mm, `None` where it has none; and the
/// faults of these rapids. Where the setup has rapid approaches, a rapid down along the axis that is nearer
/// to the blank than the safety distance is held against what the `earlier` cuts left, and does not count in
/// that distance.
fn check_rapids(
    cut: &ProgramCut,
    earlier: Earlier,
    (blank, top): (&Blank, &BlankTop),
    setup: &Setup,
) -> (Option<f64>, Vec<Fault>) {
    let stock = &setup.allowances;
    let surface = RetractSurface::new(blank, cut.tool.corner_radius);
    let mut least: Option<f64> = None;
    let mut faults = Vec::new();
    for rapid in &cut.rapids {
        let link = LinkMove { tool: &cut.tool, blank, from: rapid.from.unwrap_or(rapid.to), to: rapid.to };
        if link.is_far(stock.safety_distance) {
            continue;
        }
        let near = |(tip, axis): (Point, Vector)| NearBottom::from_cutter(&cut.tool.placed(tip, axis), blank);
        let end = near(rapid.to);
        let mut clearance = end.clearance;
        let comes_down = setup.plunge.rapid_approach && rapid.is_approach();
        if comes_down && falls_short(clearance, stock.safety_distance) {
            let segments = cut.tool.assembly.segments(cut.tool.overhang);
            let rule = ApproachRule {
                tool: &cut.tool,
                segments: &segments,
                blank,
                top,
                below: stock.safety_distance,
                aside: -STOCK_TOLERANCE,
                clearances: ClearanceSetup { shank: 0.0, holder: 0.0 },
            };
            let distance = stock.safety_distance - rule.height(rapid.to, earlier, f64::INFINITY).at_least;
            faults.extend(rapid_near_stock(distance, stock).map(|finding| finding.at(rapid.line)));
            continue;
        }
        if let Some(from) = rapid.from.filter(|_| !rapid.is_retract()) {
            clearance = clearance.min(link.clearance([&near(from), &end], stock.safety_distance));
            let (turn, depth) = (from.1.angle(&rapid.to.1), link.max_tool_depth(&surface));
            let found = [
                (turn > MAX_RAPID_TURN_RAD).then(|| {
                    let what = format!(
                        "turns the axis by {:.0}° in one rapid, in an ambiguous direction",
                        turn.to_degrees()
                    );
                    Finding::new(FaultKind::AxisTurn, turn.to_degrees(), what)
                        .with_help("add intermediate positions")
                }),
                (depth > STOCK_TOLERANCE && clearance >= 0.0).then(|| {
                    let what =
                        format!("swings the tool through the blank in rapid, {depth:.1} mm above its bottom");
                    Finding::new(FaultKind::ToolInBlank, depth, what)
                        .with_help("retract further before the axis turns")
                }),
            ];
            faults.extend(found.into_iter().flatten().map(|finding| finding.at(rapid.line)));
        }
        faults.extend(rapid_near_blank(clearance, stock).map(|finding| finding.at(rapid.line)));
        least = Some(least.map_or(clearance, |least| least.min(clearance)));
    }
    (least, faults)
}

fn rotate_cutter(cutter: &CutterSolid, angle: f64) -> CutterSolid {
    CutterSolid { tip: rotate_z(&cutter.tip, angle), axis: rotate_vector_z(&cutter.axis, angle), ..*cutter }
}

/// The cuts between two tool changes as sections, each with its tool and range of s.
fn sections_of(part: &Impeller, cuts: &[ProgramCut]) -> Vec<SectionPlan> {
    let count = cuts.iter().map(|c| c.section + 1).max().unwrap_or(0);
    (0..count)
        .filter_map(|index| {
            let ours: Vec<&ProgramCut> = cuts.iter().filter(|c| c.section == index).collect();
            let tool: Tool = ours.first()?.tool.clone();
            let s = |c: &&ProgramCut| {
                part.hub
                    .s_at(part.hub.curve().project(Meridional::from_point(&c.cutter.tip)).0)
                    .clamp(0.0, 1.0)
            };
            let (first, last) = (s(ours.first()?), s(ours.last()?));
            Some(SectionPlan {
                tool,
                from: ours.iter().map(s).fold(0.0, f64::max),
                to: ours.iter().map(s).fold(1.0, f64::min),
                feed: if last <= first { CutDirection::OutletToInlet } else { CutDirection::InletToOutlet },
                rows: ours.iter().map(|c| c.row + 1).max().unwrap_or(0),
                kind: SectionKind::Rows,
                added: None,
            })
        })
        .collect()
}
