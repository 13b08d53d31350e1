//! The tool library of the shop: what is open, what is searched and filtered, what is selected.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use crate::io::shop_tools::{LibraryTool, ToolLibrary};
use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::setup::{Setup, Tool};

use super::history::History;
use super::library_state::LibraryState;
use super::setup_tools::take_for_material;
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
    pub fn from_tool(tool: &Tool) -> Self {
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
#[derive(Clone, Debug)]
pub struct ShopLibrary {
    /// Its file; `None` for the program's own tools.
    pub path: Option<PathBuf>,
    /// The library, edited.
    content: LibraryState,
    /// Text that the tools shown contain.
    pub search: String,
    /// Form of the tools shown.
    pub form: ToolForm,
    /// Diameters of the tools shown, mm.
    pub diameters: [f64; 2],
    /// Index of the selected tool.
    pub selected: Option<usize>,
    /// What was searched last, and what that left: libraries of makers have many thousand tools.
    found: Option<(SearchKey, Vec<usize>)>,
    /// What was searched last, whatever has changed in the tools since.
    searched: Option<SearchKey>,
    /// The library as it was opened or saved last.
    saved: LibraryState,
    history: History<LibraryState>,
}

/// What the tools shown depend on, besides the tools.
#[derive(Clone, Debug, PartialEq)]
struct SearchKey {
    search: String,
    form: ToolForm,
    diameters: [f64; 2],
    units: DisplayUnits,
}

impl Default for ShopLibrary {
    fn default() -> Self {
        let own = plunge_cutters().iter().chain(flank_cutters());
        let entry = |tool: &Tool| Arc::new(LibraryTool { tool: tool.clone(), notes: Vec::new() });
        Self::new(None, ToolLibrary { tools: own.map(entry).collect(), ..ToolLibrary::default() })
    }
}

impl ShopLibrary {
    /// A library from a file.
    pub fn new(path: Option<PathBuf>, content: ToolLibrary) -> Self {
        let (form, content) = (ToolForm::Any, LibraryState::from(content));
        let (saved, mut history) = (content.clone(), History::default());
        history.add(&content);
        let search = String::new();
        let (diameters, selected, found, searched) = (ALL_DIAMETERS, None, None, None);
        Self { path, content, search, form, diameters, selected, found, searched, saved, history }
    }

    /// The library, edited.
    pub fn content(&self) -> &LibraryState {
        &self.content
    }

    /// Changes the library.
    fn edit(&mut self, change: impl FnOnce(&mut ToolLibrary)) {
        self.content.edit(&[Some(&self.saved), self.history.last()], change);
        // What is shown may have changed.
        self.found = None;
    }

    /// Puts another tool in the place of tool `index`. Rates that differ from those before are given from
    /// then on.
    pub fn replace(&mut self, index: usize, tool: Tool) {
        if index < self.content.tools.len() {
            self.edit(|library| Arc::make_mut(&mut library.tools[index]).replace(tool));
        }
    }

    /// A library with edits that are not saved.
    pub fn recovered(path: Option<PathBuf>, content: ToolLibrary) -> Self {
        Self { saved: ToolLibrary::default().into(), ..Self::new(path, content) }
    }

    /// Whether it was edited since it was opened or saved.
    pub fn is_unsaved(&self) -> bool {
        self.content != self.saved
    }

    /// Records that the library was written to `path` as `written`, when `given` was to be written: its tools
    /// get the numbers that they have there, unless they were edited meanwhile.
    pub fn note_saved(&mut self, path: PathBuf, given: LibraryState, written: LibraryState) {
        self.path = Some(path);
        if self.content == given && given != written {
            self.content = written.clone();
            self.found = None;
            self.history.add(&self.content);
        }
        self.saved = written;
    }

    /// Call once per frame: edits that have been stable for a while become undo steps. `time` in seconds.
    pub fn watch(&mut self, time: f64) {
        self.history.watch(time, &self.content);
    }

    /// Whether there is an edit to undo.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo(&self.content)
    }

    /// Whether there is an edit to redo.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo(&self.content)
    }

    /// When the edit was made that undo takes back, on the window's clock, s.
    pub fn changed_s(&self) -> Option<f64> {
        self.history.changed_s(&self.content)
    }

    /// Likewise for the one that redo makes again.
    pub fn undone_s(&self) -> Option<f64> {
        self.history.undone_s(&self.content)
    }

    /// Undoes the last edit.
    pub fn undo(&mut self) {
        if let Some(content) = self.history.undo(&self.content) {
            self.show(content);
        }
    }

    /// Redoes the last undone edit.
    pub fn redo(&mut self) {
        if let Some(content) = self.history.redo(&self.content) {
            self.show(content);
        }
    }

    /// Takes other tools, with the first one selected that differs.
    fn show(&mut self, content: LibraryState) {
        let differs = |k: &usize| match (self.content.tools.get(*k), content.tools.get(*k)) {
            (Some(a), Some(b)) => !Arc::ptr_eq(a, b) && a != b,
            (a, b) => a.is_some() || b.is_some(),
        };
        self.selected = (0..content.tools.len()).find(differs).or(self.selected);
        self.content = content;
        self.found = None;
    }

    /// Adds a copy of tool `index` under a number and offsets of its own, and selects it. A search that does
    /// not leave it ends.
    pub fn copy(&mut self, index: usize, units: DisplayUnits) {
        let Some(mut copy) = self.content.tools.get(index).map(|entry| LibraryTool::clone(entry)) else {
            return;
        };
        self.history.add(&self.content);
        copy.tool.number = self.content.free_number();
        // Those of the other tool, whatever they are; without them the number of the tool counts.
        (copy.tool.assembly.length_offset, copy.tool.assembly.diameter_offset) = (None, None);
        self.edit(|library| library.tools.push(Arc::new(copy)));
        let added = self.content.tools.len() - 1;
        if !self.search(units).contains(&added) {
            self.search.clear();
        }
        self.selected = Some(added);
        self.history.add(&self.content);
    }

    /// Removes tool `index`; undo brings it back.
    pub fn delete(&mut self, index: usize) {
        if index < self.content.tools.len() {
            self.history.add(&self.content);
            self.edit(|library| drop(library.tools.remove(index)));
            self.selected = None;
            self.history.add(&self.content);
        }
    }

    /// Indices of the tools that search and filters leave. Another search deselects a tool that it does not
    /// leave; one that is edited so that it no longer fits stays selected.
    pub fn shown(&mut self, units: DisplayUnits) -> &[usize] {
        let Self { form, diameters, .. } = *self;
        let key = SearchKey { search: self.search.clone(), form, diameters, units };
        let found = match self.found.take() {
            Some((known, found)) if known == key => found,
            _ => self.search(units),
        };
        if self.searched.as_ref() != Some(&key) {
            self.selected = self.selected.filter(|selected| found.binary_search(selected).is_ok());
            self.searched = Some(key.clone());
        }
        &self.found.insert((key, found)).1
    }

    fn search(&self, units: DisplayUnits) -> Vec<usize> {
        let words: Vec<String> = self.search.to_lowercase().split_whitespace().map(str::to_owned).collect();
        let fits = |tool: &Tool| {
            let has_words = || {
                let text = describe(tool, units).to_lowercase();
                words.iter().all(|word| text.contains(word))
            };
            (self.form == ToolForm::Any || self.form == ToolForm::from_tool(tool))
                && (self.diameters[0]..=self.diameters[1]).contains(&tool.diameter)
                && (words.is_empty() || has_words())
        };
        let tools = self.content.tools.iter().enumerate();
        tools.filter(|(_, entry)| fits(&entry.tool)).map(|(index, _)| index).collect()
    }

    /// Puts a copy of the selected tool into `setup`, with the rates that it lacks by the material of the
    /// setup. Where the setup has another tool of its number, it gets one that no tool of the setup or of the
    /// library has; where the setup has the same tool already, nothing is added. Returns its number.
    pub fn take_into(&self, setup: &mut Setup) -> Option<u32> {
        let entry = self.content.tools.get(self.selected?)?;
        let mut tool = entry.tool.clone();
        take_for_material(&mut tool, setup.allowances.cutting_data());
        // It may have got another number there, and its offsets with it.
        let is_it = |known: &&Tool| {
            let mut there = tool.clone();
            there.renumber(known.number);
            there == **known
        };
        if let Some(known) = setup.tools.iter().find(is_it) {
            return Some(known.number);
        }
        let taken = |number: u32| setup.tools.iter().any(|known| known.number == number);
        if tool.number == 0 || taken(tool.number) {
            let own = self.content.tools.iter().map(|entry| entry.tool.number);
            let own: HashSet<u32> = own.chain(self.content.other_numbers.iter().copied()).collect();
            let last = setup.tools.iter().map(|known| known.number).max().unwrap_or(0);
            tool.renumber((last + 1..).find(|number| !own.contains(number)).unwrap_or(last + 1));
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
    use crate::setup::MissingRates;

    #[test]
    fn search_and_filters_leave_what_fits_and_a_taken_tool_gets_a_free_number() {
        let mut library = ShopLibrary::default();
        let all = library.shown(DisplayUnits::Metric).len();
        assert!(all > 80, "the program's own tools");
        library.form = ToolForm::Ball;
        let balls = library.shown(DisplayUnits::Metric).to_vec();
        assert!(balls.iter().all(|&k| {
            let tool = &library.content.tools[k].tool;
            tool.corner_radius == tool.radius()
        }));
        (library.form, library.diameters) = (ToolForm::Any, [20.0, 25.0]);
        let between = library.shown(DisplayUnits::Metric).len();
        assert!(between > 0 && between < all);
        library.search = "Ø25 l125".to_owned();
        assert_eq!(library.shown(DisplayUnits::Metric).len(), 1);
        library.selected = library.shown(DisplayUnits::Metric).first().copied();
        let mut setup = Setup::default();
        let first = library.take_into(&mut setup).expect("a tool");
        assert_eq!(
            (library.take_into(&mut setup), setup.tools.len()),
            (Some(first), 1),
            "it is there already"
        );
        // Another tool of its number.
        setup.tools[0].overhang += 1.0;
        let second = library.take_into(&mut setup).expect("a tool");
        assert_ne!(first, second);
        let others = library.content().tools.iter().map(|entry| entry.tool.number);
        assert!(
            others.clone().any(|number| number == first) && !others.clone().any(|number| number == second)
        );
        assert_eq!(setup.tools.len(), 2);
        // Edited so that the search would not find it, it stays.
        let selected = library.selected.expect("selected");
        let tool = library.content().tools[selected].tool.clone();
        library.replace(selected, Tool { diameter: 21.0, ..tool });
        assert!(library.shown(DisplayUnits::Metric).is_empty());
        assert_eq!(library.selected, Some(selected));
        library.search = "nothing like this".to_owned();
        assert!(library.shown(DisplayUnits::Metric).is_empty());
        assert_eq!(library.selected, None, "what is not shown is neither taken nor deleted");
    }

    #[test]
    fn a_tool_without_rates_is_taken_with_those_of_the_material() {
        let mut library = ShopLibrary::default();
        library.edit(|library| {
            Arc::make_mut(&mut library.tools[0]).tool.assembly.missing_rates = MissingRates::ALL;
        });
        library.selected = Some(0);
        let mut setup = Setup::default();
        setup.allowances.material = Some("titanium".to_owned());
        library.take_into(&mut setup).expect("a tool");
        let data = setup.allowances.cutting_data().expect("known");
        let tool = &setup.tools[0];
        assert_eq!(tool.spindle, data.spindle_for(tool.diameter));
        assert_eq!(tool.plunge_feed, data.feed_per_tooth_for(tool.diameter) * 2.0 * tool.spindle);
    }

    #[test]
    fn a_tool_of_the_program_is_taken_with_its_rates_in_proportion_to_the_material() {
        let mut library = ShopLibrary { selected: Some(0), ..ShopLibrary::default() };
        let own = library.content().tools[0].tool.clone();
        let mut setup = Setup::default();
        library.take_into(&mut setup).expect("a tool");
        setup.allowances.material = Some("titanium".to_owned());
        let data = setup.allowances.cutting_data().expect("known");
        library.take_into(&mut setup).expect("a tool");
        let entered = Tool { spindle: own.spindle + 30.0, ..own.clone() };
        library.replace(0, entered.clone());
        library.take_into(&mut setup).expect("a tool");
        let rates = |tool: &Tool| (tool.spindle, tool.plunge_feed);
        let taken: Vec<_> = setup.tools.iter().map(rates).collect();
        assert_eq!(taken, [rates(&own), rates(&data.scaled_from_steel(&own)), rates(&entered)]);
    }

    #[test]
    fn what_is_given_is_no_longer_noted_as_assumed() {
        let mut library = ShopLibrary::default();
        let rates = "no plunge feed in the library: by `material` of the setup; without one 300 mm/min";
        let noted = ["insert width assumed: the cutter cuts to its centre", "another remark", rates];
        library.edit(|library| {
            let entry = Arc::make_mut(&mut library.tools[0]);
            entry.tool.insert_width = entry.tool.radius();
            entry.tool.assembly.missing_rates.plunge_feed = true;
            entry.notes = noted.map(str::to_owned).to_vec();
        });
        let tool = library.content().tools[0].tool.clone();
        let notes = |library: &ShopLibrary| library.content().tools[0].notes.clone();
        library.replace(0, Tool { spindle: 4000.0, ..tool.clone() });
        assert_eq!(notes(&library), noted);
        // Inserts that are cut to a smaller diameter, or that another one leaves, still reach the centre.
        let resized = |factor: f64| {
            let diameter = factor * tool.diameter;
            Tool { diameter, insert_width: tool.insert_width.min(0.5 * diameter), ..tool.clone() }
        };
        library.replace(0, resized(0.5));
        assert_eq!(notes(&library), noted);
        library.replace(0, Tool { diameter: tool.diameter, ..resized(0.5) });
        assert_eq!(notes(&library), noted);
        let now = &library.content().tools[0].tool;
        assert_eq!(now.insert_width, now.radius());
        library.replace(0, Tool { insert_width: 0.3 * tool.diameter, ..tool.clone() });
        assert_eq!(notes(&library), [noted[1], noted[2]]);
        let given = Tool { plunge_feed: 200.0, ..tool.with_given_rates() };
        library.replace(0, Tool { insert_width: 0.4 * tool.diameter, ..given });
        assert_eq!(notes(&library), ["another remark"]);
    }

    #[test]
    fn what_is_shown_follows_search_and_changes() {
        let mut library = ShopLibrary::default();
        let all = library.shown(DisplayUnits::Metric).len();
        library.copy(0, DisplayUnits::Metric);
        assert_eq!(library.shown(DisplayUnits::Metric).len(), all + 1);
        library.search = "t1 ".to_owned();
        let few = library.shown(DisplayUnits::Metric).len();
        assert!(few > 0 && few < all);
    }

    #[test]
    fn a_copy_is_in_the_list() {
        let mut library = ShopLibrary::default();
        let number = format!("t{} ", library.content().tools[40].tool.number);
        for (search, kept) in [("", ""), ("Ø", "Ø"), (&*number, "")] {
            library.search = search.to_owned();
            let first = library.shown(DisplayUnits::Metric)[0];
            library.copy(first, DisplayUnits::Metric);
            let added = library.content().tools.len() - 1;
            assert_eq!((library.selected, &*library.search), (Some(added), kept), "{search}");
            assert!(library.shown(DisplayUnits::Metric).contains(&added), "{search}");
            assert_eq!(library.selected, Some(added), "it stays selected");
        }
    }

    #[test]
    fn a_copy_has_a_free_number_and_no_offset_of_its_original() {
        let mut library = ShopLibrary::default();
        let last = library.content().tools.iter().map(|entry| entry.tool.number).max().expect("tools");
        library.edit(|library| {
            library.other_numbers.insert(last + 1);
            Arc::make_mut(&mut library.tools[0]).tool.assembly.length_offset = Some(107);
        });
        library.copy(0, DisplayUnits::Metric);
        let copy = &library.content().tools.last().expect("a copy").tool;
        assert_eq!((copy.number, copy.length_offset_number()), (last + 2, last + 2));
        // So has one that a setup takes beside another tool of its number.
        let mut own = library.content().tools[1].tool.clone();
        own.assembly.length_offset = Some(own.number);
        library.replace(1, own.clone());
        library.selected = Some(1);
        let mut setup = Setup { tools: vec![Tool { overhang: 33.0, ..own.clone() }], ..Setup::default() };
        let taken = library.take_into(&mut setup).expect("a tool");
        assert_eq!(setup.tools[1].length_offset_number(), taken);
        assert_ne!(taken, own.number);
        assert_eq!(
            (library.take_into(&mut setup), setup.tools.len()),
            (Some(taken), 2),
            "it is there already"
        );
    }

    #[test]
    fn tools_have_the_numbers_that_they_got_in_the_file() {
        let mut library = ShopLibrary::default();
        library.copy(0, DisplayUnits::Metric);
        let given = library.content().clone();
        let mut written = given.clone();
        written.edit(&[], |tools| Arc::make_mut(&mut tools.tools[0]).tool.renumber(4711));
        library.note_saved("shop.json".into(), given.clone(), written.clone());
        assert_eq!(library.content().tools[0].tool.number, 4711);
        assert!(!library.is_unsaved());
        // What was edited meanwhile stays, and is unsaved.
        library.delete(1);
        let edited = library.content().clone();
        library.note_saved("shop.json".into(), written.clone(), written);
        assert!(*library.content() == edited && library.is_unsaved());
    }

    #[test]
    fn an_edit_taken_back_by_hand_is_neither_unsaved_nor_a_step() {
        let mut library = ShopLibrary::default();
        let tool = library.content().tools[0].tool.clone();
        library.watch(0.0);
        library.replace(0, Tool { diameter: tool.diameter + 1.0, ..tool.clone() });
        library.watch(0.1);
        assert!(library.is_unsaved() && library.can_undo());
        library.replace(0, tool);
        library.watch(0.2);
        assert!(!library.is_unsaved() && !library.can_undo());
    }
}
