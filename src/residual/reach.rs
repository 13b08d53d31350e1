//! Floor that no cutter can free: the corner under a wall that leans over the channel.
//!
//! Beside such a wall the flank of a cutter follows the wall, its bottom rests on the far end of its rim, and the
//! near end stands 2R·sin β above the hub; the floor within about 2R·sin β·tan β of the wall's foot stays under
//! stock whatever is planned. Here this distance is found for the wall as it is, row by row.
//!
//! In the frame of the foot (T along the wall, e across into the channel, n along the hub normal; coordinates
//! f, d, z) an axis is a ∝ tan α · T + tan φ · e + n, and in the plane of e and a the wall is a profile w(z). The
//! flank comes as near as it can: beside the tangent plane at every height of the wall that it touches, the axis keeps
//!
//!   d ≥ w + (R + blade allowance)·g,   g² = |∇|² − (∇·a)²,   ∇ = (−∂w/∂f, 1, −∂w/∂z),
//!
//! taken where the axis stands across from the touch, lower by the rise of the near end of the rim over the centre of
//! the bottom. That is exact for a plane. Facing walls bound the axis from the other side alike. The bottom is as low as
//! the hub, to second order about the foot, lets its disc come with the hub allowance. The least d that the disc reaches
//! is minimised over φ, from upright to beyond the steepest slope of the wall, and over α.
//!
//! What bounds an axis besides (holder, limits of tilt, the hub further up, other positions) is left out, and so is
//! the corner radius: floor that is called out of reach is so for every plan, and floor that a plan leaves though
//! it is not called so counts as uncut. Only rays that end under a blade can be out of reach at all.

use rayon::prelude::*;

use super::grid::FloorSource;
use super::overhang::{Face, Over, ROWS, WallTables, rows_beside, s_of_row};
use super::profile::{Flank, Frame, Profile};
use crate::geometry::{Vector, search};
use crate::part::Impeller;

/// A stretch of s and the radius of the cutter that works there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutterStretch {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// R, mm.
    pub radius: f64,
}

impl CutterStretch {
    /// How far `s` lies outside the stretch.
    fn away(&self, s: f64) -> f64 {
        (s - self.from).max(self.to - s).max(0.0)
    }
}

/// tan α that are tried; the best is refined between its neighbours.
const SLOPES: [f64; 7] = [-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6];
/// Tolerance of tan α and tan φ.
const TOLERANCE: f64 = 1e-3;
/// Points of the rim where the bottom may touch the hub.
const RIM_POINTS: usize = 16;
/// Weight of lacking room between the walls, against distance from the foot.
const PENALTY: f64 = 20.0;
/// Lacking room that is forgiven, mm.
const ROOM_TOLERANCE: f64 = 0.05;

/// Out of reach at one row of the tables, per face: angle from its foot, rad; 0 where all is in reach.
type Reach = [f64; 4];

/// Floor out of reach along s.
#[derive(Debug)]
pub(super) struct ReachTables {
    stretches: Vec<(CutterStretch, Vec<Reach>)>,
}

impl ReachTables {
    pub(super) fn new(source: &FloorSource, walls: &WallTables) -> Self {
        let stretch = |&stretch: &CutterStretch| {
            let cutter = Cutter {
                radius: stretch.radius,
                hub_allowance: source.stock.hub_allowance,
                blade_allowance: source.stock.blade_allowance,
            };
            let rows = (0..ROWS).into_par_iter().map(|row| {
                // Rows are read in pairs. Further off no cutter works, and nothing is excused.
                if stretch.away(s_of_row(row)) > 1.0 / ROWS as f64 {
                    return [0.0; 4];
                }
                std::array::from_fn(|face| match walls.faces.get(face) {
                    Some(_) => {
                        Corner::new(source.part, walls, face, row).map_or(0.0, |c| c.out_of_reach(&cutter))
                    }
                    None => 0.0,
                })
            });
            (stretch, rows.collect())
        };
        Self { stretches: source.cutters.iter().map(stretch).collect() }
    }

    /// What of the floor at `s` is out of reach, where it lies under a blade at all.
    pub(super) fn covered(&self, s: f64, over: &Over) -> Covered {
        // Of the cutters that work nearest to s the smallest comes furthest.
        let order = |a: &CutterStretch, b: &CutterStretch| {
            a.away(s).total_cmp(&b.away(s)).then(a.radius.total_cmp(&b.radius))
        };
        let Some((_, rows)) = self.stretches.iter().min_by(|a, b| order(&a.0, &b.0)) else {
            return Covered::default();
        };
        let (first, second, share) = rows_beside(s);
        let mut covered = Covered::default();
        for (face, range) in covered.ranges.iter_mut().enumerate() {
            let reach = rows[first][face] + (rows[second][face] - rows[first][face]) * share;
            let foot = over.feet[face];
            *range = if face == 0 || face == 3 { (foot, foot + reach) } else { (foot - reach, foot) };
        }
        covered
    }
}

/// Ranges of angles at one s, counted as in [`Over`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Covered {
    ranges: [(f64, f64); 4],
}

impl Covered {
    pub(super) fn contains(&self, angle: f64) -> bool {
        self.ranges.iter().any(|range| angle > range.0 && angle < range.1)
    }
}

/// The cutter and what it must keep, mm.
struct Cutter {
    radius: f64,
    hub_allowance: f64,
    blade_allowance: f64,
}

/// The corner between hub and one wall at a row of the tables.
struct Corner<'a> {
    face: &'a Face<'a>,
    facing: [Option<&'a Face<'a>>; 2],
    row: usize,
    frame: Frame,
    /// Direction around the wheel, into the channel.
    around: Vector,
    hub: HubHere,
    /// Radius of the foot, mm.
    foot_radius: f64,
}

/// The hub about a foot, to second order in the directions (along, across).
struct HubHere {
    /// Height above the tangent plane is ½·(f, d)·[[c0, c1], [c1, c2]]·(f, d).
    curvature: [f64; 3],
    /// Components of the meridional direction.
    meridional: [f64; 2],
    /// Arc lengths to the ends of the hub, against and with the meridional direction, mm.
    ends: [f64; 2],
}

impl<'a> Corner<'a> {
    /// `None` where the wall is not found or leans over nothing.
    fn new(part: &Impeller, walls: &'a WallTables, index: usize, row: usize) -> Option<Self> {
        let face = &walls.faces[index];
        let foot = &face.row(row)[0];
        if !foot.is_on_blade() {
            return None;
        }
        let s = s_of_row(row);
        let hub = part.hub.at(s);
        let theta = foot.point.y.atan2(foot.point.x);
        let (normal, tangent) = (hub.normal.direction_at_angle(theta), hub.tangent.direction_at_angle(theta));
        let inward = part.pitch().signum() * face.opens;
        let around = Vector::new(-theta.sin(), theta.cos(), 0.0) * inward;
        let beside = |row: usize| Some(face.row(row)[0].point).filter(|p| p.x.is_finite());
        let before = beside(row.saturating_sub(1)).unwrap_or(foot.point);
        let after = beside((row + 1).min(ROWS - 1)).unwrap_or(foot.point);
        let trace = after - before;
        let along = (trace - normal * trace.dot(&normal)).try_normalize(1e-9)?;
        let across = {
            let e = normal.cross(&along);
            if e.dot(&around) < 0.0 { -e } else { e }
        };
        let [t, c] = [tangent, around].map(|d| [d.dot(&along), d.dot(&across)]);
        let (kt, kc) = (hub.curvature, -hub.normal.r / hub.point.r);
        let curvature = [
            kt * t[0] * t[0] + kc * c[0] * c[0],
            kt * t[0] * t[1] + kc * c[0] * c[1],
            kt * t[1] * t[1] + kc * c[1] * c[1],
        ];
        let ends = [part.hub.arc_at(s), (1.0 - s) * part.hub.length()];
        // The second side of a splitter is behind the first one.
        let facing = match index {
            0 => [Some(1), Some(2)],
            1 => [Some(0), Some(3)],
            2 => [Some(0), None],
            _ => [Some(1), None],
        };
        Some(Self {
            face,
            facing: facing.map(|index| walls.faces.get(index?)),
            row,
            frame: Frame { foot: foot.point, along, across, normal },
            around,
            hub: HubHere { curvature, meridional: t, ends },
            foot_radius: hub.point.r,
        })
    }

    /// `face` in the plane of the axes that lean by tan α = `slope` along the wall.
    fn profile(&self, face: &Face, slope: f64) -> Profile {
        Profile::of(&self.frame, face, slope, self.row)
    }

    /// Angle about the wheel from the foot within which the floor is out of reach, rad.
    fn out_of_reach(&self, cutter: &Cutter) -> f64 {
        let upright = self.profile(self.face, 0.0);
        if upright.steepest() < TOLERANCE {
            return 0.0;
        }
        let mut of = |slope: f64| self.nearest(cutter, slope);
        let values = SLOPES.map(&mut of);
        let best = (0..SLOPES.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let (low, high) = (SLOPES[best.saturating_sub(1)], SLOPES[(best + 1).min(SLOPES.len() - 1)]);
        let (_, refined) = search::minimum(of, low, high, 10.0 * TOLERANCE);
        let nearest = refined.min(values[best]);
        // Where no axis finds the wall, nothing is known of it and nothing excused.
        if nearest.is_finite() { self.angle_to(nearest.max(0.0)) } else { 0.0 }
    }

    /// The angle from the foot to the place of the row that lies `distance` from the wall's trace.
    fn angle_to(&self, distance: f64) -> f64 {
        let (f, d) = (self.around.dot(&self.frame.along), self.around.dot(&self.frame.across));
        // The trace bends away from its tangent.
        let mut arc = distance / d.max(0.05);
        for _ in 0..3 {
            arc = (distance + self.trace(arc * f)) / d.max(0.05);
        }
        arc.max(0.0) / self.foot_radius
    }

    /// d of the wall's trace on the hub at f.
    fn trace(&self, f: f64) -> f64 {
        let mut row = self.row;
        self.frame.cross(self.face, 0, [0.0, f], &mut row).map_or(0.0, |c| c.d)
    }

    /// Least distance from the foot that a cutter reaches whose axis leans by tan α = `slope` along the wall, mm.
    fn nearest(&self, cutter: &Cutter, slope: f64) -> f64 {
        let near = self.profile(self.face, slope);
        if near.count < 2 {
            return f64::INFINITY;
        }
        let facing = self.facing.map(|face| face.map(|face| self.profile(face, slope)));
        let of = |lean: f64| self.stand(cutter, slope, lean, &near, &facing);
        let (_, distance) = search::minimum(of, 0.0, 1.2 * near.steepest().clamp(0.0, 4.0), TOLERANCE);
        distance
    }

    /// Distance from the foot at which the bottom begins, for the axis (`slope`, `lean`) beside the wall, mm. Where
    /// the facing walls leave no room this is further than anything.
    fn stand(
        &self,
        cutter: &Cutter,
        slope: f64,
        lean: f64,
        near: &Profile,
        facing: &[Option<Profile>; 2],
    ) -> f64 {
        let length = (1.0 + slope * slope + lean * lean).sqrt();
        let axis = [slope / length, lean / length, 1.0 / length];
        let reach = cutter.radius + cutter.blade_allowance;
        let bottom = cutter.hub_allowance + self.hub.lift(&axis, cutter.radius, reach);
        // The disc across the wall: half its width, and its near end.
        let half = (1.0 - axis[1] * axis[1]).sqrt();
        let rise = cutter.radius * axis[1] * axis[2] / half;
        let flank = Flank { axis, lean, reach, rise };
        let place = near.nearest_axis(&flank, bottom + rise);
        let lacking = facing
            .iter()
            .flatten()
            .map(|wall| place - wall.furthest_axis(&flank, bottom - rise))
            .fold(0.0, f64::max);
        if place == f64::NEG_INFINITY {
            // The whole wall is lower than the bottom's near end.
            return f64::INFINITY;
        }
        let begin = place + bottom * lean - cutter.radius * half;
        begin + PENALTY * (lacking - ROOM_TOLERANCE).max(0.0)
    }
}

impl HubHere {
    /// Height of the centre of a disc of radius `radius` across `axis`, about `d` from the foot, when it touches the hub.
    fn lift(&self, axis: &[f64; 3], radius: f64, d: f64) -> f64 {
        let axis = Vector::from(*axis);
        let u = (Vector::new(0.0, 1.0, 0.0) - axis * axis.y).normalize();
        let v = axis.cross(&u);
        let above = |off: Vector| {
            let (x, y) = (off.x, d + off.y);
            let along_hub = x * self.meridional[0] + y * self.meridional[1];
            if along_hub < -self.ends[0] || along_hub > self.ends[1] {
                return f64::NEG_INFINITY;
            }
            let [c0, c1, c2] = self.curvature;
            0.5 * (c0 * x * x + 2.0 * c1 * x * y + c2 * y * y) - off.z
        };
        let rim = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RIM_POINTS as f64).sin_cos();
            above((u * cos + v * sin) * radius)
        };
        // A disc beyond the end of the hub rests on nothing.
        (0..RIM_POINTS).map(rim).fold(above(Vector::zeros()), f64::max).max(-radius)
    }
}
