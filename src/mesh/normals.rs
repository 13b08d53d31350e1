//! Estimated normals of the meshed surface at its corners: least-squares quadratic surface through the
//! corners around each one, within one smooth patch. With them, the surface can be interpolated between
//! corners.

use std::collections::HashMap;

use nalgebra::{SMatrix, SVector};

use super::surface::MeshSurface;
use crate::geometry::{Point, Vector, frame_about};

/// Largest number of corners around a corner, and of triangles around one of these: the centre of a fan has
/// many.
const MAX_NEAR: usize = 200;

/// Smallest cosine between an exact normal and the estimated one that it replaces.
const ALIKE: f64 = 0.9;

/// Exact unit normals of surfaces at points of a mesh, of either sign. A point on an edge has one for each
/// face.
#[derive(Clone, Debug, Default)]
pub struct ExactNormals {
    at: HashMap<[u64; 3], Vec<Vector>>,
}

impl ExactNormals {
    /// From points and normals.
    pub fn from_normals(normals: impl Iterator<Item = (Point, Vector)>) -> Self {
        let mut all = Self::default();
        all.extend(normals);
        all
    }

    /// Adds points and normals.
    pub fn extend(&mut self, normals: impl IntoIterator<Item = (Point, Vector)>) {
        for (p, n) in normals {
            self.at.entry(key(&p)).or_default().push(n);
        }
    }

    /// Whether no normals are known.
    pub fn is_empty(&self) -> bool {
        self.at.is_empty()
    }

    /// In the frame that `to`, a rigid transform, takes the mesh to.
    #[must_use]
    pub fn transformed(self, to: impl Fn(&Point) -> Point) -> Self {
        let origin = to(&Point::origin());
        let all = self.at.into_iter().flat_map(|(k, normals)| {
            let p = Point::from(k.map(f64::from_bits));
            normals.into_iter().map(move |n| (p, n))
        });
        Self::from_normals(all.map(|(p, n)| (to(&p), to(&Point::from(n)) - origin)))
    }

    /// The normal at `p` that is nearest to `estimated`, if any is near it.
    pub fn near(&self, p: &Point, estimated: &Vector) -> Option<Vector> {
        let normals = self.at.get(&key(p))?;
        let best = normals.iter().max_by(|a, b| a.dot(estimated).abs().total_cmp(&b.dot(estimated).abs()))?;
        (best.dot(estimated).abs() > ALIKE).then(|| best * best.dot(estimated).signum())
    }
}

/// A point by the bits of its coordinates; both zeros are one.
fn key(p: &Point) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

/// Normals of a surface's corners.
#[derive(Clone, Debug)]
pub struct CornerNormals {
    /// Per triangle, the unit normals of its own patch at its three corners.
    pub per_triangle: Vec<[Vector; 3]>,
}

impl CornerNormals {
    /// Estimates the normals; `patch` is the number of the smooth patch of each triangle.
    pub fn new(surface: &MeshSurface, patch: &[u32]) -> Self {
        let around = CornerTriangles::new(surface);
        let mut of = vec![[Vector::zeros(); 3]; surface.triangles.len()];
        let mut near: Vec<u32> = Vec::new();
        for corner in 0..surface.points.len() {
            let own = around.triangles(corner);
            for (k, &t) in own.iter().enumerate() {
                let here = patch[t as usize];
                if own[..k].iter().any(|&other| patch[other as usize] == here) {
                    continue;
                }
                near.clear();
                let mut mean = Vector::zeros();
                for &first in own.iter().filter(|&&other| patch[other as usize] == here) {
                    mean += surface.normals[first as usize] * surface.area(first as usize);
                    if near.len() > MAX_NEAR {
                        continue;
                    }
                    for ring in surface.triangles[first as usize] {
                        for &second in around.triangles(ring as usize).iter().take(MAX_NEAR) {
                            if patch[second as usize] == here {
                                near.extend(surface.triangles[second as usize]);
                            }
                        }
                    }
                }
                near.sort_unstable();
                near.dedup();
                near.retain(|&i| i as usize != corner);
                let mean = mean.try_normalize(1e-12).unwrap_or(surface.normals[t as usize]);
                let normal = fit_normal(&surface.points, corner, &near, &mean).unwrap_or(mean);
                for &other in own.iter().filter(|&&other| patch[other as usize] == here) {
                    for c in 0..3 {
                        if surface.triangles[other as usize][c] as usize == corner {
                            of[other as usize][c] = normal;
                        }
                    }
                }
            }
        }
        Self { per_triangle: of }
    }

    /// Replaces estimated normals by exact ones where there are any.
    pub fn replace_by(&mut self, surface: &MeshSurface, exact: &ExactNormals) {
        if exact.at.is_empty() {
            return;
        }
        for ((normals, t), flat) in self.per_triangle.iter_mut().zip(&surface.triangles).zip(&surface.normals)
        {
            for (normal, corner) in normals.iter_mut().zip(t) {
                let p = &surface.points[*corner as usize];
                // The triangle tells its face better than a fit through few corners, unless it is a splinter.
                if let Some(found) = exact.near(p, flat).or_else(|| exact.near(p, normal)) {
                    *normal = found;
                }
            }
        }
    }
}

/// Normal at `corner` of the quadratic surface through it and, by least squares, the corners `near`.
fn fit_normal(points: &[Point], corner: usize, near: &[u32], mean: &Vector) -> Option<Vector> {
    if near.len() < 6 {
        return None;
    }
    let centre = points[corner];
    let (e1, e2) = frame_about(mean);
    // Patches are often much longer than wide: the principal directions are scaled to unit variance.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &i in near {
        let d = points[i as usize] - centre;
        let (x, y) = (d.dot(&e1), d.dot(&e2));
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (a, b) = (e1 * turn.cos() + e2 * turn.sin(), e2 * turn.cos() - e1 * turn.sin());
    let size = |e: &Vector| {
        (near.iter().map(|&i| (points[i as usize] - centre).dot(e).powi(2)).sum::<f64>() / near.len() as f64)
            .sqrt()
    };
    let (sa, sb) = (size(&a), size(&b));
    if sa < 1e-12 || sb < 1e-12 {
        return None;
    }
    let mut matrix = SMatrix::<f64, 5, 5>::zeros();
    let mut right = SVector::<f64, 5>::zeros();
    for &i in near {
        let d = points[i as usize] - centre;
        let (x, y, h) = (d.dot(&a) / sa, d.dot(&b) / sb, d.dot(mean));
        let row = SVector::<f64, 5>::new(x, y, x * x, x * y, y * y);
        let weight = 1.0 / (0.3 + x * x + y * y);
        matrix += row * row.transpose() * weight;
        right += row * (h * weight);
    }
    for k in 0..5 {
        matrix[(k, k)] += 1e-7 * near.len() as f64;
    }
    let solved = matrix.cholesky()?.solve(&right);
    let normal = mean - a * (solved[0] / sa) - b * (solved[1] / sb);
    let normal = normal.try_normalize(1e-12)?;
    // The fit is meaningless for a patch that folds over and is not a function over its mean plane.
    (normal.dot(mean) > 0.7).then_some(normal)
}

/// Triangles around each corner, in compressed rows.
struct CornerTriangles {
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl CornerTriangles {
    fn new(surface: &MeshSurface) -> Self {
        let mut starts = vec![0_u32; surface.points.len() + 1];
        for i in surface.triangles.iter().flatten() {
            starts[*i as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut list = vec![0; 3 * surface.triangles.len()];
        for (t, triangle) in surface.triangles.iter().enumerate() {
            for i in triangle {
                list[next[*i as usize] as usize] = t as u32;
                next[*i as usize] += 1;
            }
        }
        Self { starts, list }
    }

    fn triangles(&self, corner: usize) -> &[u32] {
        &self.list[self.starts[corner] as usize..self.starts[corner + 1] as usize]
    }
}
