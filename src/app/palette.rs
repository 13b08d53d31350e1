//! The command palette: search as you type over all commands.

use egui::{Align2, Key, Modal, RichText, ScrollArea, TextEdit, Ui};

use super::command::Command;

/// State of the command palette.
#[derive(Debug, Default)]
pub struct Palette {
    open: bool,
    words: String,
    chosen: usize,
    fresh: bool,
}

impl Palette {
    /// Opens or closes it.
    pub fn toggle(&mut self) {
        *self = Self { open: !self.open, fresh: true, ..Self::default() };
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Draws it while it is open; returns the chosen command. `can`: whether a command is available now.
    pub fn show(&mut self, ui: &Ui, can: impl Fn(Command) -> bool) -> Option<Command> {
        if !self.open {
            return None;
        }
        let mut run = None;
        let area = Modal::default_area(egui::Id::unique("palette")).anchor(Align2::CENTER_TOP, [0.0, 60.0]);
        let modal = Modal::new(egui::Id::unique("palette")).area(area).show(ui.ctx(), |ui| {
            ui.set_width(420.0);
            let (up, down, enter) = ui.input_mut(|i| {
                let none = egui::Modifiers::NONE;
                (
                    i.consume_key(none, Key::ArrowUp),
                    i.consume_key(none, Key::ArrowDown),
                    i.consume_key(none, Key::Enter),
                )
            });
            let hint = "Search commands";
            let field =
                ui.add(TextEdit::singleline(&mut self.words).hint_text(hint).desired_width(f32::INFINITY));
            field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, hint));
            if std::mem::take(&mut self.fresh) {
                field.request_focus();
            }
            if field.changed() {
                self.chosen = 0;
            }
            let found = find_commands(&self.words);
            if down {
                self.chosen = (self.chosen + 1).min(found.len().saturating_sub(1));
            }
            if up {
                self.chosen = self.chosen.saturating_sub(1);
            }
            if enter {
                run = found.get(self.chosen).copied().filter(|&command| can(command));
            }
            ui.add_space(4.0);
            if found.is_empty() {
                ui.label(RichText::new("No matching command").weak());
            }
            ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
                for (k, &command) in found.iter().enumerate() {
                    let response = command_line(ui, command, k == self.chosen, can(command));
                    if k == self.chosen && (up || down) {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        run = Some(command);
                    }
                }
            });
        });
        if run.is_some() || modal.should_close() {
            self.open = false;
        }
        run
    }
}

fn command_line(ui: &mut Ui, command: Command, chosen: bool, enabled: bool) -> egui::Response {
    let mut button =
        egui::Button::selectable(chosen, command.label()).min_size(egui::vec2(ui.available_width(), 0.0));
    if let Some(keys) = command.shortcut() {
        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
    }
    ui.add_enabled(enabled, button).on_hover_text(command.tip())
}

/// Commands whose label or tip contains every typed word. Those whose label starts with the first word come
/// first, then those whose label contains it.
fn find_commands(words: &str) -> Vec<Command> {
    let words: Vec<String> = words.to_lowercase().split_whitespace().map(str::to_owned).collect();
    let mut found: Vec<(usize, Command)> = Command::ALL
        .iter()
        .filter(|command| **command != Command::Palette)
        .filter_map(|&command| {
            let (label, tip) = (command.label().to_lowercase(), command.tip().to_lowercase());
            let all = words.iter().all(|word| label.contains(word.as_str()) || tip.contains(word.as_str()));
            let rank = match words.first() {
                Some(first) if label.starts_with(first.as_str()) => 0,
                Some(first) if label.contains(first.as_str()) => 1,
                _ => 2,
            };
            all.then_some((rank, command))
        })
        .collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, command)| command).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_find_commands_by_label_and_tip() {
        assert_eq!(find_commands("").len(), Command::ALL.len() - 1, "all but the palette itself");
        assert_eq!(find_commands("export").first(), Some(&Command::ExportCl));
        assert_eq!(find_commands("CALC rough").first(), Some(&Command::Plan));
        assert!(find_commands("conventional").contains(&Command::BeforeAfter), "tips count");
        assert!(find_commands("no such thing").is_empty());
    }
}
