//! Tessellation of a part with a bounded chord error.
//!
//! Corners are on the surfaces; in between, the triangles deviate by at most the chord error. Hub, body and
//! blades are closed, the shroud is an open sheet. One blade of each row is tessellated; the others are
//! copies rotated by multiples of the pitch.

mod blade;
mod revolved;

use super::TriangleMesh;
use super::solid::Solid;
use crate::geometry::rotate_z;
use crate::part::Impeller;

/// Lower limit of the triangle budget per row of blades, with which every part can be tessellated coarsely.
const MIN_TRIANGLE_BUDGET: usize = 20_000;

/// Resolution of a tessellation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Largest distance between triangles and surfaces, mm.
    pub chord_error: f64,
    /// Largest number of triangles of hub, shroud and one blade of each row together.
    pub max_triangles: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Self { chord_error: 0.01, max_triangles: 1_000_000 }
    }
}

/// The triangles of a part, mm, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation {
    /// Hub with rim, back and bore; closed.
    pub hub: Solid,
    /// Shroud; an open sheet.
    pub shroud: Solid,
    /// Main blade; closed.
    pub main: Solid,
    /// Splitters of one pitch; closed.
    pub splitters: Vec<Solid>,
    /// Chord error that was achieved, mm: the requested one, or more where that would take too many
    /// triangles.
    pub chord_error: f64,
}

impl Tessellation {
    /// Tessellates a part. Where the chord error of `fineness` would take more triangles than it allows, the
    /// chord error is increased by steps of 25 % until they suffice; see [`Self::chord_error`].
    pub fn new(part: &Impeller, fineness: &Fineness) -> Self {
        let mut chord_error = fineness.chord_error.clamp(1e-6, 1e3);
        let most = fineness.max_triangles.max(MIN_TRIANGLE_BUDGET * (1 + part.splitters.len()));
        loop {
            if let Some(done) = Self::try_tessellate(part, chord_error, most) {
                return done;
            }
            chord_error *= 1.25;
        }
    }

    fn try_tessellate(part: &Impeller, chord_error: f64, most: usize) -> Option<Self> {
        let rows = 1 + part.splitters.len();
        let blade = |blade| blade::tessellate_blade(part, blade, chord_error, most / rows);
        let main = blade(&part.main)?;
        let splitters: Vec<Solid> = part.splitters.iter().map(blade).collect::<Option<_>>()?;
        if revolved::count_triangles(part, chord_error) > most {
            return None;
        }
        let (hub, shroud) =
            (revolved::tessellate_hub(part, chord_error), revolved::tessellate_shroud(part, chord_error));
        let done = Self { hub, shroud, main, splitters, chord_error };
        (done.triangle_count() <= most).then_some(done)
    }

    /// Hub body and all blades of `part` as one mesh of closed pieces, without the shroud.
    pub fn open_wheel(&self, part: &Impeller) -> TriangleMesh {
        let mut wheel = self.hub.mesh();
        for blade in std::iter::once(&self.main).chain(&self.splitters) {
            let mesh = blade.mesh();
            for k in 0..part.blade_count {
                let turn_rad = part.pitch() * k as f64;
                let points = mesh.points.iter().map(|p| rotate_z(p, turn_rad)).collect();
                wheel.append(&TriangleMesh { points, triangles: mesh.triangles.clone() });
            }
        }
        wheel
    }

    /// Number of triangles of hub, shroud and one blade of each row.
    pub fn triangle_count(&self) -> usize {
        let blades =
            self.main.triangle_count() + self.splitters.iter().map(Solid::triangle_count).sum::<usize>();
        self.hub.triangle_count() + self.shroud.triangle_count() + blades
    }
}
