//! Camera and mouse of the 3D view.

use egui::{PointerButton, Pos2, Rect, Response, Sense, Ui, Vec2};

use crate::gpu::camera::{Camera, Projection};
use crate::gpu::view::{View, ViewTargets};

use crate::app::model::mouse_preset::MousePreset;
use crate::app::views::mouse::Gesture;

/// Camera state of the 3D view.
#[derive(Debug, Default)]
pub struct View3d {
    camera: Option<Camera>,
    /// Standard view to apply in the next frame, when the size of the picture is known.
    wanted: Option<View>,
    /// The last standard view and its camera.
    standard: Option<(View, Camera)>,
    /// Point that the current drag orbits around or holds, mm.
    grabbed: Option<glam::Vec3>,
    aspect: f32,
    transition: Option<CameraTransition>,
}

/// An animated transition of the camera.
#[derive(Clone, Copy, Debug)]
struct CameraTransition {
    from: Camera,
    to: Camera,
    /// Seconds on the window's clock.
    start: f64,
}

/// Duration of a camera transition, s.
const TRANSITION_S: f64 = 0.22;

/// What the ray under the cursor hits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewHit {
    /// Point on the part, mm.
    pub point: Option<glam::Vec3>,
    /// Stock on the hub there, mm.
    pub stock: Option<f32>,
    /// Stock on the wall there above the blade allowance, mm, while the walls are shown.
    pub deviation: Option<f32>,
    /// Index of the position whose cutter is hit.
    pub position: Option<usize>,
}

/// Points of dragging that double or halve the camera distance.
const DRAG_PER_OCTAVE: f32 = 160.0;
/// Points of scrolling that double or halve the camera distance.
const SCROLL_PER_OCTAVE: f32 = 240.0;

impl View3d {
    /// Drops the camera: the next part gets the isometric view.
    pub fn reset(&mut self) {
        self.camera = None;
        self.wanted = Some(View::Iso);
    }

    /// The current camera.
    pub fn current(&self) -> Option<Camera> {
        self.camera
    }

    /// Requests a standard view.
    pub fn look(&mut self, view: View) {
        self.wanted = Some(view);
    }

    /// Restores a camera, e.g. from a project.
    pub fn restore(&mut self, camera: Camera) {
        self.camera = Some(camera);
        self.wanted = None;
        self.standard = None;
        self.transition = None;
    }

    /// Starts a transition to a view that a sphere around `center` fills. `facing` is the direction the
    /// target faces; a camera behind it moves around to the front. `time` in seconds.
    pub fn fly_to(&mut self, center: glam::Vec3, radius: f32, facing: glam::Vec3, time: f64) {
        let Some(from) = self.camera else { return };
        let mut to = from;
        if from.basis().2.dot(facing) < 0.25 {
            to.look_from((facing + from.basis().2 * 0.3).normalize_or(facing));
        }
        to.fit(center, radius, self.aspect.max(0.1));
        self.transition = Some(CameraTransition { from, to, start: time });
    }

    /// Looks at the same target from `direction`, at the same distance.
    pub fn look_from(&mut self, direction: glam::Vec3) {
        self.transition = None;
        if let Some(camera) = &mut self.camera {
            camera.look_from(direction);
        }
    }

    /// Advances the transition (smoothstep); `true` while it runs. `time` in seconds.
    pub fn advance(&mut self, time: f64) -> bool {
        let Some(transition) = self.transition else { return false };
        let share = ((time - transition.start) / TRANSITION_S).clamp(0.0, 1.0) as f32;
        self.camera =
            Some(transition.from.interpolate_to(&transition.to, share * share * (3.0 - 2.0 * share)));
        if share >= 1.0 {
            self.transition = None;
        }
        self.transition.is_some()
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

    /// Fits the whole wheel into the view, keeping the view direction.
    pub fn fit(&mut self, framing: &ViewTargets) {
        let aspect = self.aspect;
        if let Some(camera) = &mut self.camera {
            camera.fit_points(&framing.wheel_outline, aspect);
        }
    }

    /// The camera for a picture of `size` points; applies a requested standard view. A standard view that was
    /// not moved since is fitted again when the aspect ratio changes.
    pub fn camera(&mut self, framing: &ViewTargets, size: Vec2) -> Camera {
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

    /// Moves the camera by mouse according to `preset`; returns the point of a click. `hit` is called only
    /// when a drag, a scroll or a double-click starts.
    pub fn mouse(
        &mut self,
        ui: &Ui,
        response: &Response,
        preset: MousePreset,
        hit: impl Fn(&Camera, glam::Vec2) -> ViewHit,
    ) -> Option<Pos2> {
        let moved = response.drag_started() || ui.input(|i| i.smooth_scroll_delta.y) != 0.0;
        if moved && response.contains_pointer() {
            self.transition = None;
        }
        let camera = self.camera.as_mut()?;
        let rect = response.rect;
        let size = glam::vec2(rect.width(), rect.height());
        let hit = |camera: &Camera, at: Pos2| hit(camera, view_point(rect, at));
        let cursor = response.interact_pointer_pos().or(response.hover_pos());
        if response.drag_started()
            && let Some(at) = ui.input(|i| i.pointer.press_origin())
        {
            self.grabbed = Some(hit(camera, at).point.unwrap_or(camera.target));
        }
        if let Some(grabbed) = self.grabbed.filter(|_| response.dragged()) {
            let by = glam::vec2(response.drag_delta().x, response.drag_delta().y);
            let held = ui.input(|i| i.modifiers);
            let buttons = [PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary];
            let button = buttons.into_iter().find(|&button| response.dragged_by(button));
            match button.and_then(|button| preset.gesture(button, held)) {
                Some(Gesture::Orbit) => camera.orbit(by, grabbed),
                Some(Gesture::Pan) => camera.pan(by, grabbed, size),
                Some(Gesture::Zoom) => camera.zoom(2f32.powf(-by.y / DRAG_PER_OCTAVE), grabbed),
                None => {}
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
                return Some(at);
            }
        }
        None
    }
}

/// Point of the window, in points from the corner of the view `rect`.
pub fn view_point(rect: Rect, at: Pos2) -> glam::Vec2 {
    glam::vec2(at.x - rect.min.x, at.y - rect.min.y)
}

/// Allocates the area of a view, with its accessible name.
pub fn view_response(ui: &mut Ui, rect: Rect, name: &str) -> Response {
    let response = ui.interact(rect, ui.scope_id().with(name), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    response
}
