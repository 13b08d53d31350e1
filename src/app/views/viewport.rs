//! The middle of the window: one or two 3D views with one camera, and the controls over them.

use std::sync::Arc;
use std::time::Duration;

use egui::{CursorIcon, Pos2, Rect, Response, Sense, Stroke, Ui};
use glam::Vec3;

use crate::gpu::camera::Camera;
use crate::gpu::cutters::{CutterFilter, DrawnChannel};
use crate::gpu::scene::{FloorColours, SceneOptions};
use crate::palette::ColourMap;

use crate::app::App;
use crate::app::model::flank_passes::extent_of_pass;
use crate::app::model::look::{Arrangement, Operation, SectionPlaneLook};
use crate::app::model::machine::ShownMachine;
use crate::app::model::planned::Side;
use crate::app::model::preview::ShownCutters;
use crate::app::model::problem::Problem;
use crate::app::model::shown_channels::ChannelProgress;
use crate::app::model::solid::SolidColours;
use crate::app::views::cube;
use crate::app::views::legend;
use crate::app::views::overlay::{self, SwitchChoice};
use crate::app::views::panels::part;
use crate::app::views::picture::{Content, ShownFlank};
use crate::app::views::section_plane::{section_bar, section_bar_height, section_bar_rect, section_plane};
use crate::app::views::theme;
use crate::app::views::view3d::{self, view_point};

/// Drawn length of a cutter that is shown whole, in diameters: more than any has.
const FULL_LENGTH: f32 = 1e3;
/// Delay after the last camera move until the fine picture is drawn.
const SMOOTH_AFTER: Duration = Duration::from_millis(150);

/// Properties of the screen that a picture depends on.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::app) struct ScreenInfo {
    /// Physical pixels per point.
    pub scale: f32,
    /// Light or dark.
    pub theme: crate::gpu::Theme,
    /// Size of the middle of the window, points.
    pub size: egui::Vec2,
}

/// A view of one side.
pub(in crate::app) struct Pane {
    pub(in crate::app) side: Side,
    /// Area of mouse input and labels; the camera's picture fills it.
    pub(in crate::app) rect: Rect,
    /// Visible part of `rect`.
    pub(in crate::app) visible: Rect,
    pub(in crate::app) response: Response,
}

impl App {
    /// Draws the middle of the window.
    pub(in crate::app) fn viewport(&mut self, ui: &mut Ui) {
        if self.state.document.part.is_none() {
            ui.painter().rect_filled(ui.max_rect(), 0.0, ui.visuals().panel_fill);
            if let Some(action) = part::empty_state(ui, &self.state, &self.engine.samples) {
                self.apply_action(ui.ctx(), action);
            }
            return;
        }
        let whole = ui.available_rect_before_wrap();
        ui.allocate_rect(whole, Sense::hover());
        let (whole, strip) = whole.split_top_bottom_at_y(whole.bottom() - legend::HEIGHT);
        let dark = ui.visuals().dark_mode;
        self.screen = ScreenInfo {
            scale: ui.pixels_per_point(),
            theme: if dark { crate::gpu::Theme::Dark } else { crate::gpu::Theme::Light },
            size: whole.size(),
        };
        let panes = self.panes(ui, whole);
        let Some(framing) = self.pictures.as_ref().and_then(|pictures| pictures.framing().cloned()) else {
            overlay::message(ui, whole, "This device cannot draw the 3D view; everything else works");
            return;
        };
        let size = panes[0].rect.size();
        self.view.camera(&framing, size);
        if std::mem::take(&mut self.state.look.fly) {
            self.zoom_to_selection(ui.input(|i| i.time));
        }
        if self.view.advance(ui.input(|i| i.time)) {
            ui.ctx().request_repaint();
        }
        let before = self.view.current();
        for pane in &panes {
            self.mouse(ui, pane);
        }
        let camera = self.view.camera(&framing, size);
        let moving = Some(camera) != before || panes.iter().any(|pane| pane.response.dragged());
        for pane in &panes {
            self.draw(ui, pane, camera, moving);
        }
        self.note_first_picture();
        let values = self.values_under_cursor(&panes, &camera);
        self.draw_overlays(ui, whole, &panes, camera);
        legend::show(ui, strip, &mut self.state, values);
    }

    /// The views of the arrangement, with their accessible names.
    fn panes(&mut self, ui: &mut Ui, whole: Rect) -> Vec<Pane> {
        match self.state.look.shown_arrangement() {
            Arrangement::One => {
                let response = view3d::view_response(ui, whole, "3D view");
                vec![Pane { side: self.state.look.side, rect: whole, visible: whole, response }]
            }
            Arrangement::Both => {
                let (left, right) = whole.split_left_right_at_fraction(0.5);
                [(Side::Before, left, "3D view, before"), (Side::After, right, "3D view, after")]
                    .map(|(side, rect, name)| {
                        let rect = rect.shrink2(egui::vec2(0.5, 0.0));
                        Pane { side, rect, visible: rect, response: view3d::view_response(ui, rect, name) }
                    })
                    .into()
            }
            Arrangement::Wipe => {
                let response = view3d::view_response(ui, whole, "3D view");
                let border = self.wipe_handle(ui, whole);
                let (left, right) = whole.split_left_right_at_x(border);
                [(Side::Before, left), (Side::After, right)]
                    .map(|(side, visible)| Pane { side, rect: whole, visible, response: response.clone() })
                    .into()
            }
        }
    }

    /// The draggable divider of the wipe; returns its x coordinate.
    fn wipe_handle(&mut self, ui: &mut Ui, whole: Rect) -> f32 {
        let x = egui::lerp(whole.left()..=whole.right(), self.state.look.wipe);
        let at = Rect::from_center_size(egui::pos2(x, whole.center().y), egui::vec2(10.0, whole.height()));
        let response = ui.interact(at, ui.scope_id().with("wipe"), Sense::drag());
        let share = f64::from(self.state.look.wipe);
        response.widget_info(|| egui::WidgetInfo::slider(true, share, "Wipe divider"));
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let share = (at.x - whole.left()) / whole.width().max(1.0);
            self.state.look.wipe = share.clamp(0.02, 0.98);
        }
        response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        egui::lerp(whole.left()..=whole.right(), self.state.look.wipe)
    }

    fn mouse(&mut self, ui: &Ui, pane: &Pane) {
        let here = |at: Pos2| pane.visible.contains(at);
        if let Some(at) = ui.input(|i| i.pointer.press_origin().or(i.pointer.hover_pos()))
            && !here(at)
        {
            return;
        }
        let options = self.options(pane.side);
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(pane.side)) else {
            return;
        };
        let size = pane.rect.size();
        let preset = self.state.look.mouse;
        let clicked =
            self.view.mouse(ui, &pane.response, preset, |camera, at| picture.hit(camera, &options, at, size));
        let Some((at, camera)) = clicked.zip(self.view.current()) else { return };
        let at = view_point(pane.rect, at);
        if let Some(points) = &mut self.state.look.measure {
            if points.len() >= 2 {
                points.clear();
            }
            points.extend(picture.hit(&camera, &options, at, size).point);
            return;
        }
        match picture.pick(&camera, &options, at, size) {
            Ok(position) => {
                if self.state.look.side != pane.side {
                    self.state.show(pane.side);
                }
                self.state.look.select(position);
            }
            Err(error) => self.state.report_problem(Problem::of_device(&error)),
        }
    }

    fn draw(&mut self, ui: &Ui, pane: &Pane, camera: Camera, moving: bool) {
        let content = self.content(pane.side);
        let options = SceneOptions { show_borders: true, ..self.options(pane.side) };
        let (flank, tool) = (self.flank_content(), self.shown_tool());
        let is_roughing = self.state.look.operation == Operation::Roughing;
        let borders = if is_roughing { self.border_segments(ui.visuals()) } else { Vec::new() };
        let channels = self.drawn_channels(pane.side);
        let solid = self.solids[pane.side].shown().cloned();
        let preview = self.state.preview_on(pane.side).filter(|_| is_roughing);
        // The next stage replaces a preview soon, so draw it coarsely.
        let moving = moving || preview.is_some();
        let preview = preview.map(|preview| &preview.shown).or(tool.as_ref());
        let program = self.state.drawn_program();
        // So does the next position of a timeline that plays or is dragged.
        let held = ui.input(|input| input.pointer.any_down());
        let look = &self.state.look;
        // Table and timeline are those of the active side.
        let is_shown = look.layers.machine && pane.side == look.side;
        let cut = self.state.timeline_cut();
        let aspect = pane.rect.aspect_ratio();
        let machine = self.state.on_machine().filter(|_| is_shown).map(|program| ShownMachine {
            program: Arc::clone(program),
            cut,
            has_head: !program.head_hides(cut, &camera, aspect),
        });
        let scrubs = look.playing.is_some() || (held && cut.is_some());
        let Some(picture) = self.pictures.as_mut().and_then(|pictures| pictures.side(pane.side)) else {
            return;
        };
        picture.load_flank(flank);
        picture.load_program(program);
        picture.load(content);
        picture.load_cutter_colours(
            look.layers.cutter_colours,
            &look.hidden_classes,
            &self.state.plans_in_view(),
        );
        picture.load_preview(preview);
        picture.load_channels(channels);
        picture.load_borders(borders);
        picture.load_solid(solid);
        picture.load_machine(machine);
        // The first picture is coarse, too, to appear sooner.
        let moving = moving || !picture.has_drawn() || (scrubs && picture.is_on_software());
        let scale = ui.pixels_per_point();
        let size = [(pane.rect.width() * scale).round() as u32, (pane.rect.height() * scale).round() as u32];
        if let Some(texture) = picture.show(camera, options, size, moving) {
            let all = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter_at(pane.visible).image(texture, pane.rect, all, egui::Color32::WHITE);
        }
        if picture.is_draft() {
            ui.ctx().request_repaint_after(SMOOTH_AFTER);
        }
    }

    /// The shown channels beside the first: their plunges follow the timeline.
    fn drawn_channels(&self, side: Side) -> Vec<DrawnChannel> {
        let Some(shown) = self.state.shown_on(side) else { return Vec::new() };
        let pitch = shown.planned.outcome.workpiece.part.pitch();
        let drawn = |at: ChannelProgress| DrawnChannel {
            turn_rad: (pitch * at.channel as f64) as f32,
            up_to: self.state.look.channels_cut.map(|_| at.up_to),
            has_tool: at.is_current,
        };
        let others = self.state.channel_progress().into_iter().filter(|at| at.channel != 0);
        others.map(drawn).collect()
    }

    /// Plan content of a side's picture.
    pub(in crate::app) fn content(&self, side: Side) -> Option<Content> {
        let shown = self.state.shown_on(side)?;
        // Plans of different setups have different floors.
        let other =
            self.state.shown_on(side.other()).filter(|other| Arc::ptr_eq(other.planned, shown.planned));
        let other = other.map(|other| other.policy);
        let (planned, policy) = (Arc::clone(shown.planned), shown.policy);
        let more_than = other.filter(|_| self.state.look.difference && side == Side::After);
        let cut = self.state.look.cut_count;
        let heights = cut.and_then(|_| self.scrubbed.heights(&planned, policy));
        Some(Content { planned, policy, cut, heights, more_than })
    }

    /// Draws the controls over the views.
    fn draw_overlays(&mut self, ui: &mut Ui, whole: Rect, panes: &[Pane], camera: Camera) {
        if panes.len() > 1 {
            let x = panes[1].visible.left();
            let line = Stroke::new(2.0, theme::accent(ui.visuals()));
            ui.painter().line_segment([egui::pos2(x, whole.top()), egui::pos2(x, whole.bottom())], line);
        }
        let roughing = self.state.look.operation == Operation::Roughing;
        if let Some(why) = overlay::stale_words(&self.state).filter(|_| !roughing) {
            overlay::preview_badge(ui, whole, Some(why), None);
        }
        if let Some(finding) = self.state.selected_finding() {
            overlay::fault_mark(ui, panes[0].visible, panes[0].rect, &camera, finding);
        }
        for pane in panes.iter().filter(|_| roughing) {
            let preview = self.state.preview_on(pane.side);
            let why = self.state.is_stale(pane.side).then_some(overlay::STALE_PLAN);
            if why.is_some() || preview.is_some() {
                overlay::preview_badge(ui, pane.visible, why, preview);
            }
        }
        if let Some(points) = self.state.look.measure.clone() {
            let under = self.hover.as_ref().and_then(|hover| hover.hit.point);
            let bar = self.state.look.section.map_or(Rect::NOTHING, |_| section_bar_rect(whole));
            for pane in panes {
                let taken = [bar, overlay::view_buttons_rect(whole)];
                overlay::measurement(ui, (pane.rect, taken), &camera, &points, under);
            }
        }
        if roughing {
            self.section_borders(ui, panes, &camera);
        }
        let sides = panes.iter().map(|pane| pane.side);
        let solids: Vec<_> = sides
            .filter(|side| self.state.look.layers.stock && self.state.solid_source(*side).is_some())
            .map(|side| (side, self.solids[side].shown().map(|solid| &**solid)))
            .collect();
        if !solids.is_empty() {
            let bar = self.state.look.section.map_or(0.0, |_| section_bar_height(whole));
            legend::solid_legend(ui, whole, &solids, bar + 10.0);
        }
        match roughing.then(|| overlay::side_switch(ui, whole, &self.state.look)).flatten() {
            Some(SwitchChoice::Side(side)) => {
                self.state.look.arrangement = Arrangement::One;
                self.state.show(side);
            }
            Some(SwitchChoice::Arrange(arrangement)) => self.arrange(arrangement),
            None => {}
        }
        for pane in panes.iter().filter(|_| roughing) {
            overlay::policy(ui, pane.visible, &mut self.state, pane.side);
        }
        let channels = self.channel_count();
        let mut layers = self.state.look.layers;
        let known = overlay::switches(&mut layers).map(|(_, layer)| (layer, self.is_available(layer)));
        let is_available = |layer| known.contains(&(layer, true));
        overlay::layers(ui, whole, &mut self.state.look, channels, is_available);
        if let Some(command) = overlay::mouse_help(ui, whole, self.state.look.mouse) {
            self.run_command(ui.ctx(), command);
        }
        self.point_menu(panes, &camera);
        let across = self.state.look.section.map(|section| section.across);
        section_bar(ui, whole, &mut self.state.look, camera.bounds);
        if self.state.look.section.is_some_and(|section| Some(section.across) != across) {
            self.turn_section_to_viewer();
        }
        if let Some(command) = overlay::view_buttons(ui, whole) {
            self.run_command(ui.ctx(), command);
        }
        let corner = whole.right_top() + egui::vec2(-42.0, 74.0 + overlay::layers_top(whole));
        if whole.height() > cube::MIN_VIEW_HEIGHT
            && let Some(direction) = cube::show(ui, corner, &camera)
        {
            self.view.look_from(direction);
        }
    }

    /// Switches to an arrangement, or back to one view if it is active.
    pub(in crate::app) fn arrange(&mut self, arrangement: Arrangement) {
        let look = &mut self.state.look;
        look.arrangement = if look.arrangement == arrangement { Arrangement::One } else { arrangement };
        self.hover = None;
    }

    /// The only tool that is shown: at the selected fault of a checked program, or where the timeline of the
    /// flank plan or program stands.
    pub(in crate::app) fn shown_tool(&mut self) -> Option<ShownCutters> {
        let faulty = self.state.selected_finding().and_then(|finding| finding.place.as_ref());
        faulty.map(|place| place.cutter.clone()).or_else(|| self.timeline_tool.follow(&self.state))
    }

    /// What the pictures show of the flank plan.
    pub(in crate::app) fn flank_content(&self) -> Option<ShownFlank> {
        let look = &self.state.look.flank;
        let pass = look.pass.and_then(|k| self.state.results.passes.passes.get(k));
        self.state.shown_flank_run().map(|run| ShownFlank {
            run: Arc::clone(run),
            colours: look.colours,
            made: look.cut,
            // The passes would hide what they leave.
            passes: !self.state.look.layers.stock,
            rapids: self.state.look.layers.links,
            selected: pass.map(|pass| [pass.from, pass.end]),
        })
    }

    /// Cuts away the half before the section plane, so that its face is seen.
    pub(in crate::app) fn turn_section_to_viewer(&mut self) {
        let (Some(camera), Some(section)) = (self.view.current(), self.state.look.section) else { return };
        let plane = section_plane(&self.state, SectionPlaneLook { flipped: false, ..section });
        let flipped = plane.is_some_and(|plane| plane.normal.dot(camera.basis().2) < 0.0);
        self.state.look.section = Some(SectionPlaneLook { flipped, ..section });
    }

    /// Zooms to the selected position.
    pub(in crate::app) fn zoom_to_selection(&mut self, time: f64) {
        let to = |v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32));
        if self.state.look.operation == Operation::Program {
            let place = self.state.selected_finding().and_then(|finding| finding.place.as_ref());
            if let Some(place) = place {
                let (tip, axis) = (to(place.tip.coords.into()), to(place.axis.into()));
                self.view.fly_to(tip, 5.0 * place.radius as f32, axis, time);
            }
            return;
        }
        if self.state.look.operation == Operation::Flank {
            let pass = self.state.look.flank.pass.and_then(|k| self.state.results.passes.passes.get(k));
            let moves = self.state.results.flank_run.as_ref().map(|run| run.moves());
            if let Some((middle, reach, axis)) =
                pass.zip(moves).and_then(|(pass, moves)| extent_of_pass(pass, moves))
            {
                self.view.fly_to(to(middle.coords.into()), 1.6 * reach as f32, to(axis.into()), time);
            }
            return;
        }
        let Some(shown) = self.state.shown() else { return };
        let in_channel = self.state.selected().zip(self.state.selected_in_channel());
        let Some((position, (tip, axis))) = in_channel else { return };
        let radius = shown.plan().sections.get(position.section).map_or(10.0, |s| s.tool.radius());
        let (tip, axis): (Vec3, Vec3) = (to(tip.coords.into()), to(axis.into()));
        let center = tip + axis * radius as f32;
        self.view.fly_to(center, 5.0 * radius as f32, axis, time);
    }

    /// Render options of a side.
    pub(in crate::app) fn options(&self, side: Side) -> SceneOptions {
        let (state, look) = (&self.state, &self.state.look);
        let layers = look.layers;
        let walls = state.shown_deviation();
        let roughing = look.operation == Operation::Roughing;
        let difference = look.difference && side == Side::After && roughing;
        let (low, high) = state.range();
        let count = state.shown_on(side).map_or(0, |shown| shown.plan().positions.len());
        let shows_timeline_tool = state.shows_timeline_tool();
        SceneOptions {
            show_hub: layers.hub,
            // The blades would hide the wall values.
            show_blades: layers.blades && walls.is_none(),
            show_shroud: layers.shroud,
            // The flank plan has no plunges.
            show_cutters: match layers.cutters && roughing {
                // Cutters that stay where they plunged would fill what they cut.
                true if layers.stock => CutterFilter::Last,
                true => CutterFilter::All,
                // The tool at the selected fault, or where the timeline stands.
                false if state.shows_one_tool() => CutterFilter::All,
                false => CutterFilter::Hidden,
            },
            show_solid: layers.stock,
            show_machine: layers.machine,
            show_axes: layers.axes && roughing,
            show_holders: layers.holders && (roughing || state.shows_one_tool()),
            show_links: layers.links && roughing,
            show_floor_colours: match walls {
                // The scale is that of the floor.
                _ if layers.stock && look.solid_colours == SolidColours::Distance => FloorColours::Residual,
                _ if layers.stock => FloorColours::Plain,
                Some(_) => FloorColours::Walls,
                None if !roughing => FloorColours::Plain,
                None if difference => FloorColours::Values,
                None => layers.floor,
            },
            map: if (difference || walls.is_some()) && !layers.stock {
                ColourMap::Difference
            } else {
                ColourMap::Cividis
            },
            range_mm: match walls {
                _ if layers.stock => (low, high),
                Some(most) => (-most, most),
                None if difference => (-high, high),
                None => (low, high),
            },
            theme: self.screen.theme,
            cutter_stub: if shows_timeline_tool { FULL_LENGTH } else { SceneOptions::default().cutter_stub },
            up_to: look.cut_count.filter(|&cut| cut < count || cut == 0),
            // The tool is in another channel.
            hides_last: state.channel_progress().iter().any(|at| at.is_current && at.channel != 0),
            // Of the plunges, which the other operations do not show.
            selected: look.selected.filter(|_| roughing && side == look.side && look.selected_channel == 0),
            pixel_scale: self.screen.scale,
            section: look.section.and_then(|section| section_plane(state, section)),
            ..SceneOptions::default()
        }
    }
}
