//! Hub and shroud: from described curves to the parts of them that bound the channel.

use super::curve_order::{HubProfile, hub_profile, reversed, runs_backwards};
use super::description::{CurveDescription, PartDescription, PartError};
use crate::error::ErrorCode;
use crate::geometry::meridian::CurvePoint;
use crate::geometry::{Cubic, Meridional, MeridionalCurve};

/// Length ahead of the leading edge, as a share of that of the channel, from which on a shroud is inlet duct.
pub(super) const DUCT_FROM: f64 = 0.5;
/// The same, from which on a shroud is left out of meshes and solids of the wheel.
const SHROUD_AHEAD: f64 = 0.12;
/// Largest s at which hub and shroud may touch: they meet at the leading edge of blades whose height starts
/// at zero.
const MEETING_S: f64 = 0.02;

/// Hub or shroud: a meridional curve with s = 0 where the main blade's leading edge meets it and
/// s = 1 at the rim, proportional to arc length. The curve may reach upstream of s = 0 (hub nose); it
/// ends at s = 1.
#[derive(Clone, Debug)]
pub struct Flowpath {
    curve: MeridionalCurve,
    /// Arc length at s = 0, mm.
    leading_edge: f64,
    /// s at which the wheel begins.
    wheel_from: f64,
}

impl Flowpath {
    /// The hub: all of `curve` up to the rim, as a tool can meet its nose however far ahead of the blades it
    /// is. `leading_edge` and `rim` are arc lengths, mm.
    pub(super) fn of_hub(curve: &MeridionalCurve, leading_edge: f64, rim: f64) -> Self {
        let wheel_from = -leading_edge / (rim - leading_edge);
        Self { curve: curve.piece(0.0, rim), leading_edge, wheel_from }
    }

    /// The shroud: the part of `curve` along the channel.
    pub(super) fn of_shroud(curve: &MeridionalCurve, leading_edge: f64, rim: f64) -> Self {
        let length = rim - leading_edge;
        let start = (leading_edge - DUCT_FROM * length).max(0.0);
        let leading_edge = leading_edge - start;
        let wheel_from = (-leading_edge / length).max(-SHROUD_AHEAD);
        Self { curve: curve.piece(start, rim), leading_edge, wheel_from }
    }

    /// The curve, by arc length; its normal points away from the hub body.
    pub fn curve(&self) -> &MeridionalCurve {
        &self.curve
    }

    /// Arc length from s = 0 to s = 1, mm.
    pub fn length(&self) -> f64 {
        self.curve.length() - self.leading_edge
    }

    /// Arc length of the curve at `s`, mm.
    pub fn arc_at(&self, s: f64) -> f64 {
        self.leading_edge + s * self.length()
    }

    /// s at arc length `t` of the curve.
    pub fn s_at(&self, t: f64) -> f64 {
        (t - self.leading_edge) / self.length()
    }

    /// s at which the wheel begins: for the hub that of the curve, for the shroud slightly ahead of the
    /// blades.
    pub fn wheel_from(&self) -> f64 {
        self.wheel_from
    }

    /// Range of s the curve covers: (≤ 0, 1).
    pub fn s_range(&self) -> (f64, f64) {
        (self.s_at(0.0), 1.0)
    }

    /// Point at fraction `s` of the arc length, extended linearly beyond the curve's ends.
    pub fn point(&self, s: f64) -> Meridional {
        self.curve.point(self.arc_at(s))
    }

    /// Point, tangent, normal and curvature at `s`.
    pub fn at(&self, s: f64) -> CurvePoint {
        self.curve.at(self.arc_at(s))
    }

    /// Unit normal at `s`, away from the hub body (for the hub: into the channel).
    pub fn normal(&self, s: f64) -> Meridional {
        self.at(s).normal
    }
}

/// The curves of hub and shroud of a description, from inlet to outlet. Of a hub given as the profile of the
/// whole body only the side towards the blades is used, and curves that run from outlet to inlet are
/// reversed; lines about both are added to `notes`.
pub(super) fn channel_curves(
    d: &PartDescription,
    notes: &mut Vec<String>,
) -> Result<(MeridionalCurve, MeridionalCurve), PartError> {
    let hub = build_curve(&d.hub, d.hub_line, "hub")?;
    let shroud = build_curve(&d.shroud, d.shroud_line, "shroud")?;
    let mut outwards = |built: MeridionalCurve, given: &CurveDescription, line: usize, name: &str| {
        if !runs_backwards(&built, &d.main) {
            return Ok(built);
        }
        notes.push(format!("the {name} is given from outlet to inlet; it is reversed"));
        build_curve(&reversed(given), line, name)
    };
    let shroud = outwards(shroud, &d.shroud, d.shroud_line, "shroud")?;
    let profile = match &d.hub {
        CurveDescription::Points(points) => hub_profile(points, &shroud),
        CurveDescription::BSpline { .. } => HubProfile::Channel,
    };
    match profile {
        HubProfile::Channel => Ok((outwards(hub, &d.hub, d.hub_line, "hub")?, shroud)),
        HubProfile::Body(side) => {
            let rim = side.iter().map(|p| p.r).fold(0.0, f64::max);
            let side = CurveDescription::Points(side);
            let hub = outwards(build_curve(&side, d.hub_line, "hub")?, &side, d.hub_line, "hub")?;
            notes.push(format!(
                "the hub is the profile of its body; of it the side towards the blades is used, up to \
                 r = {rim:.2} mm"
            ));
            Ok((hub, shroud))
        }
        HubProfile::Unclear(rim) => Err(PartError::new(
            ErrorCode::FlowCurve,
            d.hub_line,
            format!("the hub runs past the rim: it turns back at r = {rim:.2} mm"),
            "give only its side towards the blades, from inlet to rim",
        )),
    }
}

/// Builds and validates the curve of a description; `name` identifies it in messages.
fn build_curve(
    description: &CurveDescription,
    line: usize,
    name: &str,
) -> Result<MeridionalCurve, PartError> {
    let finite = |points: &[Meridional]| {
        points.iter().all(|p| p.r.is_finite() && p.z.is_finite() && p.r.abs() < 1e5 && p.z.abs() < 1e5)
    };
    let few = || {
        PartError::new(
            ErrorCode::FlowCurve,
            line,
            format!("the {name} has fewer than two different points"),
            "give its meridional curve, inlet to outlet".to_string(),
        )
    };
    let wild = || {
        PartError::new(
            ErrorCode::FlowCurve,
            line,
            format!("a {name} point is not a number or further than 100 m away"),
            "check the points and the unit".to_string(),
        )
    };
    match description {
        CurveDescription::Points(points) => {
            if !finite(points) {
                return Err(wild());
            }
            let mut points = points.clone();
            points.dedup_by(|a, b| a.distance(*b) < 1e-6);
            if points.len() < 2 {
                return Err(few());
            }
            Ok(MeridionalCurve::through(&points))
        }
        CurveDescription::BSpline { control, degree, knots } => {
            if !finite(control) {
                return Err(wild());
            }
            if control.len() < 2 || !(1..=3).contains(degree) || control.len() <= *degree {
                return Err(few());
            }
            let knots = if knots.is_empty() { clamped_knots(control.len(), *degree) } else { knots.clone() };
            let increasing = knots.windows(2).all(|k| k[1] >= k[0])
                && knots.len() == control.len() + degree + 1
                && knots[control.len()] > knots[*degree];
            if !increasing {
                return Err(PartError::new(
                    ErrorCode::FlowCurve,
                    line,
                    format!("the {name}'s knots do not fit its control points"),
                    format!("give {} non-decreasing knots or none", control.len() + degree + 1),
                ));
            }
            let control: Vec<[f64; 2]> = control.iter().map(|p| [p.r, p.z]).collect();
            Ok(MeridionalCurve::from_cubic(&Cubic::b_spline(&control, *degree, &knots), 512))
        }
    }
}

fn clamped_knots(count: usize, degree: usize) -> Vec<f64> {
    let inner = count - degree;
    (0..count + degree + 1).map(|i| i.saturating_sub(degree).min(inner) as f64 / inner as f64).collect()
}

/// Orients the normals of both curves away from the hub body; rejects swapped curves.
pub(super) fn orient_normals(
    hub: MeridionalCurve,
    shroud: MeridionalCurve,
    d: &PartDescription,
) -> Result<(MeridionalCurve, MeridionalCurve), PartError> {
    let swapped = || {
        PartError::new(
            ErrorCode::CurvesSwapped,
            d.hub_line,
            "hub and shroud are swapped: the hub lies outside the shroud".to_string(),
            "exchange the two curves".to_string(),
        )
    };
    let middle = shroud.point(0.5 * shroud.length());
    let hub = hub.with_outer_side_towards(middle);
    // Near the inlet the hub must be nearer to the rotation axis than the shroud.
    let (h0, s0) = (hub.at(0.35 * hub.length()), shroud.at(0.35 * shroud.length()));
    if h0.normal.r < 0.0 && h0.point.r > s0.point.r {
        return Err(swapped());
    }
    let beyond = middle.lerp(hub.point(hub.project(middle).0), -1.0);
    Ok((hub, shroud.with_outer_side_towards(beyond)))
}

/// Checks that both curves bound the channel of a centrifugal impeller.
pub(super) fn check_channel(hub: &Flowpath, shroud: &Flowpath, d: &PartDescription) -> Result<(), PartError> {
    let (h0, s0) = (hub.point(0.0), shroud.point(0.0));
    // A leading edge may be axial, with both ends at the same radius, or a single point. That of swapped
    // curves is radial, with the end on the hub outside.
    if h0.r - s0.r > 0.7 * h0.distance(s0) && h0.r > s0.r {
        return Err(PartError::new(
            ErrorCode::CurvesSwapped,
            d.hub_line,
            format!(
                "hub and shroud are swapped: at the leading edge the hub is at r = {:.2}, the shroud at \
                 {:.2}",
                h0.r, s0.r
            ),
            "exchange the two curves".to_string(),
        ));
    }
    let rim = hub.at(1.0);
    // With mixed flow the hub may leave below the outer diameter of the inlet.
    if rim.tangent.r < 0.5 || rim.point.r < 1.05 * h0.r {
        return Err(PartError::new(
            ErrorCode::NoRadialOutlet,
            d.hub_line,
            format!(
                "no radial outlet: the hub leaves at r = {:.1} mm, {:.0}° from the axis",
                rim.point.r,
                rim.tangent.r.atan2(rim.tangent.z.abs()).to_degrees().round() + 0.0
            ),
            "open a centrifugal impeller; axial rotors are not supported".to_string(),
        ));
    }
    for i in 0..=200 {
        let s = f64::from(i) / 200.0;
        let (_, gap) = hub.curve().project(shroud.point(s));
        // Blades may start with zero height, where the shroud leaves the hub.
        let least = if s < MEETING_S { -1e-3 } else { 1e-3 };
        if gap <= least * hub.length() {
            return Err(PartError::new(
                ErrorCode::CurvesMeet,
                d.shroud_line,
                format!("hub and shroud cross or touch at {:.0} % of the channel", 100.0 * s),
                "check both curves; the shroud must stay outside the hub".to_string(),
            ));
        }
        if hub.point(s).r <= 0.0 {
            return Err(PartError::new(
                ErrorCode::FlowCurve,
                d.hub_line,
                format!("the hub reaches the rotation axis at {:.0} % of the channel", 100.0 * s),
                "check the hub's r coordinates".to_string(),
            ));
        }
    }
    Ok(())
}
