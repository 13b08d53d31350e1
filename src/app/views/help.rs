//! Help in the window: keyboard shortcuts, glossary and version.

use egui::{Grid, Label, Modal, RichText, ScrollArea, Ui};

use crate::app::views::command::Command;
use crate::app::views::modal;

/// Pages of the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HelpPage {
    /// All keys.
    Shortcuts,
    /// The words of the window.
    Glossary,
    /// Version, licence and device.
    About,
}

impl HelpPage {
    fn title(self) -> &'static str {
        match self {
            Self::Shortcuts => "Keyboard shortcuts",
            Self::Glossary => "Glossary",
            Self::About => "About Vanecut",
        }
    }
}

/// The glossary of the documentation.
const GLOSSARY: &str = include_str!("../../../docs/GLOSSARY.md");

/// A line of the glossary.
#[derive(Debug, PartialEq, Eq)]
enum GlossaryLine {
    Heading(String),
    Term { term: String, meaning: String },
}

/// Headings and terms of a glossary in Markdown: `## heading`, and tables with term and meaning first.
fn read_glossary(text: &str) -> Vec<GlossaryLine> {
    let plain = |cell: &str| cell.trim().replace(['`', '*'], "");
    let line = |line: &str| {
        if let Some(heading) = line.strip_prefix("## ") {
            return Some(GlossaryLine::Heading(plain(heading)));
        }
        let mut cells = line.strip_prefix('|')?.split('|');
        let (term, meaning) = (plain(cells.next()?), plain(cells.next()?));
        let is_term = term != "term" && !term.starts_with("---") && !meaning.is_empty();
        is_term.then_some(GlossaryLine::Term { term, meaning })
    };
    text.lines().filter_map(line).collect()
}

/// The help, if it is open.
#[derive(Debug, Default)]
pub struct Help {
    page: Option<HelpPage>,
    /// The glossary, while its page is open.
    glossary: Vec<GlossaryLine>,
    /// Words searched in the glossary.
    words: String,
    /// Whether the page was not drawn yet: the search of the glossary then takes what is typed.
    is_new: bool,
}

impl Help {
    /// Opens a page.
    pub fn open(&mut self, page: HelpPage) {
        let glossary = if page == HelpPage::Glossary { read_glossary(GLOSSARY) } else { Vec::new() };
        *self = Self { page: Some(page), glossary, words: String::new(), is_new: true };
    }

    /// Whether a page is open.
    pub fn is_open(&self) -> bool {
        self.page.is_some()
    }

    /// Draws the page while it is open. `device`: name of the graphics device.
    pub fn show(&mut self, ui: &Ui, device: &str) {
        let Some(page) = self.page else { return };
        let mut close = false;
        let modal = Modal::new(egui::Id::unique("help")).show(ui.ctx(), |ui| {
            modal::set_fitting_width(ui, 460.0);
            ui.heading(page.title());
            ui.add_space(4.0);
            match page {
                HelpPage::Shortcuts => shortcuts(ui, self.is_new),
                HelpPage::Glossary => glossary(ui, &self.glossary, &mut self.words, self.is_new),
                HelpPage::About => about(ui, device),
            }
            ui.add_space(6.0);
            close = ui.button("Close").clicked();
        });
        self.is_new = false;
        if close || modal.should_close() {
            *self = Self::default();
        }
    }
}

/// The scrolling part of a page, lower in a low window; it begins at its top where it `is_new`.
fn page_area(ui: &Ui, page: HelpPage, is_new: bool) -> ScrollArea {
    let height = (ui.ctx().content_rect().height() - 160.0).clamp(120.0, 460.0);
    let area = ScrollArea::vertical().id_salt(page.title()).max_height(height).min_scrolled_height(height);
    let area = area.auto_shrink(false);
    if is_new { area.vertical_scroll_offset(0.0) } else { area }
}

fn shortcuts(ui: &mut Ui, is_new: bool) {
    page_area(ui, HelpPage::Shortcuts, is_new).show(ui, |ui| {
        Grid::new("shortcuts").num_columns(2).spacing([16.0, 3.0]).striped(true).show(ui, |ui| {
            for command in Command::ALL {
                let Some(keys) = command.shortcut() else { continue };
                ui.label(RichText::new(ui.ctx().format_shortcut(&keys)).strong());
                ui.label(command.label()).on_hover_text(command.tip());
                ui.end_row();
            }
            for (keys, what) in [
                ("Ctrl + +/=", "Larger text and controls"),
                ("Ctrl + −, Ctrl + 0", "Smaller; the usual size"),
                ("Tab", "Next field"),
            ] {
                ui.label(RichText::new(keys).strong());
                ui.label(what);
                ui.end_row();
            }
        });
    });
}

fn glossary(ui: &mut Ui, lines: &[GlossaryLine], words: &mut String, is_new: bool) {
    let hint = "Search the glossary";
    let field = ui.add(egui::TextEdit::singleline(words).hint_text(hint).desired_width(f32::INFINITY));
    field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, hint));
    if is_new {
        field.request_focus();
    }
    ui.add_space(4.0);
    let sought = words.to_lowercase();
    let is_found = |line: &&GlossaryLine| match line {
        GlossaryLine::Heading(_) => sought.is_empty(),
        GlossaryLine::Term { term, meaning } => {
            term.to_lowercase().contains(&sought) || meaning.to_lowercase().contains(&sought)
        }
    };
    let found: Vec<&GlossaryLine> = lines.iter().filter(is_found).collect();
    page_area(ui, HelpPage::Glossary, is_new).show(ui, |ui| {
        if found.is_empty() {
            ui.label(RichText::new("No entry has these words").weak());
        }
        for line in found {
            match line {
                GlossaryLine::Heading(heading) => {
                    ui.add_space(6.0);
                    ui.label(RichText::new(heading).strong());
                }
                GlossaryLine::Term { term, meaning } => {
                    let mut text = egui::text::LayoutJob::default();
                    let format = |colour| egui::TextFormat { color: colour, ..Default::default() };
                    text.append(term, 0.0, format(ui.visuals().strong_text_color()));
                    text.append(&format!(": {meaning}"), 0.0, format(ui.visuals().text_color()));
                    ui.add(Label::new(text).wrap());
                }
            }
        }
    });
}

fn about(ui: &mut Ui, device: &str) {
    ui.label(format!("Vanecut {}", env!("CARGO_PKG_VERSION")));
    ui.label(env!("CARGO_PKG_DESCRIPTION"));
    ui.label(format!("Licence: {}", env!("CARGO_PKG_LICENSE")));
    ui.label(format!("Graphics device: {device}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glossary_has_headings_and_terms() {
        let lines = read_glossary(GLOSSARY);
        let has = |wanted: &str| {
            lines.iter().any(|line| matches!(line, GlossaryLine::Term { term, .. } if term == wanted))
        };
        assert!(has("core") && has("stock") && has("rest milling"), "{} lines", lines.len());
        assert!(lines.contains(&GlossaryLine::Heading("Stock".to_owned())));
        assert!(!has("term") && !has("---"));
        let is_plain = |line: &GlossaryLine| match line {
            GlossaryLine::Term { meaning, .. } => !meaning.contains("]("),
            GlossaryLine::Heading(_) => true,
        };
        assert!(lines.iter().all(is_plain), "a link would stand there as it is written");
    }
}
