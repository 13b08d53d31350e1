//! Inaccessible floor: the corner under a wall that leans over the channel.
//!
//! Beside such a wall the flank of a cutter follows the wall, its bottom rests on the far end of its rim, and
//! the near end is 2R·sin β above the hub; the floor within about 2R·sin β·tan β of the wall's foot
//! stays under stock in every plan. Here this distance is computed for the actual wall, row by row.
//!
//! In the frame of the foot (T along the wall, e across into the channel, n along the hub normal; coordinates
//! f, d, z) an axis is a ∝ tan α · T + tan φ · e + n, and in the plane of e and a the wall is a profile
//! w(z). The flank comes as near as it can: beside the tangent plane at every height of the wall that it
//! touches, the axis keeps
//!
//!   d ≥ w + (R + blade allowance)·g,
//!   g² = |∇|² − (∇·a)²,   ∇ = (−∂w/∂f, 1, −∂w/∂z),
//!
//! at the point of the axis opposite to the contact, which is lower by the rise of the near end of the rim
//! over the centre of the bottom. That is exact for a plane. Opposite walls bound the axis from the other
//! side in the same way. The bottom is as low as its disc can be over the hub, to second order about the
//! foot, with the hub allowance. The least d that the disc reaches is minimised over φ, from 0 to beyond the
//! steepest slope of the wall, and over α.
//!
//! Other bounds of an axis (holder, tilt limits, the hub further up, other positions) and the corner radius
//! are ignored: floor reported as inaccessible is so for every plan, and floor that a plan leaves without
//! being reported counts as uncut. Only rays that end under a blade can be inaccessible.

use rayon::prelude::*;

use super::grid::FloorSource;
use super::overhang::{BladesOverFloor, ROWS, WallTable, WallTables, rows_beside, s_of_row};
use super::profile::{CutterFlank, WallFootFrame, WallProfile};
use crate::geometry::{Vector, search};
use crate::part::Impeller;

/// A range of s and the radius of the cutter used there.
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
    /// Distance of `s` from the range, 0 within it.
    fn distance_to(&self, s: f64) -> f64 {
        (s - self.from).max(self.to - s).max(0.0)
    }
}

/// Values of tan α that are tried; the best is refined between its neighbours.
const SLOPES: [f64; 7] = [-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6];
/// Tolerance of tan α and tan φ.
const TOLERANCE: f64 = 1e-3;
/// Points of the rim where the bottom may touch the hub.
const RIM_POINTS: usize = 16;
/// Weight of missing clearance between the walls, relative to distance from the foot.
const PENALTY: f64 = 20.0;
/// Missing clearance that is tolerated, mm.
const CLEARANCE_TOLERANCE: f64 = 0.05;

/// Inaccessible floor at one row of the tables, per wall: angle from its foot, rad; 0 where all is
/// accessible.
type InaccessibleAngles = Vec<f64>;

/// Inaccessible floor along s.
#[derive(Debug)]
pub(super) struct InaccessibleTables {
    stretches: Vec<(CutterStretch, Vec<InaccessibleAngles>)>,
}

impl InaccessibleTables {
    pub(super) fn new(source: &FloorSource, walls: &WallTables) -> Self {
        let stretch = |&stretch: &CutterStretch| {
            let cutter = ReachCutter {
                radius: stretch.radius,
                hub_allowance: source.stock.hub_allowance,
                blade_allowance: source.stock.blade_allowance,
            };
            let rows = (0..ROWS).into_par_iter().map(|row| {
                // Rows are interpolated in pairs. Further from the range of the cutter they are not used.
                if stretch.distance_to(s_of_row(row)) > 1.0 / ROWS as f64 {
                    return vec![0.0; walls.faces.len()];
                }
                let angle = |face| {
                    WallCorner::new(&source.workpiece.part, walls, face, row)
                        .map_or(0.0, |c| c.inaccessible_angle(&cutter))
                };
                (0..walls.faces.len()).map(angle).collect()
            });
            (stretch, rows.collect())
        };
        Self { stretches: source.cutters.iter().map(stretch).collect() }
    }

    /// The cutter that reaches furthest at `s`: the smallest of those nearest to it.
    pub(super) fn cutter_at(&self, s: f64) -> Option<&CutterStretch> {
        self.stretch_at(s).map(|(stretch, _)| stretch)
    }

    fn stretch_at(&self, s: f64) -> Option<&(CutterStretch, Vec<InaccessibleAngles>)> {
        let order = |a: &CutterStretch, b: &CutterStretch| {
            a.distance_to(s).total_cmp(&b.distance_to(s)).then(a.radius.total_cmp(&b.radius))
        };
        self.stretches.iter().min_by(|a, b| order(&a.0, &b.0))
    }

    /// Inaccessible ranges of the floor at `s`; they apply only to floor under a blade.
    pub(super) fn inaccessible_ranges(&self, s: f64, over: &BladesOverFloor) -> InaccessibleRanges {
        let Some((_, rows)) = self.stretch_at(s) else { return InaccessibleRanges::default() };
        let (first, second, share) = rows_beside(s);
        let range = |(face, &foot): (usize, &f64)| {
            let reach = rows[first][face] + (rows[second][face] - rows[first][face]) * share;
            // The first wall and the far sides of splitters open towards the second wall.
            if face == 0 || face > 1 && face % 2 == 1 { (foot, foot + reach) } else { (foot - reach, foot) }
        };
        InaccessibleRanges { ranges: over.feet.iter().enumerate().map(range).collect() }
    }
}

/// Ranges of angles at one s, counted as in [`BladesOverFloor`].
#[derive(Clone, Debug, Default)]
pub(super) struct InaccessibleRanges {
    ranges: Vec<(f64, f64)>,
}

impl InaccessibleRanges {
    pub(super) fn contains(&self, angle: f64) -> bool {
        self.face_over(angle).is_some()
    }

    /// Number of the wall in whose corner the angle is.
    pub(super) fn face_over(&self, angle: f64) -> Option<usize> {
        self.ranges.iter().position(|range| angle > range.0 && angle < range.1)
    }
}

/// Radius of the cutter, and allowances, mm.
struct ReachCutter {
    radius: f64,
    hub_allowance: f64,
    blade_allowance: f64,
}

impl ReachCutter {
    /// Distance of the axis from a wall, mm.
    fn reach(&self) -> f64 {
        self.radius + self.blade_allowance
    }
}

/// The corner between hub and one wall at a row of the tables.
struct WallCorner<'a> {
    face: &'a WallTable<'a>,
    facing: Vec<&'a WallTable<'a>>,
    row: usize,
    frame: WallFootFrame,
    /// Circumferential direction, into the channel.
    around: Vector,
    hub: LocalHub,
    /// Radius of the foot, mm.
    foot_radius: f64,
}

/// The hub about a foot, to second order in the directions (along, across).
struct LocalHub {
    /// Height above the tangent plane is ½·(f, d)·[[c0, c1], [c1, c2]]·(f, d).
    curvature: [f64; 3],
    /// Components of the meridional direction.
    meridional: [f64; 2],
    /// Arc lengths to the ends of the hub, against and with the meridional direction, mm.
    ends: [f64; 2],
}

impl<'a> WallCorner<'a> {
    /// `None` where the wall has no foot on the blade in this row.
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
        let inward = part.pitch().signum() * face.opening_sign;
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
        Some(Self {
            face,
            facing: walls.facing(index).collect(),
            row,
            frame: WallFootFrame { foot: foot.point, along, across, normal },
            around,
            hub: LocalHub { curvature, meridional: t, ends },
            foot_radius: hub.point.r,
        })
    }

    /// Profile of `face` in the plane of the axes with tan α = `slope` along the wall.
    fn profile(&self, face: &WallTable, slope: f64, cutter: &ReachCutter) -> WallProfile {
        WallProfile::of(&self.frame, face, (slope, cutter.reach()), self.row)
    }

    /// Angle about Z from the foot within which the floor is inaccessible, rad.
    fn inaccessible_angle(&self, cutter: &ReachCutter) -> f64 {
        let upright = self.profile(self.face, 0.0, cutter);
        if upright.steepest() < TOLERANCE {
            return 0.0;
        }
        let mut of = |slope: f64| self.nearest(cutter, slope);
        let values = SLOPES.map(&mut of);
        let best = (0..SLOPES.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let (low, high) = (SLOPES[best.saturating_sub(1)], SLOPES[(best + 1).min(SLOPES.len() - 1)]);
        let (_, refined) = search::minimum(of, low, high, 10.0 * TOLERANCE);
        let nearest = refined.min(values[best]);
        // Where the wall meets no plane of axes, the floor counts as accessible.
        if nearest.is_finite() { self.angle_to(nearest.max(0.0)) } else { 0.0 }
    }

    /// The angle from the foot to the point of the row that is `distance` mm from the wall's trace, rad.
    fn angle_to(&self, distance: f64) -> f64 {
        let (f, d) = (self.around.dot(&self.frame.along), self.around.dot(&self.frame.across));
        // Fixed-point iteration, as the trace curves away from its tangent.
        let mut arc = distance / d.max(0.05);
        for _ in 0..3 {
            arc = (distance + self.trace(arc * f)) / d.max(0.05);
        }
        arc.max(0.0) / self.foot_radius
    }

    /// d of the wall's trace on the hub at f, mm.
    fn trace(&self, f: f64) -> f64 {
        let mut row = self.row;
        self.frame.cross_level(self.face, 0, [0.0, f], &mut row).map_or(0.0, |c| c.d)
    }

    /// Least distance from the foot that a cutter reaches whose axis has tan α = `slope` along the wall, mm.
    fn nearest(&self, cutter: &ReachCutter, slope: f64) -> f64 {
        let near = self.profile(self.face, slope, cutter);
        if near.is_empty() {
            return f64::INFINITY;
        }
        let facing: Vec<WallProfile> =
            self.facing.iter().map(|face| self.profile(face, slope, cutter)).collect();
        let of = |tan_tilt: f64| self.bottom_begin(cutter, slope, tan_tilt, &near, &facing);
        let most = 1.2 * near.steepest().clamp(0.0, 4.0);
        let (_, distance) = search::minimum(of, 0.0, last_finite(of, most), TOLERANCE);
        distance
    }

    /// Distance from the foot at which the bottom begins, for the axis (`slope`, `tan_tilt`) beside the wall,
    /// mm, with a penalty where opposite walls leave too little clearance.
    fn bottom_begin(
        &self,
        cutter: &ReachCutter,
        slope: f64,
        tan_tilt: f64,
        near: &WallProfile,
        facing: &[WallProfile],
    ) -> f64 {
        let length = (1.0 + slope * slope + tan_tilt * tan_tilt).sqrt();
        let axis = [slope / length, tan_tilt / length, 1.0 / length];
        let reach = cutter.reach();
        let bottom = cutter.hub_allowance + self.hub.contact_height(&axis, cutter.radius, reach);
        // Half the width of the disc across the wall, and the rise of its near end.
        let half = (1.0 - axis[1] * axis[1]).sqrt();
        let rise = cutter.radius * axis[1] * axis[2] / half;
        let flank = CutterFlank { axis, tan_phi: tan_tilt, reach, rise };
        let place = near.nearest_axis(&flank, bottom + rise);
        let lacking =
            facing.iter().map(|wall| place - wall.furthest_axis(&flank, bottom - rise)).fold(0.0, f64::max);
        if place == f64::NEG_INFINITY {
            // The whole wall is lower than the bottom's near end.
            return f64::INFINITY;
        }
        let begin = place + bottom * tan_tilt - cutter.radius * half;
        begin + PENALTY * (lacking - CLEARANCE_TOLERANCE).max(0.0)
    }
}

/// The last value in 0…`most` at which `f` is finite, found by bisection: with more tilt the bottom is above
/// the whole wall, and no longer in its corner.
fn last_finite(f: impl Fn(f64) -> f64, most: f64) -> f64 {
    let (mut low, mut high) = (0.0, most);
    if f(most).is_finite() {
        return most;
    }
    while high - low > TOLERANCE {
        let middle = 0.5 * (low + high);
        if f(middle).is_finite() { low = middle } else { high = middle }
    }
    low
}

impl LocalHub {
    /// Height of the centre of a disc of radius `radius` perpendicular to `axis`, about `d` mm from the foot,
    /// when it touches the hub, mm.
    fn contact_height(&self, axis: &[f64; 3], radius: f64, d: f64) -> f64 {
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
        // A disc beyond the end of the hub touches nothing.
        (0..RIM_POINTS).map(rim).fold(above(Vector::zeros()), f64::max).max(-radius)
    }
}
