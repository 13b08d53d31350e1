//! Checks any cutter-location program against a part (DESIGN sections 3 and 7).
//!
//! Nothing here knows how a program was planned: it looks at cutters where the program puts them.

mod fault;
mod flank;
mod plunges;

use rayon::prelude::*;

pub use fault::Fault;
use fault::{beyond_machine, near_blade, near_hub, rapid_near_blank};
pub use flank::{FlankFault, FlankFaultKind, FlankVerdict, FlankVerifier, Uncovered, is_flank, verify_flank};
pub use plunges::{Cut, cuts_of};

use crate::formats::apt::ClProgram;
use crate::geometry::{CutterSolid, Meridional, Point, rotate_vector_z, rotate_z};
use crate::part::{AxisPolicy, Feed, Tool};
use crate::part::{Blank, Channel, Impeller, Setup};
use crate::plunge::clearance::FinishedPart;
use crate::plunge::contact::{BlankTop, Column, Columns, core_contact};
use crate::plunge::retract::bottom_clearance;
use crate::plunge::{CoreContact, PlungePlan, Position, SectionPlan};

/// Tolerance of distances in a program of six decimals, mm.
const PROGRAM_TOLERANCE: f64 = 2e-6;

/// What a program does to the part.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The program as a plan of channel 1's frame: every cut measured. Cuts of other channels are
    /// turned into channel 1.
    pub plan: PlungePlan,
    /// Number of channels the program works in.
    pub channels: usize,
    /// Everything that must not be.
    pub faults: Vec<Fault>,
}

/// Checks `program` against `part` with the allowances of `setup`; tools of the setup say how wide the
/// inserts are where the program does not.
///
/// # Errors
/// The line of the program and what is missing when a cut cannot be judged: no tool before it.
pub fn verify(
    part: &Impeller,
    channel: &Channel,
    setup: &Setup,
    program: &ClProgram,
) -> Result<Verdict, Fault> {
    let cuts = cuts_of(program, setup)?;
    if cuts.is_empty() {
        return Err(Fault {
            line: 0,
            what: "the program cuts nothing: it has no move under feed; give a program with FEDRAT before its cuts".to_owned(),
        });
    }
    let blank = Blank::of(part, setup.stock.inlet_extension);
    let top = BlankTop::new(&blank);
    let finished = FinishedPart::new(part, &channel.sides);
    let columns: Columns = cuts.iter().map(|c| Column::new(c.cutter, c.tool.core_radius(), &top)).collect();
    let turns: Vec<i64> = cuts.iter().map(|c| channel_of(part, channel, &c.cutter.tip)).collect();

    let measured: Vec<(CoreContact, f64, f64, f64)> = (0..cuts.len())
        .into_par_iter()
        .map(|k| {
            let cut = &cuts[k];
            let back = -part.pitch() * turns[k] as f64;
            let worst = |f: &dyn Fn(&CutterSolid) -> f64| {
                cut.swept.iter().map(|c| f(&turned(c, back))).fold(f64::INFINITY, f64::min)
            };
            let contact = core_contact(&columns.as_slice()[k], columns.before(k), &blank);
            let retract =
                cut.rapids.iter().map(|c| bottom_clearance(c, &blank)).fold(f64::INFINITY, f64::min);
            (contact, worst(&|c| finished.hub_clearance(c)), worst(&|c| finished.blade_clearance(c)), retract)
        })
        .collect();

    let mut plan = PlungePlan {
        policy: AxisPolicy::Conventional,
        sections: sections_of(part, &cuts),
        positions: Vec::with_capacity(cuts.len()),
        dropped: Vec::new(),
        rounds: 0,
        settled: true,
    };
    let mut faults = Vec::new();
    for (k, (cut, &(contact, hub, blade, retract))) in cuts.iter().zip(&measured).enumerate() {
        let here = turned(&cut.cutter, -part.pitch() * turns[k] as f64);
        let s = part.hub.s_at(part.hub.curve().project(Meridional::of(&here.tip)).0);
        let found = [
            near_hub(hub, &setup.stock, PROGRAM_TOLERANCE),
            near_blade(blade, &setup.stock, PROGRAM_TOLERANCE),
            rapid_near_blank(retract, &setup.stock),
            beyond_machine(part, setup, &here.axis),
            contact.interferes().then(|| {
                format!(
                    "interferes: the core meets stock up to {:.3} mm above its bottom, over {:.0} % of its area",
                    contact.depth,
                    100.0 * contact.area_share
                )
            }),
        ];
        faults.extend(found.into_iter().flatten().map(|what| Fault { line: cut.line, what }));
        plan.positions.push(Position {
            tip: here.tip,
            axis: here.axis,
            retract: rotate_z(&cut.retract, -part.pitch() * turns[k] as f64),
            section: cut.section,
            row: cut.row,
            s,
            lambda: f64::NAN,
            alpha: f64::NAN,
            contact_point: here.tip,
            contact,
            lift: 0.0,
            blocked: None,
            held: None,
            hub_clearance: hub,
            blade_clearance: blade,
            retract_clearance: retract,
        });
    }
    let mut distinct = turns.clone();
    distinct.sort_unstable();
    distinct.dedup();
    Ok(Verdict { plan, channels: distinct.len(), faults })
}

fn turned(cutter: &CutterSolid, angle: f64) -> CutterSolid {
    CutterSolid { tip: rotate_z(&cutter.tip, angle), axis: rotate_vector_z(&cutter.axis, angle), ..*cutter }
}

/// By how many pitches `tip` lies ahead of channel 1.
fn channel_of(part: &Impeller, channel: &Channel, tip: &Point) -> i64 {
    let s = part.hub.s_at(part.hub.curve().project(Meridional::of(tip)).0).clamp(0.0, 1.0);
    let Some([low, high]) = channel.full.wall_angles(part, s, 0.0) else { return 0 };
    let from_middle = (tip.y.atan2(tip.x) - 0.5 * (low + high)) / part.pitch();
    let count = part.blade_count as i64;
    let turns = (from_middle.round() as i64).rem_euclid(count);
    if turns > count / 2 { turns - count } else { turns }
}

/// Stretches between tool changes as sections: which tool, and over which s.
fn sections_of(part: &Impeller, cuts: &[Cut]) -> Vec<SectionPlan> {
    let count = cuts.iter().map(|c| c.section + 1).max().unwrap_or(0);
    (0..count)
        .filter_map(|index| {
            let ours: Vec<&Cut> = cuts.iter().filter(|c| c.section == index).collect();
            let tool: Tool = ours.first()?.tool.clone();
            let s = |c: &&Cut| {
                part.hub.s_at(part.hub.curve().project(Meridional::of(&c.cutter.tip)).0).clamp(0.0, 1.0)
            };
            let (first, last) = (s(ours.first()?), s(ours.last()?));
            Some(SectionPlan {
                tool,
                from: ours.iter().map(s).fold(0.0, f64::max),
                to: ours.iter().map(s).fold(1.0, f64::min),
                feed: if last <= first { Feed::Inward } else { Feed::Outward },
                rows: ours.iter().map(|c| c.row + 1).max().unwrap_or(0),
                rest: false,
                added: None,
            })
        })
        .collect()
}
