//! Blades: from described sections or camber lines to surfaces, trimmed to hub and shroud.

use super::camber;
use super::description::{BladeDescription, CamberSpan, PartError};
use super::order::{notes_of, ordered_side};
use super::side::{BladeSide, common_parameters};
use crate::error::ErrorCode;
use crate::geometry::{Meridional, MeridionalCurve, Point, search};

/// Largest number of sections (or spans) of a blade.
const MAX_SECTIONS: usize = 200;
/// Largest number of points of a section.
const MAX_SECTION_POINTS: usize = 20_000;

/// A blade in the part frame; the others of its row are copies rotated by multiples of the pitch.
#[derive(Clone, Debug)]
pub struct Blade {
    /// Suction side.
    pub suction: BladeSide,
    /// Pressure side. At LE both sides meet; at a blunt TE they do not.
    pub pressure: BladeSide,
}

impl Blade {
    /// The blade rotated by `angle_rad` about Z.
    pub fn rotated(&self, angle_rad: f64) -> Self {
        Self { suction: self.suction.rotated(angle_rad), pressure: self.pressure.rotated(angle_rad) }
    }

    /// Arc length on `curve` of the leading edge at `v`, mm: of the furthest upstream point of the nose,
    /// which need not be where both sides meet. A scan over the nose brackets it, a one-dimensional
    /// minimisation refines it.
    pub fn leading_edge_on(&self, curve: &MeridionalCurve, v: f64) -> f64 {
        const NOSE_U: f64 = 0.15;
        const LOOKS: usize = 60;
        let look = |i: usize| NOSE_U * i as f64 / LOOKS as f64;
        let foremost = |side: &BladeSide| {
            let place = |u: f64| curve.project(Meridional::from_point(&side.point(u, v))).0;
            let looks: [f64; LOOKS + 1] = std::array::from_fn(|i| place(look(i)));
            let first = (0..=LOOKS).min_by(|&a, &b| looks[a].total_cmp(&looks[b])).unwrap_or(0);
            let (low, high) = (look(first.saturating_sub(1)), look((first + 1).min(LOOKS)));
            search::minimum(place, low, high, 1e-7).1.min(looks[first])
        };
        foremost(&self.suction).min(foremost(&self.pressure))
    }
}

/// Line of the file in which a blade is described.
pub(super) fn blade_line(description: &BladeDescription) -> usize {
    match description {
        BladeDescription::Sections { line, .. } | BladeDescription::Camber { line, .. } => *line,
    }
}

/// A blade lofted and trimmed, before s is known.
pub(super) struct RawBlade {
    pub(super) blade: Blade,
}

impl RawBlade {
    /// The blade `name`; changes to the order of its sections are added to `notes`.
    pub(super) fn new(
        description: &BladeDescription,
        hub: &MeridionalCurve,
        shroud: &MeridionalCurve,
        name: &str,
        notes: &mut Vec<String>,
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
        check_sections(suction, line, "suction")?;
        check_sections(pressure, line, "pressure")?;
        let sides = [ordered_side(suction, hub, shroud), ordered_side(pressure, hub, shroud)];
        notes.extend(notes_of(name, [("suction", &sides[0].changes), ("pressure", &sides[1].changes)]));
        let [suction, pressure] = &sides;
        let (suction, repeated) = loft_trimmed(&suction.sections, hub, shroud, line, "suction")?;
        let (pressure, repeated_too) = loft_trimmed(&pressure.sections, hub, shroud, line, "pressure")?;
        if let count @ 1.. = repeated.max(repeated_too) {
            notes.push(match count {
                1 => format!("a section of the {name} is given twice; one of the two is left out"),
                _ => format!("{count} sections of the {name} repeat others; they are left out"),
            });
        }
        let blade = Blade { suction, pressure };
        check_thickness(&blade, line, name)?;
        Ok(Self { blade })
    }

    /// Arc lengths on `curve` of leading edge and rim, along the blade's edge at `v`.
    pub(super) fn ends_on(&self, curve: &MeridionalCurve, v: f64) -> (f64, f64) {
        let sides = [&self.blade.suction, &self.blade.pressure];
        let ends = sides.map(|side| curve.project(Meridional::from_point(&side.point(1.0, v))).0);
        (self.blade.leading_edge_on(curve, v), ends[0].max(ends[1]))
    }
}

fn check_spans(spans: &[CamberSpan], line: usize) -> Result<(), PartError> {
    let fault = |code: ErrorCode, what: &str, help: &str| Err(PartError::new(code, line, what, help));
    if spans.len() < 2 {
        return fault(
            ErrorCode::BladeSections,
            "a blade needs two spans or more",
            "give one at the hub and one at the shroud",
        );
    }
    if spans.len() > MAX_SECTIONS {
        return fault(
            ErrorCode::BladeSections,
            "a blade has more than 200 spans",
            "give fewer, hub to shroud",
        );
    }
    if spans.windows(2).any(|w| w[1].span <= w[0].span) {
        return fault(
            ErrorCode::BladeSections,
            "the spans of a blade do not increase",
            "order them hub to shroud, 0 to 1",
        );
    }
    for span in spans {
        let increasing =
            |pairs: &[(f64, f64)]| !pairs.is_empty() && pairs.windows(2).all(|w| w[1].0 > w[0].0 + 1e-9);
        if !increasing(&span.angle) || !increasing(&span.thickness) {
            return fault(
                ErrorCode::BladeValues,
                "angle or thickness has no values or fractions that do not increase",
                "give [fraction, value] pairs with growing fractions from 0 to 1",
            );
        }
        if span.angle.iter().any(|a| a.1.abs() > 85f64.to_radians()) {
            return fault(
                ErrorCode::BladeValues,
                "a blade angle exceeds 85°",
                "angles are measured from the meridional direction",
            );
        }
        if span.thickness.iter().any(|t| !(t.1 > 0.0 && t.1 < 1e3)) {
            return fault(ErrorCode::BladeValues, "a blade has no thickness", "give thicknesses above 0 mm");
        }
        if !(0.0..0.95).contains(&span.leading_edge) {
            return fault(
                ErrorCode::BladeValues,
                "a leading edge is outside the channel",
                "give a fraction from 0 to below 0.95",
            );
        }
    }
    Ok(())
}

/// Checks the sections of one side, before they are used.
fn check_sections(sections: &[Vec<Point>], line: usize, name: &str) -> Result<(), PartError> {
    let longest = sections.iter().map(Vec::len).max().unwrap_or(0);
    if sections.len() > MAX_SECTIONS || longest > MAX_SECTION_POINTS {
        return Err(PartError::new(
            ErrorCode::BladeSections,
            line,
            format!("the {name} side has {} sections of up to {longest} points", sections.len()),
            format!("give at most {MAX_SECTIONS} sections of {MAX_SECTION_POINTS} points"),
        ));
    }
    if sections.len() < 2 {
        return Err(PartError::new(
            ErrorCode::BladeSections,
            line,
            format!("the {name} side has {} section", sections.len()),
            "give two sections or more, hub to tip".to_string(),
        ));
    }
    let spread = |s: &[Point]| s.iter().any(|p| (p - s[0]).norm() > 1e-6);
    let wild = |s: &[Point]| s.iter().any(|p| !p.iter().all(|x| x.is_finite() && x.abs() < 1e5));
    if sections.iter().any(|s| s.len() < 4 || wild(s) || !spread(s)) {
        return Err(PartError::new(
            ErrorCode::BladeSections,
            line,
            format!("a section of the {name} side has fewer than four different points"),
            "give the points of each side, LE to TE".to_string(),
        ));
    }
    Ok(())
}

/// Checks that the sides of a blade are not one surface, as where its camber surface was exported for both.
fn check_thickness(blade: &Blade, line: usize, name: &str) -> Result<(), PartError> {
    const STEPS: usize = 20;
    /// Thickness of such a blade as a share of its length: rounding.
    const NONE: f64 = 1e-5;
    let length = (blade.suction.point(1.0, 0.5) - blade.suction.point(0.0, 0.5)).norm();
    let at = |i: usize, v: f64| {
        let u = i as f64 / STEPS as f64;
        (blade.suction.point(u, v) - blade.pressure.point(u, v)).norm()
    };
    let thick = (0..=STEPS).any(|i| [0.0, 0.5, 1.0].into_iter().any(|v| at(i, v) > NONE * length));
    if thick {
        return Ok(());
    }
    Err(PartError::new(
        ErrorCode::BladeValues,
        line,
        format!("the {name} has no thickness: its suction and pressure sides are the same"),
        "give the points of both sides, not those of the surface midway between them",
    ))
}

/// Lofts raw sections and trims (or extends) the surface to hub and shroud. Sections that repeat the one
/// before are left out; also returns their number.
fn loft_trimmed(
    sections: &[Vec<Point>],
    hub: &MeridionalCurve,
    shroud: &MeridionalCurve,
    line: usize,
    name: &str,
) -> Result<(BladeSide, usize), PartError> {
    let (u, all) = common_parameters(sections);
    let mut heights = vec![0.0];
    let mut sections: Vec<Vec<Point>> = Vec::with_capacity(all.len());
    let mut repeated = 0;
    for section in all {
        if let Some(below) = sections.last() {
            let gap = below.iter().zip(&section).map(|(a, b)| (b - a).norm()).sum::<f64>() / u.len() as f64;
            if gap < 1e-6 {
                repeated += 1;
                continue;
            }
            heights.push(heights[heights.len() - 1] + gap);
        }
        sections.push(section);
    }
    if sections.len() < 2 {
        return Err(PartError::new(
            ErrorCode::BladeSections,
            line,
            format!("all sections of the {name} side coincide"),
            "give sections at different spans".to_string(),
        ));
    }
    let total = heights[heights.len() - 1];
    let stations: Vec<f64> = heights.iter().map(|h| h / total).collect();
    let raw = BladeSide::loft(&u, &stations, &sections);

    let miss = |surface: &str, u: f64| {
        let mut what = format!("the {name} side misses the {surface} at {:.0} % of its chord", 100.0 * u);
        if u < 0.02 {
            // For example a disc with vanes between two flat surfaces, which has no inlet.
            what += ": there is no leading edge between hub and shroud";
        }
        PartError::new(
            ErrorCode::BladeTooShort,
            line,
            what,
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
    Ok((BladeSide::loft(&u, &even, &cut), repeated))
}

/// v near `around` at which the line of constant u of `side` crosses `curve`, by bracketed root finding.
/// `guess` is the arc length of the crossing, a warm start from line to line.
fn crossing(
    side: &BladeSide,
    u: f64,
    curve: &MeridionalCurve,
    around: f64,
    guess: &mut Option<f64>,
) -> Option<f64> {
    let mut near = match *guess {
        Some(t) => t,
        None => curve.project(Meridional::from_point(&side.point(u, around))).0,
    };
    let mut height = |v: f64| {
        let (t, d) =
            curve.project_near(Meridional::from_point(&side.point(u, v)), near, 0.1 * curve.length());
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
