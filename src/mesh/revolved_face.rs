//! A face of revolution of a wheel, hub or cover, and its curve.

use super::profile::{Course, FittedProfile, MOSTLY};
use super::surface::MeshSurface;
use crate::geometry::{Meridional, MeridionalCurve};

/// Shares of a face's stretches past the blades that are tried for its curve: smoothly joined to hub or cover
/// may be the rounded edge of a collar and the plane beyond, which one curve does not follow.
const PAST_BLADES: [f64; 6] = [1.0, 0.5, 0.25, 0.12, 0.06, 0.03];
/// Share of the area of a face on its curve from which on no shorter curve is tried.
const NEARLY_ALL: f64 = 0.9;

/// What a face of revolution may look like.
#[derive(Clone, Copy)]
pub(super) enum FaceShape {
    /// Smooth all along.
    Smooth,
    /// In straight pieces, with obtuse corners between them.
    Cornered,
}

impl FaceShape {
    /// Smallest cosine of the angle between neighbouring triangles of one face.
    pub fn min_cosine(self) -> f64 {
        match self {
            Self::Smooth => 0.9,
            Self::Cornered => 0.6,
        }
    }
}

/// A face of revolution of a wheel: hub or cover.
pub(super) struct RevolvedFace {
    /// Number of its group of triangles.
    pub number: usize,
    /// Points of its curve, inlet → outlet, mm.
    pub points: Vec<Meridional>,
    /// Its curve, with the outer side towards the blades.
    pub curve: MeridionalCurve,
    /// Extent of its curve along the course, mm.
    pub extent: (f64, f64),
    /// Of all corners of the wheel, whether the nearest place of the curve is one of its ends.
    pub at_end: Vec<bool>,
    /// Heights of all corners of the wheel over it, positive towards the blades, mm.
    pub heights: Vec<f64>,
    /// Smallest radius of its corners, mm.
    pub inner: f64,
}

impl RevolvedFace {
    /// A face with the points of its curve, which has its outer side towards the blades; with the corners of
    /// the wheel, and the smallest radius of its own.
    pub fn new(
        number: usize,
        points: Vec<Meridional>,
        curve: MeridionalCurve,
        (corners, inner): (&[Meridional], f64),
        course: &Course,
    ) -> Option<Self> {
        let ends = [points.first()?, points.last()?].map(|p| course.coordinates_of(*p).0);
        let feet_of: Vec<(f64, f64)> = corners.iter().map(|p| curve.project(*p)).collect();
        let inside = 1e-6 * curve.length()..=(1.0 - 1e-6) * curve.length();
        let at_end = feet_of.iter().map(|(t, _)| !inside.contains(t)).collect();
        let heights = feet_of.into_iter().map(|(_, height)| height).collect();
        Some(Self { number, points, curve, extent: (ends[0], ends[1]), at_end, heights, inner })
    }

    /// The face from the arc length `from` of its curve on.
    pub fn behind(&self, from: f64, corners: &[Meridional], course: &Course) -> Option<Self> {
        let curve = self.curve.piece(from, self.curve.length());
        let begin = course.coordinates_of(curve.point(0.0)).0;
        let rest = self.points.iter().filter(|p| course.coordinates_of(**p).0 > begin);
        let points = std::iter::once(curve.point(0.0)).chain(rest.copied()).collect();
        Self::new(self.number, points, curve, (corners, self.inner), course)
    }
}

/// The curve of a smooth face of revolution with the corners `points` and the triangles `own`, over the
/// blades and as far past them as one curve follows the face. The blades touch the face at `feet`.
pub(super) fn curve_of(
    course: &Course,
    (points, own): (&[Meridional], &[usize]),
    feet: &[Meridional],
    middle: Meridional,
    (wheel, tolerance, shape): (&MeshSurface, f64, FaceShape),
) -> Option<FittedProfile> {
    let ((first, last), (from, to)) = (course.extent_of(points), course.extent_of(feet));
    let ranges: Vec<(f64, f64)> = PAST_BLADES
        .into_iter()
        .flat_map(|s| {
            [(s, 1.0), (1.0, s), (s, s)].map(|(a, b)| (from + (first - from) * a, to + (last - to) * b))
        })
        .skip(2)
        .collect();
    let within = |(from, to): (f64, f64)| -> (Vec<Meridional>, Vec<usize>) {
        let inside = |p: &Meridional| (from..=to).contains(&course.coordinates_of(*p).0);
        let corner = |i: u32| inside(&Meridional::from_point(&wheel.points[i as usize]));
        (
            points.iter().filter(|p| inside(p)).copied().collect(),
            own.iter().copied().filter(|t| wheel.triangles[*t].iter().all(|i| corner(*i))).collect(),
        )
    };
    let exact = ranges.iter().find_map(|range| {
        let (points, own) = within(*range);
        let line = match shape {
            FaceShape::Smooth => course.fit_curve(&points).filter(|p| p.max_deviation_mm < tolerance),
            FaceShape::Cornered => course.line_through(&points),
        };
        line.filter(|p| p.area_share_on_curve(wheel, &own, tolerance) > MOSTLY)
    });
    if exact.is_some() {
        return exact;
    }
    // A face with fillets continues smoothly up to the blades' noses: then the curve follows its bottom.
    let mut best: Option<(f64, FittedProfile)> = None;
    for range in ranges {
        let (points, own) = within(range);
        let Some(profile) = course.fit_bottom(&points, middle, tolerance) else { continue };
        let share = profile.area_share_on_curve(wheel, &own, tolerance);
        if best.as_ref().is_none_or(|(most, _)| share > *most) {
            best = Some((share, profile));
        }
        if share > NEARLY_ALL {
            break;
        }
    }
    best.filter(|(share, _)| *share > MOSTLY).map(|(_, profile)| profile)
}
