//! Lengths and angles as FreeCAD writes them, and as people do: `6.0000 mm`, `5,0 mm`, `1/4 in`, `1 1/4"`.

/// Longest text that is looked at, characters.
const MAX_LENGTH: usize = 60;

/// Reads a length with its unit, which is mm if there is none; the result is in mm. `None` if `text` is not a
/// length.
pub fn length_mm(text: &str) -> Option<f64> {
    let (value, unit) = number_and_unit(text)?;
    let factor = match unit.to_lowercase().as_str() {
        "" | "mm" => 1.0,
        "cm" => 10.0,
        "m" => 1000.0,
        "in" | "in." | "inch" | "inches" | "\"" | "″" | "''" => 25.4,
        "ft" | "'" | "′" => 304.8,
        "µm" | "μm" | "um" => 1e-3,
        "nm" => 1e-6,
        "mil" | "thou" => 0.0254,
        _ => return None,
    };
    Some(value * factor).filter(|x| x.is_finite())
}

/// An angle in degrees; without unit it is in degrees.
pub fn angle_deg(text: &str) -> Option<f64> {
    let (value, unit) = number_and_unit(text)?;
    let factor = match unit.to_lowercase().as_str() {
        "" | "°" | "deg" => 1.0,
        "rad" => 180.0 / std::f64::consts::PI,
        _ => return None,
    };
    Some(value * factor).filter(|x| x.is_finite())
}

/// The number that a text begins with, whole, decimal or with a fraction, and what follows it.
fn number_and_unit(text: &str) -> Option<(f64, String)> {
    // Thin and fixed blanks stand between number and unit.
    let text: String = text.chars().map(|c| if c.is_whitespace() { ' ' } else { c }).collect();
    let text = text.trim();
    if text.chars().count() > MAX_LENGTH {
        return None;
    }
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest.trim_start()),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let (first, rest) = number(text)?;
    let fraction = |rest: &str, over: f64| -> Option<(f64, String)> {
        let (below, rest) = number(rest.trim_start().strip_prefix('/')?.trim_start())?;
        (below > 0.0).then(|| (over / below, rest.trim().to_owned()))
    };
    if let Some((value, unit)) = fraction(rest, first) {
        return Some((sign * value, unit));
    }
    // A whole number before a fraction: with a blank or a hyphen, as in 1 1/4 and 1-1/4.
    let after = rest.trim_start();
    let mixed =
        number(after.strip_prefix('-').unwrap_or(after)).and_then(|(over, rest)| fraction(rest, over));
    match mixed {
        Some((part, unit)) if first.fract() == 0.0 && rest.starts_with([' ', '-']) => {
            Some((sign * (first + part), unit))
        }
        _ => Some((sign * first, rest.trim().to_owned())),
    }
}

/// A number without sign at the beginning of a text, with a decimal point or comma, and the rest.
fn number(text: &str) -> Option<(f64, &str)> {
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',');
    let mut end = text.find(|c: char| !digits(c)).unwrap_or(text.len());
    // An exponent belongs to the number only with its digits.
    if let Some(tail) = text[end..].strip_prefix(['e', 'E']) {
        let signed = tail.strip_prefix(['+', '-']).unwrap_or(tail);
        let count = signed.find(|c: char| !c.is_ascii_digit()).unwrap_or(signed.len());
        if count > 0 {
            end = text.len() - signed.len() + count;
        }
    }
    let shown = text[..end].to_owned();
    // Thousands are not separated: one comma is a decimal one, more are no number.
    let shown = if shown.contains('.') { shown } else { shown.replacen(',', ".", 1) };
    Some((shown.parse().ok()?, &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_as_shops_write_them() {
        for (text, mm) in [
            ("6.0000 mm", 6.0),
            ("6", 6.0),
            ("5,0 mm", 5.0),
            ("0,25 in", 6.35),
            ("1/4 in", 6.35),
            ("1/4\"", 6.35),
            ("1 1/4\"", 31.75),
            ("1-1/4 in", 31.75),
            ("3 / 8 inch", 9.525),
            ("0.375 \"", 9.525),
            ("1\u{a0}1/2\u{202f}″", 38.1),
            ("2 cm", 20.0),
            ("1e-3 m", 1.0),
            ("500 µm", 0.5),
            ("1 ft", 304.8),
            ("250 thou", 6.35),
            ("-1/4 in", -6.35),
            (".5in", 12.7),
        ] {
            let found = length_mm(text).unwrap_or_else(|| panic!("{text}"));
            assert!((found - mm).abs() < 1e-9, "{text}: {found}");
        }
        for text in
            ["", "six", "1,000.5 mm", "1.2.3", "1,2,3 mm", "1/0 in", "1/4/2 in", "6 kg", "1.5 1/4 in", "/4"]
        {
            assert_eq!(length_mm(text), None, "{text}");
        }
        assert_eq!(angle_deg("6 °"), Some(6.0));
        assert_eq!(angle_deg("2,5 deg"), Some(2.5));
        assert_eq!(angle_deg("5 mm"), None);
    }
}
