//! Report on a plunge program: of the one that `plan` writes, and of any that `verify` reads.

use std::collections::BTreeSet;

use super::assembly::unknown_assemblies;
use super::summary::{Floors, Summary};
use super::{Fault, PlungeVerdict, verify};
use crate::geometry::{rotate_vector_z, rotate_z};
use crate::part::{Impeller, Workpiece};
use crate::plunge::{PlungePlan, Position};
use crate::setup::Setup;
use crate::stock::{FloorGrid, FloorSource, field_cutters, residual_field, stretches_of_plan};
use crate::toolpath::{ClProgram, Travel};

/// Tolerance within which plunges of two channels count as equal, mm: a program has six decimals.
const SAME_TOLERANCE: f64 = 1e-5;
/// Uncut share of the reachable floor above which a note is added.
const MAX_UNCUT_SHARE: f64 = 0.1;

/// A checked plunge program. Counts, lengths and times are of the whole program; figures of the floor are
/// over all channels with cuts.
#[derive(Clone, Debug)]
pub struct PlungeReport {
    /// The measured cuts, and all faults.
    pub verdict: PlungeVerdict,
    /// Figures of the whole program.
    pub summary: Summary,
    /// Figures of each section of the verdict's plan.
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
) -> Result<PlungeReport, Fault> {
    let verdict = verify(workpiece, setup, program)?;
    let stretches = stretches_of_plan(&verdict.plan);
    let source = FloorSource { workpiece, stock: &setup.allowances, cutters: &stretches };
    let grid = FloorGrid::new(&source, cells);
    let fields = fields_of(&workpiece.part, &verdict, &grid);
    let heights: Vec<(&[f32], usize)> = fields.iter().map(|(h, n)| (h.as_slice(), *n)).collect();
    let floors = Floors { grid: &grid, heights: &heights };
    let plan = &verdict.plan;
    let summary = Summary::summarize(plan, &floors, &Travel::of(program), None);
    let section = |index| Summary::summarize(plan, &floors, &Travel::default(), Some(index));
    let sections = (0..plan.sections.len()).map(section).collect();
    let mut notes = Vec::new();
    if summary.uncut_share > MAX_UNCUT_SHARE {
        notes.push(format!("{:.1} % of the reachable floor stays uncut", 100.0 * summary.uncut_share));
    }
    notes.extend(unknown_assemblies(program, setup));
    Ok(PlungeReport { verdict, summary, sections, notes })
}

/// Heights of the floor after the program, once per group of equal channels, and the number of channels in
/// the group.
fn fields_of(part: &Impeller, verdict: &PlungeVerdict, grid: &FloorGrid) -> Vec<(Vec<f32>, usize)> {
    let worked_in: BTreeSet<i64> = verdict.channel_offsets.iter().copied().collect();
    let around: Vec<Vec<Position>> =
        worked_in.iter().map(|&number| plunges_around(part, verdict, number)).collect();
    let mut kinds: Vec<(usize, usize)> = Vec::new();
    for (index, ours) in around.iter().enumerate() {
        match kinds.iter_mut().find(|(first, _)| same_plunges(&around[*first], ours)) {
            Some((_, times)) => *times += 1,
            None => kinds.push((index, 1)),
        }
    }
    let field = |(index, times): (usize, usize)| {
        let plan = PlungePlan { positions: around[index].clone(), ..verdict.plan.clone() };
        (residual_field(grid, &field_cutters(&plan)).heights, times)
    };
    kinds.into_iter().map(field).collect()
}

/// The plunges that may reach the floor of the channel `number` pitches ahead of channel 1, rotated into
/// channel 1: its own, then those of its neighbours.
fn plunges_around(part: &Impeller, verdict: &PlungeVerdict, number: i64) -> Vec<Position> {
    let count = part.blade_count as i64;
    let mut found = Vec::new();
    for ahead in if count > 2 { [0, -1, 1].as_slice() } else { [0, 1].as_slice() } {
        let angle = part.pitch() * *ahead as f64;
        let theirs = verdict.channel_offsets.iter().zip(&verdict.plan.positions);
        let theirs = theirs.filter(|(turn, _)| (*turn - number - ahead).rem_euclid(count) == 0);
        found.extend(theirs.map(|(_, p)| Position {
            tip: rotate_z(&p.tip, angle),
            axis: rotate_vector_z(&p.axis, angle),
            ..p.clone()
        }));
    }
    found
}

/// Whether two lists of plunges are equal except for rounding.
fn same_plunges(a: &[Position], b: &[Position]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| {
            a.section == b.section
                && (a.tip - b.tip).amax() < SAME_TOLERANCE
                && (a.axis - b.axis).amax() < 1e-3 * SAME_TOLERANCE
        })
}
