//! Span sections of a blade from its mesh, between hub and shroud, with the checks that it is closed.

use super::edges::{EdgeJump, find_jump};
use super::fillets::between_fillets;
use super::holes::largest_hole;
use super::normals::ExactNormals;
use super::sections::{BladeSlicer, ChannelCoordinates};
use super::sides::SpanSection;
use super::surface::MeshSurface;
use crate::error::ErrorCode;
use crate::geometry::Meridional;
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
    // rim or ahead of its nose: of a blade cut off at the hub, the lowest section is open there.
    if let Some(first) = jump.filter(|jump| jump.is_gap) {
        let mut again = Vec::new();
        let past = sections_in(surface, &band.going_on(surface), name, normals, &mut again);
        if let Ok((better, rest)) = past
            && rest
                .is_none_or(|rest| !rest.is_gap && (rest.edge != first.edge || rest.size_mm < first.size_mm))
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
    let (low, high) = between_fillets(low, high, |height| SpanSection::from_cuts(&cutter.slice_at(height)));
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
        SpanSection::from_cuts(&cutter.slice_at(height)).ok_or_else(|| {
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
    let sections: Vec<SpanSection> = (0..SECTIONS).map(|k| section(at(k))).collect::<Result<_, _>>()?;
    let jump = find_jump(&sections);
    Ok((sections, jump))
}
