//! Triangle meshes and line segments as plain lists, mm. Meshes are made from grids of points, which
//! [`super::part_mesh`] samples from a part.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::camera::ViewRay;
use crate::geometry::Point;
use crate::mesh::{TriangleMesh, grid_triangles};
use crate::palette::Rgb;

/// One corner of a triangle. 32 bytes, matches `SurfaceIn` of `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Position in the part frame, mm.
    pub position: [f32; 3],
    /// Floor: value for the colour table. Elsewhere: openness 0…1 for ambient shading, 1 in the open, 0
    /// deep in a corner.
    pub value: f32,
    /// Unit normal, pointing out of the material.
    pub normal: [f32; 3],
    /// Floor and walls: 1 where nothing has cut, else 0. Of the stock as a solid: the bits of a [`Paint`].
    pub uncut: f32,
}

/// Colour of a triangle of the stock as a solid; that of its first corner counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Paint(u32);

impl Paint {
    /// By the value of the corners, in the colour table.
    pub const BY_VALUE: Self = Self(0);
    /// Surface of the blank.
    pub const UNCUT: Self = Self(1 << 24);

    /// A colour of its own.
    pub fn colour(colour: Rgb) -> Self {
        Self(2 << 24 | packed(colour))
    }

    /// A colour of its own, of something that the section plane does not cut.
    pub fn whole(colour: Rgb) -> Self {
        Self(3 << 24 | packed(colour))
    }
}

/// A colour in three bytes, as the shader unpacks it.
fn packed(colour: Rgb) -> u32 {
    let [r, g, b] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u32);
    b << 16 | g << 8 | r
}

impl Vertex {
    /// A corner of the stock as a solid; its normal is zero on a sharp edge.
    pub fn painted(position: [f32; 3], normal: [f32; 3], value: f32, paint: Paint) -> Self {
        Self { position, value, normal, uncut: f32::from_bits(paint.0) }
    }
}

/// Indexed triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Vertex indices, three per triangle.
    pub indices: Vec<u32>,
}

/// A line segment. 32 bytes, matches `LineIn` of `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Segment {
    /// Start, mm.
    pub a: [f32; 3],
    /// Width in pixels.
    pub width: f32,
    /// End, mm.
    pub b: [f32; 3],
    /// Index into the table of line colours ([`LineColour`]), or a packed RGB colour ([`Segment::coloured`]).
    pub colour: u32,
}

/// Named line colours; the shader's table has the same order.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineColour {
    /// Edge outside the active channel.
    Edge = 0,
    /// Edge of the active channel.
    WallEdge = 1,
    /// Axis and retract.
    Axis = 2,
    /// Rim of a sound cutter.
    Sound = 3,
    /// Rim of a blocked cutter.
    Blocked = 4,
    /// Rim of the cutter of an interfering plunge.
    Interfering = 5,
    /// Rim of the selected cutter.
    Selected = 6,
    /// Rim of a cutter that is not evaluated yet.
    Unevaluated = 7,
}

impl Segment {
    /// Flag: `colour` holds a packed RGB colour.
    const PACKED_COLOUR: u32 = 1 << 31;
    /// Flag: the line lies on the part and is clipped by the section plane.
    const ON_PART: u32 = 1 << 30;

    /// A line with an RGB colour of its own, packed as the shader unpacks it.
    pub fn coloured(a: [f32; 3], b: [f32; 3], width: f32, colour: Rgb) -> Self {
        Self { a, width, b, colour: Self::PACKED_COLOUR | packed(colour) }
    }

    /// The same line, clipped by the section plane together with the part.
    pub fn on_part(self) -> Self {
        Self { colour: self.colour | Self::ON_PART, ..self }
    }
}

/// Grid of points sampled on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PointGrid {
    /// Number of rows, at least 2.
    pub rows: usize,
    /// Number of columns, at least 2.
    pub columns: usize,
    /// `rows × columns` points, row by row.
    pub points: Vec<Vec3>,
}

impl PointGrid {
    /// Samples a surface at the given parameters: one row per `us`, one column per `vs`.
    pub fn sample(us: &[f64], vs: &[f64], mut surface: impl FnMut(f64, f64) -> Vec3) -> Self {
        let mut points = Vec::with_capacity(us.len() * vs.len());
        for &u in us {
            points.extend(vs.iter().map(|&v| surface(u, v)));
        }
        Self { rows: us.len(), columns: vs.len(), points }
    }

    /// Point at row i, column j.
    pub fn at(&self, i: usize, j: usize) -> Vec3 {
        self.points[i * self.columns + j]
    }

    /// Points of a column, along the rows.
    pub fn column(&self, j: usize) -> Vec<Vec3> {
        (0..self.rows).map(|i| self.at(i, j)).collect()
    }

    /// Points of a row.
    pub fn row(&self, i: usize) -> Vec<Vec3> {
        (0..self.columns).map(|j| self.at(i, j)).collect()
    }

    /// Unit normals from central differences, d/drow × d/dcolumn; zero where the surface is degenerate.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = Vec::with_capacity(self.points.len());
        for i in 0..self.rows {
            for j in 0..self.columns {
                let along = self.at((i + 1).min(self.rows - 1), j) - self.at(i.saturating_sub(1), j);
                let across = self.at(i, (j + 1).min(self.columns - 1)) - self.at(i, j.saturating_sub(1));
                normals.push(along.cross(across).normalize_or_zero());
            }
        }
        normals
    }

    /// Mesh of this grid. All normals are flipped if most of them disagree with `outside`, a vector out of
    /// the material per point; `open` is the openness per point, see [`Vertex::value`].
    pub fn mesh(&self, outside: impl Fn(usize, usize) -> Vec3, open: impl Fn(usize, usize) -> f32) -> Mesh {
        let mut normals = self.normals();
        let votes: f32 = (0..self.points.len())
            .map(|k| normals[k].dot(outside(k / self.columns, k % self.columns).normalize_or_zero()))
            .sum();
        if votes < 0.0 {
            normals.iter_mut().for_each(|n| *n = -*n);
        }
        let vertex = |k: usize| Vertex {
            position: self.points[k].to_array(),
            value: open(k / self.columns, k % self.columns),
            normal: normals[k].to_array(),
            uncut: 0.0,
        };
        Mesh {
            vertices: (0..self.points.len()).map(vertex).collect(),
            indices: quads(self.rows, self.columns),
        }
    }
}

/// Indices of all cells of a grid, two triangles each.
pub fn quads(rows: usize, columns: usize) -> Vec<u32> {
    grid_triangles(rows, columns, |_, _| true).into_flattened()
}

/// A point of a profile of revolution about Z, with its unit normal in the (r, z) plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    /// Radius, mm.
    pub r: f32,
    /// Height, mm.
    pub z: f32,
    /// Normal, radial part.
    pub normal_r: f32,
    /// Normal, axial part.
    pub normal_z: f32,
}

impl Mesh {
    /// The surface of revolution of `profile` about Z at `angles` (rad); `open` is the openness per point.
    pub fn revolve(profile: &[ProfilePoint], angles: &[f64], open: impl Fn(usize, f64) -> f32) -> Self {
        let mut vertices = Vec::with_capacity(profile.len() * angles.len());
        for (i, p) in profile.iter().enumerate() {
            for &angle in angles {
                let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
                vertices.push(Vertex {
                    position: [p.r * cos, p.r * sin, p.z],
                    value: open(i, angle),
                    normal: [p.normal_r * cos, p.normal_r * sin, p.normal_z],
                    uncut: 0.0,
                });
            }
        }
        Self { vertices, indices: quads(profile.len(), angles.len()) }
    }

    /// Flat-shaded copy of every `stride`-th triangle, without shared vertices; `place` transforms a point
    /// into the drawn frame.
    pub fn flat_shaded(mesh: &TriangleMesh, stride: usize, place: impl Fn(&Point) -> Vec3) -> Self {
        let mut flat = Self::default();
        for t in mesh.triangles.iter().step_by(stride.max(1)) {
            let [a, b, c] = t.map(|i| place(&mesh.points[i as usize]));
            let normal = (b - a).cross(c - a).normalize_or_zero().to_array();
            for p in [a, b, c] {
                flat.indices.push(flat.vertices.len() as u32);
                flat.vertices.push(Vertex { position: p.to_array(), value: 1.0, normal, uncut: 0.0 });
            }
        }
        flat
    }

    /// Adds the triangles of another mesh.
    pub fn append(&mut self, other: &Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.indices.extend(other.indices.iter().map(|i| i + base));
    }

    /// The same turned about Z by `angle` (rad).
    pub fn rotated_about_z(&self, angle: f64) -> Self {
        let turned = |p: [f32; 3]| rotate_about_z(Vec3::from_array(p), angle).to_array();
        let vertices = self.vertices.iter();
        let vertices = vertices
            .map(|v| Vertex { position: turned(v.position), normal: turned(v.normal), ..*v })
            .collect();
        Self { vertices, indices: self.indices.clone() }
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Nearest intersection of the ray with a triangle in front of its origin.
    pub fn hit(&self, ray: &ViewRay) -> Option<MeshHit> {
        let mut nearest: Option<(RayCrossing, &[u32])> = None;
        self.each_crossing(ray, |crossing, triangle| {
            if nearest.is_none_or(|(n, _)| crossing.distance < n.distance) {
                nearest = Some((crossing, triangle));
            }
        });
        let (RayCrossing { distance, u, v }, triangle) = nearest?;
        let [a, b, c] = [0, 1, 2].map(|k| self.vertices[triangle[k] as usize]);
        let value = a.value + (b.value - a.value) * u + (c.value - a.value) * v;
        let uncut = a.uncut + (b.uncut - a.uncut) * u + (c.uncut - a.uncut) * v;
        let is_uncut = a.uncut.to_bits() == Paint::UNCUT.0 || uncut > 0.5;
        Some(MeshHit { distance, normal: Vec3::from_array(a.normal), value, is_uncut })
    }

    /// Number of triangles that the ray crosses in front of its origin.
    pub fn crossings(&self, ray: &ViewRay) -> usize {
        let mut count = 0;
        self.each_crossing(ray, |_, _| count += 1);
        count
    }

    /// Calls `found` for every triangle that the ray crosses (Möller–Trumbore).
    fn each_crossing<'a>(&'a self, ray: &ViewRay, mut found: impl FnMut(RayCrossing, &'a [u32])) {
        let at = |i: u32| Vec3::from_array(self.vertices[i as usize].position);
        for triangle in self.indices.chunks_exact(3) {
            let a = at(triangle[0]);
            let (ab, ac) = (at(triangle[1]) - a, at(triangle[2]) - a);
            let p = ray.direction.cross(ac);
            let det = ab.dot(p);
            if det == 0.0 {
                continue;
            }
            let t = ray.origin - a;
            let u = t.dot(p) / det;
            let q = t.cross(ab);
            let v = ray.direction.dot(q) / det;
            let distance = ac.dot(q) / det;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 {
                found(RayCrossing { distance, u, v }, triangle);
            }
        }
    }
}

/// Intersection of a ray with a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance along the ray, mm.
    pub distance: f32,
    /// Normal of the triangle's first corner.
    pub normal: Vec3,
    /// Value interpolated between the corners, see [`Vertex::value`].
    pub value: f32,
    /// Whether nothing has cut there: surface of the blank on the stock as a solid ([`Paint::UNCUT`]), and
    /// corners that are marked.
    pub is_uncut: bool,
}

/// Intersection of a ray with a triangle: distance along the ray, barycentric coordinates of the second and
/// third corner.
#[derive(Clone, Copy)]
struct RayCrossing {
    distance: f32,
    u: f32,
    v: f32,
}

/// Rotates a point about Z by `angle` (rad).
pub fn rotate_about_z(p: Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
    Vec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z)
}

/// Segments of a polyline.
pub fn polyline(points: &[Vec3], width: f32, colour: LineColour) -> impl Iterator<Item = Segment> + '_ {
    points.windows(2).map(move |w| Segment {
        a: w[0].to_array(),
        width,
        b: w[1].to_array(),
        colour: colour as u32,
    })
}

/// `count` + 1 evenly spaced parameters from 0 to 1.
pub fn even_steps(count: usize) -> Vec<f64> {
    (0..=count).map(|i| i as f64 / count as f64).collect()
}

/// Selects those parameters of `us` whose polyline stays within `tolerance` (mm) of the curve
/// (Douglas–Peucker), so that a blade's nose keeps its roundness with few points.
pub fn thin_parameters(us: &[f64], curve: impl Fn(f64) -> Vec3, tolerance: f32) -> Vec<f64> {
    let points: Vec<Vec3> = us.iter().map(|&u| curve(u)).collect();
    let mut keep = vec![false; us.len()];
    if let Some(last) = us.len().checked_sub(1) {
        keep[0] = true;
        keep[last] = true;
        let mut open = vec![(0, last)];
        while let Some((from, to)) = open.pop() {
            let chord = (points[to] - points[from]).normalize_or_zero();
            let gap = |k: usize| {
                let d = points[k] - points[from];
                (d - chord * d.dot(chord)).length()
            };
            let worst = (from + 1..to).map(|k| (gap(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((gap, k)) = worst
                && gap > tolerance
            {
                keep[k] = true;
                open.push((from, k));
                open.push((k, to));
            }
        }
    }
    us.iter().zip(keep).filter_map(|(&u, k)| k.then_some(u)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone() -> Mesh {
        let n = 0.5f32.sqrt();
        let profile = [(10.0, 0.0), (5.0, 5.0)].map(|(r, z)| ProfilePoint { r, z, normal_r: n, normal_z: n });
        let angles: Vec<f64> = even_steps(90).iter().map(|t| t * std::f64::consts::TAU).collect();
        Mesh::revolve(&profile, &angles, |_, _| 1.0)
    }

    #[test]
    fn a_turned_profile_closes_and_is_hit_where_it_stands() {
        let mesh = cone();
        assert_eq!(mesh.triangles(), 180);
        let ray = ViewRay { origin: Vec3::new(7.5, 0.01, 100.0), direction: Vec3::NEG_Z };
        let hit = mesh.hit(&ray).expect("over the cone");
        assert!((hit.distance - 97.5).abs() < 0.02, "{hit:?}");
        assert!(hit.normal.z > 0.7, "{hit:?}");
        assert_eq!(mesh.crossings(&ray), 1);
        let beside = ViewRay { origin: Vec3::new(20.0, 0.0, 100.0), direction: Vec3::NEG_Z };
        assert_eq!(mesh.hit(&beside), None);
    }

    #[test]
    fn a_grids_normals_point_out_of_the_material() {
        let grid = PointGrid::sample(&even_steps(8), &even_steps(4), |u, v| {
            Vec3::new(u as f32, v as f32, (u * u) as f32 * 0.1)
        });
        for up in [Vec3::Z, Vec3::NEG_Z] {
            let mesh = grid.mesh(|_, _| up, |_, _| 1.0);
            assert_eq!(mesh.triangles(), 64);
            for vertex in &mesh.vertices {
                let n = Vec3::from_array(vertex.normal);
                assert!((n.length() - 1.0).abs() < 1e-5 && n.dot(up) > 0.9, "{n}");
            }
        }
    }

    #[test]
    fn the_value_where_a_ray_meets_is_that_of_the_corners_about_it() {
        let grid =
            PointGrid::sample(&even_steps(4), &even_steps(4), |u, v| Vec3::new(u as f32, v as f32, 0.0));
        let mesh = grid.mesh(|_, _| Vec3::Z, |i, j| i as f32 - 10.0 * j as f32);
        let ray = ViewRay { origin: Vec3::new(0.4, 0.15, 3.0), direction: Vec3::NEG_Z };
        let hit = mesh.hit(&ray).expect("over the grid");
        assert!((hit.value - (1.6 - 6.0)).abs() < 1e-4, "{hit:?}");
    }

    #[test]
    fn thinning_keeps_the_nose_and_drops_the_straight() {
        // A quarter circle of 1 mm, then 50 mm straight.
        let curve = |u: f64| {
            if u < 0.5 {
                let a = (u * std::f64::consts::PI) as f32;
                Vec3::new(1.0 - a.cos(), a.sin(), 0.0)
            } else {
                Vec3::new(1.0 + (u as f32 - 0.5) * 100.0, 1.0, 0.0)
            }
        };
        let us = even_steps(200);
        let kept = thin_parameters(&us, curve, 0.01);
        assert_eq!((kept[0], *kept.last().expect("two ends")), (0.0, 1.0));
        let in_nose = kept.iter().filter(|&&u| u < 0.5).count();
        assert!((4..12).contains(&in_nose) && kept.len() - in_nose <= 3, "{kept:?}");
    }
}
