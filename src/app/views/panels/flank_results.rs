//! Results of the flank plan: the verdict line, the comparison of the strategies, faults and stretches that
//! are left out.

use egui::{Grid, RichText, ScrollArea, Ui};

use crate::flank::UncutLength;
use crate::flank::choice::overhang_note;
use crate::io::flank_file::ShownWall;
use crate::job::flank::FlankOutcome;
use crate::setup::FlankStrategy;
use crate::verify::{FlankVerdict, Uncovered};

use super::figures::{divide, divided_figure};
use super::flank::{strategy_label, wall_side_words};
use crate::app::model::figures::{
    ABOVE_SCALLOP, ABOVE_SCALLOP_TIP, MAX_GOOD_UNCUT_SHARE, flank_times_tip, format_duration, format_percent,
    format_times,
};
use crate::app::model::flank_skips::{SkippedReason, skipped_by_reason, skipped_length};
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::model::verdict::{self, count_skipped_stretches, count_stretches};
use crate::app::views::theme::Condition;
use crate::app::views::units;
use crate::report::words::as_sentence;

/// Maximum number of faults that are listed.
const MAX_LISTED: usize = 200;

/// Draws the verdict line.
pub fn verdict(ui: &mut Ui, state: &AppState) {
    let Some(outcome) = &state.results.flank else {
        ui.label(RichText::new(state.results.words_without_flank()).weak());
        return;
    };
    let amber = Condition::Blocked.text(ui.visuals());
    if state.flank_is_stale() {
        let text = RichText::new("Out of date:").color(amber);
        ui.label(text).on_hover_text("The setup was edited after this calculation");
    }
    let faults = outcome.faults.len();
    let skipped = outcome.plan.uncut.len();
    let (condition, _) = verdict::of_flank(state, outcome);
    let text = RichText::new(format!("Faults {faults}")).strong().color(condition.text(ui.visuals()));
    ui.label(text).on_hover_text("Overcut walls, collisions of shank and holder, rapids through stock");
    if outcome.verdict.is_none() {
        ui.label(RichText::new("not verified").color(amber));
    }
    if skipped > 0 {
        let text = RichText::new(count_skipped_stretches(skipped)).color(amber);
        let line = |SkippedReason { message, stretches }| format!("\n{message}: {}", stretches.len());
        let reasons: String = skipped_by_reason(&outcome.plan.uncut).into_iter().map(line).collect();
        ui.label(text).on_hover_text(format!("Stretches of passes that are not cut:{reasons}"));
    }
    let units = state.look.units;
    let walls = units.deviations(outcome.max_overcut(), outcome.max_undercut());
    divided_figure(
        ui,
        "Wall error",
        walls,
        "Largest overcut below the blade allowance, and largest undercut above it",
    );
    for LeftFigure { name, shares } in left_figures(outcome) {
        let words: Vec<&str> = std::iter::once(name).chain(shares.iter().map(|s| &*s.text)).collect();
        divide(ui, &words);
        let all: Vec<&str> = shares.iter().map(|share| &*share.tip).collect();
        ui.label(RichText::new(name).weak()).on_hover_text(all.join("\n"));
        for LeftShare { text, counted, tip } in shares {
            let text = RichText::new(text);
            let text = if counted > MAX_GOOD_UNCUT_SHARE { text.strong().color(amber) } else { text };
            ui.label(text).on_hover_text(tip);
        }
    }
    divided_figure(ui, "Layers", outcome.plan.layout.layers.len().to_string(), "Layers from the hub up");
    let times = match outcome.wheel_time_s {
        Some(wheel) => format_times(outcome.time_s(), wheel),
        None => format!("{} per channel", format_duration(outcome.time_s())),
    };
    divided_figure(ui, "Time", times, flank_times_tip(outcome));
}

/// What the program leaves of floor or walls.
struct LeftFigure {
    name: &'static str,
    shares: Vec<LeftShare>,
}

/// A share of the floor or of the walls that the program leaves.
struct LeftShare {
    text: String,
    /// How much of it another program with the same cutter would not leave.
    counted: f64,
    tip: String,
}

/// What the program leaves; nothing where it is not verified.
fn left_figures(outcome: &FlankOutcome) -> Vec<LeftFigure> {
    let Some(verdict) = &outcome.verdict else { return Vec::new() };
    let (parts, gap) = (parts_words(&verdict.uncovered), verdict.uncovered.gap);
    let above = LeftShare {
        text: format_percent(verdict.uncovered.share()),
        counted: gap,
        tip: format!("{ABOVE_SCALLOP_TIP}:\n{parts}"),
    };
    let uncut = verdict.layer.uncut_share.into();
    let floor = LeftShare {
        text: format!("{} floor", format_percent(uncut)),
        counted: uncut,
        tip: "Share of the accessible floor that is not cut".to_owned(),
    };
    let walls = LeftShare {
        text: format!("{} walls", format_percent(verdict.unmilled_wall_share)),
        counted: verdict.unmilled_wall_share,
        tip: format!("Share of the walls that is not milled{}", wall_words(outcome, verdict)),
    };
    vec![
        LeftFigure { name: ABOVE_SCALLOP, shares: vec![above] },
        LeftFigure { name: "Not machined", shares: vec![floor, walls] },
    ]
}

/// The share of each wall that is not milled, a line each.
fn wall_words(outcome: &FlankOutcome, verdict: &FlankVerdict) -> String {
    let walls = outcome.shown_walls();
    let splitters = outcome.workpiece.channel.splitters.len();
    let known = walls.iter().zip(&verdict.unmilled_walls).filter(|(_, share)| share.is_finite());
    let line = |(of, &share): (&ShownWall, &f64)| {
        format!("\n{}: {}", wall_side_words(of.wall, of.region, splitters), format_percent(share))
    };
    known.map(line).collect()
}

/// What the share of the floor above the scallop height consists of.
fn parts_words(uncovered: &Uncovered) -> String {
    let Uncovered { fillet, no_axis, gap } = *uncovered;
    let [fillet, no_axis, gaps] = [fillet, no_axis, gap].map(format_percent);
    format!("{fillet} fillet beside blades, {no_axis} inaccessible, {gaps} gaps of the program")
}

/// Draws the results.
pub fn show(ui: &mut Ui, state: &AppState) {
    ui.label(RichText::new("Flank milling").strong());
    let Some(outcome) = &state.results.flank else {
        ui.add_space(6.0);
        ui.label(RichText::new(state.results.words_without_flank()).weak());
        return;
    };
    ScrollArea::vertical().id_salt("flank results").auto_shrink(false).show(ui, |ui| {
        table(ui, outcome);
        ui.separator();
        faults(ui, outcome);
    });
}

fn faults(ui: &mut Ui, outcome: &FlankOutcome) {
    if outcome.faults.is_empty() {
        let text = RichText::new("No faults").color(Condition::Sound.text(ui.visuals()));
        ui.label(text);
        return;
    }
    let colour = Condition::Interfering.text(ui.visuals());
    ui.label(RichText::new(format!("{} faults", outcome.faults.len())).color(colour));
    for fault in outcome.faults.iter().take(MAX_LISTED) {
        ui.add(egui::Label::new(format!("Line {}: {fault}", fault.line)).wrap());
    }
}

/// Draws the reasons of skipped stretches of passes, with number and length of each below it: beside them a
/// reason would have a column of a few letters.
fn skipped(ui: &mut Ui, uncut: &[UncutLength], units: DisplayUnits) {
    for SkippedReason { message, stretches } in skipped_by_reason(uncut) {
        ui.add(egui::Label::new(as_sentence(message.to_owned())).wrap());
        let count = count_stretches(stretches.len());
        ui.label(RichText::new(format!("{count}, {}", skipped_length(&stretches, units))).weak());
    }
}

fn table(ui: &mut Ui, outcome: &FlankOutcome) {
    let (plan, curves) = (&outcome.plan, &outcome.plan.layout);
    let units = units::display_units(ui);
    let length_head = match units {
        DisplayUnits::Metric => "Length m",
        DisplayUnits::Inch => "Length in",
    };
    Grid::new("strategies").num_columns(4).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
        for (name, tip) in [
            ("Strategy", "Layout of the passes in a layer"),
            (length_head, "Length of all passes of one channel"),
            ("Ratio", "Ratio to the length of the isoparametric passes"),
            ("Gaps", "Over-wide gaps: share of the area in gaps wider than 1.02 times the stepover"),
        ] {
            ui.label(RichText::new(name).weak()).on_hover_text(tip);
        }
        ui.end_row();
        for strategy in FlankStrategy::ALL {
            let figures = &curves.totals[strategy as usize];
            let name = RichText::new(strategy_label(strategy));
            ui.label(if strategy == curves.strategy { name.strong() } else { name });
            ui.label(match units {
                DisplayUnits::Metric => format!("{:.2}", 1e-3 * figures.length),
                DisplayUnits::Inch => format!("{:.0}", units.of_mm(figures.length)),
            });
            ui.label(format!("{:.3}", figures.length / curves.totals[0].length));
            let measured = strategy != FlankStrategy::Isoparametric || strategy == curves.strategy;
            ui.label(if measured {
                format!("{:.2} %", 100.0 * curves.wide_share(strategy))
            } else {
                "-".to_owned()
            });
            ui.end_row();
        }
    });
    if let Some(note) = curves.replacement_note() {
        ui.label(note);
    }
    ui.label(format!(
        "{} layers, cutter {}, floor {}; wall error: {} overcut, {} undercut; {}",
        curves.layers.len(),
        units.diameter(plan.tool.diameter),
        match units {
            DisplayUnits::Metric => format!("{:.2} m", 1e-3 * curves.floor_length),
            DisplayUnits::Inch => format!("{:.0} in", units.of_mm(curves.floor_length)),
        },
        units.deviation(-outcome.max_overcut()),
        units.deviation(outcome.max_undercut()),
        // No line breaks within it.
        format_duration(outcome.time_s()).replace(' ', "\u{a0}"),
    ));
    if let Some(verdict) = &outcome.verdict {
        ui.label(format!(
            "{} of the accessible floor and {} of the walls is not machined. {} of the floor keeps more stock \
             than the scallop height: {}",
            format_percent(verdict.layer.uncut_share.into()),
            format_percent(verdict.unmilled_wall_share),
            format_percent(verdict.uncovered.share()),
            parts_words(&verdict.uncovered),
        ));
    }
    if !plan.uncut.is_empty() {
        let lost = skipped_length(&plan.uncut, units);
        ui.label(format!("{lost} of passes are skipped:"));
        skipped(ui, &plan.uncut, units);
        if let Some(note) = overhang_note(&plan.tool, &plan.uncut, &outcome.workpiece.part) {
            ui.label(as_sentence(note));
        }
    }
}
