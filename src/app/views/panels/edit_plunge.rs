//! Tab "By hand" of the selected position: what is changed in the plan by hand.

use egui::{Button, Context, Grid, Id, RichText, Ui};

use super::fields::{self, FieldSpec};
use crate::app::model::state::AppState;
use crate::app::views::command::Command;
use crate::app::views::typed;
use crate::geometry::without_conversion_error;
use crate::plunge::UnappliedEdit;
use crate::setup::{PlungeChange, PlungeMove};

const LIFT: FieldSpec = FieldSpec::mm(
    "Lift by",
    "By how much the plunge stops short. Negative: it goes deeper, into the hub allowance",
    -50.0,
    200.0,
);
const ALONG: FieldSpec =
    FieldSpec::mm("Move along", "Along the channel, positive towards the inlet", -100.0, 100.0);
const ACROSS: FieldSpec =
    FieldSpec::mm("Move across", "Across the channel, positive towards the pressure side", -100.0, 100.0);
const LEAD: FieldSpec =
    FieldSpec::degrees("Turn lead", "Change of the lead angle, positive towards the inlet", -45.0, 45.0);
const TILT: FieldSpec = FieldSpec::degrees(
    "Turn tilt",
    "Change of the tilt angle, positive towards the pressure side",
    -45.0,
    45.0,
);
const MOVE_TIP: &str = "Moves and turns by the four fields, then lowers the cutter onto the hub allowance again.\n\
     Contact and clearances are measured anew; blades do not stop it";

fn focus_key() -> Id {
    Id::unique("the keys go to the edits by hand")
}

/// Gives the keys to the first control of the tab once it is drawn.
pub fn focus(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(focus_key(), true));
}

/// Draws the tab for the selected position; returns the command that was asked for.
pub fn show(ui: &mut Ui, state: &mut AppState) -> Option<Command> {
    let mut chosen = None;
    let is_focused = ui.data_mut(|data| data.remove_temp::<bool>(focus_key())).unwrap_or_default();
    if state.editable_plan().is_none() {
        let why = state.why_not_edited().unwrap_or_default();
        ui.label(RichText::new(format!("{why}.")).weak());
        counts(ui, state);
        return None;
    }
    let mut edit = state.look.edit;
    ui.horizontal(|ui| {
        ui.label("Edit");
        let first = ui.radio_value(&mut edit.whole_row, false, "Plunge");
        if is_focused {
            first.request_focus();
        }
        ui.radio_value(&mut edit.whole_row, true, "Whole row");
    });
    let row = edit.whole_row;
    ui.horizontal(|ui| {
        let commands = match row {
            false => [Command::DeletePlunge, Command::LockPlunge, Command::CutEarlier, Command::CutLater],
            true => [Command::DeleteRow, Command::LockRow, Command::CutRowEarlier, Command::CutRowLater],
        };
        let is_locked = state.is_selected_locked(row);
        for command in commands {
            let text = match command {
                Command::DeletePlunge | Command::DeleteRow => "Delete",
                Command::LockPlunge | Command::LockRow if is_locked => "Unlock",
                Command::LockPlunge | Command::LockRow => "Lock",
                Command::CutEarlier | Command::CutRowEarlier => "Earlier",
                _ => "Later",
            };
            let button = ui.add_enabled(is_possible(state, command), Button::new(text));
            if button.on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
                chosen = Some(command);
            }
        }
    });
    Grid::new("edit plunge").num_columns(3).spacing([8.0, 3.0]).show(ui, |ui| {
        number(ui, &mut edit.lift, &LIFT);
        if ui
            .add_enabled(edit.lift != 0.0 && state.takes_lifts(), Button::new("Lift"))
            .on_hover_text(LIFT.tip)
            .clicked()
        {
            state.lift_selected(row, edit.lift);
        }
        ui.end_row();
        number(ui, &mut edit.by.along, &ALONG);
        ui.end_row();
        number(ui, &mut edit.by.across, &ACROSS);
        ui.end_row();
        angle(ui, &mut edit.by.lead_rad, &LEAD);
        ui.end_row();
        angle(ui, &mut edit.by.tilt_rad, &TILT);
        let moves = edit.by != PlungeMove::default() && state.takes_edits();
        if ui.add_enabled(moves, Button::new("Move")).on_hover_text(MOVE_TIP).clicked() {
            state.move_selected(row, edit.by);
            edit.by = PlungeMove::default();
        }
        ui.end_row();
    });
    state.look.edit = edit;
    counts(ui, state);
    chosen
}

/// Whether a command edits the selected plunge or its row by hand.
pub fn is_edit(command: Command) -> bool {
    use Command as C;
    matches!(
        command,
        C::DeletePlunge
            | C::DeleteRow
            | C::LockPlunge
            | C::LockRow
            | C::CutEarlier
            | C::CutLater
            | C::CutRowEarlier
            | C::CutRowLater
    )
}

/// Whether a command that edits the selected plunge is possible.
pub fn is_possible(state: &AppState, command: Command) -> bool {
    use crate::app::model::plunge_edits::CuttingPlace::{Earlier, Later};
    let can_edit = state.takes_edits() && state.look.selected.is_some();
    can_edit
        && match command {
            Command::CutEarlier => state.can_reorder(false, Earlier),
            Command::CutLater => state.can_reorder(false, Later),
            Command::CutRowEarlier => state.can_reorder(true, Earlier),
            Command::CutRowLater => state.can_reorder(true, Later),
            _ => true,
        }
}

fn number(ui: &mut Ui, value: &mut f64, spec: &FieldSpec) {
    let form = ui.scope_id();
    let label = ui.label(spec.label).on_hover_text(spec.tip);
    ui.vertical(|ui| {
        let (field, typed) = fields::number_box(ui, value, spec, None);
        typed::keep(ui, form, spec.label, *value, typed);
        typed::show(ui, form, spec.label, *value, field.labelled_by(label.id).rect);
    });
}

fn angle(ui: &mut Ui, radians: &mut f64, spec: &FieldSpec) {
    let before = without_conversion_error(radians.to_degrees());
    let mut degrees = before;
    number(ui, &mut degrees, spec);
    if degrees != before {
        *radians = degrees.to_radians();
    }
}

/// How many edits there are, and those that do nothing in this plan with the reasons, with buttons that
/// remove them.
pub fn counts(ui: &mut Ui, state: &mut AppState) {
    let count = state.edit_count();
    let unapplied = state.unapplied_edits().to_vec();
    let word = if count == 1 { "edit" } else { "edits" };
    // The lines are there without edits, too: the panel stands on the lower edge, and would grow upwards
    // beneath the pointer with the first one.
    let waits = state.editable_plan().is_some() && !state.takes_edits();
    let text = if count == 0 { "No edits".to_owned() } else { format!("{count} {word}") };
    let text = match unapplied.len() {
        // In the same line, where it moves no button.
        _ if waits => format!("{text}; out of date: calculate it first"),
        0 => text,
        n => format!("{text}, {n} not applied"),
    };
    ui.label(RichText::new(text).weak()).on_hover_text(UNAPPLIED_TIP);
    for edit in unapplied.iter().take(MAX_LISTED) {
        unapplied_line(ui, state, edit);
    }
    if unapplied.len() > MAX_LISTED {
        ui.label(RichText::new(format!("and {} more", unapplied.len() - MAX_LISTED)).weak());
    }
    ui.horizontal(|ui| {
        if !unapplied.is_empty() && ui.small_button("Remove those").on_hover_text(UNAPPLIED_TIP).clicked() {
            state.remove_unapplied_edits();
        }
        let remove = ui.add_enabled(count > 0, Button::new("Remove all").small());
        if remove.on_hover_text("Removes all edits; undo brings them back").clicked() {
            state.remove_edits();
        }
    });
}

/// Most edits that are listed with their reason.
const MAX_LISTED: usize = 6;

/// An edit that is not applied, and why. A click selects the plunge that is nearest to the one it was for.
fn unapplied_line(ui: &mut Ui, state: &mut AppState, unapplied: &UnappliedEdit) {
    let Some(edit) = state.document.edited.setup.plunge.edits.get(unapplied.index) else { return };
    let units = state.look.units;
    let what = match edit.change {
        PlungeChange::Delete => "Delete".to_owned(),
        PlungeChange::Lift(by) => format!("Lift by {}", units.length(by, 2)),
        PlungeChange::Lock { .. } => "Lock".to_owned(),
        PlungeChange::Move(_) => "Move".to_owned(),
        PlungeChange::Reorder(_) => "Other order".to_owned(),
    };
    let row = if edit.whole_row { " (row)" } else { "" };
    let reason = unapplied.reason(|mm| units.length(mm, 2));
    let text = format!("Edit {}, {what}{row}: {reason}", unapplied.index + 1);
    let [x, y, z] = [edit.plunge.tip.x, edit.plunge.tip.y, edit.plunge.tip.z].map(|mm| units.number(mm, 2));
    let tip = format!("Tip of its plunge: {x}, {y}, {z} {}", units.length_unit());
    match unapplied.nearest {
        Some(near) => {
            let tip = format!("{tip}\nClick: select the nearest plunge");
            if ui.link(text).on_hover_text(tip).clicked() {
                state.look.select(Some(near.index));
            }
        }
        None => {
            ui.label(text).on_hover_text(tip);
        }
    }
}

const UNAPPLIED_TIP: &str = "An edit finds its plunge by where it is. When the setup changes and the planner places \
     other plunges, it waits; locked plunges stay in every plan, and the others are planned around them";
