//! What is asked of the milling of a wall, and the positions along it.

use crate::geometry::{Point, Vector};
use crate::setup::Tool;

/// Parameters of the milling of a wall. All lengths in mm.
#[derive(Clone, Debug)]
pub struct WallMilling<'a> {
    /// The tool.
    pub tool: &'a Tool,
    /// Stock that stays on the blades.
    pub blade_allowance: f64,
    /// Stock that stays on the hub: below it, and below the corner of the cutter, the wall is not cut.
    pub hub_allowance: f64,
    /// Length of the pass beyond either end of the wall.
    pub lead_in_out: f64,
    /// Maximum distance between stations.
    pub step: f64,
    /// Maximum chord error of the straight move between two stations; it reduces their distance where the
    /// wall bends.
    pub chord_error: f64,
}

/// The blade side that a position is too near to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeObstacle {
    /// Index of the blade side in [`crate::part::Channel::sides`]; of a blade that is not around the channel
    /// that of the same side there.
    pub side: usize,
    /// u of the nearest point on it, LE 0 to TE 1.
    pub u: f64,
    /// v of that point, hub 0 to tip 1.
    pub v: f64,
    /// Distance there, mm; negative where the cutter cuts the blade.
    pub distance: f64,
}

/// One position of the tool beside the wall, in the frame of the part.
#[derive(Clone, Copy, Debug)]
pub struct WallStation {
    /// u of the wall at which the position was fitted; beyond 0…1 on the extensions of the wall.
    pub u: f64,
    /// s of the foot of the axis on the hub.
    pub s: f64,
    /// Point of the axis near the hub.
    pub foot: Point,
    /// Unit axis, towards the holder.
    pub axis: Vector,
    /// Tip of the tool, lowered along the axis until it rests on the layer; `None` where it misses the layer.
    pub tip: Option<Point>,
    /// Forced deviation, mm: the minimax deviation of a straight edge from the strip of the wall that this
    /// layer forms, not cutting the wall above by more. Twist and bow force it.
    pub forced: f64,
    /// What the cutter is too near to: another wall, or a nose.
    pub blocked: Option<BladeObstacle>,
}
