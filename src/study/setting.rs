//! Keys and values of a study: dotted paths into a setup, ranges, equality.

use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::source::{Source, quote_for_message, text};
use crate::io::table::Scalar;

/// Significant digits of the values of a range: enough for any setting, and 0.1 + 0.2 is 0.3.
const RANGE_DIGITS: usize = 12;
/// Longest path of a key.
const MAX_KEY_CHARS: usize = 100;

/// The key of an axis as a path in the setup, or `part`: `policy` is short for `plunge.axis`.
///
/// # Errors
/// When it cannot be a key that varies.
pub fn canonical_key(key: &str) -> Result<String, UserError> {
    let shown = quote_for_message(key);
    match key {
        "policy" => return Ok("plunge.axis".to_owned()),
        "part" => return Ok(key.to_owned()),
        _ => {}
    }
    if key.chars().count() > MAX_KEY_CHARS || key.split('.').any(str::is_empty) {
        let help = "give a path such as plunge.step, tool.1.diameter or stock.hub_allowance";
        let what = format!("{shown} is not the path of a key of a setup");
        return Err(UserError::new(ErrorCode::UnknownKey, what, help));
    }
    if matches!(key.split('.').next(), Some("flank" | "channels")) {
        let what = format!("{shown} does not change a plunge plan");
        let help = "vary keys of stock, tool, plunge or machine";
        return Err(UserError::new(ErrorCode::UnknownKey, what, help));
    }
    Ok(key.to_owned())
}

/// The values of a range: `[from, to, step]`, with `to` included where a step ends there.
///
/// # Errors
/// When these are not three numbers that make at least one and at most `most` values.
pub fn range_values(numbers: &[f64], most: usize) -> Result<Vec<Scalar>, UserError> {
    let &[from, to, step] = numbers else {
        let what = format!("the range has {} numbers", numbers.len());
        return Err(UserError::new(ErrorCode::ValueType, what, "give three: from, to, step"));
    };
    // A hundred-thousandth of a step may be missing at the end, for rounding.
    let steps = ((to - from) / step + 1e-5).floor();
    if !(steps >= 0.0 && step != 0.0) {
        let what = format!("no step of {step} leads from {from} to {to}");
        return Err(UserError::new(ErrorCode::ValueRange, what, "give from, to and a step towards it"));
    }
    if steps >= most as f64 {
        let what = format!("the range has {} values", steps + 1.0);
        return Err(UserError::new(ErrorCode::FileTooLarge, what, format!("give at most {most}")));
    }
    let whole = numbers.iter().all(|number| number.fract() == 0.0);
    let value = |k: usize| {
        let exact = from + step * k as f64;
        let digits = RANGE_DIGITS - 1;
        let rounded = format!("{exact:.digits$e}").parse().unwrap_or(exact);
        if whole { Scalar::Whole(rounded as i64) } else { Scalar::Number(rounded) }
    };
    Ok((0..=steps as usize).map(value).collect())
}

/// Whether two values mean the same: numbers by value, others exactly.
pub fn same_value(a: &Scalar, b: &Scalar) -> bool {
    let number = |value: &Scalar| match value {
        Scalar::Whole(whole) => Some(*whole as f64),
        Scalar::Number(number) => Some(*number),
        _ => None,
    };
    match (number(a), number(b)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

/// The tables of a setup file that was checked before.
///
/// # Errors
/// When the bytes are not TOML.
pub fn setup_tree(name: &str, bytes: &[u8]) -> Result<toml::Table, InputError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Ok(toml::Table::new());
    }
    text(Source::new(name, ErrorCode::StudyFile), bytes)?.parse().map_err(|error: toml::de::Error| {
        let what = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        InputError::new(ErrorCode::InvalidToml, name, 0, format!("invalid TOML: {what}"), "correct the line")
    })
}

/// Sets the key at a dotted path. Tables on the way are made where they are missing; `tool.N` is the tool of
/// number N, `N` in any other list its place from 1.
///
/// # Errors
/// When the path leads through a value, or to a tool or place that is not there.
pub fn set_in_setup(setup: &mut toml::Table, key: &str, value: &Scalar) -> Result<(), UserError> {
    let mut names: Vec<&str> = key.split('.').collect();
    let Some(last) = names.pop() else { return Ok(()) };
    let blocked = |name: &str| {
        let what = format!("{}: `{name}` is a value, not a table", quote_for_message(key));
        UserError::new(ErrorCode::UnknownKey, what, "correct the path")
    };
    let mut table = setup;
    let mut rest = names.into_iter().peekable();
    while let Some(name) = rest.next() {
        let is_list = rest.peek().is_some_and(|next| next.bytes().all(|byte| byte.is_ascii_digit()));
        if !table.contains_key(name) && !is_list {
            table.insert(name.to_owned(), toml::Value::Table(toml::Table::new()));
        }
        table = match table.get_mut(name) {
            Some(toml::Value::Table(inner)) => inner,
            Some(toml::Value::Array(list)) => entry(list, name, rest.next(), key)?,
            Some(_) => return Err(blocked(name)),
            None => return Err(no_entry(key, name, rest.next().unwrap_or_default())),
        };
    }
    if matches!(table.get(last), Some(toml::Value::Table(_) | toml::Value::Array(_))) {
        let what = format!("{} is not a single value", quote_for_message(key));
        let help = "name a key in it, such as plunge.step or tool.1.diameter";
        return Err(UserError::new(ErrorCode::UnknownKey, what, help));
    }
    let value = match value {
        Scalar::Flag(flag) => toml::Value::Boolean(*flag),
        Scalar::Whole(whole) => toml::Value::Integer(*whole),
        Scalar::Number(number) => toml::Value::Float(*number),
        Scalar::Text(text) => toml::Value::String(text.clone()),
    };
    table.insert(last.to_owned(), value);
    Ok(())
}

fn no_entry(key: &str, list: &str, number: &str) -> UserError {
    let header = if list == "tool" { "[[tool]]".to_owned() } else { format!("[[…{list}]]") };
    let what =
        format!("{}: the base setup has no {list} {}", quote_for_message(key), quote_for_message(number));
    let help = format!("add a {header} to the base setup, or name one that it has");
    UserError::new(ErrorCode::UnknownKey, what, help)
}

/// The table in a list that a path names.
fn entry<'s>(
    list: &'s mut [toml::Value],
    name: &str,
    number: Option<&str>,
    key: &str,
) -> Result<&'s mut toml::Table, UserError> {
    let Some(number) = number else {
        let what = format!("{}: `{name}` is a list", quote_for_message(key));
        let help = format!("name an entry of it, such as {name}.1.KEY");
        return Err(UserError::new(ErrorCode::UnknownKey, what, help));
    };
    let fault = || no_entry(key, name, number);
    let wanted: i64 = number.parse().map_err(|_| fault())?;
    let number_of = |(place, value): (i64, &toml::Value)| {
        let given = value.get("number").and_then(toml::Value::as_integer).filter(|_| name == "tool");
        given.unwrap_or(place)
    };
    let index = (1..).zip(list.iter()).position(|entry| number_of(entry) == wanted).ok_or_else(fault)?;
    list.get_mut(index).and_then(toml::Value::as_table_mut).ok_or_else(fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_end_where_a_step_does() {
        let shown = |numbers: &[f64]| {
            range_values(numbers, 1000)
                .map(|values| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))
        };
        assert_eq!(shown(&[0.1, 0.7, 0.2]).unwrap(), "0.1 0.3 0.5 0.7");
        assert_eq!(shown(&[20.0, 31.0, 5.0]).unwrap(), "20 25 30");
        assert_eq!(shown(&[3.0, 1.0, -1.0]).unwrap(), "3 2 1");
        assert_eq!(shown(&[3.0, 3.0, 1.0]).unwrap(), "3");
        for bad in [&[1.0, 2.0][..], &[1.0, 2.0, 0.0], &[2.0, 1.0, 1.0], &[0.0, 1.0, 1e-6], &[0.0, 0.0, 0.0]]
        {
            assert!(shown(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn paths_lead_to_tools_by_number_and_to_sections_by_place() {
        let base =
            "[[tool]]\nnumber = 7\ndiameter = 30\n[[tool]]\ndiameter = 16\n[[plunge.section]]\ntool = 7\n";
        let set = |key: &str| {
            let mut tree: toml::Table = base.parse().unwrap();
            set_in_setup(&mut tree, key, &Scalar::Number(1.5)).map(|()| tree)
        };
        assert_eq!(set("tool.7.diameter").unwrap()["tool"][0]["diameter"].as_float(), Some(1.5));
        assert_eq!(set("tool.2.overhang").unwrap()["tool"][1]["overhang"].as_float(), Some(1.5));
        assert_eq!(set("plunge.section.1.to").unwrap()["plunge"]["section"][0]["to"].as_float(), Some(1.5));
        assert_eq!(set("stock.hub_allowance").unwrap()["stock"]["hub_allowance"].as_float(), Some(1.5));
        for (bad, words) in [
            ("tool.1.diameter", "no tool `1`"),
            ("tool.x.diameter", "no tool `x`"),
            ("tool.diameter", "such as tool.1"),
            ("tool", "not a single value"),
            ("plunge", "not a single value"),
            ("plunge.section", "not a single value"),
            ("machine.1.max_axis_tilt", "no machine `1`"),
            ("tool.7.diameter.x", "is a value"),
        ] {
            let error = set(bad).expect_err(bad).to_string();
            assert!(error.contains(words), "{bad}: {error}");
        }
    }
}
