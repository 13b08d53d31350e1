//! Texts of names and values in TOML files.

/// The first of the `known` names with the smallest edit distance to `name`.
pub fn nearest<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let name: Vec<char> = name.chars().take(64).flat_map(char::to_lowercase).collect();
    known.iter().copied().min_by_key(|candidate| edit_distance(&name, candidate))
}

/// Levenshtein distance, with one row of the table.
fn edit_distance(a: &[char], b: &str) -> usize {
    let mut row: Vec<usize> = (0..=a.len()).collect();
    for (i, cb) in b.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        if let Some(first) = row.first_mut() {
            *first = left;
        }
        for (ca, above) in a.iter().zip(row.iter_mut().skip(1)) {
            let least = (diagonal + usize::from(*ca != cb)).min(left + 1).min(*above + 1);
            diagonal = *above;
            *above = least;
            left = least;
        }
    }
    row.last().copied().unwrap_or_default()
}

/// A string as a TOML basic string, with quotes.
pub fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// An angle in rad as the shortest number of degrees that reads back as the same angle, or the nearest
/// one if none does (not every f64 is a product with π/180).
pub fn degrees_text(rad: f64) -> String {
    let exact = rad.to_degrees();
    let short = (1..=15).map(|digits| format!("{exact:.digits$}"));
    let close = [exact, exact.next_up(), exact.next_down()].map(|degrees| format!("{degrees:?}"));
    short
        .chain(close)
        .find(|text| text.parse::<f64>().is_ok_and(|degrees| degrees.to_radians() == rad))
        .unwrap_or_else(|| format!("{exact:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_by_edit_distance() {
        assert_eq!(nearest("diametr", &["number", "diameter", "overhang"]), Some("diameter"));
        assert_eq!(nearest("STEP", &["axis", "step"]), Some("step"));
        assert_eq!(edit_distance(&"kitten".chars().collect::<Vec<_>>(), "sitting"), 3);
        assert_eq!(edit_distance(&[], "abc"), 3);
    }

    #[test]
    fn degrees_are_short_and_exact() {
        assert_eq!(degrees_text(5f64.to_radians()), "5.0");
        assert_eq!(degrees_text(22.5f64.to_radians()), "22.5");
        for k in 0..2000 {
            let rad = (f64::from(k) * 0.037).to_radians();
            let back = degrees_text(rad).parse::<f64>().unwrap().to_radians();
            assert_eq!(back, rad, "angle {k} must survive");
        }
    }
}
