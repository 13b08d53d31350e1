//! The tools of a library that are left out, in few lines: libraries hold thousands.

/// Tools with one reason up to which each has a line of its own, or is named in theirs.
const NAMED: usize = 3;
/// Maximum number of reasons that are listed separately.
const MAX_REASONS: usize = 12;
/// Maximum number of different remarks that are listed separately.
const MAX_LINES: usize = 20;

/// Tools that are left out, by reason, in the order of the file.
#[derive(Debug, Default)]
pub struct LeftOutTools {
    reasons: Vec<Reason>,
    /// Those with further reasons.
    others: usize,
}

#[derive(Debug)]
struct Reason {
    why: String,
    count: usize,
    /// The first of the tools.
    named: Vec<String>,
}

impl LeftOutTools {
    /// Adds the tool `shown`, and why it is left out.
    pub fn add(&mut self, shown: String, why: String) {
        let known = self.reasons.iter().position(|reason| reason.why == why);
        let index = match known {
            Some(index) => index,
            None if self.reasons.len() == MAX_REASONS => {
                self.others += 1;
                return;
            }
            None => {
                self.reasons.push(Reason { why, count: 0, named: Vec::new() });
                self.reasons.len() - 1
            }
        };
        let reason = &mut self.reasons[index];
        reason.count += 1;
        if reason.named.len() < NAMED {
            reason.named.push(shown);
        }
    }

    /// One line for each tool, or for each reason where many share it.
    pub fn notes(self) -> Vec<String> {
        let mut notes = Vec::new();
        for Reason { why, count, named } in self.reasons {
            if count <= NAMED {
                notes.extend(named.iter().map(|shown| format!("{shown} is left out: {why}")));
            } else {
                let named = named.join(", ");
                notes.push(format!("{count} tools are left out: {why} ({named}, …)"));
            }
        }
        if self.others > 0 {
            notes.push(format!("{} more tools are left out, each for a reason of its own", self.others));
        }
        notes
    }
}

/// Remarks on tools with these names, each with its text, in few lines: equal ones together.
pub fn in_few_lines<'t>(remarks: impl Iterator<Item = (String, &'t str)>) -> Vec<String> {
    let mut texts: Vec<(&str, usize, Vec<String>)> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for (tool, text) in remarks {
        let index = *known.entry(text).or_insert_with(|| {
            texts.push((text, 0, Vec::new()));
            texts.len() - 1
        });
        let (_, count, named) = &mut texts[index];
        *count += 1;
        if named.len() < NAMED {
            named.push(tool);
        }
    }
    let more = texts.len().saturating_sub(MAX_LINES);
    let mut lines = Vec::new();
    for (text, count, named) in texts.into_iter().take(MAX_LINES) {
        if count <= NAMED {
            lines.extend(named.iter().map(|tool| format!("tool {tool}: {text}")));
        } else {
            lines.push(format!("{count} tools ({}, …): {text}", named.join(", ")));
        }
    }
    if more > 0 {
        lines.push(format!("{more} more remarks: they stand with their tools"));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_tools_with_few_reasons_take_few_lines() {
        let mut left_out = LeftOutTools::default();
        left_out.add("tool 1".to_owned(), "it is broken".to_owned());
        for k in 2..1000 {
            left_out.add(format!("tool {k}"), "`drill` is not a mill".to_owned());
        }
        for k in 1000..1100 {
            left_out.add(format!("tool {k}"), format!("its diameter is -{k}"));
        }
        let notes = left_out.notes();
        assert_eq!(notes.len(), 13);
        assert_eq!(notes[0], "tool 1 is left out: it is broken");
        assert_eq!(notes[1], "998 tools are left out: `drill` is not a mill (tool 2, tool 3, tool 4, …)");
        assert_eq!(notes[12], "90 more tools are left out, each for a reason of its own");
    }

    #[test]
    fn equal_remarks_stand_in_one_line() {
        let texts: Vec<String> = (0..50).map(|k| format!("remark {k}")).collect();
        let many = (0..500).map(|k| (k.to_string(), "insert width assumed"));
        let lines = in_few_lines(many.chain(texts.iter().map(|text| ("7".to_owned(), text.as_str()))));
        assert_eq!(lines[0], "500 tools (0, 1, 2, …): insert width assumed");
        assert_eq!((lines.len(), lines[1].as_str()), (21, "tool 7: remark 0"));
        assert_eq!(lines[20], "31 more remarks: they stand with their tools");
    }
}
