//! Report on a plunge program: of the one that `plan` writes, and of any that `verify` reads.

use std::collections::BTreeSet;

use super::assembly::unjudged_tools;
use super::summary::{CutFigures, Floors, Summary};
use super::{JudgedCut, PlungeVerdict, VerifyError, verify};
use crate::geometry::{rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, Workpiece};
use crate::plunge::SectionPlan;
use crate::setup::Setup;
use crate::stock::{FieldCutter, FloorGrid, FloorSource, residual_field, stretches_of};
use crate::toolpath::{ClProgram, Travel};

/// Tolerance within which cuts of two channels count as equal, mm: a program has six decimals.
const SAME_TOLERANCE: f64 = 1e-5;
/// Uncut share of the reachable floor above which a note is added.
const MAX_UNCUT_SHARE: f64 = 0.1;
/// Progress at which the plunges are judged, and the floor remains.
const PLUNGES_DONE: f64 = 0.8;

/// A checked plunge program. Counts, lengths and times are of the whole program; figures of the floor are
/// over all channels with cuts.
#[derive(Clone, Debug)]
pub struct PlungeReport {
    /// The measured cuts, and all faults.
    pub verdict: PlungeVerdict,
    /// Figures of the whole program.
    pub summary: Summary,
    /// Figures of each section of the verdict.
    pub sections: Vec<Summary>,
    /// Remarks that are not faults.
    pub notes: Vec<String>,
}

/// Checks `program` against `workpiece` with the allowances of `setup`; the floor has `cells` × `cells`
/// cells.
///
/// # Errors
/// As [`verify`].
pub fn report_plunges(
    workpiece: &Workpiece,
    setup: &Setup,
    program: &ClProgram,
    cells: usize,
    monitor: &Monitor,
) -> Result<PlungeReport, VerifyError> {
    let verdict = verify(workpiece, setup, program, &monitor.span(0.0, PLUNGES_DONE))?;
    let stretches = stretches_of(&verdict.sections);
    let source = FloorSource::of_setup(workpiece, setup, &stretches);
    let grid = FloorGrid::new(&source, cells);
    let fields = fields_of(&workpiece.part, &verdict, &grid, &monitor.span(PLUNGES_DONE, 1.0))?;
    let heights: Vec<(&[f32], usize)> = fields.iter().map(|(h, n)| (h.as_slice(), *n)).collect();
    let floors = Floors { grid: &grid, heights: &heights };
    let summary = Summary::of_cuts(
        verdict.cuts.iter().map(CutFigures::of_cut),
        &floors,
        Travel::from_program(program),
        None,
    );
    let section = |(index, section): (usize, &SectionPlan)| {
        let ours = verdict.cuts.iter().filter(|cut| cut.section == index).map(CutFigures::of_cut);
        Summary::of_cuts(ours, &floors, Travel::default(), Some([section.from, section.to]))
    };
    let sections = verdict.sections.iter().enumerate().map(section).collect();
    let mut notes = Vec::new();
    if summary.uncut_share > MAX_UNCUT_SHARE {
        notes.push(format!("{:.1} % of the reachable floor stays uncut", 100.0 * summary.uncut_share));
    }
    notes.extend(unjudged_tools(program, setup));
    Ok(PlungeReport { verdict, summary, sections, notes })
}

/// Heights of the floor after the program, once per group of equal channels, and the number of channels in
/// the group.
///
/// # Errors
/// When cancelled.
fn fields_of(
    part: &Impeller,
    verdict: &PlungeVerdict,
    grid: &FloorGrid,
    monitor: &Monitor,
) -> Result<Vec<(Vec<f32>, usize)>, Cancelled> {
    let worked_in: BTreeSet<i64> = verdict.cuts.iter().map(|cut| cut.channel_offset).collect();
    let around: Vec<Vec<JudgedCut>> =
        worked_in.iter().map(|&number| cuts_around(part, &verdict.cuts, number)).collect();
    let mut kinds: Vec<(usize, usize)> = Vec::new();
    for (index, ours) in around.iter().enumerate() {
        match kinds.iter_mut().find(|(first, _)| same_cuts(&around[*first], ours)) {
            Some((_, times)) => *times += 1,
            None => kinds.push((index, 1)),
        }
    }
    let count = monitor.steps(kinds.len());
    let field = |(index, times): (usize, usize)| {
        count.begin()?;
        let tool = |cut: &JudgedCut| &verdict.sections[cut.section].tool;
        let cutters = around[index].iter().map(|cut| FieldCutter::from_tool(tool(cut), cut.tip, cut.axis));
        Ok((residual_field(grid, &cutters.collect::<Vec<_>>()).heights, times))
    };
    kinds.into_iter().map(field).collect()
}

/// The cuts that may reach the floor of the channel `number` pitches ahead of channel 1, rotated into
/// channel 1: its own, then those of its neighbours.
fn cuts_around(part: &Impeller, cuts: &[JudgedCut], number: i64) -> Vec<JudgedCut> {
    let count = part.blade_count as i64;
    let mut found = Vec::new();
    for ahead in if count > 2 { [0, -1, 1].as_slice() } else { [0, 1].as_slice() } {
        let angle = part.pitch() * *ahead as f64;
        let theirs = cuts.iter().filter(|cut| (cut.channel_offset - number - ahead).rem_euclid(count) == 0);
        found.extend(theirs.map(|cut| JudgedCut {
            tip: rotate_z(&cut.tip, angle),
            axis: rotate_vector_z(&cut.axis, angle),
            ..cut.clone()
        }));
    }
    found
}

/// Whether two lists of cuts are equal except for rounding.
fn same_cuts(a: &[JudgedCut], b: &[JudgedCut]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| {
            a.section == b.section
                && (a.tip - b.tip).amax() < SAME_TOLERANCE
                && (a.axis - b.axis).amax() < 1e-3 * SAME_TOLERANCE
        })
}
