//! A field for a number of channels, from the first on.

use egui::Ui;

use super::typed::{self, TypedLimits};
use crate::app::model::number::Quantity;
use crate::app::model::units::DisplayUnits;

/// Name of the field.
const LABEL: &str = "Channels";

/// Draws field and number of all channels side by side, and below them why a number is not taken. `label`:
/// what names the field.
pub fn channels(ui: &mut Ui, chosen: &mut usize, all: usize, label: egui::Id) {
    let form = ui.scope_id();
    let why_most = if all == 1 { ", the only channel of the wheel" } else { ", the channels of the wheel" };
    let limits = TypedLimits {
        quantity: Quantity::Plain,
        units: DisplayUnits::Metric,
        range: 1.0..=all as f64,
        why_least: "",
        why_most,
        show: &|count: f64| format!("{count:.0}"),
    };
    ui.vertical(|ui| {
        let row = ui.horizontal(|ui| {
            let (field, said) = typed::limited_field(ui, chosen, &limits, 0.1);
            typed::keep(ui, form, LABEL, *chosen as f64, said);
            ui.label(format!("of {all}, from the first on"));
            field.labelled_by(label).rect
        });
        typed::show(ui, form, LABEL, *chosen as f64, row.inner);
    });
}
