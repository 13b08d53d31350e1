//! A turned blank: a closed outline in the meridional plane, revolved about Z.

use super::lattice::Lattice;
use super::rays::RayField;
use super::span::{Span, SpanEnd};
use crate::geometry::{Meridional, Point, Vector};
use crate::part::body::body_outline;
use crate::part::{Blank, Impeller};

/// Chords of each curve of an outline: those of a wheel of 500 mm are within 1 µm of it.
const CHORDS: u32 = 2000;
/// Bins of edges along each coordinate.
const BINS: usize = 2048;

/// A closed outline (r, z), r ≥ 0, to be revolved about Z.
#[derive(Clone, Debug)]
pub struct TurnedOutline {
    points: Vec<Meridional>,
    /// +1 where the points run counter-clockwise in the plane (r, z), else −1.
    sense: f64,
}

/// Edges of an outline that may cross a line of constant r or z, by bins.
struct EdgeBins {
    from: f64,
    width: f64,
    bins: Vec<Vec<u32>>,
}

impl EdgeBins {
    fn new(points: &[Meridional], of: impl Fn(&Meridional) -> f64) -> Self {
        let (from, to) = points
            .iter()
            .map(&of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let width = ((to - from) / BINS as f64).max(1e-12);
        let mut bins = vec![Vec::new(); BINS];
        let bin = |x: f64| (((x - from) / width) as usize).min(BINS - 1);
        for (index, p) in (0u32..).zip(points) {
            let (a, b) = (bin(of(p)), bin(of(&points[(index as usize + 1) % points.len()])));
            bins[a.min(b)..=a.max(b)].iter_mut().for_each(|edges| edges.push(index));
        }
        Self { from, width, bins }
    }

    fn at(&self, x: f64) -> &[u32] {
        let bin = (x - self.from) / self.width;
        if bin < 0.0 {
            return &[];
        }
        self.bins.get(bin as usize).map_or(&[], Vec::as_slice)
    }
}

impl TurnedOutline {
    /// The outline through `points`, closed from the last to the first. Radii below 0 count as 0.
    pub fn new(points: Vec<Meridional>) -> Self {
        let points: Vec<Meridional> =
            points.into_iter().map(|p| Meridional { r: p.r.max(0.0), z: p.z }).collect();
        let edges = points.iter().zip(points.iter().cycle().skip(1));
        let sense = edges.map(|(a, b)| a.r * b.z - b.r * a.z).sum::<f64>().signum();
        Self { points, sense }
    }

    /// The outline of a blank; of one that encloses the edges of the blades with the body of the hub inside
    /// and behind it.
    pub fn of_blank(part: &Impeller, blank: &Blank) -> Self {
        if let Some(outline) = blank.outline() {
            return Self::new(outline.points().to_vec());
        }
        let along = |curve: &crate::geometry::MeridionalCurve, i: u32| {
            curve.point(curve.length() * f64::from(i) / f64::from(CHORDS))
        };
        let mut points: Vec<Meridional> = (0..=CHORDS).map(|i| along(&blank.shroud, i)).collect();
        let body = body_outline(part);
        // Rim of the hub, back and bore; then the nose of the hub up to the leading edge.
        points.extend(&body);
        let (from, to) = (part.hub.wheel_from(), part.hub.s_at(part.hub.arc_at(0.0)));
        let start = part.hub.curve().project(blank.hub.point(0.0)).0;
        let (from, to) = (part.hub.arc_at(from), start.min(part.hub.arc_at(to)));
        if from < to {
            let at = |i: u32| part.hub.curve().point(from + (to - from) * f64::from(i) / 200.0);
            points.extend((1..200).map(at));
        }
        points.push(blank.hub.point(0.0));
        points.dedup_by(|a, b| a.distance(*b) < 1e-9);
        Self::new(points)
    }

    /// The outline with all coordinates times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let points = self.points.iter().map(|p| Meridional { r: factor * p.r, z: factor * p.z });
        Self::new(points.collect())
    }

    /// Lower and upper corner of the box around it, mm.
    pub fn bounds(&self) -> (Point, Point) {
        let r = self.points.iter().map(|p| p.r).fold(0.0, f64::max);
        let z = self.points.iter().map(|p| p.z);
        let (low, high) = (z.clone().fold(f64::INFINITY, f64::min), z.fold(f64::NEG_INFINITY, f64::max));
        (Point::new(-r, -r, low), Point::new(r, r, high))
    }

    /// Volume by Pappus' theorem, mm³.
    pub fn volume(&self) -> f64 {
        let edges = self.points.iter().zip(self.points.iter().cycle().skip(1));
        // ∮ π r² dz over conical frusta.
        let sum: f64 = edges.map(|(a, b)| (b.z - a.z) * (a.r * a.r + a.r * b.r + b.r * b.r)).sum();
        (std::f64::consts::PI / 3.0 * sum).abs()
    }

    /// Crossings of the outline with a line of constant z: radii with the outward normal (r, z), sorted.
    fn crossings(
        &self,
        edges: &[u32],
        at: f64,
        of: impl Fn(&Meridional) -> (f64, f64),
        into: &mut Vec<(f64, Meridional)>,
    ) {
        into.clear();
        let sense = self.sense;
        for &index in edges {
            let (a, b) =
                (&self.points[index as usize], &self.points[(index as usize + 1) % self.points.len()]);
            let ((p, x), (q, y)) = (of(a), of(b));
            // Half-open, so that a common corner of two edges counts once.
            if (p <= at) != (q <= at) {
                let normal = Meridional { r: sense * (b.z - a.z), z: sense * (a.r - b.r) };
                into.push((x + (y - x) * (at - p) / (q - p), normal));
            }
        }
        into.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// The rays of `lattice` in it.
    pub fn rays(&self, lattice: &Lattice) -> [RayField; 3] {
        let by_r = EdgeBins::new(&self.points, |p| p.r);
        let by_z = EdgeBins::new(&self.points, |p| p.z);
        // Crossings with every plane of the lattice across Z.
        let planes: Vec<Vec<(f64, Meridional)>> = (0..lattice.counts[2])
            .map(|k| {
                let z = lattice.coordinate(2, k);
                let mut found = Vec::new();
                self.crossings(by_z.at(z), z, |p| (p.z, p.r), &mut found);
                found
            })
            .collect();
        let end = |normal: &Meridional, x: f64, y: f64| {
            let r = x.hypot(y).max(1e-12);
            let normal = Vector::new(normal.r * x / r, normal.r * y / r, normal.z);
            SpanEnd::new(&normal.try_normalize(1e-300).unwrap_or_else(Vector::z), SpanEnd::BLANK)
        };
        [0, 1, 2].map(|direction| {
            RayField::filled(lattice, direction, |u, v, spans| {
                let origin = lattice.ray(direction, u, v);
                if direction == 2 {
                    let r = origin.x.hypot(origin.y);
                    let mut found = Vec::new();
                    self.crossings(by_r.at(r), r, |p| (p.r, p.z), &mut found);
                    for pair in found.chunks_exact(2) {
                        let [start, stop] =
                            [&pair[0], &pair[1]].map(|(_, normal)| end(normal, origin.x, origin.y));
                        spans.push(Span { from: pair[0].0, to: pair[1].0, start, end: stop });
                    }
                    return;
                }
                // Across Z the outline is rings; each cuts the ray twice, or not at all.
                let (plane, aside) = if direction == 0 { (v, origin.y) } else { (u, origin.x) };
                let point = |t: f64| if direction == 0 { (t, aside) } else { (aside, t) };
                let reach = |r: f64| (r * r - aside * aside).max(0.0).sqrt();
                let mark = |normal: &Meridional, t: f64| {
                    let (x, y) = point(t);
                    end(normal, x, y)
                };
                let rings = planes[plane].chunks_exact(2).filter(|ring| ring[1].0 > aside.abs());
                for ring in rings {
                    let ((inner, n), (outer, m)) = (&ring[0], &ring[1]);
                    let (a, b) = (reach(*inner), reach(*outer));
                    if *inner <= aside.abs() {
                        spans.push(Span { from: -b, to: b, start: mark(m, -b), end: mark(m, b) });
                    } else {
                        spans.push(Span { from: -b, to: -a, start: mark(m, -b), end: mark(n, -a) });
                        spans.push(Span { from: a, to: b, start: mark(n, a), end: mark(m, b) });
                    }
                }
                spans.retain(|span| span.from < span.to);
                spans.sort_by(|a, b| a.from.total_cmp(&b.from));
            })
        })
    }
}
