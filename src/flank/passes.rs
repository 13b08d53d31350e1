//! From curves to positions: inner curves under fixed axes, curves along walls with the axes fitted to the walls.

use super::chart::{Chart, Region, WallName};
use super::curves::LayerCurves;
use super::fixed_axis::{Contact, FixedAxisLimits, FixedAxisSearch, Obstacle};
use super::layer::{Layer, LayerPoint};
use super::path::Pass;
use super::plan::{MilledWall, RegionAxis};
use super::schemes::{Curve, Role};
use crate::geometry::{Point, Vector};
use crate::part::{Channel, Impeller, Setup, Tool};
use crate::plunge::clearance::FinishedPart;
use crate::plunge::slotting::DepthSurface;

/// Positions stand so far off the layer that the straight ways between them do not cut into it, mm.
const CHORD: f64 = 0.005;
/// Steps along inner curves at least and at most, mm.
const STEPS: [f64; 2] = [0.2, 5.0];
/// Distance of the stations at which fixed axes are looked for, mm along the meridian, and the most of them.
const STATION_STEP: f64 = 4.0;
const MAX_STATIONS: usize = 48;
/// Curves of a region that are looked at in a station.
const ACROSS: usize = 5;
/// Greatest angle between a fixed axis and the layer's normal, rad.
const MAX_TILT: f64 = 65.0 * std::f64::consts::PI / 180.0;
/// Intervals from the curve along a wall within which inner curves turn their axis towards the wall's.
const TURNING: f64 = 1.75;
/// Nearer than this many intervals they have the wall's axis, and the pass along the wall covers what they leave out.
const TURNED: f64 = 0.5;
/// Greatest turn of the axis from position to position, rad: a ball's tip then stays within a µm of its way.
const MOST_TURN: f64 = 1.5 * std::f64::consts::PI / 180.0;
/// Most positions that a turn adds to a step.
const MAX_TURNS: f64 = 60.0;
/// Rounds in which a position beside a nose is moved off it.
const PUSHES: usize = 12;
/// Times the way between two positions beside a nose is halved, and the push that asks for it, mm.
const MENDS: usize = 4;
const MENDED: f64 = 5e-4;
/// Spacing of the points that the surface a cutter rests on is drawn through, mm.
const SURFACE_STEP: f64 = 0.5;

/// A stretch of curves that is not cut, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Layer, 0 at the hub.
    pub layer: usize,
    /// Region.
    pub region: Region,
    /// Length of the curves there, mm.
    pub length: f64,
    /// What stands in the way.
    pub why: &'static str,
}

/// What a layer is cut with.
pub struct LayerAxes {
    /// One for each curve, or more where the axis changes on its way.
    pub passes: Vec<Pass>,
    /// Fixed axes of the inner curves.
    pub axes: Vec<RegionAxis>,
    /// What is not cut.
    pub left_out: Vec<LeftOut>,
}

/// Makes the passes of one plan.
pub struct PassMaker<'a> {
    part: &'a Impeller,
    tool: &'a Tool,
    setup: &'a Setup,
    walls: &'a [MilledWall],
    search: FixedAxisSearch<'a>,
    /// The surfaces that must not be cut.
    finished: &'a FinishedPart<'a>,
}

impl<'a> PassMaker<'a> {
    /// For `tool` in `channel`, whose surfaces are those of `finished`, with its `walls` fitted.
    pub fn new(
        finished: &'a FinishedPart<'a>,
        channel: &'a Channel,
        setup: &'a Setup,
        tool: &'a Tool,
        walls: &'a [MilledWall],
    ) -> Self {
        let limits = FixedAxisLimits {
            hub_allowance: setup.stock.hub_allowance,
            blade_allowance: setup.stock.blade_allowance,
            max_tilt: MAX_TILT,
        };
        Self {
            part: finished.part,
            tool,
            setup,
            walls,
            search: FixedAxisSearch::new(finished, channel, tool, &limits),
            finished,
        }
    }

    /// Passes of one layer.
    pub fn layer(&self, number: usize, found: &LayerCurves, chart: &Chart) -> LayerAxes {
        let layer = &found.layer;
        let beyond = self.setup.flank.extension_of(self.tool) + 4.0 * self.tool.radius();
        let curve = layer.run_on(beyond, SURFACE_STEP);
        let surface = DepthSurface::new(&curve, self.tool.corner_radius);
        let milled = self.walls.iter().map(|wall| Milled::on(self, layer, wall, &surface)).collect();
        let on = OnLayer { maker: self, layer, found, number, chart, surface: &surface, milled };
        let mut made = LayerAxes { passes: Vec::new(), axes: Vec::new(), left_out: Vec::new() };
        let mut inner: Vec<(Region, Vec<LayerPoint>)> = Vec::new();
        for curve in &found.curves {
            for (role, region, points) in on.stretches(curve) {
                match role {
                    Role::Inner => inner.push((region, points)),
                    Role::Wall(wall) => on.along_wall(wall, region, &points, &mut made),
                }
            }
        }
        for region in [Region::Inlet, Region::LowSide, Region::HighSide] {
            let lines: Vec<&[LayerPoint]> =
                inner.iter().filter(|(r, _)| *r == region).map(|(_, points)| points.as_slice()).collect();
            on.inner(region, &lines, &mut made);
        }
        made
    }
}

/// One layer in work.
struct OnLayer<'a> {
    maker: &'a PassMaker<'a>,
    layer: &'a Layer,
    found: &'a LayerCurves,
    number: usize,
    chart: &'a Chart<'a>,
    surface: &'a DepthSurface<'a>,
    milled: Vec<Milled>,
}

/// The cutter at the stations along a wall, on a layer.
struct Milled {
    wall: WallName,
    region: Region,
    /// Where it misses the layer there is none; with whether something stands in its way.
    placed: Vec<Option<(Placed, bool)>>,
}

impl Milled {
    fn on(maker: &PassMaker, layer: &Layer, milled: &MilledWall, surface: &DepthSurface) -> Self {
        let mut y = None;
        let placed = milled.axes.stations.iter().map(|station| {
            let tip = station.tip_on(surface, maker.tool)? + station.axis * CHORD;
            let axis = station.axis;
            let (place, _) = layer.place(&(tip + axis * maker.tool.corner_radius), y.unwrap_or(0.0), None);
            y = Some(place.y);
            Some((Placed { tip, axis, place }, station.blocked.is_some()))
        });
        Self { wall: milled.wall, region: milled.region, placed: placed.collect() }
    }

    /// Axis at `x`; that of the nearest station beyond both ends.
    fn axis(&self, x: f64) -> Option<Vector> {
        let stations = || self.placed.iter().flatten().map(|(placed, _)| placed);
        let mut last: Option<&Placed> = None;
        for here in stations() {
            if here.place.x >= x {
                return Some(last.map_or(here.axis, |last| {
                    last.between(here, (x - last.place.x) / (here.place.x - last.place.x).max(1e-9)).axis
                }));
            }
            last = Some(here);
        }
        last.map(|last| last.axis)
    }
}

impl OnLayer<'_> {
    /// A curve by regions: along its wall where it has one there, else as an inner one.
    fn stretches(&self, curve: &Curve) -> Vec<(Role, Region, Vec<LayerPoint>)> {
        let nose = self.found.borders.splitter.as_ref().map(|s| s.nose.x);
        let side = |p: LayerPoint| match (&self.found.borders.splitter, nose) {
            (Some(splitter), Some(nose)) if p.x >= nose => {
                let facing_low = super::border::y_at(&splitter.sides[0], p.x);
                let facing_high = super::border::y_at(&splitter.sides[1], p.x);
                if 2.0 * p.y < facing_low + facing_high { Region::LowSide } else { Region::HighSide }
            }
            _ => Region::Inlet,
        };
        if let Role::Wall(wall @ (WallName::Low | WallName::High)) = curve.role {
            return vec![(
                curve.role,
                if wall == WallName::Low { Region::LowSide } else { Region::HighSide },
                curve.points.clone(),
            )];
        }
        // Round the splitter's nose its curve stays one; isoparametric ones leave it upstream.
        let round = curve.role == Role::Wall(WallName::Splitter)
            && curve.points.first().is_some_and(|a| side(*a) != Region::Inlet)
            && curve.points.last().is_some_and(|b| side(*b) != Region::Inlet);
        if round {
            return vec![(curve.role, Region::Inlet, curve.points.clone())];
        }
        let mut stretches: Vec<(Role, Region, Vec<LayerPoint>)> = Vec::new();
        let role = |region: Region| if region == Region::Inlet { Role::Inner } else { curve.role };
        let mut last: Option<(LayerPoint, Region)> = None;
        for &p in &curve.points {
            let region = side(p);
            match last {
                Some((q, before)) if before != region => {
                    let at = nose.map_or(p, |x| q.lerp(p, ((x - q.x) / (p.x - q.x)).clamp(0.0, 1.0)));
                    if let Some((_, _, points)) = stretches.last_mut() {
                        points.push(at);
                    }
                    stretches.push((role(region), region, vec![at, p]));
                }
                Some(_) => {
                    if let Some((_, _, points)) = stretches.last_mut() {
                        points.push(p);
                    }
                }
                None => stretches.push((role(region), region, vec![p])),
            }
            last = Some((p, region));
        }
        stretches.retain(|(_, _, points)| points.len() >= 2 && self.layer.length(points) > 1e-6);
        stretches
    }

    /// Whether a place lies beyond the part, at the inlet, the rim, or above the shroud.
    fn is_open(&self, p: LayerPoint) -> bool {
        let reach = 0.5 * self.maker.setup.flank.extension_of(self.maker.tool);
        p.x <= self.layer.from - reach || p.x >= self.layer.to + reach
    }

    fn contact(&self, p: LayerPoint) -> Contact {
        let (point, normal) = self.layer.point_and_normal(p);
        Contact { point, normal }
    }

    /// Passes of the inner curves of a region.
    fn inner(&self, region: Region, lines: &[&[LayerPoint]], made: &mut LayerAxes) {
        let ends = |f: fn(f64, f64) -> f64, start: f64| {
            lines.iter().flat_map(|line| line.iter()).map(|p| p.x).fold(start, f)
        };
        let (from, to) = (ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
        if from >= to {
            return;
        }
        let count = ((to - from) / STATION_STEP).ceil().clamp(1.0, MAX_STATIONS as f64) as usize;
        let width = (to - from) / count as f64;
        // A station is a strip across the region, and its contacts are where curves enter, halve and leave it.
        let stations: Vec<Vec<Contact>> = (0..count)
            .map(|k| {
                let x = [0.0, 0.5, 1.0].map(|share| from + width * (k as f64 + share));
                x.iter().flat_map(|&x| self.across(lines, x)).map(|p| self.contact(p)).collect()
            })
            .collect();
        let found = self.maker.search.runs(&stations, self.surface);
        let border = |station: usize| from + width * station as f64;
        for run in &found.runs {
            made.axes.push(RegionAxis {
                layer: self.number,
                region,
                from: border(run.from),
                to: border(run.to + 1),
                axis: run.axis,
                clearance: run.clearance,
            });
        }
        for line in lines {
            for (group, run) in found.runs.iter().enumerate() {
                // Stations with nothing away from the walls belong to no run of their own: the nearest one serves.
                let from = if group == 0 { f64::NEG_INFINITY } else { border(run.from) };
                let to = found.runs.get(group + 1).map_or(f64::INFINITY, |next| border(next.from));
                for piece in between(line, from, to) {
                    self.fixed(region, group, &piece, run.axis, made);
                }
            }
            if found.runs.is_empty() {
                let why = found.unreachable.first().map_or(Obstacle::NoCommonAxis, |u| u.why);
                self.leave_out(made, region, self.layer.length(line), reason(why));
            }
        }
    }

    fn leave_out(&self, made: &mut LayerAxes, region: Region, length: f64, why: &'static str) {
        if length <= 0.0 {
            return;
        }
        match made.left_out.iter_mut().find(|l| l.region == region && l.why == why) {
            Some(known) => known.length += length,
            None => made.left_out.push(LeftOut { layer: self.number, region, length, why }),
        }
    }

    /// Places of some lines at `x`: the outermost and some between.
    fn across(&self, lines: &[&[LayerPoint]], x: f64) -> Vec<LayerPoint> {
        let mut places: Vec<LayerPoint> = lines
            .iter()
            .flat_map(|line| line.windows(2))
            .filter(|w| (w[0].x - x) * (w[1].x - x) <= 0.0 && w[0].x != w[1].x)
            .map(|w| w[0].lerp(w[1], (x - w[0].x) / (w[1].x - w[0].x)))
            .filter(|p| self.share_of_wall(*p) == 0.0)
            .collect();
        places.sort_by(|a, b| a.y.total_cmp(&b.y));
        places.dedup_by(|a, b| (a.y - b.y).abs() < 1e-9);
        let n = places.len();
        if n <= ACROSS {
            return places;
        }
        (0..ACROSS).map(|k| places[k * (n - 1) / (ACROSS - 1)]).collect()
    }

    /// Passes along `line` under one axis, which turns towards that of a wall where the line comes near it. Where the
    /// cutter comes too near to a blade all the same nothing is cut.
    fn fixed(&self, region: Region, group: usize, line: &[LayerPoint], axis: Vector, made: &mut LayerAxes) {
        let maker = self.maker;
        let mut open: Vec<(LayerPoint, (Point, Vector))> = Vec::new();
        let mut pieces = Vec::new();
        let mut lost = 0.0;
        let mut last: Option<LayerPoint> = None;
        for p in self.turning(self.dense(line), axis) {
            let turned = self.turned(p, axis);
            let tip = maker.search.tip(&self.contact(p), &turned, self.surface) + turned * CHORD;
            if maker.finished.clears(&maker.tool.placed(tip, turned), maker.setup.stock.blade_allowance) {
                open.push((p, (tip, turned)));
            } else {
                // Beside a wall the pass along it cuts what a curve leaves out there.
                if let Some(q) = last.filter(|_| self.share_of_wall(p) < 1.0) {
                    lost += self.layer.step(q, p);
                }
                pieces.push(std::mem::take(&mut open));
            }
            last = Some(p);
        }
        pieces.push(open);
        for piece in pieces.into_iter().filter(|piece| piece.len() >= 2) {
            let ends = [piece[0].0, piece[piece.len() - 1].0];
            let positions = piece.into_iter().map(|(_, position)| position).collect();
            made.passes.extend(self.pass(Role::Inner, region, group, ends, positions));
        }
        self.leave_out(made, region, lost, reason(Obstacle::Blade));
    }

    /// The fixed `axis`, turned towards that of a wall next to `p`.
    fn turned(&self, p: LayerPoint, axis: Vector) -> Vector {
        let share = self.share_of_wall(p);
        match self.wall_axis(p).filter(|_| share > 0.0) {
            Some(wall) => (axis + (wall - axis) * share).normalize(),
            None => axis,
        }
    }

    /// The line with so many points more that the axis turns little between two of them.
    fn turning(&self, line: Vec<LayerPoint>, axis: Vector) -> Vec<LayerPoint> {
        let mut points = vec![line[0]];
        for w in line.windows(2) {
            let middle = w[0].lerp(w[1], 0.5);
            let [a, b, c] = [w[0], middle, w[1]].map(|p| self.turned(p, axis));
            let count = ((a.angle(&b) + b.angle(&c)) / MOST_TURN).ceil().clamp(1.0, MAX_TURNS) as usize;
            points.extend((1..=count).map(|k| w[0].lerp(w[1], k as f64 / count as f64)));
        }
        points
    }

    /// How much of a wall's own axis a place near it has: 0 in the middle, 1 next to the curve along the wall.
    fn share_of_wall(&self, p: LayerPoint) -> f64 {
        let intervals = self.chart.freedom(p) / self.found.interval;
        ((TURNING - intervals) / (TURNING - TURNED)).clamp(0.0, 1.0)
    }

    /// Axis of the pass along the wall that is nearest to `p`, beside `p`.
    fn wall_axis(&self, p: LayerPoint) -> Option<Vector> {
        let wall = WallName::ALL
            .into_iter()
            .min_by(|a, b| self.chart.distance(*a, p).total_cmp(&self.chart.distance(*b, p)))?;
        let ours = self.milled.iter().filter(|m| m.wall == wall);
        let axes: Vec<Vector> = match (wall, self.chart.region(p)) {
            (WallName::Splitter, Some(Region::LowSide | Region::HighSide)) => {
                ours.filter(|m| Some(m.region) == self.chart.region(p)).filter_map(|m| m.axis(p.x)).collect()
            }
            _ => ours.filter_map(|m| m.axis(p.x)).collect(),
        };
        axes.iter().sum::<Vector>().try_normalize(1e-9)
    }

    fn pass(
        &self,
        role: Role,
        region: Region,
        group: usize,
        ends: [LayerPoint; 2],
        positions: Vec<(Point, Vector)>,
    ) -> Option<Pass> {
        (positions.len() >= 2).then(|| Pass {
            role,
            region,
            group,
            positions,
            ends,
            open: ends.map(|end| self.is_open(end)),
        })
    }

    /// The line with so many points that the straight ways between them stay within [`CHORD`] of the layer.
    fn dense(&self, line: &[LayerPoint]) -> Vec<LayerPoint> {
        let mut points = vec![line[0]];
        for w in line.windows(2) {
            let middle = w[0].lerp(w[1], 0.5);
            let bend = self.layer.sharpest_bend(middle.x);
            let step = (8.0 * CHORD / bend.max(1e-9)).sqrt().clamp(STEPS[0], STEPS[1]);
            let count = (self.layer.step(w[0], w[1]) / step).ceil().max(1.0) as usize;
            points.extend((1..=count).map(|k| w[0].lerp(w[1], k as f64 / count as f64)));
        }
        points
    }

    /// Passes of a curve along a wall.
    fn along_wall(&self, wall: WallName, region: Region, points: &[LayerPoint], made: &mut LayerAxes) {
        if wall == WallName::Splitter && region == Region::Inlet {
            self.round_nose(points, made);
            return;
        }
        let from = points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        let to = points.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        let mut positions = Vec::new();
        for position in self.wall_positions(wall, region, (from, to)) {
            match position {
                Ok(position) => positions.push(position),
                Err(length) => {
                    self.leave_out(
                        made,
                        region,
                        length,
                        "another blade stands in the way of the cutter along the wall",
                    );
                    self.push_wall(wall, region, &mut positions, made);
                }
            }
        }
        self.push_wall(wall, region, &mut positions, made);
    }

    fn push_wall(&self, wall: WallName, region: Region, positions: &mut Vec<Placed>, made: &mut LayerAxes) {
        let positions = std::mem::take(positions);
        if let (Some(first), Some(last)) = (positions.first(), positions.last()) {
            let ends = [first.place, last.place];
            let positions = positions.iter().map(|p| (p.tip, p.axis)).collect();
            made.passes.extend(self.pass(Role::Wall(wall), region, 0, ends, positions));
        }
    }

    /// The cutter at the stations along a wall whose contacts lie between two x, and at both ends; a length instead where
    /// something stands in its way.
    fn wall_positions(
        &self,
        wall: WallName,
        region: Region,
        (from, to): (f64, f64),
    ) -> Vec<Result<Placed, f64>> {
        let ours = |m: &&Milled| m.wall == wall && (wall != WallName::Splitter || m.region == region);
        let Some(milled) = self.milled.iter().find(ours) else { return Vec::new() };
        let mut result = Vec::new();
        for pair in milled.placed.windows(2) {
            let [Some((a, a_blocked)), Some((b, b_blocked))] = pair else { continue };
            let (low, high) = (a.place.x.max(from), b.place.x.min(to));
            if low >= high {
                continue;
            }
            if *a_blocked || *b_blocked {
                result.push(Err(self.layer.step(a.place, b.place)));
                continue;
            }
            let at = |x: f64| a.between(b, (x - a.place.x) / (b.place.x - a.place.x));
            if !matches!(result.last(), Some(Ok(_))) {
                result.push(Ok(at(low)));
            }
            result.push(Ok(at(high)));
        }
        result
    }

    /// One pass along one side of the splitter, round its nose, and back along the other.
    fn round_nose(&self, points: &[LayerPoint], made: &mut LayerAxes) {
        let Some(splitter) = &self.found.borders.splitter else { return };
        let foremost = (0..points.len()).min_by(|&a, &b| points[a].x.total_cmp(&points[b].x)).unwrap_or(0);
        // Beside the flanks from where they are settled; round the nose before.
        let settled = splitter.nose.x + self.maker.nose_length();
        let side = |region: Region, line: &[LayerPoint]| {
            let to = line.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
            self.wall_positions(WallName::Splitter, region, (settled, to))
        };
        let (down, up) = (&points[..=foremost], &points[foremost..]);
        let mut low = side(Region::LowSide, down);
        low.reverse();
        let high = side(Region::HighSide, up);
        let free = |placed: &[Result<Placed, f64>]| {
            placed.iter().filter_map(|p| p.as_ref().ok()).copied().collect::<Vec<Placed>>()
        };
        let (mut before, after) = (free(&low), free(&high));
        let blocked: f64 = low.iter().chain(&high).filter_map(|p| p.as_ref().err()).sum();
        self.leave_out(
            made,
            Region::LowSide,
            blocked,
            "another blade stands in the way of the cutter along the wall",
        );
        if let (Some(a), Some(b)) = (before.last().copied(), after.first().copied()) {
            let arc: Vec<LayerPoint> = points.iter().copied().filter(|p| p.x < settled).collect();
            let mut round = vec![a];
            round.extend(self.arc(&arc, a, b));
            round.push(b);
            let mended = self.mended(round);
            before.extend(&mended[1..mended.len() - 1]);
        }
        before.extend(after);
        self.push_wall(WallName::Splitter, Region::Inlet, &mut before, made);
    }

    /// The positions with others between them where the straight way would come too near to a blade.
    fn mended(&self, positions: Vec<Placed>) -> Vec<Placed> {
        let mut mended: Vec<Placed> = Vec::with_capacity(positions.len());
        for next in positions {
            if let Some(last) = mended.last().copied() {
                self.mend(last, next, MENDS, &mut mended);
            }
            mended.push(next);
        }
        mended
    }

    fn mend(&self, a: Placed, b: Placed, depth: usize, mended: &mut Vec<Placed>) {
        let middle = a.between(&b, 0.5);
        let free = self.off(middle);
        if depth == 0 || (free.tip - middle.tip).norm() < MENDED {
            return;
        }
        self.mend(a, free, depth - 1, mended);
        mended.push(free);
        self.mend(free, b, depth - 1, mended);
    }

    /// Positions on the way round the nose from `a` to `b`: the axis turns evenly, and the cutter is moved off the nose
    /// where it would come too near.
    fn arc(&self, arc: &[LayerPoint], a: Placed, b: Placed) -> Vec<Placed> {
        if arc.len() < 2 {
            return Vec::new();
        }
        let maker = self.maker;
        let dense = self.dense(arc);
        let total = self.layer.length(&dense).max(1e-9);
        let mut gone = 0.0;
        let mut placed = Vec::with_capacity(dense.len());
        for (k, &p) in dense.iter().enumerate() {
            if k > 0 {
                gone += self.layer.step(dense[k - 1], p);
            }
            let axis = (a.axis + (b.axis - a.axis) * (gone / total)).normalize();
            let tip = maker.search.tip(&self.contact(p), &axis, self.surface) + axis * CHORD;
            placed.push(self.off(Placed { tip, axis, place: p }));
        }
        placed
    }

    /// The cutter, moved over the layer away from the splitter's nose until it keeps the allowance from all blades.
    fn off(&self, placed: Placed) -> Placed {
        let maker = self.maker;
        let mut contact = self.contact(placed.place);
        let mut tip = placed.tip;
        for _ in 0..PUSHES {
            let cutter = maker.tool.placed(tip, placed.axis);
            let short = maker.setup.stock.blade_allowance - maker.finished.blade_clearance(&cutter);
            let Some(away) = self.off_nose(&contact).filter(|_| short > 0.0) else { break };
            contact.point += away * (1.3 * short + 1e-4);
            tip = maker.search.tip(&contact, &placed.axis, self.surface) + placed.axis * CHORD;
        }
        Placed { tip, ..placed }
    }

    /// Direction on the layer away from the middle of the nose.
    fn off_nose(&self, contact: &Contact) -> Option<Vector> {
        let nose = self.found.borders.splitter.as_ref()?.nose;
        let away = contact.point - self.layer.point(nose);
        (away - contact.normal * away.dot(&contact.normal)).try_normalize(1e-9)
    }
}

impl PassMaker<'_> {
    /// How far behind its foremost point a splitter's flanks are settled, mm.
    fn nose_length(&self) -> f64 {
        let Some(splitter) = self.part.splitters.first() else { return 0.0 };
        let thick = |u: f64| (splitter.suction.point(u, 0.0) - splitter.pressure.point(u, 0.0)).norm();
        0.6 * thick(0.1)
    }
}

/// A cutter on a layer.
#[derive(Clone, Copy, Debug)]
struct Placed {
    tip: Point,
    axis: Vector,
    place: LayerPoint,
}

impl Placed {
    fn between(&self, other: &Self, share: f64) -> Self {
        let share = share.clamp(0.0, 1.0);
        Self {
            tip: self.tip + (other.tip - self.tip) * share,
            axis: (self.axis + (other.axis - self.axis) * share).normalize(),
            place: self.place.lerp(other.place, share),
        }
    }
}

/// Pieces of a line between two x.
fn between(line: &[LayerPoint], from: f64, to: f64) -> Vec<Vec<LayerPoint>> {
    let mut pieces: Vec<Vec<LayerPoint>> = Vec::new();
    let mut open = false;
    for w in line.windows(2) {
        let (a, b) = (w[0], w[1]);
        let span = b.x - a.x;
        let (mut low, mut high) = (0.0f64, 1.0f64);
        if span.abs() > 1e-12 {
            let (s, t) = ((from - a.x) / span, (to - a.x) / span);
            low = low.max(s.min(t));
            high = high.min(s.max(t));
        } else if !(from..=to).contains(&a.x) {
            high = -1.0;
        }
        if low >= high {
            open = false;
            continue;
        }
        if !open || low > 0.0 {
            pieces.push(vec![a.lerp(b, low)]);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(a.lerp(b, high));
        }
        open = high >= 1.0;
    }
    pieces
}

/// What stands in the way, for people.
fn reason(why: Obstacle) -> &'static str {
    match why {
        Obstacle::Blade => "a blade is too near",
        Obstacle::Hub => "the hub is too near",
        Obstacle::Holder => "the holder meets the part",
        Obstacle::Tilt => "the axis would tilt too far",
        Obstacle::NoCommonAxis => "no one axis suits all curves there",
    }
}
