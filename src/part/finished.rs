//! Distance of a cutter to the finished part, measured independently of how the cutter was placed.

use std::ops::Range;

use super::closed_blade::faces_between;
use super::flowpath::Flowpath;
use super::impeller::Impeller;
use super::probe::{NearestOnSide, SideProbe};
use super::side::BladeSide;
use crate::geometry::{
    Circle, CutterSolid, Frustum, Meridional, Point, distance_rate, rotate_vector_z, rotate_z, search,
};

/// Length of a tool that has no end, mm.
pub const ENDLESS: f64 = 1e5;

/// The finished surfaces around a channel, prepared for many distance queries.
#[derive(Debug)]
pub struct FinishedPart {
    /// The hub.
    pub hub: Flowpath,
    /// Number of main blades.
    pub blade_count: usize,
    /// Angle from one main blade to the next, rad; see [`Impeller::pitch`].
    pub pitch: f64,
    blades: Vec<SideProbe>,
    /// Faces between the sides of the blades of a pitch, at their tips and ends.
    faces: Vec<SideProbe>,
    /// A ball around each side of each blade of the wheel, those around channel 1 first, and their number;
    /// then those around the faces between them.
    balls: Vec<SideBall>,
    side_count: usize,
}

/// A ball around a side of a blade of the wheel.
#[derive(Clone, Copy, Debug)]
pub struct SideBall {
    /// Index of the side among those of channel 1; from their number on, of a face between sides.
    side: usize,
    /// Angle about the axis of the wheel that brings the blade to channel 1, rad.
    pub to_channel_rad: f64,
    /// Centre of the ball, mm.
    pub centre: Point,
    /// Its radius, mm.
    pub radius: f64,
}

/// A cutter of the shape of `cutter` where its `column` is.
fn shaped_as(cutter: &CutterSolid, column: &Frustum) -> CutterSolid {
    CutterSolid { tip: column.base, axis: column.axis, ..*cutter }
}

impl FinishedPart {
    /// The surfaces around channel 1 of `part`, whose blade sides are `sides`.
    pub fn new(part: &Impeller, sides: &[BladeSide]) -> Self {
        let blades: Vec<SideProbe> = sides.iter().map(|s| SideProbe::new(s, 0.0, 1.0)).collect();
        // The second main blade is the first one turned.
        let pairs = sides.chunks_exact(2).enumerate().filter(|(blade, _)| *blade != 1);
        let faces = pairs.flat_map(|(_, pair)| faces_between([&pair[0], &pair[1]]));
        let faces: Vec<SideProbe> = faces.map(|face| SideProbe::new(&face, 0.0, 1.0)).collect();
        let own: Vec<(Point, f64)> = blades.iter().chain(&faces).map(SideProbe::bounding_ball).collect();
        let (pitch, count) = (part.pitch(), part.blade_count);
        let ball = |k: usize, side: usize| {
            let (centre, radius) = own[side];
            let to_channel_rad = -pitch * k as f64;
            SideBall { side, to_channel_rad, centre: rotate_z(&centre, -to_channel_rad), radius }
        };
        // The first main blade of a channel is the second of the one before.
        let is_again =
            |k: usize, side: usize| k > 0 && (side < 2 || k + 1 == count && (2..4).contains(&side));
        // Blade by blade.
        let around = |of_blade: Range<usize>| {
            (0..count).flat_map(move |k| of_blade.clone().map(move |side| (k, side)))
        };
        let sides = around(0..blades.len()).filter(|&(k, side)| !is_again(k, side));
        let mut balls: Vec<SideBall> = sides.map(|(k, side)| ball(k, side)).collect();
        let side_count = balls.len();
        balls.extend(around(blades.len()..own.len()).map(|(k, face)| ball(k, face)));
        let (hub, blade_count) = (part.hub.clone(), part.blade_count);
        Self { hub, blade_count, pitch, blades, faces, balls, side_count }
    }

    /// Balls around the sides of all blades of the wheel, those around channel 1 first, then around the faces
    /// between them.
    pub fn side_balls(&self) -> &[SideBall] {
        &self.balls
    }

    /// The side or face in a ball, where its blade is around channel 1.
    pub fn side_in(&self, ball: &SideBall) -> &SideProbe {
        self.blades.get(ball.side).unwrap_or_else(|| &self.faces[ball.side - self.blades.len()])
    }

    /// The sides of the blades, in the order they were given in.
    pub fn blades(&self) -> &[SideProbe] {
        &self.blades
    }

    /// Minimum signed distance of the cutter (bottom and column) to the blades, mm: those around the channel,
    /// and those one pitch further on either side, over which the column may tilt where the wrap angle is
    /// large.
    pub fn blade_clearance(&self, cutter: &CutterSolid) -> f64 {
        let pitch = self.pitch;
        let turned = |angle: f64| CutterSolid {
            tip: rotate_z(&cutter.tip, angle),
            axis: rotate_vector_z(&cutter.axis, angle),
            ..*cutter
        };
        [-pitch, pitch].into_iter().fold(self.blade_clearance_below(cutter, f64::INFINITY), |least, angle| {
            self.blade_clearance_below(&turned(angle), least)
        })
    }

    /// Minimum signed distance to the blades around the channel, mm, or `cap` where none is nearer than that;
    /// see [`Self::wheel_clearance_below`] for all blades.
    pub fn blade_clearance_below(&self, cutter: &CutterSolid, cap: f64) -> f64 {
        self.nearest_of(cap, |blade, cutoff| blade.nearest_below(cutter, cutoff))
            .map_or(cap, |near| near.distance)
    }

    /// The sides of blades that are not around channel 1 to which a cutter may be nearer than `cutoff` mm up
    /// to a height of `length` mm, with its column turned to where they are measured. A tool that leans far
    /// over the channels beside its own, as between blades that are much wrapped, reaches them.
    fn sides_beyond(
        &self,
        cutter: &CutterSolid,
        length: f64,
        cutoff: f64,
    ) -> impl Iterator<Item = (&SideBall, Frustum)> {
        let column = Frustum { base: cutter.tip, axis: cutter.axis, length, radii: [cutter.radius; 2] };
        let may_be_near = move |ball: &&SideBall| {
            let off = ball.centre - column.base;
            let up = off.dot(&column.axis).clamp(0.0, length);
            let reach = column.radii[0] + ball.radius + cutoff;
            reach >= 0.0 && (off - column.axis * up).norm_squared() <= reach * reach
        };
        let turned = move |ball: &SideBall| {
            let turn = ball.to_channel_rad;
            let (base, axis) = (rotate_z(&column.base, turn), rotate_vector_z(&column.axis, turn));
            Frustum { base, axis, ..column }
        };
        self.balls[self.blades.len()..self.side_count]
            .iter()
            .filter(may_be_near)
            .map(move |ball| (ball, turned(ball)))
    }

    /// Minimum signed distance to the blades of the wheel of a cutter that is `length` mm long, mm, or `cap`
    /// where none is nearer than that; to the blades around the channel as if it had no end.
    pub fn wheel_clearance_below(&self, cutter: &CutterSolid, length: f64, cap: f64) -> f64 {
        let around = self.blade_clearance_below(cutter, cap);
        self.sides_beyond(cutter, length, around).fold(around, |least, (ball, column)| {
            // The cutter is what its column and an endless one with its corner have in common.
            let side = &self.blades[ball.side];
            let column_distance = side.frustum_distance_below(&column, least).unwrap_or(least);
            if column_distance >= least {
                return least;
            }
            let near = side.nearest_below(&shaped_as(cutter, &column), least);
            near.map_or(least, |near| near.distance.max(column_distance).min(least))
        })
    }

    /// Whether a cutter that is `length` mm long keeps `allowance` mm from every blade of the wheel.
    pub fn clears_wheel(&self, cutter: &CutterSolid, length: f64, allowance: f64) -> bool {
        self.clears(cutter, allowance)
            && !self.sides_beyond(cutter, length, allowance).any(|(ball, column)| {
                let side = &self.blades[ball.side];
                side.frustum_is_within(&column, allowance)
                    && side.is_within(&shaped_as(cutter, &column), allowance)
            })
    }

    /// The sides of blades of the wheel that are nearer than `cutoff` mm to a cutter that is `length` mm
    /// long, each by its index among those around channel 1, and where it is nearest; without the side of
    /// index `but` there.
    pub fn sides_within<'a>(
        &'a self,
        cutter: &'a CutterSolid,
        length: f64,
        cutoff: f64,
        but: Option<usize>,
    ) -> impl Iterator<Item = (usize, NearestOnSide)> + 'a {
        let near = move |side: usize, cutter: &CutterSolid| {
            let near = self.blades[side].nearest_below(cutter, cutoff)?;
            (near.distance < cutoff).then_some((side, near))
        };
        let others = (0..self.blades.len()).filter(move |side| Some(*side) != but);
        let beyond = self.sides_beyond(cutter, length, cutoff).filter_map(move |(ball, column)| {
            if !self.blades[ball.side].frustum_is_within(&column, cutoff) {
                return None;
            }
            near(ball.side, &shaped_as(cutter, &column))
        });
        others.filter_map(move |side| near(side, cutter)).chain(beyond)
    }

    /// Nearest point of the blades to the cutter, if it is nearer than `cutoff` mm.
    pub fn nearest_within(&self, cutter: &CutterSolid, cutoff: f64) -> Option<NearestOnSide> {
        self.nearest_of(cutoff, |blade, cutoff| blade.nearest_below(cutter, cutoff))
    }

    /// Nearest point of the blades to `point`, if it is nearer than `cutoff` mm.
    pub fn nearest_blade_below(&self, point: &Point, cutoff: f64) -> Option<NearestOnSide> {
        self.nearest_of(cutoff, |blade, cutoff| blade.nearest_to_point_below(point, cutoff))
    }

    /// The nearest point of all blades that is nearer than `cutoff` mm; `nearest` finds that of one blade, if
    /// it is nearer than another one that is known.
    fn nearest_of(
        &self,
        cutoff: f64,
        nearest: impl Fn(&SideProbe, f64) -> Option<NearestOnSide>,
    ) -> Option<NearestOnSide> {
        self.blades.iter().fold(None, |known: Option<NearestOnSide>, blade| {
            let least = known.map_or(cutoff, |near| near.distance);
            nearest(blade, least).filter(|near| near.distance < least).or(known)
        })
    }

    /// Whether the cutter (bottom and column) keeps `allowance` mm from every blade around the channel.
    pub fn clears(&self, cutter: &CutterSolid, allowance: f64) -> bool {
        !self.blades.iter().any(|blade| blade.is_within(cutter, allowance))
    }

    /// Minimum signed distance of the cutter's bottom and flank to the hub, mm.
    pub fn hub_clearance(&self, cutter: &CutterSolid) -> f64 {
        let curve = self.hub.curve();
        let flat = cutter.radius - cutter.corner_radius;
        let centre = cutter.tip + cutter.axis * cutter.corner_radius;
        let (start, _) = curve.project(Meridional::from_point(&centre));
        let reach = 3.0 * cutter.radius + 0.05 * curve.length();
        let mut warm = start;
        // Signed distance of a point, and its foot point on the hub.
        let mut distance = |p: &Point| {
            let m = Meridional::from_point(p);
            let (t, d) = curve.project_near(m, warm.clamp(start - reach, start + reach), reach);
            warm = t;
            // Beyond its ends the hub has an edge, not a surface.
            (if t <= 0.0 || t >= curve.length() { d.abs() } else { d }, curve.point(t))
        };
        let rim = Circle::new(&centre, &cutter.axis, flat);
        let on_rim = |phi: f64| {
            let (p, turning) = rim.point_and_derivative(phi.sin_cos());
            let (d, foot) = distance(&p);
            (d, distance_rate(&p, &turning, foot) * d.signum())
        };
        let mut least = search::min_over_turn::<18>(on_rim, 0.2);
        let step = std::f64::consts::TAU / 18.0;
        // Distance at a share of the rim's radius and a height above the bottom.
        let mut at = |share: f64, phi: f64, up: f64| {
            let (p, _) = rim.point_and_derivative(phi.sin_cos());
            distance(&(centre + (p - centre) * share + cutter.axis * up)).0
        };
        // Inside the disc, for convex hubs: compass search with halved steps from the best sample.
        let mut inner = (at(0.0, 0.0, 0.0), 0.0, 0.0);
        for ring in 1..3 {
            for i in 0..9 {
                let (share, phi) = (f64::from(ring) / 3.0, step * 2.0 * f64::from(i));
                let d = at(share, phi, 0.0);
                if d < inner.0 {
                    inner = (d, share, phi);
                }
            }
        }
        if inner.0 < least + 0.1 {
            let (mut dr, mut dp) = (1.0 / 6.0, step);
            while dr * flat > 1e-5 {
                let mut moved = false;
                for (r, p) in [
                    (inner.1 + dr, inner.2),
                    (inner.1 - dr, inner.2),
                    (inner.1, inner.2 + dp),
                    (inner.1, inner.2 - dp),
                ] {
                    let r = r.clamp(0.0, 1.0);
                    let d = at(r, p, 0.0);
                    if d < inner.0 {
                        inner = (d, r, p);
                        moved = true;
                    }
                }
                if !moved {
                    dr *= 0.5;
                    dp *= 0.5;
                }
            }
            least = least.min(inner.0);
        }
        // The flank of the column, for hubs that rise beside it.
        for up in [0.2, 1.0, 3.0] {
            for i in 0..9 {
                least = least.min(at(1.0, step * 2.0 * f64::from(i), up * cutter.radius));
            }
        }
        least - cutter.corner_radius
    }
}
