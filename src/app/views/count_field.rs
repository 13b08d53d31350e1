//! A field for a number of channels, from the first on.

use egui::Ui;

use super::typed::{self, TypedLimits};
use crate::app::model::number::Quantity;
use crate::app::model::units::DisplayUnits;

/// Draws field and number of all channels of the wheel side by side, for a program. `label`: what names the
/// field.
pub fn channels(ui: &mut Ui, chosen: &mut usize, all: usize, label: egui::Id) {
    count(ui, chosen, all, ("Channels", label), ", from the first on");
}

/// The same for the channels that the views show.
pub fn shown_channels(ui: &mut Ui, chosen: &mut usize, all: usize, label: egui::Id) {
    ui.scope(|ui| {
        // In a menu, fields have no ground of their own until the pointer is on them.
        let visuals = &mut ui.visuals_mut().widgets;
        visuals.inactive.weak_bg_fill = visuals.hovered.weak_bg_fill;
        count(ui, chosen, all, ("Channels shown", label), "");
    });
}

/// Draws field and number of all channels side by side, and below them why a number is not taken.
fn count(ui: &mut Ui, chosen: &mut usize, all: usize, (name, label): (&str, egui::Id), which: &str) {
    let form = ui.scope_id();
    let why_most = if all == 1 { ", the only channel of the wheel" } else { ", the channels of the wheel" };
    let limits = TypedLimits {
        quantity: Quantity::Count,
        units: DisplayUnits::Metric,
        range: 1.0..=all as f64,
        why_least: "",
        why_most,
        show: &|count: f64| format!("{count:.0}"),
    };
    ui.vertical(|ui| {
        let row = ui.horizontal(|ui| {
            let (field, said) = typed::limited_field(ui, chosen, &limits, 0.1);
            typed::keep(ui, form, name, *chosen as f64, said);
            ui.label(format!("of {all}{which}"));
            field.labelled_by(label).rect
        });
        typed::show(ui, form, name, *chosen as f64, row.inner);
    });
}
