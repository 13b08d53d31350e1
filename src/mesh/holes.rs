//! Holes in a blade's surface. Borders of missing triangles are not borders of the blade: small holes and
//! notches are filled by greedy ear clipping before the blade is sliced, larger ones are reported.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::ops::RangeInclusive;

use super::surface::{MeshSurface, SHARP};
use crate::geometry::{Point, Vector};

/// Longest edge added across a hole, as a share of the blade's extent. Filling a single missing triangle adds
/// no edge.
const ACROSS: f64 = 0.03;
/// Smallest depth of a notch in a border, as a share of its width: less is curvature of the border itself.
const DEPTH: f64 = 0.02;
/// Largest extent of a hole as a share of the blade's, along and across: the border of a blade that is open
/// at an end is longer.
const HOLE: f64 = 0.5;
/// Smallest width of a hole, as a share of its length.
const WIDTH: f64 = 1e-6;

/// A border loop inside a blade's surface.
#[derive(Clone, Copy, Debug)]
pub struct Hole {
    /// Its middle.
    pub middle: Point,
    /// Its extent, mm.
    pub size: f64,
}

/// Candidate ear: two border edges, `from` → `at` → `to`. Ordered by the length of the edge that would close
/// it.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct EarCandidate {
    /// Squared length of the third edge as bits, which sort like the value because it is not negative.
    across: u64,
    from: u32,
    at: u32,
    to: u32,
}

/// The border edges that remain while holes are filled.
struct HoleBorders<'a> {
    points: &'a [Point],
    /// Edges in the direction of their triangles, by start and by end, with the triangle's normal.
    onwards: BTreeMap<u32, Vec<(u32, Vector)>>,
    backwards: BTreeMap<u32, Vec<u32>>,
    /// Edges between corners of borders that two triangles share.
    inner: BTreeSet<(u32, u32)>,
    corners: BinaryHeap<Reverse<EarCandidate>>,
}

fn undirected(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl<'a> HoleBorders<'a> {
    fn from_surface(surface: &'a MeshSurface) -> Self {
        let edges = single_borders(surface);
        let mut at_border = vec![false; surface.points.len()];
        edges.keys().for_each(|&(a, b)| (at_border[a as usize], at_border[b as usize]) = (true, true));
        let mut inner = BTreeSet::new();
        for t in &surface.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                if at_border[a as usize] && at_border[b as usize] && !edges.contains_key(&(a, b)) {
                    inner.insert(undirected(a, b));
                }
            }
        }
        let mut borders = Self {
            points: &surface.points,
            onwards: BTreeMap::new(),
            backwards: BTreeMap::new(),
            inner,
            corners: BinaryHeap::new(),
        };
        for (&(a, b), &t) in &edges {
            borders.add(a, b, surface.normals[t]);
        }
        borders
    }

    fn add(&mut self, a: u32, b: u32, normal: Vector) {
        let corner = |from: u32, at: u32, to: u32| {
            let across = (self.points[to as usize] - self.points[from as usize]).norm_squared().to_bits();
            Reverse(EarCandidate { across, from, at, to })
        };
        let before = self.backwards.get(&a).into_iter().flatten().map(|&from| corner(from, a, b));
        let behind = self.onwards.get(&b).into_iter().flatten().map(|&(to, _)| corner(a, b, to));
        let found: Vec<_> = before.chain(behind).collect();
        self.corners.extend(found);
        self.onwards.entry(a).or_default().push((b, normal));
        self.backwards.entry(b).or_default().push(a);
    }

    fn normal(&self, a: u32, b: u32) -> Option<Vector> {
        self.onwards.get(&a)?.iter().find(|(to, _)| *to == b).map(|(_, normal)| *normal)
    }

    fn remove(&mut self, a: u32, b: u32) {
        self.onwards.entry(a).or_default().retain(|(to, _)| *to != b);
        self.backwards.entry(b).or_default().retain(|from| *from != a);
        self.inner.insert(undirected(a, b));
    }

    /// Triangles that fill holes and notches no wider than `limit`, mm: greedy ear clipping, shortest third
    /// edge first (priority queue).
    fn fill(&mut self, limit: f64) -> Vec<[u32; 3]> {
        let mut filled = Vec::new();
        while let Some(Reverse(EarCandidate { from, at, to, .. })) = self.corners.pop() {
            let (Some(before), Some(behind)) = (self.normal(from, at), self.normal(at, to)) else { continue };
            let [a, b, c] = [from, at, to].map(|i| self.points[i as usize]);
            let area = (b - c).cross(&(a - c));
            let Some(normal) = area.try_normalize(1e-300) else { continue };
            let last = self.normal(to, from);
            let fits = match last {
                // The last three edges of a hole; the border of an isolated triangle is excluded.
                Some(last) => [before, behind, last].iter().any(|n| (n + normal).norm() > 1e-9),
                None => {
                    let width = (a - c).norm();
                    width <= limit
                        && area.norm() > DEPTH * width * width
                        && before.dot(&normal) > SHARP
                        && behind.dot(&normal) > SHARP
                        && !self.inner.contains(&undirected(from, to))
                }
            };
            if fits {
                filled.push([to, at, from]);
                self.remove(from, at);
                self.remove(at, to);
                match last {
                    Some(_) => self.remove(to, from),
                    None => self.add(from, to, normal),
                }
            }
        }
        filled
    }
}

/// Edges of exactly one triangle, in its direction, and that triangle.
fn single_borders(surface: &MeshSurface) -> BTreeMap<(u32, u32), usize> {
    let mut edges = BTreeMap::new();
    let mut counts: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (edge, t) in surface.border_edges() {
        *counts.entry(undirected(edge.0, edge.1)).or_default() += 1;
        edges.insert(edge, t);
    }
    edges.retain(|(a, b), _| counts[&undirected(*a, *b)] == 1);
    edges
}

/// Fills the small holes and notches of a blade's surface.
pub fn fill_holes(surface: MeshSurface) -> MeshSurface {
    let far = |p: &Point| (p - surface.points[0]).norm();
    let extent = surface.points.iter().map(far).fold(0.0, f64::max);
    let filling = HoleBorders::from_surface(&surface).fill(ACROSS * extent);
    if filling.is_empty() { surface } else { surface.with_triangles(filling) }
}

/// The largest remaining hole of a blade that reaches into the `heights` at which it is sliced; `places`
/// gives (along, height) of its corners. Where a coarse foot dips into the hub here and there, cutting it off
/// leaves small borders, all of them at the hub.
pub fn largest_hole(
    surface: &MeshSurface,
    places: &[(f64, f64)],
    heights: RangeInclusive<f64>,
) -> Option<Hole> {
    let spans = |corners: &mut dyn Iterator<Item = usize>| {
        let start = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let spans = corners.fold(start, |[s, h], i| {
            let (x, y) = places[i];
            [(s.0.min(x), s.1.max(x)), (h.0.min(y), h.1.max(y))]
        });
        spans.map(|(low, high)| high - low)
    };
    let whole = spans(&mut (0..places.len()));
    let holes = loops(surface).into_iter().filter(|corners| {
        let own = spans(&mut corners.iter().map(|i| *i as usize));
        let is_sliced = corners.iter().any(|i| heights.contains(&places[*i as usize].1));
        is_sliced && own[0] < HOLE * whole[0] && own[1] < HOLE * whole[1]
    });
    // Collinear corners of a triangle that is left out for that leave a border of no width.
    let has_width = |corners: &Vec<u32>| {
        let at = |i: usize| surface.points[corners[i % corners.len()] as usize];
        let area = (1..corners.len()).map(|i| (at(i) - at(0)).cross(&(at(i + 1) - at(0)))).sum::<Vector>();
        let reach = (1..corners.len()).map(|i| (at(i) - at(0)).norm_squared()).fold(0.0, f64::max);
        area.norm() > WIDTH * reach
    };
    let measured = holes.filter(has_width).map(|corners| {
        let sum: Vector = corners.iter().map(|i| surface.points[*i as usize].coords).sum();
        let middle = Point::from(sum / corners.len() as f64);
        let far = |i: &u32| (surface.points[*i as usize] - middle).norm();
        Hole { middle, size: 2.0 * corners.iter().map(far).fold(0.0, f64::max) }
    });
    measured.max_by(|a, b| a.size.total_cmp(&b.size))
}

/// The borders as loops; a border that touches itself at a corner is split there.
fn loops(surface: &MeshSurface) -> Vec<Vec<u32>> {
    let mut onwards: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (a, b) in single_borders(surface).into_keys() {
        onwards.entry(a).or_default().push(b);
    }
    let mut loops = Vec::new();
    while let Some((&start, _)) = onwards.first_key_value() {
        let mut path = vec![start];
        let mut place = BTreeMap::from([(start, 0)]);
        while let Some(&at) = path.last() {
            let Some(to) = onwards.get_mut(&at).and_then(Vec::pop) else { break };
            if let Some(&from) = place.get(&to) {
                let found = path.split_off(from);
                place.retain(|i, _| !found.contains(i));
                // The rest of the path continues from the corner that closed the loop.
                place.insert(to, path.len());
                path.push(to);
                loops.push(found);
            } else {
                place.insert(to, path.len());
                path.push(to);
            }
        }
        onwards.retain(|_, to| !to.is_empty());
    }
    loops
}
