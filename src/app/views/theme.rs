//! Design tokens: the colours and sizes of the window, for light and dark. Those that it shares with the
//! pictures are in [`crate::palette`].
//!
//! States use the Okabe-Ito palette, which is safe for colour-blind users; each also has a word or a mark
//! shape.

use egui::{
    Color32, Context, CornerRadius, FontId, FontSelection, Stroke, Style, TextStyle, Theme, Ui, Visuals,
};

use crate::palette;
pub use crate::plunge::Condition;

/// Style of the menu bar and its menus: the item that has the keys has a frame, as elsewhere.
pub fn menu_style(style: &mut Style) {
    let focus = style.visuals.widgets.active.bg_stroke;
    egui::containers::menu::menu_style(style);
    style.visuals.widgets.active.bg_stroke = focus;
}

/// A colour of the pictures, for the window.
pub fn colour(colour: palette::Rgb) -> Color32 {
    let [r, g, b] = palette::to_bytes(colour);
    Color32::from_rgb(r, g, b)
}

/// Width of a text in one line and the font of labels, points.
pub fn width_of_text(ui: &Ui, text: &str) -> f32 {
    let (font, ink) = (FontSelection::Default.resolve(ui.style()), ui.visuals().text_color());
    ui.painter().layout_no_wrap(text.to_owned(), font, ink).size().x
}

impl Condition {
    /// Colour of the mark: bluish green, orange or vermilion.
    pub fn mark(self) -> Color32 {
        match self {
            Self::Sound => colour(palette::SOUND),
            Self::Blocked => colour(palette::BLOCKED),
            Self::Interfering => colour(palette::INTERFERING),
        }
    }

    /// Colour of text in this state: the mark's hue, with enough contrast to read on a panel.
    pub fn text(self, visuals: &Visuals) -> Color32 {
        match (self, visuals.dark_mode) {
            (Self::Sound, true) => Color32::from_rgb(60, 200, 158),
            (Self::Blocked, true) => Color32::from_rgb(240, 175, 40),
            (Self::Interfering, true) => Color32::from_rgb(245, 130, 50),
            (Self::Sound, false) => Color32::from_rgb(0, 112, 82),
            (Self::Blocked, false) => Color32::from_rgb(140, 92, 0),
            (Self::Interfering, false) => Color32::from_rgb(176, 72, 0),
        }
    }
}

/// Accent colour: selection, links, primary button.
pub fn accent(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(86, 160, 220) } else { PRIMARY }
}

/// Fill of the primary button; its text is white in both themes.
pub const PRIMARY: Color32 = Color32::from_rgb(0, 98, 160);

/// Stock in the sectional view.
pub fn stock(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(120, 104, 60) } else { Color32::from_rgb(232, 216, 168) }
}

/// Background of the 3D view.
pub fn view_background(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_gray(30) } else { Color32::from_rgb(232, 234, 237) }
}

/// Backing of controls and text over the 3D view.
pub fn overlay(visuals: &Visuals) -> Color32 {
    visuals.panel_fill.gamma_multiply(0.88)
}

/// Edge of boxes and fields.
fn box_edge(visuals: &Visuals) -> Stroke {
    Stroke::new(1.0, Color32::from_gray(if visuals.dark_mode { 128 } else { 140 }))
}

/// Gives the check boxes and radio buttons that follow in a menu the edge that they have elsewhere: menus
/// have none, for the sake of their buttons.
pub fn draw_box_edges(ui: &mut Ui) {
    let edge = box_edge(ui.visuals());
    let widgets = &mut ui.visuals_mut().widgets;
    (widgets.inactive.bg_stroke, widgets.hovered.bg_stroke) = (edge, edge);
}

/// Size of the smallest text, points.
pub const MIN_TEXT_SIZE: f32 = 11.0;
/// Initial width of the left panel, points.
pub const LEFT_WIDTH: f32 = 260.0;
/// Initial width of the right panel, points.
pub const RIGHT_WIDTH: f32 = 300.0;
/// Width of the labels of a form, points.
pub const LABEL_WIDTH: f32 = 102.0;
/// Width of the boxes of a form, points.
pub const FIELD_WIDTH: f32 = 104.0;
/// Height of a table row, points.
pub const ROW_HEIGHT: f32 = 19.0;

/// Applies colours and spacing to both themes.
pub fn apply(ctx: &Context) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            let visuals = &mut style.visuals;
            visuals.panel_fill =
                if visuals.dark_mode { Color32::from_gray(38) } else { Color32::from_gray(246) };
            visuals.window_fill = visuals.panel_fill;
            visuals.extreme_bg_color =
                if visuals.dark_mode { Color32::from_gray(26) } else { Color32::from_gray(255) };
            visuals.override_text_color = None;
            // At least 4.5:1 on every background, also disabled (WCAG 2 level AA).
            let weak = if visuals.dark_mode { 172 } else { 92 };
            visuals.weak_text_color = Some(Color32::from_gray(weak));
            visuals.disabled_alpha = 0.74;
            let accent = accent(visuals);
            visuals.selection.bg_fill = accent.gamma_multiply(if visuals.dark_mode { 0.45 } else { 0.28 });
            visuals.selection.stroke =
                Stroke::new(1.0, if visuals.dark_mode { Color32::WHITE } else { Color32::BLACK });
            visuals.hyperlink_color = accent;
            for widget in [
                &mut visuals.widgets.noninteractive,
                &mut visuals.widgets.inactive,
                &mut visuals.widgets.hovered,
                &mut visuals.widgets.active,
                &mut visuals.widgets.open,
            ] {
                widget.corner_radius = CornerRadius::same(3);
            }
            // Boxes without a mark and fields would hardly stand out from the panel: 3:1 (WCAG 2, 1.4.11).
            visuals.widgets.inactive.bg_stroke = box_edge(visuals);
            visuals.widgets.noninteractive.fg_stroke.color =
                if visuals.dark_mode { Color32::from_gray(205) } else { Color32::from_gray(45) };
            visuals.widgets.inactive.fg_stroke.color =
                if visuals.dark_mode { Color32::from_gray(220) } else { Color32::from_gray(30) };
            style.text_styles.insert(TextStyle::Small, FontId::proportional(MIN_TEXT_SIZE));
            style.spacing.item_spacing = egui::vec2(6.0, 4.0);
            style.spacing.button_padding = egui::vec2(6.0, 2.0);
            style.spacing.combo_width = 120.0;
            // No animations: every frame is final, and an idle window draws nothing.
            style.animation_time = 0.0;
        });
    }
}

/// A triangle under the head of a sorted column, at the middle of its lower edge; it points to the large
/// values.
pub fn sort_mark(ui: &Ui, at: egui::Pos2, descending: bool) {
    let up = if descending { 1.0 } else { -1.0 };
    let corner = |x: f32, y: f32| at + egui::vec2(x, 2.0 + y * up);
    let ink = ui.visuals().strong_text_color();
    let triangle = vec![corner(-3.0, -1.5), corner(3.0, -1.5), corner(0.0, 1.5)];
    ui.painter().add(egui::Shape::convex_polygon(triangle, ink, Stroke::NONE));
}
