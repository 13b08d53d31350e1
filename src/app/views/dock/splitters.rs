//! Borders between docked panels: dragged by the mouse, and reset by a double click. The Tab key skips them
//! and moves from field to field.

use std::collections::{HashMap, HashSet};

use egui::{CursorIcon, Id, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo};
use egui_tiles::{Container, LinearDir, Tile, TileId, Tree};

use super::sizes::{KeptSize, holds_picture, shown_children};
use crate::app::model::panels::DockPanel;

/// Minimum size that a drag leaves to what is beside a border, points.
const LEAST: f32 = 60.0;

/// A border between two tiles of a row or column.
struct Border {
    container: TileId,
    dir: LinearDir,
    beside: [TileId; 2],
    rect: Rect,
}

impl Border {
    fn is_column(&self) -> bool {
        self.dir == LinearDir::Vertical
    }

    /// Its handle; the lines are those of the tree.
    fn interact(&self, ui: &Ui, tree: &Tree<DockPanel>) -> Response {
        let radius = ui.style().interaction.resize_grab_radius_side;
        let across = if self.is_column() { Vec2::new(0.0, radius) } else { Vec2::new(radius, 0.0) };
        let id = Id::unique(("border of docked panels", self.container, self.beside));
        let response = ui.interact(self.rect.expand2(across), id, Sense::CLICK | Sense::DRAG);
        let [before, after] = self.beside.map(|tile| name_of(tree, tile));
        let name = format!("Border {before} | {after}");
        response.widget_info(|| WidgetInfo::labeled(Role::Splitter, true, &name));
        let cursor = if self.is_column() { CursorIcon::ResizeVertical } else { CursorIcon::ResizeHorizontal };
        response.on_hover_and_drag_cursor(cursor)
    }

    /// Moves it with the pointer.
    fn drag(&self, ui: &Ui, tree: &mut Tree<DockPanel>, pointer: egui::Pos2) {
        let at = pointer - self.rect.center();
        let by = if self.is_column() { at.y } else { at.x };
        let sizes = self.beside.map(|tile| {
            let size = tree.tiles.rect(tile).map_or(Vec2::ZERO, |rect| rect.size());
            if self.is_column() { size.y } else { size.x }
        });
        // What is smaller already is not made smaller.
        let [low, high] = sizes.map(|size| (size - LEAST).max(0.0));
        let by = by.clamp(-low, high);
        if by == 0.0 {
            return;
        }
        if let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get_mut(self.container) {
            linear.shares.set_share(self.beside[0], sizes[0] + by);
            linear.shares.set_share(self.beside[1], sizes[1] - by);
        }
        ui.ctx().request_repaint();
    }

    /// Gives what is beside it the size that it has at first; what holds the 3D view takes the rest.
    fn reset(&self, ui: &Ui, tree: &mut Tree<DockPanel>, kept: &mut HashMap<TileId, KeptSize>) {
        let reset: Vec<TileId> =
            self.beside.into_iter().filter(|&tile| !holds_picture(&tree.tiles, tile)).collect();
        if let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get_mut(self.container) {
            for tile in reset {
                linear.shares.set_share(tile, 0.0);
                kept.remove(&tile);
            }
        }
        ui.ctx().request_repaint();
    }
}

/// The first panel in a tile that is shown.
fn name_of(tree: &Tree<DockPanel>, mut tile: TileId) -> &'static str {
    loop {
        match tree.tiles.get(tile) {
            Some(Tile::Pane(panel)) => return panel.title(),
            Some(Tile::Container(container)) => {
                let front = match container {
                    Container::Tabs(tabs) => tabs.active,
                    _ => shown_children(&tree.tiles, container).next(),
                };
                match front {
                    Some(front) => tile = front,
                    None => return "panels",
                }
            }
            None => return "panels",
        }
    }
}

/// The borders that can be moved; those of `rigid` containers cannot.
fn borders(tree: &Tree<DockPanel>, rigid: &HashSet<TileId>) -> Vec<Border> {
    let mut found = Vec::new();
    let mut waiting: Vec<TileId> = tree.root.into_iter().collect();
    while let Some(id) = waiting.pop() {
        let Some(container) = tree.tiles.get_container(id) else { continue };
        let shown: Vec<TileId> = shown_children(&tree.tiles, container).collect();
        match container {
            Container::Linear(linear) => {
                waiting.extend(&shown);
                let Some(whole) = tree.tiles.rect(id).filter(|_| !rigid.contains(&id)) else { continue };
                for pair in shown.windows(2) {
                    let beside = [pair[0], pair[1]];
                    let [Some(before), Some(after)] = beside.map(|tile| tree.tiles.rect(tile)) else {
                        continue;
                    };
                    let rect = match linear.dir {
                        LinearDir::Horizontal => {
                            Rect::from_x_y_ranges(before.right()..=after.left(), whole.y_range())
                        }
                        LinearDir::Vertical => {
                            Rect::from_x_y_ranges(whole.x_range(), before.bottom()..=after.top())
                        }
                    };
                    found.push(Border { container: id, dir: linear.dir, beside, rect });
                }
            }
            // Only the one in front is laid out.
            Container::Tabs(tabs) => waiting.extend(tabs.active),
            Container::Grid(_) => {}
        }
    }
    found
}

/// Lets the borders be moved, and draws the one under the pointer.
pub fn show(
    ui: &Ui,
    tree: &mut Tree<DockPanel>,
    rigid: &HashSet<TileId>,
    kept: &mut HashMap<TileId, KeptSize>,
) {
    for border in borders(tree, rigid) {
        let response = border.interact(ui, tree);
        if response.double_clicked() {
            border.reset(ui, tree, kept);
        } else if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            border.drag(ui, tree, pointer);
        }
        let widgets = &ui.visuals().widgets;
        let stroke = if response.dragged() {
            widgets.active.fg_stroke
        } else if response.hovered() {
            widgets.hovered.fg_stroke
        } else {
            continue;
        };
        let (painter, at) = (ui.painter(), border.rect.center());
        match border.dir {
            LinearDir::Horizontal => painter.vline(at.x, border.rect.y_range(), stroke),
            LinearDir::Vertical => painter.hline(border.rect.x_range(), at.y, stroke),
        };
    }
}
