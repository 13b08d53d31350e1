//! The greedy search for runs: keeps the axes that suit all stations so far, and ends the run where none is
//! left.

use rayon::prelude::*;

use super::directions::{GRID, directions, ring};
use super::scene::Cone;
use super::{
    AxisObstacle, FixedAxes, FixedAxisSearch, FixedRun, LayerContact, PreparedContact, SEED_SPARE,
    SpareClearance, Unreachable,
};
use crate::cutting::drop_cutter::DepthSurface;
use crate::geometry::Vector;

/// An axis with its minimum spare clearance over the stations of a run, mm.
#[derive(Clone, Copy, Debug)]
struct AxisCandidate {
    axis: Vector,
    spare: f64,
}

/// Step angles of the search for directions between those of the grid, rad.
const STEPS: [f64; 3] = [0.5 * GRID, 0.25 * GRID, 0.125 * GRID];
/// Maximum number of seeds.
const SEEDS: usize = 4;
/// Number of contacts that the search from a seed starts with.
const DECIDING: usize = 6;
/// Maximum number of contacts that are added to them.
const MAX_ADDED_CONTACTS: usize = 12;
/// Angle beyond the axes of a run up to which axes between those of the grid are searched, rad.
const BEYOND: f64 = 1.5 * GRID;
/// Missing clearance up to which an axis is checked against the true surfaces, mm: the fast distances may be
/// too careful.
const MAX_CHECKED_DEFICIT: f64 = 0.3;
/// Maximum number of axes of a run that are checked against the true surfaces before the run is shortened.
const MAX_CHECKED_AXES: usize = 6;
/// Spare clearance counts up to this many tool radii; beyond it the axis nearer to the normal is better.
const ENOUGH_RADII: f64 = 1.0;

/// Limits of a spare clearance, mm, that leave it as it is.
const EXACT: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl FixedAxisSearch<'_> {
    /// The runs of `stations`, sets of contacts of the tool on a layer in order along a region. `layer` is
    /// the surface of the layer offset by the corner radius: tools with a flat bottom are lifted until they
    /// do not cut into it.
    pub fn runs(&self, stations: &[Vec<LayerContact>], layer: &DepthSurface) -> FixedAxes {
        Greedy::new(self, layer, stations.to_vec()).run()
    }

    /// The obstacle of every axis at `contact`; `None` where an axis is free. See [`Self::runs`] for `layer`.
    pub fn blocked(&self, contact: &LayerContact, layer: &DepthSurface) -> Option<AxisObstacle> {
        Greedy::new(self, layer, Vec::new()).blocked(&self.prepare_contact(contact, None))
    }
}

struct Greedy<'s, 'a> {
    search: &'s FixedAxisSearch<'a>,
    layer: &'s DepthSurface<'s>,
    stations: Vec<Vec<LayerContact>>,
    /// Per station, whether the search uses all its contacts. At first it uses the two furthest apart:
    /// between two walls others seldom decide. The final check uses all.
    in_full: Vec<bool>,
    /// The contacts of the stations of the current run, prepared for the axes it may have.
    places: Vec<Vec<PreparedContact>>,
    grid: Vec<Vector>,
    /// The axes of a station alone at which the last run ended: those that the next one starts with.
    next: Option<(usize, Vec<AxisCandidate>)>,
    found: FixedAxes,
}

/// A contact by itself.
struct ContactAlone {
    /// Spare clearances of the axes of the grid, mm; below −[`SEED_SPARE`] only upper bounds.
    spares: Vec<f64>,
    /// The obstacle of all axes; `None` where one is free.
    blocked: Option<AxisObstacle>,
}

impl<'s, 'a> Greedy<'s, 'a> {
    pub(super) fn new(
        search: &'s FixedAxisSearch<'a>,
        layer: &'s DepthSurface<'s>,
        stations: Vec<Vec<LayerContact>>,
    ) -> Self {
        let places = stations.iter().map(|_| Vec::new()).collect();
        let in_full = vec![false; stations.len()];
        let (grid, found) = (directions(), FixedAxes::default());
        Self { search, layer, stations, in_full, places, grid, next: None, found }
    }

    pub(super) fn run(mut self) -> FixedAxes {
        let mut from = 0;
        while from < self.stations.len() {
            let known = self.next.take().filter(|(station, _)| *station == from).map(|(_, axes)| axes);
            let Some(start) = known.or_else(|| self.starting_at(from)) else {
                from += 1;
                continue;
            };
            let (to, axes) = self.extend_run(from, start);
            if let Some(last) = self.close_run(from, to, axes) {
                from = last + 1;
            }
        }
        self.found
    }

    /// Prepares a station for axes of `cone`, or for all axes.
    fn prepare_station(&mut self, station: usize, cone: Option<Cone>) {
        let contacts = &self.stations[station];
        let deciding: Vec<&LayerContact> =
            if self.in_full[station] { contacts.iter().collect() } else { furthest_apart(contacts) };
        let place = |contact: &&LayerContact| self.search.prepare_contact(contact, cone);
        self.places[station] = deciding.par_iter().map(place).collect();
    }

    /// Axes for the station alone. Contacts without any axis are removed from it and listed as unreachable.
    /// `None` when no contact is left or those left have no axis in common.
    fn starting_at(&mut self, station: usize) -> Option<Vec<AxisCandidate>> {
        if self.stations[station].is_empty() {
            return None;
        }
        self.prepare_station(station, None);
        if let Some(axes) = self.for_station(station) {
            return Some(axes);
        }
        self.in_full[station] = true;
        self.prepare_station(station, None);
        let alone: Vec<ContactAlone> =
            self.places[station].par_iter().map(|place| self.alone(place)).collect();
        for why in [
            AxisObstacle::Blade,
            AxisObstacle::Hub,
            AxisObstacle::Shank,
            AxisObstacle::ShankInStock,
            AxisObstacle::Holder,
            AxisObstacle::Stock,
            AxisObstacle::Tilt,
        ] {
            let contacts: Vec<usize> = (0..alone.len()).filter(|&k| alone[k].blocked == Some(why)).collect();
            if !contacts.is_empty() {
                self.found.unreachable.push(Unreachable { station, contacts, why });
            }
        }
        let mut all = alone.iter();
        self.stations[station].retain(|_| all.next().is_some_and(|here| here.blocked.is_none()));
        if self.stations[station].is_empty() {
            self.places[station].clear();
            return None;
        }
        self.prepare_station(station, None);
        let free: Vec<&ContactAlone> = alone.iter().filter(|here| here.blocked.is_none()).collect();
        let axes = if free.len() < alone.len() {
            self.suited(self.common_candidates(&free), &self.places[station].iter().collect::<Vec<_>>())
        } else {
            None
        };
        if axes.is_none() {
            let contacts = (0..alone.len()).filter(|&k| alone[k].blocked.is_none()).collect();
            self.drop_station(station, contacts);
        }
        axes
    }

    /// Lists contacts of a station as without a common axis, and drops the station.
    fn drop_station(&mut self, station: usize, contacts: Vec<usize>) {
        self.found.unreachable.push(Unreachable { station, contacts, why: AxisObstacle::NoCommonAxis });
        self.stations[station].clear();
        self.places[station].clear();
    }

    /// Axes for all contacts of a station: those of the grid and, if none suits, others between them.
    fn for_station(&self, station: usize) -> Option<Vec<AxisCandidate>> {
        let places: Vec<&PreparedContact> = self.places[station].iter().collect();
        self.suited(self.grid_candidates(&places), &places)
    }

    /// Of the `axes` of the grid those that suit all `places` and, if none does, others between them.
    fn suited(&self, axes: Vec<AxisCandidate>, places: &[&PreparedContact]) -> Option<Vec<AxisCandidate>> {
        if axes.iter().any(|c| c.spare >= 0.0) { Some(axes) } else { self.refine_between(&axes, places) }
    }

    /// Axes of the grid for some contacts, including those that lack a little.
    fn grid_candidates(&self, places: &[&PreparedContact]) -> Vec<AxisCandidate> {
        let limits = (-SEED_SPARE, f64::INFINITY);
        let spare = |&axis: &Vector| AxisCandidate { axis, spare: self.min_spare(places, &axis, limits) };
        self.grid.par_iter().map(spare).filter(|c| c.spare > -SEED_SPARE).collect()
    }

    /// The same for contacts of which each is known by itself.
    fn common_candidates(&self, contacts: &[&ContactAlone]) -> Vec<AxisCandidate> {
        let least = |k: usize| contacts.iter().map(|alone| alone.spares[k]).fold(f64::INFINITY, f64::min);
        let all = self.grid.iter().enumerate().map(|(k, &axis)| AxisCandidate { axis, spare: least(k) });
        all.filter(|c| c.spare > -SEED_SPARE).collect()
    }

    /// The obstacle at a contact that has no axis.
    pub(super) fn blocked(&self, place: &PreparedContact) -> Option<AxisObstacle> {
        // Most contacts have an axis: the first one of the grid that is free ends the search.
        let is_free = |axis: &Vector| self.search.spare(place, axis, (0.0, 0.0)).amount >= 0.0;
        if self.grid.iter().any(is_free) { None } else { self.alone(place).blocked }
    }

    fn alone(&self, place: &PreparedContact) -> ContactAlone {
        let limits = (-SEED_SPARE, f64::INFINITY);
        let spare = |axis: &Vector| self.search.spare(place, axis, limits).amount;
        let mut alone = ContactAlone { spares: self.grid.par_iter().map(spare).collect(), blocked: None };
        let axes = self.common_candidates(&[&alone]);
        if axes.iter().any(|c| c.spare >= 0.0) || self.refine_between(&axes, &[place]).is_some() {
            return alone;
        }
        // The axis that comes nearest to being free: one of these, if there is any. An axis is evaluated only
        // until it falls behind the best one so far.
        let mut nearest = SpareClearance { amount: f64::NEG_INFINITY, by: AxisObstacle::Tilt };
        let mut nearest_axis = place.contact.normal;
        let mut look = |axis: &Vector| {
            let spare = self.search.spare(place, axis, (nearest.amount, f64::INFINITY));
            if spare.amount >= nearest.amount {
                (nearest, nearest_axis) = (spare, *axis);
            }
        };
        if axes.is_empty() {
            self.grid.iter().for_each(&mut look);
        } else {
            axes.iter().for_each(|c| look(&c.axis));
        }
        alone.blocked = Some(self.search.nearest_obstacle(place, &nearest_axis, nearest.by));
        alone
    }

    /// The longest run from a station with its axes: its last station, and the axes that suit all of it.
    fn extend_run(&mut self, from: usize, start: Vec<AxisCandidate>) -> (usize, Vec<AxisCandidate>) {
        let mut axes = start;
        let mut station = from + 1;
        while station < self.stations.len() {
            self.prepare_station(station, cone_of(&axes));
            let places: Vec<&PreparedContact> = self.places[station].iter().collect();
            let next: Vec<AxisCandidate> = axes
                .par_iter()
                .map(|c| AxisCandidate {
                    spare: self.min_spare(&places, &c.axis, (-SEED_SPARE, c.spare)),
                    ..*c
                })
                .filter(|c| c.spare > -SEED_SPARE)
                .collect();
            if next.iter().any(|c| c.spare >= 0.0) {
                axes = next;
                station += 1;
                continue;
            }
            // The newest station first: it is the one at which axes fail.
            let run: Vec<&PreparedContact> = (from..=station).rev().flat_map(|k| &self.places[k]).collect();
            if let Some(between) = self.refine_between(&next, &run) {
                axes = between;
                station += 1;
                continue;
            }
            // A station without any axis does not end the run.
            let contacts = self.stations[station].len();
            let alone = self.starting_at(station);
            if let Some(axes) = alone.filter(|_| self.stations[station].len() == contacts) {
                self.next = Some((station, axes));
                break;
            }
            if self.stations[station].is_empty() {
                station += 1;
            }
        }
        (station - 1, axes)
    }

    /// Axes between those of the grid that suit `places`, searched around the best of `axes`.
    fn refine_between(
        &self,
        axes: &[AxisCandidate],
        places: &[&PreparedContact],
    ) -> Option<Vec<AxisCandidate>> {
        let mut seeds = axes.to_vec();
        seeds.sort_by(|a, b| b.spare.total_cmp(&a.spare));
        seeds.truncate(SEEDS);
        let suited = |seed: &AxisCandidate| {
            let found = self.refine_seed(*seed, places)?;
            // The fast distances may be too careful.
            let free = found.spare >= 0.0 || self.is_free(places, &found.axis);
            free.then_some(AxisCandidate { spare: found.spare.max(0.0), ..found })
        };
        let free: Vec<AxisCandidate> = seeds.par_iter().filter_map(suited).collect();
        if free.is_empty() {
            return None;
        }
        let around: Vec<Vector> =
            free.iter().flat_map(|c| STEPS.iter().flat_map(|&s| ring(&c.axis, s))).collect();
        let others = around.par_iter().map(|&axis| AxisCandidate {
            axis,
            spare: self.min_spare(places, &axis, (-SEED_SPARE, f64::INFINITY)),
        });
        let others: Vec<AxisCandidate> = others.filter(|c| c.spare > -SEED_SPARE).collect();
        Some(free.into_iter().chain(others).collect())
    }

    /// An axis near `start` that suits all `places`, or nearly. Pattern search over a few contacts, to which
    /// violated ones are added (cutting-plane style).
    fn refine_seed(&self, start: AxisCandidate, places: &[&PreparedContact]) -> Option<AxisCandidate> {
        let first = places.len().min(DECIDING);
        let mut deciding: Vec<&PreparedContact> = places[..first].to_vec();
        let mut best = AxisCandidate { spare: self.min_spare(&deciding, &start.axis, EXACT), ..start };
        for _ in 0..MAX_ADDED_CONTACTS {
            best = self.pattern_search(best, &deciding, 0.0);
            if best.spare < -MAX_CHECKED_DEFICIT {
                return None;
            }
            let wanted = best.spare.min(0.0);
            let lacks = |place: &&&PreparedContact| {
                self.search.spare(place, &best.axis, (wanted, wanted)).amount < wanted
            };
            let Some(place) = places.iter().find(lacks) else { return Some(best) };
            deciding.push(place);
            best.spare = self.min_spare(&deciding, &best.axis, EXACT);
        }
        None
    }

    /// The axis near `start` with the largest spare clearance over `places`, up to `enough`: pattern search
    /// over the contacts with the least, re-evaluated over all of them.
    fn maximise_spare(
        &self,
        start: AxisCandidate,
        places: &[&PreparedContact],
        enough: f64,
    ) -> AxisCandidate {
        let by_place = |axis: &Vector| -> Vec<(f64, usize)> {
            let amount = |place: &&PreparedContact| self.search.spare(place, axis, EXACT).amount;
            let mut all: Vec<(f64, usize)> =
                places.par_iter().enumerate().map(|(k, p)| (amount(p), k)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            all
        };
        let worst = |all: &[(f64, usize)]| all.first().map_or(f64::INFINITY, |w| w.0);
        let mut all = by_place(&start.axis);
        let mut best = AxisCandidate { spare: worst(&all), ..start };
        let mut deciding: Vec<&PreparedContact> = Vec::new();
        for _ in 0..3 {
            for &(_, k) in all.iter().take(DECIDING) {
                if !deciding.iter().any(|known| std::ptr::eq(*known, places[k])) {
                    deciding.push(places[k]);
                }
            }
            let there = self.pattern_search(best, &deciding, enough);
            all = by_place(&there.axis);
            if worst(&all) <= best.spare {
                break;
            }
            best = AxisCandidate { spare: worst(&all), ..there };
            if best.spare >= enough {
                break;
            }
        }
        best
    }

    /// Pattern search for the axis with the largest spare clearance over `places`, with decreasing steps.
    fn pattern_search(
        &self,
        start: AxisCandidate,
        places: &[&PreparedContact],
        enough: f64,
    ) -> AxisCandidate {
        let mut best = start;
        for step in STEPS {
            for _ in 0..6 {
                let before = best.spare;
                for axis in ring(&best.axis, step) {
                    let spare = self.min_spare(places, &axis, (best.spare, f64::INFINITY));
                    if spare > best.spare {
                        best = AxisCandidate { axis, spare };
                    }
                }
                if best.spare >= enough || best.spare <= before {
                    break;
                }
            }
        }
        best
    }

    /// Spare clearance of an axis over contacts, but at most `most`, mm; only an upper bound when it is below
    /// `enough`.
    fn min_spare(&self, places: &[&PreparedContact], axis: &Vector, (enough, most): (f64, f64)) -> f64 {
        let mut least = most;
        for place in places {
            least = least.min(self.search.spare(place, axis, (enough, least)).amount);
            if least < enough {
                break;
            }
        }
        least
    }

    fn is_free(&self, places: &[&PreparedContact], axis: &Vector) -> bool {
        places
            .iter()
            .all(|place| self.search.check_exactly(&place.contact, axis, self.layer, f64::INFINITY).is_ok())
    }

    /// Minimum distance from the blades over the stations of a run, mm, against the true surfaces.
    ///
    /// # Errors
    /// The first station at which the axis is not free.
    fn check_run(&self, from: usize, to: usize, axis: &Vector) -> Result<f64, usize> {
        let stations: Vec<Result<f64, usize>> = (from..=to)
            .into_par_iter()
            .map(|station| {
                let near = |least: f64, contact: &LayerContact| {
                    self.search.check_exactly(contact, axis, self.layer, least)
                };
                self.stations[station].iter().try_fold(f64::INFINITY, near).map_err(|_| station)
            })
            .collect();
        stations.into_iter().try_fold(f64::INFINITY, |least, station| Ok(station?.min(least)))
    }

    /// Selects the best axis of a run, checks it against the true surfaces and records the run. Returns its
    /// last station, an earlier one where no axis is free up to `to`. `None` when the run must be searched
    /// again with all contacts of one of its stations.
    fn close_run(&mut self, from: usize, to: usize, mut axes: Vec<AxisCandidate>) -> Option<usize> {
        let enough = ENOUGH_RADII * self.search.tool.radius();
        let normal: Vector = (from..=to).flat_map(|k| &self.stations[k]).map(|contact| contact.normal).sum();
        let worth = |c: &AxisCandidate| c.spare.min(enough) - 1e-3 * c.axis.angle(&normal);
        axes.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        axes.truncate(MAX_CHECKED_AXES);
        if let Some(best) = axes.first().copied() {
            let places: Vec<&PreparedContact> = (from..=to).rev().flat_map(|k| &self.places[k]).collect();
            let better = if best.spare < enough { self.maximise_spare(best, &places, enough) } else { best };
            axes.insert(0, better);
        }
        let mut furthest = (from, Vector::zeros());
        for candidate in &axes {
            match self.check_run(from, to, &candidate.axis) {
                Ok(clearance) => {
                    self.found.runs.push(FixedRun { from, to, axis: candidate.axis, clearance });
                    return Some(to);
                }
                Err(station) if !self.in_full[station] => {
                    self.in_full[station] = true;
                    return None;
                }
                Err(station) if station > furthest.0 => furthest = (station, candidate.axis),
                Err(_) => {}
            }
        }
        let (station, axis) = furthest;
        if station == from {
            self.drop_station(from, (0..self.stations[from].len()).collect());
            return Some(from);
        }
        let clearance = self.check_run(from, station - 1, &axis).unwrap_or(f64::NAN);
        self.found.runs.push(FixedRun { from, to: station - 1, axis, clearance });
        Some(station - 1)
    }
}

/// The two contacts furthest apart, or as many as there are.
fn furthest_apart(contacts: &[LayerContact]) -> Vec<&LayerContact> {
    let mut best = (-1.0, 0, 0);
    for i in 0..contacts.len() {
        for j in i + 1..contacts.len() {
            let apart = (contacts[i].point - contacts[j].point).norm();
            if apart > best.0 {
                best = (apart, i, j);
            }
        }
    }
    match contacts {
        [] => Vec::new(),
        [only] => vec![only],
        _ => vec![&contacts[best.1], &contacts[best.2]],
    }
}

/// A cone that holds the axes and those next to them; `None` when there are none.
fn cone_of(axes: &[AxisCandidate]) -> Option<Cone> {
    let axis = axes.iter().map(|c| c.axis).sum::<Vector>().try_normalize(1e-6)?;
    let widest = axes.iter().map(|c| c.axis.angle(&axis)).fold(0.0, f64::max);
    Some(Cone { axis, angle: widest + BEYOND })
}
