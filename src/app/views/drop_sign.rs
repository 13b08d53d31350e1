//! What is shown while files are dragged over the window.

use egui::{Align2, Area, Context, Frame, Id, Order, RichText, Stroke, StrokeKind};

use super::theme;

/// Frames the window, and says what a drop does. `asks`: a question is open, and nothing is taken.
pub fn show(ctx: &Context, asks: bool) {
    if ctx.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let words = if asks { "Answer the question first" } else { "Drop to open" };
    let sign = Area::new(Id::unique("drop sign")).order(Order::Tooltip).interactable(false);
    sign.anchor(Align2::CENTER_CENTER, egui::Vec2::ZERO).show(ctx, |ui| {
        let accent = theme::accent(ui.visuals());
        let painter = ui.painter().with_clip_rect(ctx.content_rect());
        let stroke = Stroke::new(4.0, accent);
        painter.rect_stroke(ctx.content_rect(), 0.0, stroke, StrokeKind::Inside);
        Frame::popup(ui.style()).inner_margin(16).show(ui, |ui| ui.label(RichText::new(words).size(20.0)));
    });
}
