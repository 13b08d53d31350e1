//! What runs in the background, and what becomes of it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::formats::InputError;
use crate::formats::setup_file::read_setup;
use crate::gpu::part_mesh::PartMesh;
use crate::job::JobError;
use crate::job::worker::{End, Worker};
use crate::part::{Impeller, Setup};

use super::App;
use super::dialogs::Purpose;
use super::engine::{Engine, PartSource, PlanTask};
use super::files::{self, WriteTask};
use super::planned::{Planned, Side};

/// What to open: a part, a setup, or both.
pub(super) struct OpenTask {
    part: Option<PartSource>,
    setup: Option<PathBuf>,
}

/// What was opened.
pub(super) struct Opened {
    part: Option<(PartSource, Arc<Impeller>, PartMesh)>,
    setup: Option<(PathBuf, Setup)>,
}

/// The background threads.
pub(super) struct Work {
    opener: Worker<OpenTask, Opened, InputError>,
    planner: Worker<PlanTask, Planned, JobError>,
    writer: Worker<WriteTask, String, InputError>,
}

/// How often progress moves on the screen while something runs.
pub(super) const PROGRESS_EVERY: Duration = Duration::from_millis(60);

impl Work {
    /// Starts the threads; each end repaints the window.
    pub(super) fn new(engine: &Engine, ctx: &egui::Context) -> Self {
        let repaint = || {
            let ctx = ctx.clone();
            move || ctx.request_repaint()
        };
        let (to_open, to_plan) = (engine.clone(), engine.clone());
        let open = move |task: &OpenTask, monitor: &crate::monitor::Monitor| {
            let setup = match &task.setup {
                Some(path) => Some((path.clone(), read_setup(path)?)),
                None => None,
            };
            let part = match &task.part {
                Some(source) => {
                    let impeller = (to_open.open)(source, monitor)?;
                    let mesh = PartMesh::new(&impeller);
                    Some((source.clone(), impeller, mesh))
                }
                None => None,
            };
            Ok(Opened { part, setup })
        };
        Self {
            opener: Worker::new("open", open, repaint()),
            planner: Worker::new("plan", move |task, monitor| to_plan.planned(task, monitor), repaint()),
            writer: Worker::new("write", |task, _| files::write(task), repaint()),
        }
    }

    /// What runs, and how far it is.
    pub(super) fn running(&self) -> Option<(&'static str, f64)> {
        let opening = self.opener.progress().map(|fraction| ("Opening", fraction));
        let planning = || self.planner.progress().map(|fraction| ("Planning", fraction));
        let writing = || self.writer.progress().map(|fraction| ("Writing", fraction));
        opening.or_else(planning).or_else(writing)
    }
}

impl App {
    pub(super) fn open_files(&mut self, part: Option<PartSource>, setup: Option<PathBuf>) {
        self.state.opening.clone_from(&part);
        self.state.notice = None;
        self.work.opener.submit(OpenTask { part, setup });
    }

    /// Plans with the setup as it stands.
    pub(super) fn plan(&mut self) {
        let Some(part) = &self.state.part else { return };
        self.state.notice = None;
        let task = PlanTask {
            part: Arc::clone(&part.impeller),
            setup: self.state.setup.clone(),
            compare: self.state.compare,
        };
        self.work.planner.submit(task);
    }

    /// Stops what the user waits for. Writing is over in a moment and is left to end.
    pub(super) fn cancel(&mut self) {
        self.work.opener.cancel();
        self.work.planner.cancel();
    }

    /// Takes in what the threads have finished.
    pub(super) fn collect(&mut self) {
        if let Some((_, end)) = self.work.opener.take_end() {
            self.state.opening = None;
            match end {
                End::Done(opened) => self.take_opened(opened),
                End::Cancelled => self.state.done("Opening cancelled"),
                End::Failed(error) => self.state.fault(error.to_string()),
                End::Broken(what) => self.state.fault(broken("Opening", &what)),
            }
        }
        if let Some((_, end)) = self.work.planner.take_end() {
            match end {
                End::Done(planned) => {
                    // A part that was opened meanwhile has a plan of its own on the way.
                    let part = self.state.part.as_ref();
                    if part.is_some_and(|part| Arc::ptr_eq(&part.impeller, &planned.outcome.part)) {
                        self.state.take_plan(planned);
                        self.show_side(self.state.side);
                    }
                }
                End::Cancelled | End::Failed(JobError::Cancelled) => {
                    let kept = if self.state.planned.is_some() { "; the plan before stays" } else { "" };
                    self.state.done(format!("Planning cancelled{kept}"));
                }
                End::Failed(error) => self.state.fault(error.to_string()),
                End::Broken(what) => self.state.fault(broken("Planning", &what)),
            }
        }
        if let Some((_, end)) = self.work.writer.take_end() {
            match end {
                End::Done(text) => self.state.done(text),
                End::Cancelled => {}
                End::Failed(error) => self.state.fault(error.to_string()),
                End::Broken(what) => self.state.fault(broken("Writing", &what)),
            }
        }
        let errors = self.picture.as_ref().map(|picture| picture.take_errors()).unwrap_or_default();
        if let Some(error) = errors.last() {
            let line = error.lines().next().unwrap_or_default();
            self.state
                .fault(format!("The graphics device reports: {line}; start again with VANECUT_GPU=software"));
        }
    }

    fn take_opened(&mut self, opened: Opened) {
        let Opened { part, setup } = opened;
        let new_part = part.is_some();
        if let Some((source, impeller, mesh)) = part {
            self.work.planner.cancel();
            let _ = self.work.planner.take_end();
            self.state.open(source, impeller);
            // Cutters and limits of another part would only mislead.
            if setup.is_none() {
                self.state.setup = Setup::default();
                self.state.setup_path = None;
            }
            self.view.reset();
            self.hover = None;
            if let Some(picture) = &mut self.picture {
                picture.set_part(mesh);
            }
        }
        if let Some((path, setup)) = setup {
            self.state.done(format!("Opened {}", path.display()));
            self.state.setup = setup;
            self.state.setup_path = Some(path);
        }
        // The first plan of a part comes by itself; later ones only when asked for.
        if new_part || self.state.planned.is_none() {
            self.plan();
        }
    }

    /// Goes on once a file was chosen: reads or writes it in the background.
    pub fn file_chosen(&mut self, purpose: Purpose, path: PathBuf) {
        match purpose {
            Purpose::OpenPart => self.open_part(PartSource::File(path)),
            Purpose::OpenSetup => self.open_files(None, Some(path)),
            Purpose::SaveSetup => self.write(WriteTask::Setup(path, Box::new(self.state.setup.clone()))),
            Purpose::ExportCl => {
                if let Some(planned) = self.state.planned.clone() {
                    self.write(WriteTask::Cl(path, planned));
                }
            }
            Purpose::SavePicture => match self.picture.as_ref().map(|picture| picture.read()) {
                Some(Ok((width, height, rgba))) => self.write(WriteTask::Picture(path, width, height, rgba)),
                Some(Err(error)) => self.state.fault(error.to_string()),
                None => {}
            },
        }
    }

    fn write(&mut self, task: WriteTask) {
        self.work.writer.submit(task);
    }

    /// The side that is shown.
    pub fn side(&self) -> Side {
        self.state.side
    }
}

/// A panic of the program, told so that it can be reported.
fn broken(what: &str, message: &str) -> String {
    format!("{what} broke down ({message}); change the setup or report this with the part file")
}
