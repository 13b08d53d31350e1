//! A checked program: its figures, its faults as a list that leads to their places, and the verdict line.

use egui::{Button, ComboBox, Grid, Label, Panel, RichText, ScrollArea, Ui};

use super::verdict::figure;
use crate::app::model::checked::{CheckedProgram, ProgramFinding};
use crate::app::model::figures::format_duration;
use crate::app::model::state::AppState;
use crate::app::views::theme::Condition;
use crate::io::machine_file::built_in_names;

/// Maximum number of faults that are listed.
const MAX_LISTED: usize = 500;

/// The worst verdict on a program.
fn condition(checked: &CheckedProgram) -> Condition {
    match (checked.findings.is_empty(), checked.is_complete) {
        (false, _) => Condition::Interfering,
        (true, false) => Condition::Blocked,
        (true, true) => Condition::Sound,
    }
}

/// Draws the verdict line.
pub fn verdict(ui: &mut Ui, state: &AppState) {
    let Some(checked) = &state.results.checked else {
        ui.label(RichText::new("No program is checked yet").weak());
        return;
    };
    if state.program_is_stale() {
        let text = RichText::new("Out of date:").color(Condition::Blocked.text(ui.visuals()));
        ui.label(text).on_hover_text("The setup was edited after this check");
    }
    let colour = condition(checked).text(ui.visuals());
    let text = RichText::new(format!("Faults {}", checked.findings.len())).strong().color(colour);
    ui.label(text).on_hover_text(&checked.summary);
    for (name, value, tip) in &checked.figures {
        ui.separator();
        figure(ui, name, value.clone(), tip);
    }
    ui.separator();
    let tip = "Of the whole program, from feed rates and rapids; without tool changes";
    figure(ui, "Time", format_duration(checked.time), tip);
}

/// Draws what was checked.
pub fn form(ui: &mut Ui, state: &mut AppState) {
    ui.horizontal(|ui| {
        let label = ui.label("NC machine");
        let machine = &mut state.look.check_machine;
        let list = ComboBox::from_id_salt("check machine").selected_text(machine.as_str());
        let list = list.show_ui(ui, |ui| {
            for name in built_in_names() {
                ui.selectable_value(machine, name.to_owned(), name);
            }
        });
        let tip = "The machine that NC code was posted for: its control, axes and limits. APT needs none";
        list.response.labelled_by(label.id).on_hover_text(tip);
    });
    let Some(checked) = &state.results.checked else { return };
    let path = checked.request.path.display().to_string();
    ui.add(Label::new(RichText::new(checked.name()).strong()).truncate()).on_hover_text(path);
    ui.label(checked.kind);
    Grid::new("program figures").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        for (name, value, tip) in &checked.figures {
            ui.label(RichText::new(*name).weak()).on_hover_text(*tip);
            ui.label(value);
            ui.end_row();
        }
    });
    for note in &checked.notes {
        ui.add(Label::new(RichText::new(note).weak()).wrap());
    }
}

/// Draws the list of faults; a click selects a fault and zooms to it.
pub fn faults(ui: &mut Ui, state: &mut AppState) {
    let Some(checked) = state.results.checked.clone() else {
        ui.label(RichText::new("Faults").strong());
        ui.label(RichText::new("No program is checked yet").weak());
        return;
    };
    let selected = state.look.finding;
    if let Some(finding) = selected.and_then(|k| checked.findings.get(k)) {
        let frame = egui::Frame::new().inner_margin(egui::Margin::symmetric(0, 4));
        Panel::bottom("selected fault").resizable(false).frame(frame).show(ui, |ui| details(ui, finding));
    }
    ui.label(RichText::new("Faults").strong());
    if checked.findings.is_empty() {
        ui.label(RichText::new("No faults").color(condition(&checked).text(ui.visuals())));
        return;
    }
    ui.add(Label::new(&checked.summary).wrap());
    ui.separator();
    let mut clicked = None;
    ScrollArea::vertical().id_salt("faults").auto_shrink(false).show(ui, |ui| {
        for (k, finding) in checked.findings.iter().enumerate().take(MAX_LISTED) {
            let place =
                if finding.fault.line > 0 { format!("Line {}: ", finding.fault.line) } else { String::new() };
            let text = format!("{place}{}", finding.fault.message);
            let button = Button::selectable(selected == Some(k), text).wrap().frame_when_inactive(false);
            let left = egui::Layout::top_down_justified(egui::Align::LEFT);
            let response = ui.with_layout(left, |ui| ui.add(button)).inner;
            if selected == Some(k) && state.look.fly {
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
        ui.add(Label::new(RichText::new(&finding.text).monospace()).wrap());
    }
    if let Some(place) = &finding.place {
        let (p, a) = (place.tip, place.axis);
        ui.label(format!("Tip {:.3} {:.3} {:.3} mm", p.x, p.y, p.z));
        ui.label(format!("Axis {:.4} {:.4} {:.4}, tool Ø{:.2}", a.x, a.y, a.z, 2.0 * place.radius));
    }
    if !finding.fault.help.is_empty() {
        ui.add(Label::new(format!("To do: {}", finding.fault.help)).wrap());
    }
}
