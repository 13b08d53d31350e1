//! The window: an eframe application over the same job as the command line.
//!
//! | file | holds |
//! |---|---|
//! | [`state`] | what is open, edited, selected and shown; no drawing |
//! | [`planned`] | a finished plan with what the panels show of it |
//! | [`engine`] | opening and planning as functions, so that tests can stand in |
//! | [`command`] | everything the window can be told to do |
//! | [`theme`] | colours and sizes, declared once |
//! | [`panels`] | the panels, one file each |
//! | [`view3d`], [`picture`] | the 3D view: mouse and camera; the texture it shows |
//! | [`dialogs`], [`files`] | choosing files; reading and writing them in the background |
//! | [`menu`], [`work`] | the menu; what runs in the background and what becomes of it |
//! | [`mod@run`] | opening the window |
//!
//! The UI thread never waits: work runs on [`crate::job::worker::Worker`]s, which ask for a repaint when
//! they are done; without input and without work nothing is drawn.

pub mod command;
pub mod dialogs;
pub mod engine;
pub mod files;
pub mod menu;
pub mod number;
pub mod panels;
pub mod picture;
pub mod planned;
pub mod run;
pub mod state;
pub mod theme;
pub mod view3d;
pub mod work;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use eframe::CreationContext;
use egui::{CentralPanel, Panel, ScrollArea, Ui};

use crate::gpu::cutters::CutterFilter;
use crate::gpu::scene::SceneOptions;
use crate::part::Setup;

pub use run::{AppError, run};

use command::Command;
use engine::{Engine, PartSource};
use panels::part::Wish;
use picture::Picture;
use state::State;
use view3d::{Hit, View3d};
use work::Work;

/// The application.
pub struct App {
    state: State,
    engine: Engine,
    work: Work,
    dialogs: dialogs::Dialogs,
    view: View3d,
    /// `None` on a device that cannot draw; panels work all the same.
    picture: Option<Picture>,
    undoer: egui::util::undoer::Undoer<Setup>,
    /// The last hit under the cursor and where it was asked for.
    hover: Option<(egui::Pos2, Hit)>,
    device: String,
    title: String,
    start: Option<Instant>,
    first_picture: Option<Duration>,
}

impl App {
    /// The application as it is used.
    pub fn new(cc: &CreationContext<'_>) -> Self {
        Self::with_engine(cc, Engine::default())
    }

    /// The application over other functions, for tests.
    pub fn with_engine(cc: &CreationContext<'_>, engine: Engine) -> Self {
        theme::apply(&cc.egui_ctx);
        let picture = cc.wgpu_render_state.as_ref().map(Picture::new);
        let device = picture.as_ref().map_or_else(|| "no 3D view".to_owned(), Picture::device_name);
        Self {
            state: State::default(),
            work: Work::new(&engine, &cc.egui_ctx),
            engine,
            dialogs: dialogs::Dialogs::default(),
            view: View3d::default(),
            picture,
            undoer: Default::default(),
            hover: None,
            device,
            title: String::new(),
            start: None,
            first_picture: None,
        }
    }

    /// Measures the time to the first picture from `start`.
    pub fn time_from(&mut self, start: Instant) {
        self.start = Some(start);
    }

    /// Opens a file: a setup if it looks like one, else a part.
    pub fn open_path(&mut self, path: PathBuf) {
        if files::is_setup(&path) {
            self.open_files(None, Some(path))
        } else {
            self.open_part(PartSource::File(path))
        }
    }

    /// Opens a part in the background; its plan follows by itself.
    pub fn open_part(&mut self, source: PartSource) {
        self.open_files(Some(source), None);
    }

    /// What is open, edited, selected and shown.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Where the 3D view is seen from; `None` before there is a part.
    pub fn camera(&self) -> Option<crate::gpu::camera::Camera> {
        self.view.current()
    }

    /// Whether something runs in the background.
    pub fn is_busy(&self) -> bool {
        self.work.running().is_some()
    }

    /// Time from start to the first picture of a part, once there was one.
    pub fn first_picture(&self) -> Option<Duration> {
        self.first_picture
    }

    fn take_drops(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let (mut part, mut setup) = (None, None);
        for file in dropped {
            let path = file.path().to_path_buf();
            if files::is_setup(&path) { setup = Some(path) } else { part = Some(PartSource::File(path)) }
        }
        if part.is_some() || setup.is_some() {
            self.open_files(part, setup);
        }
    }

    fn left_panel(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            // The scroll bar floats; nothing should lie under it.
            ui.set_max_width(ui.available_width() - 8.0);
            let name = self.state.part.as_ref().map_or("Part", |part| part.impeller.name.as_str()).to_owned();
            ui.label(egui::RichText::new(name).strong());
            match panels::part::show(ui, &self.state, &self.engine.samples) {
                Some(Wish::Command(command)) => self.obey(ui.ctx(), command),
                Some(Wish::Open(source)) => self.open_part(source),
                None => {}
            }
            ui.separator();
            let text = egui::RichText::new(Command::Plan.label()).color(egui::Color32::WHITE).strong();
            let button = egui::Button::new(text).fill(theme::PRIMARY);
            if ui
                .add_sized([ui.available_width(), 26.0], button)
                .on_hover_text(Command::Plan.tip_with_keys(ui.ctx()))
                .clicked()
            {
                self.obey(ui.ctx(), Command::Plan);
            }
            let setup = &mut self.state.setup;
            let open = |title: &str| egui::CollapsingHeader::new(title.to_owned()).default_open(true);
            open("Plunge").show(ui, |ui| panels::setup::plunge(ui, setup));
            open("Stock").show(ui, |ui| panels::setup::stock(ui, setup));
            let (compare, planned) = (&mut self.state.compare, self.state.planned.as_deref());
            open("Policies").show(ui, |ui| panels::policies::show(ui, compare, planned));
            let setup = &mut self.state.setup;
            let chosen = self.state.planned.as_ref().map(|planned| &planned.outcome.setup);
            open("Cutters").show(ui, |ui| panels::tools::show(ui, setup, chosen));
        });
    }

    fn middle(&mut self, ui: &mut Ui) {
        if self.state.part.is_none() {
            ui.painter().rect_filled(ui.max_rect(), 0.0, ui.visuals().panel_fill);
            match panels::part::empty_state(ui, &self.state, &self.engine.samples) {
                Some(Wish::Command(command)) => self.obey(ui.ctx(), command),
                Some(Wish::Open(source)) => self.open_part(source),
                None => {}
            }
            return;
        }
        let response = view3d::area(ui);
        let rect = response.rect;
        let Some(picture) = &mut self.picture else {
            view3d::message(ui, rect, "This device draws no 3D view");
            return;
        };
        let Some(framing) = picture.framing().cloned() else { return };
        let mut camera = self.view.camera(&framing, rect.size());
        let options = options(&self.state, ui);
        let hit = |camera: &crate::gpu::camera::Camera, at| picture.hit(camera, &options, at, rect.size());
        if let Some(position) = self.view.mouse(ui, &response, hit) {
            self.state.select(position);
        }
        let before = camera;
        camera = self.view.camera(&framing, rect.size());
        // The very first picture is a fast one too: something to see comes before something smooth.
        let moving = camera != before || response.dragged() || !picture.has_drawn();
        let scale = ui.pixels_per_point();
        let size = [(rect.width() * scale).round() as u32, (rect.height() * scale).round() as u32];
        if let Some(texture) = picture.show(camera, options, size, moving) {
            let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, egui::Color32::WHITE);
        }
        if picture.is_draft() {
            ui.ctx().request_repaint_after(SMOOTH_AFTER);
        }
        self.note_first_picture();
        let stock = self.stock_under_cursor(ui, &response, &camera, &options);
        if self.state.out_of_date() {
            view3d::out_of_date(ui, rect);
        }
        view3d::legend(ui, rect, &self.state, stock);
        if let Some(side) = view3d::side_switch(ui, rect, &self.state) {
            self.show_side(side);
        }
        view3d::layers(ui, rect, &mut self.state.layers);
        if let Some(command) = view3d::view_buttons(ui, rect) {
            self.obey(ui.ctx(), command);
        }
    }

    /// Value under the cursor; asked for again only when the cursor moved.
    fn stock_under_cursor(
        &mut self,
        ui: &Ui,
        response: &egui::Response,
        camera: &crate::gpu::camera::Camera,
        options: &SceneOptions,
    ) -> Option<f32> {
        let at = response.hover_pos().filter(|_| !response.dragged())?;
        if self.hover.is_none_or(|(before, _)| before != at) {
            let from_corner = at - response.rect.min;
            let picture = self.picture.as_ref()?;
            let hit =
                picture.hit(camera, options, glam::vec2(from_corner.x, from_corner.y), response.rect.size());
            self.hover = Some((at, hit));
        }
        let hit = self.hover?.1;
        if let Some(position) = hit.position {
            response.clone().on_hover_text_at_pointer(format!("Position {}", position + 1));
        }
        let _ = ui;
        hit.stock
    }

    fn note_first_picture(&mut self) {
        if let (Some(start), None) = (self.start, self.first_picture) {
            let told = std::env::var_os("VANECUT_TIMES").is_some();
            if let Some(picture) = self.picture.as_ref().filter(|_| told) {
                picture.wait();
            }
            let took = start.elapsed();
            self.first_picture = Some(took);
            if told {
                eprintln!("vanecut: first picture after {:.0} ms", 1e3 * took.as_secs_f64());
            }
        }
    }

    fn show_side(&mut self, side: planned::Side) {
        self.state.show(side);
        if let Some(picture) = &mut self.picture {
            picture.set_plan(self.state.planned.as_deref().map(|planned| (planned, side)));
        }
        self.hover = None;
    }

    fn update_title(&mut self, ctx: &egui::Context) {
        let title = match &self.state.part {
            Some(part) => format!("{} - Vanecut", part.impeller.name),
            None => "Vanecut".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

/// A still picture becomes smooth this long after the last move.
const SMOOTH_AFTER: Duration = Duration::from_millis(150);

/// What the renderer is told.
fn options(state: &State, ui: &Ui) -> SceneOptions {
    let layers = state.layers;
    SceneOptions {
        show_hub: layers.hub,
        show_blades: layers.blades,
        show_shroud: layers.shroud,
        show_cutters: if layers.cutters { CutterFilter::All } else { CutterFilter::Hidden },
        show_axes: layers.axes,
        show_floor_colours: layers.floor,
        range_mm: state.planned.as_ref().map_or((0.0, 1.0), |planned| planned.range),
        theme: if ui.visuals().dark_mode { crate::gpu::Theme::Dark } else { crate::gpu::Theme::Light },
        selected: state.selected,
        pixel_scale: ui.pixels_per_point(),
        ..SceneOptions::default()
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.collect();
        self.take_drops(ctx);
        for command in Command::pressed(ctx) {
            if self.can(command) {
                self.obey(ctx, command);
            }
        }
        if self.work.running().is_some() {
            ctx.request_repaint_after(work::PROGRESS_EVERY);
        }
        self.update_title(ctx);
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        Panel::top("menu").show(ui, |ui| self.menu(ui));
        let open = self.state.part.is_some();
        if open {
            Panel::top("verdict").show(ui, |ui| {
                ui.horizontal_wrapped(|ui| panels::verdict::show(ui, &self.state));
            });
        }
        Panel::bottom("status").exact_size(28.0).show(ui, |ui| {
            let activity =
                panels::status::Activity { running: self.work.running(), device: self.device.clone() };
            if panels::status::show(ui, &self.state, &activity) {
                self.obey(ui.ctx(), Command::Cancel);
            }
        });
        if open {
            Panel::left("left")
                .default_size(theme::LEFT_WIDTH)
                .min_size(200.0)
                .show(ui, |ui| self.left_panel(ui));
            Panel::right("right").default_size(theme::RIGHT_WIDTH).min_size(240.0).show(ui, |ui| {
                ui.add_space(4.0);
                if let Some(k) = self.state.selected {
                    let frame = egui::Frame::new().inner_margin(egui::Margin::symmetric(0, 2));
                    Panel::bottom("selected position").resizable(false).frame(frame).show(ui, |ui| {
                        panels::positions::details(ui, &self.state, k);
                    });
                }
                CentralPanel::no_frame().show(ui, |ui| panels::positions::show(ui, &mut self.state));
            });
        }
        CentralPanel::no_frame().show(ui, |ui| self.middle(ui));
        if let Some((purpose, path)) = self.dialogs.show(ui) {
            self.file_chosen(purpose, path);
        }
        let time = ui.input(|input| input.time);
        self.undoer.feed_state(time, &self.state.setup);
    }
}
