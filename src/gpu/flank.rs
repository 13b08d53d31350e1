//! Curves and moves of a flank plan as lines.

use std::str::FromStr;

use super::mesh::Segment;
use super::palette::{self, ColourMap, Rgb, TABLE_LEN};
use crate::flank::chart::Region;
use crate::flank::{FlankMove, MoveKind};
use crate::formats::flank_file::ShownCurve;
use crate::geometry::Point;

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
}

/// A word that names no colours of flank curves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no colours of flank curves are called \"{0}\"; use layer, region or feed")]
pub struct UnknownFlankColours(pub String);

impl FromStr for FlankColours {
    type Err = UnknownFlankColours;

    fn from_str(word: &str) -> Result<Self, UnknownFlankColours> {
        Ok(match word {
            "layer" => Self::Layer,
            "region" => Self::Region,
            "feed" => Self::Feed,
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

fn of<K: PartialEq + Copy>(table: &[(K, Rgb)], key: K) -> Rgb {
    table.iter().find(|(k, _)| *k == key).map_or([0.0; 3], |(_, colour)| *colour)
}

fn segment(a: &Point, b: &Point, wall: bool, colour: Rgb) -> Segment {
    let at = |p: &Point| [p.x as f32, p.y as f32, p.z as f32];
    Segment { a: at(a), width: WIDTHS[usize::from(!wall)], b: at(b), colour: own_colour(colour) }
}

/// A colour of its own for a line, as the shader unpacks it.
fn own_colour(colour: Rgb) -> u32 {
    let [r, g, b] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u32);
    0x8000_0000 | b << 16 | g << 8 | r
}
