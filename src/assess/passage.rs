//! Depth, width and largest cutter along a passage [assessment paper, sections I.C and I.D].

use rayon::prelude::*;

use super::cutter::{LargestCutter, WallPair};
use crate::part::{BladeSide, Channel, Impeller, Passage, PassageWidth, SideProbe, Wall};

/// A passage of the channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassageKind {
    /// Between two main blades.
    Full,
    /// Between the suction side of a main blade and the splitter.
    BesideSuction,
    /// Between the splitter and the pressure side of the next main blade.
    BesidePressure,
}

/// Width at one station, mm: minimum distance between the walls on the hub, at mid height and on the shroud.
/// `None` ahead of the splitter, or where a wall does not extend to s.
#[derive(Clone, Copy, Debug)]
pub struct WidthStation {
    /// s.
    pub s: f64,
    /// At η = 0, ½ and 1.
    pub width: [Option<f64>; 3],
}

/// Measures along one passage.
#[derive(Clone, Debug)]
pub struct PassageMeasure {
    /// Which passage.
    pub kind: PassageKind,
    /// Widths along s; for the full channel also where a splitter divides it.
    pub widths: Vec<WidthStation>,
    /// Largest cutters along s, where only these two walls bound them: in a divided channel ahead of the
    /// splitter.
    pub cutters: Vec<LargestCutter>,
}

impl PassageMeasure {
    /// All measured widths, mm.
    pub fn all_widths(&self) -> impl Iterator<Item = f64> + '_ {
        self.widths.iter().flat_map(|station| station.width).flatten()
    }
}

/// Number of steps between stations for widths and depths.
const WIDTH_STEPS: usize = 100;
/// Number of steps between stations for cutters.
const CUTTER_STEPS: usize = 20;

fn stations(steps: usize) -> impl IndexedParallelIterator<Item = f64> {
    (0..steps + 1).into_par_iter().map(move |i| i as f64 / steps as f64)
}

/// Depth along s, as (s, mm): the height of the higher wall of the channel between corresponding points on
/// hub and shroud.
pub fn depths(part: &Impeller, channel: &Channel) -> Vec<(f64, f64)> {
    stations(WIDTH_STEPS)
        .filter_map(|s| {
            let height = |wall: &Wall| {
                let u = wall.at(part, s, 0.0)?.u;
                Some((wall.side().point(u, 1.0) - wall.side().point(u, 0.0)).norm())
            };
            let [low, high] = [height(&channel.full.walls[0]), height(&channel.full.walls[1])];
            low.into_iter().chain(high).reduce(f64::max).map(|depth| (s, depth))
        })
        .collect()
}

/// A passage with its bounds.
struct BoundedPassage<'a> {
    place: PassageKind,
    passage: &'a Passage,
    /// Its walls including noses: a suction side and a pressure side.
    sides: [&'a BladeSide; 2],
    /// s at which it begins, on the hub and on the shroud.
    start: [f64; 2],
    /// s on the hub at which another blade divides it.
    end: f64,
}

/// Measures every passage of the channel.
pub fn measure(part: &Impeller, channel: &Channel) -> Vec<PassageMeasure> {
    let next = part.main.rotated(part.pitch());
    let full = BoundedPassage {
        place: PassageKind::Full,
        passage: &channel.full,
        sides: [&part.main.suction, &next.pressure],
        start: [0.0; 2],
        end: channel.splitter_s.map_or(f64::INFINITY, |[hub, _]| hub),
    };
    let mut measures = vec![measure_passage(part, &full)];
    if let ([near, far], Some(blade), Some(start)) =
        (&channel.beside_splitter[..], part.splitters.first(), channel.splitter_s)
    {
        let beside =
            |place, passage, sides| BoundedPassage { place, passage, sides, start, end: f64::INFINITY };
        let suction = beside(PassageKind::BesideSuction, near, [&part.main.suction, &blade.pressure]);
        let pressure = beside(PassageKind::BesidePressure, far, [&blade.suction, &next.pressure]);
        measures.extend([suction, pressure].iter().map(|bounded| measure_passage(part, bounded)));
    }
    measures
}

fn measure_passage(part: &Impeller, bounded: &BoundedPassage<'_>) -> PassageMeasure {
    let BoundedPassage { passage, start, .. } = bounded;
    let widths = PassageWidth::new(part, passage);
    let width_at = |s: f64| {
        let width = [0.0, 0.5, 1.0].map(|eta| {
            let begins = start[0] + eta * (start[1] - start[0]);
            (s >= begins).then(|| widths.at(s, eta)).flatten()
        });
        WidthStation { s, width }
    };
    let pair = WallPair::new(part, passage, bounded.sides[0], bounded.sides[1]);
    let cutter_at = |s: f64| {
        let within = s >= start[0] && s < bounded.end;
        within.then(|| pair.largest(s)).flatten()
    };
    PassageMeasure {
        kind: bounded.place,
        widths: stations(WIDTH_STEPS).map(width_at).collect(),
        cutters: stations(CUTTER_STEPS).filter_map(cutter_at).collect(),
    }
}

/// Distances from the points of `wall` at each `u` and `v` (row by row of u) to the nearest point of the wall
/// it faces, mm.
pub fn wall_widths(wall: &BladeSide, facing: &BladeSide, u: &[f64], v: &[f64]) -> Vec<f64> {
    let facing = SideProbe::new(facing, 0.0, 1.0);
    let row = |&u: &f64| v.iter().map(|&v| facing.nearest_to_point(&wall.point(u, v)).distance).collect();
    let rows: Vec<Vec<f64>> = u.par_iter().map(row).collect();
    rows.concat()
}
