//! Expressions of Fusion libraries: numbers with units, names of other expressions and of the tool's numbers,
//! + − × / and brackets, `max` and `min`. Where a decimal comma is used, Fusion writes `(29,5) mm`.
//!
//! Fusion computes the numbers of a tool from its expressions whenever it loads a library, so that an
//! expression prevails over the number beside it.

use std::collections::BTreeMap;

/// Largest depth of brackets and names within names, and length of an expression, characters.
const MAX_DEPTH: usize = 16;
const MAX_LENGTH: usize = 500;
/// Largest number of steps of one evaluation: names may multiply.
const MAX_STEPS: usize = 10_000;

/// Expressions by name. Values are in mm, mm/min, m/min, rev/min or degrees.
#[derive(Clone, Debug, Default)]
pub struct Expressions<'a> {
    texts: BTreeMap<&'a str, &'a str>,
    /// What names mean that have no expression: the numbers of the tool.
    numbers: BTreeMap<&'a str, ExpressionValue>,
    /// Factor of lengths without a unit: the unit of the tool.
    length_mm: f64,
}

/// A value on its way, mm if it is a length.
#[derive(Clone, Copy, Debug)]
struct ExpressionValue {
    value: f64,
    is_length: bool,
}

impl<'a> Expressions<'a> {
    /// The texts of an object of expressions; `length_mm` is the size of the tool's unit.
    pub fn new(object: Option<&'a serde_json::Value>, length_mm: f64) -> Self {
        let entries = object.and_then(serde_json::Value::as_object).into_iter().flatten();
        let texts = entries.filter_map(|(key, value)| Some((key.as_str(), value.as_str()?))).collect();
        Self { texts, numbers: BTreeMap::new(), length_mm }
    }

    /// As these, with lengths in mm and other numbers for names that have no expression.
    pub fn with_numbers(
        mut self,
        lengths: impl IntoIterator<Item = (&'a str, f64)>,
        others: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Self {
        let value = |is_length| move |(name, value)| (name, ExpressionValue { value, is_length });
        self.numbers.extend(lengths.into_iter().map(value(true)));
        self.numbers.extend(others.into_iter().map(value(false)));
        self
    }

    /// Whether there is an expression of this name.
    pub fn has(&self, name: &str) -> bool {
        self.texts.contains_key(name)
    }

    /// Value of an expression; `None` when it is absent or cannot be computed.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.evaluated(name).map(|found| found.value)
    }

    /// What a name means: the value of its expression, or the number of the tool.
    pub fn number_of(&self, name: &str) -> Option<f64> {
        self.named(name, 0, &mut 0).map(|found| found.value).filter(|x| x.is_finite())
    }

    /// Value of an expression of a length, mm: one without any unit is in the unit of the tool.
    pub fn length(&self, name: &str) -> Option<f64> {
        self.evaluated(name).map(|found| self.as_length(found)).filter(|x| x.is_finite())
    }

    fn as_length(&self, found: ExpressionValue) -> f64 {
        if found.is_length { found.value } else { found.value * self.length_mm }
    }

    fn evaluated(&self, name: &str) -> Option<ExpressionValue> {
        let mut steps = 0;
        self.text_of(name, 0, &mut steps).filter(|found| found.value.is_finite())
    }

    fn named(&self, name: &str, depth: usize, steps: &mut usize) -> Option<ExpressionValue> {
        match self.has(name) {
            true => self.text_of(name, depth, steps),
            false => self.numbers.get(name).copied(),
        }
    }

    fn text_of(&self, name: &str, depth: usize, steps: &mut usize) -> Option<ExpressionValue> {
        let text = self.texts.get(name).filter(|text| depth < MAX_DEPTH && text.len() <= MAX_LENGTH)?;
        let mut parser = ExpressionParser { all: self, rest: text.trim(), depth, steps, in_arguments: false };
        let value = parser.sum()?;
        parser.rest.trim().is_empty().then_some(value)
    }
}

/// Recursive descent over the rest of a text.
struct ExpressionParser<'a, 'e, 's> {
    all: &'e Expressions<'a>,
    rest: &'a str,
    depth: usize,
    steps: &'s mut usize,
    /// Whether a comma separates the arguments of a function; elsewhere it is a decimal one.
    in_arguments: bool,
}

impl ExpressionParser<'_, '_, '_> {
    fn take(&mut self, sign: char) -> bool {
        let rest = self.rest.trim_start();
        let found = rest.strip_prefix(sign);
        self.rest = found.unwrap_or(rest);
        found.is_some()
    }

    /// Combines two values that must be alike: a number without unit beside a length is in the unit of the
    /// tool.
    fn alike(&self, a: ExpressionValue, b: ExpressionValue, of: impl Fn(f64, f64) -> f64) -> ExpressionValue {
        let is_length = a.is_length || b.is_length;
        let [a, b] = [a, b].map(|x| if is_length { self.all.as_length(x) } else { x.value });
        ExpressionValue { value: of(a, b), is_length }
    }

    fn sum(&mut self) -> Option<ExpressionValue> {
        let mut value = self.product()?;
        loop {
            if self.take('+') {
                let other = self.product()?;
                value = self.alike(value, other, |a, b| a + b);
            } else if self.take('-') {
                let other = self.product()?;
                value = self.alike(value, other, |a, b| a - b);
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<ExpressionValue> {
        let mut value = self.factor()?;
        loop {
            if self.take('*') {
                let other = self.factor()?;
                let is_length = value.is_length || other.is_length;
                value = ExpressionValue { value: value.value * other.value, is_length };
            } else if self.take('/') {
                let other = self.factor()?;
                let is_length = value.is_length && !other.is_length;
                value = ExpressionValue { value: value.value / other.value, is_length };
            } else {
                return Some(value);
            }
        }
    }

    fn factor(&mut self) -> Option<ExpressionValue> {
        *self.steps += 1;
        if *self.steps > MAX_STEPS || self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let value = if self.take('-') {
            self.factor().map(|x| ExpressionValue { value: -x.value, ..x })
        } else if self.take('(') {
            self.bracket()
        } else {
            self.number_or_name()
        };
        self.depth -= 1;
        value
    }

    /// The rest of `(a)` after its bracket; a unit may follow it, as in `(2 + 3) mm`.
    fn bracket(&mut self) -> Option<ExpressionValue> {
        let around = std::mem::replace(&mut self.in_arguments, false);
        let value = self.sum().filter(|_| self.take(')'));
        self.in_arguments = around;
        let value = value?;
        Some(if value.is_length { value } else { self.with_unit(value.value) })
    }

    /// The rest of `max(a, b, …)` or `min(a, b, …)` after its bracket.
    fn extreme(&mut self, of: fn(f64, f64) -> f64) -> Option<ExpressionValue> {
        let around = std::mem::replace(&mut self.in_arguments, true);
        let mut value = self.sum();
        while value.is_some() && (self.take(',') || self.take(';')) {
            let other = self.sum();
            value = value.zip(other).map(|(value, other)| self.alike(value, other, of));
        }
        self.in_arguments = around;
        value.filter(|_| self.take(')'))
    }

    /// A number with the unit that follows it, if one does.
    fn with_unit(&mut self, value: f64) -> ExpressionValue {
        self.rest = self.rest.trim_start();
        for (unit, factor, is_length) in UNITS {
            let after = self.rest.strip_prefix(unit);
            if let Some(after) = after.filter(|after| !after.starts_with(|c: char| c.is_ascii_alphanumeric()))
            {
                self.rest = after;
                return ExpressionValue { value: value * factor, is_length };
            }
        }
        ExpressionValue { value, is_length: false }
    }

    fn number_or_name(&mut self) -> Option<ExpressionValue> {
        let rest = self.rest.trim_start();
        let begins_name = rest.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if begins_name {
            let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let name = rest.get(..end)?;
            self.rest = rest.get(end..)?;
            let extreme: Option<fn(f64, f64) -> f64> = match name {
                "max" => Some(f64::max),
                "min" => Some(f64::min),
                _ => None,
            };
            return match extreme {
                Some(of) if self.take('(') => self.extreme(of),
                _ => self.all.named(name, self.depth, self.steps),
            };
        }
        let comma = if self.in_arguments { '.' } else { ',' };
        let digits = |c: char| c.is_ascii_digit() || c == '.' || c == comma;
        let mut end = rest.find(|c: char| !digits(c)).unwrap_or(rest.len());
        // An exponent belongs to the number only with its digits.
        if let Some(tail) = rest.get(end..).and_then(|tail| tail.strip_prefix(['e', 'E'])) {
            let signed = tail.strip_prefix(['+', '-']).unwrap_or(tail);
            let count = signed.find(|c: char| !c.is_ascii_digit()).unwrap_or(signed.len());
            if count > 0 {
                end = rest.len() - signed.len() + count;
            }
        }
        // Thousands are not separated: a number with comma and point, or with two of them, is none.
        let value: f64 = rest.get(..end)?.replace(',', ".").parse().ok()?;
        self.rest = rest.get(end..)?;
        Some(self.with_unit(value))
    }
}

/// Units with their factors, and whether they are of a length; the longest first: `mm/min` begins with `mm`.
const UNITS: [(&str, f64, bool); 21] = [
    ("mm/min", 1.0, false),
    ("mmpm", 1.0, false),
    ("mpm", 1.0, false),
    ("m/min", 1.0, false),
    ("in/min", 25.4, false),
    ("inpm", 25.4, false),
    ("ipm", 25.4, false),
    ("ft/min", 0.3048, false),
    ("fpm", 0.3048, false),
    ("sfm", 0.3048, false),
    ("rpm", 1.0, false),
    ("inches", 25.4, true),
    ("inch", 25.4, true),
    ("degrees", 1.0, false),
    ("degree", 1.0, false),
    ("deg", 1.0, false),
    ("mm", 1.0, true),
    ("cm", 10.0, true),
    ("in", 25.4, true),
    ("\"", 25.4, true),
    ("ft", 304.8, true),
];

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_units_names_and_brackets() {
        let object = json!({
            "a": ".5 in", "b": "10 mm + a", "c": "(b - 2.7mm) * 2 / 4", "d": "7", "e": "300 mmpm", "f": "e/3",
            "g": "1e1 mm", "h": "100 fpm", "i": "-(2 mm)", "j": "2 cm", "k": "(29,5) mm", "l": "(1 + 1,5) in * 2",
            "m": "(175,5) mmpm", "n": "45 degrees", "o": "max((1,5) mm, 1 mm)", "p": "(2) + 1 mm",
        });
        let all = Expressions::new(Some(&object), 25.4);
        for (name, value) in [
            ("a", 12.7),
            ("b", 22.7),
            ("c", 10.0),
            ("d", 7.0),
            ("e", 300.0),
            ("f", 100.0),
            ("g", 10.0),
            ("h", 30.48),
            ("i", -2.0),
            ("j", 20.0),
            ("k", 29.5),
            ("l", 127.0),
            ("m", 175.5),
            ("n", 45.0),
            ("o", 1.5),
            ("p", 51.8),
        ] {
            let found = all.value(name).expect(name);
            assert!((found - value).abs() < 1e-9, "{name}: {found}");
        }
        assert_eq!(all.length("d"), Some(7.0 * 25.4), "a plain number is in the unit of the tool");
    }

    #[test]
    fn the_greater_and_the_numbers_of_the_tool() {
        let object = json!({
            "body": "max(tool_shoulderLength, (tool_overallLength - tool_holderGaugeLength - .5))",
            "least": "min(1 in; 30 mm, 2)", "share": "tool_diameter * 3", "ratio": "tool_diameter / 12.7mm",
            "empty": "max()", "open": "max(1, 2", "max": "3 mm", "named": "max + 1 mm",
        });
        let numbers = [("tool_shoulderLength", 20.0), ("tool_overallLength", 76.2), ("tool_diameter", 12.7)];
        let all = Expressions::new(Some(&object), 25.4)
            .with_numbers(numbers, [])
            .with_numbers([("tool_holderGaugeLength", 25.4)], []);
        for (name, value) in
            [("body", 38.1), ("least", 25.4), ("share", 38.1), ("ratio", 25.4), ("named", 4.0)]
        {
            let found = all.length(name).expect(name);
            assert!((found - value).abs() < 1e-9, "{name}: {found}");
        }
        assert_eq!([all.length("empty"), all.length("open")], [None, None]);
    }

    #[test]
    fn what_cannot_be_computed_is_absent() {
        let deep = format!("{}1{}", "(".repeat(400), ")".repeat(99));
        let object = json!({
            "loop": "loop + 1 mm", "twice": "p*p", "p": "q+q", "q": "twice", "empty": "", "text": "'x'",
            "deep": deep, "zero": "1/0", "tail": "3 mm x", "unknown": "tool_nothing", "open": "(1",
            "thousands": "1,000.5 mm", "commas": "1,2,3",
        });
        let all = Expressions::new(Some(&object), 1.0);
        for name in object.as_object().expect("object").keys() {
            assert_eq!(all.value(name), None, "{name}");
        }
    }
}
