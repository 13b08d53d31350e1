//! Cells of tables.

use egui::{RichText, Sense, Ui};

use crate::app::views::theme::{self, Condition};

/// A cell of a table.
pub fn cell(ui: &mut Ui, text: RichText) {
    // Selectable text would swallow the clicks on the row.
    ui.add(egui::Label::new(text.monospace().size(12.0)).selectable(false));
}

/// A cell of a table with words instead of numbers.
pub fn word_cell(ui: &mut Ui, text: &str) {
    ui.add(egui::Label::new(RichText::new(text).size(12.0)).selectable(false));
}

/// Mark of a state, by colour and shape: disc, square or small ring.
pub fn mark(ui: &mut Ui, of: Condition) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, theme::ROW_HEIGHT), Sense::hover());
    let painter = ui.painter();
    match of {
        Condition::Interfering => {
            painter.circle_filled(rect.center(), 4.5, of.mark());
        }
        Condition::Blocked => {
            painter.rect_filled(
                egui::Rect::from_center_size(rect.center(), egui::vec2(8.0, 8.0)),
                0.0,
                of.mark(),
            );
        }
        Condition::Sound => {
            painter.circle_stroke(rect.center(), 2.5, egui::Stroke::new(1.5, of.mark()));
        }
    }
}
