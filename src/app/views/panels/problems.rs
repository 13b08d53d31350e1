//! Problem messages with location and remedy, shown over the 3D view until they are dismissed or solved.

use egui::style::ScrollStyle;
use egui::{Align, Area, Frame, Id, Label, LayerId, Layout, Order, Pos2, Rect, RichText, Ui};

use crate::app::model::problem::{Problem, without_markdown};
use crate::app::model::state::AppState;
use crate::app::views::command::Command;
use crate::app::views::scroll_area;
use crate::app::views::theme::Condition;
use crate::app::views::typed;

/// Distance of the messages from the upper edge of the view, below its controls, points.
const TOP: f32 = 42.0;
/// Maximum width of the messages, points.
const MAX_WIDTH: f32 = 560.0;
/// Width at the left of the view that they leave free for the note on the next plan, and at the right for the
/// cube, where they keep at least this width themselves, points.
const NOTE_WIDTH: f32 = 250.0;
const CUBE_WIDTH: f32 = 80.0;
const MIN_WIDTH: f32 = 360.0;
/// Size of the texts below the switch, points.
const TEXTS: egui::Vec2 = egui::vec2(230.0, 96.0);
/// Share of the view that they cover at most where the newest one fits into it, and least height, points:
/// what is more is scrolled to.
const MAX_SHARE: f32 = 0.4;
const MIN_HEIGHT: f32 = 70.0;

/// State by which they are coloured, notes apart.
const MARK: Condition = Condition::Interfering;

/// How the messages were drawn in the frame before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct DrawnMessages {
    /// Height of the newest one, points: it is shown whole, with what to do.
    newest_height: f32,
    /// Whether they are higher than the view leaves for them.
    scrolls: bool,
}

/// What is wrong, and what to do.
fn texts(ui: &mut Ui, problem: &Problem) {
    let text = RichText::new(without_markdown(&problem.message));
    let text = if problem.is_note() { text } else { text.color(MARK.text(ui.visuals())) };
    let shown = ui.add(Label::new(text).wrap());
    if let Some(code) = problem.code {
        shown.on_hover_text(format!("{code}: {}", code.meaning()));
    }
    if !problem.help.is_empty() {
        let help = without_markdown(&problem.help);
        let text = match problem.is_note() {
            true => RichText::new(help).weak(),
            false => RichText::new(format!("Fix: {help}")).strong(),
        };
        ui.add(Label::new(text).wrap());
    }
}

/// Whether there is a problem that was not there in the frame before.
fn is_new(ui: &Ui, problems: Vec<Problem>) -> bool {
    let key = Id::unique("problems that were shown");
    let known = ui.data_mut(|data| data.get_temp::<Vec<Problem>>(key)).unwrap_or_default();
    let is_new = problems.iter().any(|problem| !known.contains(problem));
    if known != problems {
        ui.data_mut(|data| data.insert_temp(key, problems));
    }
    is_new
}

fn covered_key() -> Id {
    Id::unique("what problem messages cover")
}

/// Where the texts below the switch of a `view` begin: at `corner`, or below the messages of the frame before
/// if these would cover them and the texts then still fit into the upper part of the view.
pub fn below_messages(ui: &Ui, view: Rect, corner: Pos2) -> Pos2 {
    let covered = ui.data(|data| data.get_temp::<Rect>(covered_key())).unwrap_or(Rect::NOTHING);
    let below = egui::pos2(corner.x, covered.bottom() + 4.0);
    let has_room = below.y + TEXTS.y <= view.top() + MAX_SHARE * view.height();
    if has_room && covered.intersects(Rect::from_min_size(corner, TEXTS)) { below } else { corner }
}

/// Draws the problems over the view `whole`, whose controls reach `controls` points down; returns how far
/// down they reach themselves, 0 without any.
pub fn show(ui: &mut Ui, whole: Rect, controls: f32, state: &mut AppState) -> f32 {
    if state.problems.is_empty() {
        is_new(ui, Vec::new());
        ui.data_mut(|data| data.remove::<Rect>(covered_key()));
        return 0.0;
    }
    let (mut is_undone, mut dismissed, mut newest_height) = (false, None, 0.0);
    let beside = whole.width() - NOTE_WIDTH - CUBE_WIDTH;
    let width = if beside < MIN_WIDTH { whole.width() - 20.0 } else { beside }.clamp(80.0, MAX_WIDTH);
    let left = if beside < MIN_WIDTH { 0.0 } else { NOTE_WIDTH };
    let corner = egui::pos2(
        (whole.center().x - 0.5 * width).max(whole.left() + left),
        whole.top() + TOP.max(controls + 2.0),
    );
    let at = Rect::from_min_max(corner, egui::pos2(corner.x + width, whole.bottom() - 4.0));
    let fill = ui.visuals().panel_fill;
    let key = Id::unique("drawn problem messages");
    let before = ui.data(|data| data.get_temp::<DrawnMessages>(key)).unwrap_or_default();
    let share = MAX_SHARE * whole.height() - TOP;
    let height = at.height().min(share.max(MIN_HEIGHT).max(before.newest_height));
    // A new one comes above the windows of panels: what a command in one of them reports is seen there, too.
    // Then a window that is clicked comes above them.
    let layer = LayerId::new(Order::Middle, Id::unique("problems"));
    if is_new(ui, state.problems.clone()) {
        ui.ctx().move_to_top(layer);
    }
    // Where there is more than fits, a bar shows it without the pointer over it.
    let bar = ScrollStyle::solid();
    let width = if before.scrolls { width - bar.allocated_width() } else { width };
    let shown =
        Area::new(layer.id).order(layer.order).fixed_pos(at.min).movable(false).show(ui.ctx(), |ui| {
            ui.set_max_size(at.size());
            if before.scrolls {
                ui.spacing_mut().scroll = bar;
            }
            let drawn = scroll_area(height).id_salt("problems").show(ui, |ui| {
                ui.spacing_mut().item_spacing.y = 3.0;
                for (k, problem) in state.problems.iter().enumerate().rev() {
                    let edge = ui.visuals().widgets.noninteractive.fg_stroke.color;
                    let edge = if problem.is_note() { edge } else { MARK.mark() };
                    let stroke = egui::Stroke::new(1.5, edge);
                    let frame = Frame::new().fill(fill).stroke(stroke).inner_margin(6).corner_radius(3);
                    let message = frame.show(ui, |ui| {
                        ui.set_width(width - 16.0);
                        // Beside the text, not below it: messages then cover less of the view.
                        ui.with_layout(Layout::right_to_left(Align::TOP), |ui| {
                            let dismiss = ui.small_button("Dismiss");
                            let tip = Command::DismissProblems.tip_with_keys(ui.ctx());
                            if dismiss.on_hover_text(tip).clicked() {
                                dismissed = Some(k);
                            }
                            let can_undo = problem.is_of_edit() && state.document.can_undo();
                            if can_undo && ui.small_button("Undo the edit").clicked() {
                                is_undone = true;
                            }
                            ui.with_layout(Layout::top_down(Align::LEFT), |ui| texts(ui, problem));
                        });
                    });
                    if k + 1 == state.problems.len() {
                        newest_height = message.response.rect.height();
                    }
                }
            });
            let scrolls = drawn.content_size.y > drawn.inner_rect.height() + 0.5;
            let now = DrawnMessages { newest_height, scrolls };
            if now != before {
                ui.data_mut(|data| data.insert_temp(key, now));
                ui.ctx().request_repaint();
            }
        });
    if let Some(k) = dismissed {
        state.dismiss_problem(k);
    }
    // The edit of the project, even where the tool library was edited after it.
    if is_undone {
        typed::forget(ui.ctx());
        state.document.undo();
    }
    let covered = shown.response.rect;
    let covered = covered.with_max_y(covered.bottom().min(at.top() + height));
    ui.data_mut(|data| data.insert_temp(covered_key(), covered));
    covered.bottom() - whole.top()
}
