//! The window: an eframe application over the same job as the command line.
//!
//! | folder | holds | may use |
//! |---|---|---|
//! | [`model`] | document, results, look, and the rules that connect them; knows no egui | the core, meshes of `gpu` |
//! | [`tasks`] | work in the background: reading, planning, writing, simulating; knows no egui | `model` |
//! | [`views`] | panels, 3D views, menus, dialogs | `model`, `tasks` |
//! | [`control`] | what connects them: commands, results of tasks, project, export | all |
//! | [`mod@run`] | opening the window | all |
//!
//! `tests/layering.rs` holds the order. Views that draw a whole area are methods of [`App`], too: they return
//! what the user asked for to the same commands as menus and keys.
//!
//! The UI thread never waits: work runs on [`crate::job::worker::Worker`]s, which request a repaint when
//! they are done. Without input and background work nothing is drawn.

pub mod control;
pub mod model;
pub mod run;
pub mod tasks;
pub mod views;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::CreationContext;
use egui::{CentralPanel, Panel, Ui};

pub use run::{AppError, run};

use control::export::{PostponedExport, ReleaseQuestion};
use control::handover::RecoverySlot;
use control::project::Session;
use control::replaced::check_replaced;
use control::unsaved::Pending;
use control::windows::is_typing;
use model::look::{Look, Operation};
use model::panels::DockPanel;
use model::part_source::PartSource;
use model::planned::{PerSide, Side};
use model::problem::{Problem, Topic};
use model::state::AppState;
use tasks::assess::AssessWork;
use tasks::engine::Engine;
use tasks::flank_runs::FlankRunWork;
use tasks::listing::ListingWork;
use tasks::machine::MachineWork;
use tasks::machine_name::MachineNames;
use tasks::program_watch::ProgramWatch;
use tasks::programs::JudgedFlank;
use tasks::scrub::{InspectedSection, TimelineStock};
use tasks::solid::{SolidPicture, SolidWork};
use tasks::tradeoff::TradeoffWork;
use tasks::work::{PROGRESS_EVERY, Work};
use views::channels_dialog::ChannelsDialog;
use views::command::Command;
use views::dialogs::{Dialogs, FileDialog};
use views::dock::Dock;
use views::help::Help;
use views::key_order::KeyOrder;
use views::nc_dialog::NcDialog;
use views::palette::Palette;
use views::panels::library::{LibraryAnswer, LibraryPanel, TakingSetup};
use views::panels::study::StudyPanel;
use views::panels::{self, part::PartAction};
use views::picture_dialog::{ExportDialog, ExportSettings};
use views::pictures::{Pictures, PreviewSource};
use views::roles::RolesDialog;
use views::timeline_tool::TimelineTool;
use views::tour::{Tour, WindowRegion};
use views::under_cursor::Hover;
use views::view3d::{View3d, ViewHit};
use views::viewport::ScreenInfo;
use views::{repaint, theme};

/// The application.
pub struct App {
    state: AppState,
    engine: Engine,
    work: Work,
    dialogs: Dialogs,
    view: View3d,
    /// `None` on a device that cannot draw; the panels work without it.
    pictures: Option<Pictures>,
    scrubbed: TimelineStock,
    inspected: InspectedSection,
    /// The shown program on its machine.
    machining: MachineWork,
    machine_names: MachineNames,
    /// The text of the shown program.
    listing: ListingWork,
    program_watch: ProgramWatch,
    /// The flank plan in several channels.
    flank_runs: FlankRunWork,
    judged_flank: Arc<JudgedFlank>,
    /// The machinability of the part.
    assessing: AssessWork,
    /// Time against stock of the plan.
    weighing: TradeoffWork,
    /// The tool of the flank plan or checked program at the position of the timeline.
    timeline_tool: TimelineTool,
    /// The solid stock of each side.
    solids: PerSide<SolidWork>,
    hover: Option<Hover>,
    /// Target of the right click, while its context menu is open.
    context_hit: Option<(Side, ViewHit)>,
    /// Whether a section border is being dragged.
    is_dragging_border: bool,
    screen: ScreenInfo,
    palette: Palette,
    help: Help,
    tour: Tour,
    session: Session,
    export: ExportSettings,
    export_dialog: ExportDialog,
    channels_dialog: ChannelsDialog,
    nc_dialog: NcDialog,
    library: LibraryPanel,
    /// The results of a study.
    study: StudyPanel,
    /// The places of the panels.
    dock: Dock,
    /// The question about a program with something against it, while it is open.
    release: Option<ReleaseQuestion>,
    /// The program that is written once its plan is calculated again.
    postponed: Option<PostponedExport>,
    roles: RolesDialog,
    device: String,
    /// Receives the window's state when the device is lost.
    recovery_slot: Option<RecoverySlot>,
    /// Whether the state was handed over; the window then only waits to be closed.
    handed_over: bool,
    title: String,
    start: Option<Instant>,
    first_picture: Option<Duration>,
}

impl App {
    /// The application over the real planner.
    pub fn new(cc: &CreationContext<'_>) -> Self {
        Self::with_engine(cc, Engine::default())
    }

    /// The application over other functions; used by tests.
    pub fn with_engine(cc: &CreationContext<'_>, engine: Engine) -> Self {
        theme::apply(&cc.egui_ctx);
        cc.egui_ctx.add_plugin(KeyOrder::default());
        let pictures = cc.wgpu_render_state.as_ref().map(Pictures::new);
        let device = pictures.as_ref().map_or_else(|| "no 3D view".to_owned(), Pictures::device_name);
        let work = Work::new(&engine, &repaint(&cc.egui_ctx));
        let weighing = TradeoffWork::new(&repaint(&cc.egui_ctx), work.ranks.curve.clone());
        Self {
            state: AppState::default(),
            work,
            engine,
            dialogs: Dialogs::new(&cc.egui_ctx),
            view: View3d::default(),
            pictures,
            scrubbed: TimelineStock::new(&repaint(&cc.egui_ctx)),
            inspected: InspectedSection::new(&repaint(&cc.egui_ctx)),
            machining: MachineWork::new(&repaint(&cc.egui_ctx)),
            machine_names: MachineNames::new(&repaint(&cc.egui_ctx)),
            listing: ListingWork::new(&repaint(&cc.egui_ctx)),
            program_watch: ProgramWatch::new(&repaint(&cc.egui_ctx)),
            flank_runs: FlankRunWork::new(&repaint(&cc.egui_ctx)),
            judged_flank: Arc::default(),
            assessing: AssessWork::new(&repaint(&cc.egui_ctx)),
            weighing,
            timeline_tool: TimelineTool::default(),
            solids: PerSide::new(|_| SolidWork::new(&repaint(&cc.egui_ctx))),
            hover: None,
            context_hit: None,
            is_dragging_border: false,
            screen: ScreenInfo::default(),
            palette: Palette::default(),
            help: Help::default(),
            tour: Tour::default(),
            session: Session::default(),
            export: ExportSettings::default(),
            export_dialog: ExportDialog::default(),
            channels_dialog: ChannelsDialog::default(),
            nc_dialog: NcDialog::default(),
            library: LibraryPanel::default(),
            study: StudyPanel::default(),
            dock: Dock::default(),
            release: None,
            postponed: None,
            roles: RolesDialog::default(),
            device,
            recovery_slot: None,
            handed_over: false,
            title: String::new(),
            start: None,
            first_picture: None,
        }
    }

    /// Sets the start of the time measured by [`App::first_picture`].
    pub fn set_start_time(&mut self, start: Instant) {
        self.start = Some(start);
    }

    /// Opens a part in the background, then plans it.
    pub fn open_part(&mut self, source: PartSource) {
        self.open_files(Some(source), None);
    }

    /// The window's state: document, results and look.
    pub fn state(&self) -> &AppState {
        &self.state
    }

    /// How part and plan are displayed, for changes from outside.
    pub fn look_mut(&mut self) -> &mut Look {
        &mut self.state.look
    }

    /// Asks for files in the window itself, without trying the dialogs of the system.
    pub fn use_own_file_dialogs(&mut self) {
        self.dialogs.use_own_dialogs();
    }

    /// Asks `dialog` for files instead of the dialogs of the system; used by tests.
    pub fn use_file_dialog(&mut self, dialog: FileDialog) {
        self.dialogs.use_dialog(dialog);
    }

    /// Sets what computes the stock that the views draw.
    pub fn set_preview_source(&mut self, source: PreviewSource) {
        if let Some(pictures) = &mut self.pictures {
            pictures.set_preview_source(source);
        }
    }

    /// From now on only [`Self::draw_waiting_pictures`] draws the 3D views; used by tests.
    pub fn wait_to_draw_pictures(&mut self) {
        if let Some(pictures) = &mut self.pictures {
            pictures.wait_to_draw();
        }
    }

    /// Draws the 3D views of the last frame.
    pub fn draw_waiting_pictures(&mut self) {
        if let Some(pictures) = &mut self.pictures {
            pictures.draw_waiting();
        }
    }

    /// The solid stock that a side shows; `None` while the layer is hidden or nothing is computed yet.
    pub fn solid(&self, side: Side) -> Option<&SolidPicture> {
        self.solids[side].shown().map(|picture| &**picture)
    }

    /// Camera of the 3D view; `None` before a part is open.
    pub fn camera(&self) -> Option<crate::gpu::camera::Camera> {
        self.view.current()
    }

    /// Whether a background task runs.
    pub fn is_busy(&self) -> bool {
        self.running_task().is_some()
            || self.work.copier.is_busy()
            || self.dialogs.is_busy()
            || self.scrubbed.is_busy()
            || self.inspected.is_busy()
            || self.machining.is_busy()
            || self.machine_names.is_busy()
            || self.listing.is_busy()
            || self.flank_runs.is_busy()
            || self.assessing.is_busy()
            || self.weighing.is_busy()
            || self.solids.iter().any(SolidWork::is_busy)
    }

    /// Whether the flank program that was judged last is kept.
    pub fn keeps_judged_flank(&self) -> bool {
        self.judged_flank.is_kept()
    }

    /// Time from start to the first picture of a part; `None` before it.
    pub fn first_picture(&self) -> Option<Duration> {
        self.first_picture
    }

    /// Whether a question is open that has to be answered first.
    pub(in crate::app) fn is_asking(&self) -> bool {
        self.session.is_asking()
            || self.export_dialog.is_open()
            || self.channels_dialog.is_open()
            || self.nc_dialog.is_open()
            || self.release.is_some()
            || self.roles.is_open()
            || self.dialogs.is_asking()
            || self.help.is_open()
    }

    /// Runs the action a panel returned.
    fn apply_action(&mut self, ctx: &egui::Context, action: PartAction) {
        match action {
            PartAction::Command(command) => self.run_command(ctx, command),
            PartAction::Open(source) => self.run_guarded(ctx, Pending::OpenPart(source, None)),
            PartAction::OpenFile(path) => self.run_guarded(ctx, Pending::Open(path)),
            PartAction::DiscardRecovery(path) => self.begin_discarding(&path),
        }
    }

    /// The tool library.
    fn tool_library(&mut self, ui: &mut Ui) {
        let is_docked = !self.state.look.panels.floats(DockPanel::ToolLibrary);
        let document = &mut self.state.document;
        let chosen = self.state.results.chosen_tools();
        let setup = document.part.is_some().then_some(&mut document.edited.setup);
        let setup = setup.map(|setup| TakingSetup { setup, chosen });
        let answer = self.library.show(ui, setup, is_docked);
        let time = ui.input(|input| input.time);
        self.library.watch(time);
        match answer {
            Some(LibraryAnswer::Command(command)) => self.run_command(ui.ctx(), command),
            Some(LibraryAnswer::Taken(text)) => self.state.report_done(text),
            None => {}
        }
    }

    fn update_title(&mut self, ctx: &egui::Context) {
        let document = &self.state.document;
        let title = match &document.part {
            Some(part) => {
                let file = document.path.as_ref().and_then(|path| path.file_stem());
                let file = file.map_or(String::new(), |name| format!(" · {}", name.to_string_lossy()));
                let mark = if document.is_unsaved() { " •" } else { "" };
                format!("{}{file}{mark} - Vanecut", part.impeller.name)
            }
            None => "Vanecut".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for App {
    /// Time between two times that theme and text size are stored, which then outlast a crash.
    fn auto_save_interval(&self) -> Duration {
        Duration::from_secs(5)
    }

    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        if !self.was_handed_over() {
            self.state.follow_selection();
            self.collect(ctx);
            self.state.follow_selection();
        }
        if self.was_handed_over() {
            return;
        }
        self.take_drops(ctx);
        self.watch_closing(ctx);
        self.dialogs.take_typed(ctx);
        let typing = is_typing(ctx);
        // While a dialog or the command search is open, shortcuts are disabled.
        if !self.palette.is_open() && !self.is_asking() {
            // An open menu takes Escape first, then the window in front, then the tour.
            let keeps_escape = egui::Popup::is_any_open(ctx)
                || self.escape_closes_window(ctx, typing)
                || self.tour.is_open();
            let can = |command: Command| match command {
                Command::Cancel if keeps_escape => false,
                Command::Deselect if keeps_escape || typing => false,
                _ => self.is_heard(command),
            };
            for command in Command::pressed(ctx, can) {
                // One before it may have ended what it needs.
                if self.is_heard(command) {
                    self.run_command(ctx, command);
                }
                // Other keys of the same frame are not meant for the window below the dialog that it has
                // opened.
                if self.is_asking() {
                    break;
                }
            }
        }
        self.rank_work();
        self.plan_edits(ctx.input(|input| input.pointer.any_down()));
        self.claim_project(ctx);
        self.look_for_copies(ctx);
        self.keep_copy(ctx);
        self.keep_library_copy(ctx);
        if let Some(wait) = self.state.advance(ctx.input(|input| input.time)) {
            ctx.request_repaint_after(Duration::from_secs_f64(wait));
        }
        self.state.follow_channels();
        self.state.follow_flank_channels();
        if let Some(run) = self.flank_runs.follow(self.state.wanted_flank_run()) {
            self.state.show_flank_run(run);
        }
        self.scrubbed.follow(&self.state);
        self.inspected.follow(&self.state);
        self.state.results.flank_is_running = self.work.is_calculating(Operation::Flank);
        self.judged_flank.forget_replaced();
        self.state.results.check_is_running = self.work.is_calculating(Operation::Program);
        self.state.results.on_machine = self.machining.follow(&self.state);
        let (setup, readings) = (&self.state.document.edited.setup, self.state.machines.readings);
        if let Some(named) = self.machine_names.follow(setup, readings) {
            let was_faulty = self.state.machines.fault_of(&named.file).is_some();
            self.state.machines.note(named);
            if was_faulty && named.name.is_ok() {
                self.state.solve(Topic::Machine);
            }
        }
        self.state.results.listing = self.listing.follow(&self.state);
        self.watch_program(ctx);
        self.assessing.follow(&self.state, self.is_in_view(DockPanel::Machinability));
        let weighs = self.is_in_view(DockPanel::Tradeoff);
        self.weighing.follow(&self.state, weighs, self.work.is_planning());
        for side in [Side::Before, Side::After] {
            let wanted = self.state.wanted_solid(side);
            if let Some(fault) = self.solids[side].follow(wanted) {
                let help = "recalculate, or hide the layer";
                self.state.report_problem(Problem::about(
                    Topic::Stock,
                    &format!("Stock as a solid: {fault}"),
                    help,
                ));
            }
        }
        if self.running_task().is_some() {
            ctx.request_repaint_after(PROGRESS_EVERY);
        }
        self.update_title(ctx);
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        if self.was_handed_over() {
            return;
        }
        views::modal::hide_tooltips_below(ui.ctx());
        views::begin_frame(ui.ctx(), &self.state);
        let menus = Panel::top("menu").show(ui, |ui| self.menu(ui)).response.rect;
        let mut verdict = None;
        let open = self.state.document.part.is_some();
        if open {
            let height = panels::verdict::height(ui.available_width());
            let line = Panel::top("verdict").exact_size(height).show(ui, |ui| {
                panels::verdict::show(ui, &self.state);
            });
            verdict = Some(line.response.rect);
        }
        Panel::bottom("status").exact_size(28.0).show(ui, |ui| {
            let preview = self.pictures.as_ref().map(Pictures::preview_name);
            let activity = panels::status::Activity {
                running: self.running_task(),
                can_cancel: self.can_cancel(),
                preview: preview.unwrap_or_else(|| "no 3D view".to_owned()),
                device: self.device.clone(),
                awaits_file: self.dialogs.is_waiting(),
            };
            if panels::status::show(ui, &self.state, &activity) {
                self.run_command(ui.ctx(), Command::Cancel);
            }
        });
        let middle = CentralPanel::no_frame().show(ui, |ui| match open {
            true => self.docked_panels(ui),
            false => self.picture(ui),
        });
        let middle = middle.response.rect;
        let check = |purpose, path: &Path| check_replaced(&self.state, purpose, path);
        if let Some((purpose, path)) = self.dialogs.show(ui, &check) {
            self.file_chosen(ui.ctx(), purpose, path);
        }
        let mut palette = std::mem::take(&mut self.palette);
        let command = palette.show(ui, |command| self.is_available(command));
        self.palette = palette;
        if let Some(command) = command {
            self.run_command(ui.ctx(), command);
        }
        self.floating_panels(ui, menus.bottom());
        self.state.end_field_faults(&views::field_faults::edited(ui.ctx()));
        self.state.look.is_fresh &= !open;
        self.help.show(ui, &self.device);
        let setup = self.dock.rect(DockPanel::Setup);
        let (picture, table) = (self.dock.picture_rect(), self.dock.rect(DockPanel::Table));
        self.show_tour(ui, |region| match region {
            WindowRegion::Setup => setup,
            WindowRegion::Verdict => verdict,
            WindowRegion::Picture => picture.or(Some(middle)),
            WindowRegion::Table => table,
            WindowRegion::Menus => Some(menus),
        });
        self.ask_unsaved(ui);
        self.ask_changed(ui);
        self.ask_missing_part(ui);
        self.ask_recover(ui);
        self.ask_discard(ui);
        self.go_on_with_export(ui.ctx());
        self.ask_release(ui);
        self.ask_export(ui);
        self.ask_channels(ui);
        self.ask_nc_target(ui);
        self.ask_roles(ui);
        views::drop_sign::show(ui.ctx(), self.is_asking());
        // A border drag is one undo step, however long it takes.
        if !self.is_dragging_border {
            let time = ui.input(|input| input.time);
            self.state.document.watch(time);
        }
        views::modal::keep_lists_above(ui.ctx());
        self.store_layout(ui.ctx());
        // The device may have been lost while the views were drawn.
        self.collect_device_faults(ui.ctx());
    }
}
