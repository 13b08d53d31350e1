//! The tool library of the shop: search, filter, look at, edit, take into the setup, save.

use std::path::PathBuf;

use egui::{ComboBox, Id, Rect, RichText, TextEdit, Ui};

use crate::app::model::library_state::LibraryState;
use crate::app::model::number::Quantity;
use crate::app::model::problem::without_markdown;
use crate::app::model::shop_library::{ALL_DIAMETERS, ShopLibrary, ToolForm, describe};
use crate::app::views::command::Command;
use crate::app::views::list_keys;
use crate::app::views::scroll_area;
use crate::app::views::theme::Condition;
use crate::app::views::typed::{self, TypedLimits};
use crate::app::views::{tool_drawing, tool_form, units};
use crate::setup::{Setup, Tool};

/// Width of the list, and its least and greatest height, points.
const LIST_WIDTH: f32 = 280.0;
const LIST_HEIGHT: (f32, f32) = (275.0, 560.0);
/// Height of the window of the program that the list leaves to what is around it, points.
const AROUND_LIST: f32 = 260.0;
/// Least height of the form of a tool beside the list, and greatest height of the one below the list, points.
const MIN_FORM: f32 = 75.0;
const DOCKED_FORM: f32 = 400.0;
/// Height of the list where the tool stands below it, points.
const LOW_LIST: f32 = 160.0;
/// Width of list and tool side by side, points.
const WIDTH: f32 = 600.0;

/// What was asked for in the panel.
pub enum LibraryAnswer {
    /// A command: open or save.
    Command(Command),
    /// A tool was taken into the setup: what that did.
    Taken(String),
}

/// The setup that tools are taken into.
pub struct TakingSetup<'a> {
    /// The setup.
    pub setup: &'a mut Setup,
    /// The tools that the program chose for it; empty where it chooses none, or has not done so yet.
    pub chosen: &'a [Tool],
}

/// The panel, with the library while it was open once.
#[derive(Default)]
pub struct LibraryPanel {
    library: Option<ShopLibrary>,
}

impl LibraryPanel {
    /// Takes a library that was read.
    pub fn take(&mut self, library: ShopLibrary) {
        self.library = Some(library);
    }

    /// Whether the library was edited since it was opened or saved.
    pub fn is_unsaved(&self) -> bool {
        self.library.as_ref().is_some_and(ShopLibrary::is_unsaved)
    }

    /// Records that the library was written to `path`; see [`ShopLibrary::note_saved`].
    pub fn note_saved(&mut self, path: PathBuf, given: LibraryState, written: LibraryState) {
        if let Some(library) = &mut self.library {
            library.note_saved(path, given, written);
        }
    }

    /// Notes edits, for undo; call once per frame. `time` in seconds.
    pub fn watch(&mut self, time: f64) {
        if let Some(library) = &mut self.library {
            library.watch(time);
        }
    }

    /// Undoes its last edit.
    pub fn undo(&mut self) {
        if let Some(library) = &mut self.library {
            library.undo();
        }
    }

    /// Redoes the edit that was undone last.
    pub fn redo(&mut self) {
        if let Some(library) = &mut self.library {
            library.redo();
        }
    }

    /// The library.
    pub fn library(&self) -> Option<&ShopLibrary> {
        self.library.as_ref()
    }

    /// Least width, points.
    pub const MIN_WIDTH: f32 = 270.0;

    /// Draws it; returns what was asked for. `setup`: of the open part, if there is one. `is_docked`: it has
    /// the width of its place, in which list and tool may have to stand one below the other.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        setup: Option<TakingSetup>,
        is_docked: bool,
    ) -> Option<LibraryAnswer> {
        // It begins with the program's own tools.
        let library = self.library.get_or_insert_default();
        let mut answer = None;
        head(ui, library, &mut answer);
        ui.separator();
        if is_docked && ui.available_width() < WIDTH {
            filters(ui, library);
            list(ui, library, LOW_LIST);
            ui.separator();
            selected(ui, library, setup, None, &mut answer);
            return answer;
        }
        // As high as the window of the program allows: a tool has many fields.
        let (least, most) = LIST_HEIGHT;
        let height = (ui.ctx().content_rect().height() - AROUND_LIST).clamp(least, most);
        ui.horizontal_top(|ui| {
            let bottom = ui.vertical(|ui| {
                ui.set_width(LIST_WIDTH);
                filters(ui, library);
                list(ui, library, height);
                ui.cursor().top()
            });
            ui.separator();
            ui.vertical(|ui| {
                ui.set_width(300.0);
                selected(ui, library, setup, Some(bottom.inner), &mut answer);
            });
        });
        answer
    }
}

/// What undoes or redoes an edit of a library.
type Step = fn(&mut ShopLibrary);

/// The file, and the buttons to open and save.
fn head(ui: &mut Ui, library: &mut ShopLibrary, answer: &mut Option<LibraryAnswer>) {
    ui.horizontal_wrapped(|ui| {
        for command in [Command::OpenLibrary, Command::SaveLibrary] {
            if ui.button(command.label()).on_hover_text(command.tip()).clicked() {
                *answer = Some(LibraryAnswer::Command(command));
            }
        }
        let steps: [(&str, bool, Step); 2] = [
            ("Undo", library.can_undo(), ShopLibrary::undo),
            ("Redo", library.can_redo(), ShopLibrary::redo),
        ];
        for (name, is_possible, step) in steps {
            let button = ui.add_enabled(is_possible, egui::Button::new(name));
            if button.on_hover_text("Of the last edit of the library").clicked() {
                step(library);
            }
        }
        let (name, tip) = match &library.path {
            Some(path) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                (name, path.display().to_string())
            }
            None => ("The program's own tools".to_owned(), "Edits are kept in a file of yours".to_owned()),
        };
        let mark = if library.is_unsaved() { " • not saved" } else { "" };
        let label = egui::Label::new(RichText::new(format!("{name}{mark}")).weak()).extend();
        ui.add(label).on_hover_text(tip);
        let notes = &library.content().notes;
        if !notes.is_empty() {
            let word = if notes.len() == 1 { "remark" } else { "remarks" };
            let label = ui.label(RichText::new(format!("{} {word}", notes.len())).weak());
            // Of thousands of entries they are written when they are asked for.
            label.on_hover_ui(|ui| drop(ui.label(without_markdown(&notes.join("\n")))));
        }
    });
}

fn filters(ui: &mut Ui, library: &mut ShopLibrary) {
    ui.horizontal(|ui| {
        let label = ui.label("Search");
        let field = TextEdit::singleline(&mut library.search).hint_text("name, T, Ø, L").desired_width(200.0);
        ui.add(field).labelled_by(label.id);
    });
    let form = ui.scope_id();
    let fields = ui.horizontal(|ui| {
        ui.spacing_mut().interact_size.x = 46.0;
        let label = ui.label("Type");
        ComboBox::from_id_salt("tool type")
            .width(86.0)
            .selected_text(library.form.label())
            .show_ui(ui, |ui| {
                for form in ToolForm::ALL {
                    ui.selectable_value(&mut library.form, form, form.label());
                }
            })
            .response
            .labelled_by(label.id);
        diameters(ui, form, &mut library.diameters)
    });
    typed::show(ui, form, DIAMETERS, BOTH, fields.inner);
}

/// Name of the diameters shown, and value that the note on them goes by: two fields share a line below them.
const DIAMETERS: &str = "Diameters shown";
const BOTH: f64 = 0.0;

/// The fields of the least and the greatest diameter shown; returns their place.
fn diameters(ui: &mut Ui, form: Id, [least, most]: &mut [f64; 2]) -> Rect {
    let units = units::display_units(ui);
    let label = ui.label("Ø").on_hover_text(format!("{DIAMETERS}, {}", units.length_unit()));
    let [lowest, highest] = ALL_DIAMETERS;
    let show = |mm: f64| units.short(mm, 1);
    let mut at = Rect::NOTHING;
    let mut field = |ui: &mut Ui, value: &mut f64, range, why: (&str, &str)| {
        let (why_least, why_most) = why;
        let quantity = Quantity::Length;
        let limits = TypedLimits { quantity, units, range, why_least, why_most, show: &show };
        let (field, typed) = typed::limited_field(ui, value, &limits, 0.2);
        typed::keep(ui, form, DIAMETERS, BOTH, typed);
        at = at.union(field.labelled_by(label.id).rect);
    };
    let why_most = ", the greatest that is shown. For more, raise that first";
    let (low, high) = (*least, *most);
    field(ui, least, lowest..=high, ("", why_most));
    ui.label("to");
    let why_least = ", the least that is shown. For less, lower that first";
    field(ui, most, low..=highest, (why_least, ""));
    at
}

fn list(ui: &mut Ui, library: &mut ShopLibrary, height: f32) {
    let units = units::display_units(ui);
    let count = library.shown(units).len();
    let all = library.content().tools.len();
    let text = if all == 1 { format!("{count} of one tool") } else { format!("{count} of {all} tools") };
    ui.label(RichText::new(text).weak());
    let row = ui.text_style_height(&egui::TextStyle::Button) + 6.0;
    let mut area = scroll_area(height).auto_shrink([false, false]);
    // The row that arrow keys have come to, which is scrolled to and gets the focus.
    let key = ui.scope_id().with("row of the keys");
    let reached: Option<Option<usize>> = ui.data_mut(|data| data.remove_temp(key));
    let reached = reached.flatten();
    if let Some(at) = reached {
        let top = at as f32 * (row + ui.spacing().item_spacing.y);
        let offset: f32 = ui.data(|data| data.get_temp(key.with("offset"))).unwrap_or_default();
        area = area.vertical_scroll_offset(offset.clamp((top + row - height).max(0.0), top));
    }
    let mut step = None;
    let shown = area.show_rows(ui, row, count, |ui, range| {
        let first = range.start;
        let shown: Vec<usize> = library.shown(units).get(range).unwrap_or_default().to_vec();
        for (k, index) in shown.into_iter().enumerate() {
            let at = first + k;
            let entry = &library.content().tools[index];
            let button =
                egui::Button::selectable(library.selected == Some(index), describe(&entry.tool, units));
            let button = button.truncate().min_size(egui::vec2(ui.available_width(), row - 4.0));
            let button = ui.push_id(at, |ui| ui.add(button)).inner;
            if button.clicked() {
                library.selected = Some(index);
            }
            if button.clicked() || reached == Some(at) {
                button.request_focus();
            }
            step = step.or(list_keys::moved(at, list_keys::step(ui, &button), count));
        }
    });
    ui.data_mut(|data| data.insert_temp(key.with("offset"), shown.state.clamped_offset().y));
    if let Some(at) = step {
        library.selected = library.shown(units).get(at).copied();
        ui.data_mut(|data| data.insert_temp(key, Some(at)));
        ui.ctx().request_repaint();
    }
}

/// The selected tool: remarks of its import, drawing, fields, and what can be done with it. The fields end at
/// `bottom`, if there is one.
fn selected(
    ui: &mut Ui,
    library: &mut ShopLibrary,
    mut taking: Option<TakingSetup>,
    bottom: Option<f32>,
    answer: &mut Option<LibraryAnswer>,
) {
    let Some(index) = library.selected.filter(|&index| index < library.content().tools.len()) else {
        ui.label(RichText::new("Select a tool to see its drawing").weak());
        return;
    };
    ui.horizontal(|ui| {
        if let Some(text) = take(ui, library, taking.as_mut()) {
            *answer = Some(LibraryAnswer::Taken(text));
        }
        if ui.button("Copy").on_hover_text("Adds a copy to the library, to be edited").clicked() {
            library.copy(index, units::display_units(ui));
        }
        if ui
            .button("Delete")
            .on_hover_text("Removes the tool from the library; undo brings it back")
            .clicked()
        {
            library.delete(index);
        }
    });
    let setup = taking.as_ref().map(|taking| &*taking.setup);
    let known = library.content().tools.get(index).map(|entry| numbers_in(setup, &entry.tool));
    let known = known.unwrap_or_default();
    // Always a line: one that appeared later would move the fields away from the pointer.
    let numbers: Vec<String> = known.iter().map(|number| format!("T{number}")).collect();
    let only = if setup.is_some_and(|setup| setup.tools.len() == 1) { ", its only tool" } else { "" };
    let text = match numbers.is_empty() {
        true => "Not in the setup".to_owned(),
        false => format!("In the setup as {}{only}", numbers.join(", ")),
    };
    ui.add(egui::Label::new(RichText::new(text).weak()).truncate());
    let Some(index) = library.selected else { return };
    let Some(entry) = library.content().tools.get(index).cloned() else { return };
    // Names of makers' tools are often too long for the list.
    let name = entry.tool.assembly.name.as_deref().map_or(String::new(), |name| format!(": {name}"));
    let heading = RichText::new(format!("Tool T{}{name}", entry.tool.number)).strong();
    ui.add(egui::Label::new(heading).truncate());
    let warn = Condition::Blocked.text(ui.visuals());
    for note in &entry.notes {
        ui.add(egui::Label::new(RichText::new(without_markdown(note)).color(warn)).wrap());
    }
    let mut tool = entry.tool.clone();
    // It stays while the fields scroll, so that an edit is seen.
    tool_drawing::show(ui, &tool);
    let height = bottom.map_or(DOCKED_FORM, |bottom| (bottom - ui.cursor().top()).max(MIN_FORM));
    scroll_area(height).id_salt("library tool").show(ui, |ui| {
        ui.push_id(("library tool", index), |ui| tool_form::show_fields(ui, &mut tool, None));
    });
    if tool != entry.tool {
        library.replace(index, tool);
    }
}

/// The button that takes the selected tool into the setup; returns what was done. Where the program chooses
/// the tools it asks first: a setup with a tool of its own has no others.
fn take(ui: &mut Ui, library: &ShopLibrary, taking: Option<&mut TakingSetup>) -> Option<String> {
    let name = "Take into setup";
    let tip = "Copies the tool into the setup of the open part";
    let Some(TakingSetup { setup, chosen }) = taking else {
        ui.add_enabled(false, egui::Button::new(name)).on_disabled_hover_text(tip);
        return None;
    };
    if !setup.tools.is_empty() {
        let number = ui.button(name).on_hover_text(tip).clicked().then(|| library.take_into(setup))??;
        return Some(format!("T{number} is in the setup"));
    }
    let menu = ui.menu_button(name, |ui| {
        let numbers: Vec<String> = chosen.iter().map(|tool| format!("T{}", tool.number)).collect();
        let beside = match numbers.len() {
            1 => "Add to the chosen tool".to_owned(),
            _ => "Add to the chosen tools".to_owned(),
        };
        let add = ui.add_enabled(!numbers.is_empty(), egui::Button::new(beside));
        let add =
            add.on_disabled_hover_text("They are not known yet: calculate first").on_hover_text(format!(
                "The tools of the setup are then {}, and this one; its sections are chosen from them",
                numbers.join(", ")
            ));
        if add.clicked() {
            setup.tools = chosen.to_vec();
            let number = library.take_into(setup)?;
            let with = numbers.join(", ");
            return Some(format!(
                "T{number} is in the setup with {with}; undo makes the tools automatic again"
            ));
        }
        let only = ui.button("Use only this tool");
        if only.on_hover_text("The program chooses no other tools for the setup").clicked() {
            let number = library.take_into(setup)?;
            return Some(format!(
                "T{number} is the only tool of the setup; undo makes the tools automatic again"
            ));
        }
        None
    });
    menu.response.on_hover_text("Copies the tool into the setup of the open part, whose tools are automatic");
    menu.inner.flatten()
}

/// Numbers under which `tool` is in `setup`: it may have got another one there, and other rates.
fn numbers_in(setup: Option<&Setup>, tool: &Tool) -> Vec<u32> {
    let tools = setup.map_or(&[][..], |setup| &setup.tools);
    let sizes = |of: &Tool| [of.diameter, of.corner_radius, of.insert_width, of.overhang];
    let is_it = |known: &&Tool| sizes(known) == sizes(tool) && known.assembly == tool.assembly;
    tools.iter().filter(is_it).map(|known| known.number).collect()
}
