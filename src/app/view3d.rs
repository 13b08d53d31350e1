//! The 3D view: mouse and camera, the picture as an egui image, and what floats over it.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Align2, Color32, FontId, PointerButton, Pos2, Rect, Response, Sense, Ui, Vec2};

use crate::gpu::camera::{Camera, Projection};
use crate::gpu::scene::FloorColours;
use crate::gpu::view::{Framing, View};

use super::command::Command;
use super::planned::Side;
use super::state::{Layers, State};
use super::theme;

/// Camera and cursor of the 3D view.
#[derive(Debug, Default)]
pub struct View3d {
    camera: Option<Camera>,
    /// Standard view to take at the next look, when the size of the picture is known.
    wanted: Option<View>,
    /// The last standard view and the camera it gave.
    standard: Option<(View, Camera)>,
    /// Point the current drag turns about or holds, mm.
    grabbed: Option<glam::Vec3>,
    aspect: f32,
}

/// What the ray under the cursor meets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hit {
    /// Point on the part, mm.
    pub point: Option<glam::Vec3>,
    /// Stock on the hub there, mm.
    pub stock: Option<f32>,
    /// Position whose cutter is in front.
    pub position: Option<usize>,
}

/// Points of scrolling that double or halve the distance.
const SCROLL_PER_OCTAVE: f32 = 240.0;

impl View3d {
    /// Forgets the camera: the next part gets a fresh one.
    pub fn reset(&mut self) {
        self.camera = None;
        self.wanted = Some(View::Iso);
    }

    /// The camera as it stands.
    pub fn current(&self) -> Option<Camera> {
        self.camera
    }

    /// Takes a standard view.
    pub fn look(&mut self, view: View) {
        self.wanted = Some(view);
    }

    /// Switches between perspective and parallel projection.
    pub fn switch_projection(&mut self) {
        if let Some(camera) = &mut self.camera {
            camera.projection = match camera.projection {
                Projection::Perspective => Projection::Orthographic,
                Projection::Orthographic => Projection::Perspective,
            };
        }
    }

    /// Brings the whole wheel into view from where the camera looks now.
    pub fn fit(&mut self, framing: &Framing) {
        let aspect = self.aspect;
        if let Some(camera) = &mut self.camera {
            camera.fit_points(&framing.wheel_outline, aspect);
        }
    }

    /// The camera for a picture of `size` points, after a standard view that was asked for. A standard view that
    /// nobody has moved since fits the picture again when its shape changes.
    pub fn camera(&mut self, framing: &Framing, size: Vec2) -> Camera {
        let aspect = size.x / size.y.max(1.0);
        let reshaped = aspect != self.aspect;
        self.aspect = aspect;
        let untouched = self.standard.filter(|(_, camera)| reshaped && Some(*camera) == self.camera);
        let wanted = self.wanted.take().or(untouched.map(|(view, _)| view));
        let now = self.camera;
        let camera = match (now, wanted) {
            (Some(camera), None) => camera,
            (_, wanted) => {
                let view = wanted.unwrap_or_default();
                let mut camera = Camera::standard(view, framing, aspect);
                camera.projection = now.map_or_else(Projection::default, |before| before.projection);
                self.standard = Some((view, camera));
                camera
            }
        };
        self.camera = Some(camera);
        camera
    }

    /// Lets the mouse move the camera. `hit` is asked only when something begins under the cursor.
    pub fn mouse(
        &mut self,
        ui: &Ui,
        response: &Response,
        hit: impl Fn(&Camera, glam::Vec2) -> Hit,
    ) -> Option<Option<usize>> {
        let Some(camera) = &mut self.camera else { return None };
        let rect = response.rect;
        let size = glam::vec2(rect.width(), rect.height());
        let hit = |camera: &Camera, at: Pos2| hit(camera, pixel(rect, at));
        let cursor = response.interact_pointer_pos().or(response.hover_pos());
        if response.drag_started()
            && let Some(at) = ui.input(|i| i.pointer.press_origin())
        {
            self.grabbed = Some(hit(camera, at).point.unwrap_or(camera.target));
        }
        if let Some(grabbed) = self.grabbed.filter(|_| response.dragged()) {
            let by = glam::vec2(response.drag_delta().x, response.drag_delta().y);
            let shift = ui.input(|i| i.modifiers.shift);
            let pans = response.dragged_by(PointerButton::Middle) || shift;
            if pans {
                camera.pan(by, grabbed, size);
            } else if response.dragged_by(PointerButton::Primary) {
                camera.orbit(by, grabbed);
            }
        }
        if response.drag_stopped() {
            self.grabbed = None;
        }
        if let Some(at) = cursor.filter(|_| response.contains_pointer()) {
            let scroll = ui.input(|i| i.smooth_scroll_delta.y);
            if scroll != 0.0 {
                let point = hit(camera, at).point.unwrap_or(camera.target);
                camera.zoom(2f32.powf(-scroll / SCROLL_PER_OCTAVE), point);
            }
            if response.double_clicked() {
                if let Some(point) = hit(camera, at).point {
                    camera.center_on(point);
                }
            } else if response.clicked() {
                return Some(hit(camera, at).position);
            }
        }
        None
    }
}

fn pixel(rect: Rect, at: Pos2) -> glam::Vec2 {
    glam::vec2(at.x - rect.min.x, at.y - rect.min.y)
}

/// The area of the view, with its accessible name.
pub fn area(ui: &mut Ui) -> Response {
    let size = ui.available_size().max(Vec2::splat(16.0));
    let response = ui.allocate_response(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D view"));
    response
}

/// Before / After switch, in the upper left corner of the view.
pub fn side_switch(ui: &mut Ui, rect: Rect, state: &State) -> Option<Side> {
    state.planned.as_ref()?;
    let mut chosen = None;
    let at = Rect::from_min_size(rect.min + egui::vec2(10.0, 10.0), egui::vec2(260.0, 30.0)).intersect(rect);
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        let frame = egui::Frame::new().fill(theme::overlay(ui.visuals())).inner_margin(4).corner_radius(4);
        frame.show(ui, |ui| {
            ui.horizontal(|ui| {
                for side in [Side::Before, Side::After] {
                    let button = egui::Button::selectable(state.side == side, side.label());
                    if ui.add(button).on_hover_text(Command::BeforeAfter.tip_with_keys(ui.ctx())).clicked() {
                        chosen = Some(side);
                    }
                }
                // In a narrow view the menu of layers needs the place.
                let policy = state.planned.as_ref().map(|p| p.plan(state.side).policy);
                let policy = policy.filter(|_| rect.width() > 300.0);
                if let Some(policy) = policy {
                    let name = super::panels::setup::policy_label(policy).to_lowercase();
                    ui.label(egui::RichText::new(name).weak());
                }
            });
        });
    });
    chosen
}

/// Mark of a plan that the edited setup has left behind: a word and an edge.
pub fn out_of_date(ui: &mut Ui, rect: Rect) {
    let orange = theme::Condition::Blocked;
    ui.painter().rect_stroke(rect, 0.0, egui::Stroke::new(2.0, orange.mark()), egui::StrokeKind::Inside);
    let at = Rect::from_min_size(rect.min + egui::vec2(10.0, 46.0), egui::vec2(200.0, 26.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        let fill = theme::overlay(ui.visuals());
        egui::Frame::new().fill(fill).inner_margin(4).corner_radius(4).show(ui, |ui| {
            let text = egui::RichText::new("Out of date").strong().color(orange.text(ui.visuals()));
            ui.label(text).on_hover_text("The setup was edited after this plan; plan again (F5)");
        });
    });
}

/// Names of what can colour the floor.
const FLOORS: [(FloorColours, &str); 3] = [
    (FloorColours::Residual, "Stock left"),
    (FloorColours::Interference, "Contact of the core"),
    (FloorColours::Plain, "No colours"),
];

/// Menu of layers, in the upper right corner of the view.
pub fn layers(ui: &mut Ui, rect: Rect, layers: &mut Layers) {
    let at = Rect::from_min_max(
        rect.right_top() + egui::vec2(-68.0, 10.0),
        rect.right_top() + egui::vec2(-10.0, 40.0),
    );
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        let fill = theme::overlay(ui.visuals());
        egui::Frame::new().fill(fill).inner_margin(4).corner_radius(4).show(ui, |ui| {
            let stay = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
            MenuButton::new("Layers").config(stay).ui(ui, |ui| {
                for (shown, command) in [
                    (&mut layers.hub, Command::Hub),
                    (&mut layers.blades, Command::Blades),
                    (&mut layers.shroud, Command::Shroud),
                    (&mut layers.cutters, Command::Cutters),
                    (&mut layers.axes, Command::Axes),
                ] {
                    ui.checkbox(shown, command.label()).on_hover_text(command.tip());
                }
                ui.separator();
                ui.label("Floor");
                for (floor, name) in FLOORS {
                    ui.radio_value(&mut layers.floor, floor, name);
                }
            });
        });
    });
}

/// The views that are wanted most, in the lower right corner of the view.
pub fn view_buttons(ui: &mut Ui, rect: Rect) -> Option<Command> {
    let mut chosen = None;
    let size = egui::vec2(66.0, 54.0);
    let at = Rect::from_min_size(rect.right_bottom() - size - egui::vec2(10.0, 10.0), size);
    ui.scope_builder(egui::UiBuilder::new().max_rect(at), |ui| {
        let fill = theme::overlay(ui.visuals());
        egui::Frame::new().fill(fill).inner_margin(4).corner_radius(4).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            for (name, command) in [("Wheel", Command::ViewIso), ("Channel", Command::ViewChannel)] {
                let button = egui::Button::new(name).min_size(egui::vec2(58.0, 22.0));
                if ui.add(button).on_hover_text(command.tip_with_keys(ui.ctx())).clicked() {
                    chosen = Some(command);
                }
            }
        });
    });
    chosen
}

/// Legend at the lower left: the colour bar with its range in mm, and the value under the cursor.
pub fn legend(ui: &Ui, rect: Rect, state: &State, under_cursor: Option<f32>) {
    let Some(planned) = &state.planned else { return };
    if state.layers.floor != FloorColours::Residual || !state.layers.hub {
        return;
    }
    let (low, high) = planned.range;
    // The buttons of the views stand to the right.
    let width = (rect.width() - 120.0).clamp(60.0, 220.0);
    let value = under_cursor.filter(|_| width > 170.0).map(|stock| format!("{stock:.2} mm here"));
    let frame =
        Rect::from_min_size(egui::pos2(rect.min.x + 10.0, rect.max.y - 58.0), egui::vec2(width + 20.0, 48.0));
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    let text = visuals.text_color();
    let font = FontId::proportional(12.0);
    painter.rect_filled(frame, 4.0, theme::overlay(visuals));
    let head = frame.min + egui::vec2(10.0, 5.0);
    painter.text(head, Align2::LEFT_TOP, "Stock on hub", font.clone(), text);
    if let Some(value) = value {
        let at = egui::pos2(frame.max.x - 10.0, head.y);
        painter.text(at, Align2::RIGHT_TOP, value, font.clone(), text);
    }
    let bar = Rect::from_min_size(frame.min + egui::vec2(10.0, 21.0), egui::vec2(width, 8.0));
    let steps = 48;
    for k in 0..steps {
        let at = |k: i32| egui::lerp(bar.left()..=bar.right(), k as f32 / steps as f32);
        let part =
            Rect::from_min_max(egui::pos2(at(k), bar.top()), egui::pos2(at(k + 1) + 0.5, bar.bottom()));
        painter.rect_filled(part, 0.0, theme::stock((f64::from(k) + 0.5) / f64::from(steps)));
    }
    let below = bar.bottom() + 2.0;
    let ticks = [(0.0, Align2::LEFT_TOP), (0.5, Align2::CENTER_TOP), (1.0, Align2::RIGHT_TOP)];
    for (fraction, align) in ticks {
        if fraction == 0.5 && width < 170.0 {
            continue;
        }
        let value = egui::lerp(low..=high, fraction);
        let more = if fraction == 1.0 { "+ mm" } else { "" };
        let at = egui::pos2(egui::lerp(bar.left()..=bar.right(), fraction), below);
        painter.text(at, align, format!("{value:.2}{more}"), FontId::proportional(11.0), text);
    }
}

/// A line in the middle of the view, e.g. why there is no picture.
pub fn message(ui: &Ui, rect: Rect, text: &str) {
    let colour: Color32 = ui.visuals().weak_text_color();
    ui.painter_at(rect).text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(14.0), colour);
}
