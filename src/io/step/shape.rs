//! Curves and surfaces from instances.

use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use super::curve::Curve;
use super::exchange::{Instance, Value};
use super::model::{EntityArguments, EntityFault, EntityResult, MAX_CHAIN, Model, Units};
use super::nurbs::{Knots, MAX_DEGREE, NurbsCurve, NurbsSurface};
use super::surface::{Revolved, Surface};
use crate::geometry::Point;
use crate::io::source::{MAX_COORDINATE, quote_for_message};

/// Largest number of control points of a curve or surface.
const MAX_CONTROL: usize = 1_000_000;
/// Largest number of control points and of points of edges and faces of a file, which bounds time and memory.
pub const MAX_WORK: usize = 30_000_000;
/// Range of weights.
const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// The arguments of a B-spline in its simple or its complex form.
struct SplineArguments<'m, 'a> {
    own: EntityArguments<'m, 'a>,
    /// Index of the first argument of the B-spline in `own`.
    first: usize,
    knots: Option<(EntityArguments<'m, 'a>, usize)>,
    weights: Option<EntityArguments<'m, 'a>>,
    /// Whether knots are uniform, Bézier, or quasi-uniform, where there are none.
    kind: &'static str,
}

/// `what` is `B_SPLINE_CURVE` or `B_SPLINE_SURFACE`, with `count` arguments behind its name.
fn spline<'m, 'a>(instance: &'m Instance<'a>, what: &str, count: usize) -> Option<SplineArguments<'m, 'a>> {
    let id = instance.id;
    let record = |name: &str| instance.record(name).map(|values| EntityArguments::new(id, values));
    let weights = record(&format!("RATIONAL_{what}"));
    let with_knots = record(&format!("{what}_WITH_KNOTS"));
    let tail = what.strip_prefix("B_SPLINE_").unwrap_or_default();
    let kinds = [("BEZIER", "BEZIER_"), ("UNIFORM", "UNIFORM_"), ("QUASI", "QUASI_UNIFORM_")];
    let implied = kinds.iter().find_map(|(kind, prefix)| Some((*kind, record(&format!("{prefix}{tail}"))?)));
    if let Some(own) = record(what) {
        let knots = with_knots.map(|a| (a, 0));
        return Some(SplineArguments { own, first: 0, knots, weights, kind: implied.map_or("", |k| k.0) });
    }
    if let Some(own) = with_knots {
        return Some(SplineArguments { own, first: 1, knots: Some((own, 1 + count)), weights, kind: "" });
    }
    let (kind, own) = implied?;
    Some(SplineArguments { own, first: 1, knots: None, weights, kind })
}

impl SplineArguments<'_, '_> {
    /// Knots of parameter `which` of `of` (1 for a curve, 2 for a surface).
    fn knots(&self, which: usize, of: usize, degree: usize, count: usize) -> EntityResult<Knots> {
        let id = self.own.id;
        let fault = |what: String| EntityFault::new(id, what);
        let knots = match &self.knots {
            Some((a, at)) => {
                let multiplicities = a.numbers(at + which)?;
                let values = a.numbers(at + of + which)?;
                if multiplicities.len() != values.len() {
                    let (m, n) = (multiplicities.len(), values.len());
                    return Err(fault(format!("has {m} multiplicities for {n} knots")));
                }
                // Bounded before anything is allocated.
                if multiplicities.iter().any(|m| !(1.0..=MAX_DEGREE as f64 + 1.0).contains(m)) {
                    return Err(fault("has a knot of a wrong multiplicity".to_owned()));
                }
                let repeated = |(m, x): (&f64, &f64)| std::iter::repeat_n(*x, *m as usize);
                multiplicities.iter().zip(&values).flat_map(repeated).collect()
            }
            None => implied_knots(self.kind, degree, count),
        };
        Knots::new(degree, knots, count).map_err(fault)
    }
}

/// Knots of a B-spline whose kind says how they are spaced.
fn implied_knots(kind: &str, degree: usize, count: usize) -> Vec<f64> {
    let n = count + degree + 1;
    match kind {
        "BEZIER" => {
            let (degree, last) = (degree.max(1), count.saturating_sub(1) / degree.max(1));
            (0..n).map(|k| k.div_ceil(degree).saturating_sub(1).min(last) as f64).collect()
        }
        "QUASI" => {
            let last = count.saturating_sub(degree);
            (0..n).map(|k| k.saturating_sub(degree).min(last) as f64).collect()
        }
        _ => (0..n).map(|k| k as f64 - degree as f64).collect(),
    }
}

/// Builds the geometry of a representation in its units.
#[derive(Clone, Copy)]
pub struct ShapeReader<'m, 'a> {
    /// The file.
    pub model: &'m Model<'a>,
    /// Units of the representation.
    pub units: Units,
    /// What is left of the work allowed for a file.
    pub budget: &'m AtomicUsize,
}

impl ShapeReader<'_, '_> {
    /// Takes `work` (points to read or compute) from the budget.
    ///
    /// # Errors
    /// When nothing is left: instances refer to others so often that the file would take too long.
    pub fn spend(&self, id: u32, work: usize) -> EntityResult<()> {
        let left = self.budget.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(work));
        left.map(|_| ()).map_err(|_| EntityFault::new(id, format!("takes the file beyond {MAX_WORK} points")))
    }

    fn length(&self, a: &EntityArguments<'_, '_>, at: usize) -> EntityResult<f64> {
        let x = a.number(at)? * self.units.mm;
        let beyond = || EntityFault::new(a.id, format!("argument {} is a length of {x} mm", at + 1));
        if x.abs() <= MAX_COORDINATE { Ok(x) } else { Err(beyond()) }
    }

    fn radius(&self, a: &EntityArguments<'_, '_>, at: usize) -> EntityResult<f64> {
        let r = self.length(a, at)?;
        if r > 0.0 { Ok(r) } else { Err(EntityFault::new(a.id, format!("has a radius of {r} mm"))) }
    }

    fn weighted(&self, from: u32, point: &Value<'_>, weight: f64) -> EntityResult<[f64; 4]> {
        let id = point
            .reference()
            .ok_or_else(|| EntityFault::new(from, "has a control point that is not a CARTESIAN_POINT"))?;
        let p = self.model.point(from, id, self.units.mm)?;
        if !WEIGHTS.contains(&weight) {
            return Err(EntityFault::new(from, format!("has the weight {weight}")));
        }
        Ok([p.x * weight, p.y * weight, p.z * weight, weight])
    }

    /// The curve of instance `id`.
    ///
    /// # Errors
    /// When it is not a curve that is understood.
    pub fn curve(&self, from: u32, id: u32) -> EntityResult<Curve> {
        self.curve_within(from, id, 0)
    }

    fn curve_within(&self, from: u32, id: u32, depth: usize) -> EntityResult<Curve> {
        if depth > MAX_CHAIN {
            return Err(EntityFault::new(id, "is part of a chain of curves without end"));
        }
        let instance = self.model.instance(from, id)?;
        if let Some(a) = spline(instance, "B_SPLINE_CURVE", 5) {
            return self.spline_curve(&a);
        }
        let keyword = instance.keyword();
        let a = EntityArguments::new(id, instance.record(keyword).unwrap_or_default());
        let mm = self.units.mm;
        let frame = |at: usize| self.model.frame(id, a.reference(at)?, mm);
        Ok(match keyword {
            "LINE" => Curve::Line(
                self.model.point(id, a.reference(1)?, mm)?,
                self.model.vector(id, a.reference(2)?, mm)?,
            ),
            "CIRCLE" => {
                let r = self.radius(&a, 2)?;
                Curve::Ellipse(frame(1)?, r, r)
            }
            "ELLIPSE" => Curve::Ellipse(frame(1)?, self.radius(&a, 2)?, self.radius(&a, 3)?),
            "HYPERBOLA" => Curve::Hyperbola(frame(1)?, self.radius(&a, 2)?, self.radius(&a, 3)?),
            "PARABOLA" => Curve::Parabola(frame(1)?, self.radius(&a, 2)?),
            "POLYLINE" => {
                let points = a.references(1)?;
                if points.len() < 2 {
                    return Err(EntityFault::new(id, "has fewer than two points"));
                }
                let point = |p: &u32| self.model.point(id, *p, mm);
                Curve::Polyline(points.iter().map(point).collect::<EntityResult<Vec<Point>>>()?)
            }
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" | "BOUNDED_SURFACE_CURVE" => {
                self.curve_within(id, a.reference(1)?, depth + 1)?
            }
            "TRIMMED_CURVE" => self.trimmed(&a, depth)?,
            "COMPOSITE_CURVE" => {
                let mut pieces = Vec::new();
                for segment in a.references(1)? {
                    let s = self.model.expect(id, segment, &["COMPOSITE_CURVE_SEGMENT"])?;
                    let curve = self.curve_within(segment, s.reference(2)?, depth + 1)?;
                    let (low, high) = curve.span();
                    let span = if s.is_true(1)? { (low, high) } else { (high, low) };
                    pieces.push(Curve::Trimmed(Box::new(curve), span));
                }
                if pieces.is_empty() {
                    return Err(EntityFault::new(id, "has no segments"));
                }
                Curve::Composite(pieces)
            }
            other => {
                let what = format!("is a curve of the kind {}, which is not read", quote_for_message(other));
                return Err(EntityFault::new(id, what));
            }
        })
    }

    fn spline_curve(&self, a: &SplineArguments<'_, '_>) -> EntityResult<Curve> {
        let id = a.own.id;
        let degree = a.own.count(a.first, MAX_DEGREE)?;
        let points = a.own.list(a.first + 1)?;
        let weights = a.weights.map(|w| w.numbers(0)).transpose()?;
        if points.len() > MAX_CONTROL || weights.as_ref().is_some_and(|w| w.len() != points.len()) {
            return Err(EntityFault::new(id, "has a wrong number of control points or weights"));
        }
        self.spend(id, points.len())?;
        let weight = |k: usize| weights.as_ref().and_then(|w| w.get(k)).copied().unwrap_or(1.0);
        let control = points.iter().enumerate().map(|(k, p)| self.weighted(id, p, weight(k)));
        let control = control.collect::<EntityResult<Vec<_>>>()?;
        Ok(Curve::Nurbs(NurbsCurve { knots: a.knots(0, 1, degree, points.len())?, control }))
    }

    fn trimmed(&self, a: &EntityArguments<'_, '_>, depth: usize) -> EntityResult<Curve> {
        let curve = self.curve_within(a.id, a.reference(1)?, depth + 1)?;
        let (scale, offset) = match &curve {
            Curve::Ellipse(..) => (self.units.rad, 0.0),
            _ => (1.0, 0.0),
        };
        let end = |at: usize| -> EntityResult<f64> {
            let values = a.list(at)?;
            let parameter =
                values.iter().find_map(|v| if v.reference().is_none() { v.number() } else { None });
            if let Some(x) = parameter {
                return Ok(x * scale + offset);
            }
            let point = values.iter().find_map(Value::reference);
            let point = point.ok_or_else(|| EntityFault::new(a.id, "is trimmed at nothing"))?;
            let p = self.model.point(a.id, point, self.units.mm)?;
            Ok(curve.anomaly(&p).unwrap_or_else(|| curve.nearest(&p)))
        };
        let (mut from, mut to) = (end(2)?, end(3)?);
        if !a.is_true(4).unwrap_or(true) {
            std::mem::swap(&mut from, &mut to);
        }
        if matches!(curve, Curve::Ellipse(..)) {
            let turn = std::f64::consts::TAU;
            to = from + (to - from).rem_euclid(turn);
            to += if to - from < 1e-9 { turn } else { 0.0 };
        }
        if !(from.is_finite() && to.is_finite()) || from == to {
            return Err(EntityFault::new(a.id, "has no extent"));
        }
        Ok(Curve::Trimmed(Box::new(curve), (from.min(to), from.max(to))))
    }

    /// The surface of instance `id`.
    ///
    /// # Errors
    /// When it is not a surface that is understood.
    pub fn surface(&self, from: u32, id: u32) -> EntityResult<Surface> {
        self.surface_within(from, id, 0)
    }

    fn surface_within(&self, from: u32, id: u32, depth: usize) -> EntityResult<Surface> {
        if depth > MAX_CHAIN {
            return Err(EntityFault::new(id, "is part of a chain of surfaces without end"));
        }
        let instance = self.model.instance(from, id)?;
        if let Some(a) = spline(instance, "B_SPLINE_SURFACE", 7) {
            return self.spline_surface(&a);
        }
        let keyword = instance.keyword();
        let a = EntityArguments::new(id, instance.record(keyword).unwrap_or_default());
        let mm = self.units.mm;
        let frame = |at: usize| self.model.frame(id, a.reference(at)?, mm);
        Ok(match keyword {
            "PLANE" => Surface::Plane(frame(1)?),
            "CYLINDRICAL_SURFACE" => Surface::Cone(frame(1)?, self.radius(&a, 2)?, 0.0),
            "CONICAL_SURFACE" => {
                let growth = (a.number(3)? * self.units.rad).tan();
                if growth.is_nan() || growth.abs() >= 1e6 {
                    return Err(EntityFault::new(id, "has a half angle that is not one of a cone"));
                }
                Surface::Cone(frame(1)?, self.length(&a, 2)?, growth)
            }
            "SPHERICAL_SURFACE" => Surface::Sphere(frame(1)?, self.radius(&a, 2)?),
            "TOROIDAL_SURFACE" | "DEGENERATE_TOROIDAL_SURFACE" => {
                Surface::Torus(frame(1)?, self.length(&a, 2)?, self.radius(&a, 3)?)
            }
            "SURFACE_OF_REVOLUTION" => {
                let curve = self.curve(id, a.reference(1)?)?;
                Surface::Revolved(Box::new(Revolved::new(frame(2)?, curve)))
            }
            "SURFACE_OF_LINEAR_EXTRUSION" => {
                let direction = self.model.vector(id, a.reference(2)?, mm)?;
                Surface::Extruded(self.curve(id, a.reference(1)?)?, direction)
            }
            "OFFSET_SURFACE" => {
                let basis = self.surface_within(id, a.reference(1)?, depth + 1)?;
                Surface::Offset(Box::new(basis), self.length(&a, 2)?)
            }
            "RECTANGULAR_TRIMMED_SURFACE" | "CURVE_BOUNDED_SURFACE" => {
                self.surface_within(id, a.reference(1)?, depth + 1)?
            }
            other => {
                let what =
                    format!("is a surface of the kind {}, which is not read", quote_for_message(other));
                return Err(EntityFault::new(id, what));
            }
        })
    }

    fn spline_surface(&self, a: &SplineArguments<'_, '_>) -> EntityResult<Surface> {
        let id = a.own.id;
        let wrong = || EntityFault::new(id, "has a net of control points or weights of a wrong size");
        let degrees = [a.own.count(a.first, MAX_DEGREE)?, a.own.count(a.first + 1, MAX_DEGREE)?];
        let rows = a.own.list(a.first + 2)?;
        let columns = rows.first().and_then(Value::list).map_or(0, <[Value<'_>]>::len);
        if columns == 0 || rows.len() > MAX_CONTROL / columns {
            return Err(wrong());
        }
        let weights = a.weights.map(|w| w.list(0)).transpose()?;
        self.spend(id, rows.len() * columns)?;
        let mut control = Vec::with_capacity(rows.len() * columns);
        for (i, row) in rows.iter().enumerate() {
            let row = row.list().filter(|row| row.len() == columns).ok_or_else(wrong)?;
            for (j, point) in row.iter().enumerate() {
                let weight = match weights {
                    Some(w) => {
                        w.get(i).and_then(Value::list).and_then(|w| w.get(j)?.number()).ok_or_else(wrong)?
                    }
                    None => 1.0,
                };
                control.push(self.weighted(id, point, weight)?);
            }
        }
        let u = a.knots(0, 2, degrees[0], rows.len())?;
        let v = a.knots(1, 2, degrees[1], columns)?;
        Ok(Surface::Nurbs(Box::new(NurbsSurface::new(u, v, control))))
    }
}
