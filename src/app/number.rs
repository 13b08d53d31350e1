//! Parser of typed numbers: arithmetic (`30/4`), trailing units, decimal comma. Recursive descent over sum,
//! product and atom.

/// Value of `text`. Trailing letters and unit signs (`mm`, `°`) are ignored without conversion. `None` if it
/// is not a finite number.
pub fn parse(text: &str) -> Option<f64> {
    let text = text.trim().trim_end_matches(|c: char| c.is_alphabetic() || "°%/ ".contains(c));
    let text = text.replace(',', ".").replace('−', "-");
    let mut rest = text.as_bytes();
    let value = sum(&mut rest, 0)?;
    (rest.is_empty() && value.is_finite()).then_some(value)
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
            let (digits, after) = rest.split_at(length);
            *rest = after;
            std::str::from_utf8(digits).ok()?.parse().ok()
        }
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
    use super::parse;

    #[test]
    fn typed_numbers() {
        for (text, value) in [
            ("8", 8.0),
            (" 30/4 ", 7.5),
            ("30/4 mm", 7.5),
            ("2,5mm", 2.5),
            ("-12.5°", -12.5),
            ("−3", -3.0),
            ("1+2*3", 7.0),
            ("(1+2)*3", 9.0),
            ("-(2-5)", 3.0),
            ("300 mm/min", 300.0),
        ] {
            assert_eq!(parse(text), Some(value), "{text:?}");
        }
    }

    #[test]
    fn no_numbers() {
        for text in ["", "mm", "1/0", "1..2", "(1", "1)", "1e999", "auto", "--", "€", &"(".repeat(10_000)] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }
}
