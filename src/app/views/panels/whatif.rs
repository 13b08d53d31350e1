//! Panel "Variants": stored setups with their figures.

use egui::{RichText, TextEdit, Ui};

use crate::io::project_file::SetFigures;
use crate::io::setup_file::write_full_setup;
use crate::setup::Setup;

use crate::app::model::figures::{INTERFERING_TIP, TimeUnits};
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::theme::Condition;
use crate::app::views::units;

/// Draws the table; returns the command that was pressed.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let keep = ui.button(Command::KeepSet.label());
    let chosen =
        keep.on_hover_text(Command::KeepSet.tip_with_keys(ui.ctx())).clicked().then_some(Command::KeepSet);
    if state.document.edited.sets.is_empty() {
        ui.label(RichText::new("Save a variant to compare setups").weak());
        return chosen;
    }
    let (mut used, mut removed, mut is_begun) = (None, None, false);
    let units = state.look.units;
    let stock_head = match units {
        DisplayUnits::Metric => "Stock mm",
        DisplayUnits::Inch => "Stock in",
    };
    let heads = [
        ("Pos.", "Number of plunges"),
        ("Interf.", INTERFERING_TIP),
        (stock_head, "Residual stock on the hub: mean and 95th percentile"),
        ("Wheel", WHEEL_TIP),
    ];
    row(ui, |ui, k| {
        let (head, tip) = heads[k];
        ui.label(RichText::new(head).weak()).on_hover_text(tip);
    });
    ui.label(RichText::new("Current setup").weak());
    let channels = state.document.part.as_ref().map_or(1, |part| part.impeller.blade_count);
    let edited = &mut state.document.edited;
    let shown = edited.sets.iter().map(|set| &set.setup).chain([&edited.setup]);
    let times =
        shown.filter_map(|setup| state.results.figures(setup)).map(|f| (f.time, wheel_time(&f, channels)));
    let times = TimeUnits::for_all(&times.collect::<Vec<_>>());
    cells(ui, state.results.figures(&edited.setup), channels, times);
    for (k, set) in edited.sets.iter_mut().enumerate() {
        ui.separator();
        ui.horizontal(|ui| {
            let field = ui.add(TextEdit::singleline(&mut set.name).desired_width(110.0));
            let name = format!("Name of variant {}", k + 1);
            field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, &name));
            is_begun |= field.gained_focus();
            field.on_hover_text(differences(&edited.setup, &set.setup));
            if small(ui, set.setup != edited.setup, "Load", &format!("Load {}", set.name)) {
                used = Some(k);
            }
            if small(ui, true, "×", &format!("Remove {}", set.name)) {
                removed = Some(k);
            }
        });
        cells(ui, state.results.figures(&set.setup), channels, times);
    }
    // What was done before is a step of its own.
    if is_begun || used.is_some() || removed.is_some() {
        state.document.step();
    }
    let edited = &mut state.document.edited;
    if let Some(set) = used.and_then(|k| edited.sets.get(k)) {
        (edited.setup, edited.replaced) = (set.setup.clone(), set.replaced.clone());
    }
    if let Some(k) = removed {
        edited.sets.remove(k);
    }
    chosen
}

fn small(ui: &mut Ui, enabled: bool, text: &str, name: &str) -> bool {
    let response = ui.add_enabled(enabled, egui::Button::new(text).small());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    response.on_hover_text(name).clicked()
}

const WHEEL_TIP: &str = "Time of all channels: on the machine with tool changes if the setup names one, else from feed rates \
     and rapids without them";

/// Widths of the columns, points; together they fit the panel.
const WIDTHS: [f32; 4] = [38.0, 44.0, 78.0, 48.0];

/// A row of the table, cell by cell.
fn row(ui: &mut Ui, mut cell: impl FnMut(&mut Ui, usize)) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (k, width) in WIDTHS.into_iter().enumerate() {
            let layout = egui::Layout::left_to_right(egui::Align::Center);
            ui.allocate_ui_with_layout(egui::vec2(width, 18.0), layout, |ui| {
                ui.set_min_width(width);
                cell(ui, k);
            });
        }
    });
}

/// Time of all channels, s.
fn wheel_time(figures: &SetFigures, channels: usize) -> f64 {
    // Older projects do not have it: links from channel to channel are then left out.
    figures.wheel_time.unwrap_or(figures.time * channels as f64)
}

fn cells(ui: &mut Ui, figures: Option<SetFigures>, channels: usize, times: TimeUnits) {
    let Some(f) = figures else {
        ui.label(RichText::new("Not calculated yet").weak()).on_hover_text("Load it to calculate it");
        return;
    };
    let of = if f.interferential == 0 { Condition::Sound } else { Condition::Interfering };
    row(ui, |ui, k| {
        let text = match k {
            0 => RichText::new(f.positions.to_string()),
            1 => RichText::new(f.interferential.to_string()).color(of.text(ui.visuals())),
            2 => RichText::new(units::display_units(ui).pair(f.residual_mean, f.residual_p95, 2)),
            _ => RichText::new(times.wheel.text(wheel_time(&f, channels))),
        };
        let label = ui.label(text);
        if k == 3 {
            label.on_hover_text(format!("{} per channel", times.channel.text(f.time)));
        }
    });
}

/// Differences of a variant from the current setup, as lines of a setup file.
fn differences(now: &Setup, set: &Setup) -> String {
    let (now, set) = (write_full_setup(now), write_full_setup(set));
    let new = |text: &str, other: &str| -> Vec<String> {
        let known: Vec<&str> = other.lines().collect();
        text.lines().filter(|line| line.contains('=') && !known.contains(line)).map(str::to_owned).collect()
    };
    let lines = new(&set, &now);
    match (lines.is_empty(), new(&now, &set).is_empty()) {
        (true, true) => "Same as the current setup".to_owned(),
        (true, false) => "Without additions of the current setup".to_owned(),
        _ => format!("Differs from the current setup:\n{}", lines.join("\n")),
    }
}
