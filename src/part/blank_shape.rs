//! What a blank is before the first cut: key `blank` of `[stock]`.

use std::path::PathBuf;
use std::sync::Arc;

use super::blank_envelope::envelope_of;
use super::blank_mesh::BlankMesh;
use super::body::{body_outline, up_sign};
use super::impeller::Impeller;
use super::meridional_outline::{MeridionalOutline, OutlineFault};
use crate::geometry::Meridional;

/// Distance by which a part may stick out of its blank, mm: chords of a curve and rounding.
const ENCLOSED_TOLERANCE: f64 = 0.02;
/// Places along each curve at which the blank must enclose the part.
const PLACES: u32 = 400;

/// Shape of a blank.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum BlankShape {
    /// Turned between hub and shroud, from the line of leading edges to the rim.
    #[default]
    Edges,
    /// A cylinder through the largest radius of the trailing edges, from the back of the wheel to a plane
    /// before the leading edges: what a shop turns.
    Turned,
    /// From a file.
    File(Arc<BlankFile>),
}

/// A blank from a file. Equal blanks have the same name and outline.
#[derive(Clone, Debug)]
pub struct BlankFile {
    /// The file as the setup names it.
    pub name: String,
    /// Where it was found.
    pub path: PathBuf,
    /// Its outline: that of the file, or the turned envelope of its mesh.
    pub outline: MeridionalOutline,
    /// Its mesh. Absent for turned blanks, and in setups within plans, which hold only the outline.
    pub mesh: Option<BlankMesh>,
}

impl PartialEq for BlankFile {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.outline == other.outline
    }
}

impl BlankFile {
    /// The turned envelope of a mesh: what it covers while it turns about Z, with hollows that no straight
    /// line along Z reaches filled.
    ///
    /// # Errors
    /// When the mesh covers no area of the meridional plane.
    pub fn envelope(mesh: &BlankMesh) -> Result<MeridionalOutline, OutlineFault> {
        envelope_of(mesh)
    }
}

/// A place where a part sticks out of its blank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutsideBlank {
    /// By how much, mm.
    pub distance: f64,
    /// The place.
    pub point: Meridional,
    /// On what: "hub", "shroud", "leading edge" or "rim".
    pub what: &'static str,
}

impl BlankShape {
    /// The outline of the blank of `part`, with `inlet_extension` mm before the leading edges; `None` for
    /// [`Self::Edges`], whose outline is curved.
    pub(super) fn outline(&self, part: &Impeller, inlet_extension: f64) -> Option<MeridionalOutline> {
        match self {
            Self::Edges => None,
            Self::Turned => MeridionalOutline::new(&cylinder(part, inlet_extension)).ok(),
            Self::File(file) => Some(file.outline.clone()),
        }
    }

    /// Where `part` sticks out of this blank most, if it does.
    pub fn outside(&self, part: &Impeller) -> Option<OutsideBlank> {
        let Self::File(file) = self else { return None };
        let share = |i: u32| f64::from(i) / f64::from(PLACES);
        let ends = |s: f64| (part.hub.point(s), part.shroud.point(s));
        let (inlet, rim) = (ends(0.0), ends(1.0));
        let places = (0..=PLACES).map(share).flat_map(|t| {
            [
                ("hub", part.hub.point(t)),
                ("shroud", part.shroud.point(t)),
                ("leading edge", inlet.0.lerp(inlet.1, t)),
                ("rim", rim.0.lerp(rim.1, t)),
            ]
        });
        places
            .map(|(what, point)| OutsideBlank {
                distance: file.outline.signed_distance(point).0,
                point,
                what,
            })
            .filter(|place| place.distance > ENCLOSED_TOLERANCE)
            .reduce(|worst, other| if other.distance > worst.distance { other } else { worst })
    }
}

/// Corners of the cylinder that a shop turns, closed.
fn cylinder(part: &Impeller, inlet_extension: f64) -> [Meridional; 5] {
    let body = body_outline(part);
    let (back, bore) = (body[1].z, body[2].r);
    let up = up_sign(part);
    let ends = [part.hub.point(0.0), part.shroud.point(0.0)];
    let front = ends.iter().map(|p| up * p.z).fold(f64::NEG_INFINITY, f64::max) + inlet_extension;
    let front = up * front.max(up * body[4].z);
    let radius = part.hub.point(1.0).r.max(part.shroud.point(1.0).r);
    let corner = |r: f64, z: f64| Meridional { r, z };
    [corner(bore, back), corner(radius, back), corner(radius, front), corner(bore, front), corner(bore, back)]
}
