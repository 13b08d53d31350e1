//! Table of positions, and the figures of the selected one.

use std::sync::Arc;

use egui::style::KineticScrollStyle;
use egui::{ComboBox, Grid, Popup, RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

use super::axis_demand::{axis_remarks, axis_text, axis_warning};
use super::cells::{cell, mark};
use super::hand_mark::{hand_mark, hand_words};
use crate::plunge::{Blocked, PlungeMark, Position};

use crate::app::model::figures::format_clock;
use crate::app::model::look::{Filter, REVEAL, TableColumn as Key};
use crate::app::model::number::with_minus_signs;
use crate::app::model::planned::Side;
use crate::app::model::state::{AppState, ShownPlan};
use crate::app::model::units::{DisplayUnits, decimals_beside};
use crate::app::views::command::Command;
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;

/// Reason why a position is blocked.
pub fn blocked_reason(blocked: Blocked) -> &'static str {
    match blocked {
        Blocked::Walls => "no axis with the requested lead angle clears both walls",
        Blocked::ShroudEnd => "the shroud ends before the requested lead angle is reached",
        Blocked::TiltLimit => "the requested lead angle exceeds the tilt limit",
    }
}

/// Draws the table; a click on a row selects. Returns a command from the context menu of a row, with the
/// position it is for.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<(Command, usize)> {
    ui.horizontal(|ui| {
        let title = ui.label(RichText::new("Positions").strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ComboBox::from_id_salt("position filter")
                .width(132.0)
                .selected_text(state.look.filter.label())
                .show_ui(ui, |ui| {
                    let has_machine = state.on_machine().is_some();
                    let shown = |filter: &Filter| has_machine || *filter != Filter::AxisWarnings;
                    for filter in Filter::ALL.into_iter().filter(shown) {
                        ui.selectable_value(&mut state.look.filter, filter, filter.label());
                    }
                })
                .response
                .labelled_by(title.id);
        });
    });
    if state.results.planned.is_none() {
        ui.add_space(6.0);
        ui.label(RichText::new(state.results.words_without_plan()).weak());
        return None;
    }
    let rows = state.rows();
    if rows.is_empty() {
        ui.add_space(6.0);
        let words = match state.look.filter {
            Filter::All => "The plan has no positions",
            Filter::Interfering => "No interfering plunge",
            Filter::Blocked => "No blocked position",
            Filter::AxisWarnings => "No position beyond a limit of the machine or near its pole",
        };
        ui.label(RichText::new(words).weak());
        return None;
    }
    table(ui, state, &rows)
}

/// Commands for a position, in the context menus of tables, plots and views.
const POSITION_COMMANDS: [Command; 4] =
    [Command::ShowInTable, Command::OpenSection, Command::ScrubHere, Command::FlyToSelection];
/// Those that edit it, where the plan can be edited.
const POSITION_EDITS: [Command; 5] =
    [Command::EditPlunge, Command::DeletePlunge, Command::DeleteRow, Command::LockPlunge, Command::LockRow];

/// Whether a command is for a position.
pub fn is_for_position(command: Command) -> bool {
    POSITION_COMMANDS.contains(&command) || POSITION_EDITS.contains(&command)
}

/// Draws the context menu of position `k`; returns the chosen command. `can_edit`: whether the plan can be
/// edited.
pub fn position_menu(ui: &mut Ui, k: usize, can_edit: bool) -> Option<Command> {
    ui.label(RichText::new(format!("At position {}", k + 1)).strong());
    let mut chosen = None;
    for command in POSITION_COMMANDS {
        chosen = command.menu_item(ui, true).then_some(command).or(chosen);
    }
    if can_edit {
        ui.menu_button("Change by hand", |ui| {
            for command in POSITION_EDITS {
                chosen = command.menu_item(ui, true).then_some(command).or(chosen);
            }
        });
    }
    chosen
}

fn table(ui: &mut Ui, state: &mut AppState, rows: &[usize]) -> Option<(Command, usize)> {
    let reveal = state.look.reveal_selection > 0;
    state.look.reveal_selection = state.look.reveal_selection.saturating_sub(1);
    let selected = state.look.selected;
    let sort = state.look.sort;
    let shown = state.shown()?;
    let plan = shown.plan();
    let pitch = theme::ROW_HEIGHT + ui.spacing().item_spacing.y;
    // Of this frame: the panel below may just have taken some of it.
    let height = ui.available_height() - pitch;
    let has_machine = state.document.edited.setup.machine.file.is_some();
    let (can_edit, units) = (state.editable_plan().is_some(), state.look.units);
    let stock_decimals = stock_decimals(state);
    let keys = || Key::ALL.into_iter().filter(move |key| has_machine || *key != Key::Axes);
    // The offset is set beyond the end of the higher table that was there before a panel opened below: a
    // scroll with momentum would take that for a fling, and go on to where that end was.
    ui.spacing_mut().scroll.kinetic =
        KineticScrollStyle { decay_time: 0.0, rubber_band: false, ..KineticScrollStyle::default() };
    let mut builder = TableBuilder::new(ui)
        .striped(true)
        // The arrows go from row to row; each cell would be a stop of the Tab key.
        .sense(Sense::CLICK)
        .auto_shrink([false, false])
        // No higher than its place, however low that is.
        .min_scrolled_height(0.0)
        .cell_layout(egui::Layout::right_to_left(egui::Align::Center));
    for width in widths(state) {
        builder = builder.column(Column::exact(width));
    }
    builder = builder.column(Column::remainder());
    // The offset acts in this frame; scrolling to a row would act in the next one, many positions later while
    // the timeline plays.
    let mut scroll = state.look.table;
    let row = selected.and_then(|k| rows.iter().position(|&r| r == k));
    let row = row.filter(|&row| reveal || scroll.loses(row, pitch, height));
    scroll.height = height;
    if let Some(row) = row {
        builder = builder.vertical_scroll_offset(scroll.showing(row, pitch, height));
    } else if scroll.is_new {
        builder = builder.vertical_scroll_offset(0.0);
    }
    let (mut clicked, mut sorted, mut chosen) = (None, None, None);
    let output = builder
        .header(theme::ROW_HEIGHT, |mut header| {
            header.col(|_| ());
            for key in keys() {
                header.col(|ui| {
                    if head(ui, (key, units), (sort.column == key).then_some(sort.descending)) {
                        sorted = Some(sort.clicked(key));
                    }
                });
            }
            header.col(|_| ());
        })
        .body(|body| {
            body.rows(theme::ROW_HEIGHT, rows.len(), |mut row| {
                let k = rows[row.index()];
                let Some(position) = plan.positions.get(k) else { return };
                row.set_selected(selected == Some(k));
                let tool = plan.sections.get(position.section).map(|section| &section.tool);
                let of = position.condition();
                let by_hand = state.plunge_mark(k);
                row.col(|ui| mark(ui, of));
                let cells = [
                    (k + 1).to_string(),
                    (position.row + 1).to_string(),
                    tool.map_or(String::new(), |t| units.size(t.diameter)),
                    with_minus_signs(&format!("{:.1}", position.alpha_rad.to_degrees())),
                ];
                for (column, text) in cells.into_iter().enumerate() {
                    row.col(|ui| {
                        // Beside the number.
                        if column == 0 {
                            hand_mark(ui, ui.max_rect().left_center(), by_hand);
                        }
                        cell(ui, RichText::new(text));
                    });
                }
                row.col(|ui| {
                    let text = RichText::new(depth(position.evaluation.contact.depth, units));
                    let colour = Condition::Interfering.text(ui.visuals());
                    let interferes = position.evaluation.contact.interferes();
                    cell(ui, if interferes { text.color(colour).strong() } else { text });
                });
                row.col(|ui| {
                    let stock = shown.stock(k);
                    cell(
                        ui,
                        RichText::new(if stock.is_finite() {
                            units.number(stock.into(), stock_decimals)
                        } else {
                            "-".into()
                        }),
                    );
                });
                let demand = state.axis_demand(k);
                if has_machine {
                    row.col(|ui| axis_warning(ui, demand, units));
                }
                // Space for the scroll bar.
                row.col(|_| ());
                let name = format!("Position {}", k + 1);
                let response = row.response();
                response.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::Row, true, selected == Some(k), &name)
                });
                if let Some(menu) = Popup::context_menu(&response).show(|ui| position_menu(ui, k, can_edit)) {
                    chosen = chosen.or(menu.inner.map(|command| (command, k)));
                }
                if response.on_hover_ui(|ui| row_tooltip(ui, state, k, position)).clicked() {
                    clicked = Some(k);
                }
            });
        });
    scroll.offset = output.state.unclamped_offset().y;
    scroll.is_new = false;
    state.look.table = scroll;
    if let Some(k) = clicked {
        state.look.select_and_zoom(Some(k));
        // Do not scroll: the row is under the cursor.
        state.look.reveal_selection = 0;
    }
    if let Some(sort) = sorted {
        state.look.sort = sort;
        state.look.reveal_selection = REVEAL;
    }
    chosen
}

/// Head of a column; `true` when it was clicked. `sorted`: whether the table is sorted by it, largest first.
fn head(ui: &mut Ui, (key, units): (Key, DisplayUnits), sorted: Option<bool>) -> bool {
    let text = RichText::new(key.label());
    let text = if sorted.is_some() { text.strong() } else { text.weak() };
    let response = ui.add(egui::Label::new(text).selectable(false).sense(Sense::click()));
    if let Some(descending) = sorted {
        theme::sort_mark(ui, response.rect.center_bottom(), descending);
    }
    let name = format!("Sort by {}", key.name());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    let unit = match key {
        Key::Diameter | Key::Contact | Key::Hub => format!(", {}", units.length_unit()),
        Key::Order | Key::Row | Key::Alpha | Key::Axes => String::new(),
    };
    response.on_hover_text(format!("{}{unit}; click to sort", key.tip())).clicked()
}

/// Least widths of the columns from the mark of the state to the axis warnings, points.
const WIDTHS: [f32; 8] = [12.0, 30.0, 28.0, 30.0, 46.0, 50.0, 44.0, 54.0];
/// Width of a digit, points.
const DIGIT_WIDTH: f32 = 7.3;
/// Space before a length in inches, points.
const INCH_SPACE: f32 = 8.0;
/// Space beside the number of a position for the mark of what was done by hand, points.
const MARK_SPACE: f32 = 8.0;
/// Space between columns, points.
const SPACING: f32 = 6.0;

/// Decimals, of mm, of the stock on the hub.
fn stock_decimals(state: &AppState) -> usize {
    decimals_beside(state.document.edited.setup.allowances.hub_allowance)
}

/// Widths of the columns: all digits of every number fit, points. Lengths in inches have more of them.
fn widths(state: &AppState) -> Vec<f32> {
    let units = state.look.units;
    let plan = state.shown().map(|shown| shown.plan());
    let sections = plan.map(|plan| &plan.sections[..]).unwrap_or_default();
    let diameter = sections.iter().map(|section| units.size(section.tool.diameter).chars().count());
    // As long as the deepest contact and the least stock there are.
    let [contact, hub] =
        [(9.99, 2), (-9.99, stock_decimals(state))].map(|(mm, n)| units.number(mm, n).chars().count());
    let count = plan.map_or(0, |plan| plan.positions.len()).to_string().len();
    let digits = [0, count, 0, diameter.max().unwrap_or(0), 0, contact, hub, 0];
    let shown = if state.document.edited.setup.machine.file.is_some() { 8 } else { 7 };
    // Beside four decimals, numbers would read as one without more space.
    let space = if units == DisplayUnits::Inch { INCH_SPACE } else { 0.0 };
    let width = |(least, digits): (f32, usize)| {
        least.max((DIGIT_WIDTH * digits as f32).ceil() + if digits > 3 { space } else { 0.0 })
    };
    let mut widths: Vec<f32> = WIDTHS.into_iter().zip(digits).take(shown).map(width).collect();
    widths[1] = widths[1].max((DIGIT_WIDTH * count as f32).ceil() + MARK_SPACE);
    widths
}

/// Width of the columns with the space between them, points.
pub fn columns_width(state: &AppState) -> f32 {
    widths(state).into_iter().map(|width| width + SPACING).sum()
}

/// Contact depth, from mm; "0" if it would round to 0.00 mm.
fn depth(depth: f64, units: DisplayUnits) -> String {
    if depth < 0.005 { "0".to_owned() } else { units.number(depth, 2) }
}

/// Number and state of the selected position.
pub fn headline(ui: &mut Ui, state: &AppState, k: usize) {
    let Some(plan) = state.shown().map(|shown| shown.plan()) else { return };
    let Some(position) = plan.positions.get(k) else { return };
    ui.add_space(4.0);
    let of = position.condition();
    ui.horizontal(|ui| {
        mark(ui, of);
        let channel = match state.look.selected_channel {
            0 => String::new(),
            ahead => format!(", channel {}", ahead + 1),
        };
        let text = format!("Position {} of {}{channel}: {}", k + 1, plan.positions.len(), of.label());
        ui.label(RichText::new(text).strong());
        match state.plunge_mark(k) {
            PlungeMark::Planned => {}
            PlungeMark::Edited => drop(ui.label(RichText::new("edited").weak())),
            PlungeMark::Locked(_) => drop(ui.label(RichText::new("locked").weak())),
        }
    });
    // What makes it interfere, if that is not the contact of its core.
    let breach = position.evaluation.breach.filter(|_| !position.evaluation.contact.interferes());
    if let Some(breach) = breach {
        let text = RichText::new(breach.words()).color(of.text(ui.visuals()));
        ui.add(egui::Label::new(text).truncate());
    }
}

/// Figures of the selected position.
pub fn details(ui: &mut Ui, state: &AppState, k: usize) {
    let Some(shown) = state.shown() else { return };
    let plan = shown.plan();
    let Some(position) = plan.positions.get(k) else { return };
    let units = state.look.units;
    remarks(ui, position);
    axis_remarks(ui, state, k);
    Grid::new("position facts").num_columns(2).spacing([10.0, 1.0]).show(ui, |ui| {
        let mut fact = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.label(value);
            ui.end_row();
        };
        let section = plan.sections.get(position.section);
        if let Some(tool) = section.map(|section| &section.tool) {
            let place = format!("section {}, row {}", position.section + 1, position.row + 1);
            fact("Location", format!("{place}, T{} {}", tool.number, units.diameter(tool.diameter)));
        }
        let contact = position.evaluation.contact;
        if contact.interferes() {
            fact(
                "Core hits stock",
                format!(
                    "{}, {:.0} % of its area",
                    units.length(contact.depth, 2),
                    100.0 * contact.area_share
                ),
            );
        }
        let point = |numbers: [f64; 3]| {
            let numbers = numbers.map(|mm| units.number(mm, 3));
            format!("{} {}", numbers.join(" "), units.length_unit())
        };
        let (tip, axis) = state.selected_in_channel().unwrap_or((position.tip, position.axis));
        fact("Tool tip X Y Z", point([tip.x, tip.y, tip.z]));
        let [i, j, l] = [axis.x, axis.y, axis.z];
        fact("Tool axis I J K", with_minus_signs(&format!("{i:.4} {j:.4} {l:.4}")));
        let step = state.step_of_position(k, state.look.selected_channel);
        if let Some((plan, at)) = state.on_machine().and_then(|plan| Some((plan, plan.at(Some(step))?))) {
            let [x, y, z, a, b] = plan.named(at);
            fact("Machine X Y Z", point([x, y, z].map(|(_, value, _)| value)));
            let angles = [a, b].map(|(letter, value, unit)| format!("{letter} {value:.3}{unit}"));
            fact("Rotary axes", with_minus_signs(&angles.join(" ")));
        }
        let spindle = section.map_or(0.0, |section| section.tool.spindle);
        fact("Feed rate, speed", format!("{}, {spindle:.0} rev/min", units.feed(plan.feed_of(k))));
        if let Some(time) = state.time_after(step) {
            fact("Cut after", format_clock(time));
        }
        let listing = state.results.listing.as_ref();
        if let Some(line) = listing.and_then(|listing| listing.line_after(Some(step))) {
            fact("Program line", line.to_string());
        }
        let place = format!("{:.3}, {:.3}", position.s, position.lambda);
        fact("s, pitchwise", with_minus_signs(&place));
        let [hub, blade] =
            [units.number(position.hub_clearance, 3), units.length(position.blade_clearance, 3)];
        fact("Clearance", format!("hub {hub}, blade {blade}"));
        let arc = position.evaluation.engagement.max_arc_rad.to_degrees();
        let chip = plan.chip_thickness_of(k);
        let chip = chip.map_or_else(String::new, |chip| format!(", chip {}", units.length(chip, 3)));
        fact("Engaged arc", format!("{arc:.0}°{chip}"));
    });
    ui.add_space(4.0);
}

/// Remarks: what limit a position exceeds, why it is blocked, limited or lifted.
fn remarks(ui: &mut Ui, position: &Position) {
    if let Some(words) = breach_words(position) {
        ui.label(RichText::new(words).color(Condition::Interfering.text(ui.visuals())));
    }
    if let Some(blocked) = position.blocked {
        ui.label(format!("Blocked: {}", blocked_reason(blocked)));
    }
    if let Some(held) = position.limited_by {
        ui.label(format!("Limited by: {}", held.words()));
    }
    if position.lift > 0.02 {
        ui.label(format!("Ends {} above full depth", units::display_units(ui).length(position.lift, 2)));
    }
}

/// Which limit of the setup a position exceeds.
pub fn breach_words(position: &Position) -> Option<String> {
    let words = position.evaluation.breach?.words();
    Some(words[..1].to_uppercase() + &words[1..])
}

/// Tooltip of a cutter in the view of a side: what is cut there, with what, how fast and when. `channel`: in
/// pitches ahead of channel 1.
pub fn cutter_tooltip(ui: &mut Ui, state: &AppState, side: Side, k: usize, channel: usize) {
    ui.label(RichText::new(format!("Position {}", k + 1)).strong());
    let Some(shown) = state.shown_on(side) else { return };
    let plan = shown.plan();
    // The cutters of a running plan may be other ones.
    let Some(position) = plan.positions.get(k).filter(|_| state.preview_on(side).is_none()) else { return };
    let Some(section) = plan.sections.get(position.section) else { return };
    let tool = &section.tool;
    let place = format!("section {}, row {}", position.section + 1, position.row + 1);
    let diameter = state.look.units.diameter(tool.diameter);
    ui.label(format!("{}; T{} {diameter}, {place}", position.condition().label(), tool.number));
    motion(ui, state, shown, k, channel);
}

/// How position `k` of a channel is cut: axis, feed rate and speed, when, and where the axes of the machine
/// then stand.
fn motion(ui: &mut Ui, state: &AppState, shown: ShownPlan, k: usize, channel: usize) {
    let plan = shown.plan();
    let Some(position) = plan.positions.get(k) else { return };
    let spindle = plan.sections.get(position.section).map_or(0.0, |section| section.tool.spindle);
    let feed = state.look.units.feed(plan.feed_of(k));
    let lead = with_minus_signs(&format!("{:.1}°", position.alpha_rad.to_degrees()));
    ui.label(format!("lead {lead}, {feed}, {spindle:.0} rev/min"));
    // The timeline and the machine run the plan of the active side.
    let is_active = state
        .shown()
        .is_some_and(|active| active.policy == shown.policy && Arc::ptr_eq(active.planned, shown.planned));
    let step = state.step_of_position(k, channel);
    let time = match is_active {
        true => state.time_after(step),
        false => shown.planned.time_after(shown.policy, k + 1),
    };
    if let Some(time) = time {
        ui.label(format!("Cut after {}", format_clock(time)));
    }
    if let Some(plan) = state.on_machine().filter(|_| is_active)
        && let Some(at) = plan.at(Some(step))
    {
        let axes = plan.named(at).map(|axis| axis_text(axis, state.look.units));
        ui.label(axes.join("  "));
    }
}

/// Tooltip of a row.
fn row_tooltip(ui: &mut Ui, state: &AppState, k: usize, position: &Position) {
    let units = state.look.units;
    ui.label(RichText::new(format!("Position {}: {}", k + 1, position.condition().label())).strong());
    if position.evaluation.contact.interferes() {
        let share = 100.0 * position.evaluation.contact.area_share;
        ui.label(format!(
            "Core hits stock {} above the tip, {share:.0} % of its area",
            units.length(position.evaluation.contact.depth, 2)
        ));
    }
    remarks(ui, position);
    if let Some(words) = hand_words(state.plunge_mark(k)) {
        ui.label(words);
    }
    if let Some(shown) = state.shown() {
        // A click on the row selects that of channel 1.
        motion(ui, state, shown, k, 0);
    }
    axis_remarks(ui, state, k);
    ui.label(with_minus_signs(&format!("s {:.3}, pitchwise {:.3}", position.s, position.lambda)));
    ui.label(format!(
        "Clearance: hub {}, blade {}",
        units.length(position.hub_clearance, 3),
        units.length(position.blade_clearance, 3)
    ));
}
