//! Controls and texts over the 3D view: plan switch, layers, measurement.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Align2, Color32, ComboBox, FontId, Pos2, Rect, RichText, Stroke, Ui, Vec2};

use crate::gpu::camera::Camera;
use crate::gpu::scene::FloorColours;

use crate::app::model::checked::{ProgramFinding, StaleCheck};
use crate::app::model::cutter_colours::CutterColours;
use crate::app::model::figures::{policy_label, policy_tip};
use crate::app::model::look::{Arrangement, Layers, Look, Operation};
use crate::app::model::mouse_preset::MousePreset;
use crate::app::model::planned::Side;
use crate::app::model::preview::PreviewCutters;
use crate::app::model::solid::SolidColours;
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::count_field;
use crate::app::views::long_menu::long_content;
use crate::app::views::panels::flank;
use crate::app::views::panels::problems::below_messages;
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;

/// Draws `content` on a translucent backing at `at`.
pub(in crate::app) fn floating<R>(ui: &mut Ui, at: Rect, content: impl FnOnce(&mut Ui) -> R) -> R {
    let fill = theme::overlay(ui.visuals());
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        egui::Frame::new().fill(fill).inner_margin(4).corner_radius(4).show(ui, content).inner
    })
    .inner
}

/// A click on the switch in the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchChoice {
    /// Show one side alone.
    Side(Side),
    /// Show both in this arrangement.
    Arrange(Arrangement),
}

/// Names of the arrangements of two sides.
const BOTH: &str = "Both";
const WIPE: &str = "Wipe";

/// The switch between before, after and both.
pub fn side_switch(ui: &mut Ui, rect: Rect, look: &Look) -> Option<SwitchChoice> {
    let mut chosen = None;
    let at = Rect::from_min_size(rect.min + egui::vec2(10.0, 10.0), egui::vec2(230.0, 30.0)).intersect(rect);
    floating(ui, at, |ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        fit_switch(ui);
        ui.horizontal(|ui| {
            let one = look.arrangement == Arrangement::One;
            for side in [Side::Before, Side::After] {
                let button = egui::Button::selectable(one && look.side == side, side.label());
                if ui.add(button).on_hover_text(Command::BeforeAfter.tip_with_keys(ui.ctx())).clicked() {
                    chosen = Some(SwitchChoice::Side(side));
                }
            }
            for (arrangement, name, command) in
                [(Arrangement::Both, BOTH, Command::SideBySide), (Arrangement::Wipe, WIPE, Command::Wipe)]
            {
                let button = egui::Button::selectable(look.arrangement == arrangement, name);
                if ui.add(button).on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
                    chosen = Some(SwitchChoice::Arrange(arrangement));
                }
            }
        });
    });
    chosen
}

/// Makes the buttons of the switch so narrow that all fit into a narrow view.
fn fit_switch(ui: &mut Ui) {
    let names = [Side::Before.label(), Side::After.label(), BOTH, WIPE];
    let texts: f32 = names.iter().map(|name| theme::width_of_text(ui, name)).sum();
    let between = ui.spacing().item_spacing.x * (names.len() - 1) as f32;
    let most = (ui.available_width() - texts - between) / (2 * names.len()) as f32;
    let padding = &mut ui.spacing_mut().button_padding.x;
    *padding = padding.min(most).max(0.0);
}

/// Upper left corner of the policy of the side that is shown in `rect`.
fn policy_corner(rect: Rect) -> Pos2 {
    rect.min + egui::vec2(10.0, 44.0)
}

/// Policy of the side that is shown in `rect`, below the switch; a list where several policies were planned.
pub fn policy(ui: &mut Ui, rect: Rect, state: &mut AppState, side: Side) {
    let (Some(now), Some(planned)) = (state.policy(side), state.results.planned.clone()) else { return };
    let at = Rect::from_min_size(below_messages(ui, rect, policy_corner(rect)), egui::vec2(150.0, 28.0));
    floating(ui, at, |ui| {
        let name = match side {
            Side::Before => "Axis strategy before",
            Side::After => "Axis strategy after",
        };
        let policies = planned.outcome.policies();
        if policies.len() < 3 {
            ui.label(policy_label(now)).on_hover_text(format!("{name}\n{}", policy_tip(now)));
            return;
        }
        let mut choice = now;
        let list =
            ComboBox::from_id_salt(name).width(96.0).selected_text(policy_label(now)).show_ui(ui, |ui| {
                for result in &policies {
                    let policy = result.plan.policy;
                    let line = ui.selectable_value(&mut choice, policy, policy_label(policy));
                    line.on_hover_text(policy_tip(policy));
                }
            });
        list.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name));
        if choice != now {
            state.look.policies[side] = Some(choice);
            state.show(state.look.side);
        }
    });
}

/// Why plunges are out of date, and what to do.
pub const STALE_PLAN: &str = "The setup was edited after this calculation; recalculate (F5)";

/// Why what is shown of the selected operation is out of date, and what to do; `None` where it is not.
pub fn stale_words(state: &AppState) -> Option<&'static str> {
    match state.look.operation {
        Operation::Roughing => state.out_of_date().then_some(STALE_PLAN),
        Operation::Flank => state
            .flank_is_stale()
            .then_some("The setup was edited after this calculation; recalculate flank (F6)"),
        Operation::Program => state.stale_check().map(StaleCheck::words),
    }
}

/// Badge and border of a plan that is stale for a reason, with a summary of the preview of the next plan.
pub fn preview_badge(ui: &mut Ui, rect: Rect, stale: Option<&'static str>, preview: Option<&PreviewCutters>) {
    let orange = Condition::Blocked;
    ui.painter().rect_stroke(rect, 0.0, Stroke::new(2.0, orange.mark()), egui::StrokeKind::Inside);
    let corner = below_messages(ui, rect, policy_corner(rect)) + egui::vec2(0.0, 34.0);
    let at = Rect::from_min_size(corner, egui::vec2(230.0, 62.0)).intersect(rect);
    floating(ui, at, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        if let Some(why) = stale {
            let text = RichText::new("Out of date").strong().color(orange.text(ui.visuals()));
            ui.label(text).on_hover_text(why);
        }
        let Some(preview) = preview else { return };
        let is_warm_start = preview.is_warm_start();
        let axes = if is_warm_start { ", axes as before" } else { "" };
        let policy = format!("{}{axes}", policy_label(preview.policy()).to_lowercase());
        let count = preview.count();
        let (words, colour) = match preview.interfering_count() {
            None => (format!("New {policy}: {count} positions, not checked yet"), ui.visuals().text_color()),
            Some(_) if count == 0 => {
                (format!("New {policy}: no position can be cut"), orange.text(ui.visuals()))
            }
            Some(0) => {
                (format!("New {policy}: none of {count} interferes"), Condition::Sound.text(ui.visuals()))
            }
            Some(faults) => (
                format!("New {policy}: {faults} of {count} interfere"),
                Condition::Interfering.text(ui.visuals()),
            ),
        };
        ui.label(RichText::new(words).color(colour)).on_hover_text(if is_warm_start {
            "The axes of the last plan, lifted until their cores are free; better ones follow"
        } else {
            "Cutters of the current setup; their residual stock follows"
        });
    });
}

/// Colourings of the floor, with their labels.
const FLOORS: [(FloorColours, &str); 3] = [
    (FloorColours::Residual, "Residual stock"),
    (FloorColours::Interference, "Core contact"),
    (FloorColours::Plain, "Plain"),
];

const CHANNELS_TIP: &str = "Channels whose plunges or passes are shown, from the first on in the channel sequence of the setup.\n\
     With more than one the timeline runs through all of them, in the order of their program";

/// Distance of the menu of layers from the upper edge of the view: below the switch in a narrow view, points.
pub fn layers_top(rect: Rect) -> f32 {
    if rect.width() < 300.0 { 44.0 } else { 10.0 }
}

/// How far the controls at the upper edge of the view reach down, points.
pub fn controls_bottom(rect: Rect) -> f32 {
    layers_top(rect) + 30.0
}

/// The menu of layers, in the upper right corner of the view. `channels`: number of those of the part.
/// `is_available`: whether there is something that a layer shows.
pub fn layers(
    ui: &mut Ui,
    rect: Rect,
    look: &mut Look,
    channels: usize,
    is_available: impl Fn(Command) -> bool,
) {
    let top = layers_top(rect);
    let at = Rect::from_min_max(
        rect.right_top() + egui::vec2(-68.0, top),
        rect.right_top() + egui::vec2(-10.0, controls_bottom(rect)),
    );
    floating(ui, at, |ui| {
        let stay = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
        MenuButton::new("Layers").config(stay).ui(ui, |ui| {
            let top = ui.ctx().content_rect().top();
            long_content(ui, "Layers", top, |ui| layer_switches(ui, look, channels, is_available));
        });
    });
}

/// The content of the menu of layers.
fn layer_switches(ui: &mut Ui, look: &mut Look, channels: usize, is_available: impl Fn(Command) -> bool) {
    theme::draw_box_edges(ui);
    switch_rows(ui, &mut look.layers, is_available);
    ui.separator();
    if look.layers.stock {
        ui.label("Stock colours");
        for colours in SolidColours::ALL {
            ui.radio_value(&mut look.solid_colours, colours, colours.label());
        }
    } else if look.operation == Operation::Flank {
        ui.label("Passes by");
        flank::colour_radios(ui, &mut look.flank);
    } else {
        ui.label("Floor");
        for (floor, name) in FLOORS {
            // The difference map takes the place of all of them.
            let is_shown = look.layers.floor == floor && !look.difference;
            if ui.radio(is_shown, name).clicked() {
                (look.layers.floor, look.difference) = (floor, false);
            }
        }
        ui.separator();
        ui.label("Cutters by");
        for colours in CutterColours::ALL {
            ui.radio_value(&mut look.layers.cutter_colours, colours, colours.label());
        }
    }
    ui.separator();
    let label = ui.label("Channels shown").on_hover_text(CHANNELS_TIP);
    count_field::shown_channels(ui, &mut look.shown_channels, channels, label.id);
}

/// The mouse help beside the layers; returns the command of a chosen preset.
pub fn mouse_help(ui: &mut Ui, rect: Rect, mouse: MousePreset) -> Option<Command> {
    // In a narrow view the before/after switch has priority; the View menu has the same entries.
    if rect.width() < 320.0 {
        return None;
    }
    let at = Rect::from_min_max(
        rect.right_top() + egui::vec2(-98.0, 10.0),
        rect.right_top() + egui::vec2(-72.0, 40.0),
    );
    let shown = floating(ui, at, |ui| {
        let (menu, inner) = MenuButton::new("?").ui(ui, |ui| {
            ui.label(mouse.help());
            ui.separator();
            mouse_choice(ui, mouse)
        });
        menu.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Navigation help"));
        if inner.is_none() {
            menu.on_hover_text(mouse.help());
        }
        inner
    });
    shown.and_then(|inner| inner.inner)
}

/// Menu items of the mouse presets.
pub fn mouse_choice(ui: &mut Ui, mouse: MousePreset) -> Option<Command> {
    let mut chosen = None;
    theme::draw_box_edges(ui);
    for (preset, command) in MousePreset::all() {
        if ui.radio(preset == mouse, command.label()).on_hover_text(preset.help()).clicked() {
            chosen = Some(command);
            ui.close();
        }
    }
    chosen
}

/// Menu items of the units.
pub fn unit_choice(ui: &mut Ui, units: DisplayUnits) -> Option<Command> {
    let mut chosen = None;
    theme::draw_box_edges(ui);
    for (choice, command) in
        [(DisplayUnits::Metric, Command::UnitsMetric), (DisplayUnits::Inch, Command::UnitsInch)]
    {
        if ui.radio(choice == units, command.label()).on_hover_text(command.tip()).clicked() {
            chosen = Some(command);
            ui.close();
        }
    }
    chosen
}

/// Draws the switches of the layers; one with nothing to show is not available.
pub fn switch_rows(ui: &mut Ui, layers: &mut Layers, is_available: impl Fn(Command) -> bool) {
    for (shown, command) in switches(layers) {
        let switch = ui.add_enabled(is_available(command), egui::Checkbox::new(shown, command.label()));
        let why = format!("{}\nThe shown operation has none of it now", command.tip());
        switch.on_hover_text(command.tip()).on_disabled_hover_text(why);
    }
}

/// The layers with the commands that switch them.
pub fn switches(layers: &mut Layers) -> [(&mut bool, Command); 9] {
    [
        (&mut layers.hub, Command::Hub),
        (&mut layers.blades, Command::Blades),
        (&mut layers.shroud, Command::Shroud),
        (&mut layers.cutters, Command::Cutters),
        (&mut layers.axes, Command::Axes),
        (&mut layers.holders, Command::Holders),
        (&mut layers.links, Command::Links),
        (&mut layers.stock, Command::Stock),
        (&mut layers.machine, Command::Machine),
    ]
}

/// Size of the buttons of views.
pub(super) const VIEW_BUTTONS: Vec2 = egui::vec2(66.0, 54.0);

/// Buttons of the most used views, in the lower right corner of the view.
pub fn view_buttons(ui: &mut Ui, rect: Rect) -> Option<Command> {
    let mut chosen = None;
    floating(ui, view_buttons_rect(rect), |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for (name, command) in [("Wheel", Command::ViewIso), ("Channel", Command::ViewChannel)] {
            let button = egui::Button::new(name).min_size(egui::vec2(58.0, 22.0));
            let button = button.wrap_mode(egui::TextWrapMode::Extend);
            if ui.add(button).on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
                chosen = Some(command);
            }
        }
    });
    chosen
}

/// The buttons of the most used views in the view `rect`.
pub fn view_buttons_rect(rect: Rect) -> Rect {
    Rect::from_min_size(rect.right_bottom() - VIEW_BUTTONS - egui::vec2(10.0, 10.0), VIEW_BUTTONS)
}

/// Points and distance of a measurement, whose text stands above what is `taken`.
pub fn measurement(
    ui: &Ui,
    (rect, taken): (Rect, [Rect; 2]),
    camera: &Camera,
    points: &[glam::Vec3],
    under: Option<glam::Vec3>,
) {
    let size = glam::vec2(rect.width(), rect.height());
    let place = |p: glam::Vec3| camera.project(p, size).map(|q| rect.min + egui::vec2(q.x, q.y));
    let painter = ui.painter_at(rect);
    let colour = theme::accent(ui.visuals());
    let ends: Vec<glam::Vec3> = points.iter().copied().chain(under.filter(|_| points.len() == 1)).collect();
    for p in ends.iter().filter_map(|&p| place(p)) {
        painter.circle_filled(p, 3.5, colour);
    }
    let text = match ends[..] {
        [a, b] => {
            if let (Some(p), Some(q)) = (place(a), place(b)) {
                painter.line_segment([p, q], Stroke::new(2.0, colour));
            }
            format_distance(a, b, units::display_units(ui))
        }
        _ => "Click two points to measure (Esc ends)".to_owned(),
    };
    // Messages stand at the top.
    let at = egui::pos2(rect.center().x, rect.max.y - 24.0);
    let galley = painter.layout_no_wrap(text, FontId::proportional(13.0), ui.visuals().strong_text_color());
    let back = Rect::from_center_size(at, galley.size() + egui::vec2(12.0, 6.0));
    let back = raised_above(back, &taken);
    painter.rect_filled(back, 4.0, theme::overlay(ui.visuals()));
    painter.galley(back.min + egui::vec2(6.0, 3.0), galley, Color32::PLACEHOLDER);
}

/// The rectangle, raised above those that are `taken` and would cover it.
fn raised_above(back: Rect, taken: &[Rect]) -> Rect {
    let mut raised = back;
    // What stands above one of them may be covered by another.
    while let Some(taken) = taken.iter().find(|taken| raised.intersects(**taken)) {
        raised = raised.translate(egui::vec2(0.0, taken.top() - 4.0 - raised.bottom()));
    }
    raised
}

/// Distance of two points with its components.
pub fn format_distance(a: glam::Vec3, b: glam::Vec3, units: DisplayUnits) -> String {
    let d = b - a;
    let [x, y, z] = [d.x, d.y, d.z].map(|part| units.number(part.into(), 2));
    format!("{}  Δx {x}  Δy {y}  Δz {z}", units.length(d.length().into(), 2))
}

/// A ring with the line number at the place of a fault.
pub fn fault_mark(ui: &Ui, visible: Rect, rect: Rect, camera: &Camera, finding: &ProgramFinding) {
    let Some(place) = &finding.place else { return };
    let tip = glam::vec3(place.tip.x as f32, place.tip.y as f32, place.tip.z as f32);
    let Some(pixel) = camera.project(tip, glam::vec2(rect.width(), rect.height())) else { return };
    let at = rect.min + egui::vec2(pixel.x, pixel.y);
    let painter = ui.painter_at(visible);
    let colour = Condition::Interfering.mark();
    painter.circle_stroke(at, 14.0, Stroke::new(2.5, colour));
    let text = format!("Line {}", finding.fault.line);
    let galley = painter.layout_no_wrap(text, FontId::proportional(13.0), ui.visuals().strong_text_color());
    let back = Rect::from_min_size(at + egui::vec2(18.0, -10.0), galley.size() + egui::vec2(10.0, 4.0));
    painter.rect_filled(back, 3.0, theme::overlay(ui.visuals()));
    painter.galley(back.min + egui::vec2(5.0, 2.0), galley, Color32::PLACEHOLDER);
}

/// A message in the middle of the view, e.g. why there is no picture.
pub fn message(ui: &Ui, rect: Rect, text: &str) {
    let colour: Color32 = ui.visuals().weak_text_color();
    ui.painter_at(rect).text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(14.0), colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_stands_above_all_that_is_taken() {
        let rect =
            |x: f32, y: f32, width: f32| Rect::from_min_size(egui::pos2(x, y), egui::vec2(width, 20.0));
        let back = rect(100.0, 100.0, 80.0);
        let (beside, low, high) = (rect(200.0, 95.0, 60.0), rect(160.0, 110.0, 60.0), rect(60.0, 90.0, 60.0));
        assert_eq!(raised_above(back, &[beside, Rect::NOTHING]), back);
        assert_eq!(raised_above(back, &[low, beside]).bottom(), 106.0);
        assert_eq!(raised_above(back, &[low, high]).bottom(), 86.0);
        let above_low = rect(60.0, 75.0, 60.0);
        assert_eq!(raised_above(back, &[low, above_low]).bottom(), 71.0, "not covered at first");
    }
}
