//! The turned envelope of a mesh: greatest and least height of its triangles over circles about Z.

use super::blank_mesh::BlankMesh;
use super::meridional_outline::{MeridionalOutline, OutlineFault};
use crate::geometry::{Meridional, Point, norm2};

/// Circles over which the heights are taken: fewer for meshes whose triangles cross too many of them
/// together.
const CIRCLES: (usize, usize) = (50, 1000);
const MAX_CROSSINGS: f64 = 1e8;
/// Least difference between the largest and the least radius, mm.
const WALL: f64 = 1e-6;

/// Highest or lowest places over the circles; `sign` is +1 for the highest.
struct Heights {
    sign: f64,
    at: Vec<f64>,
}

impl Heights {
    fn raise(&mut self, circle: usize, z: f64) {
        if let Some(height) = self.at.get_mut(circle) {
            *height = height.max(self.sign * z);
        }
    }
}

/// See [`super::BlankFile::envelope`]. Between circles the envelope is straight; a corner between two circles
/// raises both.
pub(super) fn envelope_of(mesh: &BlankMesh) -> Result<MeridionalOutline, OutlineFault> {
    let triangle = |t: &[u32; 3]| {
        let corner = |i: u32| mesh.points.get(i as usize).copied();
        Some([corner(t[0])?, corner(t[1])?, corner(t[2])?])
    };
    let triangles: Vec<[Point; 3]> = mesh.triangles.iter().filter_map(triangle).collect();
    let r_of = |p: &Point| norm2(p.x, p.y);
    let (mut inner, mut outer) = (f64::INFINITY, 0.0f64);
    for corners in &triangles {
        inner = inner.min(min_radius(corners));
        outer = corners.iter().map(r_of).fold(outer, f64::max);
    }
    let width = outer - inner;
    if !(width.is_finite() && width > WALL) {
        return Err(OutlineFault::Flat);
    }
    let reach = |corners: &[Point; 3]| corners.iter().map(r_of).fold(0.0, f64::max) - min_radius(corners);
    let shares: f64 = triangles.iter().map(|corners| reach(corners) / width).sum();
    let circles = ((MAX_CROSSINGS / shares.max(1.0)) as usize).clamp(CIRCLES.0, CIRCLES.1);
    let width = width / circles as f64;
    let radius = |circle: usize| inner + width * circle as f64;
    let mut both = [1.0, -1.0].map(|sign| Heights { sign, at: vec![f64::NEG_INFINITY; circles + 1] });
    for corners in &triangles {
        for p in corners {
            let circle = ((r_of(p) - inner) / width).max(0.0) as usize;
            for heights in &mut both {
                heights.raise(circle, p.z);
                heights.raise(circle + 1, p.z);
            }
        }
        let low = ((min_radius(corners) - inner) / width).floor().max(0.0) as usize;
        let high = corners.iter().map(r_of).fold(0.0, f64::max);
        for circle in low..=circles {
            if radius(circle) > high {
                break;
            }
            let (lowest, highest) = heights_on_circle(corners, radius(circle));
            let [top, bottom] = &mut both;
            top.raise(circle, highest);
            bottom.raise(circle, lowest);
        }
    }
    let chain = |heights: &Heights| -> Vec<Meridional> {
        let known = heights.at.iter().enumerate().filter(|(_, height)| height.is_finite());
        known.map(|(circle, height)| Meridional { r: radius(circle), z: heights.sign * height }).collect()
    };
    let (top, bottom) = (chain(&both[0]), chain(&both[1]));
    let mut outline: Vec<Meridional> = bottom.into_iter().chain(top.into_iter().rev()).collect();
    outline.extend(outline.first().copied());
    MeridionalOutline::new(&outline)
}

/// Least distance of a triangle from the Z axis.
fn min_radius(corners: &[Point; 3]) -> f64 {
    let flat = corners.map(|p| Meridional { r: p.x, z: p.y });
    let origin = Meridional { r: 0.0, z: 0.0 };
    let side = |k: usize| {
        let (a, b) = (flat[k], flat[(k + 1) % 3]);
        a.r * b.z - a.z * b.r
    };
    let sides = [side(0), side(1), side(2)];
    if sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0) {
        return 0.0;
    }
    (0..3).map(|k| origin.nearest_on_segment(flat[k], flat[(k + 1) % 3]).0).fold(f64::INFINITY, f64::min)
}

/// Least and greatest height of a triangle over a circle about Z: where its edges cross the circle, or where
/// the triangle is steepest along the radius. An empty range where it does not meet the circle.
fn heights_on_circle(corners: &[Point; 3], radius: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut add = |z: f64| (low, high) = (low.min(z), high.max(z));
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let d = b - a;
        let (p, q) = (d.x * d.x + d.y * d.y, a.x * d.x + a.y * d.y);
        let discriminant = q * q - p * (a.x * a.x + a.y * a.y - radius * radius);
        if p > 0.0 && discriminant >= 0.0 {
            for t in [(-q - discriminant.sqrt()) / p, (-q + discriminant.sqrt()) / p] {
                if (0.0..=1.0).contains(&t) {
                    add(a.z + t * d.z);
                }
            }
        }
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let flat = norm2(normal.x, normal.y);
    if flat > 0.0 && normal.z != 0.0 {
        for side in [radius, -radius] {
            let p = Point::new(side * normal.x / flat, side * normal.y / flat, 0.0);
            let left = |k: usize| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
            };
            let sides = [left(0), left(1), left(2)];
            if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                let d = p - corners[0];
                add(corners[0].z - (normal.x * d.x + normal.y * d.y) / normal.z);
            }
        }
    }
    (low, high)
}
