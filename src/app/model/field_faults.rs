//! Faults that belong to a field of the setup: they are shown there, too.

use crate::io::setup_file::{SetupEntry, SetupEntryFault};
use crate::setup::{Setup, SetupPlace};

/// Which of the forms of the window a field is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FieldScope {
    /// Those of the setup as a whole.
    #[default]
    Setup,
    /// That of flank milling.
    Flank,
    /// That of a tool of the setup, by its index.
    Tool(usize),
    /// That of a section of the setup, by its index.
    Section(usize),
}

/// The field of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FaultyField {
    /// Its form.
    pub scope: FieldScope,
    /// Its label; [`SECTION`] for every field of a section.
    pub label: &'static str,
}

/// A fault that is shown at its field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldFault {
    /// The field.
    pub field: FaultyField,
    /// What is wrong, and what to do.
    pub text: String,
    /// Whether the default stands in the field, which may be what is meant.
    pub is_default: bool,
}

/// A faulty value of the setup in a project file, in whose place the default stands.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplacedValue {
    /// What is wrong in the file.
    pub fault: SetupEntryFault,
    /// The same at its field, if it has one.
    pub field: Option<FieldFault>,
}

impl ReplacedValue {
    /// What the value is: its field, or else its place in the file.
    pub fn name(&self) -> String {
        let Some(FieldFault { field: FaultyField { scope, label }, .. }) = &self.field else {
            return self.fault.error.place();
        };
        match scope {
            FieldScope::Setup | FieldScope::Flank => (*label).to_owned(),
            FieldScope::Tool(index) => format!("{label} of tool entry {}", index + 1),
            FieldScope::Section(index) => format!("{label} {}", index + 1),
        }
    }
}

/// Label that stands for all fields of a section.
pub const SECTION: &str = "Section";

/// Table and key of each field of the setup, with its label.
const FIELDS: [(&str, &str, &str); 40] = [
    ("stock", "hub_allowance", "Hub allowance"),
    ("stock", "blade_allowance", "Blade allowance"),
    ("stock", "safety_distance", "Rapid clearance"),
    ("stock", "inlet_extension", "Inlet overhang"),
    ("stock", "blank", "Blank"),
    ("plunge", "axis", "Axis strategy"),
    ("plunge", "step", "Step"),
    ("plunge", "stepover", "Stepover"),
    ("plunge", "row_spacing", "Stepover"),
    ("plunge", "wall_scallop", "Wall scallop"),
    ("plunge", "max_axis_change", "Max axis change"),
    ("plunge", "max_tilt", "Max tilt"),
    ("plunge", "goal", "Goal"),
    ("plunge", "max_stock", "Goal"),
    ("plunge", "max_time", "Goal"),
    ("plunge", "finish_rate", "Goal"),
    ("plunge", "finish_depth", "Goal"),
    ("plunge", "finish_pass_time", "Goal"),
    ("plunge", "lead_out", "Lead-out"),
    ("plunge", "peck", "Peck depth"),
    ("plunge", "rapid_approach", "Rapid approach"),
    ("machine", "file", "Machine"),
    ("machine", "max_axis_tilt", "Max machine tilt"),
    ("flank", "tool", "Tool"),
    ("flank", "scheme", "Strategy"),
    ("flank", "layer_depth", "Layer depth"),
    ("flank", "scallop_height", "Scallop height"),
    ("flank", "allowed_error", "Scallop height"),
    ("flank", "extension", "Lead-in/out"),
    ("flank", "feed", "Feed rate"),
    ("flank", "slot_feed", "Slot feed"),
    ("flank", "wall_feed", "Wall feed"),
    ("flank", "ramp_feed", "Ramp feed"),
    ("flank", "approach_feed", "Approach feed"),
    ("tool", "diameter", "Diameter"),
    ("tool", "insert_width", "Insert width"),
    ("tool", "corner_radius", "Corner radius"),
    ("tool", "overhang", "Stick-out"),
    ("tool", "plunge_feed", "Feed rate"),
    ("tool", "spindle", "Spindle speed"),
];

fn label_of(table: &str, key: &str) -> Option<&'static str> {
    FIELDS.iter().find(|(of, name, _)| (*of, *name) == (table, key)).map(|(.., label)| *label)
}

impl FaultyField {
    /// The list of machines.
    pub const MACHINE: Self = Self { scope: FieldScope::Setup, label: "Machine" };

    /// The field of a faulty entry of a setup file; `None` where it has none.
    pub fn of_entry(entry: &SetupEntry) -> Option<Self> {
        let scope = match entry.table.as_str() {
            "plunge.section" => {
                return Some(Self { scope: FieldScope::Section(entry.index), label: SECTION });
            }
            "tool" => FieldScope::Tool(entry.index),
            "flank" => FieldScope::Flank,
            _ => FieldScope::Setup,
        };
        Some(Self { scope, label: label_of(&entry.table, entry.key.as_deref()?)? })
    }

    /// The field of a fault found in planning `setup`; `None` where it is of no single field.
    pub fn of_place(place: SetupPlace, setup: &Setup) -> Option<Self> {
        let tool = |number: u32| {
            let index = setup.tools.iter().position(|tool| tool.number == number)?;
            Some(Self { scope: FieldScope::Tool(index), label: "Diameter" })
        };
        match place {
            SetupPlace::Whole | SetupPlace::Part => None,
            SetupPlace::Stock(key) => Some(Self { scope: FieldScope::Setup, label: label_of("stock", key)? }),
            SetupPlace::Plunge(key) => {
                Some(Self { scope: FieldScope::Setup, label: label_of("plunge", key)? })
            }
            SetupPlace::Flank(key) => Some(Self { scope: FieldScope::Flank, label: label_of("flank", key)? }),
            SetupPlace::Tool(number) => tool(number),
            SetupPlace::Section { index, .. } if index < setup.plunge.sections.len() => {
                Some(Self { scope: FieldScope::Section(index), label: SECTION })
            }
            SetupPlace::Section { tool: number, .. } => tool(number),
        }
    }
}
