//! Passes and moves of a flank plan as lines.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::walls::wall_mesh;
use crate::error::UserError;
use crate::flank::region::{Region, WallName};
use crate::flank::{FlankMove, MoveKind};
use crate::geometry::Point;
use crate::gpu::mesh::{Mesh, Segment};
use crate::gpu::unknown_colours;
use crate::io::flank_file::{ShownPass, ShownWall};
use crate::palette::{self, ColourMap, Rgb, TABLE_LEN};
use crate::part::{BladeSide, Channel, Impeller};

/// What the colours of the lines show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FlankColours {
    /// The layer of a pass: dark next to the hub, light at the top.
    #[default]
    Layer,
    /// The region of the channel that a move of the program is in, rapids grey.
    Region,
    /// The feed rate of a move of the program: dark slow, light fast, rapids grey.
    Feed,
    /// The walls coloured by the stock left on them, instead of the passes.
    Walls,
}

impl FromStr for FlankColours {
    type Err = UserError;

    fn from_str(word: &str) -> Result<Self, UserError> {
        Ok(match word {
            "layer" => Self::Layer,
            "region" => Self::Region,
            "feed" => Self::Feed,
            "walls" => Self::Walls,
            _ => {
                let help = "use layer, region, feed, walls or solid";
                return Err(unknown_colours(word, help));
            }
        })
    }
}

/// Widths of lines along walls and of other lines, pixels.
const WIDTHS: [f32; 2] = [2.4, 1.4];
/// Width of the lines of the selected pass, pixels.
const SELECTED_WIDTH: f32 = 4.5;

/// Colour of a region. Those of a channel with up to three splitters are distinct.
pub fn region_colour(region: Region) -> Rgb {
    use WallName::{High, Low, Splitter};
    match (region.low, region.high) {
        // Not blue, which is the selected pass.
        (Low, High) => palette::category(2),
        (Low, Splitter(0)) => palette::SOUND,
        (Splitter(0), High) => palette::BLOCKED,
        (Splitter(low), Splitter(high)) => palette::category(4 + high * high.saturating_sub(1) / 2 + low),
        (Splitter(low), _) => palette::category(7 + low),
        (_, Splitter(high)) => palette::category(high.saturating_sub(1)),
        _ => palette::UNEVALUATED,
    }
}
/// Colour of rapids when moves are coloured by feed rate.
pub const RAPID_COLOUR: Rgb = [0.62, 0.62, 0.62];

/// Lowest and highest feed rate of the cutting moves, mm/min: the ends of the colour scale.
pub fn feed_range(moves: &[FlankMove]) -> (f64, f64) {
    let under_feed = || moves.iter().filter(|m| m.kind != MoveKind::Rapid).map(|m| m.feed_mm_per_min);
    (under_feed().fold(f64::INFINITY, f64::min), under_feed().fold(0.0, f64::max))
}

/// Lines of a plan with `layers` layers: its `moves` when coloured by feed rate or region, else its `curves`,
/// or none where the colours show the walls; and its `rapids`, grey.
pub fn toolpath_lines(
    curves: &[ShownPass],
    moves: &[FlankMove],
    layers: usize,
    colours: FlankColours,
    rapids: bool,
) -> Vec<Segment> {
    // Curves run on from one region into the next; the passes made of them do not.
    if matches!(colours, FlankColours::Feed | FlankColours::Region) {
        return move_lines(moves, moves, layers, colours, rapids);
    }
    let mut lines = if rapids { rapid_lines(moves) } else { Vec::new() };
    if colours == FlankColours::Walls {
        return lines;
    }
    let table = ColourMap::Viridis.table();
    for curve in curves {
        let colour = layer_colour(&table, curve.layer, layers);
        lines.extend(curve.points.windows(2).map(|p| segment(&p[0], &p[1], curve.wall, colour)));
    }
    lines
}

/// Lines of the first moves `made` of `all` moves of a plan with `layers` layers, its `rapids` in grey.
/// Grey where the colours show the walls.
pub fn move_lines(
    made: &[FlankMove],
    all: &[FlankMove],
    layers: usize,
    colours: FlankColours,
    rapids: bool,
) -> Vec<Segment> {
    let table = ColourMap::Viridis.table();
    let (slow, fast) = feed_range(all);
    let line = |pair: &[FlankMove]| {
        let step = &pair[1];
        let colour = match (step.kind, colours) {
            (MoveKind::Rapid, _) | (_, FlankColours::Walls) => RAPID_COLOUR,
            (_, FlankColours::Feed) => {
                let share = (step.feed_mm_per_min - slow) / (fast - slow).max(1e-6);
                colour_at(&table, share as f32)
            }
            (_, FlankColours::Region) => region_colour(step.region),
            (_, FlankColours::Layer) => layer_colour(&table, step.layer, layers),
        };
        segment(&pair[0].tip, &step.tip, step.along_wall, colour)
    };
    let is_shown = |pair: &&[FlankMove]| rapids || pair[1].kind != MoveKind::Rapid;
    made.windows(2).filter(is_shown).map(line).collect()
}

/// Lines of the rapids among `moves`.
fn rapid_lines(moves: &[FlankMove]) -> Vec<Segment> {
    let rapids = moves.windows(2).filter(|pair| pair[1].kind == MoveKind::Rapid);
    rapids.map(|pair| segment(&pair[0].tip, &pair[1].tip, pair[1].along_wall, RAPID_COLOUR)).collect()
}

/// Lines of the moves of the selected pass, over all others.
pub fn selected_lines(moves: &[FlankMove]) -> Vec<Segment> {
    let at = |p: &Point| [p.x as f32, p.y as f32, p.z as f32];
    let line = |pair: &[FlankMove]| {
        Segment::coloured(at(&pair[0].tip), at(&pair[1].tip), SELECTED_WIDTH, palette::SELECTED)
    };
    moves.windows(2).map(line).collect()
}

/// Colour at a share of a table, 0…1.
fn colour_at(table: &[[u8; 3]; TABLE_LEN], share: f32) -> Rgb {
    table[(share.clamp(0.0, 1.0) * (TABLE_LEN - 1) as f32) as usize].map(|x| f32::from(x) / 255.0)
}

/// Colour of a layer of `layers`.
fn layer_colour(table: &[[u8; 3]; TABLE_LEN], layer: usize, layers: usize) -> Rgb {
    colour_at(table, layer as f32 / layers.saturating_sub(1).max(1) as f32)
}

/// Mesh of the walls with the residual stock above the blade allowance (mm, negative for overcut), and its
/// largest absolute value. Where a wall is not milled, the mesh is marked as uncut.
pub fn wall_deviations(part: &Impeller, walls: &[ShownWall]) -> (Mesh, f32) {
    let turned = part.main.rotated(part.pitch());
    let splitters = if walls.is_empty() { Vec::new() } else { Channel::from_part(part).splitters };
    let sides = |shown: &ShownWall| match shown.wall {
        WallName::Low => Some([&part.main.suction, &part.main.pressure]),
        WallName::High => Some([&turned.pressure, &turned.suction]),
        WallName::Splitter(number) => {
            let splitter = splitters.get(number)?;
            let [near, far] = [&splitter.near, &splitter.far].map(|wall| wall.whole_side());
            Some(if shown.region.low == shown.wall { [far, near] } else { [near, far] })
        }
    };
    let mut mesh = Mesh::default();
    let mut most = 0.0f64;
    for shown in walls {
        let map = &shown.map;
        let Some([wall, back]): Option<[&BladeSide; 2]> = sides(shown) else { continue };
        mesh.append(&wall_mesh(wall, back, &map.u, &map.v, &map.deviation).unwrap_or_default());
        most = most.max(map.max_overcut()).max(map.max_undercut());
    }
    for vertex in mesh.vertices.iter_mut().filter(|vertex| vertex.value.is_nan()) {
        (vertex.value, vertex.uncut) = (0.0, 1.0);
    }
    (mesh, most as f32)
}

/// Upper end of the scale of walls, which is symmetric, for over- and undercut up to `most`, mm.
pub fn wall_scale_end(most: f32) -> f32 {
    /// Least end, mm: machines resolve no less.
    const MIN_END: f32 = 1e-3;
    most.max(MIN_END)
}

fn segment(a: &Point, b: &Point, wall: bool, colour: Rgb) -> Segment {
    let at = |p: &Point| [p.x as f32, p.y as f32, p.z as f32];
    Segment::coloured(at(a), at(b), WIDTHS[usize::from(!wall)], colour)
}
