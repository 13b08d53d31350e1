//! The loop of paper A, fig. 16: conventional positions → step inspection → axis optimisation →
//! slotting depth and safe height, again until nothing changes; then everything is measured.

use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::clearance::FinishedPart;
use super::contact::{BlankTop, Column, core_contact, core_interferes};
use super::lane::Lane;
use super::links::raise_links;
use super::plan::{Dropped, PlungePlan, Position, SectionPlan};
use super::retract::RetractSurface;
use super::row::{RowFault, RowMaker, Station};
use super::sections::{MAX_POSITIONS, SetupFault, SetupPlace, row_spacing, step_limit, too_many, tool_of};
use super::slotting::DepthSurface;
use crate::geometry::CutterSolid;
use crate::monitor::{Cancelled, Monitor};
use crate::part::setup::{AxisPolicy, Feed, SectionSetup};
use crate::part::{Blank, Channel, Impeller, Passage, Setup, Tool};

/// Rounds after which a row that still changes is given up as not settled.
const MAX_ROUNDS: usize = 12;
/// Least leans of the first position that are tried for `monotone`, in degrees, after the unchanged one.
const START_LEANS_DEG: [f64; 17] =
    [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 18.0, 20.0];
/// How far a start is moved out of the stock, one after the other, in cutter radii.
const START_RETREATS: [f64; 8] = [0.0, 0.1, 0.2, 0.35, 0.55, 0.8, 1.2, 1.8];
/// Air between the core and the rim at the start of a row, mm.
const START_MARGIN: f64 = 0.05;

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Part and setup do not go together.
    #[error(transparent)]
    Setup(#[from] SetupFault),
}

/// Everything about a part and a setup that all policies share.
#[derive(Debug)]
pub struct Planner<'a> {
    part: &'a Impeller,
    channel: &'a Channel,
    setup: &'a Setup,
    blank: Blank,
    finished: FinishedPart<'a>,
    /// Per section what does not depend on the policy.
    grounds: Vec<Result<Vec<Ground<'a>>, PlanError>>,
}

/// A stretch as its cutter sees it, with what was found out about it: shared by all policies.
#[derive(Debug)]
struct Ground<'a> {
    stretch: Stretch<'a>,
    lane: Lane<'a>,
    /// Hub, offset by allowance and corner radius.
    hub: DepthSurface<'a>,
    rows: Vec<RowGround>,
}

/// A row's place across its stretch, and what is conventional about it.
#[derive(Debug)]
struct RowGround {
    /// λ within the stretch.
    lambda: f64,
    /// First stations that were asked for, by s.
    firsts: Memory<Option<Station>>,
    /// Whole rows, by s of their start.
    conventional: Memory<Vec<Station>>,
}

/// Answers to questions asked by s, each made once whoever asks.
#[derive(Debug)]
struct Memory<T>(Mutex<Vec<(f64, T)>>);

impl<T: Clone> Memory<T> {
    fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// The answer at `s`, from `make` unless it is known. Who asks at the same time waits: `make` may not
    /// hand work to other threads.
    fn get_or_make<E>(&self, s: f64, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, answer)) = known.iter().find(|(at, _)| *at == s) {
            return Ok(answer.clone());
        }
        let answer = make()?;
        known.push((s, answer.clone()));
        Ok(answer)
    }
}

/// A stretch of a passage that one section cuts.
#[derive(Debug)]
struct Stretch<'a> {
    passage: &'a Passage,
    /// λ of the passage's walls in the whole channel.
    lambdas: (f64, f64),
    /// Outlet end and inlet end, s.
    from: f64,
    to: f64,
}

impl Stretch<'_> {
    /// s at a share of the way from the outlet end to the inlet end.
    fn s_at(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}

/// A cutter in its final place.
struct Placed {
    cutter: CutterSolid,
    hub_clearance: f64,
    blade_clearance: f64,
}

/// One row, planned.
struct Row {
    stations: Vec<Station>,
    lambda: f64,
    rounds: usize,
    settled: bool,
}

impl Row {
    fn empty(lambda: f64) -> Self {
        Self { stations: Vec::new(), lambda, rounds: 0, settled: true }
    }
}

/// The attempts at one row: what they have in common.
struct Attempts<'r> {
    maker: &'r RowMaker<'r>,
    ground: &'r RowGround,
    /// Last s in the order of cutting.
    end: f64,
    earlier: &'r [Column],
    top: &'r BlankTop<'r>,
}

impl Attempts<'_> {
    /// Conventional stations from `start` on.
    fn conventional(&self, start: f64) -> Result<Vec<Station>, RowFault> {
        self.ground.conventional.get_or_make(start, || self.maker.conventional(start, self.end))
    }

    /// The conventional station at `s`.
    fn first(&self, s: f64) -> Option<Station> {
        let make = || Ok::<_, Infallible>(self.maker.isoparametric(s));
        let Ok(station) = self.ground.firsts.get_or_make(s, make);
        station
    }
}

/// Whether two stations have the same axis to a ten-thousandth of a millimetre.
fn same_axis(a: &Station, b: &Station) -> bool {
    (a.tip - b.tip).norm() < 1e-4 && (a.axis - b.axis).norm() < 1e-6
}

/// What was cut before the next position of a row: earlier sections and the row so far.
struct Known<'e> {
    earlier: &'e [Column],
    columns: Vec<Column>,
    blank: &'e Blank,
    top: &'e BlankTop<'e>,
}

impl<'e> Known<'e> {
    fn new(earlier: &'e [Column], blank: &'e Blank, top: &'e BlankTop<'e>) -> Self {
        Self { earlier, columns: earlier.to_vec(), blank, top }
    }

    /// Forgets the row.
    fn forget(&mut self) {
        self.columns.truncate(self.earlier.len());
    }

    /// Whether the last of `stations` interferes; remembers it as cut.
    fn interferes(&mut self, maker: &RowMaker, stations: &[Station]) -> bool {
        let Some(last) = stations.last() else { return false };
        let column = Column::new(maker.cutter(last), maker.tool.core_radius(), self.top);
        let interferes = core_interferes(&column, &self.columns, self.blank);
        self.columns.push(column);
        interferes
    }
}

impl<'a> Planner<'a> {
    /// For `part` with its `channel` and a `setup` that [`super::sections::resolve`] has completed.
    pub fn new(part: &'a Impeller, channel: &'a Channel, setup: &'a Setup) -> Self {
        let mut planner = Self {
            part,
            channel,
            setup,
            blank: Blank::of(part, setup.stock.inlet_extension),
            finished: FinishedPart::new(part, &channel.sides),
            grounds: Vec::new(),
        };
        planner.grounds = setup.plunge.sections.par_iter().map(|section| planner.ground(section)).collect();
        planner
    }

    /// The blank the plan starts from.
    pub fn blank(&self) -> &Blank {
        &self.blank
    }

    /// Plans one channel by `policy`.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`] soon after the monitor asks for it, [`PlanError::Setup`] when a cutter
    /// does not fit where it shall work.
    pub fn plan(&self, policy: AxisPolicy, monitor: &Monitor) -> Result<PlungePlan, PlanError> {
        let mut plan = PlungePlan {
            policy,
            sections: Vec::new(),
            positions: Vec::new(),
            dropped: Vec::new(),
            rounds: 0,
            settled: true,
        };
        let mut columns: Vec<Column> = Vec::new();
        let top = BlankTop::new(&self.blank);
        let sections = &self.setup.plunge.sections;
        for (index, section) in sections.iter().enumerate() {
            monitor.check()?;
            monitor.report(0.8 * index as f64 / sections.len() as f64);
            let tool = tool_of(self.setup, section.tool)?;
            let before = index.checked_sub(1).map(|i| &sections[i]);
            let place = SetupPlace::Section { index, tool: tool.number };
            let rows = self.grounds[index]
                .as_ref()
                .map_err(PlanError::clone)
                .and_then(|grounds| self.section_rows(section, grounds, before, policy, &columns, monitor))
                .map_err(|error| match error {
                    PlanError::Setup(fault) if fault.place == SetupPlace::Whole => fault.at(place).into(),
                    other => other,
                })?;
            let planned: usize = rows.iter().map(|row| row.stations.len()).sum();
            self.check_count(plan.positions.len() + planned, tool, place)?;
            plan.sections.push(SectionPlan {
                tool: tool.clone(),
                from: section.from,
                to: section.to,
                feed: section.feed.unwrap_or(Feed::Inward),
                rows: rows.len(),
            });
            for (row_index, row) in rows.iter().enumerate() {
                plan.rounds = plan.rounds.max(row.rounds);
                plan.settled &= row.settled;
                let placed: Vec<Option<Placed>> = row
                    .stations
                    .par_iter()
                    .map(|station| if monitor.is_cancelled() { None } else { self.placed(station, tool) })
                    .collect();
                monitor.check()?;
                for (station, placed) in row.stations.iter().zip(placed) {
                    let Some(placed) = placed else {
                        plan.dropped.push(Dropped { section: index, row: row_index, s: station.ends.s_hub });
                        continue;
                    };
                    columns.push(Column::new(placed.cutter, tool.core_radius(), &top));
                    plan.positions.push(Position {
                        tip: placed.cutter.tip,
                        hub_clearance: placed.hub_clearance,
                        blade_clearance: placed.blade_clearance,
                        ..Position::unmeasured(station, index, row_index, row.lambda)
                    });
                }
            }
        }
        monitor.report(0.85);
        self.measure(&mut plan, &columns, monitor)?;
        raise_links(&mut plan, &self.blank, self.setup.stock.safety_distance, monitor)?;
        monitor.report(1.0);
        Ok(plan)
    }

    /// The cutter of a station with its clearances to the finished part, measured. Where the bottom is a hair
    /// too deep it is lifted. `None` when a blade is in the way.
    fn placed(&self, station: &Station, tool: &Tool) -> Option<Placed> {
        let stock = &self.setup.stock;
        let mut cutter = tool.placed(station.tip, station.axis);
        let mut hub_clearance = self.finished.hub_clearance(&cutter);
        for doubling in 0..12 {
            let deep = stock.hub_allowance - hub_clearance;
            if deep <= 0.0 {
                break;
            }
            // On steep axes a lift gains only part of itself.
            cutter.tip += cutter.axis * (1.2 * deep * f64::from(1 << doubling) + 1e-9);
            hub_clearance = self.finished.hub_clearance(&cutter);
        }
        let blade_clearance = self.finished.blade_clearance(&cutter);
        (blade_clearance >= stock.blade_allowance - 1e-6).then_some(Placed {
            cutter,
            hub_clearance,
            blade_clearance,
        })
    }

    /// The passages a section runs through, outlet end first.
    fn stretches(&self, section: &SectionSetup, tool: &Tool) -> Vec<Stretch<'a>> {
        let whole =
            |from: f64, to: f64| Stretch { passage: &self.channel.full, lambdas: (0.0, 1.0), from, to };
        let Some([hub, shroud]) = self.channel.splitter_s else {
            return vec![whole(section.from, section.to)];
        };
        // In front of the nose by the cutter's own reach the passages become one.
        let reach = (tool.radius() + self.setup.stock.blade_allowance) / self.part.hub.length();
        let nose = (hub.min(shroud) - reach).max(0.0);
        let mut stretches = Vec::new();
        let mut joined = nose;
        if section.from > nose {
            let share = self.splitter_share(0.5 * (section.from.min(1.0) + section.to).max(hub.max(shroud)));
            for (passage, lambdas) in
                self.channel.beside_splitter.iter().zip([(0.0, share.0), (share.1, 1.0)])
            {
                // Upstream of the nose the flanks run on and may close in: the rows end where they do.
                let to = self.open_until(passage, tool, section.to.max(nose), hub.min(shroud));
                joined = joined.max(to);
                stretches.push(Stretch { passage, lambdas, from: section.from, to });
            }
        }
        if section.to < joined {
            stretches.push(whole(section.from.min(joined), section.to));
        }
        stretches
    }

    /// How far inwards of `from` the cutter fits in `passage`, at most to `to`, s.
    fn open_until(&self, passage: &Passage, tool: &Tool, to: f64, from: f64) -> f64 {
        let stock = &self.setup.stock;
        let lane = Lane::new(self.part, passage, tool, stock.hub_allowance, stock.blade_allowance);
        let steps = 16;
        let mut open = from.max(to);
        for i in 1..=steps {
            let s = from + (to - from) * f64::from(i) / f64::from(steps);
            if s >= from || lane.wall_pair(s, s).is_none() {
                break;
            }
            open = s;
        }
        open
    }

    /// λ of both sides of the splitter's foot at `s`.
    fn splitter_share(&self, s: f64) -> (f64, f64) {
        let angles = |p: &Passage| p.wall_angles(self.part, s, 0.0);
        match (
            angles(&self.channel.full),
            angles(&self.channel.beside_splitter[0]),
            angles(&self.channel.beside_splitter[1]),
        ) {
            (Some(full), Some(near), Some(far)) => {
                let width = full[1] - full[0];
                (
                    ((near[1] - near[0]) / width).clamp(0.0, 1.0),
                    (1.0 - (far[1] - far[0]) / width).clamp(0.0, 1.0),
                )
            }
            _ => (0.5, 0.5),
        }
    }

    /// What there is to know about a section before its policy.
    fn ground(&self, section: &SectionSetup) -> Result<Vec<Ground<'a>>, PlanError> {
        let stock = &self.setup.stock;
        let tool = tool_of(self.setup, section.tool)?;
        let grounds = self.stretches(section, tool).into_iter().map(|stretch| {
            let lane =
                Lane::new(self.part, stretch.passage, tool, stock.hub_allowance, stock.blade_allowance);
            let hub = DepthSurface::new(self.part.hub.curve(), stock.hub_allowance + tool.corner_radius);
            let rows = self.row_places(&lane, &stretch, tool)?.into_iter().map(|lambda| RowGround {
                lambda,
                firsts: Memory::new(),
                conventional: Memory::new(),
            });
            Ok(Ground { rows: rows.collect(), stretch, lane, hub })
        });
        grounds.collect()
    }

    fn section_rows(
        &self,
        section: &SectionSetup,
        grounds: &[Ground],
        before: Option<&SectionSetup>,
        policy: AxisPolicy,
        earlier: &[Column],
        monitor: &Monitor,
    ) -> Result<Vec<Row>, PlanError> {
        let tool = tool_of(self.setup, section.tool)?;
        let inward = if section.feed == Some(Feed::Outward) { -1.0 } else { 1.0 };
        let mut rows = Vec::new();
        for Ground { stretch, lane, hub, rows: row_grounds } in grounds {
            let made: Vec<Result<Row, PlanError>> = row_grounds
                .par_iter()
                .map(|ground| {
                    let lambda = ground.lambda;
                    let wall_row = lambda == 0.0 || lambda == 1.0 || row_grounds.len() == 1;
                    let maker = RowMaker {
                        part: self.part,
                        lane,
                        hub,
                        tool,
                        lambda,
                        inward,
                        step_limit: step_limit(&self.setup.plunge, tool, wall_row),
                        monitor,
                    };
                    let ends = self.row_ends(section, stretch, before, tool, inward);
                    let mut row = self.row(&maker, ground, ends, policy, earlier, monitor)?;
                    row.lambda = stretch.lambdas.0 + lambda * (stretch.lambdas.1 - stretch.lambdas.0);
                    Ok(row)
                })
                .collect();
            for row in made {
                rows.push(row?);
            }
        }
        Ok(rows)
    }

    /// λ of the rows of a stretch: both walls, and between them no further apart than the row
    /// spacing on the hub, nor so far at the shroud that a ridge is left standing.
    fn row_places(&self, lane: &Lane, stretch: &Stretch, tool: &Tool) -> Result<Vec<f64>, PlanError> {
        let spacing = row_spacing(&self.setup.plunge, tool);
        let widths: Vec<Option<(f64, f64)>> =
            (0..=8).into_par_iter().map(|i| lane.width(stretch.s_at(f64::from(i) / 8.0))).collect();
        let mut gaps = 0.0f64;
        let mut widest = 0.0f64;
        for (i, width) in widths.into_iter().enumerate() {
            let (hub, shroud) = width.ok_or_else(|| self.misfit(tool, stretch.s_at(i as f64 / 8.0)))?;
            gaps = gaps.max(hub / spacing).max(shroud / (1.9 * tool.radius()));
            widest = widest.max(hub);
        }
        if widest < 0.1 * tool.radius() {
            return Ok(vec![0.5]);
        }
        let count = (gaps - 1e-9).ceil().clamp(1.0, 400.0) as usize;
        Ok((0..=count).map(|i| i as f64 / count as f64).collect())
    }

    /// First and last s of a stretch's rows in the order of cutting, before the start is moved out of
    /// the stock.
    fn row_ends(
        &self,
        section: &SectionSetup,
        stretch: &Stretch,
        before: Option<&SectionSetup>,
        tool: &Tool,
        inward: f64,
    ) -> (f64, f64) {
        let hub = &self.part.hub;
        let (mut start, end) =
            if inward > 0.0 { (stretch.from, stretch.to) } else { (stretch.to, stretch.from) };
        let border = if inward > 0.0 { section.from } else { section.to };
        if start == border {
            let open_end = if inward > 0.0 { start >= 1.0 - 1e-9 } else { start <= 1e-9 };
            if open_end {
                // The core stays outside the blank at hub and shroud.
                let out = tool.core_radius().max(0.0) + START_MARGIN;
                start += inward * out / hub.length();
            } else if let Some(previous) = before.and_then(|b| tool_of(self.setup, b.tool).ok()) {
                // Front rims of the larger cutter before and of this one flush.
                let shift = (previous.radius() - tool.radius()).max(0.0) / hub.length();
                let shifted = start - inward * shift;
                if (end - shifted) * inward < 0.0 {
                    start = shifted;
                }
            }
        }
        (start, end)
    }

    fn check_count(&self, positions: usize, tool: &Tool, place: SetupPlace) -> Result<(), PlanError> {
        if positions <= MAX_POSITIONS {
            return Ok(());
        }
        Err(too_many(positions as f64, &self.setup.plunge, tool, place).into())
    }

    fn misfit(&self, tool: &Tool, s: f64) -> PlanError {
        SetupFault::new(
            format!(
                "tool {} (D {}) does not fit between the walls at s = {s:.2}",
                tool.number, tool.diameter
            ),
            "use a smaller cutter there, or end its section before it",
        )
        .into()
    }

    /// Plans one row by `policy`. For `monotone` the first position is left as it is if the row is
    /// then free of contact; else its lean is raised to the least of some fixed angles that
    /// frees the row (or leaves the fewest contacts).
    fn row(
        &self,
        maker: &RowMaker,
        ground: &RowGround,
        ends: (f64, f64),
        policy: AxisPolicy,
        earlier: &[Column],
        monitor: &Monitor,
    ) -> Result<Row, PlanError> {
        let top = BlankTop::new(&self.blank);
        let attempts = Attempts { maker, ground, end: ends.1, earlier, top: &top };
        if policy == AxisPolicy::Conventional {
            let (start, _) = self.free_start(&attempts, ends.0, None);
            let row = self.settled_row(&attempts, policy, (start, None), true, monitor)?;
            return Ok(row.unwrap_or_else(|| Row::empty(maker.lambda)));
        }
        let starts = || std::iter::once(None).chain(START_LEANS_DEG.iter().map(|d| Some(d.to_radians())));
        let mut tried: Vec<((f64, Option<f64>), Station)> = Vec::new();
        for lean in starts() {
            monitor.check()?;
            let (start, first) = self.free_start(&attempts, ends.0, lean);
            let Some(first) = first else { continue };
            // Angles below the jump of α from rear to front contact all start the row alike.
            if tried.iter().any(|(_, t)| same_axis(t, &first)) {
                continue;
            }
            tried.push(((start, lean), first));
            if let Some(row) = self.settled_row(&attempts, policy, (start, lean), false, monitor)? {
                return Ok(row);
            }
        }
        // Nothing frees the row: the start with the fewest contacts.
        let mut best: Option<(usize, Row)> = None;
        for (start, _) in tried {
            if let Some(row) = self.settled_row(&attempts, policy, start, true, monitor)? {
                let contacts = self.contacts(&attempts, &row.stations);
                if best.as_ref().is_none_or(|b| contacts < b.0) {
                    best = Some((contacts, row));
                }
            }
        }
        Ok(best.map_or_else(|| Row::empty(maker.lambda), |b| b.1))
    }

    /// The first station of a row that starts at s = `start` with at least `lean`.
    fn first_station(&self, attempts: &Attempts, start: f64, lean: Option<f64>) -> Option<Station> {
        let station = attempts.first(start)?;
        let leaning = attempts.maker.monotone(&[station], lean, self.setup.plunge.max_tilt, &mut |_| true);
        Some(leaning.and_then(|row| row.first().copied()).unwrap_or(station))
    }

    /// Stages 1 to 4 until no position is added any more; `None` when a contact turns up and none is allowed.
    fn settled_row(
        &self,
        attempts: &Attempts,
        policy: AxisPolicy,
        (start, lean): (f64, Option<f64>),
        contacts_allowed: bool,
        monitor: &Monitor,
    ) -> Result<Option<Row>, PlanError> {
        monitor.check()?;
        let max_tilt = self.setup.plunge.max_tilt;
        let maker = attempts.maker;
        let mut conventional = attempts.conventional(start).map_err(|fault| match fault {
            RowFault::Misfit(s) => self.misfit(maker.tool, s),
            RowFault::Cancelled => Cancelled.into(),
        })?;
        let mut row = Row { settled: false, ..Row::empty(maker.lambda) };
        let mut known = Known::new(attempts.earlier, &self.blank, attempts.top);
        while row.rounds < MAX_ROUNDS && !row.settled {
            row.rounds += 1;
            known.forget();
            let mut accept = |stations: &[Station]| {
                !monitor.is_cancelled() && (contacts_allowed || !known.interferes(maker, stations))
            };
            let optimised = match policy {
                AxisPolicy::Conventional => Some(conventional.clone()),
                AxisPolicy::Monotone => maker.monotone(&conventional, lean, max_tilt, &mut accept),
            };
            monitor.check()?;
            let Some(stations) = optimised else { return Ok(None) };
            row.stations = stations;
            row.settled = maker.inspect_steps(&row.stations, &mut conventional) == 0;
            self.check_count(conventional.len(), maker.tool, SetupPlace::Whole)?;
        }
        Ok(Some(row))
    }

    /// Moves the start of a row out of the stock until its first core column is free up to the top
    /// of the blank; where nothing frees it within a diameter, leaves it where it was. Returns s and
    /// the station there.
    fn free_start(&self, attempts: &Attempts, start: f64, lean: Option<f64>) -> (f64, Option<Station>) {
        let maker = attempts.maker;
        let radius_s = maker.tool.radius() / self.part.hub.length();
        let mut unmoved = None;
        for radii in START_RETREATS {
            if maker.monitor.is_cancelled() {
                break;
            }
            let s = start + maker.inward * radii * radius_s;
            let Some(first) = self.first_station(attempts, s, lean) else { break };
            let column = Column::new(maker.cutter(&first), maker.tool.core_radius(), attempts.top);
            if !core_interferes(&column, attempts.earlier, &self.blank) {
                return (s, Some(first));
            }
            unmoved = unmoved.or(Some(first));
        }
        (start, unmoved)
    }

    /// Number of interferential stations of a row that comes after `earlier`.
    fn contacts(&self, attempts: &Attempts, stations: &[Station]) -> usize {
        let mut known = Known::new(attempts.earlier, &self.blank, attempts.top);
        (1..=stations.len()).filter(|&k| known.interferes(attempts.maker, &stations[..k])).count()
    }

    /// Contact, clearances and retract of every position.
    fn measure(&self, plan: &mut PlungePlan, columns: &[Column], monitor: &Monitor) -> Result<(), PlanError> {
        let stock = &self.setup.stock;
        let tops: Vec<RetractSurface> = plan
            .sections
            .iter()
            .map(|s| RetractSurface::new(&self.blank, stock.safety_distance + s.tool.corner_radius))
            .collect();
        let sections = &plan.sections;
        let measured: Result<Vec<Position>, Cancelled> = plan
            .positions
            .par_iter()
            .enumerate()
            .map(|(k, position)| {
                monitor.check()?;
                let tool = &sections[position.section].tool;
                let cutter = columns[k].cutter;
                let lift = tops[position.section].height(
                    &cutter.tip,
                    &cutter.axis,
                    tool.radius() - tool.corner_radius,
                );
                let retract = cutter.tip + cutter.axis * (lift + 1e-6);
                let mut position = position.clone();
                position.retract = retract;
                position.contact = core_contact(&columns[k], &columns[..k], &self.blank);
                Ok(position)
            })
            .collect();
        plan.positions = measured?;
        Ok(())
    }
}
