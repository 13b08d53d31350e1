//! Typed access to the instances of a file, with faults that name the instance; units of representations.

use super::exchange::{Exchange, Instance, Record, Value};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::source::{MAX_COORDINATE, quote_for_message};

/// Deepest chain of instances that refer to one another, such as a trimmed curve of an offset curve.
pub const MAX_CHAIN: usize = 16;

/// A fault of an instance.
#[derive(Clone, Debug, PartialEq)]
pub struct EntityFault {
    /// Its number.
    pub id: u32,
    /// What is wrong with it.
    pub what: String,
}

impl EntityFault {
    /// A fault of instance `id`.
    pub fn new(id: u32, what: impl Into<String>) -> Self {
        Self { id, what: what.into() }
    }

    /// As an error of the file `name`.
    pub fn in_file(&self, name: &str) -> InputError {
        let what = format!("#{}: {}", self.id, self.what);
        InputError::new(ErrorCode::StepFile, name, 0, what, "repair the model, or export it again")
    }
}

/// Length and angle of one unit of a representation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Length, mm.
    pub mm: f64,
    /// Angle, rad.
    pub rad: f64,
}

impl Default for Units {
    fn default() -> Self {
        Self { mm: 1.0, rad: 1.0 }
    }
}

/// A right-handed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Origin, mm.
    pub origin: Point,
    /// Unit vectors of its axes.
    pub axes: [Vector; 3],
}

impl Default for Frame {
    fn default() -> Self {
        Self { origin: Point::origin(), axes: [Vector::x(), Vector::y(), Vector::z()] }
    }
}

impl Frame {
    /// A frame with a z axis, and its x axis near `x`.
    pub fn new(origin: Point, z: Vector, x: Vector) -> Self {
        let x = x - z * z.dot(&x);
        let other = if z.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let x = x.try_normalize(1e-9).unwrap_or_else(|| (other - z * z.dot(&other)).normalize());
        Self { origin, axes: [x, z.cross(&x), z] }
    }

    /// Coordinates of a point in this frame.
    pub fn local(&self, p: &Point) -> Vector {
        let d = p - self.origin;
        Vector::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]), d.dot(&self.axes[2]))
    }

    /// The point with these coordinates.
    pub fn world(&self, q: Vector) -> Point {
        self.origin + self.direction(q)
    }

    /// The direction with these coordinates.
    pub fn direction(&self, q: Vector) -> Vector {
        self.axes[0] * q.x + self.axes[1] * q.y + self.axes[2] * q.z
    }
}

/// The arguments of an instance, with faults that name it.
#[derive(Clone, Copy)]
pub struct EntityArguments<'m, 'a> {
    /// The instance's number.
    pub id: u32,
    values: &'m [Value<'a>],
}

/// What a reader of instances returns.
pub type EntityResult<T> = Result<T, EntityFault>;

impl<'m, 'a> EntityArguments<'m, 'a> {
    /// Arguments of instance `id`.
    pub fn new(id: u32, values: &'m [Value<'a>]) -> Self {
        Self { id, values }
    }

    fn get<T>(&self, at: usize, kind: &str, of: impl Fn(&'m Value<'a>) -> Option<T>) -> EntityResult<T> {
        self.values
            .get(at)
            .and_then(of)
            .ok_or_else(|| EntityFault::new(self.id, format!("argument {} is not {kind}", at + 1)))
    }

    /// A reference.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn reference(&self, at: usize) -> EntityResult<u32> {
        self.get(at, "a reference", Value::reference)
    }

    /// A reference, or `None` for `$`.
    pub fn optional(&self, at: usize) -> Option<u32> {
        self.values.get(at).and_then(Value::reference)
    }

    /// A number.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn number(&self, at: usize) -> EntityResult<f64> {
        self.get(at, "a number", Value::number)
    }

    /// A whole number from 0 to `most`.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn count(&self, at: usize, most: usize) -> EntityResult<usize> {
        let x = self.number(at)?;
        if x.fract() == 0.0 && (0.0..=most as f64).contains(&x) {
            return Ok(x as usize);
        }
        Err(EntityFault::new(self.id, format!("argument {} is {x}, not a number up to {most}", at + 1)))
    }

    /// A list.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn list(&self, at: usize) -> EntityResult<&'m [Value<'a>]> {
        self.get(at, "a list", Value::list)
    }

    /// A list of references.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn references(&self, at: usize) -> EntityResult<Vec<u32>> {
        let fault = || EntityFault::new(self.id, format!("argument {} is not a list of references", at + 1));
        self.list(at)?.iter().map(|v| v.reference().ok_or_else(fault)).collect()
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn numbers(&self, at: usize) -> EntityResult<Vec<f64>> {
        let fault = || EntityFault::new(self.id, format!("argument {} is not a list of numbers", at + 1));
        self.list(at)?.iter().map(|v| v.number().ok_or_else(fault)).collect()
    }

    /// A logical value; unknown counts as false.
    ///
    /// # Errors
    /// When the argument is not one.
    pub fn is_true(&self, at: usize) -> EntityResult<bool> {
        self.get(at, "a logical value", Value::word).map(|word| word == "T")
    }

    /// A string, decoded; empty where there is none.
    pub fn text(&self, at: usize) -> String {
        match self.values.get(at) {
            Some(Value::Text(text)) => super::exchange::decoded(text).trim().to_owned(),
            _ => String::new(),
        }
    }

    /// A value as it is.
    pub fn value(&self, at: usize) -> Option<&'m Value<'a>> {
        self.values.get(at)
    }
}

/// The instances of a file.
pub struct Model<'a> {
    /// The exchange structure.
    pub exchange: Exchange<'a>,
}

impl<'a> Model<'a> {
    /// The instance `id` that `from` refers to.
    ///
    /// # Errors
    /// When the file does not have it.
    pub fn instance(&self, from: u32, id: u32) -> EntityResult<&Instance<'a>> {
        let missing = || EntityFault::new(from, format!("refers to #{id}, which the file does not have"));
        self.exchange.get(id).ok_or_else(missing)
    }

    /// The arguments of instance `id`, which `from` refers to and which has to be one of `keywords`.
    ///
    /// # Errors
    /// When it is missing or something else.
    pub fn expect(&self, from: u32, id: u32, keywords: &[&str]) -> EntityResult<EntityArguments<'_, 'a>> {
        let instance = self.instance(from, id)?;
        let record = instance.records.iter().find(|r| keywords.contains(&r.keyword));
        let wrong = || {
            let is = quote_for_message(instance.keyword());
            EntityFault::new(id, format!("is {is} where #{from} needs {}", keywords[0]))
        };
        record.map(|r| EntityArguments { id, values: &r.values }).ok_or_else(wrong)
    }

    /// All records with a keyword, with their instances' numbers.
    pub fn all(&self, keyword: &'static str) -> impl Iterator<Item = EntityArguments<'_, 'a>> {
        let of = move |r: &&Record<'_>| r.keyword == keyword;
        self.exchange.iter().filter_map(move |i| {
            i.records.iter().find(of).map(|r| EntityArguments { id: i.id, values: &r.values })
        })
    }

    /// A point, mm.
    ///
    /// # Errors
    /// When instance `id` is not a point within 1,000,000 mm.
    pub fn point(&self, from: u32, id: u32, mm: f64) -> EntityResult<Point> {
        let x = self.expect(from, id, &["CARTESIAN_POINT"])?.numbers(1)?;
        let at = |k: usize| x.get(k).copied().unwrap_or(0.0) * mm;
        let p = Point::new(at(0), at(1), at(2));
        if x.is_empty() || x.len() > 3 {
            return Err(EntityFault::new(id, format!("has {} coordinates", x.len())));
        }
        if p.iter().any(|x| x.abs() > MAX_COORDINATE) {
            return Err(EntityFault::new(id, "is not within 1,000,000 mm"));
        }
        Ok(p)
    }

    /// A unit vector.
    ///
    /// # Errors
    /// When instance `id` is not a direction, or has no length.
    pub fn direction(&self, from: u32, id: u32) -> EntityResult<Vector> {
        let x = self.expect(from, id, &["DIRECTION"])?.numbers(1)?;
        let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
        let none = || EntityFault::new(id, "has no direction");
        Vector::new(at(0), at(1), at(2)).try_normalize(1e-12).ok_or_else(none)
    }

    /// A vector: its direction and length, mm.
    ///
    /// # Errors
    /// When instance `id` is not a vector of some length.
    pub fn vector(&self, from: u32, id: u32, mm: f64) -> EntityResult<Vector> {
        let a = self.expect(from, id, &["VECTOR"])?;
        let length = a.number(2)? * mm;
        if !(length.abs() > 1e-12 && length.abs() <= MAX_COORDINATE) {
            return Err(EntityFault::new(id, format!("has the length {length} mm")));
        }
        Ok(self.direction(id, a.reference(1)?)? * length)
    }

    /// A placement: its location, z axis and x direction.
    ///
    /// # Errors
    /// When instance `id` is not a placement.
    pub fn frame(&self, from: u32, id: u32, mm: f64) -> EntityResult<Frame> {
        let a = self.expect(from, id, &["AXIS2_PLACEMENT_3D", "AXIS1_PLACEMENT"])?;
        let origin = self.point(id, a.reference(1)?, mm)?;
        let of = |at: usize, default: Vector| match a.optional(at) {
            Some(direction) => self.direction(id, direction),
            None => Ok(default),
        };
        let z = of(2, Vector::z())?;
        let x = of(3, if z.x.abs() < 0.9 { Vector::x() } else { Vector::y() })?;
        Ok(Frame::new(origin, z, x))
    }

    /// Units of a representation by its context; those of any context where it names none.
    ///
    /// # Errors
    /// When a unit is not understood.
    pub fn units(&self, context: Option<u32>) -> EntityResult<Units> {
        let own =
            context.and_then(|id| Some((id, self.exchange.get(id)?.record("GLOBAL_UNIT_ASSIGNED_CONTEXT")?)));
        let any = || self.all("GLOBAL_UNIT_ASSIGNED_CONTEXT").next().map(|a| (a.id, a.values));
        let Some((id, values)) = own.or_else(any) else { return Ok(Units::default()) };
        let mut units = Units::default();
        for unit in EntityArguments::new(id, values).references(0)? {
            let instance = self.instance(id, unit)?;
            if instance.record("LENGTH_UNIT").is_some() {
                units.mm = 1e3 * self.size_of_unit(id, unit, 0)?;
            } else if instance.record("PLANE_ANGLE_UNIT").is_some() {
                units.rad = self.size_of_unit(id, unit, 0)?;
            }
        }
        Ok(units)
    }

    /// A unit in metres or radians.
    fn size_of_unit(&self, from: u32, id: u32, depth: usize) -> EntityResult<f64> {
        let instance = self.instance(from, id)?;
        if let Some(values) = instance.record("SI_UNIT") {
            let prefix = EntityArguments { id, values }.value(0).and_then(Value::word);
            let known = [("MILLI", 1e-3), ("CENTI", 1e-2), ("DECI", 0.1), ("MICRO", 1e-6), ("KILO", 1e3)];
            return match prefix {
                None => Ok(1.0),
                Some(prefix) => known.iter().find(|(p, _)| *p == prefix).map(|(_, x)| *x).ok_or_else(|| {
                    EntityFault::new(id, format!("has the unknown prefix {}", quote_for_message(prefix)))
                }),
            };
        }
        let Some(values) = instance.record("CONVERSION_BASED_UNIT").filter(|_| depth < MAX_CHAIN) else {
            return Err(EntityFault::new(id, "is not a unit of length or angle"));
        };
        let measure = EntityArguments { id, values }.reference(1)?;
        let a = self.instance(id, measure)?;
        let record = a.records.iter().find(|r| r.keyword.ends_with("MEASURE_WITH_UNIT"));
        let record = record.ok_or_else(|| EntityFault::new(measure, "is not a measure with a unit"))?;
        let a = EntityArguments { id: measure, values: &record.values };
        let size = a.number(0)? * self.size_of_unit(measure, a.reference(1)?, depth + 1)?;
        if !(1e-7..=1e4).contains(&size) {
            return Err(EntityFault::new(measure, format!("a unit of {size} is not plausible")));
        }
        Ok(size)
    }
}
