//! Comma-separated values by RFC 4180: fields with commas, quotes or line ends stand in quotes.

/// Maximum number of fields of a file.
const MAX_FIELDS: usize = 20_000_000;

/// Appends a record to `out`.
pub fn write_record<'a>(out: &mut String, fields: impl Iterator<Item = &'a str>) {
    for (place, field) in fields.enumerate() {
        if place > 0 {
            out.push(',');
        }
        if field.contains([',', '"', '\n', '\r']) {
            out.push('"');
            out.push_str(&field.replace('"', "\"\""));
            out.push('"');
        } else {
            out.push_str(field);
        }
    }
    out.push('\n');
}

/// A record: its line, from 1, and its fields.
pub type CsvRecord = (usize, Vec<String>);

/// The records of a file, each with its line; empty lines are left out.
///
/// # Errors
/// At a line where a quoted field is not closed, or holds text after its end, or beyond the limit of fields:
/// what is wrong.
pub fn records(text: &str) -> Result<Vec<CsvRecord>, (usize, String)> {
    let mut records = Vec::new();
    let mut fields: Vec<String> = Vec::new();
    let (mut line, mut first_line, mut count) = (1, 1, 0);
    let mut field = String::new();
    let mut characters = text.chars().peekable();
    let mut end = |fields: &mut Vec<String>, first: usize| {
        let record = std::mem::take(fields);
        if record.len() > 1 || record.first().is_some_and(|only| !only.is_empty()) {
            records.push((first, record));
        }
    };
    while let Some(character) = characters.next() {
        match character {
            '"' if field.is_empty() => {
                let opened = line;
                loop {
                    match characters.next() {
                        None => return Err((opened, "a quoted field has no end".to_owned())),
                        Some('"') if characters.next_if_eq(&'"').is_some() => field.push('"'),
                        Some('"') => break,
                        Some(inner) => {
                            line += usize::from(inner == '\n');
                            field.push(inner);
                        }
                    }
                }
                if characters.peek().is_some_and(|next| ![',', '\n', '\r'].contains(next)) {
                    return Err((line, "text follows a quoted field".to_owned()));
                }
            }
            ',' | '\n' => {
                count += 1;
                if count > MAX_FIELDS {
                    return Err((line, format!("there are more than {MAX_FIELDS} fields")));
                }
                fields.push(std::mem::take(&mut field));
                if character == '\n' {
                    end(&mut fields, first_line);
                    line += 1;
                    first_line = line;
                }
            }
            '\r' if characters.peek().is_none_or(|next| *next == '\n') => {}
            other => field.push(other),
        }
    }
    if !field.is_empty() || !fields.is_empty() {
        fields.push(field);
        end(&mut fields, first_line);
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let rows = [
            vec!["id", "a,b", "say \"no\"", ""],
            vec!["", "two\nlines", "cr\r\nlf", "end"],
            vec!["x", "\"", ",", "\n"],
        ];
        let mut text = String::new();
        rows.iter().for_each(|row| write_record(&mut text, row.iter().copied()));
        let back: Vec<Vec<String>> = records(&text).unwrap().into_iter().map(|(_, row)| row).collect();
        assert_eq!(back, rows);
        assert_eq!(
            records("a,b\r\n\r\n1,2").unwrap(),
            [(1, vec!["a".to_owned(), "b".to_owned()]), (3, vec!["1".to_owned(), "2".to_owned()])]
        );
        assert_eq!(records("a\n\"b\nc").unwrap_err().0, 2);
        assert_eq!(records("\"b\"c").unwrap_err().0, 1);
    }
}
