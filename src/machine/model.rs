//! What a machine file says: axes, limits, dynamics, how the part lies on the table, links.

use std::f64::consts::TAU;

use crate::geometry::{Point, Vector};

/// Rounding of an angle at a limit, rad.
const ANGLE_ROUNDING: f64 = 1e-6;
/// Rounding of a position at a limit, mm.
const POSITION_ROUNDING: f64 = 1e-3;

/// One of the three linear axes. Machine coordinates are those of the gauge point with all rotary axes at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearAxis {
    /// Lowest and highest position, mm.
    pub limits: (f64, f64),
    /// Rapid rate, mm/min.
    pub rapid: f64,
    /// Acceleration, mm/s².
    pub acceleration: f64,
    /// Jerk, mm/s³; infinite: not limited.
    pub jerk: f64,
}

/// What a rotary axis carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisSide {
    /// The workpiece.
    Table,
    /// The tool.
    Head,
}

/// A rotary axis.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryAxis {
    /// Its letter in programs: A, B or C.
    pub letter: char,
    /// What it carries.
    pub side: AxisSide,
    /// Unit vector about which a positive command turns the *body* (table or head) by the right hand, with
    /// all rotary axes at 0.
    pub direction: Vector,
    /// A point on the axis, mm: of a table in machine coordinates, of a head seen from the gauge point.
    pub point: Point,
    /// Lowest and highest position, rad; `None`: endless.
    pub limits: Option<(f64, f64)>,
    /// Rapid rate, rad/s.
    pub rapid_rad_per_s: f64,
    /// Acceleration, rad/s².
    pub acceleration: f64,
    /// Jerk, rad/s³; infinite: not limited.
    pub jerk: f64,
}

impl RotaryAxis {
    /// Whether the axis may stand at `angle` (rad).
    pub fn allows(&self, angle: f64) -> bool {
        self.limits.is_none_or(|(low, high)| (low - ANGLE_ROUNDING..=high + ANGLE_ROUNDING).contains(&angle))
    }

    /// `angle` and its whole turns within the limits, rad; itself alone for an endless axis.
    pub fn turns_within_limits(&self, angle: f64) -> impl Iterator<Item = f64> + '_ {
        let (low, high) = match self.limits {
            None => (0, 0),
            Some((low, high)) => {
                (((low - angle) / TAU - 1e-6).ceil() as i32, ((high - angle) / TAU + 1e-6).floor() as i32)
            }
        };
        (low..=high).map(move |turn| angle + TAU * f64::from(turn)).filter(|angle| self.allows(*angle))
    }
}

/// How the part lies on the table.
#[derive(Clone, Debug, PartialEq)]
pub struct PartPlacement {
    /// Whether the inlet points to +Z.
    pub inlet_up: bool,
    /// Angle by which the part is turned about Z, rad.
    pub clock_rad: f64,
    /// The part's origin in machine coordinates with all rotary axes at 0, mm. It is the program's zero.
    pub origin: Point,
    /// Name of the work offset or preset in programs, such as `G54`.
    pub offset_name: String,
}

impl PartPlacement {
    /// Number of the preset of the work offset, for controls that number them: 1 to 6 for `G54` to `G59`, or
    /// the number that is given instead of a name. `None` for other names.
    pub fn preset_number(&self) -> Option<u32> {
        let name = self.offset_name.trim();
        match name.strip_prefix(['G', 'g']) {
            Some(word) => {
                word.parse().ok().filter(|word| (54..=59).contains(word)).map(|word: u32| word - 53)
            }
            None => name.parse().ok(),
        }
    }
}

/// How turning links are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnLink {
    /// As planned, with the tip held on its line, at the rate of links.
    Feed,
    /// Out along the axis to the clearance sphere, around it while the axes turn, and in again.
    Clear,
}

/// `[links]`.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkSettings {
    /// How the axes turn between two cuts.
    pub turn: TurnLink,
    /// Distance of the clearance sphere from all that is cut, mm.
    pub clearance: f64,
    /// Rate of links, mm/min.
    pub rate: f64,
    /// What the control itself calls the upper limit of Z, to which programs retract, mm: its zero of the
    /// axes is where the builder put it, not that of the machine file.
    pub retract_z: f64,
}

/// What a program gives a control: tool tips or joint values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OutputKind {
    /// Tip and rotary positions; the control holds the tip (TCP, TRAORI, TCPM).
    TcpAngles,
    /// Tip and axis of the tool as a vector; the control chooses the rotary positions.
    TcpVectors,
    /// A tilted plane for each direction, and positions in it (3+2).
    Plane,
    /// Positions of all five axes, for controls that do not hold the tip.
    Joints,
}

impl OutputKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::TcpAngles, Self::TcpVectors, Self::Plane, Self::Joints];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::TcpAngles => "tcp-angles",
            Self::TcpVectors => "tcp-vectors",
            Self::Plane => "plane",
            Self::Joints => "joints",
        }
    }

    /// The kind of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A five-axis machine: three linear axes along X, Y and Z, and two rotary axes of any direction.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineTool {
    /// Its name.
    pub name: String,
    /// Its control: the name of a post.
    pub control: String,
    /// What its programs give.
    pub output: OutputKind,
    /// X, Y, Z.
    pub linear: [LinearAxis; 3],
    /// The rotary axes from workpiece to tool.
    pub rotary: [RotaryAxis; 2],
    /// Time of a tool change with the approach of the next tool, s.
    pub tool_change_s: f64,
    /// Length from the gauge point to the end of a tool's overhang, mm.
    pub holder_length: f64,
    /// Shortest time in which the control processes a block, s.
    pub block_time_s: f64,
    /// Time over which the control rounds a corner between two blocks: the speed of an axis may jump by its
    /// acceleration times this, s.
    pub corner_time_s: f64,
    /// The table that carries the part, if the machine file gives it.
    pub table: Option<MachineTable>,
    /// How the part lies on the table.
    pub part: PartPlacement,
    /// Links.
    pub links: LinkSettings,
}

impl MachineTool {
    /// Index of the first linear axis beyond its limits at the machine coordinates `joints`.
    pub fn linear_axis_beyond(&self, joints: &[f64; 3]) -> Option<usize> {
        (0..3).find(|&i| {
            let (low, high) = self.linear[i].limits;
            !(low - POSITION_ROUNDING..=high + POSITION_ROUNDING).contains(&joints[i])
        })
    }
}

/// Names of the linear axes.
pub const LINEAR_NAMES: [char; 3] = ['X', 'Y', 'Z'];

/// The table of a machine: a disc about its rotary axis, else about the part's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineTable {
    /// Its radius, mm.
    pub radius: f64,
    /// Machine coordinate Z of its upper face with all rotary axes at 0, mm.
    pub top: f64,
}
