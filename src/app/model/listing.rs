//! The program of a plan as it is exported, with the line of each step of the timeline.

/// A program as text, with lines of its moves, and its times.
#[derive(Clone, Debug)]
pub struct ProgramListing {
    text: String,
    /// Where each line starts, bytes.
    starts: Vec<usize>,
    /// Line of the move that ends each step of the timeline, counted from 1.
    ends: Vec<Option<usize>>,
    /// Time from the start to the end of each step of the timeline, from feed rates and rapids, s.
    clock: Vec<f64>,
}

impl ProgramListing {
    /// The listing of `text`, whose lines `ends` (counted from 1) end the steps of the timeline after the
    /// times `clock`, s.
    pub fn new(text: String, ends: Vec<Option<usize>>, clock: Vec<f64>) -> Self {
        let after = text.match_indices('\n').map(|(at, _)| at + 1);
        let starts = std::iter::once(0).chain(after).filter(|&start| start < text.len()).collect();
        Self { text, starts, ends, clock }
    }

    /// Line at which the timeline stands after `cut` steps, counted from 1; `None`: after all. Before the
    /// first step it is the first line.
    pub fn line_after(&self, cut: Option<usize>) -> Option<usize> {
        match cut.unwrap_or(self.ends.len()).min(self.ends.len()) {
            0 => (!self.starts.is_empty()).then_some(1),
            count => self.ends.get(count - 1).copied().flatten(),
        }
    }

    /// Time of the program from its start to the end of its first `cut` steps, s; `None` past its end.
    pub fn time_after(&self, cut: usize) -> Option<f64> {
        cut.checked_sub(1).map_or(Some(0.0), |last| self.clock.get(last).copied())
    }

    /// Text of a line, counted from 1.
    pub fn line(&self, number: usize) -> Option<&str> {
        let index = number.checked_sub(1)?;
        let start = *self.starts.get(index)?;
        let end = self.starts.get(index + 1).copied().unwrap_or(self.text.len());
        self.text.get(start..end).map(str::trim_end)
    }

    /// The statement that begins at a line, with what `$` continues on the next ones.
    pub fn statement(&self, number: usize) -> String {
        let mut statement = String::new();
        for line in (number..).map_while(|number| self.line(number)) {
            match line.strip_suffix('$') {
                Some(begun) => statement += begun,
                None => {
                    statement += line;
                    break;
                }
            }
        }
        statement
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_lead_to_their_statements() {
        let text = "PARTNO a\nRAPID\nGOTO/1,$\n2\nFINI\n".to_owned();
        let listing = ProgramListing::new(text, vec![Some(3), None], vec![2.0, 2.5]);
        assert_eq!(listing.line_after(Some(0)), Some(1));
        assert_eq!(listing.line_after(Some(1)), Some(3));
        assert_eq!(listing.line_after(None), None, "a step without a move");
        assert_eq!(listing.statement(3), "GOTO/1,2");
        assert_eq!((listing.line(5), listing.line(6), listing.line(0)), (Some("FINI"), None, None));
        assert_eq!([0, 1, 2, 3].map(|cut| listing.time_after(cut)), [Some(0.0), Some(2.0), Some(2.5), None]);
        assert_eq!(ProgramListing::new(String::new(), Vec::new(), Vec::new()).line_after(None), None);
    }
}
