//! Segmentation of a wheel given as a single mesh: surfaces of revolution that touch the blades are hub and
//! cover, the rest is blades.

use super::above_faces::AboveFaces;
use super::boss::{BossOfHub, cut_off_boss, end_of_foot};
use super::normals::ExactNormals;
use super::revolved_face::{FaceShape, RevolvedFace};
use super::revolved_patches::{ASIDE, RevolvedPatches};
use super::round::{SECTORS, is_round, radii, sectors_met};
use super::surface::MeshSurface;
use super::tip_border::begins_in_hub;
use crate::error::ErrorCode;
use crate::geometry::Vector;
use crate::part::PartError;

/// Share of the largest blade's area below which a piece is discarded as a fragment.
const SCRAP: f64 = 0.05;

/// Share of the largest piece's area above which a body of revolution beside the axis is another wheel's hub.
const OTHER_WHEEL: f64 = 0.25;

/// Share of its largest radius from which on a piece is looked at to tell a blade from a wheel.
const OUTER: f64 = 0.8;

/// Why blades alone are no wheel.
const WITHOUT_HUB: &str = "none of its bodies goes around the axis, so that it has no hub";

/// The surfaces of a segmented wheel.
pub struct Segments {
    /// The hub, or its flow side.
    pub hub: MeshSurface,
    /// How far blades go on before the beginning of the hub, straight, in the rounded corner at the foot of a
    /// boss, mm.
    pub hub_ahead_mm: f64,
    /// The shroud where it is a separate piece, or the cover.
    pub shroud: Option<MeshSurface>,
    /// Single blades.
    pub blades: Vec<MeshSurface>,
}

/// Whether a piece has points all around the axis at more than a `share` of its largest radius, as a wheel of
/// one piece has near its rim and a blade has not.
fn goes_around(piece: &MeshSurface, share: f64) -> bool {
    2 * sectors_met(piece, share) > SECTORS
}

/// Classifies disconnected pieces: surfaces of revolution are hub and shroud, all others blades. `None` where
/// there are no separate blades.
///
/// # Errors
/// Returns the number of bodies of revolution if there are more than two.
fn segment_disconnected(pieces: &[MeshSurface]) -> Result<Option<Segments>, usize> {
    let (mut round, blades): (Vec<_>, Vec<_>) = pieces.iter().cloned().partition(is_round);
    // One piece beside the hub is a blade where it does not go around the axis, else a wheel of one piece.
    if blades.len() < 2 && blades.first().is_none_or(|blade| goes_around(blade, OUTER)) {
        return Ok(None);
    }
    if round.len() > 2 {
        return Err(round.len());
    }
    // The hub is nearest to the axis.
    round.sort_by(|a, b| radii(a).0.total_cmp(&radii(b).0));
    let mut round = round.into_iter();
    let Some(hub) = round.next() else { return Ok(None) };
    Ok(Some(Segments { hub, hub_ahead_mm: 0.0, shroud: round.next(), blades }))
}

fn area_of(piece: &MeshSurface) -> f64 {
    (0..piece.triangles.len()).map(|t| piece.area(t)).sum()
}

/// Distance from Z of another wheel's hub among the pieces, mm: a large body of revolution about an axis of
/// its own.
fn wheel_beside(pieces: &[MeshSurface]) -> Option<f64> {
    let largest = pieces.iter().map(area_of).fold(0.0, f64::max);
    pieces.iter().filter(|piece| area_of(piece) > OTHER_WHEEL * largest && !goes_around(piece, 0.0)).find_map(
        |piece| {
            let weighted = (0..piece.triangles.len()).map(|t| piece.centre(t).coords * piece.area(t));
            let centre = weighted.sum::<Vector>() / area_of(piece);
            let about_own = piece.clone().transformed(|p| p - Vector::new(centre.x, centre.y, 0.0));
            let is_other = sectors_met(&about_own, OUTER) == SECTORS && is_round(&about_own);
            is_other.then(|| centre.xy().norm())
        },
    )
}

/// Which of several pieces are blades: neither fragments, nor bodies of revolution.
fn blades_among(pieces: &[MeshSurface]) -> Vec<bool> {
    let areas: Vec<f64> = pieces.iter().map(area_of).collect();
    let largest = areas.iter().copied().fold(0.0, f64::max);
    pieces.iter().zip(areas).map(|(piece, area)| area > SCRAP * largest && !is_round(piece)).collect()
}

/// Whether the blades among pieces are apart: a single one may be the only blade of the file, on one pitch of
/// the hub or on all of it; connected blades go around the axis.
fn are_apart(pieces: &[MeshSurface]) -> bool {
    let mut blades = pieces.iter().zip(blades_among(pieces)).filter(|(_, is_blade)| *is_blade);
    let first = blades.next();
    blades.next().is_some() || first.is_some_and(|(blade, _)| !goes_around(blade, 0.0))
}

/// Segments a wheel given as one mesh about Z into hub, blades and, where there is one, cover.
///
/// # Errors
/// Fails when another wheel stands beside the axis, when no surface of revolution touches blades, when there
/// are more than two disconnected bodies of revolution, or when the blades are connected with each other.
pub fn segment_wheel(wheel: &MeshSurface, exact: &ExactNormals, name: &str) -> Result<Segments, PartError> {
    let pieces = wheel.clone().into_pieces();
    if let Some(distance) = wheel_beside(&pieces) {
        return Err(PartError::new(
            ErrorCode::MeshInOne,
            0,
            format!("the single mesh `{name}` holds a second wheel {distance:.1} mm beside the axis"),
            "export one wheel alone",
        ));
    }
    let by_smooth = segment_by(FaceShape::Smooth, (wheel, &pieces), exact, name);
    // A hub drawn in straight pieces may have corners under the blades.
    by_smooth
        .or_else(|error| segment_by(FaceShape::Cornered, (wheel, &pieces), exact, name).map_err(|_| error))
}

/// Error of a wheel with `count` bodies of revolution that are apart.
fn unclear_hub(count: usize) -> PartError {
    PartError::new(
        ErrorCode::MeshRoles,
        0,
        format!("there are {count} separate bodies of revolution: which of them is the hub is not clear"),
        "give each body --role NODE=hub, NODE=shroud, NODE=blade or NODE=ignore; bodies that share a node need \
         nodes of their own",
    )
}

/// As [`segment_wheel`], with faces of revolution of one shape, of a wheel in `pieces`.
fn segment_by(
    shape: FaceShape,
    (wheel, pieces): (&MeshSurface, &[MeshSurface]),
    exact: &ExactNormals,
    name: &str,
) -> Result<Segments, PartError> {
    let unclear = |why: &str| {
        PartError::new(
            ErrorCode::MeshInOne,
            0,
            format!("hub and blades of the single mesh `{name}` cannot be separated: {why}"),
            "export hub and blades as separate bodies, or give them --role NODE=hub and NODE=blade; if the axis in \
             the file is not that of the wheel, give it with --rotation-axis",
        )
    };
    match segment_disconnected(pieces) {
        Ok(Some(segments)) => return Ok(segments),
        Ok(None) => {}
        Err(count) => return Err(unclear_hub(count)),
    }
    let patches = RevolvedPatches::new(wheel, exact, shape);
    let (hub, cover) = patches.hub_and_cover().map_err(unclear)?;
    let above = AboveFaces { patches: &patches, cover: cover.as_ref() };
    let on_hub = pieces_on(hub, &above);
    let OnHub { hub, pieces, ahead_mm } = on_hub.ok_or_else(|| {
        let has_hub = pieces.len() == 1 || pieces.iter().any(|piece| goes_around(piece, 0.0));
        unclear(if has_hub { "the blades on its hub are connected with each other" } else { WITHOUT_HUB })
    })?;
    let is_blade = blades_among(&pieces);
    let blades = pieces.into_iter().zip(is_blade).filter(|(_, is)| *is).map(|(blade, _)| blade).collect();
    let shroud = cover.as_ref().map(|cover| above.surface_of(cover));
    Ok(Segments { hub: above.surface_of(&hub), hub_ahead_mm: ahead_mm, shroud, blades })
}

/// A hub, and what stands on it in pieces.
struct OnHub {
    hub: RevolvedFace,
    pieces: Vec<MeshSurface>,
    /// As [`Segments::hub_ahead_mm`].
    ahead_mm: f64,
}

/// What stands on a hub, with blades apart; `None` where they are connected. Blades that begin in a boss with
/// a rounded foot stand on a hub that goes on up to its top: the boss is cut off, and the hub begins behind
/// it.
fn pieces_on(mut hub: RevolvedFace, above: &AboveFaces) -> Option<OnHub> {
    let RevolvedPatches { wheel, corners, course, size, tolerance, .. } = above.patches;
    let mut over_hub = above.over_hub(&hub, None);
    let pieces = over_hub.clone().into_pieces();
    let first_blade = pieces.iter().zip(blades_among(&pieces)).find(|(_, is)| *is).map(|(piece, _)| piece);
    let in_boss = first_blade.is_some_and(|blade| begins_in_hub(blade, &hub.points, course));
    let foot = if in_boss { end_of_foot(&hub.curve) } else { None };
    let behind = foot.and_then(|foot| hub.behind(foot, corners, course));
    let rounded = behind.map(|behind| std::mem::replace(&mut hub, behind));
    if rounded.is_none() && are_apart(&pieces) {
        return Some(OnHub { hub, pieces, ahead_mm: 0.0 });
    }
    if rounded.is_some() {
        over_hub = above.over_hub(&hub, rounded.as_ref());
    }
    let boss = BossOfHub {
        wheel,
        hub: &hub.points,
        rounded: rounded.as_ref().map(|face| &face.curve),
        above: hub.curve.offset_derivative(0.5 * hub.curve.length(), ASIDE * size).0,
        inlet_up: course.inlet_up(),
        tolerance: *tolerance,
    };
    match cut_off_boss(&over_hub, &boss, are_apart) {
        Some(cut) => Some(OnHub { hub, pieces: cut.pieces, ahead_mm: cut.ahead_mm }),
        None => {
            rounded.filter(|_| are_apart(&pieces)).map(|whole| OnHub { hub: whole, pieces, ahead_mm: 0.0 })
        }
    }
}
