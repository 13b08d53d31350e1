//! Parser of typed numbers: arithmetic (`30/4`), units, decimal comma. Recursive descent over sum, product
//! and atom.

use crate::geometry::without_conversion_error;

/// What a typed number measures, which decides the units that may follow it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A length, mm.
    Length,
    /// An angle, degrees.
    Angle,
    /// A feed rate, mm/min.
    FeedRate,
    /// A spindle speed, rev/min.
    SpindleSpeed,
    /// A cutting speed, m/min.
    CuttingSpeed,
    /// A rate of removal, mm³/min.
    RemovalRate,
    /// A duration, minutes.
    Duration,
    /// A number without unit.
    Plain,
    /// A whole number.
    Count,
}

impl Quantity {
    /// The unit of the field's value; empty where it has none.
    pub fn unit(self) -> &'static str {
        self.units().first().map_or("", |(unit, _)| unit)
    }

    /// The units that may be typed, with their value in that of the field, which is the first.
    fn units(self) -> &'static [(&'static str, f64)] {
        const INCH_MM: f64 = 25.4;
        match self {
            Self::Length => &[
                ("mm", 1.0),
                ("cm", 10.0),
                ("m", 1000.0),
                ("µm", 1e-3),
                ("um", 1e-3),
                ("in", INCH_MM),
                ("inch", INCH_MM),
                ("\"", INCH_MM),
                ("″", INCH_MM),
            ],
            Self::Angle => &[("°", 1.0), ("deg", 1.0), ("rad", 180.0 / std::f64::consts::PI)],
            Self::FeedRate => {
                &[("mm/min", 1.0), ("m/min", 1000.0), ("mm/s", 60.0), ("in/min", INCH_MM), ("ipm", INCH_MM)]
            }
            Self::SpindleSpeed => &[("rev/min", 1.0), ("rpm", 1.0), ("1/min", 1.0), ("/min", 1.0)],
            Self::CuttingSpeed => &[("m/min", 1.0), ("ft/min", 0.3048), ("sfm", 0.3048), ("sfpm", 0.3048)],
            Self::RemovalRate => &[
                ("mm³/min", 1.0),
                ("mm3/min", 1.0),
                ("cm³/min", 1000.0),
                ("cm3/min", 1000.0),
                ("in³/min", INCH_MM * INCH_MM * INCH_MM),
                ("in3/min", INCH_MM * INCH_MM * INCH_MM),
            ],
            Self::Duration => &[("min", 1.0), ("h", 60.0), ("s", 1.0 / 60.0)],
            Self::Plain | Self::Count => &[],
        }
    }
}

/// Value of `text` in the unit of the field: a number or a calculation, and perhaps a unit of the `quantity`,
/// which is converted. `None` where it is not a finite number, or not a whole one where the quantity is a
/// count, or its unit is not one of the quantity.
pub fn parse(text: &str, quantity: Quantity) -> Option<f64> {
    let text = text.trim();
    // The longest unit that fits: "mm" ends in "m", too.
    let fitting = quantity.units().iter().filter(|(unit, _)| {
        text.len() >= unit.len()
            && text.is_char_boundary(text.len() - unit.len())
            && text[text.len() - unit.len()..].eq_ignore_ascii_case(unit)
    });
    let (number, factor) = match fitting.max_by_key(|(unit, _)| unit.len()) {
        Some((unit, factor)) => (&text[..text.len() - unit.len()], *factor),
        None => (text, 1.0),
    };
    let number = number.trim().replace(',', ".").replace('−', "-");
    let mut rest = number.as_bytes();
    let number = sum(&mut rest, 0)?;
    let value = match quantity {
        // Degrees have no short decimals for radians.
        Quantity::Angle => number * factor,
        _ if factor == 1.0 => number,
        _ => without_conversion_error(number * factor),
    };
    let is_one = rest.is_empty() && value.is_finite();
    (is_one && (quantity != Quantity::Count || value.fract() == 0.0)).then_some(value)
}

/// `text` with minus signs before its numbers instead of hyphens: a hyphen is short, and lines break after
/// it, so that it would be parted from its number. What is rounded to zero has no sign.
pub fn with_minus_signs(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        let begins = shown.chars().last().is_none_or(|before| !before.is_alphanumeric());
        let is_sign = c == '-' && begins && chars.peek().is_some_and(char::is_ascii_digit);
        let number = || chars.clone().take_while(|c| c.is_ascii_digit() || *c == '.');
        if is_sign && number().all(|digit| matches!(digit, '0' | '.')) {
            continue;
        }
        shown.push(if is_sign { '−' } else { c });
    }
    shown
}

/// Maximum nesting depth; deeper input is rejected, so that it cannot exhaust the stack.
const MAX_DEPTH: usize = 32;

fn sum(rest: &mut &[u8], depth: usize) -> Option<f64> {
    let mut value = product(rest, depth)?;
    loop {
        match peek(rest) {
            Some(b'+') => value += product(skip(rest), depth)?,
            Some(b'-') => value -= product(skip(rest), depth)?,
            _ => return Some(value),
        }
    }
}

fn product(rest: &mut &[u8], depth: usize) -> Option<f64> {
    let mut value = atom(rest, depth)?;
    loop {
        match peek(rest) {
            Some(b'*') => value *= atom(skip(rest), depth)?,
            Some(b'/') => value /= atom(skip(rest), depth)?,
            _ => return Some(value),
        }
    }
}

fn atom(rest: &mut &[u8], depth: usize) -> Option<f64> {
    if depth > MAX_DEPTH {
        return None;
    }
    match peek(rest)? {
        b'-' => Some(-atom(skip(rest), depth + 1)?),
        b'+' => atom(skip(rest), depth + 1),
        b'(' => {
            let value = sum(skip(rest), depth + 1)?;
            (peek(rest)? == b')').then_some(())?;
            skip(rest);
            Some(value)
        }
        _ => {
            let length = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
            let (digits, after) = rest.split_at(length + length_of_exponent(&rest[length..]));
            *rest = after;
            std::str::from_utf8(digits).ok()?.parse().ok()
        }
    }
}

/// Length of the exponent that `rest` begins with, as in `1e9` and `2.5E-3`; 0 without one.
fn length_of_exponent(rest: &[u8]) -> usize {
    let [b'e' | b'E', after @ ..] = rest else { return 0 };
    let sign = usize::from(matches!(after, [b'+' | b'-', ..]));
    match after[sign..].iter().take_while(|b| b.is_ascii_digit()).count() {
        0 => 0,
        digits => 1 + sign + digits,
    }
}

fn peek(rest: &mut &[u8]) -> Option<u8> {
    *rest = rest.trim_ascii_start();
    rest.first().copied()
}

fn skip<'a, 'b>(rest: &'a mut &'b [u8]) -> &'a mut &'b [u8] {
    *rest = &rest[1..];
    rest
}

#[cfg(test)]
mod tests {
    use super::Quantity::{
        Angle, Count, CuttingSpeed, Duration, FeedRate, Length, Plain, RemovalRate, SpindleSpeed,
    };
    use super::{parse, with_minus_signs};

    #[test]
    fn only_signs_of_numbers_become_minus_signs() {
        let text = "comes within -5.7 mm (-3) of a semi-finished 2-1 hub - no";
        assert_eq!(with_minus_signs(text), "comes within −5.7 mm (−3) of a semi-finished 2-1 hub - no");
        assert_eq!(with_minus_signs("-0.0 of -0.05 and -0, (-0.00)"), "0.0 of −0.05 and 0, (0.00)");
    }

    #[test]
    fn every_unit_that_is_shown_may_be_typed() {
        for quantity in
            [Length, Angle, FeedRate, SpindleSpeed, CuttingSpeed, RemovalRate, Duration, Plain, Count]
        {
            let text = format!("12 {}", quantity.unit());
            assert_eq!(parse(&text, quantity), Some(12.0), "{text}");
        }
    }

    #[test]
    fn typed_numbers() {
        for (text, quantity, value) in [
            ("8", Length, 8.0),
            (" 30/4 ", Length, 7.5),
            ("30/4 mm", Length, 7.5),
            ("2,5mm", Length, 2.5),
            ("1in", Length, 25.4),
            ("0.5 inch", Length, 12.7),
            ("1/2\"", Length, 12.7),
            ("1.2 CM", Length, 12.0),
            ("-12.5°", Angle, -12.5),
            ("−3", Plain, -3.0),
            ("1+2*3", Plain, 7.0),
            ("(1+2)*3", Plain, 9.0),
            ("-(2-5)", Plain, 3.0),
            ("300 mm/min", FeedRate, 300.0),
            ("1000 ft/min", CuttingSpeed, 304.8),
            ("0.8 cm³/min", RemovalRate, 800.0),
            ("10 ipm", FeedRate, 254.0),
            ("1200 rpm", SpindleSpeed, 1200.0),
            ("6/2", Count, 3.0),
            ("1e9", Length, 1e9),
            ("2.5E-1 cm", Length, 2.5),
            ("1e+2*2", Plain, 200.0),
        ] {
            let parsed = parse(text, quantity).unwrap_or_else(|| panic!("{text} is a number"));
            assert!((parsed - value).abs() < 1e-12, "{text:?}: {parsed}");
        }
        assert_eq!(parse("1.5 in", Length), Some(38.1), "without the error of converting it");
        assert!((parse("0.5 rad", Angle).unwrap_or_default() - 28.647_889_756_541_16).abs() < 1e-12);
    }

    #[test]
    fn no_numbers() {
        for text in [
            "",
            "mm",
            "1/0",
            "1..2",
            "(1",
            "1)",
            "1e999",
            "1e",
            "1e+",
            "e3",
            "auto",
            "--",
            "€",
            &"(".repeat(10_000),
        ] {
            assert_eq!(parse(text, Length), None, "{text:?}");
        }
    }

    #[test]
    fn units_of_something_else_are_refused() {
        for (text, quantity) in [
            ("5°", Length),
            ("5 ft", Length),
            ("30 mm", Angle),
            ("300 mm", FeedRate),
            ("5 in", SpindleSpeed),
            ("0.5 mm", Plain),
            ("5 %", Length),
            ("2.5", Count),
            ("5/2", Count),
        ] {
            assert_eq!(parse(text, quantity), None, "{text:?}");
        }
    }
}
