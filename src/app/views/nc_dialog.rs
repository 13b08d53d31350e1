//! The question where an NC program is to run: operation, channels, machine, control, output.

use std::path::Path;

use egui::{Align2, ComboBox, Grid, Label, Modal, RichText, Ui};

use super::channel_order;
use super::count_field;
use super::modal::{self, is_confirmed, is_dismissed};
use super::panels::fields;
use super::theme::{self, Condition};
use crate::app::model::look::Operation;
use crate::app::model::machine_list::MachineList;
use crate::app::model::post_target::PostTarget;
use crate::app::model::problem::{Problem, without_markdown};
use crate::io::nc::built_in_posts;
use crate::io::part_hash::PartHash;
use crate::machine::{ChannelCalls, OutputKind};
use crate::setup::{ChannelSequence, ChannelSetup};

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
    /// Machines to choose from.
    pub machines: MachineList,
    /// Whether nobody has chosen the machine: the setup names none.
    pub is_example: bool,
    /// The part that it was asked for.
    pub part: PartHash,
}

impl NcQuestion {
    /// How often another program calls the program, with channels in this sequence; `None`: not at all.
    fn calls(&self, sequence: ChannelSequence) -> Option<ChannelCalls> {
        let calls = || ChannelCalls::for_channels(self.channels, self.channel_count, sequence);
        self.target.is_subprogram.then(calls)
    }
}

/// Answer of the dialog.
#[derive(Clone, Debug)]
pub enum NcAnswer {
    /// Ask for the file, then write the program.
    Save,
    /// Ask for the file of a post.
    OpenPost,
}

/// The dialog.
#[derive(Clone, Debug, Default)]
pub struct NcDialog {
    /// The question, as it is answered so far; kept after the dialog was closed.
    question: Option<NcQuestion>,
    is_open: bool,
    /// What speaks against the last choice of machine or control.
    remark: Option<ChoiceRemark>,
}

/// A choice in the dialog.
#[derive(Clone, Debug)]
pub enum TargetChoice {
    /// The machine of this name or file.
    Machine(String),
    /// The control of this name, or the post of this file.
    Control(String),
}

/// What the dialog says of the last choice of machine or control.
#[derive(Clone, Debug)]
enum ChoiceRemark {
    /// It was not taken, as its file cannot be read.
    Unreadable(Problem),
    /// It does not take something that was chosen before.
    Dropped(String),
}

impl NcDialog {
    /// Asks `question`.
    pub fn open(&mut self, question: NcQuestion) {
        self.question = Some(question);
        self.is_open = true;
        self.remark = None;
    }

    /// Goes on with the last question, with the post of the file `post` unless that cannot be read.
    pub fn take_post(&mut self, post: &str) {
        self.is_open = self.question.is_some();
        self.take(TargetChoice::Control(post.to_owned()));
    }

    /// Takes a machine or control, and says what that changes beside. One that cannot be read is not taken;
    /// where that is the post that was chosen for the machine before, the machine's own takes its place.
    pub fn take(&mut self, choice: TargetChoice) {
        let Some(question) = &mut self.question else { return };
        question.is_example &= !matches!(choice, TargetChoice::Machine(_));
        let (chosen, own) = match &choice {
            TargetChoice::Machine(name) => {
                (question.target.with_machine(name), PostTarget::of_machine(name).ok())
            }
            TargetChoice::Control(name) => (question.target.with_control(name), None),
        };
        let before = question.target.clone();
        self.remark = match chosen {
            Ok(target) => {
                question.target = target;
                dropped(&before, &question.target).map(ChoiceRemark::Dropped)
            }
            Err(error) => {
                question.target = own.unwrap_or(before);
                Some(ChoiceRemark::Unreadable(Problem::from(&error)))
            }
        };
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
        let remark = self.remark.as_ref();
        let (mut answer, mut changed, mut close) = (None, None, false);
        let save = is_confirmed(ui.ctx());
        let content = |ui: &mut Ui| {
            ui.label(RichText::new("Export NC program").strong());
            ui.add_space(4.0);
            (answer, changed) = form(ui, question, order);
            if question.is_example {
                let text = format!("{}{EXAMPLE}", question.target.machine);
                let text = RichText::new(text).color(Condition::Blocked.text(ui.visuals()));
                ui.add(Label::new(text).wrap());
            }
            show_remark(ui, remark);
            ui.add_space(4.0);
            ui.add(Label::new(&question.target.retract).wrap());
            ui.label(RichText::new(UNPROVEN).weak());
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Save as…").clicked() || save {
                    answer = Some(NcAnswer::Save);
                }
                close = ui.button("Cancel").clicked();
            });
        };
        let id = egui::Id::unique("nc program");
        // Its upper edge stays where it is when its text gets longer: a click is to meet what was aimed at.
        let area = Modal::default_area(id).anchor(Align2::CENTER_TOP, [0.0, modal::TOP]);
        let modal = Modal::new(id).area(area).show(ui.ctx(), |ui| modal::fitting(ui, 340.0, content));
        if let Some(chosen) = changed {
            self.take(chosen);
        }
        close |= answer.is_some();
        self.is_open &= !(close || is_dismissed(&modal));
        answer
    }
}

/// What `next` has no more of what was chosen in `before`.
fn dropped(before: &PostTarget, next: &PostTarget) -> Option<String> {
    let control = Path::new(&next.control).file_name().unwrap_or_default().to_string_lossy();
    let output = (!next.outputs.contains(&before.output)).then(|| {
        let (from, to) = (words_of(before.output), words_of(next.output));
        format!("{control} does not take {from}: the output is {to}")
    });
    let subprogram = (before.is_subprogram && !next.is_subprogram).then(|| {
        format!("{control} does not say how a subprogram begins and ends: the program is a main program")
    });
    let lines: Vec<String> = output.into_iter().chain(subprogram).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

fn show_remark(ui: &mut Ui, remark: Option<&ChoiceRemark>) {
    let coloured = |text: &str, of: Condition, ui: &Ui| RichText::new(text).color(of.text(ui.visuals()));
    match remark {
        Some(ChoiceRemark::Unreadable(problem)) => {
            let text = coloured(&without_markdown(&problem.message), Condition::Interfering, ui);
            ui.add(Label::new(text).wrap());
            if !problem.help.is_empty() {
                ui.add(Label::new(format!("Fix: {}", without_markdown(&problem.help))).wrap());
            }
        }
        Some(ChoiceRemark::Dropped(text)) => {
            let text = coloured(text, Condition::Blocked, ui);
            ui.add(Label::new(text).wrap());
        }
        None => {}
    }
}

/// Draws the fields; returns an answer, and the machine or control that was chosen.
fn form(
    ui: &mut Ui,
    question: &mut NcQuestion,
    order: &mut ChannelSetup,
) -> (Option<NcAnswer>, Option<TargetChoice>) {
    let mut changed: Option<TargetChoice> = None;
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
        fields::machine_row(ui, ("NC machine", MACHINE_TIP), &mut machine, &question.machines);
        if machine != target.machine {
            changed = Some(TargetChoice::Machine(machine));
        }
        let mut control = target.control.clone();
        fields::control_row(ui, ("Control", CONTROL_TIP), &mut control, built_in_posts(), |ui| {
            opens_post = ui.button("Post file…").on_hover_text(POST_TIP).clicked();
        });
        if control != target.control {
            changed = Some(TargetChoice::Control(control));
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
    if let Some(words) = question.calls(order.sequence).and_then(ChannelCalls::words) {
        ui.add(Label::new(format!("Subprogram {words}")).wrap());
    }
    (opens_post.then_some(NcAnswer::OpenPost), changed)
}

/// Behind the name of a machine that nobody has chosen.
const EXAMPLE: &str = " is an example, as the setup names no machine: choose the one that runs the program";
const UNPROVEN: &str =
    "No program of this kind has run on a real control yet: read it first, and run it block by block in air";
const MACHINE_TIP: &str = "The machine that runs the program: its axes, limits and conventions.\n\
     The setup's machine, if it names one";
const CONTROL_TIP: &str = "The control, whose words the program is written in";
const POST_TIP: &str = "Takes the words from a post of your own: a copy of one of these, changed (.toml)";
const OUTPUT_TIP: &str = "What the program gives: rotary angles or tool vectors with the tip held by the control,\n\
     a tilted plane for each direction (3+2), or the positions of all axes";

const SUBPROGRAM_TIP: &str = "For a program that calls it: it keeps the work offset of that program, and returns at its end.\n\
     One of a single channel is called once for each, the work offset turned from channel to channel;\n\
     one of several channels is called once";
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
