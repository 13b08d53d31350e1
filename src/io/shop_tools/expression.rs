//! Expressions of Fusion libraries: numbers with units, names of other expressions, + − × / and brackets.
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
    /// Factor of lengths without a unit: the unit of the tool.
    length_mm: f64,
}

impl<'a> Expressions<'a> {
    /// The texts of an object of expressions; `length_mm` is the size of the tool's unit.
    pub fn new(object: Option<&'a serde_json::Value>, length_mm: f64) -> Self {
        let entries = object.and_then(serde_json::Value::as_object).into_iter().flatten();
        let texts = entries.filter_map(|(key, value)| Some((key.as_str(), value.as_str()?))).collect();
        Self { texts, length_mm }
    }

    /// Whether there is an expression of this name.
    pub fn has(&self, name: &str) -> bool {
        self.texts.contains_key(name)
    }

    /// Value of an expression; `None` when it is absent or cannot be computed.
    pub fn value(&self, name: &str) -> Option<f64> {
        let mut steps = 0;
        self.named(name, 0, &mut steps).filter(|x| x.is_finite())
    }

    fn named(&self, name: &str, depth: usize, steps: &mut usize) -> Option<f64> {
        let text = self.texts.get(name).filter(|text| depth < MAX_DEPTH && text.len() <= MAX_LENGTH)?;
        let mut parser = ExpressionParser { all: self, rest: text.trim(), depth, steps };
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
}

impl ExpressionParser<'_, '_, '_> {
    fn take(&mut self, sign: char) -> bool {
        let rest = self.rest.trim_start();
        let found = rest.strip_prefix(sign);
        self.rest = found.unwrap_or(rest);
        found.is_some()
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        loop {
            if self.take('+') {
                value += self.product()?;
            } else if self.take('-') {
                value -= self.product()?;
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.factor()?;
        loop {
            if self.take('*') {
                value *= self.factor()?;
            } else if self.take('/') {
                value /= self.factor()?;
            } else {
                return Some(value);
            }
        }
    }

    fn factor(&mut self) -> Option<f64> {
        *self.steps += 1;
        if *self.steps > MAX_STEPS || self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let value = if self.take('-') {
            self.factor().map(|x| -x)
        } else if self.take('(') {
            self.sum().filter(|_| self.take(')'))
        } else {
            self.number_or_name()
        };
        self.depth -= 1;
        value
    }

    fn number_or_name(&mut self) -> Option<f64> {
        let rest = self.rest.trim_start();
        let begins_name = rest.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if begins_name {
            let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
            let name = rest.get(..end)?;
            self.rest = rest.get(end..)?;
            return self.all.named(name, self.depth, self.steps);
        }
        let digits = |c: char| c.is_ascii_digit() || c == '.';
        let mut end = rest.find(|c: char| !digits(c)).unwrap_or(rest.len());
        // An exponent belongs to the number only with its digits.
        if let Some(tail) = rest.get(end..).and_then(|tail| tail.strip_prefix(['e', 'E'])) {
            let signed = tail.strip_prefix(['+', '-']).unwrap_or(tail);
            let count = signed.find(|c: char| !c.is_ascii_digit()).unwrap_or(signed.len());
            if count > 0 {
                end = rest.len() - signed.len() + count;
            }
        }
        let value: f64 = rest.get(..end)?.parse().ok()?;
        let tail = rest.get(end..)?.trim_start();
        // The longest unit first: `mm/min` begins with `mm`.
        let units: [(&str, f64); 17] = [
            ("mm/min", 1.0),
            ("mmpm", 1.0),
            ("mpm", 1.0),
            ("m/min", 1.0),
            ("in/min", 25.4),
            ("inpm", 25.4),
            ("ipm", 25.4),
            ("ft/min", 0.3048),
            ("fpm", 0.3048),
            ("sfm", 0.3048),
            ("rpm", 1.0),
            ("inch", 25.4),
            ("deg", 1.0),
            ("mm", 1.0),
            ("cm", 10.0),
            ("in", 25.4),
            ("\"", 25.4),
        ];
        for (unit, factor) in units {
            let after = tail.strip_prefix(unit);
            if let Some(after) = after.filter(|after| !after.starts_with(|c: char| c.is_ascii_alphanumeric()))
            {
                self.rest = after;
                return Some(value * factor);
            }
        }
        self.rest = tail;
        Some(value)
    }
}

impl Expressions<'_> {
    /// Value of an expression of a length: a single number without unit is in the unit of the tool.
    pub fn length(&self, name: &str) -> Option<f64> {
        let plain = self.texts.get(name)?.trim().parse::<f64>().ok();
        plain.map(|x| x * self.length_mm).filter(|x| x.is_finite()).or_else(|| self.value(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_units_names_and_brackets() {
        let object = json!({
            "a": ".5 in", "b": "10 mm + a", "c": "(b - 2.7mm) * 2 / 4", "d": "7", "e": "300 mmpm", "f": "e/3",
            "g": "1e1 mm", "h": "100 fpm", "i": "-(2 mm)", "j": "2 cm",
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
        ] {
            let found = all.value(name).expect(name);
            assert!((found - value).abs() < 1e-9, "{name}: {found}");
        }
        assert_eq!(all.length("d"), Some(7.0 * 25.4), "a plain number is in the unit of the tool");
    }

    #[test]
    fn what_cannot_be_computed_is_absent() {
        let deep = format!("{}1{}", "(".repeat(400), ")".repeat(99));
        let object = json!({
            "loop": "loop + 1 mm", "twice": "p*p", "p": "q+q", "q": "twice", "empty": "", "text": "'x'",
            "deep": deep, "zero": "1/0", "tail": "3 mm x", "unknown": "tool_nothing", "open": "(1",
        });
        let all = Expressions::new(Some(&object), 1.0);
        for name in object.as_object().expect("object").keys() {
            assert_eq!(all.value(name), None, "{name}");
        }
    }
}
