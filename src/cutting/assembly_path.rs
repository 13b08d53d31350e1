//! Shank and holder of a tool along a move.
//!
//! A move along the axis is measured by what it sweeps, any other by conservative advancement
//! ([`AssemblyMove::advance`]). Where that ends at a collision, the worst pose is searched.

use super::assembly::{
    ASSEMBLY_TOLERANCE, AssemblyClearance, AssemblySurroundings, PartClearance, blade_distance, hub_distance,
};
use super::assembly_move::{Advance, AssemblyMove, SweptPiece};
use crate::setup::{AssemblyPart, AssemblySegment, Tool};

/// Distances beyond the required one up to which distances are measured along moves along the axis and along
/// others, these by the length of the move, mm: nothing need be looked at again until the tool has moved by
/// that.
const MIN_LOOK_AHEAD: f64 = 4.0;
const MAX_LOOK_AHEAD: f64 = 20.0;

/// Clearance of shank and holder over a move.
#[derive(Clone, Copy, Debug)]
pub struct PathClearance {
    /// The least; of what is further off than matters for the way to the next place the distance is not
    /// found.
    pub least: AssemblyClearance,
    /// How much more than required there is at the end, mm; 0 or less where that is not known.
    pub slack: f64,
    /// Up to which distance, mm, the least distances over the whole move are known; 0 where they are those of
    /// some of its poses.
    pub measured_to: f64,
}

impl PathClearance {
    /// Nothing near, and nothing measured.
    pub const FAR: Self = Self { least: AssemblyClearance::FAR, slack: 0.0, measured_to: 0.0 };
}

impl AssemblySurroundings<'_> {
    /// Clearance over a move whose start has `slack` mm of clearance more than required, 0 or less where that
    /// is not known.
    pub fn along(
        &self,
        tool: &Tool,
        segments: &[AssemblySegment],
        step: &AssemblyMove,
        slack: f64,
    ) -> PathClearance {
        let required = segments.iter().map(|segment| self.max_required(segment.part)).fold(0.0, f64::max);
        let cap = required + step.way.clamp(MIN_LOOK_AHEAD, MAX_LOOK_AHEAD);
        if slack < step.way
            && self.blank.is_none()
            && let Some(swept) = step.swept(segments)
        {
            let measured_to = required + MIN_LOOK_AHEAD;
            let mut least = self.swept_clearance(&swept, measured_to);
            if least.shank.collides() || least.holder.collides() {
                least = self.worst_along(tool, segments, (step, 0.0), &least, cap);
            }
            return PathClearance { least, slack: least.slack(), measured_to };
        }
        let mut least = AssemblyClearance::FAR;
        let advance = step.advance(slack, ASSEMBLY_TOLERANCE, |pose| {
            let here = self.at(tool, segments, pose, cap);
            least = least.worst_of(here);
            here.slack()
        });
        match advance {
            Advance::Free(slack) => PathClearance { least, slack, measured_to: 0.0 },
            Advance::Blocked(from) => {
                let unknown = PartClearance { distance: f64::NEG_INFINITY, missing: f64::INFINITY };
                let bound = AssemblyClearance { shank: unknown, holder: unknown, worst: None };
                let least = least.worst_of(self.worst_along(tool, segments, (step, from), &bound, cap));
                PathClearance { least, slack: 0.0, measured_to: 0.0 }
            }
        }
    }

    /// Clearance of what is swept, by parts; distances are measured up to `cap` mm.
    fn swept_clearance(&self, swept: &[SweptPiece], cap: f64) -> AssemblyClearance {
        let mut least = AssemblyClearance::FAR;
        for piece in swept {
            let of = least.of_part_mut(piece.part);
            *of = of.worst_of(self.clearance_of_swept(piece, cap.min(of.distance)));
        }
        least
    }

    /// Clearance of a piece that is swept; distances are measured up to `cap` mm.
    fn clearance_of_swept(&self, piece: &SweptPiece, cap: f64) -> PartClearance {
        let cap = cap.max(self.max_required(piece.part));
        let hub = self.hub_distance_of_swept(piece, cap);
        self.clearance_of([hub, blade_distance(self.finished, &piece.frustum, cap)], piece.part, cap)
    }

    /// Signed distance from the hub of a piece that is swept, mm, or `cap` where it is not less.
    fn hub_distance_of_swept(&self, piece: &SweptPiece, cap: f64) -> f64 {
        piece.short_pieces().fold(cap, |hub, piece| hub_distance(self.finished, &piece, hub))
    }

    /// Signed distance from the finished part of a piece that is swept, mm, or `cap` where it is not less.
    pub fn swept_distance(&self, piece: &SweptPiece, cap: f64) -> f64 {
        let hub = self.hub_distance_of_swept(piece, cap);
        hub.min(blade_distance(self.finished, &piece.frustum, hub.max(0.0)))
    }

    /// Clearance over a move with a collision, from a share of it on, and the pose where the holder misses
    /// most. `bound` is known to be no more than the clearance: it is exact where nothing of the part is
    /// inside the tool, of others the worst pose is searched.
    fn worst_along(
        &self,
        tool: &Tool,
        segments: &[AssemblySegment],
        (step, from): (&AssemblyMove, f64),
        bound: &AssemblyClearance,
        cap: f64,
    ) -> AssemblyClearance {
        let mut worst = AssemblyClearance::FAR;
        for part in AssemblyPart::ALL {
            let known = bound.of_part(part);
            let is_exact = known.distance >= 0.0;
            if is_exact && (part == AssemblyPart::Shank || !known.collides()) {
                *worst.of_part_mut(part) = known;
                continue;
            }
            let own: Vec<AssemblySegment> =
                segments.iter().filter(|segment| segment.part == part).copied().collect();
            // A cylinder never reaches deeper into the part than its sweep does. A cone sweeps several
            // pieces, of which none bounds the depth.
            let is_bounded = is_exact || own.iter().all(|segment| segment.radii[0] == segment.radii[1]);
            let most = if is_bounded { known.missing } else { f64::INFINITY };
            let mut found = PartClearance::FAR;
            let (_, share) = step.max_over(from, [ASSEMBLY_TOLERANCE, most], |share| {
                let here = self.at(tool, &own, step.pose(share), cap).of_part(part);
                found = found.worst_of(here);
                here.missing
            });
            *worst.of_part_mut(part) = if is_exact { known } else { found };
            if part == AssemblyPart::Holder {
                worst.worst = Some(step.pose(share));
            }
        }
        worst
    }
}
