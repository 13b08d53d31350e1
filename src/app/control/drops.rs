//! Files dropped on the window: what opens alone, what together, and what is refused.

use std::path::{Path, PathBuf};

use egui::Context;

use crate::app::App;
use crate::app::control::unsaved::Pending;
use crate::app::model::file_purpose::FilePlace;
use crate::app::model::part_source::PartSource;
use crate::app::model::problem::Problem;
use crate::app::tasks::files;
use crate::io::plan_inputs::is_plan_file;

/// Extensions of files that belong to a part file beside them: they come with it, and are read with it.
const COMPANIONS: [&str; 6] = ["curve", "bin", "png", "jpg", "jpeg", "webp"];

/// Whether a file belongs to a part file beside it.
fn is_companion(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| COMPANIONS.iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

/// Whether a file holds a part and nothing else.
fn is_part(path: &Path) -> bool {
    files::closes_project(path) && !files::is_project(path) && !is_plan_file(path)
}

impl App {
    /// Opens the files that were dropped in this frame.
    pub(in crate::app) fn take_drops(&mut self, ctx: &Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<PathBuf> = dropped.iter().map(|file| file.path().to_path_buf()).collect();
        if paths.is_empty() {
            return;
        }
        // What is opened beneath a question would be what the answer then applies to.
        if self.is_asking() {
            let what = "Files were dropped while a question was open";
            self.state.report_problem(Problem::unopened(what, "answer it, then drop them again"));
            return;
        }
        match &paths[..] {
            [path] => self.open_guarded(ctx, path.clone()),
            _ => self.open_together(ctx, &paths),
        }
    }

    /// Opens a file; asks first if that closes the project and loses unsaved changes of it. What cannot be
    /// opened is refused without a question.
    pub(in crate::app) fn open_guarded(&mut self, ctx: &Context, path: PathBuf) {
        match files::check_openable(&path) {
            Ok(()) if files::closes_project(&path) => self.run_guarded(ctx, Pending::Open(path)),
            Ok(()) => self.open_file(path),
            Err(error) => self.state.report_problem(Problem::of_opening(&error)),
        }
    }

    /// Opens a part with its setup.
    fn open_together(&mut self, ctx: &Context, paths: &[PathBuf]) {
        let (setups, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
            paths.iter().partition(|path| files::is_setup(path));
        let others: Vec<&PathBuf> = match others.iter().any(|path| !is_companion(path)) {
            true => others.into_iter().filter(|path| !is_companion(path)).collect(),
            false => others,
        };
        match (&others[..], &setups[..]) {
            ([part], []) => self.open_guarded(ctx, (*part).clone()),
            ([part], [setup]) if is_part(part) && files::check_openable(part).is_ok() => {
                self.dialogs.note_folder(FilePlace::Part, part);
                let source = PartSource::File((*part).clone());
                self.run_guarded(ctx, Pending::OpenPart(source, Some((*setup).clone())));
            }
            _ => {
                let name =
                    |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let names: Vec<String> = paths.iter().map(name).collect();
                let what = format!("These files cannot be opened together: {}", names.join(", "));
                let help = "drop a part alone or with one setup, and everything else alone";
                self.state.report_problem(Problem::unopened(what, help));
            }
        }
    }
}
