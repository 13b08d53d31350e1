//! The machinability of the part: what `vanecut assess` prints and draws, in a panel.

use egui::{Grid, RichText, ScrollArea, Ui};

use crate::app::App;
use crate::app::model::units::DisplayUnits;
use crate::app::views::chart;
use crate::app::views::command::Command;
use crate::app::views::units;
use crate::assess::reach::ReachSides;
use crate::job::assess::AssessedPart;
use crate::report::assessment::assessment_charts;
use crate::report::assessment_figures::{BLADE_FIGURES, BladeSize};

impl App {
    /// The machinability of the part.
    pub(in crate::app) fn machinability(&mut self, ui: &mut Ui) {
        let assessed = self.assessing.known(&self.state).map(|assessed| &**assessed);
        if let Some(command) = show(ui, assessed, self.assessing.is_busy()) {
            self.run_command(ui.ctx(), command);
        }
    }
}

/// Draws the figures, or that they are being measured; returns the command that was chosen.
fn show(ui: &mut Ui, assessed: Option<&AssessedPart>, is_busy: bool) -> Option<Command> {
    let Some(assessed) = assessed else {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label("Measuring…");
        });
        return None;
    };
    let mut command = None;
    ui.horizontal(|ui| {
        let save = Command::SaveAssessment;
        if ui.button(save.label()).on_hover_text(save.tip()).clicked() {
            command = Some(save);
        }
        if is_busy {
            ui.spinner();
            ui.label(RichText::new("Measuring with the edited setup…").weak());
        }
    });
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        figures(ui, assessed);
        reach(ui, assessed);
        ui.add_space(8.0);
        let charts = assessment_charts(&assessed.workpiece, &assessed.assessment);
        for chart in &charts {
            chart::show(ui, chart);
            ui.add_space(8.0);
        }
    });
    command
}

/// A length; a dash where it could not be measured.
fn shown_length(value: f64, units: DisplayUnits) -> String {
    if value.is_finite() { units.length(value, 2) } else { "–".to_owned() }
}

fn size_text(size: BladeSize, units: DisplayUnits) -> String {
    match size {
        BladeSize::AngleRad(angle) => format!("{:.1}°", angle.to_degrees()),
        BladeSize::LengthMm(length) => units.length(length, 3),
    }
}

/// Passages, then blade by blade.
fn figures(ui: &mut Ui, assessed: &AssessedPart) {
    let measured = &assessed.assessment;
    let (narrow, wide) = measured.width_range();
    let units = units::display_units(ui);
    let mm = |value: f64| shown_length(value, units);
    let is_known = narrow.is_finite() && wide.is_finite();
    let widths = if is_known { units.range(narrow, wide, 2) } else { mm(narrow) };
    Grid::new("passages").num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (name, value, tip) in [
            ("Largest cutter", mm(measured.largest_cutter()), CUTTER_TIP),
            ("Width of passages", widths, WIDTH_TIP),
            ("Depth up to", mm(measured.depth()), DEPTH_TIP),
        ] {
            ui.label(name).on_hover_text(tip);
            ui.label(value);
            ui.end_row();
        }
    });
    ui.add_space(8.0);
    // A column for each blade: there are fewer of them than figures.
    Grid::new("blades").num_columns(1 + measured.blades.len()).striped(true).spacing([16.0, 3.0]).show(
        ui,
        |ui| {
            ui.label(RichText::new("Blade").strong())
                .on_hover_text("Main blade, and the splitters of a pitch");
            for blade in &measured.blades {
                ui.label(RichText::new(&blade.name).strong());
            }
            ui.end_row();
            for figure in BLADE_FIGURES {
                ui.label(figure.name).on_hover_text(figure.meaning);
                for blade in &measured.blades {
                    ui.label(size_text((figure.size)(blade), units));
                }
                ui.end_row();
            }
        },
    );
}

const CUTTER_TIP: &str =
    "Diameter of the largest cutter that fits everywhere along the channel, down to the hub";
const WIDTH_TIP: &str = "Distance between the walls of a passage: the least and the greatest";
const DEPTH_TIP: &str = "Distance from shroud to hub";

/// What the tools reach of the floor, section by section.
fn reach(ui: &mut Ui, assessed: &AssessedPart) {
    ui.add_space(8.0);
    let Some(map) = &assessed.assessment.reach else {
        if let Some(fault) = &assessed.no_reach {
            ui.label(format!("Reach is not known: {fault}"));
        }
        return;
    };
    ui.label("Share of the floor that is reached, %");
    Grid::new("reach").num_columns(5).min_col_width(0.0).striped(true).spacing([7.0, 3.0]).show(ui, |ui| {
        for (name, tip) in REACH_COLUMNS {
            ui.label(RichText::new(name).strong()).on_hover_text(tip);
        }
        ui.end_row();
        for (index, section) in assessed.sections().into_iter().enumerate() {
            let tool = units::display_units(ui).diameter(section.tool.diameter);
            ui.label(format!("{tool}, {:.2}–{:.2}{}", section.from, section.to, section.kind.suffix()));
            for class in ReachSides::CLASSES {
                ui.label(format!("{:.1}", 100.0 * map.share_of_section(index, class)));
            }
            ui.end_row();
        }
        ui.label("all");
        for class in ReachSides::CLASSES {
            ui.label(format!("{:.1}", 100.0 * map.share(class)));
        }
        ui.end_row();
    });
}

const REACH_COLUMNS: [(&str, &str); 5] = [
    ("Section", "Tool of the section; from and to along the hub: 0 leading edge, 1 outlet"),
    ("Any", "Share of the floor that the tool reaches from any side"),
    ("Outlet", "Share that it reaches with its axis leaning towards the outlet"),
    ("Inlet", "Share that it reaches with its axis leaning towards the inlet"),
    ("Both", "Share that it reaches from both"),
];
