//! The plunge plan: positions in cutting order.
//!
//! A plan comes about in two steps, which its type tells apart. The planner decides axes and depths: that is
//! a `PlungePlan<Unevaluated>`. [`super::Planner::evaluate`] measures what follows from all of them together,
//! and adds an [`Evaluation`] to each position: that is a [`PlungePlan`].

use rayon::prelude::*;

use super::reasons::{AddedPlunges, Blocked, Breach, Condition, DropReason, LimitedBy};
use crate::cutting::contact::{BlankTop, Columns, CoreContact, Engagement, PlungeColumn};
use crate::geometry::{Point, Vector, rotate_vector_z};
use crate::part::{Blank, Impeller};
use crate::setup::{AxisPolicy, CutDirection, SectionKind, Setup, TILT_TOLERANCE, Tool, falls_short};

/// Largest number of interruptions of one plunge.
const MAX_PECKS: usize = 100;
/// Distance of the retract that breaks the chip, mm, and its maximum as a share of the depth between two
/// interruptions.
const CHIP_BREAK: f64 = 0.5;
const CHIP_BREAK_SHARE: f64 = 0.5;

/// What is measured of a plunge once axes and depths of all plunges are final: it depends on those before it
/// and, for the links, on those beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// Contact of the core with stock.
    pub contact: CoreContact,
    /// Position of the tip on the axis at which the cutter is clear of the blank, in the frame of the part,
    /// mm.
    pub retract: Point,
    /// Minimum distance of the bottom to the blank at the retract point and on the following link, mm.
    pub retract_clearance: f64,
    /// Engagement of its circumference in stock.
    pub engagement: Engagement,
    /// How it is moved.
    pub motion: PlungeMotion,
    /// Limit of the setup that it exceeds; `None`: none.
    pub breach: Option<Breach>,
}

/// How a plunge is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlungeMotion {
    /// Its feed rate, mm/min; `None`: that of the tool.
    pub feed_mm_per_min: Option<f64>,
    /// Lead-out away from the stock beside it, across the axis, mm; the tool rises by the same length. Zero:
    /// it retracts straight.
    pub lead_out: Vector,
    /// Where it is interrupted to break the chip.
    pub pecking: Option<Pecking>,
    /// Height above the tip at which the rapid down ends and the feed begins, mm; `None`: at the retract
    /// point.
    pub approach: Option<f64>,
}

impl PlungeMotion {
    /// The tip after the lead-out, from the `tip` at the end of a plunge along `axis`.
    pub fn led_out(&self, tip: Point, axis: &Vector) -> Point {
        tip + self.lead_out + axis * self.lead_out.norm()
    }

    /// It, with the part turned about Z by `angle_rad`.
    pub fn rotated_z(&self, angle_rad: f64) -> Self {
        Self { lead_out: rotate_vector_z(&self.lead_out, angle_rad), ..*self }
    }
}

/// Interruptions of a plunge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pecking {
    /// Height above the tip at which it enters the blank, mm.
    pub from: f64,
    /// Depth between two of them, mm.
    pub depth: f64,
}

impl Pecking {
    /// Heights above the tip at which the plunge is interrupted, in cutting order, mm.
    pub fn heights(&self) -> impl Iterator<Item = f64> + use<> {
        let (from, depth) = (self.from, self.step());
        (1..).map(move |k| from - depth * f64::from(k)).take_while(|height| *height > 1e-6)
    }

    /// The interruptions that remain when the feed starts at `height` above the tip, mm; `None` if the feed
    /// is at most one `depth` long.
    pub fn below(self, height: f64) -> Option<Self> {
        let from = self.from.min(height);
        (from > self.depth).then_some(Self { from, ..self })
    }

    /// Distance by which the tool retracts at each interruption, mm.
    pub fn back(&self) -> f64 {
        CHIP_BREAK.min(CHIP_BREAK_SHARE * self.step())
    }

    /// Depth between two interruptions, mm.
    fn step(&self) -> f64 {
        self.depth.max(self.from / MAX_PECKS as f64)
    }
}

/// In place of the [`Evaluation`] of a plunge whose axis and depth are final, but not those of all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unevaluated;

/// One plunge as it was planned, with its evaluation `E`. Points and directions are in the frame of the part,
/// mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Position<E = Evaluation> {
    /// Centre of the bottom at the end of the plunge.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Index into [`PlungePlan::sections`].
    pub section: usize,
    /// Row within the section, 0 at the suction wall.
    pub row: usize,
    /// Fraction of meridional arc length of the tip.
    pub s: f64,
    /// Channel coordinate across, 0 suction wall, 1 pressure wall.
    pub lambda: f64,
    /// α: signed angle between hub normal at the contact point and axis, rad, positive towards the inlet.
    pub alpha_rad: f64,
    /// Where the bottom touches the allowance surface of the hub.
    pub contact_point: Point,
    /// Distance by which the plunge stops short of the hub allowance so that its core is free, mm.
    pub lift: f64,
    /// Why the position lacks the axis its policy prescribes, if it does.
    pub blocked: Option<Blocked>,
    /// What keeps it from the axis that would leave the least stock; set by `minimal` only.
    pub limited_by: Option<LimitedBy>,
    /// Minimum distance of the cutter to the finished hub, mm.
    pub hub_clearance: f64,
    /// Minimum distance of the cutter to the finished blades, mm.
    pub blade_clearance: f64,
    /// What is measured of it in the finished plan.
    pub evaluation: E,
}

impl Position {
    /// Overall condition; contact of the core and a [`Breach`] take precedence over [`Blocked`].
    pub fn condition(&self) -> Condition {
        if self.evaluation.contact.interferes() || self.evaluation.breach.is_some() {
            Condition::Interfering
        } else if self.blocked.is_some() {
            Condition::Blocked
        } else {
            Condition::Sound
        }
    }
}

impl<E> Position<E> {
    /// Limit of `setup` that it exceeds on `part` by more than rounding, the gravest first.
    pub fn breach(&self, part: &Impeller, setup: &Setup) -> Option<Breach> {
        let allowances = &setup.allowances;
        if falls_short(self.blade_clearance, allowances.blade_allowance) {
            Some(Breach::Blade)
        } else if falls_short(self.hub_clearance, allowances.hub_allowance) {
            Some(Breach::Hub)
        } else {
            let excess = setup.machine.excess_tilt_rad(part, &self.axis);
            (excess > TILT_TOLERANCE).then_some(Breach::Tilt)
        }
    }

    /// The same plunge with another evaluation.
    fn with_evaluation<F>(self, evaluation: F) -> Position<F> {
        Position {
            tip: self.tip,
            axis: self.axis,
            section: self.section,
            row: self.row,
            s: self.s,
            lambda: self.lambda,
            alpha_rad: self.alpha_rad,
            contact_point: self.contact_point,
            lift: self.lift,
            blocked: self.blocked,
            limited_by: self.limited_by,
            hub_clearance: self.hub_clearance,
            blade_clearance: self.blade_clearance,
            evaluation,
        }
    }
}

/// A position that was dropped because the tool cannot cut there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// Index of the section.
    pub section: usize,
    /// Row within the section.
    pub row: usize,
    /// s of M, the foot of its axis.
    pub s: f64,
    /// Why.
    pub why: DropReason,
    /// The least overhang with which the tool could cut there, mm, where only its given holder is in the way.
    pub stick_out: Option<f64>,
}

/// A section, planned or found in a program: a stretch of s cut with one tool.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionPlan {
    /// The tool.
    pub tool: Tool,
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// Cutting direction of the rows.
    pub feed: CutDirection,
    /// Number of rows.
    pub rows: usize,
    /// What it cuts.
    pub kind: SectionKind,
    /// Plunges added to those of the rows; `None` for policies that add none, unless they were stopped, and
    /// for programs, which do not record it.
    pub added: Option<AddedPlunges>,
}

impl SectionPlan {
    /// Whether it is part of the program.
    pub fn is_cut(&self) -> bool {
        self.kind.is_cut(self.rows)
    }

    /// Whether planning was stopped before the section was finished: it holds the best result so far.
    pub fn is_unfinished(&self) -> bool {
        self.added.is_some_and(AddedPlunges::is_unfinished)
    }

    /// What was added to the rows, and why no more; `None` for policies that add none.
    pub fn added_words(&self) -> Option<String> {
        let added = self.added?;
        let AddedPlunges { count, stopped } = added;
        let why = stopped.words();
        Some(match (self.kind == SectionKind::Rest, count) {
            _ if added.is_unfinished() => format!("{count} plunges added; {why}"),
            (false, _) => format!("{count} plunges added to the rows; {why}"),
            (true, 0) => "nothing left that is thick enough for another cutter".to_owned(),
            (true, _) => format!("{count} plunges for the rest; {why}"),
        })
    }
}

/// A plunge plan of one channel, with the evaluation `E` of each plunge.
#[derive(Clone, Debug, PartialEq)]
pub struct PlungePlan<E = Evaluation> {
    /// Policy that made the axes.
    pub policy: AxisPolicy,
    /// Sections in cutting order.
    pub sections: Vec<SectionPlan>,
    /// Positions in cutting order: section by section, row by row.
    pub positions: Vec<Position<E>>,
    /// Positions that were dropped, with the reason.
    pub dropped: Vec<Dropped>,
    /// Largest number of iterations of the loop over any row ([plunge paper], fig. 16).
    pub iterations: usize,
    /// Whether the loop converged in every row.
    pub converged: bool,
}

impl<E> PlungePlan<E> {
    /// The same plunges with other evaluations, given by number in cutting order.
    pub fn with_evaluations<F>(self, evaluation: impl Fn(usize) -> F) -> PlungePlan<F> {
        let evaluated = |(k, position): (usize, Position<E>)| position.with_evaluation(evaluation(k));
        PlungePlan {
            policy: self.policy,
            sections: self.sections,
            positions: self.positions.into_iter().enumerate().map(evaluated).collect(),
            dropped: self.dropped,
            iterations: self.iterations,
            converged: self.converged,
        }
    }

    /// The tools of its program, one for each section that is cut.
    pub fn tools(&self) -> impl Iterator<Item = &Tool> {
        self.sections.iter().filter(|section| section.is_cut()).map(|section| &section.tool)
    }

    /// The tool of position `k`; `None` where it has no section.
    fn tool_at(&self, k: usize) -> Option<&Tool> {
        Some(&self.sections.get(self.positions.get(k)?.section)?.tool)
    }

    /// Number of plunges of section `index`.
    pub fn plunges_of(&self, index: usize) -> usize {
        self.positions.iter().filter(|position| position.section == index).count()
    }

    /// Why section `index` has no plunges; `None` if it has some.
    pub fn idle_words(&self, index: usize) -> Option<String> {
        let section = self.sections.get(index).filter(|_| self.plunges_of(index) == 0)?;
        let dropped = self.dropped.iter().filter(|dropped| dropped.section == index);
        let count = |why: DropReason| dropped.clone().filter(|dropped| dropped.why == why).count();
        let most = DropReason::ALL.into_iter().map(|why| (count(why), why)).max_by_key(|(count, _)| *count);
        Some(match (most, section.added_words()) {
            (Some((count, why)), _) if count > 0 => format!("{count} positions {}", why.words()),
            (_, Some(words)) => match section.added.map_or(0, |added| added.count) {
                0 => words,
                count => format!("none of the {count} that were found is worth its time"),
            },
            _ if section.kind == SectionKind::Rest => {
                "rest milling is for the strategy of minimum stock only".to_owned()
            }
            _ if section.kind == SectionKind::Opening => "nothing above the shroud is in the way".to_owned(),
            _ => "no row fits into the section".to_owned(),
        })
    }

    /// Whether planning was stopped before the plan was finished: it is valid, but leaves more stock than a
    /// finished one.
    pub fn is_unfinished(&self) -> bool {
        self.sections.iter().any(SectionPlan::is_unfinished)
    }

    /// Marks the plan, by its last section, as one whose planning was stopped.
    pub(crate) fn mark_unfinished(&mut self) {
        if let Some(section) = self.sections.last_mut() {
            let count = section.added.map_or(0, |added| added.count);
            section.added = Some(AddedPlunges { count, ..AddedPlunges::UNFINISHED });
        }
    }
}

impl PlungePlan {
    /// Number of positions that are [`Condition::Interfering`].
    pub fn count_interfering(&self) -> usize {
        self.positions.iter().filter(|p| p.condition() == Condition::Interfering).count()
    }

    /// Feed rate of position `k`, mm/min; 0 where it has no tool.
    pub fn feed_of(&self, k: usize) -> f64 {
        let own = self.positions.get(k).and_then(|p| p.evaluation.motion.feed_mm_per_min);
        own.or(self.tool_at(k).map(|tool| tool.plunge_feed)).unwrap_or(0.0)
    }

    /// Thickness of the chip of position `k`, mm: in a plunge the feed per tooth. `None` where the tool does
    /// not say how many teeth it has.
    pub fn chip_thickness_of(&self, k: usize) -> Option<f64> {
        let tool = self.tool_at(k)?;
        Some(self.feed_of(k) / (f64::from(tool.assembly.teeth?) * tool.spindle))
    }
}

impl<E: Sync> PlungePlan<E> {
    /// The columns of its plunges in `blank`, in cutting order.
    pub fn columns(&self, blank: &Blank) -> Columns {
        let top = BlankTop::new(blank);
        let column = |p: &Position<E>| {
            let tool = &self.sections[p.section].tool;
            PlungeColumn::new(tool.placed(p.tip, p.axis), tool.core_radius(), &top)
        };
        let columns: Vec<PlungeColumn> = self.positions.par_iter().map(column).collect();
        columns.into_iter().collect()
    }
}
