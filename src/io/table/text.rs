//! Texts of names and values in TOML files.

/// Length of a name whose every such part may be mistyped once for it to be near to a known one.
const CHARS_PER_MISTAKE: usize = 3;
/// Largest number of known names that a message lists.
const MAX_LISTED: usize = 12;

/// The one of the `known` names with the smallest edit distance to `name`, the first of several, if it is
/// near enough to be what was meant: at most one mistake for every three characters.
fn nearest<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let name: Vec<char> = name.chars().take(64).flat_map(char::to_lowercase).collect();
    let distances = known.iter().map(|&candidate| (edit_distance(&name, candidate), candidate));
    let (distance, candidate) = distances.min_by_key(|(distance, _)| *distance)?;
    let length = name.len().max(candidate.chars().count());
    (distance <= (length / CHARS_PER_MISTAKE).max(1)).then_some(candidate)
}

/// ` (the nearest is …)` where one of the `known` names is near to `name`, else empty.
pub fn nearest_note(name: &str, known: &[&str]) -> String {
    nearest(name, known).map_or_else(String::new, |near| format!(" (the nearest is `{near}`)"))
}

/// What to do about an unknown `name`, a `kind` of thing such as "key": use one of the `known` names, or
/// remove it.
pub fn known_or_none(kind: &str, name: &str, known: &[&str]) -> String {
    match nearest(name, known) {
        Some(near) => format!("use `{near}`, the nearest known {kind}, or remove it"),
        None if (1..=MAX_LISTED).contains(&known.len()) => {
            format!("use one of `{}`, or remove it", known.join("`, `"))
        }
        None => "remove it".to_owned(),
    }
}

/// Optimal string alignment distance: characters that are missing, too many, wrong, or swapped with the next.
fn edit_distance(a: &[char], b: &str) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=a.len()).collect();
    let mut last = None;
    for (i, cb) in b.chars().enumerate() {
        let mut next = vec![i + 1; a.len() + 1];
        for (j, &ca) in a.iter().enumerate() {
            let changed = row[j] + usize::from(ca != cb);
            next[j + 1] = changed.min(next[j] + 1).min(row[j + 1] + 1);
            if j > 0 && last == Some(ca) && a[j - 1] == cb {
                next[j + 1] = next[j + 1].min(before[j - 1] + 1);
            }
        }
        (before, row) = (row, next);
        last = Some(cb);
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
        let distance = |a: &str, b| edit_distance(&a.chars().collect::<Vec<_>>(), b);
        assert_eq!([distance("kitten", "sitting"), distance("", "abc"), distance("abc", "")], [3, 3, 3]);
        assert_eq!([distance("stpe", "step"), distance("ba", "ab"), distance("ca", "abc")], [1, 1, 3]);
    }

    #[test]
    fn what_is_not_near_is_not_suggested() {
        let known = ["number", "diameter", "overhang"];
        assert_eq!(nearest("stpe", &["axis", "step"]), Some("step"), "swapped");
        assert_eq!(nearest("colour", &known), None);
        assert_eq!(nearest("", &known), None);
        assert_eq!(nearest_note("diametre", &known), " (the nearest is `diameter`)");
        assert_eq!(nearest_note("colour", &known), "");
        let help = known_or_none("key", "colour", &known);
        assert_eq!(help, "use one of `number`, `diameter`, `overhang`, or remove it");
        assert_eq!(known_or_none("key", "colour", &["x"; MAX_LISTED + 1]), "remove it");
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
