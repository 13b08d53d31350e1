//! The walls of the channel on a layer, and the fans of geodesics that leave them at right angles: the end
//! points of all geodesics of one length form the true offset of the wall (geodesic parallel).

use std::f64::consts::{FRAC_PI_2, PI};

use super::layer::{LayerPoint, LayerSurface};
use crate::geometry::wrap_angle;
use crate::part::{BladeSide, Channel, Impeller, SplitterWalls};

/// A wall as a line on the layer.
#[derive(Clone, Debug)]
pub struct LayerWall {
    /// The wall within the channel, extended beyond both ends, in the order of the rays.
    pub points: Vec<LayerPoint>,
    /// Start point and heading (rad) of each ray: at right angles to the wall, into the passage. At a nose
    /// several rays share a start point. No ray starts on an extension ahead of a nose.
    rays: Vec<(LayerPoint, f64)>,
    /// x of the foremost point with rays in all directions, mm; −∞ where the extension ahead of the wall has
    /// rays as well.
    pub nose: f64,
}

/// The walls of a channel on a layer.
#[derive(Clone, Debug)]
pub struct LayerWalls {
    /// At λ = 0.
    pub low: LayerWall,
    /// At λ = 1.
    pub high: LayerWall,
    /// The splitters whose noses are on the layer, from `low` to `high`.
    pub splitters: Vec<LayerSplitter>,
}

/// A splitter on a layer.
#[derive(Clone, Debug)]
pub struct LayerSplitter {
    /// Its number across the channel, among all splitters of a pitch.
    pub number: usize,
    /// The whole outline, from its trailing edge along the side that faces `low`, round the nose and back.
    pub border: LayerWall,
    /// x of the foremost point of its nose, mm.
    pub nose: LayerPoint,
    /// The sides that face `low` and `high`, x growing.
    pub sides: [Vec<LayerPoint>; 2],
}

/// Lines of constant u at which a flank is traced.
const FLANK_LINES: usize = 80;
/// Lines of constant u of each side of a splitter, denser towards its nose.
const NOSED_LINES: usize = 70;
/// Turn of a wall between two points above which several rays leave from there, rad.
const RAY_TURN: f64 = 0.12;
/// Lines of constant u round the nose of a main blade.
const NOSE_LINES: usize = 24;
/// Largest angle to the meridian of an extension ahead of a leading edge where a geodesic would turn back,
/// rad.
const MAX_ANGLE_TO_MERIDIAN: f64 = 60.0 * PI / 180.0;
/// Radius below which a ray beyond the ends of the layer stops, in the least radius of these ends: where the
/// straight extension of a layer comes to the axis of rotation, a geodesic turns ever faster.
const NEAR_AXIS: f64 = 0.1;
/// Least and largest spacing of the points of an extension, mm.
const EXTENSION_STEPS: [f64; 2] = [0.02, 2.0];

impl LayerWall {
    /// A wall through `points`. Rays leave to the left of the line for a `side` of 1, to the right for −1.
    fn new(layer: &LayerSurface, points: Vec<LayerPoint>, side: f64) -> Self {
        Self { nose: f64::NEG_INFINITY, rays: perpendicular_rays(layer, &points, side), points }
    }

    /// A main blade's wall, extended to `points` with growing x. Rays leave `wall` only, from the foremost
    /// point of its nose on. At that point they fan out up to straight upstream: ahead of the leading edge no
    /// wall bounds the channel, so its offsets are arcs round the nose.
    fn with_nose(layer: &LayerSurface, points: Vec<LayerPoint>, wall: &[LayerPoint], side: f64) -> Self {
        let mut rays = perpendicular_rays(layer, wall, side);
        if let Some(&(nose, heading)) = rays.first() {
            let turn = PI - side * heading;
            let count = (turn / RAY_TURN).ceil().max(0.0) as usize;
            let round = (0..count).map(|k| (nose, side * (PI - turn * k as f64 / count as f64)));
            rays.splice(0..0, round.collect::<Vec<_>>());
        }
        let nose = wall.first().map_or(f64::INFINITY, |p| p.x);
        Self { points, rays, nose }
    }

    /// End points of all rays after `length` mm: the offset of the wall.
    pub fn offset(&self, layer: &LayerSurface, length: f64) -> Vec<LayerPoint> {
        self.rays.iter().map(|&(p, heading)| layer.geodesic(p, heading, length).0).collect()
    }

    /// End points of all rays for each of the ascending `lengths` (mm), one row per length. Beyond the layer
    /// a ray ends near the axis of rotation.
    pub fn fan(&self, layer: &LayerSurface, lengths: &[f64]) -> Vec<Vec<LayerPoint>> {
        let mut rows = vec![Vec::with_capacity(self.rays.len()); lengths.len()];
        let min_radius = NEAR_AXIS * layer.radius(layer.from).0.min(layer.radius(layer.to).0);
        let goes_on =
            |p: LayerPoint| (layer.from..=layer.to).contains(&p.x) || layer.radius(p.x).0 > min_radius;
        for &(start, heading) in &self.rays {
            let (mut p, mut psi, mut gone) = (start, heading, 0.0);
            for (row, &length) in rows.iter_mut().zip(lengths) {
                if goes_on(p) {
                    (p, psi) = layer.geodesic(p, psi, length - gone);
                }
                gone = length;
                row.push(p);
            }
        }
        rows
    }

    /// y of the wall at `x`; beyond its ends that of the nearer end. x grows along the wall.
    pub fn y_at(&self, x: f64) -> f64 {
        y_at(&self.points, x)
    }
}

/// Rays at right angles to the line through `points`, to the left of it for a `side` of 1, to the right for
/// −1.
fn perpendicular_rays(layer: &LayerSurface, points: &[LayerPoint], side: f64) -> Vec<(LayerPoint, f64)> {
    let headings: Vec<f64> = points.windows(2).map(|p| layer.heading(p[0], p[1])).collect();
    let mut rays = Vec::with_capacity(points.len() + 32);
    for (i, &p) in points.iter().enumerate() {
        let before = if i > 0 { headings[i - 1] } else { headings[0] };
        let after = before + wrap_angle(headings.get(i).copied().unwrap_or(before) - before);
        let turn = after - before;
        // Where the wall turns away from the passage, two neighbouring rays would leave a gap: fan out. Where
        // it turns towards the passage they cross, and one ray is enough.
        let count = if -turn * side > RAY_TURN { (turn.abs() / RAY_TURN).ceil() as usize } else { 0 };
        if count > 0 {
            for k in 0..=count {
                rays.push((p, before + turn * k as f64 / count as f64 + side * FRAC_PI_2));
            }
            continue;
        }
        // The slope of the parabola through three points.
        let (a, b) = (
            if i > 0 { layer.segment_length(points[i - 1], p) } else { 1.0 },
            points.get(i + 1).map_or(1.0, |&q| layer.segment_length(p, q)),
        );
        let heading = before + turn * a / (a + b);
        rays.push((p, heading + side * FRAC_PI_2));
    }
    rays
}

/// y of a line at `x`; beyond its ends that of the nearer end. x grows along the line.
pub fn y_at(line: &[LayerPoint], x: f64) -> f64 {
    let after = line.partition_point(|p| p.x < x);
    if after == 0 {
        return line.first().map_or(0.0, |p| p.y);
    }
    if after == line.len() {
        return line[after - 1].y;
    }
    let (a, b) = (line[after - 1], line[after]);
    a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x).max(1e-12)
}

impl LayerWalls {
    /// The walls of `channel` on `layer`, each extended as a geodesic by `beyond` mm past the ends of the
    /// layer, and further where its rays need that to cover the whole channel. They are traced `raised` mm
    /// above the layer: at the height of the centre of a ball end, whose distance from the wall is what
    /// counts. Between two rays an offset of an extension is at most about `sag` mm beside a straight line.
    /// `None` where a wall does not cross the layer.
    pub fn from_part(
        part: &Impeller,
        channel: &Channel,
        layer: &LayerSurface,
        beyond: f64,
        raised: f64,
        sag: f64,
    ) -> Option<Self> {
        let [a, b] = &channel.full.walls;
        let low = trace_flank(layer, a.side(), raised)?;
        let high = trace_flank(layer, b.side(), raised)?;
        // The wall at λ = 1 is within one pitch after the other.
        let middle = 0.5 * (layer.from + layer.to);
        let gap = y_at(&high, middle) - y_at(&low, middle);
        let pitch = part.pitch().abs();
        let shift = wrap_angle(gap - 0.5 * pitch) + 0.5 * pitch - gap;
        let high: Vec<LayerPoint> = high.iter().map(|p| LayerPoint { x: p.x, y: p.y + shift }).collect();
        if [layer.from, middle, layer.to].iter().any(|&x| y_at(&high, x) <= y_at(&low, x)) {
            return None;
        }
        let numbered = channel.splitters.iter().enumerate();
        let splitters = numbered.filter_map(|(number, walls)| {
            trace_splitter(layer, (number, walls), (&low, &high), beyond, raised, sag)
        });
        let splitters = splitters.collect();
        let reach = |line: &[LayerPoint], end: usize, x: f64| {
            let next = if end == 0 { 1 } else { end - 1 };
            let slope = layer.heading(line[end.min(next)], line[end.max(next)]).tan().abs().min(3.0);
            let width = layer.radius(x).0 * (y_at(&high, x) - y_at(&low, x));
            beyond + slope * width
        };
        let ends = |line: &[LayerPoint]| [reach(line, 0, layer.from), reach(line, line.len() - 1, layer.to)];
        let turning = [&low, &high].into_iter().any(|line| turns_back(layer, line, ends(line)[0], sag));
        let max_turn_rad = if turning { MAX_ANGLE_TO_MERIDIAN } else { FRAC_PI_2 };
        let wall = |line: &[LayerPoint], blade: &BladeSide, flank: &BladeSide, side: f64| {
            let points = extended(layer, line, ends(line), max_turn_rad, sag);
            if !turning {
                return LayerWall::new(layer, points, side);
            }
            let own = points.iter().position(|p| p == &line[0]).unwrap_or(0);
            let mut all = trace_nose(layer, blade, flank, line[0], raised);
            all.extend_from_slice(&points[own..]);
            LayerWall::with_nose(layer, points, &all, side)
        };
        Some(Self {
            low: wall(&low, &part.main.suction, a.side(), 1.0),
            high: wall(&high, &part.main.rotated(part.pitch()).pressure, b.side(), -1.0),
            splitters,
        })
    }
}

impl LayerWalls {
    /// Whether the main blades have rays round their noses.
    pub fn have_noses(&self) -> bool {
        self.low.points.first().is_some_and(|p| p.x < self.low.nose)
    }
}

/// The line of a flank within the layer's ends, x growing.
fn trace_flank(layer: &LayerSurface, side: &BladeSide, raised: f64) -> Option<Vec<LayerPoint>> {
    let (first, last) = side.u_range();
    let traced = |from: f64, to: f64| {
        let lines = (0..=FLANK_LINES).map(|i| from + (to - from) * i as f64 / FLANK_LINES as f64);
        growing(layer.trace(side, lines, 0.0, raised))
    };
    let fits = |line: &Vec<LayerPoint>| line.len() >= 3 && line[1].x < layer.to;
    // A layer that ends beside the nose meets only the straight extension ahead of the flank.
    let line = Some(traced(first, last))
        .filter(fits)
        .or_else(|| Some(traced(first - 0.2, first + 0.1)).filter(fits))?;
    Some(until(line, layer.to))
}

/// Points up to and including the first beyond `to`.
fn until(points: Vec<LayerPoint>, to: f64) -> Vec<LayerPoint> {
    let end = points.iter().position(|p| p.x >= to).map_or(points.len(), |i| i + 1);
    let mut points = points;
    points.truncate(end.max(3));
    points
}

/// Drops the points at which x does not grow.
fn growing(points: Vec<LayerPoint>) -> Vec<LayerPoint> {
    let mut kept: Vec<LayerPoint> = Vec::with_capacity(points.len());
    for p in points {
        if kept.last().is_none_or(|last| p.x > last.x + 1e-9) {
            kept.push(p);
        }
    }
    kept
}

/// The nose of a `blade` ahead of the first point of its `flank` on the layer, from its foremost point on,
/// with growing x.
fn trace_nose(
    layer: &LayerSurface,
    blade: &BladeSide,
    flank: &BladeSide,
    first: LayerPoint,
    raised: f64,
) -> Vec<LayerPoint> {
    let end = flank.u_range().0;
    let lines = (0..NOSE_LINES).map(|i| end * (i as f64 / NOSE_LINES as f64).powi(2));
    let traced = layer.trace(blade, lines, 0.0, raised);
    let foremost = (0..traced.len()).min_by(|&a, &b| traced[a].x.total_cmp(&traced[b].x)).unwrap_or(0);
    let near = |p: &LayerPoint| LayerPoint { x: p.x, y: first.y + wrap_angle(p.y - first.y) };
    let mut points = growing(traced[foremost.min(traced.len())..].iter().map(near).collect());
    points.retain(|p| p.x < first.x - 1e-6);
    points
}

/// Number of steps of an extension of `length` mm: a straight line of x and y as long as a step is at most
/// `sag` mm beside a geodesic, also where the rays from the steps come to the least radius of the layer.
fn extension_steps(layer: &LayerSurface, length: f64, sag: f64) -> f64 {
    let min_radius = layer.radius(layer.from).0.min(layer.radius(layer.to).0);
    let step = (8.0 * sag * min_radius).sqrt();
    let [least, most] = EXTENSION_STEPS;
    (length / step.clamp(least, most)).ceil().max(1.0)
}

/// The geodesic of `length` mm that leaves `from` at `heading` (rad), in steps of an extension, without
/// `from`.
fn extension(layer: &LayerSurface, from: LayerPoint, heading: f64, length: f64, sag: f64) -> Vec<LayerPoint> {
    let steps = extension_steps(layer, length, sag);
    (1..=steps as usize).map(|k| layer.geodesic(from, heading, length * k as f64 / steps).0).collect()
}

/// Length (mm) and initial heading (rad) of the extension ahead of a line that ends `reach` mm beyond the end
/// of the layer.
fn ahead_of(layer: &LayerSurface, line: &[LayerPoint], reach: f64) -> (f64, f64) {
    let back = end_heading(layer, [line[0], line[1], line[2]]);
    ((line[0].x - layer.from).max(0.0) / (-back.cos()).max(0.3) + reach, back)
}

/// Whether a geodesic ahead of a line turns back within `reach` mm of the end of the layer. Ahead of strongly
/// wrapped walls, on a layer that narrows, it does and would run through the channel.
fn turns_back(layer: &LayerSurface, line: &[LayerPoint], reach: f64, sag: f64) -> bool {
    let (length, mut heading) = ahead_of(layer, line, reach);
    let steps = extension_steps(layer, length, sag);
    let mut at = line[0];
    (0..steps as usize).any(|_| {
        (at, heading) = layer.geodesic(at, heading, length / steps);
        heading.cos() >= 0.0
    })
}

/// The line, extended by geodesics until `reach` mm beyond both ends of the layer. Ahead of the leading edge
/// the heading is kept within `max_turn_rad` (rad) of the meridian.
fn extended(
    layer: &LayerSurface,
    line: &[LayerPoint],
    reach: [f64; 2],
    max_turn_rad: f64,
    sag: f64,
) -> Vec<LayerPoint> {
    let n = line.len();
    let (behind, back) = ahead_of(layer, line, reach[0]);
    let run = |from: LayerPoint, heading: f64, length: f64| extension(layer, from, heading, length, sag);
    let mut points = if max_turn_rad < FRAC_PI_2 {
        let steps = extension_steps(layer, behind, sag);
        let mut at = (line[0], back);
        let next = |_| {
            let turn = wrap_angle(at.1 - PI).clamp(-max_turn_rad, max_turn_rad);
            at = layer.geodesic(at.0, PI + turn, behind / steps);
            at.0
        };
        (0..steps as usize).map(next).collect()
    } else {
        run(line[0], back, behind)
    };
    points.reverse();
    points.extend_from_slice(line);
    let ahead = end_heading(layer, [line[n - 1], line[n - 2], line[n - 3]]);
    let missing = (layer.to - line[n - 1].x).max(0.0) / ahead.cos().max(0.3) + reach[1];
    points.extend(run(line[n - 1], ahead, missing));
    points
}

/// Heading (rad) at which a line continues beyond its end, the first of three points: the slope of the
/// parabola through them.
fn end_heading(layer: &LayerSurface, [end, next, third]: [LayerPoint; 3]) -> f64 {
    let (outer, inner) = (layer.heading(next, end), layer.heading(third, next));
    let (a, b) = (layer.segment_length(end, next), layer.segment_length(next, third));
    outer + wrap_angle(outer - inner) * a / (a + b).max(1e-12)
}

/// The outline of a splitter on the layer; `None` where the layer ends before its nose.
fn trace_splitter(
    layer: &LayerSurface,
    (number, walls): (usize, &SplitterWalls),
    (low, high): (&[LayerPoint], &[LayerPoint]),
    beyond: f64,
    raised: f64,
    sag: f64,
) -> Option<LayerSplitter> {
    let lines = || (0..=NOSED_LINES).map(|i| (i as f64 / NOSED_LINES as f64).powi(2));
    let near = |p: &LayerPoint| 0.5 * (y_at(low, p.x) + y_at(high, p.x));
    let side = |side: &BladeSide| {
        let traced = layer.trace(side, lines(), 0.0, raised);
        let shift = traced.last().map_or(0.0, |p| near(p) + wrap_angle(p.y - near(p)) - p.y);
        traced.into_iter().map(|p| LayerPoint { x: p.x, y: p.y + shift }).collect::<Vec<_>>()
    };
    let (facing_low, facing_high) = (side(walls.near.whole_side()), side(walls.far.whole_side()));
    if facing_low.len() < 4 || facing_high.len() < 4 {
        return None;
    }
    let nose = facing_low.iter().chain(&facing_high).copied().min_by(|a, b| a.x.total_cmp(&b.x))?;
    if nose.x >= layer.to {
        return None;
    }
    let (facing_low, facing_high) = (cut_at(facing_low, layer.to), cut_at(facing_high, layer.to));
    let ahead = |line: &[LayerPoint]| {
        let n = line.len();
        let heading = match n {
            2 => layer.heading(line[0], line[1]),
            _ => end_heading(layer, [line[n - 1], line[n - 2], line[n - 3]]),
        };
        let length = beyond + (layer.to - line[n - 1].x).max(0.0) / heading.cos().max(0.3);
        [line, &extension(layer, line[n - 1], heading, length, sag)].concat()
    };
    let (facing_low, facing_high) = (ahead(&facing_low), ahead(&facing_high));
    let mut points: Vec<LayerPoint> = facing_low.iter().rev().copied().collect();
    points.extend(facing_high.iter().skip_while(|p| layer.segment_length(**p, facing_low[0]) < 1e-9));
    Some(LayerSplitter {
        number,
        border: LayerWall::new(layer, points, 1.0),
        nose,
        sides: [growing(facing_low), growing(facing_high)],
    })
}

/// Points from the nose up to and including the first beyond `to`.
fn cut_at(points: Vec<LayerPoint>, to: f64) -> Vec<LayerPoint> {
    let mut points = points;
    let foremost = (0..points.len()).min_by(|&a, &b| points[a].x.total_cmp(&points[b].x)).unwrap_or(0);
    let end = (foremost..points.len()).find(|&i| points[i].x >= to).map_or(points.len(), |i| i + 1);
    points.truncate(end.max(2));
    points
}
