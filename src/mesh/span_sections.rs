//! Span sections of a blade from its mesh, between hub and shroud, with the checks that it is closed.

use nalgebra::{DMatrix, DVector};

use super::edges::{EdgeJump, find_jump, largest_jump};
use super::fillets::between_fillets;
use super::holes::largest_hole;
use super::normals::ExactNormals;
use super::sections::{BladeSlicer, ChannelCoordinates};
use super::sides::{BeginRule, EdgeKind, SpanSection, SplitRule};
use super::surface::MeshSurface;
use crate::error::ErrorCode;
use crate::geometry::{Meridional, Point};
use crate::part::PartError;

/// Number of span sections of a blade.
const SECTIONS: usize = 13;
/// Distance of the outermost sections from hub and shroud as a share of the height, because slices there
/// would run along the blade's border.
const INSET: f64 = 0.01;
/// Intervals along a blade in each of which its height is looked at.
const STRETCHES: usize = 22;
/// Smallest height of a blade between its fillets, as a share of the channel's height.
const MIN_HEIGHT: f64 = 0.2;
/// Holes up to this size are ignored, mm: the sections are interpolated across them.
const MIN_HOLE: f64 = 0.05;
/// Relative height of the highest section below which a blade is said to end short of the shroud.
const SHORT: f64 = 0.975;
/// Largest jump of an edge of sections that are made in another way, as a share of the jump before, with
/// which they are better.
const LESS: f64 = 0.6;
/// Largest number of sections with a face of an edge among such with a line there.
const FEW_FACES: usize = 2;
/// Steps of the parameter at which ways along the sections are compared, terms of the polynomials through
/// them, and the largest distance from these of sections that are even, as a share of their length.
const WAYS: usize = 720;
const WAY_TERMS: usize = 5;
const UNEVEN: f64 = 4e-3;
/// Step of the parameter from which on it goes by the position along the channel alone.
const BEHIND_NOSE: usize = 240;
/// Help text for missing triangles.
const CLOSE: &str = "close the mesh, or export the surface again with all of its faces";

/// Span sections of a blade; adds a note about a jump that is either its shape or due to missing triangles,
/// or, where the bodies of the file are `whole`, to an edge that was not understood.
///
/// # Errors
/// Fails when the blade is open, or does not reach from hub to shroud.
pub fn span_sections(
    surface: &MeshSurface,
    band: &ChannelCoordinates,
    name: &str,
    (normals, whole): (&ExactNormals, bool),
    notes: &mut Vec<String>,
) -> Result<Vec<SpanSection>, PartError> {
    let mut own = Vec::new();
    let (mut sections, mut jump) = sections_in(surface, band, name, normals, &mut own)?;
    // What looks like a gap of an edge may be the end of the hub below a blade that goes on past it, at the
    // rim or ahead of its nose: of a blade cut off at the hub, the lowest section is open there. Of another
    // it goes around that end.
    if let Some(first) = jump {
        let mut again = Vec::new();
        let past = sections_in(surface, &band.going_on(surface), name, normals, &mut again);
        let is_better = |rest: &EdgeJump| {
            let share = if first.is_gap { 1.0 } else { LESS };
            !rest.is_gap && (first.is_gap && rest.edge != first.edge || rest.size_mm < share * first.size_mm)
        };
        if let Ok((better, rest)) = past
            && rest.as_ref().is_none_or(is_better)
        {
            (sections, jump, own) = (better, rest, again);
        }
    }
    notes.extend(own);
    if let Some(jump) = jump {
        let at = Meridional::from_point(&jump.at);
        let place = format!("at z = {:.1}, r = {:.1} mm", at.z, at.r);
        if jump.is_gap {
            return Err(PartError::new(
                ErrorCode::MeshNotClosed,
                0,
                format!("the {} of the {name} has a gap of {:.1} mm {place}", jump.edge, jump.size_mm),
                CLOSE,
            ));
        }
        let cause = match whole {
            true => "it was not understood: compare it with the CAD model",
            false => "triangles are missing there",
        };
        notes.push(format!(
            "the {} of the {name} jumps by {:.1} mm {place}: if that is not its shape, {cause}",
            jump.edge, jump.size_mm
        ));
    }
    Ok(sections)
}

/// Lets all sections of a blade begin alike, and end alike, where their edges jump less then. Where some do
/// at the line where the sides meet, and others beside it, as it is at the end of their noses or was not
/// found, sides through points at equal parameters would wave. `made` makes the section of a number by a
/// rule.
fn split_alike(sections: &mut Vec<SpanSection>, made: impl Fn(usize, SplitRule) -> Option<SpanSection>) {
    let all = sections.len();
    let mut rules = vec![SplitRule::AS_FOUND; all];
    let count = |edge: usize, kind: EdgeKind| sections.iter().filter(|s| s.edges[edge] == kind).count();
    let (lines, round) = (count(0, EdgeKind::Line), count(0, EdgeKind::Round));
    if lines > 0 && round > 0 && lines + round == all {
        let by = |begin: BeginRule| {
            let rule = SplitRule { begin, end: None };
            let alike = (0..all).map(|k| made(k, rule)).collect::<Option<Vec<_>>>()?;
            Some((largest_jump(&alike, 0), rule, alike))
        };
        let made = [BeginRule::AtLine, BeginRule::AtForemost].into_iter().filter_map(by);
        let best = made.min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, rule, alike)) = best.filter(|best| best.0 < LESS * largest_jump(sections, 0)) {
            (rules, *sections) = (vec![rule; all], alike);
        }
    }
    for edge in 0..2 {
        let lines = sections.iter().filter(|s| s.edges[edge] == EdgeKind::Line).count();
        // A few faces among lines are none, but what a slice goes along at the end of hub or shroud.
        let is_off = |section: &SpanSection| match section.edges[edge] {
            EdgeKind::Line => false,
            EdgeKind::Round => 2 * lines > all,
            EdgeKind::Face => lines + FEW_FACES >= all,
        };
        let (mut alike, mut own) = (sections.clone(), rules.clone());
        for k in (0..all).filter(|k| is_off(&sections[*k])) {
            let Some(place) = expected_line(sections, edge, k) else { continue };
            let rule = match edge {
                0 => SplitRule { begin: BeginRule::Near(place), ..rules[k] },
                _ => SplitRule { end: Some(place), ..rules[k] },
            };
            if let Some(section) = made(k, rule) {
                (alike[k], own[k]) = (section, rule);
            }
        }
        if largest_jump(&alike, edge) < LESS * largest_jump(sections, edge) {
            (rules, *sections) = (own, alike);
        }
    }
}

/// Where the line at leading (0) or trailing `edge` (1) is expected in section `k`: straight between the two
/// nearest sections that have it.
fn expected_line(sections: &[SpanSection], edge: usize, k: usize) -> Option<Point> {
    let mut having: Vec<usize> =
        (0..sections.len()).filter(|i| *i != k && sections[*i].edges[edge] == EdgeKind::Line).collect();
    having.sort_by_key(|i| i.abs_diff(k));
    let (&a, &b) = (having.first()?, having.get(1)?);
    let at = |i: usize| sections[i].sides[0].point(edge as f64);
    let share = (k as f64 - a as f64) / (b as f64 - a as f64);
    Some(at(a) + (at(b) - at(a)) * share)
}

/// Gives the sides of all sections of a blade the parameters of most, with a round trailing edge or without:
/// sides through points at equal parameters of both would wave. A blunt trailing edge that runs out at the
/// tip is round in the last sections only.
fn end_alike(sections: &mut [SpanSection]) {
    let round = sections.iter().filter(|section| section.has_round_tail).count();
    let is_round = 2 * round > sections.len();
    for section in sections.iter_mut().filter(|section| section.has_round_tail != is_round) {
        section.parametrise(is_round);
    }
}

/// Evens out the parameters of the sections where they jump from one to the next: the position along the
/// channel, by which they go, does so where a place is as near to one part of hub or shroud as to another.
/// Sides through points at equal parameters would wave there. Of each parameter the ways along the sections
/// become a polynomial of their number.
fn even_out(sections: &mut [SpanSection]) {
    let count = sections.len();
    let numbers = |i: usize, power: usize| (2.0 * i as f64 / (count - 1) as f64 - 1.0).powi(power as i32);
    let basis = DMatrix::from_fn(count, WAY_TERMS.min(count), numbers);
    let Some(inverse) = basis.clone().pseudo_inverse(1e-12).ok() else { return };
    let smoothing = basis * inverse;
    // At the corners of a blunt leading edge the ways jump in any case: few points are there.
    let faces = sections.iter().filter(|section| section.edges[0] == EdgeKind::Face).count();
    let from = if 2 * faces > count { BEHIND_NOSE } else { 0 };
    for side in 0..2 {
        let at =
            |w: usize| DVector::from_fn(count, |k, _| sections[k].sides[side].way(w as f64 / WAYS as f64));
        let ways: Vec<(DVector<f64>, DVector<f64>)> =
            (0..=WAYS).map(|w| (at(w), &smoothing * at(w))).collect();
        let looked_at = ways.iter().skip(from);
        let off = looked_at.map(|(ways, even)| (even - ways).amax()).fold(0.0, f64::max);
        if off < UNEVEN {
            continue;
        }
        for (k, section) in sections.iter_mut().enumerate() {
            let mut own: Vec<f64> = ways.iter().map(|(_, even)| even[k].clamp(0.0, 1.0)).collect();
            for w in 1..own.len() {
                own[w] = own[w].max(own[w - 1]);
            }
            section.sides[side].set_ways(&own);
        }
    }
}

/// Span sections of a blade in the coordinates of `band`, and the largest jump of an edge over them.
fn sections_in(
    surface: &MeshSurface,
    band: &ChannelCoordinates,
    name: &str,
    normals: &ExactNormals,
    notes: &mut Vec<String>,
) -> Result<(Vec<SpanSection>, Option<EdgeJump>), PartError> {
    let cutter = BladeSlicer::new(surface, band, normals);
    let hole = largest_hole(surface, cutter.places(), INSET..=1.0 - INSET);
    if let Some(hole) = hole.filter(|hole| hole.size > MIN_HOLE) {
        let at = Meridional::from_point(&hole.middle);
        return Err(PartError::new(
            ErrorCode::MeshNotClosed,
            0,
            format!(
                "the {name} has a hole of {:.1} mm across at z = {:.1}, r = {:.1} mm",
                hole.size, at.z, at.r
            ),
            CLOSE,
        ));
    }
    let (low, high) = cutter.height_range(STRETCHES);
    let (low, high) = (low.max(0.0) + INSET, high.min(1.0) - INSET);
    if !(MIN_HEIGHT..=1.0).contains(&(high - low)) {
        return Err(PartError::new(
            ErrorCode::MeshRoles,
            0,
            format!("the {name} does not reach from hub to shroud"),
            "check the roles of the meshes (--role NODE=hub, shroud or blade)",
        ));
    }
    let tip = high;
    let (low, high) = between_fillets(low, high, |height| {
        SpanSection::from_cuts(&cutter.slice_at(height), SplitRule::AS_FOUND)
    });
    if high - low < MIN_HEIGHT {
        return Err(PartError::new(
            ErrorCode::BladeSections,
            0,
            format!("the fillets of the {name} leave {:.0} % of its height", 100.0 * (high - low)),
            "export the wheel without fillets",
        ));
    }
    if tip - high < INSET && high < SHORT {
        notes.push(format!(
            "a side of the {name} ends up to {:.1} % of the height below the shroud; it is extended to it",
            100.0 * (1.0 - high - INSET)
        ));
    }
    let at = |k: usize| low + (high - low) * k as f64 / (SECTIONS - 1) as f64;
    let section = |height: f64| {
        SpanSection::from_cuts(&cutter.slice_at(height), SplitRule::AS_FOUND).ok_or_else(|| {
            PartError::new(
                ErrorCode::MeshNotClosed,
                0,
                format!(
                    "the {name} is not a closed blade: at {:.0} % of its height it does not have two sides",
                    100.0 * height
                ),
                "close its gaps, or exclude fragments with --role NODE=ignore",
            )
        })
    };
    let mut sections: Vec<SpanSection> = (0..SECTIONS).map(|k| section(at(k))).collect::<Result<_, _>>()?;
    split_alike(&mut sections, |k, rule| SpanSection::from_cuts(&cutter.slice_at(at(k)), rule));
    end_alike(&mut sections);
    even_out(&mut sections);
    let jump = find_jump(&sections);
    Ok((sections, jump))
}
