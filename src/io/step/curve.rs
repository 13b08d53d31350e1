//! Curves of edges and of swept surfaces.

use std::f64::consts::TAU;

use super::model::Frame;
use super::nurbs::NurbsCurve;
use crate::geometry::search::GOLDEN;
use crate::geometry::{Point, Vector};

/// A curve over a parameter.
#[derive(Clone, Debug)]
pub enum Curve {
    /// A line from a point; the parameter counts lengths of the vector.
    Line(Point, Vector),
    /// Ellipse with the half axes along x and y of its frame; the parameter is the eccentric anomaly, rad.
    Ellipse(Frame, f64, f64),
    /// Hyperbola, with its parameter in the frame: (a cosh t, b sinh t).
    Hyperbola(Frame, f64, f64),
    /// Parabola of a focal distance: (f t², 2 f t).
    Parabola(Frame, f64),
    /// B-spline.
    Nurbs(NurbsCurve),
    /// Chords through points; the parameter counts them.
    Polyline(Vec<Point>),
    /// The part of a curve between two parameters, and whether it runs as the curve does.
    Trimmed(Box<Self>, (f64, f64)),
    /// Pieces one after the other; each takes one unit of the parameter.
    Composite(Vec<Self>),
}

impl Curve {
    /// The point at a parameter.
    pub fn at(&self, t: f64) -> Point {
        match self {
            Self::Line(p, d) => p + d * t,
            Self::Ellipse(f, a, b) => f.world(Vector::new(a * t.cos(), b * t.sin(), 0.0)),
            Self::Hyperbola(f, a, b) => f.world(Vector::new(a * t.cosh(), b * t.sinh(), 0.0)),
            Self::Parabola(f, d) => f.world(Vector::new(d * t * t, 2.0 * d * t, 0.0)),
            Self::Nurbs(n) => n.at(t),
            Self::Polyline(points) => {
                let k = (t.max(0.0) as usize).min(points.len() - 2);
                points[k] + (points[k + 1] - points[k]) * (t - k as f64)
            }
            Self::Trimmed(curve, (a, b)) => {
                curve.at(if curve.is_periodic() { t } else { t.clamp(a.min(*b), a.max(*b)) })
            }
            Self::Composite(pieces) => {
                let k = (t.max(0.0) as usize).min(pieces.len() - 1);
                let (a, b) = pieces[k].span();
                pieces[k].at(a + (b - a) * (t - k as f64).clamp(0.0, 1.0))
            }
        }
    }

    fn is_periodic(&self) -> bool {
        matches!(self, Self::Ellipse(..))
    }

    /// The range of the parameter; that of a line is ± 1,000 mm or a little more.
    pub fn span(&self) -> (f64, f64) {
        match self {
            Self::Line(_, d) => (-1e3 / d.norm(), 1e3 / d.norm()),
            Self::Ellipse(..) => (0.0, TAU),
            Self::Hyperbola(..) => (-6.0, 6.0),
            Self::Parabola(_, d) => (-1e3 / d.abs().max(1.0), 1e3 / d.abs().max(1.0)),
            Self::Nurbs(n) => n.knots.domain(),
            Self::Polyline(points) => (0.0, (points.len() - 1) as f64),
            Self::Trimmed(_, span) => *span,
            Self::Composite(pieces) => (0.0, pieces.len() as f64),
        }
    }

    /// Parameters at which it may bend, within its range, ends included.
    pub fn breaks(&self) -> Vec<f64> {
        let (a, b) = self.span();
        let inside = |t: &f64| *t > a.min(b) && *t < a.max(b);
        let mut breaks = vec![a.min(b)];
        match self {
            Self::Nurbs(n) => breaks.extend(n.knots.breaks().into_iter().filter(inside)),
            Self::Trimmed(curve, _) => breaks.extend(curve.breaks().into_iter().filter(inside)),
            Self::Polyline(_) | Self::Composite(_) => {
                breaks.extend((1..b as usize).map(|k| k as f64));
            }
            _ => {}
        }
        breaks.push(a.max(b));
        breaks
    }

    /// Whether it is straight.
    pub fn is_straight(&self) -> bool {
        match self {
            Self::Line(..) => true,
            Self::Trimmed(curve, _) => curve.is_straight(),
            _ => false,
        }
    }

    /// Whether its ends meet.
    pub fn is_closed(&self) -> bool {
        let (a, b) = self.span();
        !self.is_straight() && (self.at(a) - self.at(b)).norm() < 1e-5
    }

    /// Eccentric anomaly of a point, for an ellipse.
    pub fn anomaly(&self, p: &Point) -> Option<f64> {
        match self {
            Self::Ellipse(f, a, b) => {
                let q = f.local(p);
                Some((q.y / b).atan2(q.x / a))
            }
            Self::Trimmed(curve, _) => curve.anomaly(p),
            _ => None,
        }
    }

    /// Parameter within the range at which `distance` is least: a scan, then a golden-section search.
    pub fn least(&self, distance: impl Fn(&Point) -> f64) -> f64 {
        let mut places = self.breaks();
        let per_span = (64 / places.len()).max(4);
        let fine: Vec<f64> = places
            .windows(2)
            .flat_map(|w| (0..per_span).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / per_span as f64))
            .chain(places.last().copied())
            .collect();
        places = fine;
        let far: Vec<f64> = places.iter().map(|t| distance(&self.at(*t))).collect();
        let Some(k) = (0..far.len()).min_by(|a, b| far[*a].total_cmp(&far[*b])) else { return 0.0 };
        let (low, high) = (places[k.saturating_sub(1)], places[(k + 1).min(places.len() - 1)]);
        let (mut a, mut b) = (low, high);
        let at = |t: f64| distance(&self.at(t));
        let (mut c, mut d) = (a + GOLDEN * (b - a), b - GOLDEN * (b - a));
        let (mut fc, mut fd) = (at(c), at(d));
        for _ in 0..60 {
            if fc < fd {
                (b, d, fd) = (d, c, fc);
                c = a + GOLDEN * (b - a);
                fc = at(c);
            } else {
                (a, c, fc) = (c, d, fd);
                d = b - GOLDEN * (b - a);
                fd = at(d);
            }
        }
        let middle = 0.5 * (a + b);
        // The ends exactly, where they are as near.
        let ends = [low, high].into_iter().min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(middle);
        if at(ends) <= at(middle) + 1e-12 { ends } else { middle }
    }

    /// Parameter of the point nearest to `p`.
    pub fn nearest(&self, p: &Point) -> f64 {
        match self {
            Self::Line(o, d) => (p - o).dot(d) / d.norm_squared(),
            Self::Parabola(f, d) if *d != 0.0 => f.local(p).y / (2.0 * d),
            Self::Hyperbola(f, _, b) if *b != 0.0 => (f.local(p).y / b).asinh(),
            _ => self.least(|q| (q - p).norm()),
        }
    }
}
