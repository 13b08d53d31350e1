//! Table of the passes of the flank plan, in cutting order.

use std::sync::Arc;

use egui::{RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

use super::cells::{cell, word_cell};
use super::flank::{region_words, short_region_words};
use crate::app::model::figures::format_clock;
use crate::app::model::flank_passes::FlankPass;
use crate::app::model::flank_run::FlankRun;
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme;
use crate::flank::region::{Region, WallName};

/// Heads of the columns with their meaning, and their widths, points, in mm and in inches, whose numbers are
/// longer.
const COLUMNS: [(&str, &str, [f32; 2]); 5] = [
    ("#", "Number in cutting order", [30.0; 2]),
    ("Layer", "Layer, 1 at the hub", [38.0; 2]),
    ("Region", "Where in the channel, and whether along a wall", [84.0; 2]),
    ("Length", "Length of the pass", [48.0, 54.0]),
    ("Time", "When the pass ends, on the clock of the timeline", [58.0, 54.0]),
];

/// Column after the first one, where several channels are shown.
const CHANNEL: (&str, &str, [f32; 2]) = ("Ch.", "Channel", [19.0; 2]);

/// Space between columns, points.
const SPACING: f32 = 4.0;
/// Space for the scroll bar, points.
const SCROLL_BAR: f32 = 5.0;

/// The columns, with that of the channel where `several` are shown.
fn columns(several: bool) -> impl Iterator<Item = (&'static str, &'static str, [f32; 2])> {
    let first = COLUMNS.into_iter().take(1);
    first.chain(several.then_some(CHANNEL)).chain(COLUMNS.into_iter().skip(1))
}

/// Index of the widths of the columns in these units.
fn width_index(units: DisplayUnits) -> usize {
    usize::from(units == DisplayUnits::Inch)
}

/// The flank plan in its channels, if several are shown.
fn several_channels(state: &AppState) -> Option<&Arc<FlankRun>> {
    state.results.flank_run.as_ref().filter(|run| run.count() > 1)
}

/// Width of all columns, points.
pub fn columns_width(state: &AppState) -> f32 {
    let unit = width_index(state.look.units);
    let widths = columns(several_channels(state).is_some()).map(|(_, _, widths)| widths[unit] + SPACING);
    widths.sum::<f32>() + SCROLL_BAR
}

/// Draws the table; a click on a row selects the pass.
pub fn show(ui: &mut Ui, state: &mut AppState) {
    let found = Arc::clone(&state.results.passes);
    let layout = state.results.flank.as_ref().map(|outcome| &outcome.plan.layout);
    let of_one = layout.map_or(0, |layout| layout.totals[layout.strategy as usize].passes);
    let passes = of_one * state.results.flank_run.as_ref().map_or(1, |run| run.count());
    let title = match passes == found.passes.len() {
        true => "Passes".to_owned(),
        false => format!("{} cuts of {passes} passes", found.passes.len()),
    };
    let tip = "A pass is several cuts where the tool leaves it between: at blades and where it is not cut";
    ui.label(RichText::new(title).strong()).on_hover_text(tip);
    if found.passes.is_empty() {
        ui.label(RichText::new("The plan has no passes").weak());
        return;
    }
    let several = several_channels(state).cloned();
    ui.spacing_mut().item_spacing.x = SPACING;
    let selected = state.look.flank.pass;
    // Its own place of scrolling, and a new one for another part.
    let part = state.document.part.as_ref().map(|part| part.hash.fnv1a);
    let mut builder = TableBuilder::new(ui)
        .id_salt(("flank passes", part))
        .striped(true)
        .sense(Sense::CLICK)
        .auto_shrink([false, false])
        // No higher than its place, however low that is.
        .min_scrolled_height(0.0)
        // A row revealed while the table still moves to another one would be missed.
        .animate_scrolling(false)
        .cell_layout(egui::Layout::right_to_left(egui::Align::Center));
    let splitters = splitter_count(state);
    let unit = width_index(state.look.units);
    let columns = || columns(several.is_some());
    for (_, _, widths) in columns() {
        builder = builder.column(Column::exact(widths[unit]));
    }
    builder = builder.column(Column::remainder());
    let reveal = std::mem::take(&mut state.look.flank.reveal);
    if let Some(row) = selected.filter(|_| reveal) {
        builder = builder.scroll_to_row(row, None);
    }
    let (mut clicked, units) = (None, state.look.units);
    builder
        .header(theme::ROW_HEIGHT, |mut header| {
            for (head, tip, _) in columns() {
                header.col(|ui| {
                    ui.label(RichText::new(head).weak()).on_hover_text(tip);
                });
            }
            // Space for the scroll bar.
            header.col(|_| ());
        })
        .body(|body| {
            body.rows(theme::ROW_HEIGHT, found.passes.len(), |mut row| {
                let k = row.index();
                let Some(pass) = found.passes.get(k) else { return };
                row.set_selected(selected == Some(k));
                let region = match pass.region {
                    // A pass round its nose stands in the region that it divides.
                    Region::INLET if pass.along_wall && splitters > 0 => "splitter",
                    region => short_region_words(region, splitters),
                };
                let wall = if pass.along_wall { " wall" } else { "" };
                let channel = several.as_ref().map(|run| (run.channel_of(pass.from) + 1).to_string());
                let numbers = [Some((k + 1).to_string()), channel, Some((pass.layer + 1).to_string())];
                for text in numbers.into_iter().flatten() {
                    row.col(|ui| cell(ui, RichText::new(text)));
                }
                row.col(|ui| word_cell(ui, &format!("{region}{wall}")));
                let time = state.time_after(pass.end).map_or_else(String::new, format_clock);
                for text in [units.number(pass.length, 1), time] {
                    row.col(|ui| cell(ui, RichText::new(text)));
                }
                row.col(|_| ());
                let response = row.response();
                let name = format!("Pass {}", k + 1);
                response.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::Row, true, selected == Some(k), &name)
                });
                if response.on_hover_ui(|ui| describe(ui, state, k, pass)).clicked() {
                    clicked = Some(k);
                }
            });
        });
    if let Some(k) = clicked {
        state.select_pass(Some(k));
    }
}

/// Number of splitters between two main blades.
fn splitter_count(state: &AppState) -> usize {
    state.results.flank.as_ref().map_or(0, |outcome| outcome.workpiece.part.splitters.len())
}

/// What pass `k` is, how fast it goes and when.
pub fn describe(ui: &mut Ui, state: &AppState, k: usize, pass: &FlankPass) {
    let wall = match pass.region {
        _ if !pass.along_wall => "",
        Region { low: WallName::Low, .. } => ", along the suction side",
        Region { high: WallName::High, .. } => ", along the pressure side",
        _ => ", along a splitter",
    };
    let channel = several_channels(state)
        .map_or_else(String::new, |run| format!(" channel {},", run.channel_of(pass.from) + 1));
    ui.label(RichText::new(format!("Pass {}:{channel} layer {}{wall}", k + 1, pass.layer + 1)).strong());
    if !pass.along_wall {
        ui.label(region_words(pass.region, splitter_count(state)));
    }
    let [low, high] = pass.feeds;
    let units = state.look.units;
    let feeds = match high - low < 0.5 {
        true => units.feed(high),
        false => format!("{} to {}", units.number(low, 0), units.feed(high)),
    };
    ui.label(format!("{} at {feeds}, {:.1} s", units.length(pass.length, 1), pass.time));
    ui.label(format!("The axis turns by {:.1}°", pass.turn.to_degrees()));
    if let Some(time) = state.time_after(pass.end) {
        ui.label(format!("Cut after {}", format_clock(time)));
    }
}
