//! Table of positions in cutting order.

use egui::{ComboBox, Grid, RichText, Sense, Ui};
use egui_extras::{Column, TableBuilder};

use crate::plunge::{Blocked, Position};

use super::super::planned::{Planned, condition};
use super::super::state::{Filter, State};
use super::super::theme::{self, Condition};

/// Why a position is blocked, in words.
pub fn blocked_words(blocked: Blocked) -> &'static str {
    match blocked {
        Blocked::Walls => "no axis with the tilt asked for clears both walls",
        Blocked::ShroudEnd => "the shroud ends before the tilt asked for is reached",
        Blocked::TiltLimit => "the tilt asked for is beyond the limit",
    }
}

/// Draws the table; a click on a row selects.
pub fn show(ui: &mut Ui, state: &mut State) {
    ui.horizontal(|ui| {
        let title = ui.label(RichText::new("Positions").strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ComboBox::from_id_salt("position filter")
                .width(132.0)
                .selected_text(state.filter.label())
                .show_ui(ui, |ui| {
                    for filter in Filter::ALL {
                        ui.selectable_value(&mut state.filter, filter, filter.label());
                    }
                })
                .response
                .labelled_by(title.id);
        });
    });
    let Some(planned) = state.planned.clone() else {
        ui.add_space(6.0);
        ui.label(RichText::new("Nothing planned yet").weak());
        return;
    };
    let rows = state.filtered();
    if rows.is_empty() {
        ui.add_space(6.0);
        let words = match state.filter {
            Filter::All => "The plan has no positions",
            Filter::Interferential => "No interferential position",
            Filter::Blocked => "No blocked position",
        };
        ui.label(RichText::new(words).weak());
        return;
    }
    table(ui, state, &planned, &rows);
}

fn table(ui: &mut Ui, state: &mut State, planned: &Planned, rows: &[usize]) {
    let side = state.side;
    let plan = planned.plan(side);
    let mut builder = TableBuilder::new(ui)
        .striped(true)
        .sense(Sense::click())
        .auto_shrink([false, false])
        .cell_layout(egui::Layout::right_to_left(egui::Align::Center))
        .column(Column::exact(12.0))
        .column(Column::exact(30.0))
        .column(Column::exact(28.0))
        .column(Column::exact(30.0))
        .column(Column::exact(46.0))
        .column(Column::exact(50.0))
        .column(Column::exact(44.0))
        .column(Column::remainder());
    if std::mem::take(&mut state.reveal_selection)
        && let Some(row) = state.selected.and_then(|k| rows.iter().position(|&r| r == k))
    {
        builder = builder.scroll_to_row(row, None);
    }
    let heads = [
        ("", ""),
        ("#", "Place in the cutting order"),
        ("Row", "Row within its section, 1 at the suction wall"),
        ("D", "Diameter of the cutter, mm"),
        ("α °", "Angle between hub normal and axis, positive towards the inlet"),
        ("Contact", "How far above its final bottom the core meets stock, mm"),
        ("Hub", "Mean stock left on the hub under the cutter, mm"),
        ("", ""),
    ];
    let mut clicked = None;
    builder
        .header(theme::ROW_HEIGHT, |mut header| {
            for (head, tip) in heads {
                header.col(|ui| {
                    ui.label(RichText::new(head).weak()).on_hover_text(tip);
                });
            }
        })
        .body(|body| {
            body.rows(theme::ROW_HEIGHT, rows.len(), |mut row| {
                let k = rows[row.index()];
                let Some(position) = plan.positions.get(k) else { return };
                row.set_selected(state.selected == Some(k));
                let tool = plan.sections.get(position.section).map(|section| &section.tool);
                let of = condition(position);
                row.col(|ui| mark(ui, of));
                let cells = [
                    (k + 1).to_string(),
                    (position.row + 1).to_string(),
                    tool.map_or(String::new(), |t| format!("{}", t.diameter)),
                    format!("{:.1}", position.alpha.to_degrees()),
                ];
                for text in cells {
                    row.col(|ui| cell(ui, RichText::new(text)));
                }
                row.col(|ui| {
                    let text = RichText::new(depth(position.contact.depth));
                    let colour = Condition::Interferential.text(ui.visuals());
                    cell(
                        ui,
                        if of == Condition::Interferential { text.color(colour).strong() } else { text },
                    );
                });
                row.col(|ui| {
                    let stock = planned.stock(side, k);
                    cell(
                        ui,
                        RichText::new(if stock.is_finite() { format!("{stock:.2}") } else { "-".into() }),
                    );
                });
                // Room for the scroll bar.
                row.col(|_| ());
                let name = format!("Position {}", k + 1);
                let response = row.response();
                response.widget_info(|| {
                    egui::WidgetInfo::selected(egui::Role::Row, true, state.selected == Some(k), &name)
                });
                if response.on_hover_ui(|ui| about(ui, k, position)).clicked() {
                    clicked = Some(k);
                }
            });
        });
    if let Some(k) = clicked {
        // A second click on the row lets go.
        state.selected = (state.selected != Some(k)).then_some(k);
    }
}

/// Contact depth: nothing at all reads as such.
fn depth(depth: f64) -> String {
    if depth <= 0.0 { "0".to_owned() } else { format!("{depth:.2}") }
}

fn cell(ui: &mut Ui, text: RichText) {
    // The row takes the clicks; selectable text in it would swallow them.
    ui.add(egui::Label::new(text.monospace().size(12.0)).selectable(false));
}

/// Colour and shape: a full disc, a square, a small ring.
fn mark(ui: &mut Ui, of: Condition) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, theme::ROW_HEIGHT), Sense::hover());
    let painter = ui.painter();
    match of {
        Condition::Interferential => {
            painter.circle_filled(rect.center(), 4.5, of.mark());
        }
        Condition::Blocked => {
            painter.rect_filled(
                egui::Rect::from_center_size(rect.center(), egui::vec2(8.0, 8.0)),
                0.0,
                of.mark(),
            );
        }
        Condition::Sound => {
            painter.circle_stroke(rect.center(), 2.5, egui::Stroke::new(1.5, of.mark()));
        }
    }
}

/// Everything about the selected position.
pub fn details(ui: &mut Ui, state: &State, k: usize) {
    let Some(planned) = &state.planned else { return };
    let plan = planned.plan(state.side);
    let Some(position) = plan.positions.get(k) else { return };
    ui.add_space(4.0);
    let of = condition(position);
    ui.horizontal(|ui| {
        mark(ui, of);
        ui.label(
            RichText::new(format!("Position {} of {}: {}", k + 1, plan.positions.len(), of.word())).strong(),
        );
    });
    remarks(ui, position);
    Grid::new("position facts").num_columns(2).spacing([10.0, 1.0]).show(ui, |ui| {
        let mut fact = |name: &str, value: String| {
            ui.label(RichText::new(name).weak());
            ui.label(value);
            ui.end_row();
        };
        let section = plan.sections.get(position.section);
        if let Some(tool) = section.map(|section| &section.tool) {
            let place = format!("section {}, row {}", position.section + 1, position.row + 1);
            fact("Place", format!("{place}, T{} D {}", tool.number, tool.diameter));
        }
        let contact = position.contact;
        if contact.interferes() {
            fact(
                "Core meets stock",
                format!("{:.2} mm, {:.0} % of its disc", contact.depth, 100.0 * contact.area_share),
            );
        }
        let [x, y, z] = [position.tip.x, position.tip.y, position.tip.z];
        fact("Tip x y z", format!("{x:.3} {y:.3} {z:.3} mm"));
        let [i, j, k] = [position.axis.x, position.axis.y, position.axis.z];
        fact("Axis i j k", format!("{i:.4} {j:.4} {k:.4}"));
        fact("s, across", format!("{:.3}, {:.3}", position.s, position.lambda));
        let [hub, blade] = [position.hub_clearance, position.blade_clearance];
        fact("Clearance", format!("hub {hub:.3}, blade {blade:.3} mm"));
    });
    ui.add_space(4.0);
}

/// What else there is to say of a position.
fn remarks(ui: &mut Ui, position: &Position) {
    if let Some(blocked) = position.blocked {
        ui.label(format!("Blocked: {}", blocked_words(blocked)));
    }
    if let Some(held) = position.held {
        ui.label(format!("Held back by: {}", held.words()));
    }
    if position.lift > 0.02 {
        ui.label(format!("Stops {:.2} mm short", position.lift));
    }
}

/// What the tip over a row says.
fn about(ui: &mut Ui, k: usize, position: &Position) {
    ui.label(RichText::new(format!("Position {}: {}", k + 1, condition(position).word())).strong());
    if position.contact.interferes() {
        let share = 100.0 * position.contact.area_share;
        ui.label(format!(
            "Core meets stock {:.2} mm above its bottom, {share:.0} % of its disc",
            position.contact.depth
        ));
    }
    remarks(ui, position);
    ui.label(format!("s {:.3}, across {:.3}", position.s, position.lambda));
    ui.label(format!(
        "Clearance: hub {:.3} mm, blade {:.3} mm",
        position.hub_clearance, position.blade_clearance
    ));
}
