//! The tool library of the shop: what is open, what is searched and filtered, what is selected.

use std::path::PathBuf;

use crate::io::shop_tools::{LibraryTool, ToolLibrary};
use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::setup::{Setup, Tool};

use super::units::DisplayUnits;

/// Form of a cutter's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToolForm {
    /// Every form.
    #[default]
    Any,
    /// A sharp corner.
    Flat,
    /// A rounded corner.
    BullNose,
    /// A ball.
    Ball,
}

impl ToolForm {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Any, Self::Flat, Self::BullNose, Self::Ball];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Any => "All types",
            Self::Flat => "Flat end",
            Self::BullNose => "Bull nose",
            Self::Ball => "Ball end",
        }
    }

    /// The form of a tool.
    pub fn of(tool: &Tool) -> Self {
        match tool.corner_radius {
            corner if corner <= 0.0 => Self::Flat,
            corner if corner < tool.radius() - 1e-6 => Self::BullNose,
            _ => Self::Ball,
        }
    }
}

/// Least and greatest diameter that is not filtered, mm.
pub const ALL_DIAMETERS: [f64; 2] = [0.0, 1000.0];

/// A library with what is shown of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShopLibrary {
    /// Its file; `None` for the program's own tools.
    pub path: Option<PathBuf>,
    /// The library, edited.
    pub content: ToolLibrary,
    /// Text that the tools shown contain.
    pub search: String,
    /// Form of the tools shown.
    pub form: ToolForm,
    /// Diameters of the tools shown, mm.
    pub diameters: [f64; 2],
    /// Index of the selected tool.
    pub selected: Option<usize>,
}

impl Default for ShopLibrary {
    fn default() -> Self {
        let own = plunge_cutters().iter().chain(flank_cutters());
        let tools = own.map(|tool| LibraryTool { tool: tool.clone(), notes: Vec::new() }).collect();
        Self::new(None, ToolLibrary { tools, notes: Vec::new() })
    }
}

impl ShopLibrary {
    /// A library from a file.
    pub fn new(path: Option<PathBuf>, content: ToolLibrary) -> Self {
        let form = ToolForm::Any;
        Self { path, content, search: String::new(), form, diameters: ALL_DIAMETERS, selected: None }
    }

    /// Indices of the tools that search and filters leave.
    pub fn shown(&self, units: DisplayUnits) -> Vec<usize> {
        let words: Vec<String> = self.search.to_lowercase().split_whitespace().map(str::to_owned).collect();
        let fits = |tool: &Tool| {
            let text = describe(tool, units).to_lowercase();
            words.iter().all(|word| text.contains(word))
                && (self.form == ToolForm::Any || self.form == ToolForm::of(tool))
                && (self.diameters[0]..=self.diameters[1]).contains(&tool.diameter)
        };
        let tools = self.content.tools.iter().enumerate();
        tools.filter(|(_, entry)| fits(&entry.tool)).map(|(index, _)| index).collect()
    }

    /// Puts a copy of the selected tool into `setup`, under a number of its own. Returns that number.
    pub fn take_into(&self, setup: &mut Setup) -> Option<u32> {
        let mut tool = self.content.tools.get(self.selected?)?.tool.clone();
        let taken = |number: u32| setup.tools.iter().any(|known| known.number == number);
        if tool.number == 0 || taken(tool.number) {
            tool.number = setup.tools.iter().map(|known| known.number).max().unwrap_or(0) + 1;
        }
        let number = tool.number;
        setup.tools.push(tool);
        Some(number)
    }
}

/// A tool in one line: what search looks through.
pub fn describe(tool: &Tool, units: DisplayUnits) -> String {
    let name = tool.assembly.name.as_deref().map_or(String::new(), |name| format!(" {name}"));
    let short = |mm: f64| units.short(mm, 3);
    let corner = match tool.corner_radius > 0.0 {
        true => format!(" R{}", short(tool.corner_radius)),
        false => String::new(),
    };
    let diameter = units.diameter(tool.diameter);
    format!("T{} {diameter}{corner} L{}{name}", tool.number, short(tool.overhang))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_and_filters_leave_what_fits_and_a_taken_tool_gets_a_free_number() {
        let mut library = ShopLibrary::default();
        let all = library.shown(DisplayUnits::Metric).len();
        assert!(all > 80, "the program's own tools");
        library.form = ToolForm::Ball;
        assert!(library.shown(DisplayUnits::Metric).iter().all(|&k| {
            let tool = &library.content.tools[k].tool;
            tool.corner_radius == tool.radius()
        }));
        (library.form, library.diameters) = (ToolForm::Any, [20.0, 25.0]);
        let between = library.shown(DisplayUnits::Metric);
        assert!(!between.is_empty() && between.len() < all);
        library.search = "Ø25 l125".to_owned();
        assert_eq!(library.shown(DisplayUnits::Metric).len(), 1);
        library.selected = library.shown(DisplayUnits::Metric).first().copied();
        let mut setup = Setup::default();
        let first = library.take_into(&mut setup).expect("a tool");
        let second = library.take_into(&mut setup).expect("a tool");
        assert_ne!(first, second);
        assert_eq!(setup.tools.len(), 2);
        library.search = "nothing like this".to_owned();
        assert!(library.shown(DisplayUnits::Metric).is_empty());
    }
}
