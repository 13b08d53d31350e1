//! Panels "Plunge" and "Allowances": policy, limits, allowances and clearances of the setup.

use egui::{ComboBox, Key, PopupCloseBehavior, RichText, Role, TextEdit, Ui, WidgetInfo};

use crate::part::BlankShape;
use crate::plunge::spacing::{default_step, default_stepover, max_step};
use crate::setup::cutting_data::{CUTTING_DATA, CuttingData};
use crate::setup::{AxisPolicy, Setup};

use super::fields::{self, ChoiceSpec, FieldSpec};
use super::goal::goal_rows;
use crate::app::model::figures::{policy_label, policy_tip};
use crate::app::model::known_goals::KnownGoals;
use crate::app::model::setup_tools;
use crate::app::model::step_note::{lead_out_note, step_note};
use crate::app::views::command::Command;
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;
use crate::report::words::as_sentence;

const POLICY: ChoiceSpec<AxisPolicy> = ChoiceSpec {
    label: "Axis strategy",
    tip: "How the tool axes of the \"after\" plan are chosen",
    all: &[AxisPolicy::Minimal, AxisPolicy::Monotone, AxisPolicy::Staircase, AxisPolicy::Conventional],
    name: policy_label,
    meaning: policy_tip,
};

const STEP: FieldSpec = FieldSpec::mm(
    "Step",
    "Maximum distance of neighbouring axes along a row; auto: 0.8 × each tool's insert width.\n\
     A tool takes at most its insert width, less where its stick-out is beyond 4 diameters (5 below D 13),\n\
     and at most its radius; along walls the wall scallop permits less.\n\
     Smaller: less stock between plunges and less core contact, but more plunges and time",
    0.5,
    100.0,
)
.sliding(1.0, 30.0);
const STEPOVER: FieldSpec = FieldSpec::mm(
    "Stepover",
    "Maximum distance of neighbouring rows; auto: 4/3 of each tool's radius.\n\
     Smaller: lower scallops between rows, but more rows and time",
    0.5,
    200.0,
)
.sliding(1.0, 60.0);
const SCALLOP: FieldSpec = FieldSpec::mm(
    "Wall scallop",
    "Max scallop height between plunges along a wall.\n\
     Smaller: smoother walls for flank milling, but more plunges along them",
    0.01,
    5.0,
)
.sliding(0.05, 2.0);
const TILT: FieldSpec = FieldSpec::degrees(
    "Max tilt",
    "Maximum angle between an axis and the isoparametric one.\n\
     Larger: cores get free of stock at more positions; smaller: less turning of the rotary axes",
    0.0,
    90.0,
)
.sliding(0.0, 60.0);
const MACHINE: FieldSpec = FieldSpec::degrees(
    "Max machine tilt",
    "Maximum angle between tool axis and wheel axis on the machine; used by Min. stock. 180: no limit.\n\
     Smaller: no axis beyond what the machine reaches, but more stock where it would be needed",
    1.0,
    180.0,
)
.sliding(30.0, 180.0);
const CHANGE: FieldSpec = FieldSpec::degrees(
    "Max axis change",
    "Maximum angle between the axes of neighbouring positions.\n\
     Smaller: smoother motion of the rotary axes, but the lead angle follows the hub more slowly",
    0.1,
    90.0,
)
.sliding(0.5, 20.0);
const LEAD_OUT: FieldSpec = FieldSpec::mm(
    "Lead-out",
    "Distance by which the tool moves off the stock beside it at the end of a plunge, at 45°, before it\n\
     retracts: it does not drag along the wall it has cut. At most the radius of the tool",
    0.01,
    20.0,
)
.or_none();
const PECK: FieldSpec = FieldSpec::mm(
    "Peck depth",
    "Depth after which a plunge is interrupted to break the chip.\n\
     Smaller: shorter chips, but more time",
    0.1,
    500.0,
)
.or_none();
const RAPID_APPROACH: (&str, &str) = (
    "to the stock",
    "Plunges come down in rapid as far as earlier plunges have removed the stock, less the rapid clearance,\n\
     and feed from there. Off: they feed from the retract point over the blank, which takes longer",
);
const HUB: FieldSpec = FieldSpec::mm(
    "Hub allowance",
    "Stock that must stay on the hub.\n\
     Larger: safer for finishing, and the plunges end higher",
    0.0,
    20.0,
)
.sliding(0.0, 3.0);
const BLADE: FieldSpec = FieldSpec::mm(
    "Blade allowance",
    "Stock that must stay on the blades.\n\
     Larger: safer for finishing, but less room for the cutter between the blades",
    0.0,
    20.0,
)
.sliding(0.0, 3.0);
const SAFETY: FieldSpec = FieldSpec::mm(
    "Rapid clearance",
    "Distance of the cutter above the blank before a rapid.\n\
     Larger: safer links, but longer retracts. In setup files: safety_distance",
    0.0,
    100.0,
)
.sliding(0.0, 20.0);
const INLET: FieldSpec = FieldSpec::mm(
    "Inlet overhang",
    "Length of blank before the leading edge, along hub and shroud.\n\
     It is cut too: the plunges begin that far in front of the blades. In setup files: inlet_extension",
    0.0,
    200.0,
)
.sliding(0.0, 50.0);

/// What the blank is, as the list of the panel shows it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BlankChoice {
    Edges,
    Turned,
    File,
}

impl BlankChoice {
    fn from_shape(shape: &BlankShape) -> Self {
        match shape {
            BlankShape::Edges => Self::Edges,
            BlankShape::Turned => Self::Turned,
            BlankShape::File(_) => Self::File,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Edges => "To the edges",
            Self::Turned => "Cylinder",
            Self::File => "From file",
        }
    }

    fn tip(self) -> &'static str {
        match self {
            Self::Edges => "Turned between hub and shroud, from the leading edges to the rim",
            Self::Turned => "A cylinder through the trailing edges, with a plane before the leading edges",
            Self::File => "A mesh (.stl), of which plans know the turned envelope, or an outline",
        }
    }
}

const BLANK: ChoiceSpec<BlankChoice> = ChoiceSpec {
    label: "Blank",
    tip: "Shape of the stock before the first cut",
    all: &[BlankChoice::Edges, BlankChoice::Turned, BlankChoice::File],
    name: BlankChoice::label,
    meaning: BlankChoice::tip,
};

/// Rows of the blank, and of its file if it has one; whether a file is to be asked for.
fn blank_rows(ui: &mut Ui, shape: &mut BlankShape, default: &BlankShape) -> bool {
    let mut choice = BlankChoice::from_shape(shape);
    fields::choice_row(ui, &mut choice, BlankChoice::from_shape(default), &BLANK);
    match (choice, &*shape) {
        (BlankChoice::Edges, _) => *shape = BlankShape::Edges,
        (BlankChoice::Turned, _) => *shape = BlankShape::Turned,
        (BlankChoice::File, BlankShape::File(file)) => {
            let title = ui.label("Blank file").on_hover_text(file.path.display().to_string());
            let name =
                file.path.file_name().map_or_else(|| file.name.clone().into(), |n| n.to_string_lossy());
            let button = ui.button(name).labelled_by(title.id).on_hover_text(Command::OpenBlank.tip());
            ui.end_row();
            return button.clicked();
        }
        (BlankChoice::File, _) => return true,
    }
    false
}

const MATERIAL_TIP: &str = "Material of the blank. Tools without speeds and feeds of their own get\n\
     those of the cutting data for it; a material that is not known changes nothing";
const TOO_FAST_TIP: &str = "These speeds were entered, or are those of a shop library: they do not follow the material.\n\
     Enter others at the tools, unless these are meant";
/// Text of the list where the material is not given.
const NO_MATERIAL: &str = "not given";

/// Row of the material: one with cutting data, or the name of another.
fn material_row(ui: &mut Ui, material: &mut Option<String>) {
    let label = ui.label("Material").on_hover_text(MATERIAL_TIP);
    let known = material.as_deref().and_then(CuttingData::of_name);
    ui.horizontal(|ui| {
        let list = ComboBox::from_id_salt("material")
            .width(theme::FIELD_WIDTH)
            .truncate()
            .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
            .selected_text(material.as_deref().unwrap_or(NO_MATERIAL))
            .show_ui(ui, |ui| chosen_material(ui, material.as_deref(), known));
        let tip = match (&*material, known) {
            (Some(_), None) => "No cutting data of this material: speeds stay those of the tools",
            _ => MATERIAL_TIP,
        };
        list.response.labelled_by(label.id).on_hover_text(tip);
        if let Some(chosen) = list.inner.flatten() {
            *material = chosen;
        }
        if material.is_some() && fields::reset_dot(ui, "Material") {
            *material = None;
        }
    });
    ui.end_row();
}

/// The list of materials; returns the one that was chosen or typed.
#[expect(clippy::option_option, reason = "no choice, or the choice of none")]
fn chosen_material(ui: &mut Ui, now: Option<&str>, known: Option<&CuttingData>) -> Option<Option<String>> {
    let mut chosen = None;
    if ui.selectable_label(now.is_none(), NO_MATERIAL).clicked() {
        chosen = Some(None);
    }
    for data in &CUTTING_DATA {
        let is_it = known.is_some_and(|known| known.names[0] == data.names[0]);
        let button = ui.selectable_label(is_it, data.names[0]);
        if button.on_hover_text(data.names.join(", ")).clicked() {
            chosen = Some(Some(data.names[0].to_owned()));
        }
    }
    ui.separator();
    let id = ui.scope_id().with("typed material");
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_default();
    let field = ui.add(TextEdit::singleline(&mut text).hint_text("or a grade").desired_width(120.0));
    field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "Another material"));
    let typed = text.trim();
    if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) && !typed.is_empty() {
        chosen = Some(Some(typed.to_owned()));
        text.clear();
    }
    ui.data_mut(|data| data.insert_temp(id, text));
    if chosen.is_some() {
        ui.close();
    }
    chosen
}

/// Draws the plunge fields; `defaults` are those of the part, `chosen` is the complete setup of the latest
/// plan, `known` are the goals given before.
pub fn plunge(
    ui: &mut Ui,
    setup: &mut Setup,
    known: &mut KnownGoals,
    defaults: &Setup,
    chosen: Option<&Setup>,
) {
    let first = chosen.and_then(|chosen| chosen.tools.first());
    let Setup { plunge: default, machine, .. } = defaults;
    let units = units::display_units(ui);
    // Those of the last plan where the program chooses them.
    let tools =
        if setup.tools.is_empty() { chosen.map_or(&[][..], |chosen| &chosen.tools) } else { &setup.tools };
    fields::form(ui, "plunge fields", |ui| {
        fields::choice_row(ui, &mut setup.plunge.axis, default.axis, &POLICY);
        // The usual goal needs no rows here: it is chosen beside the curve of time against stock.
        if setup.plunge.axis == AxisPolicy::Minimal && setup.plunge.goal != default.goal {
            goal_rows(ui, &mut setup.plunge.goal, known, default.goal, first);
        }
        let step = first.map(|tool| default_step(tool).min(max_step(tool)));
        let stepover = first.map(default_stepover);
        fields::noted_row(ui, &mut setup.plunge.step, &STEP, step, &|mm| step_note(mm, tools, units));
        fields::optional_row(ui, &mut setup.plunge.stepover, &STEPOVER, stepover);
        fields::angle_row(ui, &mut setup.plunge.max_tilt_rad, default.max_tilt_rad, &TILT);
        fields::angle_row(ui, &mut setup.machine.max_axis_tilt_rad, machine.max_axis_tilt_rad, &MACHINE);
        fields::angle_row(ui, &mut setup.plunge.max_axis_change_rad, default.max_axis_change_rad, &CHANGE);
        fields::number_row(ui, &mut setup.plunge.wall_scallop, default.wall_scallop, &SCALLOP);
        let lead_out = &mut setup.plunge.lead_out;
        fields::noted_row(ui, lead_out, &LEAD_OUT, None, &|mm| lead_out_note(mm, tools, units));
        fields::optional_row(ui, &mut setup.plunge.peck, &PECK, None);
        let rapid = &mut setup.plunge.rapid_approach;
        fields::switch_row(ui, rapid, default.rapid_approach, "Rapid approach", RAPID_APPROACH);
    });
}

/// Draws the fields of allowances and clearances; `defaults` are those of the part. Returns the command that
/// was asked for.
pub fn stock(ui: &mut Ui, setup: &mut Setup, defaults: &Setup) -> Option<Command> {
    let default = &defaults.allowances;
    let mut asks_for_file = false;
    fields::form(ui, "stock fields", |ui| {
        fields::number_row(ui, &mut setup.allowances.hub_allowance, default.hub_allowance, &HUB);
        fields::number_row(ui, &mut setup.allowances.blade_allowance, default.blade_allowance, &BLADE);
        fields::number_row(ui, &mut setup.allowances.safety_distance, default.safety_distance, &SAFETY);
        fields::number_row(ui, &mut setup.allowances.inlet_extension, default.inlet_extension, &INLET);
        asks_for_file = blank_rows(ui, &mut setup.allowances.blank, &default.blank);
        let material = setup.allowances.material.clone();
        material_row(ui, &mut setup.allowances.material);
        setup_tools::follow_material(setup, material.as_deref());
    });
    if let Some(note) = setup.allowances.too_fast(&setup.tools) {
        let text = RichText::new(as_sentence(note)).color(Condition::Blocked.text(ui.visuals()));
        ui.add(egui::Label::new(text).wrap()).on_hover_text(TOO_FAST_TIP);
    }
    asks_for_file.then_some(Command::OpenBlank)
}
