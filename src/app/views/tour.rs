//! The tour: five cards that say what the parts of the window are for. It is offered once, with the first
//! part that is opened.

use egui::{
    Align2, Area, Frame, Id, Key, LayerId, Modifiers, Order, Rect, RichText, Stroke, StrokeKind, Ui, Vec2,
};

use super::theme;
use crate::app::model::panels::DockPanel;

/// A part of the window that a card is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowRegion {
    /// Part, operations and setup.
    Setup,
    /// The line with the verdict.
    Verdict,
    /// The 3D view, with plots and timeline.
    Picture,
    /// The table, with positions.
    Table,
    /// The menus.
    Menus,
}

/// A card: what it is about, its title and its text.
type Card = (WindowRegion, &'static str, &'static str);

/// The cards, in their order.
const CARDS: [Card; 5] = [
    (
        WindowRegion::Setup,
        DockPanel::Setup.title(),
        "Part, operations, and what they are planned with. Every edit is planned as it is made; a dot beside a \
         value says that it differs from the default, and a click on it resets it.",
    ),
    (
        WindowRegion::Verdict,
        "Verdict",
        "How many plunges would run the dead core of the cutter into stock, before and after; stock on the hub, \
         clearances, floor that is not machined, time. The colour is that of the worst.",
    ),
    (
        WindowRegion::Picture,
        DockPanel::Picture.title(),
        "Red-orange cutters meet stock with their core, green ones do not. B switches before and after, S shows the \
         stock as a solid, Space plays the timeline below.",
    ),
    (
        WindowRegion::Table,
        DockPanel::Table.title(),
        "The plunges in cutting order. A click selects one, here or in the 3D view, and the sectional view below \
         the table shows what its core meets; N goes to the next fault.",
    ),
    (
        WindowRegion::Menus,
        "Menus",
        "File writes APT, NC code, setup sheet and project; you are asked where something speaks against a program. \
         Plan has machinability and time against stock. Ctrl+K finds any command.",
    ),
];

/// Width of a card, points.
const WIDTH: f32 = 340.0;

/// The tour, and whether it was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tour {
    /// Index of the card that is shown; `None` while none is.
    card: Option<usize>,
}

impl Tour {
    /// Begins with the first card.
    pub fn begin(&mut self) {
        self.card = Some(0);
    }

    /// Whether a card is due: Escape ends the tour then.
    pub fn is_open(&self) -> bool {
        self.card.is_some()
    }

    /// Draws the card that is due, beside the part of the window that it is about; `true` when the tour ends.
    pub fn show(&mut self, ui: &Ui, place_of: impl Fn(WindowRegion) -> Option<Rect>) -> bool {
        let Some((card, &(region, title, text))) = self.card.and_then(|card| Some((card, CARDS.get(card)?)))
        else {
            return false;
        };
        let (ctx, accent) = (ui.ctx(), theme::accent(ui.visuals()));
        // A question is answered first: the mark would cross it.
        if ctx.memory(|memory| memory.top_modal_layer().is_some()) {
            return false;
        }
        let place = place_of(region);
        if let Some(place) = place {
            let layer = LayerId::new(Order::Foreground, Id::unique("tour mark"));
            let painter = ctx.layer_painter(layer);
            painter.rect_stroke(place.shrink(1.0), 3.0, Stroke::new(2.0, accent), StrokeKind::Inside);
        }
        let (mut next, mut ends) = (card, false);
        let area = Area::new(Id::unique("tour")).order(Order::Foreground);
        let area = match place.filter(|_| region == WindowRegion::Picture) {
            // Above the timeline and the plots, which it speaks of.
            Some(picture) => area.pivot(Align2::CENTER_CENTER).fixed_pos(picture.center()),
            None => area.anchor(Align2::CENTER_BOTTOM, Vec2::new(0.0, -70.0)),
        };
        area.show(ctx, |ui| {
            Frame::popup(ui.style()).inner_margin(12.0).show(ui, |ui| {
                ui.set_width(WIDTH);
                ui.label(RichText::new(title).strong());
                ui.add_space(2.0);
                ui.label(text);
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.label(RichText::new(format!("{} of {}", card + 1, CARDS.len())).weak());
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        let is_last = card + 1 == CARDS.len();
                        let forward = if is_last { "Done" } else { "Next" };
                        if ui.button(forward).clicked() {
                            (next, ends) = (card + 1, is_last);
                        }
                        if card > 0 && ui.button("Back").clicked() {
                            next = card - 1;
                        }
                        ends |= !is_last && ui.button("Skip tour").clicked();
                    });
                });
            });
        });
        let typing = ctx.text_edit_focused() || egui::Popup::is_any_open(ctx);
        ends |= !typing && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
        self.card = (!ends).then_some(next);
        ends
    }
}
