//! Survey of the channel along s: width and depth of its passages, and the length of their rows. Independent
//! of any tool.

use std::collections::HashSet;

use rayon::prelude::*;

use super::lane::Lane;
use super::spacing::row_distance;
use crate::cutting::assembly::AssemblySurroundings;
use crate::geometry::Point;
use crate::part::{Channel, Impeller, Passage, PassageWidth, Workpiece};
use crate::setup::{AllowanceSetup, Setup, Tool};

/// Number of equal steps of s at which the channel is measured.
const STEPS: usize = 50;
/// Half of a step of s.
const HALF_STEP: f64 = 0.5 / STEPS as f64;
/// Lean of an axis from the hub normal beyond which the rim is not raised further, rad.
const MAX_LEAN_RAD: f64 = std::f64::consts::FRAC_PI_3;
/// A joint this close to a station (in s) uses that station instead of a new one.
const SAME_STATION: f64 = 1e-6;
/// Width of a passage, as a share of the widest one beside it, up to which it is set aside if it is so narrow
/// all along. A cutter for it would take more than 1/share² times the plunges in the wide one.
const NARROW_SHARE: f64 = 0.2;

/// Measures of one passage at one station.
#[derive(Clone, Copy, Debug)]
pub struct PassageExtent {
    /// Index in [`Channel::passages`].
    pub passage: usize,
    /// Minimum width over the height, mm.
    pub narrowest: f64,
    /// Width for rows on the hub, mm: two rows are this times their difference in λ apart, perpendicular to
    /// the flow or to the axis, whichever is smaller.
    pub hub: f64,
    /// The same on the shroud, mm.
    pub shroud: f64,
    /// Length of the isoparametric axis between hub and shroud, in the middle of the passage, mm.
    pub depth: f64,
    /// Speed of a row's axis along s, measured perpendicular to the axis, mm per unit of s: the larger of hub
    /// and shroud.
    pub advance: f64,
    /// Turn of the isoparametric axis in the middle of the passage, rad per unit of s.
    pub turn_rad: f64,
}

/// The channel at one s.
#[derive(Clone, Debug)]
pub struct SurveyStation {
    /// s.
    pub s: f64,
    /// Minimum width of `passages` over their height, mm; infinite where the blades do not extend to this s.
    pub narrowest: f64,
    /// Longest isoparametric axis, walls included, mm.
    pub deepest: f64,
    /// Largest diameter of the tried cylinders that clears both walls of all `passages` with the conventional
    /// axis, mm; infinite before [`Survey::try_cylinders`], 0 if none clears.
    pub clear_diameter: f64,
    /// Numbers of the tools whose given shank or holder is in the way here; see [`Survey::try_assemblies`].
    pub hindered: Vec<u32>,
    /// The passages at this s by which sections are chosen.
    pub passages: Vec<PassageExtent>,
    /// The passages that are set aside: all along less than a fifth as wide as the widest one beside them, as
    /// where a splitter stands close to a blade, or nowhere within reach of any tool. They are cut where the
    /// chosen cutters fit.
    pub aside: Vec<PassageExtent>,
}

/// The channel along s.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Stations from leading edge to rim, s = 0 and s = 1 among them.
    pub stations: Vec<SurveyStation>,
    /// Indices of the stations at which the passages beside a splitter join and sections have to meet.
    pub joints: Vec<usize>,
}

impl Survey {
    /// Measures the channel of `workpiece`. Sections have to meet where a splitter begins, unless less than
    /// `shortest` (in s) would remain on one side of it.
    pub fn from_workpiece(workpiece: &Workpiece, shortest: f64) -> Self {
        let Workpiece { part, channel, .. } = workpiece;
        let mut s: Vec<f64> = (0..=STEPS).map(|i| i as f64 / STEPS as f64).collect();
        let mut joints = Vec::new();
        let mut before = 0.0;
        for joint in channel.noses().into_iter().map(|[hub, shroud]| hub.max(shroud)) {
            if !(before + shortest..=1.0 - shortest).contains(&joint) {
                continue;
            }
            let at = s.partition_point(|&s| s < joint - SAME_STATION);
            if s[at] > joint + SAME_STATION {
                s.insert(at, joint);
            }
            joints.push(at);
            before = joint;
        }
        let tape = Surveyor::new(part, channel);
        let mut survey = Self { stations: s.into_par_iter().map(|s| tape.station(s)).collect(), joints };
        survey.set_narrow_aside(channel.passages.len());
        survey
    }

    /// Sets the passages, of `count`, aside that are narrow all along; see [`SurveyStation::aside`].
    fn set_narrow_aside(&mut self, count: usize) {
        let mut shares = vec![0.0f64; count];
        for station in &self.stations {
            let widest = station.passages.iter().map(|across| across.narrowest).fold(0.0, f64::max);
            for across in &station.passages {
                let share = &mut shares[across.passage];
                *share = share.max(across.narrowest / widest);
            }
        }
        self.set_aside(|across| shares[across.passage] < NARROW_SHARE);
    }

    /// Sets the passages aside that are nowhere `within_reach` of a tool; see [`SurveyStation::aside`].
    /// Where that is all of them none is.
    pub fn set_inaccessible_aside(&mut self, within_reach: impl Fn(&PassageExtent) -> bool) {
        let passages = self.stations.iter().flat_map(|station| &station.passages);
        let accessible: HashSet<usize> =
            passages.filter(|across| within_reach(across)).map(|across| across.passage).collect();
        self.set_aside(|across| !accessible.contains(&across.passage));
    }

    /// Moves passages to [`SurveyStation::aside`], at each station at which another one remains.
    fn set_aside(&mut self, is_aside: impl Fn(&PassageExtent) -> bool) {
        for station in &mut self.stations {
            if station.passages.iter().all(&is_aside) {
                continue;
            }
            let passages = std::mem::take(&mut station.passages).into_iter();
            let (aside, others): (Vec<_>, Vec<_>) = passages.partition(&is_aside);
            station.passages = others;
            station.aside.extend(aside);
            station.narrowest =
                station.passages.iter().map(|across| across.narrowest).fold(f64::INFINITY, f64::min);
        }
    }

    /// Tries cylinders of `diameters` (mm, largest first) between the walls at every station, with the same
    /// fits as the planner: between twisted walls the width alone does not decide what fits.
    pub fn try_cylinders(&mut self, workpiece: &Workpiece, stock: &AllowanceSetup, diameters: &[f64]) {
        let free_width = |station: &SurveyStation| station.narrowest - 2.0 * stock.blade_allowance;
        let clears = |station: &SurveyStation, diameter: f64| {
            station.passages.iter().all(|across| {
                let passage = &workpiece.channel.passages[across.passage];
                let lane = Lane::new(workpiece, passage, &cylinder(diameter), stock);
                lane.wall_pair(station.s, station.s).is_some()
            })
        };
        self.stations.par_iter_mut().for_each(|station| {
            let mut tried = diameters.iter().copied().filter(|&diameter| diameter <= free_width(station));
            station.clear_diameter = tried.find(|&diameter| clears(station, diameter)).unwrap_or(0.0);
        });
    }

    /// Holds the given shanks and holders of `tools` against the part and the whole blank at every station,
    /// on the conventional axes of mid channel: a tool whose holder is in the way there is as good as too
    /// short.
    pub fn try_assemblies(&mut self, workpiece: &Workpiece, setup: &Setup, tools: &[Tool]) {
        let given: Vec<&Tool> = tools.iter().filter(|tool| !tool.assembly.is_empty()).collect();
        if given.is_empty() {
            return;
        }
        let around = AssemblySurroundings::new(&workpiece.finished, setup).with_blank(&workpiece.blank);
        let part = &workpiece.part;
        let is_clear = |station: &SurveyStation, tool: &Tool| {
            let segments = tool.assembly.segments(tool.overhang);
            station.passages.iter().all(|across| {
                let at = |eta: f64| {
                    let passage = &workpiece.channel.passages[across.passage];
                    passage.point(part, station.s, 0.5, eta).map(|p| p.point)
                };
                let Some((foot, top)) = at(0.0).zip(at(1.0)) else { return true };
                let Some(axis) = (top - foot).try_normalize(1e-9) else { return true };
                // A flat bottom stands on its rim where the axis leans.
                let normal = part.hub.at(station.s).normal.direction_at_angle(foot.y.atan2(foot.x));
                let lean = axis.angle(&normal).min(MAX_LEAN_RAD).tan();
                let raise = setup.allowances.hub_allowance + (tool.radius() - tool.corner_radius) * lean;
                let found = around.at(tool, &segments, (foot + axis * raise, axis), 0.0);
                !found.shank.collides() && !found.holder.collides()
            })
        };
        self.stations.par_iter_mut().for_each(|station| {
            let hindered = given.iter().filter(|tool| !is_clear(station, tool)).map(|tool| tool.number);
            station.hindered = hindered.collect();
        });
    }

    /// Indices of the stations covered by a stretch of s, including the station nearest to each end.
    pub fn covered(&self, from: f64, to: f64) -> std::ops::RangeInclusive<usize> {
        let nearest = |s: f64| {
            let distance = |i: &usize| (self.stations[*i].s - s).abs();
            (0..self.stations.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        };
        let (from, to) = (from + 1e-9, to - 1e-9);
        let first = self.stations.partition_point(|station| station.s < to).min(nearest(to));
        let last = self.stations.partition_point(|station| station.s <= from).saturating_sub(1);
        first..=last.max(nearest(from))
    }

    /// Maximum over a stretch of s of the minimum width between the walls, mm; 0 where there are no walls.
    pub fn max_width(&self, from: f64, to: f64) -> f64 {
        let widths = self.stations[self.covered(from, to)].iter().map(|station| station.narrowest);
        widths.filter(|width| width.is_finite()).fold(0.0, f64::max)
    }
}

/// An endless cylinder of this diameter (mm) as a tool.
pub(super) fn cylinder(diameter: f64) -> Tool {
    Tool {
        number: 0,
        diameter,
        corner_radius: 0.0,
        insert_width: 0.5 * diameter,
        overhang: f64::INFINITY,
        plunge_feed: 1.0,
        spindle: 1.0,
        assembly: Default::default(),
    }
}

/// Measures the stations of a channel.
struct Surveyor<'a> {
    part: &'a Impeller,
    channel: &'a Channel,
    /// Those of [`Channel::passages`].
    widths: Vec<PassageWidth<'a>>,
}

impl<'a> Surveyor<'a> {
    fn new(part: &'a Impeller, channel: &'a Channel) -> Self {
        let widths = channel.passages.iter().map(|p| PassageWidth::new(part, p)).collect();
        Self { part, channel, widths }
    }

    fn station(&self, s: f64) -> SurveyStation {
        let mut station = SurveyStation {
            s,
            narrowest: f64::INFINITY,
            deepest: self.depth(s),
            clear_diameter: f64::INFINITY,
            hindered: Vec::new(),
            passages: Vec::new(),
            aside: Vec::new(),
        };
        for index in self.channel.passages_at(s) {
            let (passage, width) = (&self.channel.passages[index], &self.widths[index]);
            let narrowest = width.min_width(s);
            let axis = |s: f64, lambda: f64| self.axis(passage, s, lambda);
            let depth = axis(s, 0.5).map_or_else(|| self.depth(s), |[foot, top]| (top - foot).norm());
            for lambda in [0.0, 0.5, 1.0] {
                let deep = axis(s, lambda).map_or(0.0, |[foot, top]| (top - foot).norm());
                station.deepest = station.deepest.max(deep);
            }
            if narrowest.is_finite() {
                station.passages.push(PassageExtent {
                    passage: index,
                    narrowest,
                    hub: self.width(passage, s, 0.0).unwrap_or(narrowest),
                    shroud: self.width(passage, s, 1.0).unwrap_or(narrowest),
                    depth,
                    advance: self.advance(passage, s),
                    turn_rad: self.turn_rad(passage, s),
                });
            }
        }
        station
    }

    /// Distance between hub and shroud in the meridional plane, mm.
    fn depth(&self, s: f64) -> f64 {
        self.part.hub.point(s).distance(self.part.shroud.point(s))
    }

    /// Ends of the isoparametric axis, on the hub and on the shroud.
    fn axis(&self, passage: &Passage, s: f64, lambda: f64) -> Option<[Point; 2]> {
        let at = |eta: f64| passage.point(self.part, s, lambda, eta).map(|p| p.point);
        Some([at(0.0)?, at(1.0)?])
    }

    /// See [`PassageExtent::hub`]: what [`Lane::width`] measures, without a cutter. The nearest distance is
    /// not used here: near the ends of the blades the other wall ends, while rows continue.
    fn width(&self, passage: &Passage, s: f64, eta: f64) -> Option<f64> {
        let of_row = |lambda: f64| {
            let place = passage.point(self.part, s, lambda, eta)?;
            let [foot, top] = self.axis(passage, s, lambda)?;
            row_distance(place.by_lambda, place.by_s, top - foot)
        };
        [0.0, 0.5, 1.0].into_iter().filter_map(of_row).reduce(f64::max)
    }

    /// See [`PassageExtent::turn_rad`]; 0 without walls.
    fn turn_rad(&self, passage: &Passage, s: f64) -> f64 {
        let (from, to) = ((s - HALF_STEP).max(0.0), (s + HALF_STEP).min(1.0));
        let axis = |s: f64| self.axis(passage, s, 0.5).map(|[foot, top]| top - foot);
        axis(from).zip(axis(to)).map_or(0.0, |(a, b)| a.angle(&b) / (to - from))
    }

    /// See [`PassageExtent::advance`]; without walls, the longer of hub and shroud.
    fn advance(&self, passage: &Passage, s: f64) -> f64 {
        let followed = || {
            let [foot, top] = self.axis(passage, s, 0.5)?;
            let along = (top - foot).try_normalize(1e-9)?;
            let slopes = [0.0, 1.0].map(|eta| passage.point(self.part, s, 0.5, eta).map(|p| p.by_s));
            let across = slopes.into_iter().flatten().map(|slope| (slope - along * slope.dot(&along)).norm());
            across.reduce(f64::max)
        };
        followed().unwrap_or_else(|| self.part.hub.length().max(self.part.shroud.length()))
    }
}
