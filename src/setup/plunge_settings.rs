//! Settings of the plunge planner: policies, sections and goals.

use super::PlungeEdit;

/// Axis policy of the plunge planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisPolicy {
    /// Isoparametric axes, as commercial modules plan them.
    Conventional,
    /// The angle between hub normal and axis grows from position to position ([plunge paper]).
    Monotone,
    /// Vanecut's own: the least residual stock without core contact.
    Minimal,
    /// Isoparametric axes, each plunge shortened until its core is free.
    Staircase,
}

impl AxisPolicy {
    /// All policies, from current practice to Vanecut's own.
    pub const ALL: [Self; 4] = [Self::Conventional, Self::Monotone, Self::Staircase, Self::Minimal];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Conventional => "conventional",
            Self::Monotone => "monotone",
            Self::Minimal => "minimal",
            Self::Staircase => "staircase",
        }
    }
}

/// Direction in which the rows of a section are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum CutDirection {
    /// Outlet → inlet; `inward` in files.
    #[serde(rename = "inward", alias = "outlet_to_inlet")]
    OutletToInlet,
    /// Inlet → outlet; `outward` in files.
    #[serde(rename = "outward", alias = "inlet_to_outlet")]
    InletToOutlet,
}

impl CutDirection {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::OutletToInlet => "outlet to inlet",
            Self::InletToOutlet => "inlet to outlet",
        }
    }

    /// +1 when rows run inwards, −1 when they run outwards.
    pub fn sign_along_s(self) -> f64 {
        match self {
            Self::OutletToInlet => 1.0,
            Self::InletToOutlet => -1.0,
        }
    }
}

/// `[[plunge.section]]`: a range of s cut with one tool.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionSetup {
    /// Number of the tool in the list of tools.
    pub tool: u32,
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// Direction of the rows; absent: inward, or with `minimal` the one that leaves less.
    pub cut_direction: Option<CutDirection>,
    /// What it cuts.
    pub kind: SectionKind,
}

impl SectionSetup {
    /// Direction of the rows where the policy leaves it to the setup.
    pub fn direction(&self) -> CutDirection {
        self.cut_direction.unwrap_or(CutDirection::OutletToInlet)
    }
}

/// What a section of plunges cuts: keys `rest` and `opening` of a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SectionKind {
    /// The channel between hub and shroud, in rows.
    #[default]
    Rows,
    /// Rest milling: single plunges only where earlier sections left a thick layer. Only `minimal` plans it;
    /// the other policies skip it.
    Rest,
    /// What stands above the shroud in the way of the tools of later sections: plunges along the axis of
    /// rotation.
    Opening,
}

impl SectionKind {
    /// Whether a section with this many rows is part of the program; one for the rest, or above the shroud,
    /// may have nothing to cut.
    pub fn is_cut(self, rows: usize) -> bool {
        self == Self::Rows || rows > 0
    }

    /// Word in programs; `None` for rows.
    pub fn word(self) -> Option<&'static str> {
        match self {
            Self::Rows => None,
            Self::Rest => Some("REST"),
            Self::Opening => Some("OPENING"),
        }
    }

    /// The kind with these words at the end of a section in a program.
    pub fn from_words(words: &[&str]) -> Self {
        let is = |kind: &Self| kind.word().is_some_and(|word| words == [word]);
        [Self::Rest, Self::Opening].into_iter().find(is).unwrap_or_default()
    }

    /// What follows the name of a tool where it does not cut rows.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Rows => "",
            Self::Rest => ", rest",
            Self::Opening => ", above the shroud",
        }
    }
}

/// `[plunge]`.
#[derive(Clone, Debug, PartialEq)]
pub struct PlungeSetup {
    /// Policy of the result.
    pub axis: AxisPolicy,
    /// Upper limit of the step along a row, mm; absent: 0.8 × the insert width of each tool.
    pub step: Option<f64>,
    /// Upper limit of the stepover between rows, mm; absent: 4/3 of the radius of each tool.
    pub stepover: Option<f64>,
    /// Largest scallop height between plunges along a wall, mm.
    pub wall_scallop: f64,
    /// Largest angle between the axes of neighbouring positions, rad (degrees in the file).
    pub max_axis_change_rad: f64,
    /// Largest angle of an axis from the isoparametric one, rad (degrees in the file: `max_tilt`).
    pub max_tilt_rad: f64,
    /// Distance by which the tool moves off the stock beside it after a plunge, and up as far, at 45°, before
    /// it retracts, mm; absent: it retracts straight.
    pub lead_out: Option<f64>,
    /// Depth after which a plunge is interrupted to break the chip, mm; absent: it is not.
    pub peck: Option<f64>,
    /// Whether the feed rate of a plunge follows its engagement, for tools whose number of teeth is known.
    pub adapt_feed: bool,
    /// Whether a plunge comes down in rapid to the safety distance above what earlier plunges left, instead
    /// of feeding from the retract point over the blank; rapids down along the axis are then judged by that
    /// too.
    pub rapid_approach: bool,
    /// What a plan of `minimal` is for.
    pub goal: Goal,
    /// Whether automatically chosen sections are followed by rest milling with smaller tools, for the stock
    /// beside leaning walls ([`SectionKind::Rest`]).
    pub rest: bool,
    /// Sections, outlet → inlet; empty: chosen from the tools, for the least time.
    pub sections: Vec<SectionSetup>,
    /// What the user changed in the plan by hand, in the order in which it applies.
    pub edits: Vec<PlungeEdit>,
}

/// What a plan of `minimal` is for: key `goal` of `[plunge]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The least residual stock, by as few plunges as leave it within 2 %.
    Stock {
        /// Within this time of one channel, minutes; `None`: whatever it takes.
        max_time_min: Option<f64>,
    },
    /// The least time.
    Time {
        /// With at most this stock above the hub allowance at the 95th percentile, mm.
        max_stock: f64,
    },
    /// Where more time begins to buy little.
    Balance,
    /// The least time of plunging and of removing by semi-finishing what the plunges leave.
    Total {
        /// What semi-finishing takes.
        finishing: SemiFinishing,
    },
}

impl Default for Goal {
    fn default() -> Self {
        Self::Stock { max_time_min: None }
    }
}

/// How fast semi-finishing removes what plunges leave above the allowance of the hub.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SemiFinishing {
    /// By volume: key `finish_rate`.
    Rate {
        /// Removal rate, mm³/min.
        mm3_per_min: f64,
    },
    /// In passes over the floor of a channel: keys `finish_depth` and `finish_pass_time`.
    Passes {
        /// Stock that a pass removes, mm.
        depth: f64,
        /// Time of a pass over one channel, minutes.
        pass_time_min: f64,
    },
}

impl SemiFinishing {
    /// Time that semi-finishing of one channel takes, s: for a `volume` above the allowance, mm³, or in as
    /// many passes as the height above it that 95 % of the floor stays below, `p95` mm, needs.
    pub fn time_s(&self, volume: f64, p95: f64) -> f64 {
        let minutes = match *self {
            Self::Rate { mm3_per_min } => volume.max(0.0) / mm3_per_min,
            Self::Passes { depth, pass_time_min } => (p95.max(0.0) / depth).ceil() * pass_time_min,
        };
        60.0 * minutes
    }
}
