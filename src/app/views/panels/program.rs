//! A checked program: its figures, its faults as a list that leads to their places, and the verdict line.

use egui::{Button, Grid, Label, Panel, RichText, ScrollArea, Ui};

use super::fields;
use super::figures::divided_figure;
use crate::app::model::checked::{CheckedProgram, ProgramFinding};
use crate::app::model::figures::format_duration;
use crate::app::model::number::with_minus_signs;
use crate::app::model::state::AppState;
use crate::app::views::theme::Condition;
use crate::app::views::units;
use crate::io::nc::built_in_posts;
use crate::report::words::as_sentence;

/// Maximum number of faults that are listed.
const MAX_LISTED: usize = 500;

/// The worst verdict on a program. One that was not checked since an edit is not known to be sound.
fn condition(state: &AppState, checked: &CheckedProgram) -> Condition {
    match (checked.findings.is_empty(), checked.is_complete && !state.program_is_stale()) {
        (false, _) => Condition::Interfering,
        (true, false) => Condition::Blocked,
        (true, true) => Condition::Sound,
    }
}

/// What stands where nothing is known of a program.
fn words_without_program(state: &AppState) -> &'static str {
    if state.results.check_is_running { "Checking…" } else { "No program is checked yet" }
}

/// Draws the verdict line.
pub fn verdict(ui: &mut Ui, state: &AppState) {
    let Some(checked) = &state.results.checked else {
        ui.label(RichText::new(words_without_program(state)).weak());
        return;
    };
    if let Some(why) = state.stale_check() {
        let text = RichText::new("Out of date:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text(why.words());
    }
    let colour = condition(state, checked).text(ui.visuals());
    let text = RichText::new(format!("Faults {}", checked.findings.len())).strong().color(colour);
    ui.label(text).on_hover_text(&checked.summary);
    for (name, value, tip) in &checked.figures {
        divided_figure(ui, name, value.text(state.look.units), tip);
    }
    let tip = match checked.machine_time {
        Some(_) => "Of the whole program, on the machine, with tool changes and accelerations",
        None => "Of the whole program, from feed rates and rapids; without tool changes and accelerations",
    };
    divided_figure(ui, "Time", format_duration(checked.time_s()), tip);
}

const MACHINE_TIP: &str = "The machine that NC code was posted for: its axes and limits. APT needs none";
const CONTROL_TIP: &str = "The control whose words the NC code is written in. APT needs none";
const POST_TIP: &str = "Reads the program with a post of your own, by which it was written (.toml)";
/// Entry of the list of controls for the one that the machine file names.
const OF_MACHINE: &str = "of the machine";

/// Draws what was checked; `true` where a post file is asked for.
pub fn form(ui: &mut Ui, state: &mut AppState) -> bool {
    let mut opens_post = false;
    Grid::new("check target").num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        let mut machine = state.check_machine().to_owned();
        fields::machine_row(ui, ("NC machine", MACHINE_TIP), &mut machine, &state.machines);
        if machine != state.check_machine() {
            state.look.check_machine = Some(machine);
        }
        let look = &mut state.look;
        let mut control = look.check_control.clone().unwrap_or_else(|| OF_MACHINE.to_owned());
        let controls = [OF_MACHINE].into_iter().chain(built_in_posts());
        fields::control_row(ui, ("NC control", CONTROL_TIP), &mut control, controls, |_| {});
        ui.label("");
        opens_post = ui.button("Post file…").on_hover_text(POST_TIP).clicked();
        ui.end_row();
        look.check_control = Some(control).filter(|control| control != OF_MACHINE);
    });
    let Some(checked) = &state.results.checked else { return opens_post };
    if let Some(words) = state.results.program_file.words() {
        let text = RichText::new(words).color(Condition::Blocked.text(ui.visuals()));
        ui.add(Label::new(text).wrap());
    }
    let path = checked.request.path.display().to_string();
    ui.add(Label::new(RichText::new(checked.name()).strong()).truncate()).on_hover_text(path);
    ui.label(checked.kind);
    Grid::new("program figures").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        for (name, value, tip) in &checked.figures {
            ui.label(RichText::new(*name).weak()).on_hover_text(*tip);
            ui.label(value.text(state.look.units));
            ui.end_row();
        }
    });
    for note in &checked.notes {
        ui.add(Label::new(RichText::new(as_sentence(note.clone())).weak()).wrap());
    }
    opens_post
}

/// Draws the list of faults; a click selects a fault and zooms to it.
pub fn faults(ui: &mut Ui, state: &mut AppState) {
    let Some(checked) = state.results.checked.clone() else {
        ui.label(RichText::new("Faults").strong());
        ui.label(RichText::new(words_without_program(state)).weak());
        return;
    };
    let selected = state.look.finding;
    if let Some(finding) = selected.and_then(|k| checked.findings.get(k)) {
        let frame = egui::Frame::new().inner_margin(egui::Margin::symmetric(0, 4));
        Panel::bottom("selected fault").resizable(false).frame(frame).show(ui, |ui| details(ui, finding));
    }
    ui.label(RichText::new("Faults").strong());
    if checked.findings.is_empty() {
        let words = match (state.program_is_stale(), checked.program.incomplete_words()) {
            (true, _) => "No faults, but out of date".to_owned(),
            (false, Some(words)) => format!("No faults, but the program {words}"),
            (false, None) => "No faults".to_owned(),
        };
        ui.label(RichText::new(words).color(condition(state, &checked).text(ui.visuals())));
        return;
    }
    ui.add(Label::new(&checked.summary).wrap());
    ui.separator();
    let reveal = state.look.reveal_finding > 0;
    state.look.reveal_finding = state.look.reveal_finding.saturating_sub(1);
    let mut clicked = None;
    ScrollArea::vertical().id_salt("faults").auto_shrink(false).show(ui, |ui| {
        // The selected one is there however many others come before it.
        let beyond = selected.filter(|k| *k >= MAX_LISTED);
        for k in (0..checked.findings.len().min(MAX_LISTED)).chain(beyond) {
            let Some(finding) = checked.findings.get(k) else { continue };
            let place =
                if finding.fault.line > 0 { format!("Line {}: ", finding.fault.line) } else { String::new() };
            let text = format!("{place}{}", finding.fault.message);
            let button = Button::selectable(selected == Some(k), with_minus_signs(&text)).wrap();
            let left = egui::Layout::top_down_justified(egui::Align::LEFT);
            let response = ui.with_layout(left, |ui| ui.add(button)).inner;
            response.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, selected == Some(k), &text)
            });
            if selected == Some(k) && reveal {
                response.scroll_to_me(None);
            }
            if response.clicked() {
                clicked = Some(k);
            }
        }
        let more = checked.findings.len().saturating_sub(MAX_LISTED);
        if more > 0 {
            ui.label(RichText::new(format!("and {more} more")).weak());
        }
    });
    if let Some(k) = clicked {
        state.select_finding((selected != Some(k)).then_some(k));
    }
}

/// The selected fault: its line as it is written, the tool, and what to do.
fn details(ui: &mut Ui, finding: &ProgramFinding) {
    if !finding.text.is_empty() {
        statement(ui, &finding.text);
    }
    if let Some(place) = &finding.place {
        let (p, a) = (place.tip, place.axis);
        let units = units::display_units(ui);
        let tip = [p.x, p.y, p.z].map(|mm| units.number(mm, 3)).join(" ");
        let diameter = units.number(2.0 * place.radius, 2);
        ui.label(with_minus_signs(&format!("Tip {tip} {}", units.length_unit())));
        let axis = format!("Axis {:.4} {:.4} {:.4}, tool Ø{diameter}", a.x, a.y, a.z);
        ui.label(with_minus_signs(&axis));
    }
    if !finding.fault.help.is_empty() {
        ui.add(Label::new(format!("Fix: {}", finding.fault.help)).wrap());
    }
}

/// A line of a program as it is written, in as many lines as it needs.
fn statement(ui: &mut Ui, text: &str) {
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let glyph = ui.fonts_mut(|fonts| fonts.glyph_width(&font, '0'));
    let columns = (ui.available_width() / glyph.max(1.0)) as usize;
    let lines = break_between_words(text, columns);
    let shown = ui.add(Label::new(RichText::new(lines).monospace()).extend());
    shown.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, text));
}

/// `text` in lines of at most `columns` characters that end after a comma, a slash or a space: no number is
/// parted from its sign. Only a longer word is parted.
fn break_between_words(text: &str, columns: usize) -> String {
    let columns = columns.max(1);
    let (mut lines, mut length) = (String::with_capacity(text.len() + 8), 0);
    for word in text.split_inclusive([',', '/', ' ']) {
        let count = word.chars().count();
        if length > 0 && length + word.trim_end().chars().count() > columns {
            lines.push('\n');
            length = 0;
        }
        for (k, c) in word.chars().enumerate() {
            if k > 0 && k % columns == 0 && count > columns {
                lines.push('\n');
            }
            lines.push(c);
        }
        length = if count > columns { count % columns } else { length + count };
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::break_between_words;

    #[test]
    fn no_number_is_parted_from_its_sign() {
        let text = "GOTO/12.345678,-3.593152,101.000000,0.000000,-0.707107,0.707107";
        for columns in 12..80 {
            let lines = break_between_words(text, columns);
            assert_eq!(lines.replace('\n', ""), text, "{columns}");
            assert!(lines.lines().all(|line| line.len() <= columns && !line.ends_with('-')), "{lines}");
        }
        assert_eq!(break_between_words("ABCDEFGH", 3), "ABC\nDEF\nGH", "a word too long for a line");
        assert_eq!(break_between_words("L X1 Y-2", 5), "L X1 \nY-2");
    }
}
