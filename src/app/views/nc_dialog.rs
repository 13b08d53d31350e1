//! The question where an NC program is to run: operation, channels, machine, control, output.

use egui::{ComboBox, Grid, Modal, RichText, Ui};

use super::channel_order;
use super::count_field;
use super::modal::is_dismissed;
use super::panels::fields;
use super::theme;
use crate::app::model::look::Operation;
use crate::app::model::post_target::PostTarget;
use crate::io::InputError;
use crate::io::machine_file::built_in_names;
use crate::io::nc::built_in_posts;
use crate::machine::OutputKind;
use crate::setup::ChannelSetup;

/// What the dialog asks about.
#[derive(Clone, Debug)]
pub struct NcQuestion {
    /// Operations with a plan.
    pub operations: Vec<Operation>,
    /// The one whose plan is written.
    pub operation: Operation,
    /// Number of channels that the program mills, from the first on.
    pub channels: usize,
    /// Number of channels of the part.
    pub channel_count: usize,
    /// Where the program is to run.
    pub target: PostTarget,
}

/// Answer of the dialog.
#[derive(Clone, Debug)]
pub enum NcAnswer {
    /// Ask for the file, then write the program.
    Save,
    /// Ask for the file of a post.
    OpenPost,
    /// A machine or control that cannot be read was chosen.
    Unreadable(InputError),
}

/// The dialog.
#[derive(Clone, Debug, Default)]
pub struct NcDialog {
    /// The question, as it is answered so far; kept after the dialog was closed.
    question: Option<NcQuestion>,
    is_open: bool,
}

impl NcDialog {
    /// Asks `question`.
    pub fn open(&mut self, question: NcQuestion) {
        self.question = Some(question);
        self.is_open = true;
    }

    /// Goes on with the last question, with the post of the file `post`.
    ///
    /// # Errors
    /// When the post cannot be read; the dialog is open all the same.
    pub fn take_post(&mut self, post: &str) -> Result<(), InputError> {
        self.is_open = self.question.is_some();
        let Some(question) = &mut self.question else { return Ok(()) };
        question.target = question.target.with_control(post)?;
        Ok(())
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// What was answered last.
    pub fn question(&self) -> Option<&NcQuestion> {
        self.question.as_ref()
    }

    /// Draws it; returns an answer once. `order`: that of several channels in the setup.
    pub fn show(&mut self, ui: &Ui, order: &mut ChannelSetup) -> Option<NcAnswer> {
        let question = self.question.as_mut().filter(|_| self.is_open)?;
        let (mut answer, mut close) = (None, false);
        let modal = Modal::new(egui::Id::unique("nc program")).show(ui.ctx(), |ui| {
            ui.set_width(340.0);
            ui.label(RichText::new("Export NC program").strong());
            ui.add_space(4.0);
            answer = form(ui, question, order);
            ui.add_space(4.0);
            ui.label(RichText::new(UNPROVEN).weak());
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Save as…").clicked() {
                    answer = Some(NcAnswer::Save);
                }
                close = ui.button("Cancel").clicked();
            });
        });
        close |= matches!(answer, Some(NcAnswer::Save | NcAnswer::OpenPost));
        self.is_open &= !(close || is_dismissed(&modal));
        answer
    }
}

/// Draws the fields; returns what they cannot answer themselves.
fn form(ui: &mut Ui, question: &mut NcQuestion, order: &mut ChannelSetup) -> Option<NcAnswer> {
    let mut changed: Option<Result<PostTarget, InputError>> = None;
    let mut opens_post = false;
    Grid::new("nc fields").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Operation");
        let list = ComboBox::from_id_salt("nc operation").selected_text(question.operation.label());
        let list = list.show_ui(ui, |ui| {
            for &operation in &question.operations {
                ui.selectable_value(&mut question.operation, operation, operation.label());
            }
        });
        list.response.labelled_by(label.id);
        ui.end_row();
        let label = ui.label("Channels").on_hover_text("How many are milled, from the first on");
        count_field::channels(ui, &mut question.channels, question.channel_count, label.id);
        ui.end_row();
        channel_order::rows(ui, order);

        let target = &mut question.target;
        let mut machine = target.machine.clone();
        let names = built_in_names().map(str::to_owned);
        fields::name_row(ui, "NC machine", MACHINE_TIP, &mut machine, names, |_| {});
        if machine != target.machine {
            changed = Some(PostTarget::of_machine(&machine));
        }
        let mut control = target.control.clone();
        let names = built_in_posts().map(str::to_owned);
        fields::name_row(ui, "Control", CONTROL_TIP, &mut control, names, |ui| {
            opens_post = ui.button("Post file…").on_hover_text(POST_TIP).clicked();
        });
        if control != target.control {
            changed = Some(target.with_control(&control));
        }
        let label = ui.label("Output").on_hover_text(OUTPUT_TIP);
        let list = ComboBox::from_id_salt("nc output").width(theme::FIELD_WIDTH);
        let list = list.selected_text(words_of(target.output)).show_ui(ui, |ui| {
            for &output in &target.outputs {
                ui.selectable_value(&mut target.output, output, words_of(output));
            }
        });
        list.response.labelled_by(label.id).on_hover_text(OUTPUT_TIP);
        ui.end_row();
        ui.label("");
        let tip = if target.takes_subprograms { SUBPROGRAM_TIP } else { NO_SUBPROGRAM_TIP };
        let choice = egui::Checkbox::new(&mut target.is_subprogram, "Subprogram");
        ui.add_enabled(target.takes_subprograms, choice).on_hover_text(tip).on_disabled_hover_text(tip);
        ui.end_row();
    });
    match changed {
        Some(Ok(target)) => question.target = target,
        Some(Err(error)) => return Some(NcAnswer::Unreadable(error)),
        None => {}
    }
    opens_post.then_some(NcAnswer::OpenPost)
}

const UNPROVEN: &str =
    "No program of this kind has run on a real control yet: read it first, and run it block by block in air";
const MACHINE_TIP: &str = "The machine that runs the program: its axes, limits and conventions.\n\
     The setup's machine, if it names one";
const CONTROL_TIP: &str = "The control, whose words the program is written in";
const POST_TIP: &str = "Takes the words from a post of your own: a copy of one of these, changed (.toml)";
const OUTPUT_TIP: &str = "What the program gives: rotary angles or tool vectors with the tip held by the control,\n\
     a tilted plane for each direction (3+2), or the positions of all axes";

const SUBPROGRAM_TIP: &str = "For a program that calls it, once a channel, with the work offset turned by the pitch: \
     it keeps that offset, and returns at its end";
const NO_SUBPROGRAM_TIP: &str =
    "The post does not say how a subprogram begins and ends: `sub_start`, `sub_end`";

/// What an output gives, in words.
fn words_of(output: OutputKind) -> &'static str {
    match output {
        OutputKind::TcpAngles => "Rotary angles",
        OutputKind::TcpVectors => "Tool vectors",
        OutputKind::Plane => "Tilted planes",
        OutputKind::Joints => "All axes",
    }
}
