//! The impeller: hub, shroud and blades, trimmed to each other and checked.

use std::f64::consts::TAU;

use super::camber;
use super::description::{BladeDescription, CamberSpan, CurveDescription, PartDescription, PartError};
use super::side::{BladeSide, common_parameters};
use crate::geometry::meridian::CurvePoint;
use crate::geometry::{Cubic, Meridional, MeridionalCurve, Point, search, wrap_angle};

/// Hub or shroud: a meridional curve with s = 0 where the main blade's leading edge meets it and
/// s = 1 at the rim, proportional to arc length. The curve may reach upstream of s = 0 (hub nose); it
/// ends at s = 1.
#[derive(Clone, Debug)]
pub struct Flowpath {
    curve: MeridionalCurve,
    /// Arc length at s = 0, mm.
    leading_edge: f64,
}

impl Flowpath {
    fn new(curve: &MeridionalCurve, leading_edge: f64, rim: f64) -> Self {
        // What lies further upstream than half the channel is inlet duct, not impeller.
        let start = (leading_edge - 0.5 * (rim - leading_edge)).max(0.0);
        Self { curve: curve.piece(start, rim), leading_edge: leading_edge - start }
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

    /// Range of s the curve covers: (≤ 0, 1).
    pub fn s_range(&self) -> (f64, f64) {
        (self.s_at(0.0), 1.0)
    }

    /// Point at fraction `s` of the arc length; straight on beyond the curve's ends.
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

/// A blade in its place (the others of its row follow by rotation by the pitch).
#[derive(Clone, Debug)]
pub struct Blade {
    /// Suction side.
    pub suction: BladeSide,
    /// Pressure side. At LE both sides meet; at a blunt TE they do not.
    pub pressure: BladeSide,
}

impl Blade {
    /// The blade turned about the rotation axis.
    pub fn rotated(&self, angle: f64) -> Self {
        Self { suction: self.suction.rotated(angle), pressure: self.pressure.rotated(angle) }
    }
}

/// A centrifugal impeller.
#[derive(Clone, Debug)]
pub struct Impeller {
    /// Name of the part.
    pub name: String,
    /// Number of main blades.
    pub blade_count: usize,
    /// Hub.
    pub hub: Flowpath,
    /// Shroud.
    pub shroud: Flowpath,
    /// Main blade.
    pub main: Blade,
    /// Splitters of one pitch, turned into channel 1.
    pub splitters: Vec<Blade>,
    pitch: f64,
}

/// Most sections (or spans) of a blade.
const MAX_SECTIONS: usize = 200;
/// Most points of a section.
const MAX_SECTION_POINTS: usize = 20_000;
/// Fewest and most main blades a wheel may have.
const BLADE_COUNTS: std::ops::RangeInclusive<usize> = 2..=200;

impl Impeller {
    /// Trims, extends and checks a description.
    ///
    /// # Errors
    /// [`PartError`] with the line of the file, when the description is no centrifugal impeller: hub and
    /// shroud swapped or crossing, blades that miss hub or shroud, no radial outlet, absurd
    /// blade counts, overlapping blades.
    pub fn build(description: &PartDescription) -> Result<Self, PartError> {
        let d = description;
        if !BLADE_COUNTS.contains(&d.blade_count) {
            return Err(PartError::new(
                d.count_line,
                format!("{} main blades", d.blade_count),
                format!("give {} to {}", BLADE_COUNTS.start(), BLADE_COUNTS.end()),
            ));
        }
        let hub = curve(&d.hub, d.hub_line, "hub")?;
        let shroud = curve(&d.shroud, d.shroud_line, "shroud")?;
        let (hub, shroud) = face(hub, shroud, d)?;

        let main = RawBlade::new(&d.main, &hub, &shroud)?;
        let splitters: Vec<RawBlade> =
            d.splitters.iter().map(|s| RawBlade::new(s, &hub, &shroud)).collect::<Result<_, _>>()?;
        let hub_ends = main.ends_on(&hub, 0.0);
        let shroud_ends = main.ends_on(&shroud, 1.0);
        for ((start, end), (line, name)) in
            [(hub_ends, (d.hub_line, "hub")), (shroud_ends, (d.shroud_line, "shroud"))]
        {
            if end - start < 1e-3 * hub.length() {
                return Err(PartError::new(
                    line,
                    format!("the main blade covers no stretch of the {name}"),
                    "check that blade sections run LE to TE and use the units of the curves".to_string(),
                ));
            }
        }
        let hub = Flowpath::new(&hub, hub_ends.0, hub_ends.1);
        let shroud = Flowpath::new(&shroud, shroud_ends.0, shroud_ends.1);
        check_channel(&hub, &shroud, d)?;

        let main = main.blade;
        let middle = |side: &BladeSide| {
            let p = side.point(0.6, 0.5);
            p.y.atan2(p.x)
        };
        let towards_suction = wrap_angle(middle(&main.suction) - middle(&main.pressure));
        let pitch = (TAU / d.blade_count as f64).copysign(towards_suction);
        let splitters = splitters
            .into_iter()
            .map(|s| {
                // Turn the splitter by whole pitches into the channel beside the main suction side.
                let ahead = wrap_angle(splitter_angle(&s.blade, &main)) / pitch;
                s.blade.rotated(-ahead.floor() * pitch)
            })
            .collect();
        let part =
            Self { name: d.name.clone(), blade_count: d.blade_count, hub, shroud, main, splitters, pitch };
        part.check_passages(blade_line(&d.main))?;
        Ok(part)
    }

    /// Angle between neighbouring main blades, rad; signed: channel 1 lies between the suction side
    /// of `main` and the pressure side of `main` turned about Z by this angle.
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// Direction of the axis of rotation that points out of the inlet, away from the back of the wheel.
    pub fn out_of_inlet(&self) -> crate::geometry::Vector {
        let inwards = self.hub.point(0.0).z >= self.hub.point(1.0).z;
        crate::geometry::Vector::z() * if inwards { 1.0 } else { -1.0 }
    }

    /// Outer radius, mm.
    pub fn rim_radius(&self) -> f64 {
        self.hub.point(1.0).r.max(self.shroud.point(1.0).r)
    }

    /// Meridional point at s and η on the straight line from hub (η = 0) to shroud (η = 1).
    pub fn meridional(&self, s: f64, eta: f64) -> Meridional {
        self.hub.point(s).lerp(self.shroud.point(s), eta)
    }

    /// Neighbouring blades may not overlap anywhere.
    fn check_passages(&self, line: usize) -> Result<(), PartError> {
        for i in 0..=40 {
            let u = f64::from(i) / 40.0;
            for v in [0.0, 0.5, 1.0] {
                let (a, b) = (self.main.suction.point(u, v), self.main.pressure.point(u, v));
                let thickness = wrap_angle(a.y.atan2(a.x) - b.y.atan2(b.x)) * self.pitch.signum();
                if thickness > 0.9 * self.pitch.abs() {
                    return Err(PartError::new(
                        line,
                        format!(
                            "{} blades overlap: at {:.0} % of the chord a blade is {:.1}° thick in a pitch of {:.1}°",
                            self.blade_count,
                            100.0 * u,
                            thickness.to_degrees(),
                            self.pitch.abs().to_degrees()
                        ),
                        "give fewer or thinner blades".to_string(),
                    ));
                }
            }
        }
        Ok(())
    }
}

fn blade_line(description: &BladeDescription) -> usize {
    match description {
        BladeDescription::Sections { line, .. } | BladeDescription::Camber { line, .. } => *line,
    }
}

/// Angle of a splitter ahead of the main blade's suction side at the same radius and height.
fn splitter_angle(splitter: &Blade, main: &Blade) -> f64 {
    let p = splitter.suction.point(0.9, 0.5);
    let wanted = Meridional::of(&p);
    let nearest = (0..=400)
        .map(|i| main.suction.point(f64::from(i) / 400.0, 0.5))
        .min_by(|a, b| Meridional::of(a).distance(wanted).total_cmp(&Meridional::of(b).distance(wanted)))
        .unwrap_or(p);
    p.y.atan2(p.x) - nearest.y.atan2(nearest.x)
}

fn curve(description: &CurveDescription, line: usize, name: &str) -> Result<MeridionalCurve, PartError> {
    let finite = |points: &[Meridional]| {
        points.iter().all(|p| p.r.is_finite() && p.z.is_finite() && p.r.abs() < 1e5 && p.z.abs() < 1e5)
    };
    let few = || {
        PartError::new(
            line,
            format!("the {name} has fewer than two different points"),
            "give its meridional curve, inlet to outlet".to_string(),
        )
    };
    let wild = || {
        PartError::new(
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

/// Turns the normals of both curves away from the hub body; catches swapped curves.
fn face(
    hub: MeridionalCurve,
    shroud: MeridionalCurve,
    d: &PartDescription,
) -> Result<(MeridionalCurve, MeridionalCurve), PartError> {
    let swapped = || {
        PartError::new(
            d.hub_line,
            "hub and shroud are swapped: the hub lies outside the shroud".to_string(),
            "exchange the two curves".to_string(),
        )
    };
    let middle = shroud.point(0.5 * shroud.length());
    let hub = hub.facing(middle);
    // At the inlet the hub is nearer to the rotation axis; the inlet is where the curves are furthest in.
    let (h0, s0) = (hub.at(0.35 * hub.length()), shroud.at(0.35 * shroud.length()));
    if h0.normal.r < 0.0 && h0.point.r > s0.point.r {
        return Err(swapped());
    }
    let beyond = middle.lerp(hub.point(hub.project(middle).0), -1.0);
    Ok((hub, shroud.facing(beyond)))
}

fn check_channel(hub: &Flowpath, shroud: &Flowpath, d: &PartDescription) -> Result<(), PartError> {
    let (h0, s0) = (hub.point(0.0), shroud.point(0.0));
    if h0.r >= s0.r {
        return Err(PartError::new(
            d.hub_line,
            format!(
                "hub and shroud are swapped: at the leading edge the hub is at r = {:.2}, the shroud at {:.2}",
                h0.r, s0.r
            ),
            "exchange the two curves".to_string(),
        ));
    }
    let rim = hub.at(1.0);
    if rim.tangent.r < 0.5 || rim.point.r < 1.05 * s0.r {
        return Err(PartError::new(
            d.hub_line,
            format!(
                "no radial outlet: the hub leaves at r = {:.1} mm, {:.0}° from the axis",
                rim.point.r,
                rim.tangent.r.atan2(rim.tangent.z.abs()).to_degrees().round() + 0.0
            ),
            "open a centrifugal impeller; axial rotors are not planned".to_string(),
        ));
    }
    for i in 0..=200 {
        let s = f64::from(i) / 200.0;
        let (_, gap) = hub.curve().project(shroud.point(s));
        if gap <= 1e-3 * hub.length() {
            return Err(PartError::new(
                d.shroud_line,
                format!("hub and shroud cross or touch at {:.0} % of the channel", 100.0 * s),
                "check both curves; the shroud must stay outside the hub".to_string(),
            ));
        }
        if hub.point(s).r <= 0.0 {
            return Err(PartError::new(
                d.hub_line,
                format!("the hub reaches the rotation axis at {:.0} % of the channel", 100.0 * s),
                "check the hub's r coordinates".to_string(),
            ));
        }
    }
    Ok(())
}

/// A blade lofted and trimmed, before s is known.
struct RawBlade {
    blade: Blade,
}

impl RawBlade {
    fn new(
        description: &BladeDescription,
        hub: &MeridionalCurve,
        shroud: &MeridionalCurve,
    ) -> Result<Self, PartError> {
        let line = blade_line(description);
        let made;
        let (suction, pressure) = match description {
            BladeDescription::Sections { suction, pressure, .. } => (suction, pressure),
            BladeDescription::Camber { spans, .. } => {
                check_spans(spans, line)?;
                made = camber::sections(spans, hub, shroud);
                (&made.0, &made.1)
            }
        };
        let side = |sections: &[Vec<Point>], name: &str| trimmed(sections, hub, shroud, line, name);
        let blade = Blade { suction: side(suction, "suction")?, pressure: side(pressure, "pressure")? };
        Ok(Self { blade })
    }

    /// Arc lengths on `curve` of leading edge and rim, along the blade's edge at `v`.
    fn ends_on(&self, curve: &MeridionalCurve, v: f64) -> (f64, f64) {
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for side in [&self.blade.suction, &self.blade.pressure] {
            for i in 0..=60 {
                let (t, _) = curve.project(Meridional::of(&side.point(0.15 * f64::from(i) / 60.0, v)));
                start = start.min(t);
            }
            let (t, _) = curve.project(Meridional::of(&side.point(1.0, v)));
            end = end.max(t);
        }
        (start, end)
    }
}

fn check_spans(spans: &[CamberSpan], line: usize) -> Result<(), PartError> {
    let fault = |what: &str, cure: &str| Err(PartError::new(line, what.to_string(), cure.to_string()));
    if spans.len() < 2 {
        return fault("a blade needs two spans or more", "give one at the hub and one at the shroud");
    }
    if spans.len() > MAX_SECTIONS {
        return fault("a blade with more than 200 spans", "give fewer, hub to shroud");
    }
    if spans.windows(2).any(|w| w[1].span <= w[0].span) {
        return fault("the spans of a blade do not increase", "order them hub to shroud, 0 to 1");
    }
    for span in spans {
        let increasing =
            |pairs: &[(f64, f64)]| !pairs.is_empty() && pairs.windows(2).all(|w| w[1].0 > w[0].0 + 1e-9);
        if !increasing(&span.angle) || !increasing(&span.thickness) {
            return fault(
                "angle or thickness has no values or fractions that do not increase",
                "give [fraction, value] pairs with growing fractions from 0 to 1",
            );
        }
        if span.angle.iter().any(|a| a.1.abs() > 85f64.to_radians()) {
            return fault("a blade angle beyond 85°", "angles count from the meridional direction");
        }
        if span.thickness.iter().any(|t| !(t.1 > 0.0 && t.1 < 1e3)) {
            return fault("a blade without thickness", "give thicknesses above 0 mm");
        }
        if !(0.0..0.95).contains(&span.leading_edge) {
            return fault("a leading edge outside the channel", "give a fraction from 0 to below 0.95");
        }
    }
    Ok(())
}

/// Lofts raw sections and trims (or extends) the surface to hub and shroud.
fn trimmed(
    sections: &[Vec<Point>],
    hub: &MeridionalCurve,
    shroud: &MeridionalCurve,
    line: usize,
    name: &str,
) -> Result<BladeSide, PartError> {
    let longest = sections.iter().map(Vec::len).max().unwrap_or(0);
    if sections.len() > MAX_SECTIONS || longest > MAX_SECTION_POINTS {
        return Err(PartError::new(
            line,
            format!("the {name} side has {} sections of up to {longest} points", sections.len()),
            format!("give at most {MAX_SECTIONS} sections of {MAX_SECTION_POINTS} points"),
        ));
    }
    if sections.len() < 2 {
        return Err(PartError::new(
            line,
            format!("the {name} side has {} section", sections.len()),
            "give two sections or more, hub to tip".to_string(),
        ));
    }
    let spread = |s: &[Point]| s.iter().any(|p| (p - s[0]).norm() > 1e-6);
    let wild = |s: &[Point]| s.iter().any(|p| !p.iter().all(|x| x.is_finite() && x.abs() < 1e5));
    if sections.iter().any(|s| s.len() < 4 || wild(s) || !spread(s)) {
        return Err(PartError::new(
            line,
            format!("a section of the {name} side has fewer than four different points"),
            "give the points of each side, LE to TE".to_string(),
        ));
    }
    let (u, sections) = common_parameters(sections);
    let mut heights = vec![0.0];
    for pair in sections.windows(2) {
        let gap = pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).norm()).sum::<f64>() / u.len() as f64;
        if gap < 1e-6 {
            return Err(PartError::new(
                line,
                format!("two sections of the {name} side coincide"),
                "give sections at different spans".to_string(),
            ));
        }
        heights.push(heights[heights.len() - 1] + gap);
    }
    let total = heights[heights.len() - 1];
    let stations: Vec<f64> = heights.iter().map(|h| h / total).collect();
    let raw = BladeSide::loft(&u, &stations, &sections);

    let miss = |surface: &str, u: f64| {
        PartError::new(
            line,
            format!("the {name} side misses the {surface} at {:.0} % of its chord", 100.0 * u),
            format!("give sections that reach the {surface} (or nearly so), in the same units"),
        )
    };
    let count = sections.len();
    let mut cut = vec![Vec::with_capacity(u.len()); count];
    let (mut hub_guess, mut shroud_guess) = (None, None);
    for &u in &u {
        let bottom = crossing(&raw, u, hub, 0.0, &mut hub_guess).ok_or_else(|| miss("hub", u))?;
        let top = crossing(&raw, u, shroud, 1.0, &mut shroud_guess).ok_or_else(|| miss("shroud", u))?;
        if top - bottom < 1e-3 {
            return Err(miss("channel between hub and shroud", u));
        }
        for (k, section) in cut.iter_mut().enumerate() {
            section.push(raw.point(u, bottom + (top - bottom) * k as f64 / (count - 1) as f64));
        }
    }
    let even: Vec<f64> = (0..count).map(|k| k as f64 / (count - 1) as f64).collect();
    Ok(BladeSide::loft(&u, &even, &cut))
}

/// v near `around` at which the ruling u of `side` crosses `curve`; `guess` carries the arc length on.
fn crossing(
    side: &BladeSide,
    u: f64,
    curve: &MeridionalCurve,
    around: f64,
    guess: &mut Option<f64>,
) -> Option<f64> {
    let mut near = match *guess {
        Some(t) => t,
        None => curve.project(Meridional::of(&side.point(u, around))).0,
    };
    let mut height = |v: f64| {
        let (t, d) = curve.project_near(Meridional::of(&side.point(u, v)), near, 0.1 * curve.length());
        near = t;
        d
    };
    let here = height(around);
    let mut found = None;
    if here.abs() < 1e-9 {
        found = Some(around);
    } else {
        for reach in [0.02, 0.05, 0.1, 0.2, 0.35, 0.5] {
            for v in [around - reach, around + reach] {
                if found.is_none() && height(v) * here <= 0.0 {
                    found = Some(search::root(&mut height, around, v, 1e-12));
                }
            }
        }
    }
    if found.is_some() {
        *guess = Some(near);
    }
    found
}

/// The part's blades around channel 1, both sides of each: what a cutter in that channel can touch.
/// Main blades −1 to 2 pitches away would be needless: the two bounding blades and the splitter.
pub fn sides_around_channel(part: &Impeller) -> Vec<BladeSide> {
    let other = part.main.rotated(part.pitch());
    let mut sides =
        vec![part.main.suction.clone(), part.main.pressure.clone(), other.suction, other.pressure];
    for splitter in &part.splitters {
        sides.push(splitter.suction.clone());
        sides.push(splitter.pressure.clone());
    }
    sides
}
