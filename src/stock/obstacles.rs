//! What makes floor inaccessible: under which wall it lies, and for which cutter.

use super::corner::CornerLimit;
use super::floor_source::FloorSource;
use super::grid::FloorGrid;
use super::overhang::WallTables;
use super::reach::InaccessibleTables;

/// What keeps every axis of a cutter from a part of the floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FloorObstacle {
    /// The suction side of a main blade leans over it.
    SuctionSide,
    /// The pressure side of a main blade leans over it.
    PressureSide,
    /// The suction side of a splitter leans over it.
    SplitterSuctionSide,
    /// The pressure side of a splitter leans over it.
    SplitterPressureSide,
    /// No more than the hub allowance stands there, as at a slanted edge of the blank.
    HubAllowance,
}

impl FloorObstacle {
    /// The obstacle that is wall `face` of the tables: the walls of the channel, the first one a suction
    /// side, then the near and the far side of each splitter.
    fn of_face(face: usize) -> Self {
        match face {
            0 => Self::SuctionSide,
            1 => Self::PressureSide,
            _ if face % 2 == 1 => Self::SplitterSuctionSide,
            _ => Self::SplitterPressureSide,
        }
    }

    /// Its value in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::SuctionSide => "suction_side",
            Self::PressureSide => "pressure_side",
            Self::SplitterSuctionSide => "splitter_suction_side",
            Self::SplitterPressureSide => "splitter_pressure_side",
            Self::HubAllowance => "hub_allowance",
        }
    }

    /// Where the floor is, for users.
    pub fn words(self) -> &'static str {
        match self {
            Self::SuctionSide => "under the suction side",
            Self::PressureSide => "under the pressure side",
            Self::SplitterSuctionSide => "under the suction side of a splitter",
            Self::SplitterPressureSide => "under the pressure side of a splitter",
            Self::HubAllowance => "with no more stock than the hub allowance",
        }
    }
}

/// Inaccessible floor with the same cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InaccessibleFloor {
    /// What is in the way.
    pub obstacle: FloorObstacle,
    /// What keeps the cutter from getting nearer to that wall; `None` where no wall is in the way.
    pub limit: Option<CornerLimit>,
    /// Number of the tool that works there.
    pub tool: u32,
    /// Diameter of its cutter, mm.
    pub diameter: f64,
    /// s of its end nearest to the outlet.
    pub from: f64,
    /// s of its end nearest to the inlet.
    pub to: f64,
    /// Its share of the whole floor, 0…1. The shares of all causes add up to
    /// [`ResidualStatistics::unreachable_share`](super::ResidualStatistics::unreachable_share).
    pub share: f64,
}

/// The inaccessible floor of `grid`, which was made of `source` with `walls` and `reach`, by its causes, the
/// largest share first.
pub(super) fn inaccessible_floor(
    source: &FloorSource,
    grid: &FloorGrid,
    walls: &WallTables,
    reach: &InaccessibleTables,
) -> Vec<InaccessibleFloor> {
    let half_row = 0.5 / grid.rows as f64;
    let mut found: Vec<InaccessibleFloor> = Vec::new();
    let mut floor_area = 0.0;
    for row in 0..grid.rows {
        let s = grid.s_of_row(row);
        let over = walls.blades_over(s);
        let covered = reach.inaccessible_ranges(s, &over);
        let cell_angle = over.width.abs() / grid.columns as f64;
        let (tool, diameter) = reach.cutter_at(s).map_or((0, 0.0), |c| (c.tool, 2.0 * c.radius));
        for column in 0..grid.columns {
            let cell = row * grid.columns + column;
            if !grid.floor[cell] {
                continue;
            }
            let area = f64::from(grid.areas[cell]);
            floor_area += area;
            if grid.reachable[cell] {
                continue;
            }
            let holds_stock = f64::from(grid.blank_heights[cell]) > source.stock.hub_allowance;
            let face = covered.face_over((column as f64 + 0.5) * cell_angle).filter(|_| holds_stock);
            let obstacle = face.map_or(FloorObstacle::HubAllowance, FloorObstacle::of_face);
            let limit = face.map(|face| reach.limit_at(s, face));
            let same = |part: &&mut InaccessibleFloor| {
                (part.obstacle, part.limit, part.tool) == (obstacle, limit, tool)
            };
            let (from, to) = (s + half_row, s - half_row);
            match found.iter_mut().find(same) {
                Some(part) => {
                    (part.from, part.to) = (part.from.max(from), part.to.min(to));
                    part.share += area;
                }
                None => {
                    found.push(InaccessibleFloor { obstacle, limit, tool, diameter, from, to, share: area });
                }
            }
        }
    }
    for part in &mut found {
        part.share /= floor_area.max(f64::MIN_POSITIVE);
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share).then(a.obstacle.cmp(&b.obstacle)));
    found
}
