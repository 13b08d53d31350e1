//! Panel "Part": data of the open part, and the start page.

use std::path::{Path, PathBuf};

use egui::{Grid, RichText, Ui};

use crate::app::model::part_source::{PartSource, Sample};
use crate::app::model::state::{AppState, RecoveryCopy};
use crate::app::tasks::files::is_project;
use crate::app::views::command::Command;

/// Action that the panel requests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartAction {
    /// Run a command.
    Command(Command),
    /// Open this part.
    Open(PartSource),
    /// Open this file.
    OpenFile(PathBuf),
    /// Ask whether to discard a recovery copy.
    DiscardRecovery(PathBuf),
}

/// Draws the panel; returns the requested action.
pub fn show(ui: &mut Ui, state: &AppState, samples: &[Sample]) -> Option<PartAction> {
    let mut action = None;
    ui.horizontal(|ui| {
        let open = ui.button(Command::OpenPart.label());
        let tip = Command::OpenPart.tip_with_keys(ui.ctx());
        if open.on_hover_text(tip).clicked() {
            action = Some(PartAction::Command(Command::OpenPart));
        }
        ui.menu_button("Samples", |ui| {
            if let Some(source) = sample_buttons(ui, samples) {
                action = Some(PartAction::Open(source));
                ui.close();
            }
        });
    });
    let Some(part) = &state.document.part else { return action };
    let impeller = &part.impeller;
    let units = state.look.units;
    Grid::new("part facts").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        let mut fact = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.label(value);
            ui.end_row();
        };
        fact("Blades", blades(impeller.blade_count, impeller.splitters.len()));
        let (rim, eye) = (impeller.hub.point(1.0), impeller.shroud.point(0.0));
        fact("Outlet diameter", units.length(2.0 * rim.r, 1));
        fact("Eye diameter", units.length(2.0 * eye.r, 1));
        let tip = impeller.shroud.point(1.0);
        fact("Outlet height", units.length((tip.r - rim.r).hypot(tip.z - rim.z), 1));
    });
    action
}

/// "17" or "9 + 9 splitters".
fn blades(main: usize, splitters_per_pitch: usize) -> String {
    match splitters_per_pitch {
        0 => main.to_string(),
        n => format!("{main} + {} splitters", main * n),
    }
}

/// Name of a project among others: with as many of its folders as tell it from those of the same name.
pub fn name_in_list(path: &Path, all: &[PathBuf]) -> String {
    // A part often has the name of its project.
    let stem = |path: &Path| {
        let name = if is_project(path) { path.file_stem() } else { path.file_name() };
        name.unwrap_or_default().to_string_lossy().into_owned()
    };
    let folders = |path: &Path, count: usize| -> Vec<String> {
        let above = path.ancestors().skip(1).filter_map(Path::file_name).take(count);
        above.map(|name| name.to_string_lossy().into_owned()).collect()
    };
    let twins: Vec<&PathBuf> =
        all.iter().filter(|other| *other != path && stem(other) == stem(path)).collect();
    let depth = path.ancestors().count();
    let tells = |count: &usize| twins.iter().all(|other| folders(other, *count) != folders(path, *count));
    let mut named = folders(path, (0..depth).find(tells).unwrap_or(depth));
    named.reverse();
    match named.is_empty() {
        true => stem(path),
        false => format!("{} ({})", stem(path), named.join("/")),
    }
}

/// One button per sample part.
pub fn sample_buttons(ui: &mut Ui, samples: &[Sample]) -> Option<PartSource> {
    let mut chosen = None;
    for sample in samples {
        if ui.button(sample.name).on_hover_text(sample.about).clicked() {
            chosen = Some(PartSource::Sample(sample.name.to_owned()));
        }
    }
    chosen
}

/// Draws the start page in the middle of the window; returns the requested action.
pub fn empty_state(ui: &mut Ui, state: &AppState, samples: &[Sample]) -> Option<PartAction> {
    let mut action = None;
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.18).max(8.0));
        if let Some(source) = &state.opening {
            ui.label(format!("Opening {}…", source.shown()));
            return;
        }
        for RecoveryCopy { path, title, .. } in &state.recoverable {
            ui.label(RichText::new(format!("Unsaved changes of {title}")).strong());
            ui.horizontal(|ui| {
                // Both buttons under the middle of the title.
                let font = egui::TextStyle::Button.resolve(ui.style());
                let width_of = |text: &str| {
                    let galley =
                        ui.painter().layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::PLACEHOLDER);
                    galley.size().x + 2.0 * ui.spacing().button_padding.x
                };
                let width = width_of("Recover") + width_of("Discard") + ui.spacing().item_spacing.x;
                ui.add_space(((ui.available_width() - width) / 2.0).max(0.0));
                if ui.button("Recover").on_hover_text(path.display().to_string()).clicked() {
                    action = Some(PartAction::OpenFile(path.clone()));
                }
                if ui.button("Discard").clicked() {
                    action = Some(PartAction::DiscardRecovery(path.clone()));
                }
            });
            ui.add_space(10.0);
        }
        ui.heading("Drop a part here");
        ui.label(
            ".toml, .geomTurbo, TurboGrid .inf, .step, .glb, .gltf or .stl, with or without a setup; or a project or plan",
        );
        ui.add_space(10.0);
        for command in [Command::OpenPart, Command::OpenProject] {
            let button = ui.button(command.label());
            if button.on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
                action = Some(PartAction::Command(command));
            }
        }
        if !state.recents.is_empty() {
            ui.add_space(14.0);
            ui.label(RichText::new("Recent").weak());
            for path in state.recents.iter().take(4) {
                if ui.link(name_in_list(path, &state.recents)).on_hover_text(path.display().to_string()).clicked() {
                    action = Some(PartAction::OpenFile(path.clone()));
                }
            }
        }
        if samples.is_empty() {
            return;
        }
        ui.add_space(18.0);
        ui.label(RichText::new("Samples").weak());
        ui.add_space(4.0);
        for sample in samples {
            let text = RichText::new(sample.name).size(15.0);
            if ui.add(egui::Button::new(text).min_size([170.0, 28.0].into())).clicked() {
                action = Some(PartAction::Open(PartSource::Sample(sample.name.to_owned())));
            }
            ui.label(RichText::new(sample.about).weak().small());
            ui.add_space(4.0);
        }
    });
    action
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projects_of_one_name_are_distinguished_by_their_folders() {
        let all = ["/a/new/wheel.vanecut", "/a/old/wheel.vanecut", "/b/old/wheel.vanecut", "/b/pump.vanecut"];
        let all = all.map(PathBuf::from);
        let names: Vec<String> = all.iter().map(|path| name_in_list(path, &all)).collect();
        assert_eq!(names, ["wheel (new)", "wheel (a/old)", "wheel (b/old)", "pump"]);
    }
}
