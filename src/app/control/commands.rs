//! The commands of the window: which are available, and what each does.

use std::path::Path;

use egui::Context;

use crate::drawing::flank::FlankColours;
use crate::gpu::view::View;

use crate::app::App;
use crate::app::control::unsaved::Pending;
use crate::app::model::file_purpose::Purpose;
use crate::app::model::look::{Arrangement, Operation, Tab};
use crate::app::model::mouse_preset::MousePreset;
use crate::app::model::panels::DockPanel;
use crate::app::model::planned::Side;
use crate::app::model::plunge_edits::CuttingPlace;
use crate::app::model::shop_library::ShopLibrary;
use crate::app::model::state::Boundary;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::help::HelpPage;
use crate::app::views::panels::edit_plunge;

/// Why plunges take no edits while they are planned.
const CALCULATED: &str = "Roughing is still being calculated: edit it when that is done";

impl App {
    /// Whether a command is available now.
    pub(in crate::app) fn is_available(&self, command: Command) -> bool {
        use Command as C;
        let open = self.state.document.part.is_some();
        match command {
            C::NewProject | C::SaveProject | C::SaveProjectAs | C::KeepSet => open,
            C::AssignRoles => self.has_mesh_options(),
            C::DismissProblems => !self.state.problems.is_empty(),
            C::SaveLibrary => self.library.library().is_some(),
            C::StudyResults => self.study.has_results(),
            C::PlanFlank | C::Assess | C::CompareAll | C::ShowTour | C::OpenMachine => open,
            C::SaveAssessment => self.assessing.known(&self.state).is_some(),
            C::CheckProgram => open,
            C::CheckAgain | C::CloseProgram => {
                self.state.results.checked.is_some() || self.work.asked_check.is_some()
            }
            C::ExportCl | C::ExportClSome | C::ExportClAll | C::ExportNc | C::ExportSheet => {
                !self.planned_operations().is_empty()
            }
            C::PassesByLayer | C::PassesByRegion | C::PassesByFeed | C::PassesByWalls => {
                self.state.look.operation == Operation::Flank && self.state.results.flank.is_some()
            }
            C::ExportFlank | C::FlankCurves => self.state.results.flank.is_some(),
            C::ExportScene
            | C::SaveSetup
            | C::Plan
            | C::Fit
            | C::ViewIso
            | C::ViewFront
            | C::ViewTop
            | C::ViewChannel => open,
            C::Perspective | C::SectionPlane | C::Measure => open,
            C::SavePicture => open && self.pictures.is_some(),
            C::BeforeAfter | C::SideBySide | C::Wipe | C::Difference
                if self.state.look.operation != Operation::Roughing =>
            {
                false
            }
            // Plunges that are made at one place each; the only tool of other operations is always shown.
            C::Cutters | C::Axes => self.state.look.operation == Operation::Roughing,
            C::Holders => self.state.look.operation == Operation::Roughing || self.state.shows_one_tool(),
            // Those of a checked program are always shown.
            C::Links => self.state.look.operation != Operation::Program,
            C::Machine => self.state.document.edited.setup.machine.file.is_some(),
            C::ExportStock
            | C::Stock
            | C::TimeAgainstStock
            | C::BeforeAfter
            | C::SideBySide
            | C::Wipe
            | C::Difference
            | C::ViewSection => self.state.results.planned.is_some(),
            C::NextFault | C::PreviousFault | C::NextRow | C::PreviousRow if self.is_program() => {
                self.state.results.checked.as_ref().is_some_and(|checked| !checked.findings.is_empty())
            }
            C::NextRow | C::PreviousRow if self.state.look.operation == Operation::Flank => {
                !self.state.results.passes.passes.is_empty()
            }
            C::NextFault | C::PreviousFault | C::NextRow | C::PreviousRow => {
                self.state.look.operation == Operation::Roughing && self.state.position_count() > 0
            }
            C::NextTool | C::PreviousTool => !self.state.boundaries(Boundary::Tool).is_empty(),
            C::Play
            | C::StepForward
            | C::NextSection
            | C::PreviousSection
            | C::StepBack
            | C::LeapForward
            | C::LeapBack
            | C::ToBlank
            | C::ToEnd => self.state.timeline_len() > 0,
            C::FlyToSelection if self.state.look.operation == Operation::Flank => {
                self.state.look.flank.pass.is_some()
            }
            C::ScrubHere => {
                self.state.look.operation == Operation::Roughing && self.state.selected().is_some()
            }
            C::FlyToSelection | C::ShowInTable | C::OpenSection => self.state.selected().is_some(),
            C::EditPlunge => self.state.selected().is_some(),
            _ if edit_plunge::is_edit(command) => edit_plunge::is_possible(&self.state, command),
            C::MeasureHere => self.measure_start().is_some(),
            C::Cancel => self.can_cancel() || self.state.look.measure.is_some(),
            C::Deselect => self.state.has_selection(),
            C::Undo => {
                self.state.document.can_undo() || self.shown_library().is_some_and(ShopLibrary::can_undo)
            }
            C::Redo => {
                self.state.document.can_redo() || self.shown_library().is_some_and(ShopLibrary::can_redo)
            }
            _ => true,
        }
    }

    /// Whether the keys of a command do something: at least they say why it cannot be done.
    pub(in crate::app) fn is_heard(&self, command: Command) -> bool {
        self.is_available(command) || self.why_refused(command).is_some()
    }

    /// Why a command that is asked for by its keys is not done; `None` where it is, or nothing is to be said.
    fn why_refused(&self, command: Command) -> Option<String> {
        use Command as C;
        match command {
            C::NextFault | C::PreviousFault => self.why_no_fault().map(str::to_owned),
            _ if edit_plunge::is_edit(command) => {
                self.state.selected()?;
                let why = self.state.why_not_edited()?;
                let is_planning = self.work.is_calculating(Operation::Roughing);
                Some(if is_planning { CALCULATED.to_owned() } else { why.to_owned() })
            }
            _ => self.why_not_exported(command),
        }
    }

    /// Words on a plan or a program without faults; `None` where there are some, or nothing is known.
    fn why_no_fault(&self) -> Option<&'static str> {
        if self.is_program() {
            let checked = self.state.results.checked.as_ref()?;
            return checked.findings.is_empty().then_some("The program has no faults");
        }
        if self.state.look.operation == Operation::Flank {
            let outcome = self.state.results.flank.as_ref()?;
            return Some(match outcome.faults.is_empty() {
                true => "The flank program has no faults",
                false => "The results of the flank plan list its faults",
            });
        }
        let is_known = self.state.shown().is_some() && self.state.interfering_plunges().is_empty();
        is_known.then_some("No plunge of this plan interferes")
    }

    /// Whether there is work to cancel.
    pub(in crate::app) fn can_cancel(&self) -> bool {
        self.work.can_cancel() || self.weighing.progress().is_some()
    }

    /// Executes a command.
    pub(in crate::app) fn run_command(&mut self, ctx: &Context, command: Command) {
        use Command as C;
        if let Some(why) = self.why_refused(command) {
            return self.state.report_refusal(why);
        }
        let can_cancel = self.can_cancel();
        // One behind another tab comes to the front.
        let is_behind = |panel| self.state.look.panels.is_open(panel) && !self.is_in_view(panel);
        let behind = [DockPanel::Machinability, DockPanel::Tradeoff].map(is_behind);
        let look = &mut self.state.look;
        match command {
            C::Assess if behind[0] => look.panels.open(DockPanel::Machinability),
            C::TimeAgainstStock if behind[1] => look.panels.open(DockPanel::Tradeoff),
            C::NewProject => self.run_guarded(ctx, Pending::New),
            C::OpenProject => self.dialogs.open_dialog(ctx, Purpose::OpenProject, String::new()),
            C::SaveProject => self.save_project(ctx),
            C::SaveProjectAs => self.ask_for_project(ctx),
            C::Palette => self.palette.toggle(),
            C::KeepSet => {
                let name = self.state.document.keep_set();
                self.state.report_done(format!("The setup is saved as \"{name}\", under Variants"));
            }
            C::FollowEdits => self.state.auto_update ^= true,
            C::CompareAll => self.state.compare ^= true,
            C::DismissProblems => self.state.dismiss_problems(),
            C::OpenPart => self.dialogs.open_dialog(ctx, Purpose::OpenPart, String::new()),
            C::AssignRoles => self.assign_roles(),
            C::OpenSetup => self.dialogs.open_dialog(ctx, Purpose::OpenSetup, String::new()),
            C::OpenBlank => self.dialogs.open_dialog(ctx, Purpose::OpenBlank, String::new()),
            C::OpenMachine => self.dialogs.open_dialog(ctx, Purpose::OpenMachine, String::new()),
            C::ToolLibrary => look.panels.open(DockPanel::ToolLibrary),
            C::OpenStudy => self.dialogs.open_dialog(ctx, Purpose::OpenStudy, String::new()),
            C::StudyResults => look.panels.open(DockPanel::Study),
            C::OpenLibrary => self.dialogs.open_dialog(ctx, Purpose::OpenLibrary, String::new()),
            C::SaveLibrary => self.ask_for_library(ctx),
            C::SaveSetup => {
                self.dialogs.open_dialog(ctx, Purpose::SaveSetup, self.suggest_file_name("setup.toml"));
            }
            C::CheckProgram => self.dialogs.open_dialog(ctx, Purpose::CheckProgram, String::new()),
            C::CheckAgain => self.check_again(),
            C::CloseProgram => self.close_program(),
            C::ExportCl => self.ask_for_cl_file(ctx, 1),
            C::ExportClSome => {
                let (shown, count) = (self.state.look.shown_channels, self.channel_count());
                self.channels_dialog.open(if shown > 1 { shown } else { count }, count);
            }
            C::ExportClAll => self.ask_for_cl_file(ctx, self.channel_count()),
            C::NextTool => self.state.jump_to_boundary(Boundary::Tool, true),
            C::PreviousTool => self.state.jump_to_boundary(Boundary::Tool, false),
            C::NextSection => self.state.jump_to_boundary(Boundary::Section, true),
            C::PreviousSection => self.state.jump_to_boundary(Boundary::Section, false),
            C::ExportScene => self.ask_for_model(ctx, false),
            C::ExportStock => self.ask_for_model(ctx, true),
            C::SavePicture => self.export_dialog.open(),
            C::Quit => self.run_guarded(ctx, Pending::Quit),
            C::Undo => self.undo(ctx),
            C::Redo => self.redo(ctx),
            C::Plan => {
                look.operation = Operation::Roughing;
                // The machine file may have been mended since it was read.
                self.state.machines.readings += 1;
                self.plan();
            }
            C::PlanFlank => {
                look.operation = Operation::Flank;
                self.state.machines.readings += 1;
                self.plan_flank();
            }
            C::ExportFlank => self.ask_for_flank_file(ctx, 1),
            C::ExportNc => self.ask_for_nc_target(),
            C::ExportSheet => {
                let Some(operation) = self.exported_operation() else { return };
                let name = match operation {
                    Operation::Flank => "flank-setup-sheet.html",
                    _ => "setup-sheet.html",
                };
                let name = self.suggest_file_name(name);
                self.dialogs.open_dialog(ctx, Purpose::ExportSheet { operation }, name);
            }
            C::Assess => look.panels.toggle(DockPanel::Machinability),
            C::TimeAgainstStock => look.panels.toggle(DockPanel::Tradeoff),
            C::SaveAssessment => {
                let name = self.suggest_file_name("machinability.html");
                self.dialogs.open_dialog(ctx, Purpose::SaveAssessment, name);
            }
            C::FlankCurves => {
                look.flank.shown = !(look.flank.shown && look.operation == Operation::Flank);
                look.operation = Operation::Flank;
            }
            C::Cancel if !can_cancel => look.measure = None,
            C::Cancel => self.cancel(),
            C::Deselect => self.state.deselect(),
            C::NextFault => self.state.select_next_fault(true),
            C::PreviousFault => self.state.select_next_fault(false),
            C::NextRow => self.state.select_next_row(1),
            C::PreviousRow => self.state.select_next_row(-1),
            C::StepForward => self.state.step_timeline(1),
            C::StepBack => self.state.step_timeline(-1),
            C::LeapForward => self.state.step_timeline(100),
            C::LeapBack => self.state.step_timeline(-100),
            C::ToBlank => self.state.set_timeline(Some(0)),
            C::ToEnd => self.state.set_timeline(None),
            C::Play => self.state.play(ctx.input(|i| i.time)),
            C::BeforeAfter => {
                look.arrangement = Arrangement::One;
                let other = look.side.other();
                self.state.show(other);
            }
            C::SideBySide => self.arrange(Arrangement::Both),
            C::Wipe => self.arrange(Arrangement::Wipe),
            C::Difference => look.difference ^= true,
            C::Fit => {
                if let Some(framing) = self.pictures.as_ref().and_then(|pictures| pictures.framing()) {
                    self.view.fit(framing);
                }
            }
            C::FlyToSelection => look.fly = true,
            C::ViewIso => self.view.look(View::Iso),
            C::ViewFront => self.view.look(View::Front),
            C::ViewTop => self.view.look(View::Top),
            C::ViewChannel => self.view.look(View::Channel),
            C::ViewSection => self.view.look(View::Section(self.current_section() + 1)),
            C::Perspective => self.view.switch_projection(),
            C::SectionPlane => {
                look.switch_section();
                self.turn_section_to_viewer();
            }
            C::Measure => look.measure = if look.measure.is_some() { None } else { Some(Vec::new()) },
            C::ShowInTable => {
                look.panels.open(DockPanel::Table);
                self.state.show_in_table();
            }
            C::OpenSection => {
                look.tab = Tab::Section;
                look.panels.open(DockPanel::Details);
            }
            C::EditPlunge => {
                look.tab = Tab::Edit;
                look.panels.open(DockPanel::Details);
                edit_plunge::focus(ctx);
            }
            C::DeletePlunge => self.state.delete_selected(false),
            C::DeleteRow => self.state.delete_selected(true),
            C::LockPlunge => self.state.toggle_lock(false),
            C::LockRow => self.state.toggle_lock(true),
            C::CutEarlier => self.state.reorder_selected(false, CuttingPlace::Earlier),
            C::CutLater => self.state.reorder_selected(false, CuttingPlace::Later),
            C::CutRowEarlier => self.state.reorder_selected(true, CuttingPlace::Earlier),
            C::CutRowLater => self.state.reorder_selected(true, CuttingPlace::Later),
            C::ScrubHere => {
                let cut = self.state.selected_end();
                self.state.set_timeline(cut);
            }
            C::MeasureHere => {
                let from = self.measure_start();
                self.state.look.measure = Some(from.into_iter().collect());
            }
            C::Plots => self.switch_panel(ctx, DockPanel::Plots),
            C::SetupPanel => self.switch_panel(ctx, DockPanel::Setup),
            C::RotaryAxesPanel => self.switch_panel(ctx, DockPanel::Axes),
            C::TimelinePanel => self.switch_panel(ctx, DockPanel::Timeline),
            C::TablePanel => self.switch_panel(ctx, DockPanel::Table),
            C::DetailsPanel => self.switch_panel(ctx, DockPanel::Details),
            C::SectionalViewPanel => self.switch_panel(ctx, DockPanel::SectionalView),
            C::ResetLayout => look.panels.reset(),
            C::Hub => look.layers.hub ^= true,
            C::Blades => look.layers.blades ^= true,
            C::Shroud => look.layers.shroud ^= true,
            C::Cutters => look.layers.cutters ^= true,
            C::Axes => look.layers.axes ^= true,
            C::Holders => look.layers.holders ^= true,
            C::Links => look.layers.links ^= true,
            C::Stock => look.layers.stock ^= true,
            C::Machine => look.layers.machine ^= true,
            C::MouseVanecut | C::MouseNx | C::MouseSolidworks | C::MouseOnshape | C::MouseBlender => {
                look.mouse = MousePreset::from_command(command).unwrap_or(look.mouse);
                self.store_preferences();
            }
            C::UnitsMetric | C::UnitsInch => {
                look.units = if command == C::UnitsInch { DisplayUnits::Inch } else { DisplayUnits::Metric };
                self.store_preferences();
            }
            C::PassesByLayer | C::PassesByRegion | C::PassesByFeed | C::PassesByWalls => {
                look.flank.shown = true;
                look.flank.colours = match command {
                    C::PassesByLayer => FlankColours::Layer,
                    C::PassesByRegion => FlankColours::Region,
                    C::PassesByFeed => FlankColours::Feed,
                    _ => FlankColours::Walls,
                };
            }
            C::TextLarger => egui::gui_zoom::zoom_in(ctx),
            C::TextSmaller => egui::gui_zoom::zoom_out(ctx),
            C::TextUsual => ctx.set_zoom_factor(1.0),
            C::ShowTour => self.tour.begin(),
            C::ShowShortcuts => self.help.open(HelpPage::Shortcuts),
            C::ShowGlossary => self.help.open(HelpPage::Glossary),
            C::ShowAbout => self.help.open(HelpPage::About),
            C::SwitchTheme => {
                let dark = ctx.theme() == egui::Theme::Dark;
                ctx.set_theme(if dark { egui::Theme::Light } else { egui::Theme::Dark });
            }
        }
        ctx.request_repaint();
    }

    /// Asks where to write the shown plunge plan as a CL file.
    pub(in crate::app) fn ask_for_cl_file(&mut self, ctx: &Context, channels: usize) {
        if self.exported_operation() == Some(Operation::Flank) {
            return self.ask_for_flank_file(ctx, channels);
        }
        let name = self.suggest_plunge_name(channels, ".apt");
        self.dialogs.open_dialog(ctx, Purpose::ExportCl { channels }, name);
    }

    /// The same of the flank plan.
    fn ask_for_flank_file(&mut self, ctx: &Context, channels: usize) {
        let name = self.suggest_flank_name(channels, ".apt");
        self.dialogs.open_dialog(ctx, Purpose::ExportFlank { channels }, name);
    }

    /// Proposed name of a program of the flank plan, which says of how many channels it is.
    pub(in crate::app) fn suggest_flank_name(&self, channels: usize, ending: &str) -> String {
        self.suggest_file_name(&format!("flank{}{ending}", self.words_of_channels(channels)))
    }

    /// What the name of a program says of its number of channels.
    fn words_of_channels(&self, channels: usize) -> String {
        match channels {
            1 => String::new(),
            n if n == self.channel_count() => "-all-channels".to_owned(),
            n => format!("-{n}-channels"),
        }
    }

    /// Proposed name of a program of the shown plunge plan. It says the policy where the side "before" is
    /// shown, and of how many channels the program is.
    pub(in crate::app) fn suggest_plunge_name(&self, channels: usize, ending: &str) -> String {
        let side = self.state.look.side;
        let policy = match self.state.last_whole_plan(side) {
            Some(shown) if side == Side::Before => format!("-{}", shown.policy.name()),
            _ => String::new(),
        };
        let of_channels = self.words_of_channels(channels);
        self.suggest_file_name(&format!("plunge{policy}{of_channels}{ending}"))
    }

    /// Number of channels of the open part; 1 without one.
    pub(in crate::app) fn channel_count(&self) -> usize {
        self.state.document.part.as_ref().map_or(1, |part| part.impeller.blade_count.max(1))
    }

    /// Proposed name of a file saved from the part.
    pub(in crate::app) fn suggest_file_name(&self, ending: &str) -> String {
        match &self.state.document.part {
            Some(part) => format!("{}_{ending}", part.impeller.name),
            None => ending.to_owned(),
        }
    }

    /// Whether a checked program is shown.
    fn is_program(&self) -> bool {
        self.state.look.operation == Operation::Program
    }

    /// Index of the section of the selected position, else 0.
    fn current_section(&self) -> usize {
        self.state.selected().map_or(0, |position| position.section)
    }

    /// Whether the open part comes from CAD or a mesh.
    fn has_mesh_options(&self) -> bool {
        self.state.document.part.as_ref().is_some_and(|part| part.source.mesh().is_some())
    }

    /// Whether `path` is the file of the open part.
    pub(in crate::app) fn is_of_open_part(&self, path: &Path) -> bool {
        let part = self.state.document.part.as_ref();
        part.and_then(|part| part.source.file()).is_some_and(|(own, _)| own == path)
    }
}
