//! The curve of the shroud: of its body, or through the tips of the blades.

use super::profile::{Course, FittedProfile};
use super::shroud_ends::extend_ahead;
use super::surface::MeshSurface;
use super::tip_border::{covered_share, fit_tip_border, past_share, tip_extent};
use super::tip_faces::fit_tip_faces;
use super::tips::fit_tip_curve;
use super::walls::check_deviation;
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve, Point};
use crate::part::PartError;

/// Largest distance of a blade tip from the line of the tips, as a share of the diameter: tips are often not
/// turned in a model.
const TIP_TOLERANCE: f64 = 2e-3;
/// Share of the tips along the channel that the curve through their edges has to go along.
const MOST_OF_TIPS: f64 = 0.8;
/// How far that curve may go on past the tips, as a share of them.
const PAST_TIPS: f64 = 0.015;

/// A curve of the shroud.
pub(super) struct ShroudCurve {
    pub profile: FittedProfile,
    /// Whether the tips turn into leading and trailing edge past its ends.
    pub goes_past_tips: bool,
}

/// What the shroud of a wheel is found by.
pub(super) struct ShroudSearch<'a> {
    /// The main blade, within the channel.
    pub blade: &'a MeshSurface,
    /// Points of the hub's curve.
    pub hub: &'a [Meridional],
    pub course: &'a Course,
    /// Radius of the rim, mm.
    pub size: f64,
    /// Largest distance of a corner from the curve of a body, mm.
    pub tolerance: f64,
    /// Whether the meshes are of a CAD model.
    pub is_cad: bool,
}

impl ShroudSearch<'_> {
    /// The curve of a shroud that was `fitted` to its body, extended to where the blades begin, or else that
    /// through the tips. A line about what is not as it should be is added to `notes`.
    ///
    /// # Errors
    /// When no curve runs through the tips, or they are too far from it.
    pub fn curve(
        &self,
        fitted: Option<FittedProfile>,
        notes: &mut Vec<String>,
    ) -> Result<ShroudCurve, PartError> {
        let Some(mut profile) = fitted else { return self.through_tips(notes) };
        let mut goes_past_tips = self.goes_past(&profile);
        if !goes_past_tips && let Some(ahead) = extend_ahead(&mut profile, self.hub, self.blade) {
            notes.push(format!(
                "the blades begin {ahead:.2} mm ahead of the shroud, which goes on along their tips"
            ));
            goes_past_tips = self.goes_past(&profile);
        }
        Ok(ShroudCurve { profile, goes_past_tips })
    }

    /// Whether the tips of the blade go on past an end of its shroud, straight.
    fn goes_past(&self, shroud: &FittedProfile) -> bool {
        let (shroud, tolerance) = (MeridionalCurve::through(&shroud.points), self.tolerance);
        let inside = -tolerance..=shroud.length() + tolerance;
        let is_past = |p: &Point| {
            let (t, off) = shroud.project_past_ends(Meridional::from_point(p));
            off.abs() < tolerance && !inside.contains(&t)
        };
        self.blade.points.iter().any(is_past)
    }

    fn through_tips(&self, notes: &mut Vec<String>) -> Result<ShroudCurve, PartError> {
        // Meshes show their tips by sharp edges; models from CAD, which know their faces, often have none.
        let tips = match self.is_cad {
            false => self.along_tips().or_else(|| self.by_border()).or_else(|| self.by_edges()),
            true => self.by_faces().or_else(|| self.by_border()).or_else(|| self.by_edges()),
        };
        let ShroudCurve { profile, goes_past_tips } = tips.ok_or_else(|| {
            PartError::new(
                ErrorCode::NoShroud,
                0,
                "no shroud curve can be fitted to the blade tips",
                "give one with --role NODE=shroud",
            )
        })?;
        let off = profile.max_deviation_mm;
        if off > self.tolerance {
            notes.push(format!(
                "the blade tips are up to {off:.2} mm off the surface of revolution through them"
            ));
        }
        let most = self.tolerance.max(2.0 * self.size * TIP_TOLERANCE);
        Ok(ShroudCurve { profile: check_deviation(profile, "line of the blade tips", most)?, goes_past_tips })
    }

    /// The curve through sharp edges of the tips.
    fn by_edges(&self) -> Option<ShroudCurve> {
        let hub = MeridionalCurve::through(self.hub);
        let profile = fit_tip_curve(std::slice::from_ref(self.blade), &hub, self.course)?;
        Some(ShroudCurve { profile, goes_past_tips: false })
    }

    /// As [`Self::by_edges`], where it goes along the tips: edges of tips that are not turned make a curve
    /// along part of them only, and those of leading edges may lead it on past them.
    fn along_tips(&self) -> Option<ShroudCurve> {
        let extent = tip_extent(self.blade, self.hub, self.course);
        self.by_edges().filter(|ShroudCurve { profile, .. }| {
            extent.is_none_or(|extent| {
                let is_within = past_share(&profile.points, extent, self.course) < PAST_TIPS;
                is_within && covered_share(&profile.points, extent, self.course) > MOST_OF_TIPS
            })
        })
    }

    /// The curve along the border of the blade away from the hub.
    fn by_border(&self) -> Option<ShroudCurve> {
        let profile = fit_tip_border(self.blade, self.hub, self.course)?;
        Some(ShroudCurve { profile, goes_past_tips: true })
    }

    /// The curve through the faces that are tips.
    fn by_faces(&self) -> Option<ShroudCurve> {
        let profile = fit_tip_faces(self.blade, self.hub, self.course)?;
        (profile.max_deviation_mm < self.tolerance).then_some(ShroudCurve { profile, goes_past_tips: false })
    }
}
