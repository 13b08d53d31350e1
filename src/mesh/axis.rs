//! The axis of rotation of a mesh, and the transform that makes it Z.

use std::str::FromStr;

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitVector3};

use super::surface::MeshSurface;
use crate::error::{ErrorCode, UserError};
use crate::geometry::{Point, Vector, frame_about, norm2};

/// Largest area-weighted circumferential component of the hub's normals with which an axis is accepted.
const FOUND: f64 = 0.02;
/// Largest circumferential component of the normal of a triangle of revolution.
const TURNED: f64 = 0.05;
/// Angle, rad, and offset as a share of the size, within which a fitted axis is snapped to one of the file's.
const SNAP: (f64, f64) = (0.002, 5e-4);
/// An axis beside the origin has more area of revolution about it than one through it by this factor.
const BESIDE: f64 = 1.2;
/// As [`BESIDE`], of the area that tells where the axis is, and smallest sine of the angle between its
/// normals and the axis.
const BESIDE_STEEP: f64 = 2.0;
const STEEP: f64 = 0.3;
/// As [`SNAP`], for an axis that is exact but for rounding: rad and mm.
const EXACT: (f64, f64) = (1e-6, 1e-4);
/// Corners of a circle about the axis are of one height, next to each other in radius where the centre is
/// uncertain, and on the circle, each as a share of the size, and in each of this number of sectors.
const RING: (f64, f64, f64) = (4e-6, 2e-3, 2e-5);
const SECTORS: usize = 8;

/// An axis of the file's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Through the origin, along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

impl Axis {
    /// All three.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The letter for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

impl FromStr for Axis {
    type Err = UserError;

    fn from_str(text: &str) -> Result<Self, UserError> {
        let lower = text.to_lowercase();
        let known = Self::ALL.into_iter().find(|axis| axis.name() == lower);
        known.ok_or_else(|| {
            UserError::new(ErrorCode::UnknownName, format!("`{text}` is not an axis"), "give x, y or z")
        })
    }
}

/// Transform from the file's frame to that of the part, where the axis of rotation is Z through the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartFromFile {
    /// A permutation of coordinates, which is exact.
    Along(Axis),
    /// Any other axis.
    Turned {
        /// Rotation of the axis to Z.
        turn: Rotation3<f64>,
        /// A point of the axis in the file's frame.
        through: Point,
    },
}

impl PartFromFile {
    /// The frame about an exact axis through `through`, mm, along the unit vector `along`.
    pub fn about(through: &Point, along: &Vector) -> Self {
        Self::snapped(through, along, EXACT.0, EXACT.1)
    }

    /// The frame about an axis, which is one of the file's where they are within `angle`, rad, and `offset`.
    fn snapped(through: &Point, along: &Vector, angle: f64, offset: f64) -> Self {
        for (axis, own) in [(Axis::Z, Vector::z()), (Axis::Y, Vector::y()), (Axis::X, Vector::x())] {
            let aside = through.coords - own * own.dot(&through.coords);
            if along.cross(&own).norm() < angle && aside.norm() < offset {
                return Self::Along(axis);
            }
        }
        let along = if along.sum() < 0.0 { -along } else { *along };
        // The opposite of Z has no single rotation; any about a line across it will do.
        let turn = Rotation3::rotation_between(&along, &Vector::z())
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
        Self::Turned { turn, through: *through }
    }

    /// Transforms a point of the file's frame to the frame of the part.
    pub fn apply(&self, p: &Point) -> Point {
        match self {
            Self::Along(Axis::X) => Point::new(p.y, p.z, p.x),
            // y is up in a glTF file; this rotation turns it to z.
            Self::Along(Axis::Y) => Point::new(p.x, -p.z, p.y),
            Self::Along(Axis::Z) => *p,
            Self::Turned { turn, through } => turn * Point::from(p - through),
        }
    }
}

/// A triangle of a surface. The axis is sought in some dozen passes over all of them.
struct Facet {
    centre: Point,
    normal: Vector,
    area: f64,
}

impl Facet {
    fn all(surface: &MeshSurface) -> Vec<Self> {
        let facet = |t| Self { centre: surface.centre(t), normal: surface.normals[t], area: surface.area(t) };
        (0..surface.triangles.len()).map(facet).collect()
    }

    /// Whether it is of revolution about the axis through `through` along `along`.
    fn is_revolved(&self, along: &Vector, through: &Point) -> bool {
        let arm = along.cross(&(self.centre - through));
        self.normal.dot(&arm).abs() < TURNED * arm.norm()
    }
}

/// Deviation from a surface of revolution about the axis through `through` along `along`: area-weighted mean
/// of the circumferential component of the normals.
fn revolution_error(facets: &[Facet], along: &Vector, through: &Point) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for facet in facets {
        let arm = along.cross(&(facet.centre - through));
        let r = arm.norm();
        if r > 1e-9 {
            sum += facet.area * (facet.normal.dot(&arm) / r).abs();
            total += facet.area;
        }
    }
    if total > 0.0 { sum / total } else { 1.0 }
}

/// The frame in which the hub's axis of rotation is Z: an axis of the file where one fits, else a fitted
/// axis. `None` where the hub has no axis of rotation.
pub fn find_axis(hub: &MeshSurface) -> Option<PartFromFile> {
    axis_of(hub, &Facet::all(hub))
}

/// As [`find_axis`], of a surface with these facets.
fn axis_of(hub: &MeshSurface, facets: &[Facet]) -> Option<PartFromFile> {
    let axes = [(Axis::Z, Vector::z()), (Axis::Y, Vector::y()), (Axis::X, Vector::x())];
    let (axis, least) = axes
        .iter()
        .map(|(axis, along)| (*axis, revolution_error(facets, along, &Point::origin())))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    if least < FOUND {
        return Some(PartFromFile::Along(axis));
    }
    let (along, through) = fit_axis(facets)?;
    let missed = revolution_error(facets, &along, &through);
    // A body with blades deviates about any axis: then the axis with the largest area of revolution is used.
    if missed > 0.6 * least && missed > FOUND {
        return largest_revolved_axis(hub, facets);
    }
    let size = hub.points.iter().map(|p| (p - through).norm()).fold(0.0, f64::max);
    Some(PartFromFile::snapped(&through, &along, SNAP.0, SNAP.1 * size))
}

/// As [`find_axis`], only where the surface is one of revolution.
pub fn turned_axis(surface: &MeshSurface) -> Option<PartFromFile> {
    let facets = Facet::all(surface);
    let frame = axis_of(surface, &facets)?;
    let (along, through) = match frame {
        PartFromFile::Along(axis) => {
            let own = [(Axis::X, Vector::x()), (Axis::Y, Vector::y()), (Axis::Z, Vector::z())];
            let along = own.into_iter().find(|(a, _)| *a == axis).map_or_else(Vector::z, |(_, v)| v);
            (along, Point::origin())
        }
        PartFromFile::Turned { turn, through } => (turn.inverse() * Vector::z(), through),
    };
    (revolution_error(&facets, &along, &through) < FOUND).then_some(frame)
}

/// Share of its area by which a surface is of revolution about an axis.
fn revolved_share(facets: &[Facet], along: &Vector, through: &Point) -> f64 {
    let (mut turned, mut total) = (0.0, 0.0);
    for facet in facets {
        total += facet.area;
        if facet.is_revolved(along, through) {
            turned += facet.area;
        }
    }
    turned / f64::max(total, 1e-300)
}

/// Area of a surface that is of revolution about an axis and tells where that is, mm²: faces across it, as
/// discs, are so about any axis beside it, and those that are nearly so about many.
fn locating_area(facets: &[Facet], along: &Vector, through: &Point) -> f64 {
    let tells = |facet: &&Facet| {
        let steep = facet.normal.cross(along).norm();
        let arm = along.cross(&(facet.centre - through));
        steep > STEEP && facet.normal.dot(&arm).abs() < TURNED * arm.norm()
    };
    facets.iter().filter(tells).map(|facet| facet.area).sum()
}

/// The axis in a direction of the file's with by far the largest area of revolution about it. In a wheel with
/// its blades, that area is the hub and the blade tips. The axis goes through the origin, unless clearly more
/// area is of revolution about a line beside it.
fn largest_revolved_axis(surface: &MeshSurface, facets: &[Facet]) -> Option<PartFromFile> {
    let by_share = |through: &dyn Fn(&Vector) -> Option<Point>| {
        let axes = [(Axis::X, Vector::x()), (Axis::Y, Vector::y()), (Axis::Z, Vector::z())];
        let mut shares = axes.map(|(axis, along)| {
            let through = through(&along);
            (through.map_or(0.0, |through| revolved_share(facets, &along, &through)), axis, along, through)
        });
        shares.sort_by(|a, b| b.0.total_cmp(&a.0));
        (shares[0], shares[1].0)
    };
    let (own, next) = by_share(&|_| Some(Point::origin()));
    let tells_better = |along: &Vector, through: &Point| {
        let own = locating_area(facets, along, &Point::origin());
        locating_area(facets, along, through) > BESIDE_STEEP * own
    };
    let (beside, beside_next) = by_share(&|along| revolution_centre(facets, along));
    if let Some(through) = beside.3
        && beside.0 > 1.5 * beside_next
        && (beside.0 > BESIDE * own.0 || tells_better(&beside.2, &through))
    {
        let size = surface.points.iter().map(|p| (p - through).norm()).fold(0.0, f64::max);
        let through = centre_of_rings(&surface.points, (&beside.2, &through), size).unwrap_or(through);
        return Some(PartFromFile::snapped(&through, &beside.2, SNAP.0, SNAP.1 * size));
    }
    (own.0 > 1.5 * next).then_some(PartFromFile::Along(own.1))
}

/// The point through which an axis `along` has the surface's triangles of revolution about it. The centre of
/// the area of a wheel is on its axis; from there the point is fitted by least squares, as in [`fit_axis`],
/// to the triangles that are of revolution about the last one.
fn revolution_centre(facets: &[Facet], along: &Vector) -> Option<Point> {
    let mut through = centre_of_area(facets)?;
    for round in 0..6 {
        // At first also those that are nearly of revolution.
        let (mut squares, mut sums) = (Matrix3::zeros(), Vector::zeros());
        for facet in facets {
            let (c, n) = (facet.centre - through, facet.normal);
            let arm = along.cross(&c);
            if n.dot(&arm).abs() > TURNED * arm.norm() * if round < 2 { 3.0 } else { 1.0 } {
                continue;
            }
            // n · (a × (c − p)) = 0 is (n × a) · p = n · (a × c).
            let row = n.cross(along);
            squares += row * row.transpose() * facet.area;
            sums += row * n.dot(&arm) * facet.area;
        }
        let held = along * along.transpose() * squares.trace();
        let step = (squares + held).try_inverse()? * sums;
        through += step;
    }
    through.iter().all(|x| x.is_finite()).then_some(through)
}

/// The point through which an axis `along`, which is near `through`, has circles of corners about it: those
/// of one height and radius all around. Corners are on the surface, as facets are not: they tell the axis
/// better than normals do.
fn centre_of_rings(points: &[Point], (along, through): (&Vector, &Point), size: f64) -> Option<Point> {
    let (e1, e2) = frame_about(along);
    let place = |p: &Point| {
        let d = p - through;
        (d.dot(along), d.dot(&e1), d.dot(&e2))
    };
    let mut places: Vec<(f64, f64, f64)> = points.iter().map(place).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let radius = |(_, x, y): &(f64, f64, f64)| norm2(*x, *y);
    let mut centres: Vec<(f64, f64, f64)> = Vec::new();
    for level in places.chunk_by(|a, b| b.0 - a.0 < RING.0 * size) {
        let mut level = level.to_vec();
        level.sort_by(|a, b| radius(a).total_cmp(&radius(b)));
        for ring in level.chunk_by(|a, b| radius(b) - radius(a) < RING.1 * size) {
            centres.extend(centre_of_ring(ring, RING.2 * size).map(|(x, y)| (ring.len() as f64, x, y)));
        }
    }
    let weight: f64 = centres.iter().map(|c| c.0).sum();
    let median = |of: fn(&(f64, f64, f64)) -> f64| {
        let mut sorted: Vec<(f64, f64)> = centres.iter().map(|c| (of(c), c.0)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut sum = 0.0;
        sorted.into_iter().find_map(|(x, w)| {
            sum += w;
            (sum >= 0.5 * weight).then_some(x)
        })
    };
    let (x, y) = (median(|c| c.1)?, median(|c| c.2)?);
    Some(through + e1 * x + e2 * y)
}

/// The centre of a circle through places, all around and within `tolerance` of it.
fn centre_of_ring(ring: &[(f64, f64, f64)], tolerance: f64) -> Option<(f64, f64)> {
    let mut met = [false; SECTORS];
    for (_, x, y) in ring {
        let turn = y.atan2(*x) / std::f64::consts::TAU + 0.5;
        met[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
    }
    if met.contains(&false) {
        return None;
    }
    // x² + y² = 2 a x + 2 b y + c, by least squares.
    let (mut squares, mut sums) = (Matrix3::zeros(), Vector::zeros());
    for (_, x, y) in ring {
        let row = Vector::new(2.0 * x, 2.0 * y, 1.0);
        squares += row * row.transpose();
        sums += row * (x * x + y * y);
    }
    let found = squares.try_inverse()? * sums;
    let radius = (found.z + found.x * found.x + found.y * found.y).sqrt();
    let is_on = |(_, x, y): &(f64, f64, f64)| (norm2(x - found.x, y - found.y) - radius).abs() < tolerance;
    ring.iter().all(is_on).then_some((found.x, found.y))
}

/// Centre of the area of a surface.
fn centre_of_area(facets: &[Facet]) -> Option<Point> {
    let (mut middle, mut total) = (Vector::zeros(), 0.0);
    for facet in facets {
        middle += facet.centre.coords * facet.area;
        total += facet.area;
    }
    let middle = middle / total;
    middle.iter().all(|x| x.is_finite()).then(|| Point::from(middle))
}

/// The axis as the line that all normals of a surface of revolution intersect: n·(a × c) + n·m = 0 for every
/// triangle with centre c and normal n, by least squares for the direction a (unit) and the moment m.
/// Iteratively reweighted, so that triangles far from it count less.
fn fit_axis(facets: &[Facet]) -> Option<(Vector, Point)> {
    let middle = centre_of_area(facets)?.coords;
    let mut found: Option<(Vector, Vector)> = None;
    for _ in 0..4 {
        let (mut aa, mut am, mut mm) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
        for facet in facets {
            let (c, n) = (facet.centre.coords - middle, facet.normal);
            let arm = c.cross(&n);
            let mut weight = facet.area;
            if let Some((a, m)) = &found {
                let missed = (arm.dot(a) + n.dot(m)) / c.norm().max(1e-9);
                weight /= 1.0 + (missed / FOUND).powi(2);
            }
            aa += arm * arm.transpose() * weight;
            am += arm * n.transpose() * weight;
            mm += n * n.transpose() * weight;
        }
        let inverse = (mm + Matrix3::identity() * (1e-9 * mm.trace())).try_inverse()?;
        let eigen = SymmetricEigen::try_new(aa - am * inverse * am.transpose(), 1e-14, 200)?;
        let k = eigen.eigenvalues.imin();
        let a = Vector::from(eigen.eigenvectors.column(k));
        found = Some((a, -inverse * am.transpose() * a));
    }
    let (a, m) = found?;
    let a = UnitVector3::try_new(a, 1e-12)?.into_inner();
    // m = −a × p for any point p of the axis, and p = a × m is the one nearest to the middle.
    let p = Point::from(middle + a.cross(&m));
    let a = if a.iter().copied().fold(0.0, |x: f64, y| if y.abs() > x.abs() { y } else { x }) < 0.0 {
        -a
    } else {
        a
    };
    p.iter().all(|x| x.is_finite()).then_some((a, p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriangleMesh, grid_triangles};

    #[test]
    fn circles_of_corners_tell_an_axis_beside_the_origin() {
        // A cone with facets of different widths about an axis along Z.
        const SECTORS: u32 = 48;
        let angle = |k: u32| {
            let turn = f64::from(k % SECTORS);
            std::f64::consts::TAU * (turn + 0.4 * turn.sin()) / f64::from(SECTORS)
        };
        let ring = |(r, z): (f64, f64)| {
            (0..=SECTORS).map(move |k| Point::new(10.0 + r * angle(k).cos(), r * angle(k).sin() - 5.0, z))
        };
        let points = [(40.0, 0.0), (20.0, 15.0)].into_iter().flat_map(ring).collect();
        let triangles = grid_triangles(2, SECTORS as usize + 1, |_, _| true);
        let cone = MeshSurface::from_mesh(&TriangleMesh { points, triangles });
        let frame = largest_revolved_axis(&cone, &Facet::all(&cone));
        let Some(PartFromFile::Turned { through, .. }) = frame else { panic!("{frame:?}") };
        let off = norm2(through.x - 10.0, through.y + 5.0);
        assert!(off < 1e-9, "{off} mm");
    }
}
