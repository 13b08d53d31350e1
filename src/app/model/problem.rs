//! Problems that are shown until they are dismissed or solved.

use super::field_faults::{FaultyField, FieldFault};
use super::file_purpose::Purpose;
use crate::error::ErrorCode;
use crate::gpu::GpuError;
use crate::io::InputError;
use crate::io::setup_file::SetupEntryFault;
use crate::report::words::as_sentence;

/// What a problem is about; decides what solves and replaces it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// The plunge plan: solved by the next plan.
    Plan,
    /// The flank plan: solved by the next flank plan.
    Flank,
    /// The checked program: solved by the next check.
    Program,
    /// What is faulty in an opened project: solved where its field is edited.
    Project,
    /// The project, which another window has open: solved when that closes it.
    SharedProject,
    /// The stock as a solid: solved by the next plan.
    Stock,
    /// A machine that was not taken: solved by the next that is; past with a plan without one.
    Machine,
    /// A file that was not opened: solved by the next that is.
    Opening,
    /// A file of this kind that was not written: solved by the next that is.
    Writing(&'static str),
    /// A remark that is not a fault: stays until it is dismissed.
    Note,
    /// Anything else: stays until it is dismissed.
    Other,
}

impl Topic {
    /// Whether it is about a calculation, of which only the last one counts.
    pub fn is_of_calculation(self) -> bool {
        !matches!(
            self,
            Self::Project | Self::SharedProject | Self::Opening | Self::Writing(_) | Self::Note | Self::Other
        )
    }
}

/// A problem shown until it is dismissed or solved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong, and where.
    pub message: String,
    /// What to do about it; may be empty.
    pub help: String,
    /// What it is about.
    pub topic: Topic,
    /// Its kind, where it is an error of the input.
    pub code: Option<ErrorCode>,
    /// What is shown at its field, too.
    pub field: Option<FieldFault>,
}

impl Problem {
    /// A problem that stays until it is dismissed.
    pub fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        let message = as_sentence(what.into());
        Self { message, help: help.into(), topic: Topic::Other, code: None, field: None }
    }

    /// A file that was not opened.
    pub fn of_opening(error: &InputError) -> Self {
        Self { topic: Topic::Opening, ..Self::from(error) }
    }

    /// A file that was not written.
    pub fn of_writing(purpose: Purpose, error: &InputError) -> Self {
        Self { topic: Topic::Writing(purpose.kind()), ..Self::from(error) }
    }

    /// A remark that is not a fault.
    pub fn note(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { topic: Topic::Note, ..Self::new(what, help) }
    }

    /// Whether it is a remark rather than a fault.
    pub fn is_note(&self) -> bool {
        self.topic == Topic::Note
    }

    /// The device that draws has failed.
    pub fn of_device(error: &GpuError) -> Self {
        Self::new(error.to_string(), "save the project and restart with VANECUT_GPU=software")
    }

    /// Files that were not opened.
    pub fn unopened(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { topic: Topic::Opening, ..Self::new(what, help) }
    }

    /// A problem of a calculation. Keys of setup files are replaced by the labels of their fields.
    pub fn about(topic: Topic, what: &str, help: &str) -> Self {
        let message = as_sentence(with_labels(what));
        Self { message, help: with_labels(help), topic, code: None, field: None }
    }

    /// The same problem with the code of its error.
    #[must_use]
    pub fn with_code(self, code: ErrorCode) -> Self {
        Self { code: Some(code), ..self }
    }

    /// The problem of a faulty value of a setup in a project file, in whose place the default stands.
    pub fn of_replaced(SetupEntryFault { error: fault, entry }: &SetupEntryFault) -> Self {
        let help = format!("{}; until then the default is used", fault.help);
        let problem = Self::about(Topic::Project, &format!("{}: {}", fault.place(), fault.message), &help);
        let field = entry.as_ref().and_then(FaultyField::of_entry);
        problem.with_code(fault.code).at_field(field, &fault.message)
    }

    /// The same problem, shown at its field, too: `what` is wrong there, without the place in a file.
    #[must_use]
    pub fn at_field(self, field: Option<FaultyField>, what: &str) -> Self {
        let text = || format!("{}; {}", with_labels(what), self.help);
        let field =
            field.map(|field| FieldFault { field, text: text(), is_default: self.topic == Topic::Project });
        Self { field, ..self }
    }

    /// Whether an edit of the setup may have caused it, so that undoing the edit may help.
    pub fn is_of_edit(&self) -> bool {
        matches!(self.topic, Topic::Plan | Topic::Flank)
    }

    /// Message and help in one line.
    pub fn text(&self) -> String {
        if self.help.is_empty() { self.message.clone() } else { format!("{}; {}", self.message, self.help) }
    }
}

impl From<&InputError> for Problem {
    fn from(error: &InputError) -> Self {
        let message = match error.place().as_str() {
            "" => error.message.clone(),
            place => format!("{place}: {}", error.message),
        };
        Self::new(message, error.help.clone()).with_code(error.code)
    }
}

/// A text without the signs of Markdown that messages of files have for the command line.
pub fn without_markdown(text: &str) -> String {
    text.replace('`', "")
}

/// Keys of setup files, with the labels of their fields.
const LABELS: [(&str, &str); 23] = [
    ("hub_allowance", "Hub allowance"),
    ("blade_allowance", "Blade allowance"),
    ("safety_distance", "Rapid clearance"),
    ("inlet_extension", "Inlet overhang"),
    ("blank", "Blank"),
    ("max_tilt", "Max tilt"),
    ("max_axis_tilt", "Max machine tilt"),
    ("max_axis_change", "Max axis change"),
    ("wall_scallop", "Wall scallop"),
    ("stepover", "Stepover"),
    ("layer_depth", "Layer depth"),
    ("scallop_height", "Scallop height"),
    ("lead_in_out", "Lead-in/out"),
    ("insert_width", "Insert width"),
    ("corner_radius", "Corner radius"),
    ("plunge_feed", "Feed rate"),
    ("diameter", "Diameter"),
    ("overhang", "Stick-out"),
    ("spindle", "Spindle speed"),
    ("cutting_direction", "Direction"),
    ("axis", "Axis strategy"),
    ("step", "Step"),
    ("rest", "Rest milling with smaller tools"),
];

/// `text` with the label of its field for each key of a setup file in backticks, and for each word that is a
/// key of more than one word.
fn with_labels(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        if end == 0 {
            let after = rest.chars().next().map_or(0, char::len_utf8);
            shown.push_str(&rest[..after]);
            rest = &rest[after..];
            continue;
        }
        let (word, after) = rest.split_at(end);
        let quoted = shown.ends_with('`') && after.starts_with('`');
        match LABELS.iter().find(|(key, _)| *key == word && (quoted || key.contains('_'))) {
            Some((_, label)) if quoted => {
                shown.pop();
                shown.push_str(&format!("\"{label}\""));
                rest = &after[1..];
            }
            Some((_, label)) => {
                shown.push_str(&format!("\"{label}\""));
                rest = after;
            }
            None => {
                shown.push_str(word);
                rest = after;
            }
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{as_sentence, with_labels};

    #[test]
    fn sentences_begin_with_a_capital_letter_and_names_stay() {
        for (text, shown) in [
            ("the wheel would be 100 m across", "The wheel would be 100 m across"),
            ("plunge.apt: cannot be read", "plunge.apt: cannot be read"),
            ("/tmp/a: cannot be read", "/tmp/a: cannot be read"),
            ("hub_allowance is 9", "hub_allowance is 9"),
            ("9 blades differ", "9 blades differ"),
            ("", ""),
        ] {
            assert_eq!(as_sentence(text.to_owned()), shown);
        }
    }

    #[test]
    fn keys_become_labels_and_words_stay() {
        for (text, shown) in [
            ("`blade_allowance` is 9, but", "\"Blade allowance\" is 9, but"),
            ("make hub_allowance smaller", "make \"Hub allowance\" smaller"),
            ("a step of `step`, α", "a step of \"Step\", α"),
            ("give more overhang", "give more overhang"),
            ("`unknown_key` stays", "`unknown_key` stays"),
        ] {
            assert_eq!(with_labels(text), shown);
        }
    }
}
