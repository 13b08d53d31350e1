//! The panels beside the 3D view: part, operations and the form of the selected operation; its results as a
//! table and in detail.

use egui::{CentralPanel, RichText, ScrollArea, Ui};

use crate::app::App;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::look::{DrawingPart, Operation, SectionalLook, Tab};
use crate::app::model::panels::DockPanel;
use crate::app::views::command::Command;
use crate::app::views::panels;
use crate::app::views::theme;

impl App {
    /// Part, operations and the form of the selected operation.
    pub(in crate::app) fn setup_panel(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        let fresh = self.state.look.is_fresh;
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if fresh {
            area = area.vertical_scroll_offset(0.0);
        }
        area.show(ui, |ui| {
            // The scroll bar floats over the content; leave its width free.
            ui.set_max_width(ui.available_width() - 8.0);
            let part = self.state.document.part.as_ref();
            let name = part.map_or("Part", |part| part.impeller.name.as_str()).to_owned();
            ui.label(RichText::new(name).strong());
            if let Some(action) = panels::part::show(ui, &self.state, &self.engine.samples) {
                self.apply_action(ui.ctx(), action);
            }
            ui.separator();
            let running = |operation| self.work.words_while_calculating(operation);
            let chosen = panels::operations::show(ui, &self.state, running);
            self.state.look.operation = chosen.unwrap_or(self.state.look.operation);
            ui.separator();
            match self.state.look.operation {
                Operation::Roughing => self.roughing_form(ui, fresh),
                Operation::Flank => self.flank_form(ui, fresh),
                Operation::Program => self.program_form(ui, fresh),
            }
        });
    }

    /// The button that calculates the selected operation, and the switch of automatic calculation.
    fn calculate(&mut self, ui: &mut Ui, command: Command) {
        let text = RichText::new(command.label()).color(egui::Color32::WHITE).strong();
        let button = egui::Button::new(text).fill(theme::PRIMARY);
        let button = ui.add_sized([ui.available_width(), 26.0], button);
        if button.on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
            self.run_command(ui.ctx(), command);
        }
        ui.checkbox(&mut self.state.auto_update, Command::FollowEdits.label())
            .on_hover_text(Command::FollowEdits.tip());
    }

    /// The allowances, which all operations share.
    fn allowances(&mut self, ui: &mut Ui, fresh: bool) {
        let open = self.state.document.part.as_ref();
        let defaults = open.map(|part| part.defaults.clone()).unwrap_or_default();
        let setup = &mut self.state.document.edited.setup;
        let asked = heading(ui, "Allowances", fresh, |ui| panels::setup::stock(ui, setup, &defaults));
        if let Some(command) = asked.flatten() {
            self.run_command(ui.ctx(), command);
        }
    }

    /// The machine of all operations.
    fn machine(&mut self, ui: &mut Ui, fresh: bool) {
        let (setup, machines) = (&self.state.document.edited.setup, &self.state.machines);
        let chosen = heading(ui, "Machine", fresh, |ui| panels::machine::show(ui, setup, machines));
        if let Some(choice) = chosen.flatten() {
            self.choose_machine(ui.ctx(), choice);
        }
    }

    fn roughing_form(&mut self, ui: &mut Ui, fresh: bool) {
        self.calculate(ui, Command::Plan);
        let planned = self.state.results.planned.clone();
        let chosen = planned.as_ref().map(|planned| &planned.outcome.setup);
        let open = self.state.document.part.as_ref();
        let mut defaults = open.map(|part| part.defaults.clone()).unwrap_or_default();
        let setup = &mut self.state.document.edited.setup;
        // That of the machine, which the planner keeps to.
        let machine = setup.machine.file.as_deref();
        let reached_rad = machine.and_then(|machine| self.state.machines.max_axis_tilt_rad(machine));
        defaults.machine.max_axis_tilt_rad = reached_rad.unwrap_or(defaults.machine.max_axis_tilt_rad);
        let known = &mut self.state.look.known_goals;
        heading(ui, "Plunge", fresh, |ui| panels::setup::plunge(ui, setup, known, &defaults, chosen));
        self.allowances(ui, fresh);
        self.machine(ui, fresh);
        if let Some(command) =
            heading(ui, "Variants", fresh, |ui| panels::whatif::show(ui, &mut self.state)).flatten()
        {
            self.run_command(ui.ctx(), command);
        }
        let is_stale = self.state.out_of_date();
        let compare = &mut self.state.compare;
        let preview = self.state.results.preview.as_ref().and_then(|preview| preview.planned.clone());
        heading(ui, "Axis strategies", fresh, |ui| {
            panels::policies::show(ui, compare, (planned.as_deref(), is_stale), preview.as_deref());
        });
        let shown = self.state.last_whole_plan(self.state.look.side).map(|shown| shown.policy);
        let change = self.state.results.tool_change.as_deref();
        let setup = &mut self.state.document.edited.setup;
        let planned = planned.as_deref().zip(shown);
        let asked = heading(ui, "Tools", fresh, |ui| panels::tools::show(ui, setup, planned, change));
        if let Some(command) = asked.flatten() {
            self.run_command(ui.ctx(), command);
        }
    }

    fn flank_form(&mut self, ui: &mut Ui, fresh: bool) {
        self.calculate(ui, Command::PlanFlank);
        let can_export = self.is_available(Command::ExportFlank);
        let export = ui.add_enabled(can_export, egui::Button::new(Command::ExportFlank.label()));
        if export.on_hover_text(Command::ExportFlank.tip()).clicked() {
            self.run_command(ui.ctx(), Command::ExportFlank);
        }
        let open = self.state.document.part.as_ref();
        let defaults = open.map(|part| part.defaults.clone()).unwrap_or_default();
        let flank = self.state.results.flank.clone();
        let setup = &mut self.state.document.edited.setup;
        heading(ui, "Flank milling", fresh, |ui| panels::flank::show(ui, setup, &defaults, flank.as_deref()));
        self.allowances(ui, fresh);
        self.machine(ui, fresh);
        let chosen = flank.as_ref().map(|outcome| &outcome.setup);
        let setup = &mut self.state.document.edited.setup;
        let asked = heading(ui, "Tools", fresh, |ui| panels::tools::show_list(ui, setup, chosen));
        if let Some(command) = asked.flatten() {
            self.run_command(ui.ctx(), command);
        }
        if flank.is_some() {
            heading(ui, "Display", fresh, |ui| panels::flank::display(ui, &mut self.state.look.flank));
        }
    }

    fn program_form(&mut self, ui: &mut Ui, fresh: bool) {
        self.calculate(ui, Command::CheckAgain);
        ui.horizontal(|ui| {
            for command in [Command::CheckProgram, Command::CloseProgram] {
                if ui.button(command.label()).on_hover_text(command.tip()).clicked() {
                    self.run_command(ui.ctx(), command);
                }
            }
        });
        let mut opens_post = false;
        heading(ui, "Program", fresh, |ui| opens_post = panels::program::form(ui, &mut self.state));
        if opens_post {
            self.dialogs.open_dialog(ui.ctx(), Purpose::OpenPostOfCheck, String::new());
        }
        self.allowances(ui, fresh);
    }

    /// The table of the selected operation.
    pub(in crate::app) fn table(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        // Within its own margins, beyond which no row is marked.
        CentralPanel::no_frame().show(ui, |ui| match self.state.look.operation {
            Operation::Roughing => {
                let menu = panels::positions::show(ui, &mut self.state);
                self.run_for_position(ui.ctx(), menu);
            }
            Operation::Flank => panels::flank_passes::show(ui, &mut self.state),
            Operation::Program => panels::program::faults(ui, &mut self.state),
        });
    }

    /// Sectional view and figures of the selected position. `fill_height`: the height to fill, points;
    /// `None`: as high as needed.
    pub(in crate::app) fn details(&mut self, ui: &mut Ui, fill_height: Option<f32>) {
        let Some(k) = self.state.look.selected else { return };
        panels::positions::headline(ui, &self.state, k);
        ui.horizontal(|ui| {
            for (tab, name) in
                [(Tab::Section, "Sectional view"), (Tab::Facts, "Figures"), (Tab::Edit, "By hand")]
            {
                ui.selectable_value(&mut self.state.look.tab, tab, name);
            }
        });
        match self.state.look.tab {
            Tab::Facts => panels::positions::details(ui, &self.state, k),
            Tab::Edit => {
                if let Some(command) = panels::edit_plunge::show(ui, &mut self.state) {
                    self.run_command(ui.ctx(), command);
                }
            }
            Tab::Section => {
                let plane = self.state.cut_plane();
                let can_enlarge = !self.state.look.panels.is_open(DockPanel::SectionalView);
                let look = &mut self.state.look.sectional;
                if panels::section::controls(ui, (&mut look.plane, &mut look.docked), plane, can_enlarge) {
                    self.state.look.panels.open(DockPanel::SectionalView);
                }
                let least = panels::section::height(ui.ctx().content_rect().height());
                let height = fill_height.map_or(least, |fill_height| {
                    (fill_height - ui.min_rect().height() - BELOW_SECTION).max(least)
                });
                let name = format!("Sectional view through position {}", k + 1);
                if !self.section(ui, k, (&name, |look| &mut look.docked), height) {
                    // Reserve the height, so that nothing jumps when the view arrives.
                    ui.allocate_space(egui::vec2(ui.available_width(), height));
                }
            }
        }
    }

    /// The sectional view through position `k`, `height` points high; `false` while there is none yet.
    fn section(
        &mut self,
        ui: &mut Ui,
        k: usize,
        (name, part): (&str, fn(&mut SectionalLook) -> &mut DrawingPart),
        height: f32,
    ) -> bool {
        let plane = self.state.cut_plane();
        let Some(selected) = self.state.selected() else { return true };
        let Some((of, view)) = self.inspected.section() else { return false };
        let stale = of != k || view.plane != plane;
        // The figures are those of the drawing, until that of the selected position is there.
        let drawn = self.state.shown().and_then(|shown| shown.plan().positions.get(of));
        let position = drawn.unwrap_or(selected).clone();
        let part = part(&mut self.state.look.sectional);
        panels::section::show(ui, name, (&view, &position), part, stale, height);
        true
    }

    /// The sectional view, enlarged.
    pub(in crate::app) fn large_section(&mut self, ui: &mut Ui) {
        let Some(k) = self.state.look.selected else { return };
        let plane = self.state.cut_plane();
        let look = &mut self.state.look.sectional;
        panels::section::controls(ui, (&mut look.plane, &mut look.enlarged), plane, false);
        let height = (ui.available_height() - BELOW_SECTION).max(120.0);
        let name = format!("Enlarged sectional view through position {}", k + 1);
        self.section(ui, k, (&name, |look| &mut look.enlarged), height);
    }
}

/// Height of the figures below a sectional view, three lines, points.
const BELOW_SECTION: f32 = 3.0 * theme::ROW_HEIGHT;

/// A heading with its content, open for a new part; the content is not indented, so that it has the whole
/// width.
fn heading<R>(ui: &mut Ui, title: &str, fresh: bool, content: impl FnOnce(&mut Ui) -> R) -> Option<R> {
    let heading = egui::CollapsingHeader::new(title).open(fresh.then_some(true)).default_open(true);
    heading.show_unindented(ui, content).body_returned
}
