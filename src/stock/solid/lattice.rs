//! The lattice on whose lines the rays run.

use crate::error::{ErrorCode, UserError};
use crate::geometry::Point;

/// Memory that a stock may take, bytes.
pub const MAX_BYTES: f64 = (1u64 << 30) as f64;
/// Memory up to which a message names it, GiB.
const MAX_SHOWN_GIB: f64 = 1e6;
/// Bytes that a ray takes on average with its spans, the surface on it, and the file of that: measured on a
/// milled wheel, with room.
const BYTES_PER_RAY: f64 = 330.0;
/// Cells across the largest extent of a blank below which its solid says nothing: its volume is off by
/// several percent, or it is between two rays.
const MIN_CELLS: f64 = 25.0;
/// Empty cells around the stock.
const MARGIN: f64 = 1.5;
/// Shift of the lattice in cells, so that its planes do not coincide with faces at round coordinates.
const SHIFT: [f64; 3] = [0.137_035, 0.291_103, 0.412_307];

/// Why a stock cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.explained())]
pub enum SolidError {
    /// The spacing is not a length.
    Spacing(f64),
    /// The stock would take too much memory.
    Memory {
        /// The spacing, mm.
        spacing: f64,
        /// Memory it would take, GiB.
        gib: f64,
        /// A spacing that would do, mm.
        least: f64,
    },
    /// The rays would miss much of the blank.
    Coarse {
        /// The spacing, mm.
        spacing: f64,
        /// A spacing that would do, mm.
        most: f64,
    },
    /// The cuts leave too many separate pieces.
    Pieces(f64),
    /// The blank has no extent.
    Empty,
    /// The work was cancelled.
    Cancelled(#[from] crate::monitor::Cancelled),
}

impl SolidError {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        let (what, help) = match self {
            Self::Spacing(spacing) => {
                (format!("a spacing of {spacing} mm is not possible"), "give a length above 0".to_owned())
            }
            Self::Memory { spacing, gib, least } => {
                let takes =
                    if *gib < MAX_SHOWN_GIB { format!("{gib:.1}") } else { format!("over {MAX_SHOWN_GIB}") };
                (
                    format!("a spacing of {} mm would take {takes} GiB", shown(*spacing)),
                    format!("give at least {least:.3} mm"),
                )
            }
            Self::Coarse { spacing, most } => (
                format!("a spacing of {} mm is too coarse for this blank", shown(*spacing)),
                format!("give {most:.3} mm or less"),
            ),
            Self::Pieces(spacing) => (
                "the stock falls into too many pieces for 1 GiB".to_owned(),
                format!("give a larger spacing than {spacing} mm"),
            ),
            Self::Empty => ("the blank encloses no volume".to_owned(), "check its file".to_owned()),
            Self::Cancelled(cancelled) => return (*cancelled).into(),
        };
        UserError::new(ErrorCode::StockSpacing, what, help)
    }
}

/// A length in the fewest digits: as a decimal number, or with an exponent where that would be long.
fn shown(mm: f64) -> String {
    if (1e-6..1e6).contains(&mm) { format!("{mm}") } else { format!("{mm:e}") }
}

impl From<SolidError> for UserError {
    fn from(error: SolidError) -> Self {
        error.explained()
    }
}

/// A cubic lattice; rays run along its lines in all three directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The node with the least coordinates, mm.
    pub origin: Point,
    /// Distance of neighbouring nodes, mm.
    pub spacing: f64,
    /// Number of nodes along x, y and z.
    pub counts: [usize; 3],
}

impl Lattice {
    /// The lattice of a spacing around the box from `low` to `high`.
    ///
    /// # Errors
    /// When the spacing is not a positive number or too coarse for the box, the box is empty, or the stock
    /// would take more than `MAX_BYTES`.
    pub fn around(low: Point, high: Point, spacing: f64) -> Result<Self, SolidError> {
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(SolidError::Spacing(spacing));
        }
        let extent = high - low;
        if !(extent.min() > 0.0 && extent.iter().all(|x| x.is_finite())) {
            return Err(SolidError::Empty);
        }
        let most = extent.max() / MIN_CELLS;
        if spacing > most {
            return Err(SolidError::Coarse { spacing, most });
        }
        let bytes = |spacing: f64| {
            let [x, y, z] = [0, 1, 2].map(|k| extent[k] / spacing + 2.0 * MARGIN + 2.0);
            // Spans, and one bit for each node while a surface is made.
            BYTES_PER_RAY * (x * y + y * z + z * x) + x * y * z / 8.0
        };
        if bytes(spacing) > MAX_BYTES {
            let mut least = spacing;
            while bytes(least) > MAX_BYTES {
                least *= 1.01;
            }
            return Err(SolidError::Memory { spacing, gib: bytes(spacing) / MAX_BYTES, least });
        }
        let mut origin = low;
        let mut counts = [0; 3];
        for k in 0..3 {
            origin[k] -= (MARGIN + SHIFT[k]) * spacing;
            counts[k] = (extent[k] / spacing + 2.0 * MARGIN + 1.0).ceil() as usize + 1;
        }
        Ok(Self { origin, spacing, counts })
    }

    /// Coordinate of node `index` along `axis`, mm.
    #[inline]
    pub fn coordinate(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + self.spacing * index as f64
    }

    /// The two coordinates across rays along `direction`.
    pub fn across(direction: usize) -> (usize, usize) {
        ((direction + 1) % 3, (direction + 2) % 3)
    }

    /// The point with coordinate 0 of the ray (u, v) along `direction`.
    #[inline]
    pub fn ray(&self, direction: usize, u: usize, v: usize) -> Point {
        let (a, b) = Self::across(direction);
        let mut point = Point::origin();
        point[a] = self.coordinate(a, u);
        point[b] = self.coordinate(b, v);
        point
    }

    /// Lower and upper corner, mm.
    pub fn bounds(&self) -> (Point, Point) {
        let end = |k: usize| self.coordinate(k, self.counts[k] - 1);
        (self.origin, Point::new(end(0), end(1), end(2)))
    }
}
