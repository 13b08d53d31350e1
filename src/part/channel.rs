//! A channel: the space between neighbouring blades, with its coordinates (s, λ, η).

use std::ops::Range;

use super::impeller::{Impeller, sides_around_channel};
use super::side::BladeSide;
use crate::geometry::{Meridional, Point, Vector, norm2, wrap_angle};

/// s on the hub at which splitters are put in order, from the rim inwards.
const ORDER_AT: [f64; 3] = [1.0, 0.97, 0.9];

/// One wall of a passage: the flank of a blade side (without its rounded ends), extended linearly beyond LE,
/// TE, hub and shroud.
#[derive(Clone, Debug)]
pub struct Wall {
    side: BladeSide,
    /// The complete side, rounded ends included.
    whole: BladeSide,
    /// s of the wall's foot on the hub at even steps of u over [0, u of its end]: start values of Newton's
    /// method.
    starts: Vec<f64>,
    /// First and last s up to which the linear extension of the flank is of use, at even steps of η over
    /// [0, 1]; `None` where all of it is.
    limits: [Option<Vec<f64>>; 2],
}

/// Steps of η at which [`Wall::limits`] are kept.
const LIMIT_STEPS: usize = 8;
/// Step of s in which a limit is looked for.
const LIMIT_STEP: f64 = 0.01;
/// Distance in s beyond the channel up to which that is done.
const LIMIT_REACH: f64 = 0.3;
/// Step in s by which a point of the extension is looked for nearer to the flank than a limit.
const LIMIT_MARGIN: f64 = 2e-3;
/// Number of such steps.
const LIMIT_TRIES: usize = 30;
/// Distance across the meridional direction per distance along it beyond which an extension is too steep to
/// be followed: 76° from the meridional plane.
const MAX_STEEPNESS: f64 = 4.0;

/// Angle of a wall at a meridional point, with derivatives.
#[derive(Clone, Copy, Debug)]
pub struct WallPoint {
    /// θ, rad.
    pub theta: f64,
    /// ∂θ/∂s and ∂θ/∂η, rad.
    pub theta_s: f64,
    /// See `theta_s`.
    pub theta_eta: f64,
    /// Parameter along the blade side, LE 0 … TE 1.
    pub u: f64,
    /// Parameter across the blade side, hub 0 … shroud 1.
    pub v: f64,
}

/// Angle of a wall at a point of the meridional plane, with its slope there.
#[derive(Clone, Copy, Debug)]
pub struct WallAngle {
    /// θ, rad.
    pub theta: f64,
    /// ∂θ/∂r and ∂θ/∂z, rad/mm.
    pub by_r: f64,
    /// See `by_r`.
    pub by_z: f64,
    /// Parameter along the blade side, LE 0 … TE 1.
    pub u: f64,
    /// Parameter across the blade side, hub 0 … shroud 1.
    pub v: f64,
}

impl Wall {
    fn new(part: &Impeller, side: &BladeSide) -> Self {
        let (whole, side) = (side.clone(), side.flank());
        let (_, end) = side.u_range();
        let starts = (0..=32)
            .map(|i| {
                let foot = Meridional::from_point(&side.point(end * f64::from(i) / 32.0, 0.0));
                part.hub.s_at(part.hub.curve().project(foot).0)
            })
            .collect();
        let mut wall = Self { side, whole, starts, limits: [None, None] };
        wall.limits = [-1.0, 1.0].map(|outward| {
            let at = |j: usize| wall.limit(part, j as f64 / LIMIT_STEPS as f64, outward);
            let found: Vec<(f64, bool)> = (0..=LIMIT_STEPS).map(at).collect();
            found.iter().any(|(_, ends)| *ends).then(|| found.iter().map(|(s, _)| *s).collect())
        });
        wall
    }

    /// The last s that the extension of the flank at `eta` reaches without getting too steep, beyond the
    /// leading (`outward` −1) or the trailing edge (1), and whether it ends there or only the search does.
    ///
    /// The tangent of a flank that runs nearly across the meridional direction leaves the flow path before it
    /// gets further along it.
    fn limit(&self, part: &Impeller, eta: f64, outward: f64) -> (f64, bool) {
        let (begin, end) = self.side.u_range();
        let middle = Meridional::from_point(&self.side.point(0.5 * (begin + end), eta));
        let on = |path: &super::Flowpath| path.s_at(path.curve().project(middle).0);
        // Between the values at hub and shroud: anywhere on the flank will do.
        let from = (1.0 - eta) * on(&part.hub) + eta * on(&part.shroud);
        let s_at = |i: usize| from + outward * LIMIT_STEP * i as f64;
        let is_of_use = |s: f64| {
            self.on_extension(part, s, eta).is_some_and(|place| {
                let is_flank = (begin..=end).contains(&place.u);
                is_flank || self.steepness(part, (s, eta), &place) <= MAX_STEEPNESS
            })
        };
        let to = if outward < 0.0 { -LIMIT_REACH } else { 1.0 + LIMIT_REACH };
        let steps = ((to - from).abs() / LIMIT_STEP) as usize + 1;
        let Some(lost) = (0..=steps).find(|&i| !is_of_use(s_at(i))).filter(|&lost| lost > 0) else {
            return (s_at(steps), false);
        };
        let (mut inside, mut outside) = (s_at(lost - 1), s_at(lost));
        for _ in 0..20 {
            let middle = 0.5 * (inside + outside);
            if is_of_use(middle) { inside = middle } else { outside = middle }
        }
        (inside, true)
    }

    /// Distance across the meridional direction per distance along it at (s, η).
    fn steepness(&self, part: &Impeller, (s, eta): (f64, f64), place: &WallPoint) -> f64 {
        let (by_r, by_z) = along_path(part, s, eta);
        (part.meridional(s, eta).r * place.theta_s / norm2(by_r, by_z)).abs()
    }

    /// The flank as a surface.
    pub fn side(&self) -> &BladeSide {
        &self.side
    }

    /// The complete side of the finished blade, rounded ends included.
    pub fn whole_side(&self) -> &BladeSide {
        &self.whole
    }

    /// Angles about Z of the ends of the ruling between `s[0]` on the hub and `s[1]` on the shroud, each
    /// moved by `offset` mm along the surface of hub or shroud, in the direction of increasing θ where it is
    /// positive, rad. `None` where the wall does not extend to these s.
    pub fn ruling_offset(&self, part: &Impeller, s: [f64; 2], offset: f64) -> Option<[f64; 2]> {
        let (foot, top) = (self.at(part, s[0], 0.0)?, self.at(part, s[1], 1.0)?);
        let moved = |r: f64, theta_s: f64, length: f64| {
            let slope = r * theta_s / length;
            offset * (1.0 + slope * slope).sqrt().min(MAX_STEEPNESS) / r.max(1e-6)
        };
        let [hub, shroud] = [part.hub.point(s[0]).r, part.shroud.point(s[1]).r];
        Some([
            foot.theta + moved(hub, foot.theta_s, part.hub.length()),
            foot.theta
                + wrap_angle(top.theta - foot.theta)
                + moved(shroud, top.theta_s, part.shroud.length()),
        ])
    }

    /// Whether `place` is on the blade itself and not on its linear extension beyond LE or TE.
    pub fn is_blade_at(&self, place: &WallPoint) -> bool {
        const TOLERANCE_U: f64 = 0.02;
        (-TOLERANCE_U..=1.0 + TOLERANCE_U).contains(&place.u)
    }

    /// The wall at (s, η). Where the linear extension of the flank does not reach it, or only after turning
    /// far across the meridional direction, the wall goes on along that direction. `None` far from any place
    /// at which Newton's method converges.
    pub fn at(&self, part: &Impeller, s: f64, eta: f64) -> Option<WallPoint> {
        let limit = |end: usize| self.limits[end].as_ref().map(|limits| interpolated(limits, eta));
        let (limit, inward, is_beyond) = match (limit(0), limit(1)) {
            (Some(first), _) if s < first => (first, 1.0, true),
            (_, Some(last)) if s > last => (last, -1.0, true),
            _ => match self.on_extension(part, s, eta) {
                Some(place) => return Some(place),
                None => (s, if s < 0.5 { 1.0 } else { -1.0 }, false),
            },
        };
        // Limits are known at a few η only, and Newton's method may fail close to one.
        let mut near = (0..=LIMIT_TRIES).map(|i| limit + inward * LIMIT_MARGIN * i as f64);
        let (found, place) = near.find_map(|s| Some((s, self.on_extension(part, s, eta)?)))?;
        let (begin, end) = self.side.u_range();
        // Further from the flank in u as well, so that `is_blade_at` gets false.
        let off = if inward > 0.0 { place.u.min(begin) } else { place.u.max(end) };
        let u = off - inward * (s - found).abs();
        let is_on_flank = begin < place.u && place.u < end;
        (is_beyond || !is_on_flank).then_some(WallPoint { theta_s: 0.0, u, ..place })
    }

    /// The flank or its linear extension at (s, η), by Newton's method on its meridional image. `None` where
    /// that does not converge, as where the extension does not reach (s, η).
    fn on_extension(&self, part: &Impeller, s: f64, eta: f64) -> Option<WallPoint> {
        let wanted = part.meridional(s, eta);
        let n = self.starts.len() - 1;
        let (begin, end) = self.side.u_range();
        let bracket = self.starts.windows(2).position(|w| w[0] <= s && s <= w[1]);
        let first = self.starts[0];
        let u = match bracket {
            Some(i) => {
                let share = (s - self.starts[i]) / (self.starts[i + 1] - self.starts[i]).max(1e-12);
                end * (i as f64 + share) / n as f64
            }
            None if s < first => begin + (s - first),
            None => end + (s - self.starts[n]),
        };
        let on = self.at_meridional(wanted, u, eta)?;
        // Chain rule: θ depends on (s, η) through the meridional point (r, z).
        let by_s = along_path(part, s, eta);
        let (hub, shroud) = (part.hub.at(s), part.shroud.at(s));
        let by_eta = (shroud.point.r - hub.point.r, shroud.point.z - hub.point.z);
        Some(WallPoint {
            theta: on.theta,
            theta_s: on.by_r * by_s.0 + on.by_z * by_s.1,
            theta_eta: on.by_r * by_eta.0 + on.by_z * by_eta.1,
            u: on.u,
            v: on.v,
        })
    }

    /// The wall at the meridional point `wanted`, by damped Newton steps from (u, v). `None` where they do
    /// not converge.
    pub fn at_meridional(&self, wanted: Meridional, u: f64, v: f64) -> Option<WallAngle> {
        let (mut u, mut v) = (u, v);
        for _ in 0..40 {
            let (p, pu, pv) = self.side.derivatives(u, v);
            let r = norm2(p.x, p.y);
            if r < 1e-9 {
                return None;
            }
            let radial = |d: &Vector| (p.x * d.x + p.y * d.y) / r;
            let turn = |d: &Vector| (p.x * d.y - p.y * d.x) / (r * r);
            let (ru, rv) = (radial(&pu), radial(&pv));
            let determinant = ru * pv.z - rv * pu.z;
            if determinant.abs() < 1e-12 {
                return None;
            }
            let (dr, dz) = (wanted.r - r, wanted.z - p.z);
            if norm2(dr, dz) < 1e-9 {
                let (tu, tv) = (turn(&pu), turn(&pv));
                return Some(WallAngle {
                    theta: p.y.atan2(p.x),
                    by_r: (tu * pv.z - tv * pu.z) / determinant,
                    by_z: (tv * ru - tu * rv) / determinant,
                    u,
                    v,
                });
            }
            let (du, dv) = ((dr * pv.z - rv * dz) / determinant, (ru * dz - pu.z * dr) / determinant);
            let limit = (0.3 / du.abs().max(dv.abs())).min(1.0);
            u += du * limit;
            v += dv * limit;
            if !(u.abs() < 20.0 && v.abs() < 20.0) {
                return None;
            }
        }
        None
    }
}

/// Linear interpolation of `values` at even steps over [0, 1].
fn interpolated(values: &[f64], at: f64) -> f64 {
    let steps = values.len() - 1;
    let at = at.clamp(0.0, 1.0) * steps as f64;
    let low = (at as usize).min(steps - 1);
    values[low] + (at - low as f64) * (values[low + 1] - values[low])
}

/// Derivative by s of the meridional point at (s, η), mm.
fn along_path(part: &Impeller, s: f64, eta: f64) -> (f64, f64) {
    let (hub, shroud) = (part.hub.at(s).tangent, part.shroud.at(s).tangent);
    let (on_hub, on_shroud) = ((1.0 - eta) * part.hub.length(), eta * part.shroud.length());
    (on_hub * hub.r + on_shroud * shroud.r, on_hub * hub.z + on_shroud * shroud.z)
}

/// A point of a channel with its derivatives by the channel coordinates, mm.
#[derive(Clone, Copy, Debug)]
pub struct ChannelPoint {
    /// The point.
    pub point: Point,
    /// ∂/∂s.
    pub by_s: Vector,
    /// ∂/∂λ.
    pub by_lambda: Vector,
    /// ∂/∂η.
    pub by_eta: Vector,
}

/// A passage between two walls: the whole channel, or the part of it beside a splitter.
#[derive(Clone, Debug)]
pub struct Passage {
    /// Wall at λ = 0 (a suction side) and at λ = 1 (a pressure side).
    pub walls: [Wall; 2],
}

impl Passage {
    /// Point at (s, λ, η). λ runs across this passage. `None` where a wall does not reach.
    pub fn point(&self, part: &Impeller, s: f64, lambda: f64, eta: f64) -> Option<ChannelPoint> {
        let [low, high] = [self.walls[0].at(part, s, eta)?, self.walls[1].at(part, s, eta)?];
        let width = passage_angle(low.theta, high.theta, part.pitch());
        let theta = low.theta + lambda * width;
        let (hub, shroud) = (part.hub.at(s), part.shroud.at(s));
        let (lh, ls) = (part.hub.length(), part.shroud.length());
        let middle = part.meridional(s, eta);
        let direction = |r: f64, z: f64, turn: f64| {
            let (sin, cos) = theta.sin_cos();
            Vector::new(r * cos - middle.r * turn * sin, r * sin + middle.r * turn * cos, z)
        };
        let mix = |a: f64, b: f64| low.theta_s * (1.0 - a) + high.theta_s * b;
        let mix_eta = |a: f64, b: f64| low.theta_eta * (1.0 - a) + high.theta_eta * b;
        Some(ChannelPoint {
            point: middle.at_angle(theta),
            by_s: direction(
                (1.0 - eta) * hub.tangent.r * lh + eta * shroud.tangent.r * ls,
                (1.0 - eta) * hub.tangent.z * lh + eta * shroud.tangent.z * ls,
                mix(lambda, lambda),
            ),
            by_lambda: direction(0.0, 0.0, width),
            by_eta: direction(
                shroud.point.r - hub.point.r,
                shroud.point.z - hub.point.z,
                mix_eta(lambda, lambda),
            ),
        })
    }

    /// Angles θ of both walls at (s, η), rad; the one at λ = 1 is unwrapped relative to the one at λ = 0.
    pub fn wall_angles(&self, part: &Impeller, s: f64, eta: f64) -> Option<[f64; 2]> {
        let [low, high] = [self.walls[0].at(part, s, eta)?, self.walls[1].at(part, s, eta)?];
        Some([low.theta, low.theta + passage_angle(low.theta, high.theta, part.pitch())])
    }
}

/// Signed angle from the wall at θ = `low` to the one at θ = `high`, rad; between 0 and `pitch` for any
/// valid part.
pub fn passage_angle(low: f64, high: f64, pitch: f64) -> f64 {
    wrap_angle((high - low) - 0.5 * pitch) + 0.5 * pitch
}

/// A passage divided by a splitter. Of several splitters the longest divides the channel, and the next
/// longest divide the passages beside it.
#[derive(Clone, Debug)]
pub struct Division {
    /// Position of the splitter in [`Channel::splitters`].
    pub splitter: usize,
    /// s of the leading edge of the splitter: on the hub, on the shroud.
    pub s: [f64; 2],
    /// Indices in [`Channel::passages`] of the passages beside it: on the side of the first wall, and of the
    /// second.
    pub passages: [usize; 2],
    /// How shorter splitters divide these passages.
    pub inner: [Option<Box<Self>>; 2],
}

/// Channel 1 of an impeller.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Between the main blades.
    pub full: Passage,
    /// The passages beside the splitter: along the main suction side, and along the main pressure side. Empty
    /// without a splitter.
    pub beside_splitter: Vec<Passage>,
    /// s of the splitter's leading edge: on the hub, on the shroud.
    pub splitter_s: Option<[f64; 2]>,
    /// All passages of the channel: `full`, then those that [`Self::division`] names.
    pub passages: Vec<Passage>,
    /// All splitters of a pitch, from the first wall to the second.
    pub splitters: Vec<SplitterWalls>,
    /// How they divide the channel; `None` without any.
    pub division: Option<Box<Division>>,
    /// Both sides of every blade that bounds or divides the channel, the first main blade, the second, then
    /// the splitters: the surfaces that a tool in it touches before any other.
    pub sides: Vec<BladeSide>,
}

impl Channel {
    /// Channel 1 of `part`.
    ///
    /// ```
    /// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let channel = vanecut::part::Channel::from_part(&part);
    /// assert!(channel.splitter_s.is_none(), "all blades are main blades");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_part(part: &Impeller) -> Self {
        let other = part.main.rotated(part.pitch());
        let low = Wall::new(part, &part.main.suction);
        let high = Wall::new(part, &other.pressure);
        let full = Passage { walls: [low, high] };
        let mut passages = vec![full.clone()];
        let splitters = SplitterWalls::across(part, &full);
        let division = Division::new(&splitters, 0..splitters.len(), &full.walls, &mut passages);
        let first = splitters.iter().find(|splitter| splitter.index == 0);
        let beside_splitter = first.map_or_else(Vec::new, |first| first.passages_beside(&full.walls).into());
        let splitter_s = first.map(|first| first.s);
        Self {
            full,
            beside_splitter,
            splitter_s,
            passages,
            splitters,
            division,
            sides: sides_around_channel(part),
        }
    }

    /// Indices of the [`Self::passages`] at `s`, from the first wall to the second.
    pub fn passages_at(&self, s: f64) -> Vec<usize> {
        let mut found = Vec::new();
        Division::passages_at(self.division.as_deref(), 0, s, &mut found);
        found
    }

    /// The passages beyond all noses, from the first wall to the second.
    pub fn passages_at_outlet(&self) -> Vec<Passage> {
        let [low, high] = &self.full.walls;
        let lows = std::iter::once(low).chain(self.splitters.iter().map(|splitter| &splitter.far));
        let highs = self.splitters.iter().map(|splitter| &splitter.near).chain([high]);
        lows.zip(highs).map(|(low, high)| Passage { walls: [low.clone(), high.clone()] }).collect()
    }
}

/// A splitter as the walls of the passages on either side of it.
#[derive(Clone, Debug)]
pub struct SplitterWalls {
    /// Index of the splitter in [`Impeller::splitters`].
    pub index: usize,
    /// s of its leading edge: on the hub, on the shroud.
    pub s: [f64; 2],
    /// The side that faces the first wall of the channel, and the one that faces the second.
    pub near: Wall,
    /// See `near`.
    pub far: Wall,
}

impl SplitterWalls {
    /// The splitters of a pitch in order from the first wall of the channel `full` to the second.
    pub fn across(part: &Impeller, full: &Passage) -> Vec<Self> {
        let leading = |splitter: &super::Blade, path: &super::Flowpath, v: f64| {
            path.s_at(splitter.leading_edge_on(path.curve(), v))
        };
        let turn = |wall: &Wall| {
            ORDER_AT.iter().find_map(|&s| {
                let (low, at) = (full.walls[0].at(part, s, 0.0)?, wall.at(part, s, 0.0)?);
                Some(part.pitch().signum() * passage_angle(low.theta, at.theta, part.pitch()))
            })
        };
        let mut found: Vec<(f64, Self)> = part
            .splitters
            .iter()
            .enumerate()
            .map(|(index, splitter)| {
                let s = [leading(splitter, &part.hub, 0.0), leading(splitter, &part.shroud, 1.0)];
                let (near, far) = (Wall::new(part, &splitter.pressure), Wall::new(part, &splitter.suction));
                (turn(&near).unwrap_or(0.0), Self { index, s, near, far })
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, walls)| walls).collect()
    }

    /// The passages on either side of it, in the passage between the walls `low` and `high`.
    fn passages_beside(&self, [low, high]: &[Wall; 2]) -> [Passage; 2] {
        [
            Passage { walls: [low.clone(), self.near.clone()] },
            Passage { walls: [self.far.clone(), high.clone()] },
        ]
    }
}

impl Division {
    /// How those `splitters` of which this are the positions, in order, divide the passage between `walls`;
    /// adds the passages to `passages`.
    fn new(
        splitters: &[SplitterWalls],
        positions: Range<usize>,
        walls: &[Wall; 2],
        passages: &mut Vec<Passage>,
    ) -> Option<Box<Self>> {
        let begins = |at: &usize| splitters[*at].s[0];
        let longest = positions.clone().min_by(|a, b| begins(a).total_cmp(&begins(b)))?;
        let first = passages.len();
        let beside = splitters[longest].passages_beside(walls);
        passages.extend(beside.iter().cloned());
        let inner = [
            Self::new(splitters, positions.start..longest, &beside[0].walls, passages),
            Self::new(splitters, longest + 1..positions.end, &beside[1].walls, passages),
        ];
        let s = splitters[longest].s;
        Some(Box::new(Self { splitter: longest, s, passages: [first, first + 1], inner }))
    }

    fn passages_at(division: Option<&Self>, whole: usize, s: f64, found: &mut Vec<usize>) {
        match division {
            Some(Self { s: [hub, shroud], passages, inner, .. }) if s >= hub.min(*shroud) => {
                for (passage, inner) in passages.iter().zip(inner) {
                    Self::passages_at(inner.as_deref(), *passage, s, found);
                }
            }
            _ => found.push(whole),
        }
    }
}
