//! Surfaces of faces: evaluation, inversion, periods and poles.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::curve::Curve;
use super::model::Frame;
use super::nurbs::NurbsSurface;
use crate::geometry::{Point, Vector};

/// Points nearer to an axis than this are on it, mm.
pub const ON_AXIS: f64 = 1e-6;
/// Samples of the profile of a surface of revolution between two of its breaks.
const PROFILE_SAMPLES: usize = 16;

/// Where `f` is least between two arguments, by golden-section search.
fn golden_minimum(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const STEPS: usize = 60;
    for _ in 0..STEPS {
        let (c, d) = (a + 0.381_966 * (b - a), b - 0.381_966 * (b - a));
        if f(c) < f(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}

/// A surface over two parameters.
#[derive(Clone, Debug)]
pub enum Surface {
    /// The x-y plane of a frame.
    Plane(Frame),
    /// A cone about z: radius at z = 0, and its growth per mm of z; 0 for a cylinder. Parameters: angle, z.
    Cone(Frame, f64, f64),
    /// A sphere. Parameters: angle about z, latitude.
    Sphere(Frame, f64),
    /// A torus about z: major and minor radius. Parameters: angle about z, angle round the tube.
    Torus(Frame, f64, f64),
    /// A curve turned about z of a frame. Parameters: angle, that of the curve.
    Revolved(Box<Revolved>),
    /// A curve moved along a vector. Parameters: that of the curve, lengths of the vector.
    Extruded(Curve, Vector),
    /// A B-spline surface.
    Nurbs(Box<NurbsSurface>),
    /// A surface at a distance from another, along its normal.
    Offset(Box<Self>, f64),
}

/// A surface of revolution.
#[derive(Clone, Debug)]
pub struct Revolved {
    frame: Frame,
    curve: Curve,
    /// (parameter, radius, height) along the curve.
    profile: Vec<(f64, f64, f64)>,
}

impl Revolved {
    /// The surface of a curve turned about z of `frame`.
    pub fn new(frame: Frame, curve: Curve) -> Self {
        let breaks = curve.breaks();
        let per_span = (512 / breaks.len()).clamp(2, PROFILE_SAMPLES);
        let places = breaks
            .windows(2)
            .flat_map(|w| (0..per_span).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / per_span as f64))
            .chain(breaks.last().copied());
        let profile = places
            .map(|t| {
                let q = frame.local(&curve.at(t));
                (t, q.x.hypot(q.y), q.z)
            })
            .collect();
        Self { frame, curve, profile }
    }

    /// Parameters of the profile between its ends at which it is nearest to the axis: a whole circle may meet
    /// it there.
    fn nearest_to_axis(&self) -> Vec<f64> {
        let radius = |t: f64| {
            let q = self.frame.local(&self.curve.at(t));
            q.x.hypot(q.y)
        };
        let is_least = |w: &&[(f64, f64, f64)]| w[1].1 <= w[0].1 && w[1].1 < w[2].1;
        let least = self.profile.windows(3).filter(is_least);
        let refined = |w: &[(f64, f64, f64)]| golden_minimum(radius, w[0].0, w[2].0);
        least.map(refined).collect()
    }

    fn nearest(&self, p: &Point) -> [f64; 2] {
        let q = self.frame.local(p);
        let (r, h) = (q.x.hypot(q.y), q.z);
        let off = |s: &(f64, f64, f64)| (s.1 - r).hypot(s.2 - h);
        let far = |t: f64| {
            let y = self.frame.local(&self.curve.at(t));
            (y.x.hypot(y.y) - r).hypot(y.z - h)
        };
        let t = if let Curve::Line(o, d) = &self.curve {
            // The profile of a line that meets the axis is straight, too; that of others is searched.
            let (a, b) = (self.frame.local(o), self.frame.local(&(o + d)));
            let straight = (a.x * b.y - a.y * b.x).abs() < 1e-9 * (1.0 + a.norm() * b.norm());
            let (dr, dh) = (b.x.hypot(b.y) - a.x.hypot(a.y), b.z - a.z);
            let same_side = a.x * b.x + a.y * b.y >= 0.0;
            (straight && same_side)
                .then(|| ((r - a.x.hypot(a.y)) * dr + (h - a.z) * dh) / (dr * dr + dh * dh).max(1e-300))
        } else {
            None
        };
        let t = t.unwrap_or_else(|| {
            let k = (0..self.profile.len())
                .min_by(|a, b| off(&self.profile[*a]).total_cmp(&off(&self.profile[*b])))
                .unwrap_or(0);
            let last = self.profile.len() - 1;
            let (a, b) = (self.profile[k.saturating_sub(1)].0, self.profile[(k + 1).min(last)].0);
            let ends = [a, b, self.profile[k].0];
            let middle = golden_minimum(far, a, b);
            let end = ends.into_iter().min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(middle);
            if far(end) <= far(middle) + 1e-12 { end } else { middle }
        });
        let y = self.frame.local(&self.curve.at(t));
        [q.y.atan2(q.x) - y.y.atan2(y.x), t]
    }
}

/// A parameter value at which the surface is a single point, whatever the other parameter.
#[derive(Clone, Copy, Debug)]
pub struct Pole {
    /// The parameter that has no meaning there.
    pub loose: usize,
    /// The value of the other.
    pub value: f64,
    /// The point.
    pub point: Point,
}

impl Surface {
    /// The point at parameters; those of closed B-splines may be beyond their ranges.
    pub fn at(&self, q: [f64; 2]) -> Point {
        let [u, v] = q;
        match self {
            Self::Plane(f) => f.world(Vector::new(u, v, 0.0)),
            Self::Cone(f, r, k) => {
                let r = r + v * k;
                f.world(Vector::new(r * u.cos(), r * u.sin(), v))
            }
            Self::Sphere(f, r) => f.world(Vector::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin()) * *r),
            Self::Torus(f, major, minor) => {
                let r = major + minor * v.cos();
                f.world(Vector::new(r * u.cos(), r * u.sin(), minor * v.sin()))
            }
            Self::Revolved(s) => {
                let q = s.frame.local(&s.curve.at(v));
                let (sin, cos) = u.sin_cos();
                s.frame.world(Vector::new(q.x * cos - q.y * sin, q.x * sin + q.y * cos, q.z))
            }
            Self::Extruded(c, d) => {
                let (a, b) = c.span();
                let u = if c.is_closed() { a + (u - a).rem_euclid(b - a) } else { u };
                c.at(u) + d * v
            }
            Self::Nurbs(n) => n.at(n.within(q)),
            Self::Offset(s, d) => s.at(q) + s.normal(q) * *d,
        }
    }

    /// The unit normal, du × dv; by differences where there is no closed form.
    pub fn normal(&self, q: [f64; 2]) -> Vector {
        let (du, dv) = match self {
            Self::Plane(f) => return f.axes[2],
            Self::Nurbs(n) => {
                let (_, a, b) = n.derivatives(n.within(q));
                (a, b)
            }
            _ => {
                let slope = |i: usize| {
                    let (mut a, mut b) = (q, q);
                    let h = 1e-5;
                    (a[i], b[i]) = (q[i] - h, q[i] + h);
                    (self.at(b) - self.at(a)) / (2.0 * h)
                };
                (slope(0), slope(1))
            }
        };
        du.cross(&dv).try_normalize(1e-300).unwrap_or_else(Vector::z)
    }

    /// Periods of the parameters.
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Self::Plane(_) => [None; 2],
            Self::Cone(..) | Self::Sphere(..) => [Some(TAU), None],
            Self::Revolved(s) => {
                let (a, b) = s.curve.span();
                [Some(TAU), s.curve.is_closed().then_some(b - a)]
            }
            Self::Torus(..) => [Some(TAU); 2],
            Self::Extruded(c, _) => {
                let (a, b) = c.span();
                [c.is_closed().then_some(b - a), None]
            }
            Self::Nurbs(n) => std::array::from_fn(|i| n.closed(i).then(|| n.domain(i).1 - n.domain(i).0)),
            Self::Offset(s, _) => s.periods(),
        }
    }

    /// Parameters of the point of the surface nearest to `p`; `hint` are those of a point near it.
    pub fn nearest(&self, p: &Point, hint: Option<[f64; 2]>) -> [f64; 2] {
        match self {
            Self::Plane(f) => {
                let q = f.local(p);
                [q.x, q.y]
            }
            Self::Cone(f, r, k) => {
                let q = f.local(p);
                // Beyond its apex a cone's angle is turned by half a circle.
                let sign = if r + q.z * k < 0.0 { -1.0 } else { 1.0 };
                [(sign * q.y).atan2(sign * q.x), q.z]
            }
            Self::Sphere(f, _) => {
                let q = f.local(p);
                [q.y.atan2(q.x), q.z.atan2(q.x.hypot(q.y))]
            }
            Self::Torus(f, major, _) => {
                let q = f.local(p);
                [q.y.atan2(q.x), q.z.atan2(q.x.hypot(q.y) - major)]
            }
            Self::Revolved(s) => s.nearest(p),
            Self::Extruded(c, d) => {
                let e = d.normalize();
                let across = |x: &Point| {
                    let w = p - x;
                    (w - e * w.dot(&e)).norm()
                };
                let u = match c {
                    Curve::Line(o, l) => {
                        let (w, l) = (p - o, l - e * l.dot(&e));
                        w.dot(&l) / l.norm_squared().max(1e-300)
                    }
                    _ => c.least(across),
                };
                [u, (p - c.at(u)).dot(&e) / d.norm()]
            }
            Self::Nurbs(n) => n.nearest(p, hint),
            Self::Offset(s, d) => {
                let mut q = s.nearest(p, hint);
                for _ in 0..8 {
                    q = s.nearest(&(p - s.normal(q) * *d), Some(q));
                }
                q
            }
        }
    }

    /// Its poles.
    pub fn poles(&self) -> Vec<Pole> {
        match self {
            Self::Cone(f, r, k) if *k != 0.0 => {
                let value = -r / k;
                vec![Pole { loose: 0, value, point: f.world(Vector::new(0.0, 0.0, value)) }]
            }
            Self::Sphere(f, r) => [-1.0, 1.0]
                .map(|s| Pole {
                    loose: 0,
                    value: s * FRAC_PI_2,
                    point: f.world(Vector::new(0.0, 0.0, s * r)),
                })
                .to_vec(),
            Self::Revolved(s) => {
                let (a, b) = s.curve.span();
                let places = [a, b].into_iter().chain(s.nearest_to_axis());
                let places = places.map(|value| Pole { loose: 0, value, point: s.curve.at(value) });
                let on_axis = |p: &Pole| {
                    let q = s.frame.local(&p.point);
                    q.x.hypot(q.y) < ON_AXIS
                };
                places.filter(on_axis).collect()
            }
            Self::Nurbs(n) => {
                let mut poles = Vec::new();
                for loose in 0..2 {
                    let ((low, high), ends) = (n.domain(loose), n.domain(1 - loose));
                    for value in [ends.0, ends.1] {
                        let at = |share: f64| {
                            let t = low + (high - low) * share;
                            n.at(if loose == 0 { [t, value] } else { [value, t] })
                        };
                        let point = at(0.0);
                        if [0.25, 0.5, 0.75, 1.0].iter().all(|s| (at(*s) - point).norm() < ON_AXIS) {
                            poles.push(Pole { loose, value, point });
                        }
                    }
                }
                poles
            }
            _ => Vec::new(),
        }
    }

    /// Parameters at which pieces meet, within the range `low` to `high` of parameter `i`, ends included.
    pub fn breaks(&self, i: usize, low: f64, high: f64) -> Vec<f64> {
        let own = match self {
            Self::Nurbs(n) => n.breaks(i),
            Self::Revolved(s) if i == 1 => s.curve.breaks(),
            Self::Extruded(c, _) if i == 0 => c.breaks(),
            Self::Offset(s, _) => return s.breaks(i, low, high),
            _ => Vec::new(),
        };
        let period = self.periods()[i];
        let mut breaks = vec![low, high];
        for turn in [-2.0, -1.0, 0.0, 1.0, 2.0] {
            if let Some(shift) = period.map(|w| w * turn).or((turn == 0.0).then_some(0.0)) {
                breaks.extend(own.iter().map(|b| b + shift).filter(|b| *b > low && *b < high));
            }
        }
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * (high - low));
        breaks
    }

    /// Whether it is straight along a parameter; a B-spline only if it is developable: a twisted ruled one is
    /// not.
    pub fn is_straight(&self, i: usize) -> bool {
        match self {
            Self::Plane(_) => true,
            Self::Cone(..) => i == 1,
            Self::Extruded(c, _) => i == 1 || c.is_straight(),
            Self::Revolved(s) => i == 1 && s.curve.is_straight(),
            Self::Nurbs(n) => n.is_developable(i),
            _ => false,
        }
    }

    /// The axis of a surface of revolution: a point and the direction.
    pub fn axis(&self) -> Option<(Point, Vector)> {
        match self {
            Self::Cone(f, ..) | Self::Torus(f, ..) => Some((f.origin, f.axes[2])),
            Self::Revolved(s) => Some((s.frame.origin, s.frame.axes[2])),
            Self::Offset(s, _) => s.axis(),
            _ => None,
        }
    }

    /// A sphere turned so that its pole is in the middle of a loop of points; others as they are.
    pub fn facing(&mut self, ring: &[Point]) {
        if let Self::Sphere(f, _) = self {
            let next = ring.iter().cycle().skip(1);
            let area: Vector =
                ring.iter().zip(next).map(|(a, b)| (a - f.origin).cross(&(b - f.origin))).sum();
            if let Some(z) = area.try_normalize(1e-12) {
                *f = Frame::new(f.origin, z, f.axes[0]);
            }
        }
    }

    /// The whole range of parameters of a surface without borders, if it is closed.
    pub fn closed_range(&self) -> Option<[(f64, f64); 2]> {
        match self {
            Self::Sphere(..) => Some([(-PI, PI), (-FRAC_PI_2, FRAC_PI_2)]),
            Self::Torus(..) => Some([(-PI, PI); 2]),
            Self::Revolved(s) => Some([(-PI, PI), s.curve.span()]),
            Self::Nurbs(n) => Some([n.domain(0), n.domain(1)]),
            _ => None,
        }
    }
}
