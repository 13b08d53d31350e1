//! Cutter, shank and holder of whole programs against the finished wheel, shank and holder against the
//! standing blank, by points: a check that shares no code with the distances by which plans are made and
//! programs verified.
//!
//! The wheel is a cloud of points of the hub and of every blade, the tool a profile of heights and radii
//! about its axis, and every move a row of poses. A point is never nearer than the surface it is from, so
//! whatever is found is there.

use rayon::prelude::*;
use vanecut::geometry::{Meridional, Point, Vector};
use vanecut::part::Workpiece;
use vanecut::setup::{Setup, Tool};
use vanecut::toolpath::{ClProgram, Motion, Move};

/// Largest distance of neighbouring points of the wheel, in diameters of the rim.
const POINTS_PER_DIAMETER: f64 = 110.0;
/// Largest travel of a tip, and of the far end of the tool, between two poses, mm.
const POSE_SPACING: f64 = 3.0;
/// Clearance that may be missing by the digits of a program, mm.
const ROUNDING: f64 = 2e-3;
/// Depth of a point of a shank or holder in standing stock that is tolerated, mm.
const STOCK_TOLERANCE: f64 = 0.02;
/// The same between two poses of a pass, mm.
const PASS_TOLERANCE: f64 = 0.4;
/// Depth that the solid does not resolve by which passes are planned, in diameters of the rim: slivers that
/// are less are tolerated beside passes.
const UNRESOLVED: f64 = 1.0 / 800.0;
/// Every how many moves of a pass its pose is held against stock.
const POSES_PER_LOOK: usize = 8;

/// A stack of cylinders and cones: `[from, to, lower radius, upper radius]`, and what it is.
type Profile = Vec<([f64; 4], &'static str)>;

/// What the edge of the bottom is: a cylinder within a cutter by its corner radius.
const EDGE: &str = "cutter's edge";
const CUTTER: &str = "cutter";
/// Depth of a cutter in the allowance that is tolerated, mm: that of passes along a wall, and rounding.
const CUTTER_TOLERANCE: f64 = 6e-3;

/// Cutter, shank and holder of a tool as the setup describes them, from its own lists.
fn profile(tool: &Tool) -> Profile {
    let mut profile = Profile::new();
    let shank: f64 = tool.assembly.shank.iter().map(|segment| segment[1]).sum();
    let mut from = tool.assembly.flute_length.unwrap_or(tool.overhang - shank).max(0.0);
    let (corner, radius) = (tool.corner_radius, 0.5 * tool.diameter);
    let top = if tool.assembly.shank.is_empty() { tool.overhang } else { from }.max(corner + 1e-6);
    profile.push(([corner, top, radius - corner, radius - corner], EDGE));
    profile.push(([corner, top, radius, radius], CUTTER));
    for (index, [diameter, length]) in tool.assembly.shank.iter().enumerate() {
        let last = index + 1 == tool.assembly.shank.len();
        let to = if last { tool.overhang } else { (from + length).min(tool.overhang) };
        if to > from {
            profile.push(([from, to, 0.5 * diameter, 0.5 * diameter], "shank"));
            from = to;
        }
    }
    from = tool.overhang;
    for [lower, upper, length] in &tool.assembly.holder {
        profile.push(([from, from + length, 0.5 * lower, 0.5 * upper], "holder"));
        from += length;
    }
    profile
}

/// Distance of the point at `height` and `radius` from a trapezoid of the half plane, 0 inside.
fn distance([from, to, lower, upper]: [f64; 4], height: f64, radius: f64) -> f64 {
    let at = |h: f64| lower + (upper - lower) * ((h - from) / (to - from)).clamp(0.0, 1.0);
    if (from..=to).contains(&height) && radius <= at(height) {
        return 0.0;
    }
    // To the two ends and to the slant, as segments.
    let segment = |a: [f64; 2], b: [f64; 2]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let squared = dx * dx + dy * dy;
        let share = if squared > 0.0 {
            (((height - a[0]) * dx + (radius - a[1]) * dy) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (height - a[0] - share * dx).hypot(radius - a[1] - share * dy)
    };
    let ends = segment([from, 0.0], [from, lower]).min(segment([to, 0.0], [to, upper]));
    ends.min(segment([from, lower], [to, upper]))
}

/// Points of the finished wheel: of the hub, and of the blades.
pub struct WheelPoints {
    hub: Vec<Cluster>,
    blades: Vec<Cluster>,
}

/// Points within a ball.
struct Cluster {
    centre: Point,
    radius: f64,
    points: Vec<Point>,
}

/// Points of a cluster; neighbours in the order in which they are sampled.
const CLUSTER: usize = 50;

/// Points in their order as clusters.
fn clusters(points: &[Point]) -> Vec<Cluster> {
    let cluster = |points: &[Point]| {
        let sum: Vector = points.iter().map(|p| p.coords).sum();
        let centre = Point::from(sum / points.len() as f64);
        let radius = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        Cluster { centre, radius, points: points.to_vec() }
    };
    points.chunks(CLUSTER).map(cluster).collect()
}

impl WheelPoints {
    /// Of the whole wheel of a workpiece.
    pub fn from_workpiece(workpiece: &Workpiece) -> Self {
        let part = &workpiece.part;
        let spacing = 2.0 * part.rim_radius() / POINTS_PER_DIAMETER;
        let curve = part.hub.curve();
        let rings = (curve.length() / spacing).ceil() as usize;
        let mut hub = Vec::new();
        for i in 0..=rings {
            let p = curve.point(curve.length() * i as f64 / rings as f64);
            let around = ((std::f64::consts::TAU * p.r / spacing).ceil() as usize).max(8);
            hub.extend((0..around).map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
                Point::new(p.r * cos, p.r * sin, p.z)
            }));
        }
        let mut blades = Vec::new();
        for side in &workpiece.channel.sides {
            let own: Vec<Point> = (0..=90)
                .flat_map(|i| (0..=24).map(move |j| (i, j)))
                .map(|(i, j)| side.point(f64::from(i) / 90.0, f64::from(j) / 24.0))
                .collect();
            for turn in 0..part.blade_count {
                let (sin, cos) = (part.pitch() * turn as f64).sin_cos();
                blades.extend(
                    own.iter().map(|p| Point::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z)),
                );
            }
        }
        Self { hub: clusters(&hub), blades: clusters(&blades) }
    }

    /// What lacks of allowance and clearance in a pose, mm, and what it is of; of a cutter with this corner
    /// radius.
    fn missing(
        &self,
        (profile, corner): (&Profile, f64),
        setup: &Setup,
        pose: (Point, Vector),
    ) -> Option<(f64, String)> {
        let clearance = |what: &str| match what {
            "shank" => setup.clearances.shank,
            "holder" => setup.clearances.holder,
            EDGE => corner - CUTTER_TOLERANCE,
            _ => -CUTTER_TOLERANCE,
        };
        // Height along the axis, and distance from it.
        let place = |point: &Point| {
            let d = point - pose.0;
            let height = d.dot(&pose.1);
            (height, (d.norm_squared() - height * height).max(0.0).sqrt())
        };
        let mut worst: Option<(f64, String)> = None;
        let stock = &setup.allowances;
        for (points, allowance, of) in
            [(&self.hub, stock.hub_allowance, "hub"), (&self.blades, stock.blade_allowance, "blades")]
        {
            // Whether points within `size` of a place may be too near to a segment: by its height and width
            // alone, as the distance takes far longer.
            let may_lack =
                |([from, to, lower, upper], what): &([f64; 4], &str), place: (f64, f64), size: f64| {
                    let reach = clearance(what) + allowance - ROUNDING + size;
                    place.0 > from - reach && place.0 < to + reach && place.1 < lower.max(*upper) + reach
                };
            let is_near = |cluster: &&Cluster| {
                let place = place(&cluster.centre);
                profile.iter().any(|segment| may_lack(segment, place, cluster.radius))
            };
            for point in points.iter().filter(is_near).flat_map(|cluster| &cluster.points) {
                let place = place(point);
                for (segment, what) in profile.iter().filter(|segment| may_lack(segment, place, 0.0)) {
                    let short = clearance(what) + allowance - distance(*segment, place.0, place.1);
                    if short > ROUNDING && worst.as_ref().is_none_or(|(most, _)| short > *most) {
                        worst = Some((short, format!("{what} {short:.3} mm too near to the {of}")));
                    }
                }
            }
        }
        worst
    }
}

/// Poses along a move, at most [`POSE_SPACING`] apart for every point of the tool.
fn poses(from: &Move, to: &Move, length: f64) -> Vec<(Point, Vector)> {
    let travel = to.tip - from.tip;
    let turn = from.axis.angle(&to.axis);
    let steps = ((travel.norm() + turn * length) / POSE_SPACING).ceil().clamp(1.0, 400.0) as usize;
    let between = |k: usize| {
        let share = k as f64 / steps as f64;
        // By the great circle, as a machine turns.
        let axis = if turn < 1e-9 {
            to.axis
        } else {
            (from.axis * ((1.0 - share) * turn).sin() + to.axis * (share * turn).sin()) / turn.sin()
        };
        (from.tip + travel * share, axis)
    };
    (1..=steps).map(between).collect()
}

/// What the tools of `setup` run into over `program`, one line for each of the first few moves.
pub fn collisions(
    workpiece: &Workpiece,
    points: &WheelPoints,
    setup: &Setup,
    program: &ClProgram,
) -> Vec<String> {
    let tools: Vec<Option<(Tool, Profile)>> = program
        .tools
        .iter()
        .map(|described| {
            let tool = setup.tools.iter().find(|tool| tool.number == described.number)?;
            Some((tool.clone(), profile(tool)))
        })
        .collect();
    let moves = &program.moves;
    let near: Vec<String> = (0..moves.len())
        .into_par_iter()
        .filter_map(|k| {
            let (tool, profile) = tools[moves[k].tool?].as_ref()?;
            let before = k.checked_sub(1).map(|k| &moves[k]).filter(|before| before.tool == moves[k].tool);
            let length = profile.iter().map(|(segment, _)| segment[1]).fold(0.0, f64::max);
            let poses = poses(before.unwrap_or(&moves[k]), &moves[k], length);
            let worst =
                poses.iter().filter_map(|pose| points.missing((profile, tool.corner_radius), setup, *pose));
            let (_, what) = worst.max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(format!("move {k}, {:?}: {what}", moves[k].motion))
        })
        .collect();
    let mut found = near;
    found.extend(in_stock(workpiece, &tools, program));
    found.truncate(6);
    found
}

/// Poses under feed at which a shank or holder that is wider than its cutter is in stock which stands: within
/// the blank, and in the way of no cutter up to there. Along passes only every few poses are checked; the
/// stock between two of them is less than [`PASS_TOLERANCE`].
fn in_stock(workpiece: &Workpiece, tools: &[Option<(Tool, Profile)>], program: &ClProgram) -> Vec<String> {
    let moves = &program.moves;
    let mut columns: Vec<(Point, Vector, f64)> = Vec::new();
    let mut looked_at = Vec::new();
    for k in 1..moves.len() {
        let (before, step) = (&moves[k - 1], &moves[k]);
        let Some(index) = step.tool else { continue };
        if !matches!(step.motion, Motion::Feed(_)) || before.tool != step.tool {
            continue;
        }
        let travel = step.tip - before.tip;
        let is_axial = step.is_axial_from(before);
        if is_axial && travel.dot(&step.axis) >= 0.0 {
            continue;
        }
        let radius = 0.5 * program.tools[index].diameter;
        if is_axial {
            columns.push((step.tip, step.axis, radius + STOCK_TOLERANCE));
        } else {
            let all = poses(before, step, 0.0);
            columns.extend(all.into_iter().map(|(tip, axis)| (tip, axis, radius + PASS_TOLERANCE)));
        }
        if tools[index].is_some() && (is_axial || k % POSES_PER_LOOK == 0) {
            looked_at.push((k, columns.len()));
        }
    }
    let unresolved = UNRESOLVED * 2.0 * workpiece.part.rim_radius();
    let stands = |&(k, count): &(usize, usize)| {
        let (tool, profile) = tools[moves[k].tool?].as_ref()?;
        let earlier = &columns[..count];
        // A segment no wider than the cutter stays within the space that the cutter has already cleared.
        let wider = |segment: &[f64; 4]| segment[2].max(segment[3]) > tool.radius();
        profile.iter().filter(|(segment, _)| wider(segment)).find_map(|(segment, what)| {
            let (p, depth) = standing_point(workpiece, segment, &moves[k], earlier)?;
            let is_plunge = moves[k].is_axial_from(&moves[k - 1]);
            if !is_plunge && depth < unresolved {
                return None;
            }
            Some(format!("move {k}: {what} {depth:.3} mm deep in standing stock at {p:.2?}"))
        })
    };
    looked_at.par_iter().filter_map(stands).collect()
}

/// A point of the surface of a segment that is in the blank and in none of the columns, and how deep it is in
/// what they leave of it, mm.
fn standing_point(
    workpiece: &Workpiece,
    [from, to, lower, upper]: &[f64; 4],
    step: &Move,
    columns: &[(Point, Vector, f64)],
) -> Option<(Point, f64)> {
    let (e1, e2) = across(&step.axis);
    (0..=6).flat_map(|i| (0..24).map(move |j| (i, j))).find_map(|(i, j)| {
        let share = f64::from(i) / 6.0;
        let radius = lower + (upper - lower) * share - STOCK_TOLERANCE;
        let (sin, cos) = (std::f64::consts::TAU * f64::from(j) / 24.0).sin_cos();
        let p = step.tip + step.axis * (from + (to - from) * share) + (e1 * cos + e2 * sin) * radius;
        // How far a point is outside of a column.
        let outside = |(tip, axis, radius): &(Point, Vector, f64)| {
            let d = p - tip;
            let height = d.dot(axis);
            let off = (d.norm_squared() - height * height).max(0.0).sqrt();
            (-STOCK_TOLERANCE - height).max(off - radius)
        };
        let depth = workpiece.blank.depth(Meridional::from_point(&p));
        if depth <= STOCK_TOLERANCE || columns.iter().any(|column| outside(column) < 0.0) {
            return None;
        }
        Some((p, columns.iter().map(outside).fold(depth, f64::min)))
    })
}

/// Two unit vectors across an axis.
fn across(axis: &Vector) -> (Vector, Vector) {
    let off = if axis.x.abs() < 0.7 { Vector::x() } else { Vector::y() };
    let e1 = axis.cross(&off).normalize();
    (e1, axis.cross(&e1))
}

/// Numbers from 0 to 1, from a seed.
pub struct Dice(u64);

impl Dice {
    /// Dice of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bd1_e995)
    }

    /// A number between two others.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// The tool with any assembly at all: far too short or too long, with a shank up to twice as thick as the
/// cutter or none, and a holder of cones either way or none.
#[allow(dead_code, reason = "not every test that includes this draws them")]
pub fn with_wild_assembly(tool: &Tool, dice: &mut Dice) -> Tool {
    let mut tool = tool.clone();
    let d = tool.diameter;
    tool.overhang = (tool.overhang * dice.between(0.35, 1.0) * dice.between(1.0, 2.5)).max(1.2 * d);
    let flutes = (d * dice.between(0.6, 3.0)).clamp(0.6 * d, 0.8 * tool.overhang);
    tool.assembly.flute_length = Some(flutes);
    let left = tool.overhang - flutes;
    let neck = d * dice.between(0.8, 1.0);
    tool.assembly.shank = match dice.between(0.0, 4.0) as u32 {
        0 => Vec::new(),
        1 => vec![[neck, left]],
        2 => vec![[neck, left * dice.between(0.3, 0.8)], [d * dice.between(1.0, 2.0), left]],
        _ => vec![[d * dice.between(1.05, 2.0), left]],
    };
    let mut lower = d * dice.between(1.1, 3.0);
    for _ in 0..dice.between(0.2, 3.99) as usize {
        let upper = lower * dice.between(0.5, 2.0);
        tool.assembly.holder.push([lower, upper, d * dice.between(0.5, 6.0)]);
        lower = upper * dice.between(1.0, 1.5);
    }
    tool
}

/// The tool with a neck or shank, and a holder of one to three pieces, some of them so thick or so low that
/// they are in the way somewhere.
pub fn with_random_assembly(tool: &Tool, dice: &mut Dice) -> Tool {
    let mut tool = tool.clone();
    let d = tool.diameter;
    tool.overhang = (tool.overhang * dice.between(0.75, 1.2)).round().max(2.0);
    let flutes = (d * dice.between(0.5, 1.5)).min(0.5 * tool.overhang);
    tool.assembly.flute_length = Some(flutes);
    let neck = dice.between(0.8, 0.98) * d;
    let shank = if dice.between(0.0, 1.0) < 0.5 { neck } else { d * dice.between(1.0, 1.25) };
    let length = (tool.overhang - flutes) * dice.between(0.4, 0.9);
    tool.assembly.shank = vec![[neck, length], [shank, tool.overhang - flutes - length]];
    let mut lower = d * dice.between(1.2, 2.0);
    for _ in 0..dice.between(1.0, 3.99) as usize {
        let upper = lower + d * dice.between(-0.1, 1.0);
        tool.assembly.holder.push([lower, upper, d * dice.between(0.6, 3.0)]);
        lower = upper;
    }
    tool
}
