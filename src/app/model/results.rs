//! Results: the latest plans, and the figures of setups that were planned before.

use std::sync::Arc;

use crate::io::InputError;
use crate::io::project_file::SetFigures;
use crate::job::PolicyResult;
use crate::job::flank::FlankOutcome;
use crate::setup::{Setup, Tool};

use crate::app::model::checked::{CheckedProgram, FileChange};
use crate::app::model::exported::ExportedPrograms;
use crate::app::model::flank_passes::FlankPasses;
use crate::app::model::flank_run::FlankRun;
use crate::app::model::listing::ProgramListing;
use crate::app::model::machine::ProgramOnMachine;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::preview::PlanPreview;
use crate::app::model::units::DisplayUnits;

/// Figures of a plan.
fn figures_of(result: &PolicyResult, channels: usize) -> SetFigures {
    let summary = &result.summary;
    SetFigures {
        positions: summary.positions,
        interferential: result.plan.count_interfering(),
        residual_mean: summary.residual_mean,
        residual_p95: summary.residual_p95,
        uncut_share: summary.uncut_share,
        time: summary.time_s(),
        wheel_time: Some(summary.time_of_channels_s(channels, channels)),
    }
}

/// Maximum number of setups with stored figures; the oldest are dropped first.
const MAX_FIGURES: usize = 64;

/// Whether the program chooses the tools.
fn chooses_tools(setup: &Setup) -> bool {
    setup.tools.is_empty()
}

/// Everything computed for the open part.
#[derive(Debug, Default)]
pub struct Results {
    /// Latest successful plan.
    pub planned: Option<Arc<DisplayPlan>>,
    /// What the last plan changed in tools and sections that the program chooses, as a sentence; `None` if
    /// nothing.
    pub tool_change: Option<String>,
    /// Preview of the running plan, if there is one.
    pub preview: Option<Arc<PlanPreview>>,
    /// Latest successful flank plan.
    pub flank: Option<Arc<FlankOutcome>>,
    /// Whether one is being calculated.
    pub flank_is_running: bool,
    /// Whether a program is being checked.
    pub check_is_running: bool,
    /// The flank plan in the shown channels.
    pub flank_run: Option<Arc<FlankRun>>,
    /// Its passes; empty without one.
    pub passes: Arc<FlankPasses>,
    /// The program that was checked last.
    pub checked: Option<Arc<CheckedProgram>>,
    /// What became of its file since then.
    pub program_file: FileChange,
    /// Whether the last attempt to check it again failed.
    pub recheck_failed: bool,
    /// The shown plan on the machine of the setup; `None` without a machine, or until it is known.
    pub on_machine: Option<Result<Arc<ProgramOnMachine>, InputError>>,
    /// The program of the shown plan; `None` until it is known.
    pub listing: Option<Arc<ProgramListing>>,
    /// The program files that were written.
    pub exported: ExportedPrograms,
    figures: Vec<(Setup, SetFigures)>,
}

impl Results {
    /// Words in place of a plan that is not there yet.
    pub fn words_without_plan(&self) -> &'static str {
        if self.preview.is_some() { "Calculating…" } else { "Not calculated yet" }
    }

    /// The tools that the program chose for the shown plan; empty where the setup gives them.
    pub fn chosen_tools(&self) -> &[Tool] {
        let planned = self.planned.as_ref().filter(|planned| chooses_tools(&planned.setup));
        planned.map_or(&[], |planned| &planned.outcome.setup.tools)
    }

    /// Stores a plan, and its figures if it is finished. Its change of tools is described
    /// in `units`.
    pub fn take(&mut self, planned: DisplayPlan, units: DisplayUnits) {
        // A full plan of the setup of a draft says what the draft said.
        if self.planned.as_ref().is_none_or(|last| last.setup != planned.setup) {
            let last = self.planned.as_ref().filter(|last| chooses_tools(&last.setup));
            let last = last.filter(|_| chooses_tools(&planned.setup));
            self.tool_change = last.and_then(|last| planned.tool_change_since(last, units));
        }
        let channels = planned.outcome.workpiece.part.blade_count;
        // Figures of a cancelled plan would be misleading.
        if !planned.is_unfinished() {
            self.store_figures(planned.setup.clone(), figures_of(&planned.outcome.after, channels));
        }
        self.planned = Some(Arc::new(planned));
        self.preview = None;
    }

    /// Words in place of a flank plan that is not there yet.
    pub fn words_without_flank(&self) -> &'static str {
        if self.flank_is_running {
            "Calculating flank milling…"
        } else {
            "Flank milling is not calculated yet"
        }
    }

    /// Stores the figures of a setup.
    pub fn store_figures(&mut self, setup: Setup, figures: SetFigures) {
        self.figures.retain(|(known, _)| *known != setup);
        if self.figures.len() >= MAX_FIGURES {
            self.figures.remove(0);
        }
        self.figures.push((setup, figures));
    }

    /// Figures of a setup, if it was planned.
    pub fn figures(&self, setup: &Setup) -> Option<SetFigures> {
        let planned = self.planned.as_ref().filter(|planned| planned.is_of(setup));
        let setup = planned.map_or(setup, |planned| &planned.setup);
        self.figures.iter().find(|(known, _)| known == setup).map(|(_, figures)| *figures)
    }
}
