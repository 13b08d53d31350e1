//! The units of the window, where views draw.

use egui::{Context, Id, Ui};

use crate::app::model::units::DisplayUnits;

fn key() -> Id {
    Id::unique("display units")
}

/// Makes `units` those of all views of the window.
pub fn set(ctx: &Context, units: DisplayUnits) {
    ctx.data_mut(|data| data.insert_temp(key(), units));
}

/// The units in which `ui` shows lengths and feed rates.
pub fn display_units(ui: &Ui) -> DisplayUnits {
    ui.data(|data| data.get_temp(key())).unwrap_or_default()
}
