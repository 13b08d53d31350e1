//! Intersection of one ray with one cutter: the arithmetic of the field for one cell.
//!
//! `shaders/residual.wgsl` has the same functions under the same names, and gets the constants of this file
//! when it is compiled. Only the steps around the corner of a bull nose branch, so that loops over the others
//! become vector instructions.

use super::field_cutter::FieldCutter;
use super::tiles::TILE;

/// Height that no ray reaches, mm.
pub(crate) const FAR: f32 = 1e30;
/// Least squared sine between ray and axis: a ray along the axis meets the wall 1e6 radii away.
pub(crate) const MIN_SQUARED_SINE: f32 = 1e-12;
/// Least cosine between ray and axis: a ray along the bottom plane crosses it far away.
pub(crate) const MIN_COSINE: f32 = 1e-6;
/// Largest number of Newton steps towards a rounded corner.
pub(crate) const CORNER_STEPS: u32 = 8;
/// Distance from the rounded corner that counts as on it, mm.
pub(crate) const CORNER_TOLERANCE: f32 = 2e-5;

/// A value per lane: one row of a tile.
pub(super) type LaneRow<T> = [T; TILE];

/// One ray relative to the axis of one cutter. At height h the ray is at height `z + h·slope` above the
/// bottom, and at squared distance `squared_distance + 2 h·closing + h²·squared_sine` from the axis.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub(super) z: f32,
    pub(super) slope: f32,
    squared_sine: f32,
    closing: f32,
    squared_distance: f32,
}

impl Meeting {
    #[inline(always)]
    pub(super) fn new(point: [f32; 3], normal: [f32; 3], cutter: &FieldCutter) -> Self {
        let axis = cutter.axis;
        let from_tip = [point[0] - cutter.tip[0], point[1] - cutter.tip[1], point[2] - cutter.tip[2]];
        let z = dot(from_tip, axis);
        let slope = dot(normal, axis);
        // Across the axis. Forming the vectors first keeps small tilts exact; 1 − slope² would not.
        let start = [from_tip[0] - axis[0] * z, from_tip[1] - axis[1] * z, from_tip[2] - axis[2] * z];
        let step = [normal[0] - axis[0] * slope, normal[1] - axis[1] * slope, normal[2] - axis[2] * slope];
        Self {
            z,
            slope,
            squared_sine: larger(dot(step, step), MIN_SQUARED_SINE),
            closing: dot(start, step),
            squared_distance: dot(start, start),
        }
    }

    /// Positive if the whole line of the ray meets the cylinder of that squared radius.
    #[inline(always)]
    pub(super) fn discriminant(&self, squared_radius: f32) -> f32 {
        self.closing * self.closing - self.squared_sine * (self.squared_distance - squared_radius)
    }

    /// Heights at which the ray enters (0 if its foot is inside) and leaves the cylinder above the bottom
    /// plane. Only meaningful for a positive discriminant, and empty unless entry < exit.
    #[inline(always)]
    pub(super) fn interval(&self, squared_radius: f32) -> (f32, f32) {
        let half = larger(self.discriminant(squared_radius), 0.0).sqrt();
        let inverse = 1.0 / self.squared_sine;
        let enter = (-self.closing - half) * inverse;
        let leave = (-self.closing + half) * inverse;
        let slope = if self.slope.abs() < MIN_COSINE { MIN_COSINE } else { self.slope };
        let bottom = -self.z / slope;
        let enter = if slope > 0.0 { larger(enter, bottom) } else { enter };
        let leave = if slope < 0.0 { smaller(leave, bottom) } else { leave };
        (larger(enter, 0.0), leave)
    }

    /// Height at which the ray enters the cylinder above the bottom plane, [`FAR`] if it does not.
    #[inline(always)]
    pub(super) fn entry(&self, squared_radius: f32) -> f32 {
        let (entry, exit) = self.interval(squared_radius);
        let meets = (self.discriminant(squared_radius) > 0.0) & (entry < exit);
        if meets { entry } else { FAR }
    }

    /// The same ray, `by` mm higher above the bottom.
    #[inline(always)]
    pub(super) fn raised(self, by: f32) -> Self {
        Self { z: self.z + by, ..self }
    }

    /// False only where [`Meeting::contact_depth`] is 0: the cylinder misses the ray, or all stock is below
    /// the bottom plane. Avoids the square roots for most rows.
    #[inline(always)]
    pub(super) fn may_touch(&self, squared_core: f32, height: f32) -> bool {
        let above = (self.z + height * self.slope > 0.0) | (self.slope <= 0.0);
        (self.discriminant(squared_core) > 0.0) & above
    }

    /// Height above the bottom of the highest stock in the core, for stock up to `height`; 0 if none.
    #[inline(always)]
    pub(super) fn contact_depth(&self, squared_core: f32, height: f32) -> f32 {
        let (entry, exit) = self.interval(squared_core);
        let top = smaller(height, exit);
        // The top is the higher end unless the axis is inclined by more than 90° from the hub normal.
        let depth = larger(self.z + top * self.slope, self.z + entry * self.slope);
        let meets = (self.discriminant(squared_core) > 0.0) & (entry < top);
        if meets { larger(depth, 0.0) } else { 0.0 }
    }

    /// Where the ray enters the cutter with its rounded corner, given where it enters the sharp one.
    ///
    /// The distance to the rounded body is convex along the ray and the sharp body contains the rounded
    /// one, so Newton steps from the sharp entry come closer without passing it.
    #[inline(always)]
    pub(super) fn corner_entry(&self, sharp_entry: f32, cutter: &FieldCutter) -> f32 {
        let inner = cutter.radius - cutter.corner_radius;
        if inner <= 0.0 {
            return self.ball_entry(sharp_entry, cutter.radius);
        }
        let mut height = sharp_entry;
        for _ in 0..CORNER_STEPS {
            let squared = self.squared_distance + height * (2.0 * self.closing + height * self.squared_sine);
            let distance = larger(squared, MIN_SQUARED_SINE).sqrt();
            let out = larger(distance - inner, 0.0);
            let down = larger(cutter.corner_radius - (self.z + height * self.slope), 0.0);
            let length = (out * out + down * down).sqrt();
            let gap = length - cutter.corner_radius;
            if gap <= CORNER_TOLERANCE {
                return height;
            }
            let receding = (self.closing + height * self.squared_sine) / distance;
            let rate = (out * receding - down * self.slope) / length;
            if rate >= 0.0 {
                return FAR;
            }
            height -= gap / rate;
        }
        height
    }

    /// As [`Self::corner_entry`] of a ball, whose entry has a closed form: the root of a quadratic, taken
    /// from the sharp entry on so that its numbers are small.
    #[inline(always)]
    pub(super) fn ball_entry(&self, sharp_entry: f32, radius: f32) -> f32 {
        let squared =
            self.squared_distance + sharp_entry * (2.0 * self.closing + sharp_entry * self.squared_sine);
        let down = larger(radius - (self.z + sharp_entry * self.slope), 0.0);
        let outside = squared + down * down - radius * radius;
        let nearing = down * self.slope - (self.closing + sharp_entry * self.squared_sine);
        let discriminant = nearing * nearing - outside;
        let further = outside / larger(nearing + larger(discriminant, 0.0).sqrt(), MIN_COSINE);
        let met = if nearing > 0.0 && discriminant >= 0.0 { sharp_entry + further } else { FAR };
        if outside <= 2.0 * radius * CORNER_TOLERANCE { sharp_entry } else { met }
    }
}

/// [`Meeting`]s of a row of cells, by component.
#[derive(Default)]
pub(super) struct MeetingRow {
    z: LaneRow<f32>,
    slope: LaneRow<f32>,
    squared_sine: LaneRow<f32>,
    closing: LaneRow<f32>,
    squared_distance: LaneRow<f32>,
}

impl MeetingRow {
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, meeting: Meeting) {
        self.z[lane] = meeting.z;
        self.slope[lane] = meeting.slope;
        self.squared_sine[lane] = meeting.squared_sine;
        self.closing[lane] = meeting.closing;
        self.squared_distance[lane] = meeting.squared_distance;
    }

    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Meeting {
        Meeting {
            z: self.z[lane],
            slope: self.slope[lane],
            squared_sine: self.squared_sine[lane],
            closing: self.closing[lane],
            squared_distance: self.squared_distance[lane],
        }
    }
}

#[inline(always)]
pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// All bits set if `condition` holds: combines with a lane's value where an `if` would become a branch.
#[inline(always)]
pub(super) fn mask(condition: bool) -> u32 {
    u32::from(condition).wrapping_neg()
}

/// The larger of two numbers. Unlike `f32::max` it does not handle NaN, and so is one instruction.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; see [`larger`].
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greatest value of a row, at least 0.
#[inline(always)]
pub(super) fn greatest(row: LaneRow<f32>) -> f32 {
    // Pairwise reduction: in a chain of comparisons over the lanes each would wait for the one before.
    let mut row = row;
    let mut half = TILE / 2;
    while half > 0 {
        for lane in 0..half {
            row[lane] = larger(row[lane], row[lane + half]);
        }
        half /= 2;
    }
    larger(row[0], 0.0)
}
