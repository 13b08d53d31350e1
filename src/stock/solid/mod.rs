//! The stock as a solid, after any move of any program: a tri-dexel model.
//!
//! Rays run along x, y and z on the lines of a cubic lattice. Each keeps a sorted list of disjoint spans of
//! stock, with the surface and the move that bounds them. A move is a few convex pieces that travel on
//! straight lines (`motion.rs`); what one of them sweeps of a ray is one interval in closed form
//! (`piece.rs`). Plunges are exact, other moves are within a tenth of the spacing.

pub mod assembly;
mod carve;
mod lattice;
pub mod mesh_blank;
pub mod motion;
mod near;
mod outline;
mod part;
mod piece;
pub mod player;
pub mod program;
mod rays;
mod revolved;
mod runs;
mod span;
pub mod surface;

pub use assembly::{SolidSegment, SolidTool};
pub use carve::Contact;
pub use lattice::{Lattice, SolidError};
pub use mesh_blank::{MeshBlank, MeshFault};
pub use motion::{SolidMove, ToolPose, tell_plunges_from_approaches};
pub use part::ToolPart;
pub use player::StockPlayer;
pub use program::{ProgramFault, SolidProgram};
pub use revolved::TurnedOutline;
pub use runs::MAX_RUN;
pub use span::{Span, SpanEnd};
pub use surface::StockSurface;

use std::sync::Arc;

use carve::ResolvedDepth;
use motion::PieceMaker;
use near::NearStock;
use rays::{RayField, RayTile};

use crate::geometry::Point;
use crate::monitor::Monitor;
use crate::part::{Blank, Impeller};

/// Rays across the wheel of a solid that is to be drawn soon.
pub const COARSE_RAYS: f64 = 140.0;
/// Rays across the wheel of a solid that stays in the picture.
pub const FINE_RAYS: f64 = 360.0;
/// Distance of the pieces of a move that turns from its true sweep, in spacings.
const TURN_TOLERANCE: f64 = 0.06;
/// Distance of a move that stands for a run of cuts from the cuts, in spacings.
const RUN_TOLERANCE: f64 = 0.04;
/// Depth of contact that the model resolves, in spacings: less is not reported.
const RESOLVED: f64 = 0.5;
/// Depth by which a cutter that gets less deep into stock in rapid than the model resolves is returned all
/// the same, mm, and the most of it in spacings: rounding and the way of a machine may move it as much.
const RAPID_MARGIN: (f64, f64) = (0.03, 0.25);
/// Pieces applied between two checks of the monitor, and at least between two states that are kept.
const CHUNK: usize = 1 << 12;
/// Spans that fit the memory allowed.
const MAX_SPANS: usize = lattice::MAX_BYTES as usize / (2 * size_of::<Span>());

/// What a stock is before the first cut.
#[derive(Clone, Debug)]
pub enum SolidBlank {
    /// A turned blank.
    Turned(TurnedOutline),
    /// A closed triangle mesh.
    Mesh(MeshBlank),
}

impl SolidBlank {
    /// The blank of `part`: the mesh of its file where there is one, else the turned body.
    pub fn from_part(part: &Impeller, blank: &Blank) -> Self {
        let mesh = blank.file().and_then(|file| file.mesh.as_ref());
        match mesh.map(MeshBlank::of_mesh) {
            Some(Ok(mesh)) => Self::Mesh(mesh),
            _ => Self::Turned(TurnedOutline::of_blank(part, blank)),
        }
    }

    /// Lower and upper corner of the box around it, mm.
    pub fn bounds(&self) -> (Point, Point) {
        match self {
            Self::Turned(outline) => outline.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Its volume, mm³.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Turned(outline) => outline.volume(),
            Self::Mesh(mesh) => mesh.volume(),
        }
    }

    /// Default spacing: the largest extent across the axis of rotation / 800, mm.
    pub fn default_spacing(&self) -> f64 {
        let (low, high) = self.bounds();
        (high.x - low.x).max(high.y - low.y) / 800.0
    }
}

/// The stock as a solid.
#[derive(Clone, Debug)]
pub struct SolidStock {
    lattice: Lattice,
    fields: [RayField; 3],
    near: Arc<NearStock>,
}

impl SolidStock {
    /// The blank, with rays at a spacing in mm.
    ///
    /// ```
    /// use vanecut::{setup::Setup, stock::solid::{SolidBlank, SolidStock}};
    /// # let part = vanecut::io::part_file::read_part("assets/parts/pump6.toml".as_ref())?;
    /// # let part = vanecut::part::Impeller::build(&part)?;
    /// let workpiece = Setup::for_part(&part).allowances.workpiece_of(part);
    /// let blank = SolidBlank::from_part(&workpiece.part, &workpiece.blank);
    /// let stock = SolidStock::new(&blank, 1.0)?;
    /// assert!((stock.volume() / blank.volume() - 1.0).abs() < 0.02);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When the spacing is not possible or would take too much memory.
    pub fn new(blank: &SolidBlank, spacing: f64) -> Result<Self, SolidError> {
        let (low, high) = blank.bounds();
        let lattice = Lattice::around(low, high, spacing)?;
        let fields = match blank {
            SolidBlank::Turned(outline) => outline.rays(&lattice),
            SolidBlank::Mesh(mesh) => mesh.rays(&lattice)?,
        };
        let near = Arc::new(NearStock::from_lattice(&lattice, &fields));
        Ok(Self { lattice, fields, near })
    }

    /// The lattice of its rays.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Volume, mm³: the mean of the three directions. Faces along the rays make it less exact than that of
    /// [`StockSurface::volume`]; it takes a hundredth of the time.
    pub fn volume(&self) -> f64 {
        let length: f64 = self.fields.iter().map(RayField::length).sum();
        length / 3.0 * self.lattice.spacing * self.lattice.spacing
    }

    /// Number of spans; memory grows with it.
    pub fn span_count(&self) -> usize {
        self.tiles().map(|tile| tile.len()).sum()
    }

    /// Memory of its rays, bytes.
    pub fn bytes(&self) -> usize {
        self.tiles().map(|tile| tile.bytes()).sum()
    }

    /// Memory of its rays that `other`, another state of the same stock, does not share, bytes.
    pub fn bytes_beside(&self, other: &Self) -> usize {
        let own = self.tiles().zip(other.tiles()).filter(|(tile, other)| !Arc::ptr_eq(tile, other));
        own.map(|(tile, _)| tile.bytes()).sum()
    }

    fn tiles(&self) -> impl Iterator<Item = &Arc<RayTile>> {
        self.fields.iter().flat_map(|field| &field.tiles)
    }

    /// The spans of the ray along `direction` (0 to 2) through node (u, v) of the other two coordinates,
    /// which follow it in cyclic order.
    pub fn spans(&self, direction: usize, u: usize, v: usize) -> &[Span] {
        self.fields[direction].spans(u, v)
    }

    /// Depth of contact that the model resolves, mm.
    pub fn resolved(&self) -> f64 {
        RESOLVED * self.lattice.spacing
    }

    /// Makes the moves with `tools`: under feed the cutter removes stock; what must not meet stock is
    /// returned, by move, where it gets deeper than [`Self::resolved`].
    ///
    /// # Errors
    /// When cancelled, which leaves a part of the moves made, or when the stock falls into too many pieces.
    pub fn make_moves(
        &mut self,
        tools: &[SolidTool],
        moves: &[SolidMove],
        monitor: &Monitor,
    ) -> Result<Vec<Contact>, SolidError> {
        let found = self.make_moves_from(0, tools, moves, monitor, |_, _, _| ())?;
        let resolved = self.resolved();
        Ok(found.into_iter().filter(|contact| contact.depth > resolved).collect())
    }

    /// As [`Self::make_moves`], for a stock in which the first `made` of `moves` are made already. `keep`
    /// gets some states on the way: the number of moves made, the stock, and the contacts since `made`. A
    /// program with the same moves up to [`MAX_RUN`] beyond such a state may go on from it, with the same
    /// result as from the blank. Cutters in rapid are returned from a little less than [`Self::resolved`] on.
    ///
    /// # Errors
    /// As [`Self::make_moves`].
    pub fn make_moves_from(
        &mut self,
        made: usize,
        tools: &[SolidTool],
        moves: &[SolidMove],
        monitor: &Monitor,
        mut keep: impl FnMut(usize, &Self, &[Contact]),
    ) -> Result<Vec<Contact>, SolidError> {
        let spacing = self.lattice.spacing;
        let bounds = self.lattice.bounds();
        let maker = PieceMaker { tools, tolerance: TURN_TOLERANCE * spacing, bounds, near: &self.near };
        let resolved = ResolvedDepth {
            cutter: self.resolved() - RAPID_MARGIN.0.min(RAPID_MARGIN.1 * spacing),
            other: self.resolved(),
        };
        let mut contacts = Vec::new();
        let mut pieces = Vec::new();
        let mut bodies = Vec::new();
        let mut index = made;
        while index < moves.len() {
            let (merged, count) = runs::next_run(&moves[index..], tools, RUN_TOLERANCE * spacing);
            let run = &moves[index..index + count];
            run.iter().for_each(|step| maker.add_bodies(step, &mut bodies));
            // Where shank or holder may meet stock it matters what each move has left.
            if count > 1 && bodies.is_empty() {
                maker.add_cutter(&merged, &mut pieces);
            } else {
                run.iter().for_each(|step| maker.add(step, &mut pieces));
            }
            bodies.clear();
            index += count;
            if pieces.len() >= CHUNK || index == moves.len() {
                monitor.check()?;
                monitor.report(index as f64 / moves.len() as f64);
                contacts.extend(carve::carve(&self.lattice, &mut self.fields, &pieces, resolved));
                pieces.clear();
                if self.span_count() > MAX_SPANS {
                    return Err(SolidError::Pieces(spacing));
                }
                keep(index, self, &contacts);
            }
        }
        Ok(carve::deepest(contacts))
    }
}
