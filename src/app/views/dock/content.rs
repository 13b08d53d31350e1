//! What each panel shows, docked or in a window of its own.

use egui::{Frame, Id, Margin, ScrollArea, Ui, Vec2, Vec2b};

use super::sizes::GAP;
use crate::app::App;
use crate::app::model::look::Operation;
use crate::app::model::panels::DockPanel;
use crate::app::views::overlay::controls_bottom;
use crate::app::views::panels;
use crate::app::views::panels::library::LibraryPanel;

/// Least widths of the details, and of tables other than that of positions, points.
const DETAILS_WIDTH: f32 = 276.0;
const TABLE_WIDTH: f32 = 270.0;

/// Id of the content of a panel, wherever it is shown.
pub fn panel_id(panel: DockPanel) -> Id {
    Id::unique(("panel", panel))
}

/// Margins of a docked panel, points.
fn margin(panel: DockPanel) -> Margin {
    match panel {
        DockPanel::Picture => Margin::ZERO,
        DockPanel::Setup | DockPanel::Table => Margin::symmetric(8, 2),
        DockPanel::Details => Margin { left: 8, right: 8, top: 2, bottom: 4 },
        DockPanel::Plots | DockPanel::Axes | DockPanel::Timeline => Margin::symmetric(6, 4),
        DockPanel::SectionalView
        | DockPanel::Machinability
        | DockPanel::Tradeoff
        | DockPanel::ToolLibrary
        | DockPanel::Study => Margin::same(8),
    }
}

impl App {
    /// Whether a panel has something to show now.
    pub(super) fn has_content(&self, panel: DockPanel) -> bool {
        let results = &self.state.results;
        let operation = self.state.look.operation;
        let has_timeline = match operation {
            Operation::Roughing => results.planned.is_some(),
            Operation::Flank => results.flank.is_some(),
            Operation::Program => results.checked.is_some(),
        };
        let is_open = self.state.document.part.is_some();
        match panel {
            DockPanel::Setup | DockPanel::Picture | DockPanel::Machinability => is_open,
            DockPanel::Timeline => has_timeline,
            DockPanel::Plots => has_timeline && operation == Operation::Roughing,
            DockPanel::Axes => has_timeline && self.state.timeline_machine().is_some(),
            DockPanel::Table => is_open && (operation != Operation::Flank || results.flank.is_some()),
            DockPanel::Details => match operation {
                Operation::Roughing => self.state.look.selected.is_some(),
                Operation::Flank => is_open,
                Operation::Program => false,
            },
            DockPanel::SectionalView => operation == Operation::Roughing && self.state.selected().is_some(),
            DockPanel::Tradeoff => results.planned.is_some(),
            DockPanel::ToolLibrary => true,
            DockPanel::Study => self.study.has_results(),
        }
    }

    /// Height of a docked panel that is as high as its content, points. `details`: that of the selected
    /// position.
    pub(super) fn height_of(&self, panel: DockPanel, details: f32) -> Option<f32> {
        match panel {
            DockPanel::Plots => Some(panels::plots::HEIGHT + 8.0 - GAP),
            DockPanel::Axes => Some(panels::rotary::HEIGHT + 8.0 - GAP),
            DockPanel::Timeline => Some(panels::timeline::height(&self.state) - GAP),
            DockPanel::Details => (self.state.look.operation == Operation::Roughing).then_some(details),
            _ => None,
        }
    }

    /// Width that the docked table needs, points.
    pub(super) fn table_width(&self) -> f32 {
        let columns = match self.state.look.operation {
            Operation::Roughing => panels::positions::columns_width(&self.state),
            Operation::Flank => panels::flank_passes::columns_width(&self.state),
            Operation::Program => return 0.0,
        };
        columns + margin(DockPanel::Table).sum().x
    }

    /// Size below which a panel scrolls, points; 0 where it fits into what there is.
    fn min_size(&self, panel: DockPanel) -> Vec2 {
        match panel {
            DockPanel::Setup => Vec2::new(232.0, 0.0),
            DockPanel::Table => Vec2::new((self.table_width() - margin(panel).sum().x).max(TABLE_WIDTH), 0.0),
            DockPanel::Details => Vec2::new(DETAILS_WIDTH, 0.0),
            DockPanel::SectionalView => Vec2::new(270.0, 210.0),
            DockPanel::Tradeoff => Vec2::new(270.0, 290.0),
            DockPanel::Study => Vec2::new(270.0, 360.0),
            DockPanel::Machinability => Vec2::new(270.0, 160.0),
            DockPanel::ToolLibrary => Vec2::new(LibraryPanel::MIN_WIDTH, 0.0),
            DockPanel::Picture | DockPanel::Plots | DockPanel::Axes | DockPanel::Timeline => Vec2::ZERO,
        }
    }

    /// Draws a docked panel. `details_height`: height of the content of the details, which is measured.
    pub(super) fn docked_panel(&mut self, ui: &mut Ui, panel: DockPanel, details_height: &mut f32) {
        let margin = margin(panel);
        let fill =
            if panel == DockPanel::Picture { egui::Color32::TRANSPARENT } else { ui.visuals().panel_fill };
        let frame = Frame::new().inner_margin(margin).fill(fill);
        let size = ui.available_size();
        frame.show(ui, |ui| {
            ui.set_min_size(size - margin.sum());
            self.filled_panel(ui, panel, size.y, details_height);
        });
    }

    /// Draws a panel within its margins; with them it is `height` points high.
    fn filled_panel(&mut self, ui: &mut Ui, panel: DockPanel, height: f32, details_height: &mut f32) {
        if panel == DockPanel::Details && self.state.look.operation == Operation::Roughing {
            // Higher than its content, where nothing else stands in its column.
            let fill_height = (height > *details_height + 1.0).then_some(ui.available_height());
            let measured = (self.selected_position(ui, fill_height) + margin(panel).sum().y).ceil();
            // Its tabs stay where they are while the content changes: it is as high as its highest content
            // in a window of this size.
            let (key, window) =
                (Id::unique("size of the window of the details"), ui.ctx().content_rect().size());
            let is_same = ui.data(|data| data.get_temp::<Vec2>(key)) == Some(window);
            let wanted = if is_same { measured.max(*details_height) } else { measured };
            if fill_height.is_none() && wanted != *details_height {
                *details_height = wanted;
                ui.ctx().request_repaint();
            }
            if fill_height.is_none() {
                ui.data_mut(|data| data.insert_temp(key, window));
            }
        } else {
            self.scrolled_panel(ui, panel, None);
        }
    }

    /// Draws the content of a panel, with scroll bars where the panel is smaller than its content needs.
    pub(super) fn scrolled_panel(&mut self, ui: &mut Ui, panel: DockPanel, fill_height: Option<f32>) {
        let min = self.min_size(panel);
        if min == Vec2::ZERO || panel == DockPanel::Details {
            self.panel(ui, panel, fill_height);
            return;
        }
        // A horizontal scroll bar only where it is needed: it lies over the last row and would take its
        // clicks, and rounding to pixels makes the content a little wider than the panel.
        let is_narrow = ui.available_width() < min.x;
        // The tool library is as high as its content.
        let directions = Vec2b::new(is_narrow, min.y > 0.0 || panel == DockPanel::ToolLibrary);
        ScrollArea::new(directions).id_salt("panel").auto_shrink(false).show(ui, |ui| {
            ui.set_width(ui.available_width().max(min.x));
            if min.y > 0.0 {
                ui.set_height(ui.available_height().max(min.y));
            }
            self.panel(ui, panel, fill_height);
        });
    }

    /// Draws the content of a panel. `fill_height`: height that the details take up, points; `None`:
    /// that of their content.
    pub(super) fn panel(&mut self, ui: &mut Ui, panel: DockPanel, fill_height: Option<f32>) {
        match panel {
            DockPanel::Setup => self.setup_panel(ui),
            DockPanel::Picture => self.picture(ui),
            DockPanel::Plots => {
                let menu = panels::plots::show(ui, &mut self.state);
                self.run_for_position(ui.ctx(), menu);
            }
            DockPanel::Axes => {
                let menu = panels::rotary::show(ui, &mut self.state);
                self.run_for_position(ui.ctx(), menu);
            }
            DockPanel::Timeline => {
                if let Some(command) = panels::timeline::show(ui, &mut self.state) {
                    self.run_command(ui.ctx(), command);
                }
            }
            DockPanel::Table => self.table(ui),
            DockPanel::Details if self.state.look.operation == Operation::Roughing => {
                self.selected_position(ui, fill_height);
            }
            DockPanel::Details => panels::flank_results::show(ui, &self.state),
            DockPanel::SectionalView => self.large_section(ui),
            DockPanel::Machinability => self.machinability(ui),
            DockPanel::Tradeoff => self.tradeoff(ui),
            DockPanel::ToolLibrary => self.tool_library(ui),
            DockPanel::Study => self.study_results(ui),
        }
    }

    /// The selected position; returns the height of its content, which scrolls where it does not fit, points.
    fn selected_position(&mut self, ui: &mut Ui, fill_height: Option<f32>) -> f32 {
        let is_narrow = ui.available_width() < DETAILS_WIDTH;
        let area = ScrollArea::new([is_narrow, true]).id_salt("details").auto_shrink(false);
        let shown = area.show(ui, |ui| {
            ui.set_width(ui.available_width().max(DETAILS_WIDTH));
            self.details(ui, fill_height);
        });
        shown.content_size.y
    }

    /// The 3D view, with problems over it: a message that took space would move what is under the pointer.
    pub(in crate::app) fn picture(&mut self, ui: &mut Ui) {
        let whole = ui.available_rect_before_wrap();
        if self.state.document.part.is_some() {
            self.viewport(ui);
            panels::problems::show(ui, whole, controls_bottom(whole), &mut self.state);
            return;
        }
        // The start page begins below the messages: they would hide what it offers.
        ui.painter().rect_filled(whole, 0.0, ui.visuals().panel_fill);
        let taken = panels::problems::show(ui, whole, 0.0, &mut self.state);
        let rest = whole.with_min_y(whole.top() + taken);
        ui.scope_builder(egui::UiBuilder::new().max_rect(rest), |ui| self.viewport(ui));
    }
}
