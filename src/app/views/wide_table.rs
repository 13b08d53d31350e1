//! A table that may be wider and higher than its place: it scrolls both ways, while its head and its first
//! column stay. What a cell cannot show is elided, and shown whole under the pointer.

use std::ops::Range;

use egui::emath::GuiRounding;
use egui::{
    Align, Label, Layout, Pos2, Rect, Response, RichText, Role, ScrollArea, Sense, Ui, UiBuilder, Vec2,
    WidgetInfo,
};

use super::theme;

/// Space between columns, points.
const GAP: f32 = 10.0;
/// Space between the stripes of rows, points.
const ROW_GAP: f32 = 3.0;

/// What was clicked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableClick {
    /// The head of a column.
    Head(usize),
    /// A row.
    Row(usize),
}

/// A column.
pub struct WideColumn {
    /// Its head.
    pub head: String,
    /// What is said of it under the pointer.
    pub tip: String,
    /// Name of its head for assistive technology.
    pub name: String,
    /// Whether the table is sorted by it, and then whether the largest is first.
    pub sorted: Option<bool>,
    /// Width, points; see [`width_of_column`].
    pub width: f32,
}

/// Width of a column whose head has a mark of the order: that of the head, within limits, points.
pub fn width_of_column(ui: &Ui, head: &str, least: f32, most: f32) -> f32 {
    (theme::width_of_text(ui, head) + 10.0).ceil().clamp(least, most)
}

/// What the table shows.
pub struct WideTable<'a> {
    /// The columns; the first one stays where it is.
    pub columns: &'a [WideColumn],
    /// Number of rows.
    pub rows: usize,
    /// The selected row.
    pub selected: Option<usize>,
    /// Text of a cell, by row and column.
    pub cell: &'a dyn Fn(usize, usize) -> String,
    /// Name of a row for assistive technology.
    pub name: &'a dyn Fn(usize) -> String,
}

impl WideTable<'_> {
    /// Draws it in the rest of `ui`; returns what was clicked.
    pub fn show(&self, ui: &mut Ui) -> Option<TableClick> {
        let pitch = theme::ROW_HEIGHT + ROW_GAP;
        let mut lefts = Vec::with_capacity(self.columns.len() + 1);
        let mut right = 0.0;
        for column in self.columns {
            lefts.push(right);
            right += column.width + GAP;
        }
        lefts.push(right);
        let size = Vec2::new(right, pitch * (1 + self.rows) as f32);
        let mut clicked = None;
        ScrollArea::both().auto_shrink(false).show_viewport(ui, |ui, view| {
            let origin = ui.max_rect().min;
            let seen = ui.clip_rect();
            ui.allocate_rect(Rect::from_min_size(origin, size), Sense::hover());
            let parts = Parts {
                lefts: &lefts,
                origin,
                // On whole pixels, as the origin is: head and first column would tremble while it scrolls.
                corner: (origin + view.min.to_vec2()).round_to_pixels(ui.pixels_per_point()),
                seen,
                pitch,
                pinned: lefts.get(1).copied().unwrap_or(0.0),
            };
            for row in parts.rows(view.y_range(), self.rows) {
                clicked = self.row(ui, &parts, row).or(clicked);
            }
            for column in 0..self.columns.len() {
                clicked = self.head(ui, &parts, column).or(clicked);
            }
            if view.min.x > 0.5 {
                let x = parts.corner.x + parts.pinned - 0.5 * GAP;
                ui.painter().vline(x, seen.y_range(), ui.visuals().widgets.noninteractive.bg_stroke);
            }
        });
        clicked
    }

    fn row(&self, ui: &mut Ui, parts: &Parts, row: usize) -> Option<TableClick> {
        let top = parts.origin.y + parts.pitch * (1 + row) as f32;
        let body = parts.body();
        let rect = Rect::from_x_y_ranges(parts.seen.x_range(), top..=top + parts.pitch);
        let is_selected = self.selected == Some(row);
        let fill = if is_selected {
            Some(ui.visuals().selection.bg_fill)
        } else {
            (row % 2 == 1).then_some(ui.visuals().faint_bg_color)
        };
        let painter = ui.painter().with_clip_rect(body);
        if let Some(fill) = fill {
            painter.rect_filled(rect, 0.0, fill);
        }
        let response = ui.interact(rect.intersect(body), ui.scope_id().with(("row", row)), Sense::click());
        if response.hovered() && !is_selected {
            painter.rect_filled(rect, 0.0, ui.visuals().widgets.hovered.weak_bg_fill.gamma_multiply(0.5));
        }
        let name = (self.name)(row);
        response.widget_info(|| WidgetInfo::selected(Role::Row, true, is_selected, &name));
        for (column, of) in self.columns.iter().enumerate() {
            let (at, clip) = parts.cell(column, of.width, top, body);
            label(ui, at, clip, RichText::new((self.cell)(row, column)), Sense::hover());
        }
        response.clicked().then_some(TableClick::Row(row))
    }

    fn head(&self, ui: &mut Ui, parts: &Parts, column: usize) -> Option<TableClick> {
        let of = self.columns.get(column)?;
        let (at, clip) = parts.cell(column, of.width, parts.corner.y, parts.seen);
        let text = RichText::new(&of.head);
        let text = if of.sorted.is_some() { text.strong() } else { text.weak() };
        let response = label(ui, at, clip, text, Sense::click())?;
        if let Some(descending) = of.sorted {
            theme::sort_mark(ui, response.rect.center_bottom(), descending);
        }
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &of.name));
        response.on_hover_text(&of.tip).clicked().then_some(TableClick::Head(column))
    }
}

/// Where the parts of a table are.
struct Parts<'a> {
    /// Left edges of the columns within the table, points.
    lefts: &'a [f32],
    /// Upper left corner of the whole table, which scrolling moves.
    origin: Pos2,
    /// Upper left corner of what is seen.
    corner: Pos2,
    /// What is seen.
    seen: Rect,
    /// From a row to the next one, points.
    pitch: f32,
    /// Width of the first column with its gap, points.
    pinned: f32,
}

impl Parts<'_> {
    /// What is seen below the head.
    fn body(&self) -> Rect {
        self.seen.with_min_y((self.corner.y + self.pitch).max(self.seen.top()))
    }

    /// Rows that are seen of `count`.
    fn rows(&self, view: egui::Rangef, count: usize) -> Range<usize> {
        let first = (view.min / self.pitch).floor().max(0.0) as usize;
        let last = (view.max / self.pitch).ceil().max(0.0) as usize;
        first.min(count)..last.min(count)
    }

    /// Place of a cell at height `top`, and the part of it that is seen within `area`.
    fn cell(&self, column: usize, width: f32, top: f32, area: Rect) -> (Rect, Rect) {
        let left = self.lefts.get(column).copied().unwrap_or(0.0);
        let from = if column == 0 { self.corner.x } else { self.origin.x };
        let at = Rect::from_min_size(Pos2::new(from + left, top), Vec2::new(width, self.pitch));
        let area = if column == 0 { area } else { area.with_min_x(self.corner.x + self.pinned) };
        (at, at.intersect(area))
    }
}

/// A text in `at` of which `clip` is seen; `None` where that is nothing.
fn label(ui: &mut Ui, at: Rect, clip: Rect, text: RichText, sense: Sense) -> Option<Response> {
    if !clip.is_positive() {
        return None;
    }
    let layout = Layout::left_to_right(Align::Center);
    let mut place = ui.new_child(UiBuilder::new().max_rect(at).layout(layout));
    place.shrink_clip_rect(clip);
    Some(place.add(Label::new(text).selectable(false).sense(sense).truncate()))
}
