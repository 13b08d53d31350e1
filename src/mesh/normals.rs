//! Estimated normals of the meshed surface at its corners: least-squares quadratic surface through the
//! corners around each one, within one smooth patch. With them, the surface can be interpolated between
//! corners.

use std::collections::HashMap;

use nalgebra::{SMatrix, SVector};

use super::surface::MeshSurface;
use crate::geometry::{Point, Vector, bits_of, frame_about};

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
            self.at.entry(bits_of(&p)).or_default().push(n);
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
        let normals = self.at.get(&bits_of(p))?;
        let best = normals.iter().max_by(|a, b| a.dot(estimated).abs().total_cmp(&b.dot(estimated).abs()))?;
        (best.dot(estimated).abs() > ALIKE).then(|| best * best.dot(estimated).signum())
    }
}

/// Normals of a surface's corners.
#[derive(Clone, Debug)]
pub struct CornerNormals {
    /// Per triangle, the unit normals of its own patch at its three corners.
    pub per_triangle: Vec<[Vector; 3]>,
}

impl CornerNormals {
    /// Estimates the normals; `smooth` tells of each triangle whether it meets its neighbours smoothly, and
    /// `jumps` over which of its edges the curvature jumps.
    pub fn new(surface: &MeshSurface, smooth: &[[bool; 3]], jumps: &[[bool; 3]]) -> Self {
        let even = |t: usize| std::array::from_fn(|k| smooth[t][k] && !jumps[t][k]);
        let around = CornerTriangles::new(surface, &(0..smooth.len()).map(even).collect::<Vec<_>>());
        let whole = CornerTriangles::new(surface, smooth);
        let mut at_jump = vec![false; surface.points.len()];
        for (corners, jumps) in surface.triangles.iter().zip(jumps) {
            for k in (0..3).filter(|k| jumps[*k]) {
                at_jump[corners[k] as usize] = true;
                at_jump[corners[(k + 1) % 3] as usize] = true;
            }
        }
        let mut of = vec![[Vector::zeros(); 3]; surface.triangles.len()];
        let set = |of: &mut Vec<[Vector; 3]>, corner: usize, fan: &[u32], normal: Vector| {
            for &t in fan {
                for c in (0..3).filter(|c| surface.triangles[t as usize][*c] as usize == corner) {
                    of[t as usize][c] = normal;
                }
            }
        };
        let mut near: Vec<u32> = Vec::new();
        for corner in 0..surface.points.len() {
            // The corners on one side of a jump lie on few lines, which tell no quadratic surface; but where
            // it hardly bends its facets are large, and have the normal of both sides.
            if at_jump[corner] {
                for own in whole.fans(corner) {
                    let sides = around.fans(corner).filter(|side| own.contains(&side[0]));
                    let sums = sides.map(|side| surface.sum_of_normals(side));
                    let largest = sums.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
                    let flat = surface.normals[own[0] as usize];
                    let normal = largest.and_then(|sum| sum.try_normalize(1e-12)).unwrap_or(flat);
                    set(&mut of, corner, own, normal);
                }
                continue;
            }
            for own in around.fans(corner) {
                near.clear();
                for &first in own {
                    if near.len() > MAX_NEAR {
                        continue;
                    }
                    for ring in 0..3 {
                        for &second in around.fan(first as usize, ring).iter().take(MAX_NEAR) {
                            near.extend(surface.triangles[second as usize]);
                        }
                    }
                }
                near.sort_unstable();
                near.dedup();
                near.retain(|&i| i as usize != corner);
                let mean = surface.sum_of_normals(own).try_normalize(1e-12);
                let mean = mean.unwrap_or(surface.normals[own[0] as usize]);
                let normal = fit_normal(&surface.points, corner, &near, &mean).unwrap_or(mean);
                set(&mut of, corner, own, normal);
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

/// Triangles around each corner, in compressed rows, by fans: those of a fan meet smoothly at the corner. An
/// edge may be sharp at one end and run out in a smooth face at the other.
struct CornerTriangles<'a> {
    surface: &'a MeshSurface,
    starts: Vec<u32>,
    list: Vec<u32>,
    /// Where in `list` the fan of each corner of each triangle begins and ends.
    fans: Vec<[(u32, u32); 3]>,
}

impl<'a> CornerTriangles<'a> {
    fn new(surface: &'a MeshSurface, smooth: &[[bool; 3]]) -> Self {
        let triangles = &surface.triangles;
        let mut starts = vec![0_u32; surface.points.len() + 1];
        for i in triangles.iter().flatten() {
            starts[*i as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut list = vec![0; 3 * triangles.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for i in triangle {
                list[next[*i as usize] as usize] = t as u32;
                next[*i as usize] += 1;
            }
        }
        let mut fans = vec![[(0, 0); 3]; triangles.len()];
        let mut waiting = vec![false; triangles.len()];
        for corner in 0..surface.points.len() {
            let rows = starts[corner] as usize..starts[corner + 1] as usize;
            let (mut end, own) = (rows.start, list[rows].to_vec());
            own.iter().for_each(|t| waiting[*t as usize] = true);
            for first in own {
                if !std::mem::take(&mut waiting[first as usize]) {
                    continue;
                }
                let begin = end;
                list[end] = first;
                end += 1;
                let mut at = begin;
                while at < end {
                    let t = list[at] as usize;
                    at += 1;
                    for k in (0..3).filter(|k| smooth[t][*k]) {
                        let other = surface.neighbours[t][k];
                        let meets = [k, (k + 1) % 3].iter().any(|c| triangles[t][*c] as usize == corner);
                        if meets && std::mem::take(&mut waiting[other as usize]) {
                            list[end] = other;
                            end += 1;
                        }
                    }
                }
                for t in list[begin..end].iter().map(|t| *t as usize) {
                    for c in (0..3).filter(|c| triangles[t][*c] as usize == corner) {
                        fans[t][c] = (begin as u32, end as u32);
                    }
                }
            }
        }
        Self { surface, starts, list, fans }
    }

    /// The fans of a corner.
    fn fans(&self, corner: usize) -> impl Iterator<Item = &[u32]> {
        let (mut at, to) = (self.starts[corner], self.starts[corner + 1]);
        std::iter::from_fn(move || {
            let first = *self.list.get(at as usize).filter(|_| at < to)? as usize;
            let c = self.surface.triangles[first].iter().position(|i| *i as usize == corner)?;
            at = self.fans[first][c].1;
            Some(self.fan(first, c))
        })
    }

    /// The fan of a triangle around its corner `c`.
    fn fan(&self, triangle: usize, c: usize) -> &[u32] {
        let (begin, end) = self.fans[triangle][c];
        &self.list[begin as usize..end as usize]
    }
}
