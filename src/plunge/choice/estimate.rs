//! Time estimate for a cutter on a stretch of the channel without planning it: rows and positions spaced as
//! by the planner, each plunge at its feed rate over the depth of the channel, retracts in rapid; on a
//! machine with accelerations, and turns between isoparametric axes.

use std::collections::HashMap;

use super::fit::{Rules, ToolFit};
use super::times::{MoveTimes, PlungeMoves};
use crate::plunge::spacing::{max_shroud_spacing, step_limit, stepover};
use crate::plunge::survey::{PassageExtent, Survey, SurveyStation};
use crate::setup::{PlungeSetup, Setup, Tool};

/// Cost of a choice, ordered lexicographically: broken rules first, then time.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Cost {
    /// Stations at which a cutter is wider than the passage.
    pub misfits: u32,
    /// Stations at which a cutter fits, but against the rules.
    pub wanting: u32,
    /// Missing overhang of tools that are too short, summed over the stations, mm.
    pub lacking: f64,
    /// Time, s.
    pub seconds: f64,
}

impl Cost {
    /// A cost that consists of time only.
    pub fn seconds(seconds: f64) -> Self {
        Self { seconds, ..Self::default() }
    }

    /// Sum of both costs.
    pub fn and(self, other: Self) -> Self {
        Self {
            misfits: self.misfits + other.misfits,
            wanting: self.wanting + other.wanting,
            lacking: self.lacking + other.lacking,
            seconds: self.seconds + other.seconds,
        }
    }
}

/// Estimates for one survey and one setup.
#[derive(Debug)]
pub struct Estimator<'a> {
    /// Measures of the channel.
    pub survey: &'a Survey,
    /// Steps and stepovers of the setup.
    plunge: &'a PlungeSetup,
    /// Rules for whether a cutter fits.
    pub rules: Rules,
    /// How long moves take.
    times: MoveTimes<'a>,
    /// By number of the tool: for each station, the time of a plunge with its retract and the link to the
    /// next in each passage, s.
    plunges: HashMap<u32, Vec<Vec<f64>>>,
}

/// Rows and positions of a stretch of one passage, accumulated station by station.
#[derive(Clone, Copy, Debug, Default)]
struct RowEstimate {
    /// Number of gaps between rows.
    gaps: f64,
    /// Maximum speed of the axes along s, mm per unit of s: positions are evenly spaced in s.
    advance: f64,
    /// Time of a plunge integrated over s, s.
    plunging: f64,
}

impl RowEstimate {
    /// Number of places of all rows per mm that the axes advance, for the steps of wall rows and inner rows,
    /// mm.
    fn places_per_mm(&self, [wall, inner]: [f64; 2]) -> f64 {
        let inner_rows = rows(self.gaps) - 2.0;
        2.0 / wall + inner_rows / inner
    }

    /// Time of all rows, s, for the steps of wall rows and inner rows, mm.
    fn seconds(&self, steps: [f64; 2]) -> f64 {
        self.advance * self.plunging * self.places_per_mm(steps)
    }

    /// Takes the passage at another station into account, where `gaps` gaps between rows are needed.
    fn add_extent(&mut self, across: &PassageExtent, gaps: f64) {
        self.gaps = self.gaps.max(gaps);
        self.advance = self.advance.max(across.advance);
    }
}

/// Number of rows for a fractional number of gaps. The planner rounds gaps up; here half a gap is added, the
/// average of that, so that the estimate is continuous in the width.
fn rows(gaps: f64) -> f64 {
    (gaps + 0.5).max(1.0) + 1.0
}

impl<'a> Estimator<'a> {
    /// The estimator of `setup` for `tools` in the channel of `survey`; `times` tells how long moves take.
    pub fn new(survey: &'a Survey, setup: &'a Setup, tools: &[&Tool], times: MoveTimes<'a>) -> Self {
        let rules = Rules::new(&setup.allowances);
        let mut estimator = Self { survey, plunge: &setup.plunge, rules, times, plunges: HashMap::new() };
        for tool in tools {
            let at = |station: &SurveyStation| {
                station.passages.iter().map(|across| estimator.plunge_seconds(tool, across)).collect()
            };
            let plunges = survey.stations.iter().map(at).collect();
            estimator.plunges.insert(tool.number, plunges);
        }
        estimator
    }

    /// One lane for each passage, without places.
    fn no_lanes(&self) -> Vec<RowEstimate> {
        let passages = self.survey.stations.iter().flat_map(|station| &station.passages);
        vec![RowEstimate::default(); passages.map(|across| across.passage + 1).max().unwrap_or(0)]
    }

    /// Number of places in the rows of `tool` from station `from` inwards to station `to`.
    pub fn places(&self, tool: &Tool, from: usize, to: usize) -> f64 {
        let stations = &self.survey.stations;
        let mut lanes = self.no_lanes();
        let mut lengths = vec![0.0; lanes.len()];
        for (inner, outer) in stations[to..=from].iter().zip(&stations[to + 1..=from]) {
            for across in &outer.passages {
                lengths[across.passage] += outer.s - inner.s;
            }
        }
        for across in stations[to..=from].iter().flat_map(|station| &station.passages) {
            lanes[across.passage].add_extent(across, self.gaps(tool, across));
        }
        let steps = self.steps(tool);
        let places = |(lane, length): (&RowEstimate, f64)| length * lane.advance * lane.places_per_mm(steps);
        lanes.iter().zip(lengths).map(places).sum()
    }

    /// Steps of wall rows and of inner rows of `tool`, mm.
    fn steps(&self, tool: &Tool) -> [f64; 2] {
        [true, false].map(|wall_row| step_limit(self.plunge, tool, wall_row))
    }

    /// Costs of cutting with `tool` from station `from` inwards to each of the stations below it, nearest
    /// first. Entry and tool change are not included, see [`Self::beginning`].
    pub fn inwards<'s>(&'s self, tool: &'s Tool, from: usize) -> impl Iterator<Item = Cost> + use<'s, 'a> {
        let plunges = &self.plunges[&tool.number];
        let stations = &self.survey.stations;
        let mut lanes = self.no_lanes();
        let steps = self.steps(tool);
        let mut broken = self.broken_rules(tool, from);
        (0..from).rev().map(move |to| {
            let (outer, inner) = (&stations[to + 1], &stations[to]);
            broken = broken.and(self.broken_rules(tool, to));
            for (across, seconds) in outer.passages.iter().zip(&plunges[to + 1]) {
                let lane = &mut lanes[across.passage];
                lane.plunging += (outer.s - inner.s) * seconds;
            }
            for across in outer.passages.iter().chain(&inner.passages) {
                lanes[across.passage].add_extent(across, self.gaps(tool, across));
            }
            broken.and(Cost::seconds(lanes.iter().map(|lane| lane.seconds(steps)).sum()))
        })
    }

    /// Cost of cutting with `tool` between two stations; see [`Self::inwards`].
    pub fn stretch(&self, tool: &Tool, from: usize, to: usize) -> Cost {
        self.inwards(tool, from).nth(from - to - 1).unwrap_or_default()
    }

    /// Cost of beginning with `tool` at station `from` after the tool `before`: the tool change, and the
    /// positions of every row outside its stretch until the core is free.
    pub fn beginning(&self, tool: &Tool, from: usize, before: Option<&Tool>) -> Cost {
        // The planner aligns the front rims of both cutters, and starts with the core outside the rim.
        let way_in = before.map_or(tool.core_radius().max(0.0), |t| (t.radius() - tool.radius()).max(0.0));
        let change =
            if before.is_some_and(|b| b.number == tool.number) { 0.0 } else { self.times.tool_change_s() };
        let positions = 1.0 + way_in / step_limit(self.plunge, tool, false);
        let passages = self.survey.stations[from].passages.iter().zip(&self.plunges[&tool.number][from]);
        let travel: f64 =
            passages.map(|(across, seconds)| rows(self.gaps(tool, across)) * positions * seconds).sum();
        Cost::seconds(change + travel)
    }

    /// Number of gaps between rows, spaced as by the planner, on the hub and at the shroud.
    fn gaps(&self, tool: &Tool, across: &PassageExtent) -> f64 {
        let free_across = |width: f64| self.rules.free_width(width) - tool.diameter;
        (free_across(across.hub) / stepover(self.plunge, tool))
            .max(free_across(across.shroud) / max_shroud_spacing(tool))
    }

    /// Time of one plunge with its retract and the link to the next, s.
    fn plunge_seconds(&self, tool: &Tool, across: &PassageExtent) -> f64 {
        let length = across.depth + self.rules.safety_distance;
        let link = step_limit(self.plunge, tool, false);
        let turn_rad = across.turn_rad * link / across.advance.max(f64::MIN_POSITIVE);
        self.times.plunge_s(tool, &PlungeMoves { length, link, turn_rad })
    }

    fn broken_rules(&self, tool: &Tool, station: usize) -> Cost {
        match self.rules.fit(tool, &self.survey.stations[station]) {
            ToolFit::Good => Cost::default(),
            ToolFit::Tight => Cost { wanting: 1, ..Cost::default() },
            ToolFit::Short => {
                let station = &self.survey.stations[station];
                let lacking = self.rules.overhang(station) - tool.overhang;
                // A tool that does not reach the hub even along the isoparametric axis counts like one that
                // is too wide.
                let misfits = u32::from(tool.overhang < station.deepest);
                Cost { misfits, wanting: 1 - misfits, lacking, ..Cost::default() }
            }
            ToolFit::Wide | ToolFit::Hindered => Cost { misfits: 1, ..Cost::default() },
        }
    }
}
