//! What a plan says of its positions and sections in a word: their condition, what blocks, limits or drops
//! them, and why no more plunges were added.

/// Overall condition of a position, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Condition {
    /// It has the prescribed axis, and its core meets no stock.
    Sound,
    /// It lacks the axis its policy prescribes; see [`Blocked`].
    Blocked,
    /// Its core meets stock, or it exceeds a limit of the setup; see [`Breach`].
    Interfering,
}

/// Limit of the setup that a plunge exceeds. Planned plunges keep them; those that are moved by hand may not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breach {
    /// It comes nearer to the hub than the allowance.
    Hub,
    /// It comes nearer to a blade than the allowance.
    Blade,
    /// Its shank comes nearer to part or blank than its clearance.
    Shank,
    /// Its holder does.
    Holder,
    /// The machine does not reach its axis.
    Tilt,
}

impl Breach {
    /// All of them, the gravest first.
    pub const ALL: [Self; 5] = [Self::Blade, Self::Hub, Self::Shank, Self::Holder, Self::Tilt];

    /// What is wrong, as shown to the user.
    pub fn words(self) -> &'static str {
        match self {
            Self::Hub => "closer to the hub than its allowance",
            Self::Blade => "closer to a blade than its allowance",
            Self::Shank => "shank closer to part or blank than its clearance",
            Self::Holder => "holder closer to part or blank than its clearance",
            Self::Tilt => "axis beyond the reach of the machine",
        }
    }
}

impl Condition {
    /// Name, as shown to the user and written to glTF files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Blocked => "blocked",
            Self::Interfering => "interferential",
        }
    }
}

/// Why no more plunges were added to a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// No possible plunge would remove enough stock.
    NothingWorthwhile,
    /// The limit of added plunges per section, a multiple of those of its rows, is reached.
    ShareReached,
    /// The number of positions at which a plan gets no further plunges is reached.
    PlanFull,
    /// The remaining stock is left to the smaller tool of a later rest-milling section.
    SmallerCutter,
    /// Planning was stopped; the section holds the best result so far.
    Cancelled,
}

impl StopReason {
    /// All variants.
    pub const ALL: [Self; 5] =
        [Self::NothingWorthwhile, Self::ShareReached, Self::PlanFull, Self::SmallerCutter, Self::Cancelled];

    /// Key in files.
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
            Self::NothingWorthwhile => "no further plunge would remove enough",
            Self::ShareReached => "limit for the section reached",
            Self::PlanFull => "limit of positions for the plan reached",
            Self::SmallerCutter => "the rest is left to a smaller cutter",
            Self::Cancelled => "cancelled: best result so far",
        }
    }
}

/// Plunges that were added to those of the rows of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddedPlunges {
    /// Their number.
    pub count: usize,
    /// Why no more.
    pub stopped: StopReason,
}

impl AddedPlunges {
    /// None before planning was stopped.
    pub const UNFINISHED: Self = Self { count: 0, stopped: StopReason::Cancelled };

    /// Whether planning was stopped before the section was finished.
    pub fn is_unfinished(self) -> bool {
        self.stopped == StopReason::Cancelled
    }
}

/// Why a position lacks the axis its policy prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// No axis with the required inclination clears both walls.
    Walls,
    /// The row's shroud curve ends before the required inclination is reached.
    ShroudEnd,
    /// The required inclination exceeds `max_tilt`.
    TiltLimit,
}

impl Blocked {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::Walls, Self::ShroudEnd, Self::TiltLimit];

    /// Key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::ShroudEnd => "shroud_end",
            Self::TiltLimit => "tilt_limit",
        }
    }
}

/// What limits a position of `minimal`: why it lacks the axis that would leave the least stock there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitedBy {
    /// That axis does not clear the blades.
    Walls,
    /// That axis differs from the previous one by more than `max_axis_change`.
    AxisChange,
    /// The core would meet stock, at this position or a later one.
    Contact,
    /// The machine does not reach that axis.
    Machine,
}

impl LimitedBy {
    /// All variants.
    pub const ALL: [Self; 4] = [Self::Walls, Self::AxisChange, Self::Contact, Self::Machine];

    /// Key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::AxisChange => "axis_change",
            Self::Contact => "contact",
            Self::Machine => "machine",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::AxisChange => "axis change",
            Self::Contact => "contact",
            Self::Machine => "the machine",
        }
    }
}

/// Why a position was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropReason {
    /// The cutter does not clear the blades.
    Blades,
    /// The plunge would have to stop so short for its core to be free that it would cut next to nothing.
    Contact,
    /// The overhang is shorter than the depth in the blank: the holder would enter the blank.
    Overhang,
    /// The shank would come too near to the part or the blank.
    Shank,
    /// The holder would come too near to the part or the blank.
    Holder,
    /// The axis is beyond the reach of the machine.
    Machine,
}

impl DropReason {
    /// All variants.
    pub const ALL: [Self; 6] =
        [Self::Blades, Self::Contact, Self::Overhang, Self::Shank, Self::Holder, Self::Machine];

    /// Key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blades => "blades",
            Self::Contact => "contact",
            Self::Overhang => "overhang",
            Self::Shank => "shank",
            Self::Holder => "holder",
            Self::Machine => "machine",
        }
    }

    /// Relative clause that completes "n positions …" in reports.
    pub fn words(self) -> &'static str {
        match self {
            Self::Blades => "that do not clear the blades",
            Self::Contact => "whose core is free of stock only far above the hub",
            Self::Overhang => "for which the tool is too short",
            Self::Shank => "whose shank comes too near to part or blank",
            Self::Holder => "whose holder comes too near to part or blank",
            Self::Machine => "whose axis the machine does not reach",
        }
    }
}
