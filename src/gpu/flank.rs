//! Curves and moves of a flank plan as lines.

use std::str::FromStr;

use super::mesh::{Mesh, Segment};
use super::walls::wall_mesh;
use crate::flank::chart::{Region, WallName};
use crate::flank::{FlankMove, MoveKind};
use crate::formats::flank_file::{ShownCurve, ShownWall};
use crate::geometry::Point;
use crate::palette::{self, ColourMap, Rgb, TABLE_LEN};
use crate::part::Impeller;

/// What the colours of the lines tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlankColours {
    /// The layer a curve lies on: dark next to the hub, light at the top.
    #[default]
    Layer,
    /// The region of the channel.
    Region,
    /// How a move of the program is made.
    Feed,
    /// What the cutter leaves on the walls, in place of curves.
    Walls,
}

/// A word that names no colours of flank curves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no colours of flank curves are called \"{0}\"; use layer, region, feed or walls")]
pub struct UnknownFlankColours(pub String);

impl FromStr for FlankColours {
    type Err = UnknownFlankColours;

    fn from_str(word: &str) -> Result<Self, UnknownFlankColours> {
        Ok(match word {
            "layer" => Self::Layer,
            "region" => Self::Region,
            "feed" => Self::Feed,
            "walls" => Self::Walls,
            _ => return Err(UnknownFlankColours(word.to_owned())),
        })
    }
}

/// Widths of lines along walls and of others, pixels.
const WIDTHS: [f32; 2] = [2.4, 1.4];

/// Colours of the regions, and of the kinds of move, with their names.
pub const REGION_COLOURS: [(Region, Rgb); 3] = [
    (Region::Inlet, palette::SELECTED),
    (Region::LowSide, palette::SOUND),
    (Region::HighSide, palette::BLOCKED),
];
/// See [`REGION_COLOURS`].
pub const MOVE_COLOURS: [(MoveKind, Rgb); 4] = [
    (MoveKind::Rapid, [0.62, 0.62, 0.62]),
    (MoveKind::Approach, palette::INTERFERENTIAL),
    (MoveKind::Cut, palette::SOUND),
    (MoveKind::Link, palette::BLOCKED),
];

/// The lines of `curves` of a plan with `layers` layers, or of its `moves`.
pub fn lines(
    curves: &[ShownCurve],
    moves: &[FlankMove],
    layers: usize,
    colours: FlankColours,
) -> Vec<Segment> {
    let mut lines = Vec::new();
    if colours == FlankColours::Walls {
        return lines;
    }
    if colours == FlankColours::Feed {
        for pair in moves.windows(2) {
            let colour = of(&MOVE_COLOURS, pair[1].kind);
            lines.push(segment(&pair[0].tip, &pair[1].tip, pair[1].wall, colour));
        }
        return lines;
    }
    let table = ColourMap::Viridis.table();
    for curve in curves {
        let colour = match colours {
            FlankColours::Region => of(&REGION_COLOURS, curve.region),
            _ => {
                let share = curve.layer as f32 / layers.saturating_sub(1).max(1) as f32;
                table[(share * (TABLE_LEN - 1) as f32) as usize].map(|x| f32::from(x) / 255.0)
            }
        };
        lines.extend(curve.points.windows(2).map(|p| segment(&p[0], &p[1], curve.wall, colour)));
    }
    lines
}

/// The walls with the stock that the cutter leaves above the blade allowance (negative below it), and the greatest of it
/// either way, mm.
pub fn wall_deviations(part: &Impeller, walls: &[ShownWall]) -> (Mesh, f32) {
    let turned = part.main.rotated(part.pitch());
    let mut mesh = Mesh::default();
    let mut most = 0.0f64;
    for shown in walls {
        let splitter = part.splitters.first();
        let sides = match (shown.wall, shown.region) {
            (WallName::Low, _) => Some((&part.main.suction, &part.main.pressure)),
            (WallName::High, _) => Some((&turned.pressure, &turned.suction)),
            (WallName::Splitter, Region::HighSide) => splitter.map(|s| (&s.suction, &s.pressure)),
            (WallName::Splitter, _) => splitter.map(|s| (&s.pressure, &s.suction)),
        };
        let map = &shown.map;
        let Some((wall, back)) = sides else { continue };
        mesh.append(&wall_mesh(wall, back, &map.u, &map.v, &map.deviation).unwrap_or_default());
        most = most.max(map.max_overcut()).max(map.max_undercut());
    }
    (mesh, most as f32)
}

fn of<K: PartialEq + Copy>(table: &[(K, Rgb)], key: K) -> Rgb {
    table.iter().find(|(k, _)| *k == key).map_or([0.0; 3], |(_, colour)| *colour)
}

fn segment(a: &Point, b: &Point, wall: bool, colour: Rgb) -> Segment {
    let at = |p: &Point| [p.x as f32, p.y as f32, p.z as f32];
    Segment::coloured(at(a), at(b), WIDTHS[usize::from(!wall)], colour)
}
