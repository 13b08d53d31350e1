//! Figures with their names, side by side in lines that break between them.

use egui::{RichText, Ui};

use crate::app::views::theme;

/// Draws a figure with its name, in the next line if this one is too short for both.
pub fn figure(ui: &mut Ui, name: &str, value: String, tip: &str) {
    keep_together(ui, &[name, &value]);
    named(ui, name, value, tip);
}

/// Draws a figure like [`figure`], divided by a line from those before it in the same line.
pub fn divided_figure(ui: &mut Ui, name: &str, value: String, tip: &str) {
    divide(ui, &[name, &value]);
    named(ui, name, value, tip);
}

fn named(ui: &mut Ui, name: &str, value: String, tip: &str) {
    ui.label(RichText::new(name).weak()).on_hover_text(tip);
    ui.label(value).on_hover_text(tip);
}

/// Begins the next line if `words` do not all fit in the rest of this one.
pub fn keep_together(ui: &mut Ui, words: &[&str]) {
    if width_of(ui, words) > ui.available_size_before_wrap().x {
        ui.end_row();
    }
}

/// Draws a line between figures, or begins the next line if the `words` after it do not fit in this one: no
/// line is left at its start or its end.
pub fn divide(ui: &mut Ui, words: &[&str]) {
    let line = SEPARATOR + ui.spacing().item_spacing.x;
    if line + width_of(ui, words) > ui.available_size_before_wrap().x {
        ui.end_row();
    } else {
        ui.add(egui::Separator::default().spacing(SEPARATOR));
    }
}

/// Width of a line between figures with the space around it, points.
const SEPARATOR: f32 = 6.0;

/// Width of words side by side, points.
fn width_of(ui: &Ui, words: &[&str]) -> f32 {
    let width = |text: &&str| theme::width_of_text(ui, text);
    words.iter().map(width).sum::<f32>() + ui.spacing().item_spacing.x * (words.len() - 1) as f32
}
