//! The command palette: search as you type over all commands.

use egui::{Align2, Key, Modal, RichText, TextEdit, Ui};

use crate::app::views::command::Command;
use crate::app::views::{list_keys, scroll_area};

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
            let (step, enter) = ui.input_mut(|i| {
                let none = egui::Modifiers::NONE;
                (list_keys::step_in(i), i.consume_key(none, Key::Enter))
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
            let mut found = find_commands(&self.words);
            // Stable: the best matches come first among those that can be chosen.
            found.sort_by_key(|&command| !can(command));
            self.chosen = list_keys::moved(self.chosen, step, found.len()).unwrap_or(self.chosen);
            if enter {
                run = found.get(self.chosen).copied().filter(|&command| can(command));
            }
            ui.add_space(4.0);
            if found.is_empty() {
                ui.label(RichText::new("No matching command").weak());
            }
            scroll_area(LIST).show(ui, |ui| {
                for (k, &command) in found.iter().enumerate() {
                    let response = command_line(ui, command, k == self.chosen, can(command));
                    if k == self.chosen && step != 0 {
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
    if let Some(keys) = command.shortcut().filter(|_| enabled) {
        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
    }
    let line = ui.add_enabled(enabled, button).on_hover_text(command.tip());
    if !enabled {
        // Beside the name: the field still takes Enter, which then does nothing.
        let text = egui::Label::new(RichText::new("not available now").weak());
        let right = egui::Layout::right_to_left(egui::Align::Center);
        let place = line.rect.shrink2(egui::vec2(ui.spacing().button_padding.x, 0.0));
        ui.new_child(egui::UiBuilder::new().max_rect(place).layout(right)).add(text);
    }
    line
}

/// Height of the list of commands, points.
const LIST: f32 = 300.0;

/// Commands that the empty search shows first, in this order.
const FIRST: [Command; 13] = [
    Command::Plan,
    Command::PlanFlank,
    Command::NextFault,
    Command::BeforeAfter,
    Command::SideBySide,
    Command::Play,
    Command::Stock,
    Command::ViewChannel,
    Command::Fit,
    Command::SaveProject,
    Command::ExportCl,
    Command::ExportNc,
    Command::OpenPart,
];

/// Other words for a command, as other programs call it.
fn synonyms(command: Command) -> &'static str {
    use Command as C;
    match command {
        C::Plan => "plan compute generate toolpath plunge roughing",
        C::PlanFlank => "plan compute generate toolpath swarf finish",
        C::CheckProgram => "verify simulate collision gcode g-code nc apt open import",
        C::Play => "simulate simulation animate run verify",
        C::ScrubHere => "simulation",
        C::Stock => "simulate simulation solid material removal ipw blank",
        C::NextTool | C::PreviousTool => "toolchange m6 jump",
        C::NextSection | C::PreviousSection => "zone jump",
        C::ExportCl | C::ExportClSome | C::ExportClAll | C::ExportFlank => "nc program output apt cl write",
        C::ExportNc => {
            "gcode g-code cnc post postprocess output write heidenhain siemens fanuc haas linuxcnc"
        }
        C::TimeAgainstStock => "pareto tradeoff goal faster cycle optimise optimize",
        C::ExportSheet => "report print html machine operator write",
        C::Assess | C::SaveAssessment => "assess analyse analyze twist bow depth width cutter reach report",
        C::ExportStock => "stl ipw rest",
        C::ExportScene => "gltf glb 3d model",
        C::SavePicture => "screenshot image png export",
        C::OpenPart => "import load step stl model wheel",
        C::OpenProject | C::OpenSetup => "load",
        C::ToolLibrary => "tools magazine fusion freecad shank holder",
        C::OpenLibrary => "load import tools fusion freecad",
        C::SaveLibrary => "store write export tools fusion",
        C::OpenBlank => "load import stl stock casting forging preform",
        C::OpenMachine => "load import kinematics trunnion own",
        C::SaveProject | C::SaveProjectAs | C::SaveSetup => "store write",
        C::Cutters => "tool tools",
        C::Holders => "tool tools collision",
        C::Axes => "tool vectors",
        C::Links => "retract moves",
        C::NextFault | C::PreviousFault => "collision error problem gouge interference",
        C::BeforeAfter => "compare toggle conventional",
        C::SideBySide => "compare split both",
        C::Wipe => "compare curtain slider",
        C::Difference => "compare delta",
        C::KeepSet => "what-if snapshot compare",
        C::CompareAll => "policy axis conventional stepped minimal",
        C::DismissProblems => "notes messages warnings errors remarks",
        C::Measure | C::MeasureHere => "distance ruler dimension",
        C::SectionPlane => "clip cut cross-section meridional axial",
        C::SwitchTheme => "dark light mode appearance",
        C::FollowEdits => "live automatic recalculate",
        C::Fit => "zoom all",
        C::ShowShortcuts => "help keys keyboard hotkeys",
        C::ShowGlossary => "help words terms",
        C::ShowAbout => "help version licence",
        C::PassesByLayer | C::PassesByRegion | C::PassesByFeed => "colour color flank curves",
        C::PassesByWalls => "colour color flank deviation residual gouge",
        C::TextLarger | C::TextSmaller | C::TextUsual => "font zoom scale ui scaling hidpi",
        C::Quit => "exit close",
        _ => "",
    }
}

/// Whether a command takes away what is open; such commands are never proposed first.
fn is_destructive(command: Command) -> bool {
    matches!(command, Command::NewProject | Command::Quit)
}

/// Whether a command moves the timeline to a place that its label names: who types the name of a thing looks
/// for the thing before a jump to it.
fn is_jump(command: Command) -> bool {
    use Command as C;
    matches!(command, C::NextTool | C::PreviousTool | C::NextSection | C::PreviousSection)
}

/// Place of the best match of a typed word in a command: a word of its label, a synonym, a word of its tip;
/// in each, a whole word comes before the beginning of one. The label of a jump comes after synonyms.
/// Only beginnings of words match: "tool" is not to find "stool".
fn place_of(word: &str, command: Command) -> Option<usize> {
    let places = [command.label(), synonyms(command), command.tip()];
    places.iter().enumerate().find_map(|(place, text)| {
        let text = text.to_lowercase();
        let words = || text.split(|c: char| !c.is_alphanumeric() && c != '-');
        let begins = words().any(|known| known.starts_with(word));
        let after = if is_jump(command) { 3 } else { 0 };
        begins.then(|| 2 * place + after + usize::from(!words().any(|known| known == word)))
    })
}

/// Commands that contain every typed word: best places first, labels that start with the first word before
/// others, and destructive commands last of their place.
fn find_commands(words: &str) -> Vec<Command> {
    // Signs are no part of words, in what is typed as in labels.
    let typed = words.to_lowercase();
    let words = typed.split(|c: char| !c.is_alphanumeric() && c != '-').filter(|word| !word.is_empty());
    let words: Vec<String> = words.map(str::to_owned).collect();
    let rank = |command: Command| -> Option<(usize, bool, usize)> {
        let mut worst = 0;
        for word in &words {
            worst = worst.max(place_of(word, command)?);
        }
        let starts =
            words.first().is_none_or(|first| command.label().to_lowercase().starts_with(first.as_str()));
        let first = FIRST.iter().position(|&known| known == command).unwrap_or(FIRST.len());
        Some((2 * worst + usize::from(!starts), is_destructive(command), first))
    };
    let mut found: Vec<((usize, bool, usize), Command)> = Command::ALL
        .iter()
        .filter(|command| **command != Command::Palette)
        .filter_map(|&command| Some((rank(command)?, command)))
        .collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, command)| command).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_find_commands_by_label_synonym_and_tip() {
        assert_eq!(find_commands("").len(), Command::ALL.len() - 1, "all but the palette itself");
        for (words, first) in [
            ("export", Command::ExportCl),
            ("CALC rough", Command::Plan),
            ("simulate", Command::ScrubHere),
            ("gcode", Command::ExportNc),
            ("g-code", Command::ExportNc),
            ("stock", Command::Stock),
            ("tool", Command::Cutters),
            ("screenshot", Command::SavePicture),
            ("zoom", Command::FlyToSelection),
            ("Units: m", Command::UnitsMetric),
            ("text size", Command::TextLarger),
            ("larger", Command::TextLarger),
            ("passes layer", Command::PassesByLayer),
            ("colour walls", Command::PassesByWalls),
            ("compare all", Command::CompareAll),
            ("strateg", Command::CompareAll),
            ("note", Command::DismissProblems),
        ] {
            assert_eq!(find_commands(words).first(), Some(&first), "{words}");
        }
        assert!(!find_commands("light").contains(&Command::PassesByFeed), "it is about no light");
        assert!(find_commands("simulate").contains(&Command::Play));
        assert!(find_commands("conventional").contains(&Command::BeforeAfter), "tips count");
        assert!(find_commands("no such thing").is_empty());
    }

    #[test]
    fn what_closes_the_project_is_never_proposed_first() {
        for words in ["", "e", "c", "n", "project", "window"] {
            let found = find_commands(words);
            assert!(!is_destructive(found[0]) || found.len() == 1, "{words}: {:?}", found[0]);
        }
        let empty = find_commands("");
        assert!(empty[empty.len() - 2..].iter().all(|&command| is_destructive(command)), "last of all");
    }
}
