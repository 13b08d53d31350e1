//! Recovery from a lost graphics device. A window cannot change its device, so it closes, and a new window
//! opens on another device with the same state.

use std::cell::RefCell;
use std::rc::Rc;

use eframe::CreationContext;
use egui::{Context, ThemePreference, Vec2, ViewportCommand};

use crate::app::App;
use crate::app::control::project::Session;
use crate::app::model::problem::Problem;
use crate::app::model::state::AppState;
use crate::app::tasks::engine::Engine;
use crate::app::tasks::part_meshes::PartMeshes;
use crate::app::views::dock::Dock;
use crate::app::views::panels::library::LibraryPanel;
use crate::app::views::picture_dialog::ExportSettings;
use crate::app::views::view3d::View3d;

/// State of a window without its device.
pub struct Handover {
    state: AppState,
    view: View3d,
    session: Session,
    export: ExportSettings,
    dock: Dock,
    library: LibraryPanel,
    mesh: Option<PartMeshes>,
    /// Whether the planner was running.
    planning: bool,
    theme: ThemePreference,
    size: Option<Vec2>,
    /// Error message of the device.
    reason: String,
}

impl Handover {
    /// Size of the window, points; `None` where the system does not report it.
    pub fn size(&self) -> Option<Vec2> {
        self.size
    }

    /// Error message of the device.
    pub fn reason(&self) -> &str {
        &self.reason
    }
}

/// Shared slot through which a closing window passes its state to the next one.
#[derive(Clone, Default)]
pub struct RecoverySlot(Rc<RefCell<Option<Handover>>>);

impl RecoverySlot {
    /// Takes the state out of the slot.
    pub fn take(&self) -> Option<Handover> {
        self.0.borrow_mut().take()
    }
}

impl App {
    /// Sets the slot that receives the state when the device is lost; the window then closes. Without a slot
    /// the window stays open, without pictures.
    pub fn set_recovery_slot(&mut self, way_out: RecoverySlot) {
        self.recovery_slot = Some(way_out);
    }

    /// The application with the state of another window.
    pub fn resumed(cc: &CreationContext<'_>, engine: Engine, left: Handover) -> Self {
        let mut app = Self::with_engine(cc, engine);
        let Handover { state, view, session, export, dock, library, mesh, planning, theme, reason, .. } =
            left;
        (app.state, app.view, app.session, app.export) = (state, view, session, export);
        (app.dock, app.library) = (dock, library);
        cc.egui_ctx.set_theme(theme);
        if let Some((pictures, mesh)) = app.pictures.as_mut().zip(mesh) {
            pictures.set_part(mesh);
        }
        app.state.results.preview = None;
        app.state.report_problem(Problem::new(
            format!("The graphics device was lost ({reason}); the window continues with the software driver"),
            "",
        ));
        if planning {
            app.plan();
        }
        app
    }

    /// Whether the state was handed over and the window only waits to be closed.
    pub(in crate::app) fn was_handed_over(&self) -> bool {
        self.handed_over
    }

    /// Hands the state over and closes the window; `false` without a slot.
    pub(in crate::app) fn hand_over(&mut self, ctx: &Context, reason: &str) -> bool {
        let Some(way_out) = self.recovery_slot.take() else { return false };
        let planning = self.work.is_planning();
        let handover = Handover {
            state: std::mem::take(&mut self.state),
            view: std::mem::take(&mut self.view),
            session: std::mem::take(&mut self.session),
            export: self.export,
            dock: std::mem::take(&mut self.dock),
            library: std::mem::take(&mut self.library),
            mesh: self.pictures.as_ref().and_then(|pictures| pictures.mesh().cloned()),
            planning,
            theme: ctx.options(|options| options.theme_preference),
            size: ctx.input(|input| input.viewport().inner_rect).map(|rect| rect.size()),
            reason: reason.to_owned(),
        };
        *way_out.0.borrow_mut() = Some(handover);
        self.handed_over = true;
        self.pictures = None;
        // Nothing may be drawn any more on the lost device.
        ctx.graphics_mut(|graphics| *graphics = Default::default());
        ctx.send_viewport_cmd(ViewportCommand::Close);
        true
    }
}
