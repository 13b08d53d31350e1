//! Closed profile loops, split into suction and pressure side.
//!
//! Edges: the points marked `le` and `te` (or `te1`, `te2` at a blunt trailing edge) if there are marks.
//! Otherwise the loop's first point, which by convention is an edge, if it is within 5 % of the loop's
//! upstream or downstream end, and the extreme point at the other end. Two corners of more than 45° near
//! the downstream end make a blunt trailing edge.
//!
//! Sides: the file does not give the sense of rotation. An impeller's blades wrap against the sense of
//! rotation from LE to TE, so the sense is derived from the main blade's wrap; the pressure side is the
//! leading one, for main blades and splitters alike. A part whose main blade has no wrap is assumed to
//! turn towards increasing θ.

use std::path::Path;

use super::super::InputError;
use super::super::source::{JOINT, MAX_POINTS, Source, name_of, number, read_bytes, text};
use super::inf::TurboGridFrame;
use crate::error::ErrorCode;
use crate::geometry::Point;
use crate::part::{BladeDescription, Meridional};

/// Share of a loop's meridional length within which a point counts as one of its ends.
const EDGE_SHARE: f64 = 0.05;
/// Minimum turning angle at a corner of a blunt trailing edge, rad.
const CORNER: f64 = std::f64::consts::FRAC_PI_4;
/// Maximum number of flowpath points used to measure how far downstream a point is.
const FLOWPATH_POINTS: usize = 200;

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    None,
    Le,
    Te,
    Te1,
    Te2,
}

/// One closed profile loop.
struct ProfileLoop {
    line: usize,
    points: Vec<(Point, Mark)>,
}

/// The loops of a blade, hub to tip.
struct ProfileBlade {
    name: String,
    line: usize,
    loops: Vec<ProfileLoop>,
}

/// Reads main blade and splitters of a profile file; `line` is its line in the `.inf` file.
pub(super) fn read(
    path: &Path,
    line: usize,
    frame: TurboGridFrame,
    flowpaths: [&[Meridional]; 2],
) -> Result<(BladeDescription, Vec<BladeDescription>), InputError> {
    let name = name_of(path);
    let source = Source::new(&name, ErrorCode::PartFile);
    let bytes = read_bytes(path)?;
    let mut blades = blades(source, text(source, &bytes)?, frame)?;
    for blade in &blades {
        if blade.loops.len() < 2 {
            let what = format!("the blade has {} profile(s)", blade.loops.len());
            return Err(source
                .fault(blade.line, what, "give two or more, hub to tip")
                .with_code(ErrorCode::BladeSections));
        }
    }
    if blades.is_empty() {
        return Err(source
            .fault(0, "holds no profile", "give `# Profile` headers with points below")
            .with_code(ErrorCode::BladeSections));
    }
    let main = blades.iter().position(|blade| blade.name.contains("main")).unwrap_or(0);
    let main = blades.remove(main);
    let ruler = Ruler::new(flowpaths);
    let main = SplitBlade::new(source, main, &ruler)?;
    let turns = if main.wrap() > 0.0 { -1.0 } else { 1.0 };
    let splitters = blades
        .into_iter()
        .map(|blade| Ok(SplitBlade::new(source, blade, &ruler)?.described(turns, line)))
        .collect::<Result<_, InputError>>()?;
    Ok((main.described(turns, line), splitters))
}

fn blades(source: Source<'_>, text: &str, frame: TurboGridFrame) -> Result<Vec<ProfileBlade>, InputError> {
    let mut blades: Vec<ProfileBlade> = Vec::new();
    let mut span = f64::NEG_INFINITY;
    let mut points = 0;
    for (at, row) in text.lines().enumerate() {
        let (line, row) = (at + 1, row.trim());
        if let Some(name) = row.strip_prefix("##") {
            blades.push(ProfileBlade { name: name.trim().to_lowercase(), line, loops: Vec::new() });
            span = f64::NEG_INFINITY;
        } else if let Some(percent) = profile_header(row) {
            // Without names, a span that does not increase starts the next blade.
            let falls = percent.is_some_and(|percent| percent <= span);
            if falls || blades.is_empty() {
                blades.push(ProfileBlade { name: String::new(), line, loops: Vec::new() });
            }
            span = percent.unwrap_or(span);
            if let Some(blade) = blades.last_mut() {
                blade.loops.push(ProfileLoop { line, points: Vec::new() });
            }
        } else if !row.is_empty() && !row.starts_with(['#', '!']) {
            let (point, token) = frame.point(source, line, row)?;
            let mark = match token.to_ascii_lowercase().as_str() {
                "le" | "le1" => Mark::Le,
                "te" => Mark::Te,
                "te1" => Mark::Te1,
                "te2" => Mark::Te2,
                _ => Mark::None,
            };
            let Some(last) = blades.last_mut().and_then(|blade| blade.loops.last_mut()) else {
                return Err(source.fault(line, "a point before the first `# Profile`", "add the header"));
            };
            points += 1;
            if points > MAX_POINTS {
                return Err(source
                    .fault(line, "holds more than 1,000,000 points", "give fewer points")
                    .with_code(ErrorCode::FileTooLarge));
            }
            match last.points.last_mut() {
                Some((before, old)) if (*before - point).norm() < JOINT => {
                    if *old == Mark::None {
                        *old = mark;
                    }
                }
                _ => last.points.push((point, mark)),
            }
        }
    }
    blades.retain(|blade| !blade.loops.is_empty());
    Ok(blades)
}

/// Measures how far downstream a point is: the arc-length fraction of the nearest points on hub and
/// shroud.
struct Ruler {
    curves: [Vec<(Meridional, f64)>; 2],
}

impl Ruler {
    fn new(flowpaths: [&[Meridional]; 2]) -> Self {
        let curves = flowpaths.map(|points| {
            let stride = points.len().div_ceil(FLOWPATH_POINTS).max(1);
            let last = points.last().filter(|_| (points.len() - 1) % stride != 0);
            let mut curve: Vec<(Meridional, f64)> = Vec::new();
            for p in points.iter().step_by(stride).chain(last) {
                let length = curve.last().map_or(0.0, |(q, s)| s + (p.r - q.r).hypot(p.z - q.z));
                curve.push((*p, length));
            }
            let total = curve.last().map_or(1.0, |(_, s)| s.max(JOINT));
            curve.iter_mut().for_each(|(_, s)| *s /= total);
            curve
        });
        Self { curves }
    }

    /// Arc-length fraction of `p`, interpolated at `span` between hub (0) and shroud (1).
    fn measure(&self, p: &Point, span: f64) -> f64 {
        let at = Meridional { r: p.x.hypot(p.y), z: p.z };
        let [hub, shroud] = self.curves.each_ref().map(|curve| nearest(curve, at));
        hub * (1.0 - span) + shroud * span
    }
}

fn nearest(curve: &[(Meridional, f64)], p: Meridional) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for pair in curve.windows(2) {
        let [(a, sa), (b, sb)] = pair else { continue };
        let (dr, dz) = (b.r - a.r, b.z - a.z);
        let length = dr * dr + dz * dz;
        let t = if length > 0.0 { ((p.r - a.r) * dr + (p.z - a.z) * dz) / length } else { 0.0 };
        let t = t.clamp(0.0, 1.0);
        let distance = (p.r - a.r - t * dr).hypot(p.z - a.z - t * dz);
        if distance < best.0 {
            best = (distance, sa + t * (sb - sa));
        }
    }
    best.1
}

/// A blade whose loops are split at their edges.
struct SplitBlade {
    /// Per section: the sides of smaller and of larger θ, LE → TE.
    sides: Vec<[Vec<Point>; 2]>,
}

impl SplitBlade {
    fn new(source: Source<'_>, blade: ProfileBlade, ruler: &Ruler) -> Result<Self, InputError> {
        let steps = (blade.loops.len() - 1).max(1) as f64;
        let sides = blade.loops.into_iter().enumerate();
        let sides = sides.map(|(k, profile)| split(source, profile, ruler, k as f64 / steps));
        Ok(Self { sides: sides.collect::<Result<_, _>>()? })
    }

    /// Change of θ from LE to TE, summed over the sides of all sections, rad.
    fn wrap(&self) -> f64 {
        let turn = |pair: &[Point]| match pair {
            [a, b] => (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y),
            _ => 0.0,
        };
        self.sides.iter().flatten().map(|side| side.windows(2).map(turn).sum::<f64>()).sum()
    }

    /// The blade as suction and pressure sections; `turns` is +1 if the wheel turns towards increasing θ,
    /// −1 otherwise.
    fn described(self, turns: f64, line: usize) -> BladeDescription {
        let (small, large) = self.sides.into_iter().map(|[small, large]| (small, large)).unzip();
        let (suction, pressure) = if turns > 0.0 { (small, large) } else { (large, small) };
        BladeDescription::Sections { suction, pressure, line }
    }
}

/// Splits a loop at its edges into the sides of smaller and of larger θ.
fn split(
    source: Source<'_>,
    mut profile: ProfileLoop,
    ruler: &Ruler,
    span: f64,
) -> Result<[Vec<Point>; 2], InputError> {
    let line = profile.line;
    let closes = match profile.points.as_slice() {
        [(first, _), .., (last, _)] => (first - last).norm() < JOINT.max(1e-9 * first.coords.norm()),
        _ => false,
    };
    if closes
        && let Some((_, mark)) = profile.points.pop()
        && let Some(first) = profile.points.first_mut().filter(|first| first.1 == Mark::None)
    {
        first.1 = mark;
    }
    let n = profile.points.len();
    if n < 4 {
        let what = format!("the profile has {n} distinct point(s)");
        return Err(source
            .fault(line, what, "give a closed loop of four or more")
            .with_code(ErrorCode::BladeSections));
    }
    let m: Vec<f64> = profile.points.iter().map(|(p, _)| ruler.measure(p, span)).collect();
    let (le, te) = edges(&profile.points, &m);
    let points: Vec<Point> = profile.points.into_iter().map(|(p, _)| p).collect();
    // Counted from the leading edge, the loop reaches the trailing edge at index `a` and leaves it at `b`.
    let from_le = |k: usize| (k + n - le) % n;
    let (a, b) = (from_le(te.0).min(from_le(te.1)), from_le(te.0).max(from_le(te.1)));
    if a == 0 {
        return Err(source
            .fault(line, "leading and trailing edge of the profile are one point", "mark le and te")
            .with_code(ErrorCode::BladeSections));
    }
    let at = |k: usize| points.get((le + k) % n).copied();
    let forward: Vec<Point> = (0..=a).filter_map(at).collect();
    let backward: Vec<Point> = (b..=n).rev().filter_map(at).collect();
    // Shoelace area in the (m, θ) plane: if counter-clockwise, the forward side has the smaller θ.
    let mut theta = 0.0;
    let mut area = 0.0;
    for k in 0..n {
        let (Some(p), Some(q)) = (at(k), at(k + 1)) else { continue };
        let turn = (p.x * q.y - p.y * q.x).atan2(p.x * q.x + p.y * q.y);
        let rise = |k: usize| m.get((le + k) % n).copied().unwrap_or_default();
        area -= (theta + turn / 2.0) * (rise(k + 1) - rise(k));
        theta += turn;
    }
    Ok(if area > 0.0 { [forward, backward] } else { [backward, forward] })
}

/// Index of the leading edge and the two of the trailing edge (equal unless it is blunt).
fn edges(points: &[(Point, Mark)], m: &[f64]) -> (usize, (usize, usize)) {
    let marked = |mark: Mark| points.iter().position(|(_, found)| *found == mark);
    let extreme = |sign: f64| {
        let by = |a: &(usize, &f64), b: &(usize, &f64)| (sign * a.1).total_cmp(&(sign * b.1));
        m.iter().enumerate().max_by(by).map_or(0, |(k, _)| k)
    };
    let (low, high) = (extreme(-1.0), extreme(1.0));
    let value = |k: usize| m.get(k).copied().unwrap_or_default();
    let share = (value(high) - value(low)) * EDGE_SHARE;
    let le = marked(Mark::Le).unwrap_or(if value(0) <= value(low) + share { 0 } else { low });
    let te = match (marked(Mark::Te), marked(Mark::Te1), marked(Mark::Te2)) {
        (Some(te), _, _) => (te, te),
        (None, Some(one), Some(two)) => (one, two),
        (None, Some(te), None) | (None, None, Some(te)) => (te, te),
        (None, None, None) => {
            let near = |k: usize| value(k) >= value(high) - share;
            let corners: Vec<usize> =
                (0..m.len()).filter(|k| near(*k) && turn_at(points, *k) > CORNER).collect();
            match corners.as_slice() {
                [one, two] => (*one, *two),
                _ if near(0) => (0, 0),
                _ => (high, high),
            }
        }
    };
    (le, te)
}

/// Turning angle of the loop at point `k`, rad.
fn turn_at(points: &[(Point, Mark)], k: usize) -> f64 {
    let n = points.len();
    let at = |k: usize| points.get(k % n).map_or_else(Point::origin, |(p, _)| *p);
    (at(k) - at(k + n - 1)).angle(&(at(k + 1) - at(k)))
}

/// The span in percent of a section header `# Profile 1 at 20.00%`, if the line is one.
fn profile_header(line: &str) -> Option<Option<f64>> {
    let words = line.strip_prefix('#').filter(|rest| !rest.starts_with('#'))?;
    if !words.trim_start().get(..7).is_some_and(|word| word.eq_ignore_ascii_case("profile")) {
        return None;
    }
    let last = words.split_whitespace().last().unwrap_or_default();
    Some(last.strip_suffix('%').and_then(|percent| number(percent).ok()))
}
