//! From a part to triangles whose distance from its surfaces is bounded.
//!
//! Corners lie on the surfaces; between them the triangles are at most the chord error away. Hub, body and blades are
//! closed, the shroud is a sheet. Every blade is tessellated once, in its place; the others of its row follow by
//! rotation by the pitch.

mod blade;
mod revolved;

pub use revolved::{body_outline, nose, up_sign};

use super::solid::Solid;
use crate::part::Impeller;

/// How finely a part is tessellated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Largest distance between triangles and surfaces, mm.
    pub chord_error: f64,
    /// Most triangles of hub, shroud and one blade of each row together.
    pub most_triangles: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Self { chord_error: 0.01, most_triangles: 1_000_000 }
    }
}

/// A part in triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation {
    /// Hub with rim, back and bore; closed.
    pub hub: Solid,
    /// Shroud, a sheet.
    pub shroud: Solid,
    /// Main blade; closed.
    pub main: Solid,
    /// Splitters of one pitch; closed.
    pub splitters: Vec<Solid>,
    /// Chord error that holds, mm: what was asked for, or more where that would take too many triangles.
    pub chord_error: f64,
}

impl Tessellation {
    /// Tessellates a part. Where `fineness` asks for more triangles than it allows, the chord error grows until they
    /// are enough; see [`Self::chord_error`].
    pub fn new(part: &Impeller, fineness: &Fineness) -> Self {
        let mut chord_error = fineness.chord_error.clamp(1e-6, 1e3);
        let most = fineness.most_triangles.max(FEWEST_TRIANGLES * (1 + part.splitters.len()));
        loop {
            if let Some(done) = Self::within(part, chord_error, most) {
                return done;
            }
            chord_error *= 1.25;
        }
    }

    fn within(part: &Impeller, chord_error: f64, most: usize) -> Option<Self> {
        let rows = 1 + part.splitters.len();
        let blade = |blade| blade::blade(part, blade, chord_error, most / rows);
        let main = blade(&part.main)?;
        let splitters: Vec<Solid> = part.splitters.iter().map(blade).collect::<Option<_>>()?;
        if revolved::triangles(part, chord_error) > most {
            return None;
        }
        let (hub, shroud) = (revolved::hub(part, chord_error), revolved::shroud(part, chord_error));
        let done = Self { hub, shroud, main, splitters, chord_error };
        (done.triangles() <= most).then_some(done)
    }

    /// Number of triangles of hub, shroud and one blade of each row.
    pub fn triangles(&self) -> usize {
        let blades = self.main.triangles() + self.splitters.iter().map(Solid::triangles).sum::<usize>();
        self.hub.triangles() + self.shroud.triangles() + blades
    }
}

/// With as many triangles for each row of blades a part can be had, however coarse.
const FEWEST_TRIANGLES: usize = 20_000;
