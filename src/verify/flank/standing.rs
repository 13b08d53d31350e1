//! Collisions of a program with the stock that stands, by the solid.
//!
//! The heightfield knows the stock above the floor of one channel; the solid also that beside walls that lean
//! away and in the channels not cut yet, and it meets the whole length of shank and holder. In programs that
//! plunge beside it knows what passes along curves have left of the stock in the way of a core.

use std::collections::BTreeSet;

use super::super::fault::{FaultKind, Finding, core_in_stock};
use super::steps::CutterStep;
use crate::cutting::assembly::AssemblySurroundings;
use crate::cutting::contact::{BlankTop, Columns, PlungeColumn, core_contacts};
use crate::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Blank, Impeller};
use crate::setup::Tool;
use crate::stock::solid::{
    Contact, MAX_RUN, SolidBlank, SolidError, SolidMove, SolidStock, SolidTool, ToolPart, ToolPose,
    tell_plunges_from_approaches,
};

/// Spacing of the rays as a share of the largest diameter of the blank.
const SPACING_SHARE: f64 = 1.0 / 400.0;

/// Distance, mm, and turn, rad, of two poses that are the same: channels are turned to and fro.
const SAME_PLACE: f64 = 1e-6;
const SAME_AXIS: f64 = 1e-8;

/// Number of equal parts of a program; the stock after each is kept if another program may follow.
const KEPT_PARTS: usize = 16;

/// Searches programs of one part, with the same tools, for contacts with standing stock. A program that
/// begins with the same moves as the previous one is simulated from the last stock that was kept within them.
pub(super) struct StandingStock {
    /// By how much holders, and shanks that are thicker than their cutter, count as thicker still, in
    /// spacings of the rays: stock between two rays is not seen.
    margin: f64,
    /// Whether states are kept for a next program.
    keeps: bool,
    /// The moves of the last program.
    moves: Vec<SolidMove>,
    /// Depth of contact that the solid resolves, mm.
    pub(super) resolved: f64,
    /// The stock at some places in it, in order.
    kept: Vec<KeptStock>,
}

/// The stock after the first moves of a program.
struct KeptStock {
    /// Number of moves made.
    made: usize,
    stock: SolidStock,
    /// What was met in them.
    contacts: Vec<Contact>,
}

impl StandingStock {
    /// Before the first program; of one after which no other follows nothing is kept.
    pub(super) fn new(margin: f64, keeps: bool) -> Self {
        Self { margin, keeps, moves: Vec::new(), resolved: 0.0, kept: Vec::new() }
    }

    /// What is known of a program in which no shank and no holder meets stock, for those that are less thick.
    pub(super) fn with_exact_tools(self) -> Self {
        Self { margin: 0.0, ..self }
    }

    /// Forgets the last program: the tools change.
    pub(super) fn forget(&mut self) {
        *self = Self::new(self.margin, self.keeps);
    }

    /// Where parts of the tools that must not meet stock meet it; `number` of a contact is the index of its
    /// step. Only `steps` differ from the last call, unless [`Self::forget`] was called.
    ///
    /// # Errors
    /// When cancelled.
    pub(super) fn collisions(
        &mut self,
        part: &Impeller,
        blank: &Blank,
        tools: &[Tool],
        steps: &[CutterStep],
        monitor: &Monitor,
    ) -> Result<Vec<Contact>, Cancelled> {
        match self.simulate(part, blank, tools, moves(part, steps), monitor) {
            Ok(mut contacts) => {
                contacts.retain(|contact| !self.is_own_cut(contact, tools));
                let plunges: Vec<usize> =
                    (0..self.moves.len()).filter(|&k| self.moves[k].checks_core).collect();
                judge_cores(part, blank, tools, (steps, &plunges), contacts, monitor)
            }
            Err(SolidError::Cancelled(cancelled)) => Err(cancelled),
            // At this spacing a blank fits the memory allowed; stock in more pieces than that is not milling.
            Err(_) => Ok(Vec::new()),
        }
    }

    /// Whether a cutter that retracts along its axis is found to meet what it has just cut. Where it stood at
    /// the end of the cut nothing can be left: it is the solid that leaves slivers there, as it divides moves
    /// into pieces.
    fn is_own_cut(&self, contact: &Contact, tools: &[Tool]) -> bool {
        if contact.part != ToolPart::Cutter {
            return false;
        }
        let last = contact.number as usize;
        let mut retract = &self.moves[last];
        if !retract.is_retract() {
            return false;
        }
        for before in self.moves[..last].iter().rev() {
            let (end, start) = (before.to, retract.from);
            if before.tool != retract.tool
                || (end.tip - start.tip).norm() > SAME_PLACE
                || (end.axis - start.axis).norm() > SAME_AXIS
            {
                return false;
            }
            if !before.rapid {
                let height = (contact.point - end.tip).dot(&end.axis);
                return height < SolidTool::from_tool(&tools[before.tool]).cutting_length;
            }
            if !before.is_retract() {
                return false;
            }
            retract = before;
        }
        false
    }

    /// Makes the moves of a program on the solid, from the last kept stock that it has in common with the
    /// one before; their contacts.
    fn simulate(
        &mut self,
        part: &Impeller,
        blank: &Blank,
        tools: &[Tool],
        moves: Vec<SolidMove>,
        monitor: &Monitor,
    ) -> Result<Vec<Contact>, SolidError> {
        let solid = SolidBlank::from_part(part, blank);
        let (low, high) = solid.bounds();
        let spacing = SPACING_SHARE * (high.x - low.x).max(high.y - low.y);
        let margin = self.margin * spacing;
        let solid_tools: Vec<SolidTool> =
            tools.iter().map(|tool| SolidTool::from_tool(&thickened(tool, margin))).collect();
        let alike = self.moves.iter().zip(&moves).take_while(|(known, new)| known == new).count();
        self.kept.retain(|kept| kept.made + MAX_RUN <= alike);
        self.moves = moves;
        let (made, mut stock, mut contacts) = match self.kept.last() {
            Some(kept) => (kept.made, kept.stock.clone(), kept.contacts.clone()),
            None => (0, SolidStock::new(&solid, spacing)?, Vec::new()),
        };
        self.resolved = stock.resolved();
        let interval = self.moves.len() / KEPT_PARTS;
        let mut next = made + interval;
        let before = contacts.clone();
        let keep = |made: usize, stock: &SolidStock, since: &[Contact]| {
            if self.keeps && made >= next {
                let contacts = before.iter().chain(since).copied().collect();
                self.kept.push(KeptStock { made, stock: stock.clone(), contacts });
                next = made + interval;
            }
        };
        contacts.extend(stock.make_moves_from(made, &solid_tools, &self.moves, monitor, keep)?);
        Ok(contacts)
    }
}

/// `tool` with its holder, and what of its shank is thicker than the cutter, thicker by `margin` mm all
/// around. A shank no thicker than the cutter stays within the space that the cutter has already cleared.
fn thickened(tool: &Tool, margin: f64) -> Tool {
    let mut tool = tool.clone();
    for [diameter, _] in &mut tool.assembly.shank {
        if *diameter > tool.diameter {
            *diameter += 2.0 * margin;
        }
    }
    for [lower, upper, _] in &mut tool.assembly.holder {
        *lower += 2.0 * margin;
        *upper += 2.0 * margin;
    }
    tool
}

/// The steps where the program has them, in their channels.
fn moves(part: &Impeller, steps: &[CutterStep]) -> Vec<SolidMove> {
    let mut moves: Vec<SolidMove> = (0u32..)
        .zip(steps)
        .map(|(number, step)| {
            let turn = part.pitch() * step.channel as f64;
            let pose = |(tip, axis): &(Point, Vector)| {
                if step.channel == 0 {
                    ToolPose { tip: *tip, axis: *axis }
                } else {
                    ToolPose { tip: rotate_z(tip, turn), axis: rotate_vector_z(axis, turn) }
                }
            };
            let (from, to) = (pose(&step.from), pose(&step.to));
            let rapid = step.feed.is_none();
            SolidMove { number, tool: step.tool, rapid, checks_core: true, from, to }
        })
        .collect();
    tell_plunges_from_approaches(&mut moves);
    moves
}

/// Replaces the contacts of cores by the exact ones where only plunges can have cut before: the solid
/// resolves no thin contact. Elsewhere a core is free where it is free after the plunges alone, and else the
/// solid decides. `plunges` are indices of `steps`.
fn judge_cores(
    part: &Impeller,
    blank: &Blank,
    tools: &[Tool],
    (steps, plunges): (&[CutterStep], &[usize]),
    contacts: Vec<Contact>,
    monitor: &Monitor,
) -> Result<Vec<Contact>, Cancelled> {
    let (cores, mut judged): (Vec<Contact>, Vec<Contact>) =
        contacts.into_iter().partition(|contact| contact.part == ToolPart::Core);
    if plunges.is_empty() {
        return Ok(judged);
    }
    let top = BlankTop::new(blank);
    let end = |k: usize| {
        let turn = part.pitch() * steps[k].channel as f64;
        let (tip, axis) = steps[k].to;
        tools[steps[k].tool].placed(rotate_z(&tip, turn), rotate_vector_z(&axis, turn))
    };
    let column = |k: usize| PlungeColumn::new(end(k), tools[steps[k].tool].core_radius(), &top);
    let columns: Columns = plunges.iter().map(|&k| column(k)).collect();
    let exact = core_contacts(&columns, blank, monitor)?;
    // What mills across its axis, as a column that contains its sweep.
    let passes: Vec<usize> =
        (0..steps.len()).filter(|&k| steps[k].feed.is_some() && !steps[k].is_axial()).collect();
    let sweep = |&k: &usize| {
        let (cutter, step) = (end(k), &steps[k]);
        let aside = step.length() + step.turn() * tools[step.tool].overhang;
        let cutter = CutterSolid { radius: cutter.radius + aside, ..cutter };
        PlungeColumn { cutter, core_radius: 0.0, top: 0.0 }
    };
    let sweeps: Columns = passes.iter().map(sweep).collect();
    let mut left_to_solid = BTreeSet::new();
    for ((&k, contact), column) in plunges.iter().zip(exact).zip(columns.as_slice()) {
        if !contact.interferes() {
            continue;
        }
        let number = k as u32;
        let before = sweeps.before(passes.partition_point(|&pass| pass < k));
        if before.numbers_near(column).is_empty() {
            let (depth, point) = (contact.depth, column.cutter.tip);
            judged.push(Contact { number, part: ToolPart::Core, depth, point });
        } else {
            left_to_solid.insert(number);
        }
    }
    judged.extend(cores.into_iter().filter(|core| left_to_solid.contains(&core.number)));
    judged.sort_by_key(|contact| (contact.number, contact.part));
    Ok(judged)
}

/// An overhang, mm, with which the holder that meets stock in `step` would be clear of all of the blank at
/// both its ends; `None` for other contacts, or where no overhang does.
pub(super) fn overhang_for(
    contact: &Contact,
    tool: &Tool,
    step: &CutterStep,
    around: &AssemblySurroundings,
) -> Option<f64> {
    if contact.part != ToolPart::Holder {
        return None;
    }
    let [from, to] = [step.from, step.to].map(|pose| around.stick_out(tool, pose, f64::INFINITY));
    from.zip(to).map(|(from, to)| from.max(to)).filter(|overhang| *overhang > tool.overhang)
}

/// The fault of a contact in a step with tool number `tool`, and the overhang that would do.
pub(super) fn finding(contact: &Contact, tool: u32, overhang: Option<f64>) -> Finding {
    let depth = contact.depth;
    let (kind, what, help) = match contact.part {
        ToolPart::Cutter => (
            FaultKind::RapidInStock,
            format!("the cutter meets stock in rapid, {depth:.2} mm deep"),
            "remove it first, or move under feed",
        ),
        ToolPart::Shank => (
            FaultKind::ShankCollision,
            format!("the shank of tool {tool} runs {depth:.2} mm into remaining stock"),
            "remove it first, or give a thinner shank",
        ),
        ToolPart::Core => return core_in_stock(depth, None),
        ToolPart::Holder => (
            FaultKind::HolderInStock,
            format!("the holder of tool {tool} runs {depth:.2} mm into remaining stock"),
            "remove it first, tilt the axis, or give the tool more overhang",
        ),
    };
    let by_length = overhang.map(|overhang| format!("remove it first, or give an overhang of {overhang} mm"));
    Finding::new(kind, depth, what)
        .with_help(by_length.unwrap_or_else(|| help.to_owned()))
        .with_overhang(overhang)
}
