//! What a plunge plan is: positions in cutting order, with everything measured of them.

use crate::geometry::{Point, Vector};
use crate::part::Tool;
use crate::part::setup::{AxisPolicy, Feed};

/// Contact of the core with stock during one plunge (DESIGN section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct CoreContact {
    /// How far above the final bottom the stock reaches, mm; 0 when the core is free.
    pub depth: f64,
    /// Share of the core disc in stock at the end of the plunge, 0…1.
    pub area_share: f64,
}

/// Contact depth above which a position counts as interferential, mm.
pub const CONTACT_TOLERANCE: f64 = 0.02;

impl CoreContact {
    /// Whether the position is interferential.
    pub fn interferes(&self) -> bool {
        self.depth > CONTACT_TOLERANCE
    }
}

/// What is to be said of a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Condition {
    /// Its core meets no stock.
    Sound,
    /// The blades keep it from the axis its policy asks for.
    Blocked,
    /// Its core meets stock.
    Interferential,
}

impl Condition {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Blocked => "blocked",
            Self::Interferential => "interferential",
        }
    }
}

/// Why no more plunges were planned in a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stopped {
    /// None that is possible would take enough.
    NothingWorthwhile,
    /// There are as many as a section may get beside its rows.
    ShareReached,
    /// The whole plan has as many positions as one may have for more to be added.
    PlanFull,
    /// What is left is for the smaller cutter that comes after.
    SmallerCutter,
    /// Planning was cancelled: what there is of the section is the best so far.
    Cancelled,
}

impl Stopped {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::NothingWorthwhile => "nothing_worthwhile",
            Self::ShareReached => "share_reached",
            Self::PlanFull => "plan_full",
            Self::SmallerCutter => "smaller_cutter",
            Self::Cancelled => "cancelled",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::NothingWorthwhile => "no other would take enough",
            Self::ShareReached => "as many as a section may get",
            Self::PlanFull => "the plan is too long for more",
            Self::SmallerCutter => "the rest is for a smaller cutter",
            Self::Cancelled => "cancelled: the best so far",
        }
    }
}

/// Why a position could not get the axis its policy asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Blocked {
    /// No axis with the tilt asked for clears both walls.
    Walls,
    /// The row's shroud curve ends before the tilt asked for is reached.
    ShroudEnd,
    /// The tilt asked for is beyond `max_tilt`.
    TiltLimit,
}

/// What keeps a position of `minimal` from the axis that would leave the least there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Held {
    /// A blade is in the way of that axis.
    Walls,
    /// It is further from the axis before than `max_axis_change`.
    AxisChange,
    /// The core would meet stock, here or further on.
    Contact,
}

impl Held {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Walls, Self::AxisChange, Self::Contact];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::AxisChange => "axis change",
            Self::Contact => "contact",
        }
    }
}

/// One plunge.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Centre of the bottom at the end of the plunge.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Point on the axis at which the cutter is clear of the blank.
    pub retract: Point,
    /// Index into [`PlungePlan::sections`].
    pub section: usize,
    /// Row within the section, 0 at the suction wall.
    pub row: usize,
    /// Fraction of meridional arc length of the tip.
    pub s: f64,
    /// Channel coordinate across, 0 suction wall, 1 pressure wall.
    pub lambda: f64,
    /// α: signed angle between hub normal at the contact point and axis, rad, positive towards the inlet.
    pub alpha: f64,
    /// Where the bottom touches the allowance surface of the hub.
    pub contact_point: Point,
    /// Contact of the core with stock.
    pub contact: CoreContact,
    /// How far the plunge stops short of the allowance for its core to be free, mm.
    pub lift: f64,
    /// Why the policy's axis could not be had, if so.
    pub blocked: Option<Blocked>,
    /// What keeps it from the axis that would leave the least, if anything does. Only `minimal` knows.
    pub held: Option<Held>,
    /// Least distance of the cutter to the finished hub, mm.
    pub hub_clearance: f64,
    /// Least distance of the cutter to the finished blades, mm.
    pub blade_clearance: f64,
    /// Least distance of the bottom to the blank at the retract point and on the link after it, mm.
    pub retract_clearance: f64,
}

impl Position {
    /// What is to be said of it; contact of the core counts first.
    pub fn condition(&self) -> Condition {
        if self.contact.interferes() {
            Condition::Interferential
        } else if self.blocked.is_some() {
            Condition::Blocked
        } else {
            Condition::Sound
        }
    }

    /// A planned position before anything was measured of it.
    pub(super) fn unmeasured(station: &super::row::Station, section: usize, row: usize, lambda: f64) -> Self {
        Self {
            tip: station.tip,
            axis: station.axis,
            retract: station.tip,
            section,
            row,
            s: station.ends.s_hub,
            lambda,
            alpha: station.alpha,
            contact_point: station.contact_point,
            contact: CoreContact::default(),
            lift: 0.0,
            blocked: station.blocked,
            held: station.held,
            hub_clearance: f64::NAN,
            blade_clearance: f64::NAN,
            retract_clearance: f64::NAN,
        }
    }
}

/// Why there is no place for a cutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoPlace {
    /// It does not clear the blades.
    Blades,
    /// It would have to stop so short for its core to be free that it would cut next to nothing.
    Contact,
    /// It is shorter than its way through the blank: the holder would run into the blank.
    Overhang,
}

impl NoPlace {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Blades, Self::Contact, Self::Overhang];

    /// What is counted of this kind, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Blades => "that clear no blade",
            Self::Contact => "whose core would be free only far above the hub",
            Self::Overhang => "that the cutter is too short for",
        }
    }
}

/// A position that was left out because there is no place for its cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// Index of the section.
    pub section: usize,
    /// Row within the section.
    pub row: usize,
    /// s of the tip it would have had.
    pub s: f64,
    /// Why.
    pub why: NoPlace,
}

/// A stretch of s cut with one tool.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionPlan {
    /// The cutter.
    pub tool: Tool,
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// Direction of the rows.
    pub feed: Feed,
    /// Number of rows.
    pub rows: usize,
    /// Whether it cuts only what the sections before it left thick.
    pub rest: bool,
    /// Plunges that were added to those of the rows, and why no more; `None` by policies that add none, unless they were
    /// cancelled.
    pub added: Option<(usize, Stopped)>,
}

impl SectionPlan {
    /// Whether it is part of the program: one for the rest may turn out to have nothing to cut.
    pub fn is_cut(&self) -> bool {
        !self.rest || self.rows > 0
    }
}

/// A plunge plan of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct PlungePlan {
    /// Policy that made the axes.
    pub policy: AxisPolicy,
    /// Sections in cutting order.
    pub sections: Vec<SectionPlan>,
    /// Positions in cutting order: section by section, row by row.
    pub positions: Vec<Position>,
    /// Positions left out because the blades are in the way.
    pub dropped: Vec<Dropped>,
    /// Rounds of the outer loop (fig. 16).
    pub rounds: usize,
    /// Whether the loop came to rest.
    pub settled: bool,
}

impl PlungePlan {
    /// Whether planning was cancelled before this plan was finished: it is sound, but leaves more than it would have.
    pub fn is_unfinished(&self) -> bool {
        self.sections.iter().any(|s| matches!(s.added, Some((_, Stopped::Cancelled))))
    }
}
