//! Triangles of one face: constrained Delaunay in the plane of its parameters.

use std::collections::HashMap;

use spade::handles::FixedFaceHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, PositionInTriangulation, Triangulation};

use super::chart::{Chart, Ring, unwrapped};
use super::edges::{EdgePoints, StepFineness, off_line};
use super::model::{EntityArguments, EntityFault, EntityResult};
use super::shape::ShapeReader;
use super::surface::Surface;
use crate::geometry::{Point, Vector};

type Plane = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Largest number of steps between two knots.
const MAX_STEPS: usize = 64;
/// Largest number of divisions of a step of a twisted surface.
const MAX_DIVISIONS: f64 = 200.0;
/// Largest number of points inside a face.
const MAX_INSIDE: usize = 400_000;
/// Points inside keep this share of the grid's width away from the border.
const CLEAR: f64 = 0.3;

/// What a face became.
#[derive(Debug)]
pub struct MeshedFace {
    /// Its triangles, with the material behind them.
    pub triangles: Vec<[u32; 3]>,
    /// Its surface.
    pub surface: Surface,
    /// Why some of it is missing.
    pub fault: Option<&'static str>,
    /// Unit normals of a curved surface at points of the triangles, of either sign.
    pub normals: Vec<(u32, Vector)>,
    /// Whether its borders run round it against the sense that it gives for its surface: one of the two is
    /// wrong.
    pub against_borders: bool,
}

/// The borders of a face as closed lines of points; edges that the face has on both sides are left out.
fn border_rings(
    reader: ShapeReader<'_, '_>,
    edges: &mut EdgePoints<'_, '_>,
    face: &EntityArguments<'_, '_>,
) -> EntityResult<Vec<Vec<u32>>> {
    let model = reader.model;
    let mut rings = Vec::new();
    for bound in face.references(1)? {
        let b = model.expect(face.id, bound, &["FACE_OUTER_BOUND", "FACE_BOUND"])?;
        let (loop_id, forward) = (b.reference(1)?, b.is_true(2)?);
        let l = model.instance(bound, loop_id)?;
        if l.record("VERTEX_LOOP").is_some() {
            continue;
        }
        let found = if let Some(values) = l.record("POLY_LOOP") {
            let corners = EntityArguments::new(loop_id, values).references(1)?;
            vec![corners.iter().map(|c| edges.vertex(loop_id, *c)).collect::<EntityResult<Vec<u32>>>()?]
        } else {
            edge_loops(reader, edges, bound, loop_id)?
        };
        for mut ring in found {
            ring.dedup();
            if ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
            if !forward {
                ring.reverse();
            }
            if ring.len() > 2 {
                rings.push(ring);
            }
        }
    }
    Ok(rings)
}

fn edge_loops(
    reader: ShapeReader<'_, '_>,
    edges: &mut EdgePoints<'_, '_>,
    from: u32,
    id: u32,
) -> EntityResult<Vec<Vec<u32>>> {
    let model = reader.model;
    let mut parts: Vec<(u32, bool)> = Vec::new();
    for oriented in model.expect(from, id, &["EDGE_LOOP"])?.references(1)? {
        let o = model.expect(id, oriented, &["ORIENTED_EDGE"])?;
        parts.push((o.reference(3)?, o.is_true(4)?));
    }
    let mut uses: HashMap<u32, [usize; 2]> = HashMap::new();
    for (edge, forward) in &parts {
        uses.entry(*edge).or_default()[usize::from(*forward)] += 1;
    }
    // A seam is in the loop once in either direction.
    let before = parts.len();
    parts.retain(|(edge, _)| uses.get(edge) != Some(&[1, 1]));
    let lines = parts
        .iter()
        .map(|(edge, forward)| {
            let mut line = edges.edge(id, *edge)?;
            if !forward {
                line.reverse();
            }
            Ok(line)
        })
        .collect::<EntityResult<Vec<Vec<u32>>>>()?;
    if parts.len() == before {
        return Ok(vec![lines.concat()]);
    }
    // What is left of the loop falls into closed lines.
    let mut rings = Vec::new();
    let mut used = vec![false; lines.len()];
    for start in 0..lines.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let mut ring = lines[start].clone();
        while ring.first() != ring.last() {
            let next = (0..lines.len())
                .map(|k| (start + 1 + k) % lines.len())
                .find(|k| !used[*k] && lines[*k].first() == ring.last());
            let Some(next) = next else { break };
            used[next] = true;
            ring.extend(&lines[next]);
        }
        rings.push(ring);
    }
    Ok(rings)
}

/// Triangles of the face of instance `id`.
///
/// # Errors
/// When its surface or an edge is not understood; what cannot be meshed is a fault of the result.
pub fn mesh_face(
    reader: ShapeReader<'_, '_>,
    edges: &mut EdgePoints<'_, '_>,
    id: u32,
    fineness: StepFineness,
) -> EntityResult<MeshedFace> {
    let a = reader.model.expect(id, id, &["ADVANCED_FACE", "FACE_SURFACE", "FACE"])?;
    let same = a.is_true(3).unwrap_or(true);
    let mut rings = border_rings(reader, edges, &a)?;
    let mut surface = match a.optional(2) {
        Some(surface) => reader.surface(id, surface)?,
        None => plane_of(&rings, &edges.points).ok_or_else(|| EntityFault::new(id, "has no surface"))?,
    };
    // A polygon is flat whatever it says of its surface.
    rings.sort_by_key(|ring| std::cmp::Reverse(ring.len()));
    if let Some(ring) = rings.first() {
        surface.facing(&ring.iter().map(|i| edges.points[*i as usize]).collect::<Vec<_>>());
    }
    let mut fault = None;
    let mut triangles = Vec::new();
    let mut normals = Vec::new();
    let mut against_borders = false;
    if rings.is_empty() {
        match closed_surface(&surface, edges, fineness) {
            Some(all) => triangles = all,
            None => fault = Some("it has no borders"),
        }
    } else {
        let poles = surface.poles();
        let unwrapped: Option<Vec<Ring>> =
            rings.iter().map(|ring| unwrapped(&surface, ring, &edges.points, &poles)).collect();
        match unwrapped {
            None => fault = Some("its borders are not on its surface"),
            Some(mut rings) => match Chart::new(&surface, &mut rings, same, &poles) {
                Err(why) => fault = Some(why),
                Ok(chart) => {
                    let area: f64 = rings.iter().map(Ring::signed_area).sum();
                    against_borders = chart.round().is_none() && (area > 0.0) != same;
                    let budget = |n: usize| reader.spend(id, n);
                    let (found, crossing) =
                        triangulate(&surface, &chart, &rings, edges, fineness, budget, &mut normals)?;
                    triangles = found;
                    if chart.reversed {
                        triangles.iter_mut().for_each(|t| t.swap(1, 2));
                    }
                    fault = crossing
                        .then_some("its borders cross")
                        .or_else(|| triangles.is_empty().then_some("it has no extent"));
                }
            },
        }
    }
    if !same {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(MeshedFace { triangles, surface, fault, normals, against_borders })
}

/// The plane through the first border of a face without a surface.
fn plane_of(rings: &[Vec<u32>], points: &[Point]) -> Option<Surface> {
    let ring: Vec<Point> = rings.first()?.iter().map(|i| points[*i as usize]).collect();
    let origin = *ring.first()?;
    let area = ring.windows(2).map(|w| (w[0] - origin).cross(&(w[1] - origin))).sum::<Vector>();
    let z = area.try_normalize(1e-12)?;
    Some(Surface::Plane(super::model::Frame::new(origin, z, Vector::x())))
}

/// Values of parameter `k` that are close enough for the chord error.
fn steps(surface: &Surface, ranges: [(f64, f64); 2], k: usize, fineness: StepFineness) -> Vec<f64> {
    let (low, high) = ranges[k];
    if surface.is_straight(k) {
        return vec![low, high];
    }
    let breaks = surface.breaks(k, low, high);
    let other = ranges[1 - k];
    let at = |t: f64, share: f64| {
        let s = other.0 + (other.1 - other.0) * share;
        surface.at(if k == 0 { [t, s] } else { [s, t] })
    };
    let coarse = |a: f64, b: f64| {
        (0..5).any(|j| {
            let share = j as f64 / 4.0;
            let (p, m, q) = (at(a, share), at(0.5 * (a + b), share), at(b, share));
            let (sag, length) = (off_line(&m, &p, &q), (q - p).norm());
            sag > fineness.chord_mm || (length > 1e-6 && 4.0 * sag / length > fineness.turn_rad)
        })
    };
    let mut steps = Vec::new();
    for w in breaks.windows(2) {
        let end = |n: usize, i: usize| w[0] + (w[1] - w[0]) * i as f64 / n as f64;
        let mut n = 1;
        while n < MAX_STEPS && (0..n).any(|i| coarse(end(n, i), end(n, i + 1))) {
            n *= 2;
        }
        steps.extend((0..n).map(|i| end(n, i)));
    }
    steps.push(high);
    steps
}

/// Each step divided into `n`.
fn divided(steps: &[f64], n: usize) -> Vec<f64> {
    let inner =
        steps.windows(2).flat_map(|w| (0..n).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / n as f64));
    inner.chain(steps.last().copied()).collect()
}

/// The grid of parameters for a face. Where lines of both parameters are straight the surface may still be
/// twisted: then both are divided further.
fn grid(surface: &Surface, ranges: [(f64, f64); 2], fineness: StepFineness) -> [Vec<f64>; 2] {
    let mut grid = [steps(surface, ranges, 0, fineness), steps(surface, ranges, 1, fineness)];
    if matches!(surface, Surface::Nurbs(_) | Surface::Offset(..)) {
        let mut most = 0.0_f64;
        for u in grid[0].windows(2).step_by(grid[0].len() / 16 + 1) {
            for v in grid[1].windows(2).step_by(grid[1].len() / 16 + 1) {
                let corner = |i: usize, j: usize| surface.at([u[i], v[j]]);
                let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
                if let Some(normal) = (c - a).cross(&(d - b)).try_normalize(1e-12) {
                    most = most.max(0.5 * ((a - b) + (c - d)).dot(&normal).abs());
                }
            }
        }
        // The twist of a cell falls with its area.
        let n = (most / fineness.chord_mm).sqrt().ceil().clamp(1.0, MAX_DIVISIONS) as usize;
        if n > 1 {
            grid = grid.map(|steps| divided(&steps, n));
        }
    }
    while grid[0].len() * grid[1].len() > MAX_INSIDE {
        let wider = usize::from(grid[1].len() > grid[0].len());
        let last = grid[wider].last().copied();
        grid[wider] = grid[wider].iter().step_by(2).copied().chain(last).collect();
    }
    grid
}

/// Triangles of a surface without borders, such as a sphere: a grid closed at its periods and poles.
fn closed_surface(
    surface: &Surface,
    edges: &mut EdgePoints<'_, '_>,
    fineness: StepFineness,
) -> Option<Vec<[u32; 3]>> {
    let ranges = surface.closed_range()?;
    let periods = surface.periods();
    let poles = surface.poles();
    let pole_at = |k: usize, value: f64| {
        poles.iter().any(|p| p.loose == 1 - k && (p.value - value).abs() < 1e-9 * (ranges[k].1 - ranges[k].0))
    };
    let ends = |k: usize| periods[k].is_some() || (pole_at(k, ranges[k].0) && pole_at(k, ranges[k].1));
    if !(ends(0) && ends(1)) {
        return None;
    }
    let [us, vs] = grid(surface, ranges, fineness);
    let (rows, columns) = (us.len(), vs.len());
    let mut number = vec![u32::MAX; rows * columns];
    for i in 0..rows {
        for j in 0..columns {
            let first_of = |k: usize, at: usize, last: usize| {
                let closed = periods[k].is_some() && at == last;
                if closed { 0 } else { at }
            };
            let (mut a, mut b) = (first_of(0, i, rows - 1), first_of(1, j, columns - 1));
            if pole_at(0, us[i]) && periods[0].is_none() {
                b = 0;
            }
            if pole_at(1, vs[j]) && periods[1].is_none() {
                a = 0;
            }
            if (a, b) == (i, j) {
                number[i * columns + j] = edges.add(surface.at([us[i], vs[j]]));
            } else {
                number[i * columns + j] = number[a * columns + b];
            }
        }
    }
    let mut triangles = Vec::new();
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let at = |di: usize, dj: usize| number[(i + di) * columns + j + dj];
            let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
            let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
            triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(whole));
        }
    }
    Some(triangles)
}

/// Which triangles of the plane are reached from outside over an odd number of borders.
fn inside(plane: &Plane) -> Vec<bool> {
    let mut odd: Vec<Option<bool>> = vec![None; plane.num_all_faces()];
    let mut waiting: Vec<(FixedFaceHandle<spade::handles::InnerTag>, bool)> = Vec::new();
    for e in plane.convex_hull() {
        if let Some(face) = e.rev().face().as_inner() {
            waiting.push((face.fix(), e.is_constraint_edge()));
        } else if let Some(face) = e.face().as_inner() {
            waiting.push((face.fix(), e.is_constraint_edge()));
        }
    }
    while let Some((face, is_odd)) = waiting.pop() {
        if odd[face.index()].is_some() {
            continue;
        }
        odd[face.index()] = Some(is_odd);
        for e in plane.face(face).adjacent_edges() {
            if let Some(next) = e.rev().face().as_inner()
                && odd[next.index()].is_none()
            {
                waiting.push((next.fix(), is_odd ^ e.is_constraint_edge()));
            }
        }
    }
    odd.into_iter().map(|o| o == Some(true)).collect()
}

/// Triangles of a face, and whether its borders cross.
fn triangulate(
    surface: &Surface,
    chart: &Chart,
    rings: &[Ring],
    edges: &mut EdgePoints<'_, '_>,
    fineness: StepFineness,
    spend: impl Fn(usize) -> EntityResult<()>,
    normals: &mut Vec<(u32, Vector)>,
) -> EntityResult<(Vec<[u32; 3]>, bool)> {
    let inner = (!matches!(surface, Surface::Plane(_))).then(|| grid(surface, chart.ranges, fineness));
    let is_straight = surface.is_straight(0) || surface.is_straight(1);
    let mut chart = chart.clone();
    if let Some([us, vs]) = inner.as_ref().filter(|_| !is_straight) {
        chart = chart.with_cells([us.len() - 1, vs.len() - 1]);
    }
    let mut plane = Plane::new();
    let mut crossing = false;
    let mut owner: Vec<u32> = Vec::new();
    // Numbers below this are not numbers to `spade`.
    let flushed = |[x, y]: [f64; 2]| {
        let flush = |x: f64| if x.abs() < 1e-30 { 0.0 } else { x };
        Point2::new(flush(x), flush(y))
    };
    for ring in rings {
        let mut handles = Vec::with_capacity(ring.places.len());
        for (q, number) in &ring.places {
            let Ok(handle) = plane.insert(flushed(chart.place(*q))) else {
                crossing = true;
                continue;
            };
            if handle.index() == owner.len() {
                owner.push(*number);
            }
            handles.push(handle);
        }
        for (k, a) in handles.iter().enumerate() {
            let b = handles[(k + 1) % handles.len()];
            if *a != b {
                if plane.can_add_constraint(*a, b) {
                    plane.add_constraint(*a, b);
                } else {
                    crossing = true;
                }
            }
        }
    }
    if plane.num_inner_faces() == 0 {
        return Ok((Vec::new(), crossing));
    }
    let on_border = rings.iter().flat_map(|ring| &ring.places);
    normals.extend(on_border.map(|(q, number)| (*number, surface.normal(*q))));
    let border = inside(&plane);
    let mut places: Vec<([f64; 2], Point2<f64>)> = Vec::new();
    if let Some([us, vs]) = inner {
        // Between the ends; all round where it goes round.
        let between = |values: &[f64], k: usize| -> Vec<f64> {
            let first = usize::from(chart.round() != Some(k));
            values.get(first..values.len() - 1).unwrap_or_default().to_vec()
        };
        let (us, vs) = (between(&us, 0), between(&vs, 1));
        spend(us.len() * vs.len())?;
        for u in &us {
            for v in &vs {
                places.push(([*u, *v], flushed(chart.place([*u, *v]))));
            }
        }
        // The distance between neighbours of the grid, to stay clear of the border by a share of it.
        let near = |k: usize, n: usize| n > k + 1;
        let spacing = |i: usize| -> f64 {
            let other =
                |j: usize| places.get(j).map(|(_, p)| (p.x - places[i].1.x).hypot(p.y - places[i].1.y));
            let next_v = if near(i % vs.len().max(1), vs.len()) {
                other(i + 1)
            } else {
                i.checked_sub(1).and_then(other)
            };
            let next_u = other(i + vs.len()).or_else(|| i.checked_sub(vs.len()).and_then(other));
            let own = |d: Option<f64>| d.filter(|d| *d > 0.0).unwrap_or(f64::INFINITY);
            own(next_v).min(own(next_u))
        };
        let keep: Vec<bool> = (0..places.len())
            .map(|i| {
                let p = places[i].1;
                let PositionInTriangulation::OnFace(face) = plane.locate(p) else { return false };
                if border.get(face.index()) != Some(&true) {
                    return false;
                }
                let clear = CLEAR * spacing(i);
                let clear = if clear.is_finite() { clear * clear } else { 0.0 };
                let face = plane.face(face);
                let free = |e: spade::handles::DirectedEdgeHandle<'_, _, _, _, _>| {
                    !e.is_constraint_edge() || e.distance_2(p) > clear
                };
                face.adjacent_edges().into_iter().all(free)
                    && face.vertices().iter().all(|v| v.position().distance_2(p) > clear)
            })
            .collect();
        let mut keep = keep.into_iter();
        places.retain(|_| keep.next() == Some(true));
    }
    if let Some(pole) = chart.pole {
        let mut q = [pole.value; 2];
        q[pole.loose] = chart.ranges[pole.loose].0;
        places.push((q, Point2::new(0.0, 0.0)));
    }
    for (q, place) in places {
        if let Ok(handle) = plane.insert(place)
            && handle.index() == owner.len()
        {
            let number = edges.add(surface.at(q));
            owner.push(number);
            normals.push((number, surface.normal(q)));
        }
    }
    let inside = inside(&plane);
    let mut triangles = Vec::new();
    for face in plane.inner_faces().filter(|f| inside[f.index()]) {
        let t = face.vertices().map(|v| owner.get(v.index()).copied().unwrap_or(0));
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            triangles.push(t);
        }
    }
    Ok((triangles, crossing))
}
