//! `flank.json`: a flank plan with everything needed to show it again, part and setup included.

use serde::{Deserialize, Serialize};

use super::InputError;
use super::native::write_native;
use super::setup_file::write_setup;
use super::stored::{self, Origin, are_sane, damaged};
use crate::flank::chart::{Region, WallName};
use crate::flank::schemes::Role;
use crate::flank::wall::DeviationMap;
use crate::flank::{FlankMove, FlankPlan, MilledWall, MoveKind};
use crate::geometry::Point;
use crate::part::{FlankScheme, Impeller, PartDescription, Setup};
use crate::plunge::choice::estimate::RAPID_FEED;

/// Version of the file; readers refuse newer ones.
const VERSION: u32 = 1;
/// Positions and points are written to this, mm.
const DECIMALS: f64 = 1e6;
/// Axes are written to this.
const AXIS_DECIMALS: f64 = 1e9;
/// Feeds are written to this, mm/min.
const FEED_DECIMALS: f64 = 1e3;

#[derive(Serialize, Deserialize)]
struct FlankFile {
    vanecut_flank: u32,
    /// The part in the native format.
    part: String,
    /// The setup with the cutter filled in.
    setup: String,
    scheme: FlankScheme,
    /// Feed along curves beside others, mm/min.
    feed: f64,
    layers: Vec<LayerFile>,
    #[serde(default)]
    walls: Vec<WallFile>,
    moves: Vec<MoveFile>,
    /// Of each move, mm/min; older files have one feed for all that are not rapid.
    #[serde(default)]
    feeds: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
struct LayerFile {
    /// mm above the hub.
    height: f64,
    /// Distance of neighbouring curves, mm.
    interval: f64,
    curves: Vec<CurveFile>,
}

#[derive(Serialize, Deserialize)]
struct CurveFile {
    wall: bool,
    region: Region,
    points: Vec<[f64; 3]>,
}

/// Deviation of a milled wall.
#[derive(Serialize, Deserialize)]
struct WallFile {
    wall: WallName,
    region: Region,
    u: Vec<f64>,
    v: Vec<f64>,
    /// Line by line of u, mm: stock above the blade allowance, negative below it.
    deviation: Vec<f64>,
}

/// What the cutter leaves on a wall, swept along it.
#[derive(Clone, Debug)]
pub struct ShownWall {
    /// Which wall.
    pub wall: WallName,
    /// The passage beside it.
    pub region: Region,
    /// Stock above the blade allowance.
    pub map: DeviationMap,
}

/// kind, layer, region, along a wall, tip, axis.
type MoveFile = (MoveKind, usize, Region, bool, [f64; 3], [f64; 3]);

/// A curve as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownCurve {
    /// Layer, 0 at the hub.
    pub layer: usize,
    /// Where its middle lies.
    pub region: Region,
    /// Whether it runs along a wall.
    pub wall: bool,
    /// Its points on the layer, mm.
    pub points: Vec<Point>,
}

/// A flank plan read back.
#[derive(Debug)]
pub struct StoredFlank {
    /// The part as it was.
    pub description: PartDescription,
    /// The part, built.
    pub part: Impeller,
    /// The setup the plan was made with.
    pub setup: Setup,
    /// Its scheme.
    pub scheme: FlankScheme,
    /// Feed along curves beside others, mm/min.
    pub feed: f64,
    /// Number of layers.
    pub layers: usize,
    /// The curves of all layers.
    pub curves: Vec<ShownCurve>,
    /// What it leaves on the walls.
    pub walls: Vec<ShownWall>,
    /// The program.
    pub moves: Vec<FlankMove>,
}

/// The curves of a plan as they are shown.
pub fn shown_curves(plan: &FlankPlan) -> Vec<ShownCurve> {
    let layers = plan.curves.layers.iter().enumerate();
    layers
        .flat_map(|(number, layer)| {
            layer.curves.iter().map(move |curve| ShownCurve {
                layer: number,
                region: curve.region,
                wall: matches!(curve.role, Role::Wall(WallName::Low | WallName::High | WallName::Splitter)),
                points: curve.points.iter().map(|p| layer.layer.point(*p)).collect(),
            })
        })
        .collect()
}

/// The walls of a plan as they are shown.
pub fn shown_walls(plan: &FlankPlan) -> Vec<ShownWall> {
    let shown = |w: &MilledWall| ShownWall { wall: w.wall, region: w.region, map: w.axes.map.clone() };
    plan.walls.iter().map(shown).collect()
}

fn rounded(coordinates: [f64; 3], decimals: f64) -> [f64; 3] {
    coordinates.map(|x| (x * decimals).round() / decimals)
}

/// Text of a flank plan file.
pub fn write_flank(description: &PartDescription, setup: &Setup, plan: &FlankPlan) -> String {
    let curves = shown_curves(plan);
    let layers = plan.curves.layers.iter().enumerate().map(|(number, layer)| LayerFile {
        height: layer.layer.height,
        interval: layer.interval,
        curves: curves
            .iter()
            .filter(|curve| curve.layer == number)
            .map(|curve| CurveFile {
                wall: curve.wall,
                region: curve.region,
                points: curve.points.iter().map(|p| rounded(p.coords.into(), DECIMALS)).collect(),
            })
            .collect(),
    });
    let file = FlankFile {
        vanecut_flank: VERSION,
        part: write_native(description),
        setup: write_setup(setup),
        scheme: plan.curves.scheme,
        feed: plan.feeds.step,
        layers: layers.collect(),
        walls: plan
            .walls
            .iter()
            .map(|w| {
                let round = |x: &f64| (x * DECIMALS).round() / DECIMALS;
                let map = &w.axes.map;
                let (u, v) = (map.u.iter().map(round).collect(), map.v.iter().map(round).collect());
                WallFile {
                    wall: w.wall,
                    region: w.region,
                    u,
                    v,
                    deviation: map.deviation.iter().map(round).collect(),
                }
            })
            .collect(),
        moves: plan
            .moves
            .iter()
            .map(|m| {
                let (tip, axis) =
                    (rounded(m.tip.coords.into(), DECIMALS), rounded(m.axis.into(), AXIS_DECIMALS));
                (m.kind, m.layer, m.region, m.wall, tip, axis)
            })
            .collect(),
        feeds: plan.moves.iter().map(|m| (m.feed * FEED_DECIMALS).round() / FEED_DECIMALS).collect(),
    };
    let mut text = serde_json::to_string(&file).unwrap_or_default();
    text.push('\n');
    text
}

/// Whether the bytes look like a flank plan file rather than a plunge plan.
pub fn is_flank(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(64)];
    head.windows(15).any(|w| w == b"\"vanecut_flank\"")
}

/// Reads a flank plan file; `name` stands for it in messages.
///
/// # Errors
/// What is wrong and where, when the bytes are no flank plan file of a known version.
pub fn read_flank_bytes(name: &str, bytes: &[u8]) -> Result<StoredFlank, InputError> {
    let file: FlankFile = serde_json::from_slice(bytes).map_err(|e| {
        InputError::new(
            name,
            e.line(),
            format!("this is no flank plan file ({e})"),
            "give a flank.json that `vanecut flank` wrote",
        )
    })?;
    stored::check_version(name, "flank plan file", file.vanecut_flank, VERSION)?;
    let Origin { description, part, setup } = stored::origin(name, &file.part, &file.setup)?;
    let layers = file.layers.len();
    let mut curves = Vec::new();
    for (layer, found) in file.layers.into_iter().enumerate() {
        for curve in found.curves {
            if !are_sane(curve.points.iter().flatten()) {
                return Err(damaged(name, format!("a curve of layer {} is damaged", layer + 1)));
            }
            let points = curve.points.into_iter().map(stored::point).collect();
            curves.push(ShownCurve { layer, region: curve.region, wall: curve.wall, points });
        }
    }
    let mut moves = Vec::with_capacity(file.moves.len());
    for (number, (kind, layer, region, wall, tip, axis)) in file.moves.into_iter().enumerate() {
        let axis = stored::unit_axis(axis).filter(|_| are_sane(&tip) && layer < layers.max(1));
        let feed = file.feeds.get(number).copied().unwrap_or(match kind {
            MoveKind::Rapid => RAPID_FEED,
            _ => file.feed,
        });
        let Some(axis) = axis.filter(|_| feed > 0.0 && feed.is_finite()) else {
            return Err(damaged(name, format!("move {} is damaged", number + 1)));
        };
        moves.push(FlankMove { kind, tip: stored::point(tip), axis, feed, layer, region, wall });
    }
    let mut walls = Vec::new();
    for wall in file.walls {
        let numbers = wall.u.iter().chain(&wall.v).chain(&wall.deviation);
        if wall.deviation.len() != wall.u.len() * wall.v.len() || !are_sane(numbers) {
            return Err(damaged(name, "the deviation of a wall is damaged"));
        }
        let map = DeviationMap { u: wall.u, v: wall.v, deviation: wall.deviation };
        walls.push(ShownWall { wall: wall.wall, region: wall.region, map });
    }
    Ok(StoredFlank {
        walls,
        description,
        part,
        setup,
        scheme: file.scheme,
        feed: file.feed,
        layers,
        curves,
        moves,
    })
}
