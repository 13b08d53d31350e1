//! Depth, width and largest cutter along a passage [assessment paper, sections I.C and I.D].

use rayon::prelude::*;

use super::cutter::{LargestCutter, WallPair};
use crate::part::{
    BladeSide, BoundedPassage, Channel, Impeller, PassageWidth, SideProbe, Wall, splitter_name,
};

/// Number of steps between stations for widths and depths.
const WIDTH_STEPS: usize = 100;
/// Number of steps between stations for cutters.
const CUTTER_STEPS: usize = 20;

/// Which passage of a channel: the blades on its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassageBlades {
    /// Numbers of the splitters on its two sides, counted from 0 at the suction side of the main blade;
    /// `None` is a main blade.
    pub splitters: [Option<usize>; 2],
    /// Number of splitters in a pitch.
    pub count: usize,
}

impl PassageBlades {
    /// Name in texts.
    pub fn label(self) -> String {
        match (self.splitters, self.count) {
            ([None, None], _) => "main to main blade".to_owned(),
            ([None, _], 1) => "beside the splitter, at the suction side".to_owned(),
            (_, 1) => "beside the splitter, at the pressure side".to_owned(),
            _ => self.names("main blade").join(" to "),
        }
    }

    /// Key in JSON.
    pub fn key(self) -> String {
        match (self.splitters, self.count) {
            ([None, None], _) => "full".to_owned(),
            ([None, _], 1) => "beside_splitter_suction".to_owned(),
            (_, 1) => "beside_splitter_pressure".to_owned(),
            _ => self.names("main").join("_to_").replace(' ', "_"),
        }
    }

    /// Names of both blades; `main` is that of a main blade.
    fn names(self, main: &str) -> [String; 2] {
        self.splitters
            .map(|number| number.map_or(main.to_owned(), |number| splitter_name(number, self.count)))
    }
}

/// Width at one station, mm: distance from the wall at λ = 0 to the nearest point of the one it faces, on the
/// hub, at mid height and on the shroud. `None` ahead of the splitter, or where that wall does not extend to
/// s.
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
    pub blades: PassageBlades,
    /// Widths along s; also where a splitter divides it.
    pub widths: Vec<WidthStation>,
    /// Largest cutters along s, where only these two walls bound them: in a divided passage ahead of the
    /// splitter.
    pub cutters: Vec<LargestCutter>,
}

impl PassageMeasure {
    /// All measured widths, mm.
    pub fn all_widths(&self) -> impl Iterator<Item = f64> + '_ {
        self.widths.iter().flat_map(|station| station.width).flatten()
    }
}

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

/// Measures every passage of the channel.
pub fn measure(part: &Impeller, channel: &Channel) -> Vec<PassageMeasure> {
    let next = part.main.rotated(part.pitch());
    let measured = |bounded: &BoundedPassage| {
        let splitter = |number: Option<usize>| Some(&part.splitters[channel.splitters.get(number?)?.index]);
        let [low, high] = bounded.splitters.map(splitter);
        // Walls including noses: a suction side and a pressure side.
        let sides = [&low.unwrap_or(&part.main).suction, &high.unwrap_or(&next).pressure];
        measure_passage(part, channel, bounded, sides)
    };
    channel.bounded_passages().iter().map(measured).collect()
}

fn measure_passage(
    part: &Impeller,
    channel: &Channel,
    bounded: &BoundedPassage,
    sides: [&BladeSide; 2],
) -> PassageMeasure {
    let BoundedPassage { splitters, begins, ends, .. } = bounded;
    let passage = &channel.passages[bounded.index];
    let widths = PassageWidth::new(part, passage);
    let width_at = |s: f64| {
        let width = [0.0, 0.5, 1.0].map(|eta| {
            let begins = begins[0] + eta * (begins[1] - begins[0]);
            (s >= begins).then(|| widths.distance_from(0, s, eta)).flatten()
        });
        WidthStation { s, width }
    };
    let pair = WallPair::new(part, passage, sides[0], sides[1]);
    let cutter_at = |s: f64| {
        let within = s >= begins[0] && s < ends[0];
        within.then(|| pair.largest(s)).flatten()
    };
    PassageMeasure {
        blades: PassageBlades { splitters: *splitters, count: channel.splitters.len() },
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
