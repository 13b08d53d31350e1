//! A drawing of a tool with its dimensions: cutter, shank, holder, tip down.

use egui::{Align2, Color32, FontId, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};

use crate::app::views::theme::{self, Condition};
use crate::app::views::units;
use crate::setup::{OutlineKind, Tool};

/// Height of the drawing, points.
const HEIGHT: f32 = 190.0;
/// Space for dimensions beside and below the tool, points.
const BESIDE: f32 = 58.0;
const BELOW: f32 = 20.0;
const ABOVE: f32 = 16.0;

/// Draws `tool` over the available width.
pub fn show(ui: &mut Ui, tool: &Tool) {
    let size = Vec2::new(ui.available_width().min(280.0), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let title = format!("Drawing of T{}", tool.number);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &title));
    if !ui.is_rect_visible(rect) {
        return;
    }
    let visuals = ui.visuals().clone();
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    let outline = tool.outline();
    let height = outline.iter().map(|piece| piece.from + piece.length).fold(tool.overhang, f64::max);
    let widest = outline.iter().flat_map(|piece| piece.radii).fold(tool.radius(), f64::max);
    let inner =
        Rect::from_min_max(rect.min + egui::vec2(BESIDE, ABOVE), rect.max - egui::vec2(BESIDE, BELOW));
    let scale = f64::from(inner.height()) / height.max(1e-9);
    let scale = scale.min(0.5 * f64::from(inner.width()) / widest.max(1e-9));
    let at = |off: f64, up: f64| -> Pos2 {
        egui::pos2(inner.center().x + (off * scale) as f32, inner.bottom() - (up * scale) as f32)
    };
    let ink = visuals.text_color();
    for piece in &outline {
        let side = piece.side(tool);
        let left = side.iter().rev().map(|[off, up]| at(-off, *up));
        let corners = side.iter().map(|[off, up]| at(*off, *up)).chain(left).collect();
        let kind = piece.kind;
        let line = match kind {
            OutlineKind::AssumedHolder => Stroke::new(1.0, visuals.weak_text_color()),
            _ => Stroke::new(1.0, ink),
        };
        painter.add(Shape::convex_polygon(corners, fill(kind, &visuals), line));
    }
    // The core, which has no edge.
    let core = tool.core_radius();
    if core * scale > 0.5 {
        let low = at(-core, 0.0);
        let high = at(core, 0.0) - egui::vec2(0.0, 5.0);
        painter.rect_filled(Rect::from_two_pos(low, high), 0.0, Condition::Interfering.mark());
    }
    let dimensions = Dimensions { painter: &painter, ink, font: FontId::proportional(11.0) };
    let units = units::display_units(ui);
    let number = |value: f64| units.short(value, 2);
    // Stick-out on the right, flutes on the left, diameters below and above.
    let right = at(widest, 0.0).x + 8.0;
    dimensions.vertical(right, at(0.0, 0.0).y, at(0.0, tool.overhang).y, &number(tool.overhang), true);
    let [cutter, ..] = outline.as_slice() else { return };
    if cutter.length < tool.overhang {
        let left = at(-widest, 0.0).x - 8.0;
        dimensions.vertical(left, at(0.0, 0.0).y, at(0.0, cutter.length).y, &number(cutter.length), false);
    }
    let insert = if core > 0.0 { format!(", insert {}", number(tool.insert_width)) } else { String::new() };
    let below = egui::pos2(inner.center().x, inner.bottom() + 3.0);
    dimensions.text(below, Align2::CENTER_TOP, &format!("Ø{}{insert}", number(tool.diameter)));
    let holder = outline.iter().flat_map(|piece| match piece.kind {
        OutlineKind::Holder => piece.radii.to_vec(),
        _ => Vec::new(),
    });
    let gauge: f64 = tool.assembly.holder.iter().map(|[.., length]| length).sum();
    let holder = match holder.reduce(f64::max) {
        Some(radius) => format!("holder Ø{} × {}", number(2.0 * radius), number(gauge)),
        None => "holder not described".to_owned(),
    };
    dimensions.text(egui::pos2(rect.center().x, rect.top() + 2.0), Align2::CENTER_TOP, &holder);
}

/// Colour of a piece.
fn fill(kind: OutlineKind, visuals: &egui::Visuals) -> Color32 {
    let steel = visuals.widgets.inactive.bg_fill;
    match kind {
        OutlineKind::Cutter => theme::accent(visuals).gamma_multiply(0.45),
        OutlineKind::Body | OutlineKind::Shank => steel,
        OutlineKind::Holder => steel.gamma_multiply(0.7),
        OutlineKind::AssumedHolder => Color32::TRANSPARENT,
    }
}

/// Draws dimensions.
struct Dimensions<'a> {
    painter: &'a egui::Painter,
    ink: Color32,
    font: FontId,
}

impl Dimensions<'_> {
    fn text(&self, at: Pos2, align: Align2, text: &str) {
        self.painter.text(at, align, text, self.font.clone(), self.ink);
    }

    /// A dimension between two heights, with its text on the right or the left.
    fn vertical(&self, x: f32, from: f32, to: f32, text: &str, right: bool) {
        let line = Stroke::new(1.0, self.ink);
        self.painter.line_segment([egui::pos2(x, from), egui::pos2(x, to)], line);
        for y in [from, to] {
            self.painter.line_segment([egui::pos2(x - 3.0, y), egui::pos2(x + 3.0, y)], line);
        }
        let (off, align) = if right { (5.0, Align2::LEFT_CENTER) } else { (-5.0, Align2::RIGHT_CENTER) };
        self.text(egui::pos2(x + off, 0.5 * (from + to)), align, text);
    }
}
