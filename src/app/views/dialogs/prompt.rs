//! The window's own file dialog: folder, files that fit, name with ending check, and the question before a
//! file is replaced.

use std::ops::Range;
use std::path::{Path, PathBuf};

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Button, Color32, Event, Key, Modal, Modifiers, RichText, TextEdit, Ui};

use super::ReplacedCheck;
use crate::app::model::file_purpose::Purpose;
use crate::app::tasks::Repaint;
use crate::app::tasks::latest::Latest;
use crate::app::views::modal::{self, is_dismissed};
use crate::app::views::scroll_area;
use crate::app::views::theme::{self, Condition};
use crate::io::shop_tools::is_fusion_library;
use crate::report::words::as_sentence;

/// Maximum number of entries of a folder that are listed.
const MAX_ENTRIES: usize = 2000;

/// An entry of a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Entry {
    Folder(String),
    File(String),
}

/// Content of a folder; `None` where it cannot be read.
type Listing = Option<Vec<Entry>>;

/// Reads folders in the background: a folder may lie on a slow network.
pub(super) struct FolderReader(Latest<PathBuf, Listing>);

impl FolderReader {
    pub(super) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("folder", repaint, |folder: &PathBuf| list_folder(folder)))
    }

    /// Requests the content of a folder.
    pub(super) fn read(&mut self, folder: Option<&Path>) {
        self.0.request(folder.map(Path::to_owned));
    }

    pub(super) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }

    /// Content of `folder`; `None` until it is read.
    fn content(&self, folder: &Path) -> Option<&Listing> {
        self.0.answer().filter(|(known, _)| known == folder).map(|(_, listing)| listing)
    }
}

/// Folders and files of a folder without hidden ones, sorted by name.
fn list_folder(folder: &Path) -> Listing {
    let entries = std::fs::read_dir(folder).ok()?.flatten();
    let named = entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok().filter(|name| !name.starts_with('.'))?;
        let is_folder = entry.path().is_dir();
        Some(if is_folder { Entry::Folder(name) } else { Entry::File(name) })
    });
    let mut found: Vec<Entry> = named.take(MAX_ENTRIES).collect();
    found.sort();
    Some(found)
}

/// Answer of the dialog.
pub(super) enum PromptAnswer {
    Chosen(PathBuf),
    Cancelled,
}

/// The dialog.
pub(super) struct Prompt {
    purpose: Purpose,
    folder: PathBuf,
    /// Name or path as typed.
    name: String,
    /// Why the window asks itself; may be empty.
    reason: &'static str,
    /// File that exists and may be replaced, while that is asked.
    replacing: Option<PathBuf>,
    /// File that must not be replaced, and why.
    refused: Option<(PathBuf, String)>,
    fresh: bool,
    is_drawn: bool,
    /// Number of characters of the name that were typed before the dialog was there.
    typed_before: usize,
}

impl Prompt {
    pub(super) fn new(purpose: Purpose, name: String, folder: Option<&Path>, reason: &'static str) -> Self {
        let folder = folder.map_or_else(|| std::env::current_dir().unwrap_or_default(), Path::to_owned);
        let (replacing, refused, fresh, is_drawn, typed_before) = (None, None, true, false, 0);
        Self { purpose, folder, name, reason, replacing, refused, fresh, is_drawn, typed_before }
    }

    /// Whether it was drawn before, and its field takes what is typed.
    pub(super) fn is_drawn(&self) -> bool {
        self.is_drawn
    }

    /// Takes what was typed before it was there. As in the field it replaces the proposed name up to its
    /// ending.
    pub(super) fn begin_with(&mut self, typed: &str) {
        let ending: String = self.name.chars().skip(stem_length(&self.name)).collect();
        self.name = format!("{typed}{ending}");
        drop_doubled_ending(&mut self.name, self.purpose.filter().1);
        self.typed_before = typed.chars().count();
    }

    pub(super) fn purpose(&self) -> Purpose {
        self.purpose
    }

    /// Draws the dialog; returns its answer once.
    pub(super) fn show(
        &mut self,
        ui: &Ui,
        reader: &mut FolderReader,
        check: &ReplacedCheck<'_>,
    ) -> Option<PromptAnswer> {
        reader.read(Some(&self.folder));
        self.is_drawn = true;
        // Before the field takes the key. An Enter that is held is that of what opened the dialog.
        let (escape, enter) = ui.input_mut(|input| {
            let none = Modifiers::NONE;
            let is_held = |event: &Event| matches!(event, Event::Key { key: Key::Enter, repeat: true, .. });
            let holds_enter = input.events.iter().any(is_held);
            let enter = input.consume_key(none, Key::Enter) && !holds_enter;
            (input.consume_key(none, Key::Escape), enter)
        });
        if self.replacing.is_some() {
            return self.ask_replace(ui, escape, enter);
        }
        let (mut answer, mut go) = (None, enter);
        let modal = Modal::new(egui::Id::unique("file prompt")).show(ui.ctx(), |ui| {
            modal::fitting(ui, 440.0, |ui| {
                ui.label(RichText::new(self.purpose.title()).strong());
                if !self.reason.is_empty() {
                    ui.label(RichText::new(self.reason).weak());
                }
                self.folder_line(ui);
                self.entries(ui, reader);
                ui.horizontal(|ui| {
                    let label = ui.label("File");
                    let hint = self.purpose.filter().1.iter().map(|e| format!(".{e}")).collect::<Vec<_>>();
                    let field = TextEdit::singleline(&mut self.name).desired_width(f32::INFINITY);
                    let field = ui.add(field.hint_text(hint.join(", "))).labelled_by(label.id);
                    if field.changed() {
                        drop_doubled_ending(&mut self.name, self.purpose.filter().1);
                    }
                    if std::mem::take(&mut self.fresh) {
                        field.request_focus();
                        let (typed, stem) = (self.typed_before, stem_length(&self.name));
                        // What is typed goes on behind what was typed, or replaces the name up to its ending.
                        let selected = if typed > 0 { typed..typed } else { 0..stem };
                        self.typed_before = 0;
                        select(ui, field.id, selected);
                    } else if ui.memory(|memory| memory.focused().is_none()) {
                        // A click in the list takes it away, but what is typed is meant as a name.
                        field.request_focus();
                    }
                });
                let target = self.target();
                let problem = target.as_ref().err().filter(|text| !text.is_empty());
                let colour =
                    problem.map_or(Color32::TRANSPARENT, |_| Condition::Interfering.text(ui.visuals()));
                // An empty line otherwise, so that the buttons stay where they are.
                ui.label(RichText::new(problem.map_or(" ", String::as_str)).color(colour));
                ui.horizontal(|ui| {
                    let verb = if self.purpose.saves() { "Save" } else { "Open" };
                    go |= ui.add_enabled(target.is_ok(), Button::new(verb)).clicked();
                    if ui.button("Cancel").clicked() || escape {
                        answer = Some(PromptAnswer::Cancelled);
                    }
                });
            });
        });
        if answer.is_some() || is_dismissed(&modal) {
            return Some(PromptAnswer::Cancelled);
        }
        let path = go.then(|| self.target()).and_then(Result::ok)?;
        // A folder that was typed is entered.
        if path.is_dir() {
            self.enter(path);
            return None;
        }
        // Into a library of Fusion tools are added: it is asked about as that.
        let adds = self.purpose == Purpose::SaveLibrary && is_fusion_library(&path);
        if let Err(error) = check(self.purpose, &path) {
            let why = format!("{}: {}", as_sentence(error.message), error.help);
            self.refused = Some((path, why));
            return None;
        }
        if self.purpose.saves() && path.exists() && !adds {
            self.replacing = Some(path);
            return None;
        }
        Some(PromptAnswer::Chosen(path))
    }

    /// The folder with a button to its parent.
    fn folder_line(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let parent = self.folder.parent().map(Path::to_owned);
            let up = ui.add_enabled(parent.is_some(), Button::new("Up"));
            if let Some(parent) = parent.filter(|_| up.on_hover_text("To the parent folder").clicked()) {
                self.enter(parent);
            }
            let text = self.folder.display().to_string();
            let shown = end_that_fits(&text, |part| theme::width_of_text(ui, part) <= ui.available_width());
            ui.add(egui::Label::new(shown).truncate()).on_hover_text(text);
        });
    }

    /// Folders and fitting files whose names begin with what is typed.
    fn entries(&mut self, ui: &mut Ui, reader: &FolderReader) {
        let mut chosen = None;
        let typed = self.name.to_lowercase();
        // A complete name, as proposed when saving, hides nothing.
        let typed = if typed.contains(['.', '/']) { "" } else { typed.as_str() };
        let begins = |name: &str| name.to_lowercase().starts_with(typed);
        scroll_area(160.0).auto_shrink(false).show(ui, |ui| match reader.content(&self.folder) {
            None => {
                ui.label(RichText::new("Reading…").weak());
            }
            Some(None) => {
                ui.label(RichText::new("This folder cannot be read").weak());
            }
            Some(Some(entries)) => {
                for entry in entries {
                    let (name, text) = match entry {
                        Entry::Folder(name) => (name, format!("{name}/")),
                        Entry::File(name) if self.purpose.fits(Path::new(name)) => (name, name.clone()),
                        Entry::File(_) => continue,
                    };
                    if begins(name) && ui.selectable_label(*name == self.name, text).clicked() {
                        chosen = Some(entry.clone());
                    }
                }
            }
        });
        match chosen {
            Some(Entry::Folder(name)) => self.enter(self.folder.join(name)),
            Some(Entry::File(name)) => self.name = name,
            None => {}
        }
    }

    fn enter(&mut self, folder: PathBuf) {
        self.folder = folder;
        if !self.purpose.saves() || self.name.contains('/') {
            self.name.clear();
        }
        self.fresh = true;
    }

    /// The file that is named; a missing ending is added where one is required.
    ///
    /// # Errors
    /// What is wrong with the name, and what to do; empty while there is none.
    fn target(&self) -> Result<PathBuf, String> {
        let name = self.name.trim();
        if name.is_empty() {
            return Err(String::new());
        }
        let mut path = self.folder.join(in_home(name));
        if path.is_dir() {
            return Ok(path);
        }
        let endings = self.purpose.filter().1;
        if self.purpose.requires_ending() {
            match (path.extension(), endings.first()) {
                (None, Some(ending)) => {
                    path.set_extension(ending);
                }
                (Some(_), _) if !self.purpose.fits(&path) => {
                    let all: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
                    return Err(format!("The name must end in {}", all.join(" or ")));
                }
                _ => {}
            }
        }
        if let Some((_, why)) = self.refused.as_ref().filter(|(refused, _)| *refused == path) {
            return Err(why.clone());
        }
        if self.purpose.saves() {
            let folder = path.parent().unwrap_or(Path::new(""));
            if !folder.is_dir() {
                return Err(format!("The folder {} does not exist", folder.display()));
            }
        } else if !path.exists() {
            let what = if name.ends_with(std::path::is_separator) { "folder" } else { "file" };
            return Err(format!("The {what} {} does not exist", path.display()));
        }
        Ok(path)
    }

    /// The question before a file is replaced.
    fn ask_replace(&mut self, ui: &Ui, escape: bool, enter: bool) -> Option<PromptAnswer> {
        let path = self.replacing.clone()?;
        let (mut replace, mut back) = (false, escape);
        let modal = Modal::new(egui::Id::unique("file replace")).show(ui.ctx(), |ui| {
            modal::fitting(ui, 360.0, |ui| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                ui.label(RichText::new(format!("Replace {name}?")).strong());
                ui.label(format!("It already exists in {}", self.folder_of(&path)));
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    replace = ui.button("Replace").clicked();
                    back |= ui.button("Cancel").clicked() || enter;
                });
            });
        });
        if replace {
            return Some(PromptAnswer::Chosen(path));
        }
        if back || is_dismissed(&modal) {
            self.replacing = None;
            self.fresh = true;
        }
        None
    }

    fn folder_of(&self, path: &Path) -> String {
        path.parent().unwrap_or(&self.folder).display().to_string()
    }
}

/// A typed name; `~` at its beginning is the home folder, as in a terminal.
fn in_home(name: &str) -> PathBuf {
    let rest =
        name.strip_prefix('~').filter(|rest| rest.is_empty() || rest.starts_with(std::path::is_separator));
    match rest.zip(std::env::home_dir()) {
        Some((rest, home)) => home.join(rest.trim_start_matches(std::path::is_separator)),
        None => PathBuf::from(name),
    }
}

/// The path `text`, shortened at its beginning until it fits: the last folders show where the user is. `fits`
/// tells whether a text is short enough.
fn end_that_fits(text: &str, fits: impl Fn(&str) -> bool) -> String {
    if fits(text) {
        return text.to_owned();
    }
    let ends = text.char_indices().filter(|(_, c)| std::path::is_separator(*c)).map(|(at, _)| at);
    let shorter: Vec<String> = ends.skip(1).map(|at| format!("…{}", &text[at..])).collect();
    let fitting = shorter.iter().find(|end| fits(end)).or(shorter.last());
    fitting.cloned().unwrap_or_else(|| text.to_owned())
}

/// Drops one of two equal `endings` of a name: the ending stays behind what is typed, and may be typed, too.
fn drop_doubled_ending(name: &mut String, endings: &[&str]) {
    for ending in endings {
        let ending = format!(".{ending}");
        if name.ends_with(&ending.repeat(2)) {
            name.truncate(name.len() - ending.len());
        }
    }
}

/// Number of characters of a name before its ending.
fn stem_length(name: &str) -> usize {
    Path::new(name).file_stem().map_or(0, |stem| stem.to_string_lossy().chars().count())
}

/// Selects characters in the field `id`: what is typed replaces them.
fn select(ui: &Ui, id: egui::Id, characters: Range<usize>) {
    let mut state = TextEditState::load(ui.ctx(), id).unwrap_or_default();
    let range = CCursorRange::two(CCursor::new(characters.start), CCursor::new(characters.end));
    state.cursor.set_char_range(Some(range));
    state.store(ui.ctx(), id);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilde_is_the_home_folder() {
        let home = std::env::home_dir().expect("a home");
        assert_eq!(in_home("~"), home);
        assert_eq!(in_home("~/parts/a.toml"), home.join("parts/a.toml"));
        assert_eq!(in_home("~a.toml"), PathBuf::from("~a.toml"));
    }

    #[test]
    fn an_ending_that_is_typed_is_not_doubled() {
        for (typed, name) in
            [("p.apt.apt", "p.apt"), ("p.apt", "p.apt"), ("p.cl.apt", "p.cl.apt"), ("papt.apt", "papt.apt")]
        {
            let mut now = typed.to_owned();
            drop_doubled_ending(&mut now, &["apt", "cl"]);
            assert_eq!(now, name, "{typed}");
        }
    }

    #[test]
    fn a_long_path_keeps_its_end() {
        let shown = |path: &str| end_that_fits(path, |text| text.chars().count() <= 16);
        assert_eq!(shown("/data/parts"), "/data/parts");
        assert_eq!(shown("/data/customers/wheels/2026-11"), "…/wheels/2026-11");
        assert_eq!(shown("/data/a-name-that-is-much-too-long"), "…/a-name-that-is-much-too-long");
    }
}
