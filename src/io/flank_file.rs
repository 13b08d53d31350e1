//! `flank.json`: a flank plan with everything needed to display it again, including part and setup.

use serde::{Deserialize, Serialize};

use super::InputError;
use super::native::write_native;
use super::setup_file::write_full_setup;
use super::source::Source;
use super::stored;
use super::stored::{StoredInputs, are_coordinates, damaged};
use crate::error::ErrorCode;
use crate::flank::channels::FlankChannel;
use crate::flank::region::{Region, WallName};
use crate::flank::strategies::PassRole;
use crate::flank::wall::DeviationMap;
use crate::flank::{FlankMove, FlankOpening, FlankPlan, MilledWall, MoveKind};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, PartDescription, Workpiece};
use crate::setup::{FlankStrategy, Setup, tool_of};
use crate::toolpath::{ClProgram, RAPID_MM_PER_MIN};
use crate::verify::FlankVerdict;

/// Version of the file format; newer files are rejected.
pub(super) const VERSION: u32 = 3;
/// Version of files of one channel, which programs of that version read as well.
const ONE_CHANNEL_VERSION: u32 = 2;
/// Steps per mm to which positions and points are rounded.
const STEPS_PER_MM: f64 = 1e6;
/// Steps per unit to which axis components are rounded.
const AXIS_STEPS: f64 = 1e9;
/// Steps per mm/min to which feed rates are rounded.
const FEED_STEPS: f64 = 1e3;

#[derive(Serialize, Deserialize)]
struct FlankFile {
    vanecut_flank: u32,
    /// The part in the native format.
    part: String,
    /// The setup in its file format, with the chosen tool filled in.
    setup: String,
    scheme: FlankStrategy,
    /// Number of channels that the plan is repeated for; absent: one.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    channels: usize,
    /// Feed rate along passes beside one that is already cut, mm/min.
    feed: f64,
    layers: Vec<LayerFile>,
    #[serde(default)]
    walls: Vec<WallFile>,
    moves: Vec<MoveFile>,
    /// Feed rate of each move, mm/min; older files have one feed rate for all moves that are not rapid.
    #[serde(default)]
    feeds: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    opening: Option<OpeningFile>,
}

fn one() -> usize {
    1
}

fn is_one(count: &usize) -> bool {
    *count == 1
}

/// Plunges above the shroud.
#[derive(Serialize, Deserialize)]
struct OpeningFile {
    /// Number of their tool in the setup.
    tool: u32,
    /// Retract point, tip and axis of each.
    plunges: Vec<[[f64; 3]; 3]>,
    /// Tip and axis of each rapid to the passes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    link: Vec<[[f64; 3]; 2]>,
}

#[derive(Serialize, Deserialize)]
struct LayerFile {
    /// Height above the hub, mm.
    height: f64,
    /// Stepover between neighbouring passes, mm.
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
    /// Deviation, row by row of u, mm: stock above the blade allowance, negative below it.
    deviation: Vec<f64>,
    /// Indices in it where the wall is not milled; there it is 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unmilled: Vec<usize>,
}

/// What the swept cutter leaves on a wall.
#[derive(Clone, Debug)]
pub struct ShownWall {
    /// Which wall.
    pub wall: WallName,
    /// The passage beside it.
    pub region: Region,
    /// Stock above the blade allowance, mm.
    pub map: DeviationMap,
}

/// Kind, layer, region, whether it runs along a wall, tip (mm), axis (unit vector).
type MoveFile = (MoveKind, usize, Region, bool, [f64; 3], [f64; 3]);

/// A pass as it is displayed.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownPass {
    /// Layer index, 0 at the hub.
    pub layer: usize,
    /// Region of its middle.
    pub region: Region,
    /// Whether it runs along a wall.
    pub wall: bool,
    /// Its points on the layer, in the part frame, mm.
    pub points: Vec<Point>,
}

/// A flank plan read back.
#[derive(Debug)]
pub struct StoredFlank {
    /// Description of the part when the plan was made.
    pub description: PartDescription,
    /// The part built from it.
    pub part: Impeller,
    /// The setup the plan was made with.
    pub setup: Setup,
    /// Strategy of the passes.
    pub scheme: FlankStrategy,
    /// Feed rate along passes beside one that is already cut, mm/min.
    pub feed_mm_per_min: f64,
    /// Number of layers.
    pub layers: usize,
    /// The passes of all layers.
    pub passes: Vec<ShownPass>,
    /// Deviation of the milled walls.
    pub walls: Vec<ShownWall>,
    /// What is cut before.
    pub opening: Option<FlankOpening>,
    /// All moves of one channel in cutting order.
    pub moves: Vec<FlankMove>,
    /// Number of channels that it is repeated for.
    pub channels: usize,
}

impl StoredFlank {
    /// What it cuts in one channel; `None` where its setup lacks the tool.
    fn in_one_channel(&self) -> Option<FlankChannel<'_>> {
        // The setup of a flank plan names the tool that was chosen.
        let number = self.setup.flank.tool;
        let tool = self.setup.tools.iter().find(|tool| number.is_none_or(|number| tool.number == number))?;
        let Self { part, moves, opening, .. } = self;
        Some(FlankChannel { part_name: &part.name, tool, moves, opening: opening.as_ref() })
    }

    /// Its program, for all channels that it is repeated for; `None` where its setup lacks the tool.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn program(&self, monitor: &Monitor) -> Result<Option<ClProgram>, Cancelled> {
        let Self { part, setup, .. } = self;
        let channels = self.channels.clamp(1, part.blade_count);
        let Some(one) = self.in_one_channel() else { return Ok(None) };
        if channels == 1 {
            return Ok(Some(one.program()));
        }
        let blank = setup.allowances.blank_of(part);
        Ok(Some(one.in_channels(part, &blank, setup, channels, monitor)?.program))
    }
}

/// The passes of a plan as they are displayed.
pub fn shown_passes(plan: &FlankPlan) -> Vec<ShownPass> {
    let layers = plan.layout.layers.iter().enumerate();
    layers
        .flat_map(|(number, layer)| {
            layer.pass_curves.iter().map(move |curve| ShownPass {
                layer: number,
                region: curve.region,
                wall: matches!(curve.role, PassRole::Wall(_)),
                points: curve.points.iter().map(|p| layer.layer.point(*p)).collect(),
            })
        })
        .collect()
}

/// The milled walls of a plan as they are displayed: by what its program leaves, or, where that could not be
/// verified, by what cutters at all positions along the walls would leave.
pub fn shown_walls(plan: &FlankPlan, verdict: Option<&FlankVerdict>) -> Vec<ShownWall> {
    let Some(verdict) = verdict else {
        let shown = |w: &MilledWall| ShownWall { wall: w.wall, region: w.region, map: w.axes.map.clone() };
        return plan.walls.iter().map(shown).collect();
    };
    let splitters = (verdict.walls.len() / 2).saturating_sub(1);
    let beside = |number: usize| {
        let low = number.checked_sub(1).map_or(WallName::Low, WallName::Splitter);
        let high = if number + 1 < splitters { WallName::Splitter(number + 1) } else { WallName::High };
        let wall = WallName::Splitter(number);
        [(wall, Region { low, high: wall }), (wall, Region { low: wall, high })]
    };
    let sides = [(WallName::Low, Region::INLET), (WallName::High, Region::INLET)];
    let named = sides.into_iter().chain((0..splitters).flat_map(beside));
    let shown = named.zip(&verdict.walls);
    shown.map(|((wall, region), map)| ShownWall { wall, region, map: map.clone() }).collect()
}

/// A point as the numbers of a file, mm.
fn point_numbers(point: &Point) -> [f64; 3] {
    rounded(point.coords.into(), STEPS_PER_MM)
}

/// A unit axis as the numbers of a file.
fn axis_numbers(axis: &Vector) -> [f64; 3] {
    rounded((*axis).into(), AXIS_STEPS)
}

/// A point as it is read again.
fn stored_point(point: &Point) -> Point {
    stored::point(point_numbers(point))
}

/// A unit axis as it is read again.
fn stored_axis(axis: &Vector) -> Vector {
    stored::unit_axis(axis_numbers(axis)).unwrap_or(*axis)
}

/// A move as a file of it holds it.
fn stored_move(m: &FlankMove) -> FlankMove {
    FlankMove {
        tip: stored_point(&m.tip),
        axis: stored_axis(&m.axis),
        feed_mm_per_min: (m.feed_mm_per_min * FEED_STEPS).round() / FEED_STEPS,
        ..*m
    }
}

/// The same of the plunges above the shroud.
fn stored_opening(opening: &FlankOpening) -> FlankOpening {
    let plunge = |(retract, tip, axis): &(Point, Point, Vector)| {
        (stored_point(retract), stored_point(tip), stored_axis(axis))
    };
    let position = |(tip, axis): &(Point, Vector)| (stored_point(tip), stored_axis(axis));
    FlankOpening {
        tool: opening.tool.clone(),
        plunges: opening.plunges.iter().map(plunge).collect(),
        link: opening.link.iter().map(position).collect(),
    }
}

/// The program of a plan as [`StoredFlank::program`] reads it from a file for that number of `channels`: NC
/// code that is posted from either is the same.
///
/// # Errors
/// When `monitor` is cancelled.
pub fn stored_program(
    workpiece: &Workpiece,
    setup: &Setup,
    plan: &FlankPlan,
    channels: usize,
    monitor: &Monitor,
) -> Result<ClProgram, Cancelled> {
    let Workpiece { part, blank, .. } = workpiece;
    let moves: Vec<FlankMove> = plan.moves.iter().map(stored_move).collect();
    let opening = plan.opening.as_ref().map(stored_opening);
    let (tool, moves, opening) = (&plan.tool, &*moves, opening.as_ref());
    let one = FlankChannel { part_name: &part.name, tool, moves, opening };
    match channels {
        1 => Ok(one.program()),
        _ => Ok(one.in_channels(part, blank, setup, channels, monitor)?.program),
    }
}

fn rounded(coordinates: [f64; 3], decimals: f64) -> [f64; 3] {
    coordinates.map(|x| (x * decimals).round() / decimals)
}

/// Writes a flank plan file (JSON); lengths in mm, feed rates in mm/min, part frame. `walls` are those of
/// [`shown_walls`], `channels` is the number of channels that the plan is repeated for.
pub fn write_flank(
    description: &PartDescription,
    setup: &Setup,
    plan: &FlankPlan,
    walls: &[ShownWall],
    channels: usize,
) -> String {
    let curves = shown_passes(plan);
    let layers = plan.layout.layers.iter().enumerate().map(|(number, layer)| LayerFile {
        height: layer.layer.height,
        interval: layer.stepover,
        curves: curves
            .iter()
            .filter(|curve| curve.layer == number)
            .map(|curve| CurveFile {
                wall: curve.wall,
                region: curve.region,
                points: curve.points.iter().map(|p| rounded(p.coords.into(), STEPS_PER_MM)).collect(),
            })
            .collect(),
    });
    let file = FlankFile {
        vanecut_flank: if channels > 1 { VERSION } else { ONE_CHANNEL_VERSION },
        part: write_native(description),
        setup: write_full_setup(setup),
        scheme: plan.layout.strategy,
        channels,
        feed: plan.feeds.step_mm_per_min,
        layers: layers.collect(),
        walls: walls
            .iter()
            .map(|ShownWall { wall, region, map }| {
                let round = |x: &f64| (x * STEPS_PER_MM).round() / STEPS_PER_MM;
                let is_milled = |d: &f64| d.is_finite();
                WallFile {
                    wall: *wall,
                    region: *region,
                    u: map.u.iter().map(round).collect(),
                    v: map.v.iter().map(round).collect(),
                    deviation: map
                        .deviation
                        .iter()
                        .map(|d| if is_milled(d) { round(d) } else { 0.0 })
                        .collect(),
                    unmilled: (0..map.deviation.len()).filter(|&k| !is_milled(&map.deviation[k])).collect(),
                }
            })
            .collect(),
        moves: plan
            .moves
            .iter()
            .map(|m| {
                let (tip, axis) = (point_numbers(&m.tip), axis_numbers(&m.axis));
                (m.kind, m.layer, m.region, m.along_wall, tip, axis)
            })
            .collect(),
        feeds: plan.moves.iter().map(|m| (m.feed_mm_per_min * FEED_STEPS).round() / FEED_STEPS).collect(),
        opening: plan.opening.as_ref().map(|opening| {
            let plunge = |(retract, tip, axis): &(Point, Point, Vector)| {
                [point_numbers(retract), point_numbers(tip), axis_numbers(axis)]
            };
            let position = |(tip, axis): &(Point, Vector)| [point_numbers(tip), axis_numbers(axis)];
            OpeningFile {
                tool: opening.tool.number,
                plunges: opening.plunges.iter().map(plunge).collect(),
                link: opening.link.iter().map(position).collect(),
            }
        }),
    };
    let mut text = serde_json::to_string(&file).unwrap_or_default();
    text.push('\n');
    text
}

/// Whether the bytes look like a flank plan file rather than a plunge plan file.
pub fn is_flank(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(64)];
    head.windows(15).any(|w| w == b"\"vanecut_flank\"")
}

/// The plunges above the shroud of a file.
fn read_opening(name: &str, file: &OpeningFile, setup: &Setup) -> Result<FlankOpening, InputError> {
    let tool = tool_of(setup, file.tool).map_err(|e| damaged(name, e.message))?.clone();
    let plunge = |(number, &[retract, tip, axis]): (usize, &[[f64; 3]; 3])| {
        let axis = stored::unit_axis(axis).filter(|_| are_coordinates(retract.iter().chain(&tip)));
        let axis = axis.ok_or_else(|| damaged(name, format!("plunge {} is damaged", number + 1)))?;
        Ok((stored::point(retract), stored::point(tip), axis))
    };
    let plunges = file.plunges.iter().enumerate().map(plunge).collect::<Result<_, InputError>>()?;
    let position = |&[tip, axis]: &[[f64; 3]; 2]| {
        let axis = stored::unit_axis(axis).filter(|_| are_coordinates(&tip));
        let axis =
            axis.ok_or_else(|| damaged(name, "the rapid from the plunges to the passes is damaged"))?;
        Ok((stored::point(tip), axis))
    };
    let link = file.link.iter().map(position).collect::<Result<_, InputError>>()?;
    Ok(FlankOpening { tool, plunges, link })
}

/// Reads a flank plan file; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not a flank plan file of a supported version, or hold unusable values.
pub fn read_flank_bytes(name: &str, bytes: &[u8]) -> Result<StoredFlank, InputError> {
    let help = "give a flank.json that `vanecut flank` wrote";
    let source = Source::new(name, ErrorCode::PlanFile);
    let file: FlankFile =
        serde_json::from_slice(bytes).map_err(|e| source.not_json(&e, "a flank plan file", help))?;
    stored::check_version(name, "flank plan file", file.vanecut_flank, VERSION)?;
    let StoredInputs { description, part, setup } = stored::read_inputs(name, &file.part, &file.setup, None)?;
    let layers = file.layers.len();
    let mut curves = Vec::new();
    for (layer, found) in file.layers.into_iter().enumerate() {
        for curve in found.curves {
            if !are_coordinates(curve.points.iter().flatten()) {
                return Err(damaged(name, format!("a curve of layer {} is damaged", layer + 1)));
            }
            let points = curve.points.into_iter().map(stored::point).collect();
            curves.push(ShownPass { layer, region: curve.region, wall: curve.wall, points });
        }
    }
    let opening = file.opening.map(|opening| read_opening(name, &opening, &setup)).transpose()?;
    let mut moves = Vec::with_capacity(file.moves.len());
    for (number, (kind, layer, region, wall, tip, axis)) in file.moves.into_iter().enumerate() {
        let axis = stored::unit_axis(axis).filter(|_| are_coordinates(&tip) && layer < layers.max(1));
        let feed = file.feeds.get(number).copied().unwrap_or(match kind {
            MoveKind::Rapid => RAPID_MM_PER_MIN,
            _ => file.feed,
        });
        let Some(axis) = axis.filter(|_| feed > 0.0 && feed.is_finite()) else {
            return Err(damaged(name, format!("move {} is damaged", number + 1)));
        };
        moves.push(FlankMove {
            kind,
            tip: stored::point(tip),
            axis,
            feed_mm_per_min: feed,
            layer,
            region,
            along_wall: wall,
        });
    }
    let mut walls = Vec::new();
    for mut wall in file.walls {
        let numbers = wall.u.iter().chain(&wall.v).chain(&wall.deviation);
        if wall.deviation.len() != wall.u.len() * wall.v.len() || !are_coordinates(numbers) {
            return Err(damaged(name, "the deviation of a wall is damaged"));
        }
        for k in wall.unmilled {
            let place = wall.deviation.get_mut(k);
            *place.ok_or_else(|| damaged(name, "the deviation of a wall is damaged"))? = f64::NAN;
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
        feed_mm_per_min: file.feed,
        layers,
        passes: curves,
        opening,
        moves,
        channels: file.channels,
    })
}
