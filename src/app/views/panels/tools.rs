//! Panel "Tools": tools and, for plunging, their sections, chosen by the program or entered by the user.

use std::collections::HashSet;

use egui::{ComboBox, Grid, Id, RichText, Ui};

use crate::io::tool_file::MAX_NUMBER;
use crate::setup::cutting_data::fill_rates;
use crate::setup::{
    AxisPolicy, CutDirection, MissingRates, SectionKind, SectionSetup, Setup, Tool, ToolAssembly,
};

use super::fields::{self, FieldSpec};
use crate::app::model::field_faults::{FieldScope, SECTION};
use crate::app::model::number::Quantity;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::setup_tools;
use crate::app::model::units::DisplayUnits;
use crate::app::views::command::Command;
use crate::app::views::field_faults;
use crate::app::views::theme::{self, Condition};
use crate::app::views::tool_form;
use crate::app::views::typed::{self, TypedLimits};
use crate::app::views::units;

const S: FieldSpec = FieldSpec {
    label: "s",
    tip: "Fraction of meridional arc length: 0 at the leading edge (LE), 1 at the rim (OD)",
    quantity: Quantity::Plain,
    min: 0.0,
    max: 1.0,
    speed: 0.005,
    decimals: 3,
    slide: None,
    absent: "auto",
    why_most: "",
};

/// Draws the panel; `planned` is the latest plan, and `change` what it changed in the tools. Returns the
/// command that was asked for.
pub fn show(
    ui: &mut Ui,
    setup: &mut Setup,
    planned: Option<(&DisplayPlan, AxisPolicy)>,
    change: Option<&str>,
) -> Option<Command> {
    let asked = library_button(ui);
    content(ui, setup, planned, change);
    asked
}

/// Draws the tools of the setup alone, without what plunging makes of them; `chosen` is the setup of the
/// latest plan. Returns the command that was asked for.
pub fn show_list(ui: &mut Ui, setup: &mut Setup, chosen: Option<&Setup>) -> Option<Command> {
    let asked = library_button(ui);
    match setup.tools.is_empty() {
        true => _ = ui.label(RichText::new(FROM_LIBRARY).weak()),
        false => tools(ui, setup, chosen),
    }
    asked
}

/// Text in place of the tools of a setup without any.
const FROM_LIBRARY: &str = "Chosen from the tool library for the part";

fn library_button(ui: &mut Ui) -> Option<Command> {
    let button = ui.button(Command::ToolLibrary.label()).on_hover_text(Command::ToolLibrary.tip());
    button.clicked().then_some(Command::ToolLibrary)
}

fn content(
    ui: &mut Ui,
    setup: &mut Setup,
    planned: Option<(&DisplayPlan, AxisPolicy)>,
    change: Option<&str>,
) {
    let chosen = planned.map(|(planned, _)| &planned.outcome.setup);
    if setup.tools.is_empty() {
        ui.label(RichText::new(FROM_LIBRARY).weak());
        rest_checkbox(ui, setup);
        let Some((chosen, (planned, policy))) = chosen.zip(planned) else { return };
        if let Some(change) = change {
            let text = RichText::new(change);
            ui.add(egui::Label::new(text.color(Condition::Blocked.text(ui.visuals()))).wrap())
                .on_hover_text("The last edit led to other tools; edit tools and sections to keep them");
        }
        summary(ui, planned, chosen);
        uses(ui, planned, policy);
        let edit = ui.button("Edit tools and sections").on_hover_text("Copies these into the setup");
        if edit.clicked() {
            copy_sections(setup, chosen);
        }
        return;
    }
    tools(ui, setup, chosen);
    sections(ui, setup);
    let is_of_them = |planned: &DisplayPlan| Tool::cut_alike(&planned.outcome.setup.tools, &setup.tools);
    if let Some((planned, policy)) = planned.filter(|(planned, _)| is_of_them(planned)) {
        uses(ui, planned, policy);
    }
    if ui.button("Reset to automatic").on_hover_text("Removes these tools and sections").clicked() {
        setup.tools.clear();
        setup.plunge.sections.clear();
    }
}

/// Why section `k` has its tool, as the planner says it.
fn reason_of(planned: &DisplayPlan, k: usize) -> Option<&str> {
    planned.outcome.reasons.get(k)?.as_deref()
}

fn summary(ui: &mut Ui, planned: &DisplayPlan, setup: &Setup) {
    let units = units::display_units(ui);
    Grid::new("chosen tools").num_columns(4).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
        for head in ["Tool", "Insert", "From s", "To s"] {
            ui.label(RichText::new(head).weak());
        }
        ui.end_row();
        for (k, section) in setup.plunge.sections.iter().enumerate() {
            let Some(tool) = setup.tools.iter().find(|t| t.number == section.tool) else { continue };
            let rest = section.kind.suffix();
            let reason = reason_of(planned, k).unwrap_or_default();
            let insert = format!("Insert width, {}\n{reason}", units.length_unit());
            for (text, tip) in [
                (format!("T{} {}{rest}", tool.number, units.diameter(tool.diameter)), reason),
                (units.size(tool.insert_width), insert.trim_end()),
                (format!("{:.2}", section.from), reason),
                (format!("{:.2}", section.to), reason),
            ] {
                let cell = ui.label(text);
                if !tip.is_empty() {
                    cell.on_hover_text(tip);
                }
            }
            ui.end_row();
        }
    });
}

/// Number of plunges of each section by the strategy that is shown, with the reason where a tool gets none.
fn uses(ui: &mut Ui, planned: &DisplayPlan, policy: AxisPolicy) {
    let plan = planned.plan(policy);
    for (k, section) in plan.sections.iter().enumerate() {
        let tool =
            format!("T{} {}", section.tool.number, units::display_units(ui).diameter(section.tool.diameter));
        // A tool may have several sections.
        let is_only = plan.sections.iter().filter(|of| of.tool.number == section.tool.number).count() == 1;
        let tool = if is_only { tool } else { format!("Section {}, {tool}", k + 1) };
        let text = match plan.idle_words(k) {
            Some(why) => RichText::new(format!("{tool}: no plunges, {why}"))
                .color(Condition::Blocked.text(ui.visuals())),
            None => RichText::new(format!("{tool}: {} plunges", plan.plunges_of(k))),
        };
        let label = ui.add(egui::Label::new(text).wrap());
        if let Some(reason) = reason_of(planned, k) {
            label.on_hover_text(reason);
        }
    }
    let is_idle = |tool: &&Tool| plan.sections.iter().all(|section| section.tool.number != tool.number);
    let idle: Vec<&Tool> = planned.setup.tools.iter().filter(is_idle).collect();
    // Ball ends are for flank milling.
    let round: Vec<&Tool> = idle.iter().copied().filter(|tool| !tool.is_flat() && !tool.is_ball()).collect();
    idle_line(ui, &round, ("a corner radius of a quarter of the diameter or more", ROUND_TIP));
    let flat: Vec<&Tool> = idle.into_iter().filter(|tool| tool.is_flat()).collect();
    let reason = match planned.setup.plunge.sections.is_empty() {
        true => (
            "not chosen for a section",
            "Sections get the tools that cut the channel in the least time. Cutters that are too thick or too \
             short and tapered cutters are not chosen.",
        ),
        false => ("not named in any section", "Name the tool in a section, or remove it from the setup"),
    };
    idle_line(ui, &flat, reason);
}

/// That `tools` have no plunges, and why, with a tooltip; nothing without tools.
fn idle_line(ui: &mut Ui, tools: &[&Tool], (why, tip): (&str, &str)) {
    if tools.is_empty() {
        return;
    }
    let (named, others) = tools.split_at(tools.len().min(MAX_IDLE));
    let units = units::display_units(ui);
    let names: Vec<String> =
        named.iter().map(|tool| format!("T{} {}", tool.number, units.diameter(tool.diameter))).collect();
    let more = match others.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let text = format!("{}{more}: no plunges, {why}", names.join(", "));
    ui.add(egui::Label::new(RichText::new(text).color(Condition::Blocked.text(ui.visuals()))).wrap())
        .on_hover_text(tip);
}

const ROUND_TIP: &str =
    "Plunges are planned for mills whose bottom is flat but for small corners, where there are such";
/// Number of tools without plunges that are named.
const MAX_IDLE: usize = 8;
/// Number of tools that are all listed; of a library in a setup only those that are used.
const MAX_LISTED: usize = 100;

/// The tools of a setup, `chosen` being the one that its plan was made with.
fn tools(ui: &mut Ui, setup: &mut Setup, chosen: Option<&Setup>) {
    let mut remove = None;
    let mut renumbered = None;
    let last_one = setup.tools.len() == 1;
    let used: Option<HashSet<u32>> =
        (setup.tools.len() > MAX_LISTED).then(|| used_numbers(setup, chosen.unwrap_or(setup)));
    let numbers: Vec<u32> = setup.tools.iter().map(|tool| tool.number).collect();
    let material = setup.allowances.cutting_data();
    let is_listed = |tool: &Tool| used.as_ref().is_none_or(|used| used.contains(&tool.number));
    for (k, tool) in setup.tools.iter_mut().enumerate().filter(|(_, tool)| is_listed(tool)) {
        let units = units::display_units(ui);
        let insert = format!("{} {}", units.size(tool.insert_width), units.length_unit());
        let name = format!("T{}  {}, insert {insert}", tool.number, units.diameter(tool.diameter));
        let is_faulty = field_faults::is_any(ui, FieldScope::Tool(k));
        let heading = egui::CollapsingHeader::new(name).id_salt(("tool", k));
        // A fault is not hidden under a closed heading.
        heading.open(is_faulty.then_some(true)).show_unindented(ui, |ui| {
            number_row(ui, tool.number, &numbers, &mut renumbered);
            let before = tool.clone();
            field_faults::within(ui, FieldScope::Tool(k), |ui| tool_form::show(ui, tool, material));
            setup_tools::follow_diameter(tool, &before, material);
            let delete = ui.add_enabled(!last_one, egui::Button::new("Remove tool"));
            if delete.clicked() {
                remove = Some(k);
            }
        });
    }
    if let Some((was, is)) = renumbered {
        setup_tools::renumber(setup, was, is);
    }
    if let Some(k) = remove {
        let gone = setup.tools.remove(k);
        remove_sections(setup, |_, section| section.tool == gone.number);
    }
    if let Some(used) = &used {
        let more = setup.tools.iter().filter(|tool| !is_listed(tool)).count();
        ui.label(RichText::new(format!("and {more} more, to choose from")).weak());
        let button = egui::Button::new("Keep only these");
        let button = ui.add_enabled(!used.is_empty(), button);
        if button.on_hover_text("Removes the tools that no section uses").clicked() {
            setup.tools.retain(|tool| used.contains(&tool.number));
        }
    }
    if ui.button("Add tool").clicked() {
        let number = setup.tools.iter().map(|tool| tool.number).max().unwrap_or(0).saturating_add(1);
        let like = setup.tools.last();
        let missing_rates = like.map_or(MissingRates::ALL, |t| t.assembly.missing_rates);
        let mut tool = Tool {
            number,
            diameter: like.map_or(16.0, |t| t.diameter),
            corner_radius: like.map_or(0.0, |t| t.corner_radius),
            insert_width: like.map_or(5.0, |t| t.insert_width),
            overhang: like.map_or(120.0, |t| t.overhang),
            plunge_feed: like.map_or(300.0, |t| t.plunge_feed),
            spindle: like.map_or(1200.0, |t| t.spindle),
            assembly: ToolAssembly { missing_rates, ..ToolAssembly::default() },
        };
        fill_rates(&mut tool, material);
        setup.tools.push(tool);
    }
}

const NUMBER: FieldSpec = FieldSpec {
    label: "Number",
    tip: "Number of the tool in programs: its place in the machine",
    quantity: Quantity::Count,
    min: 1.0,
    max: MAX_NUMBER as f64,
    speed: 1.0,
    decimals: 0,
    ..S
};

/// Row of the number of a tool: one that another of `numbers` has is refused.
fn number_row(ui: &mut Ui, number: u32, numbers: &[u32], renumbered: &mut Option<(u32, u32)>) {
    fields::form(ui, "tool number", |ui| {
        let form = ui.scope_id();
        let mut value = f64::from(number);
        if !fields::plain_row(ui, &mut value, &NUMBER) {
            return;
        }
        let asked = value as u32;
        if numbers.contains(&asked) && asked != number {
            let text = format!("T{asked} is another tool of the setup");
            typed::say(ui, form, NUMBER.label, f64::from(number), text);
        } else {
            *renumbered = Some((number, asked));
        }
    });
}

/// Numbers of the tools that the sections of a setup or of its plan use, and flank passes.
fn used_numbers(setup: &Setup, chosen: &Setup) -> HashSet<u32> {
    let sections = [setup, chosen].into_iter().flat_map(|setup| &setup.plunge.sections);
    sections.map(|section| section.tool).chain(setup.flank.tool).collect()
}

/// What sets the greatest end of a section.
const BEFORE_START: &str = ", before the start. For more, move the start first";

/// Keeps the ends of a section in order, as a setup file must have them.
fn fit_ends(section: &mut SectionSetup) {
    section.from = section.from.max(MIN_SECTION_LENGTH);
    section.to = section.to.min(section.from - MIN_SECTION_LENGTH).max(0.0);
}

fn sections(ui: &mut Ui, setup: &mut Setup) {
    ui.add_space(4.0);
    ui.label(RichText::new("Sections, outlet to inlet").strong());
    if setup.plunge.sections.is_empty() {
        ui.label(RichText::new("Chosen from the tools").weak());
        rest_checkbox(ui, setup);
    }
    let numbers: Vec<u32> = setup.tools.iter().map(|tool| tool.number).collect();
    let mut remove = None;
    for (k, section) in setup.plunge.sections.iter_mut().enumerate() {
        ui.push_id(("section", k), |ui| {
            let form = ui.scope_id();
            let title = ui.label(format!("Section {}", k + 1));
            let before = section.clone();
            let line = ui.horizontal(|ui| {
                ComboBox::from_id_salt("tool")
                    .width(46.0)
                    .selected_text(format!("T{}", section.tool))
                    .show_ui(ui, |ui| {
                        for number in &numbers {
                            ui.selectable_value(&mut section.tool, *number, format!("T{number}"));
                        }
                    })
                    .response
                    .labelled_by(title.id);
                let from = (MIN_SECTION_LENGTH, 1.0, "");
                s_box(ui, form, &mut section.from, from).labelled_by(title.id);
                ui.label("to");
                let most = (section.from - MIN_SECTION_LENGTH).max(0.0);
                s_box(ui, form, &mut section.to, (0.0, most, BEFORE_START)).labelled_by(title.id);
                let to = section.to;
                fit_ends(section);
                if section.to != to {
                    let text = format!("its end was {to:.3}: {:.3} with the start", section.to);
                    typed::say(ui, form, S.label, 0.0, text);
                }
            });
            typed::show(ui, form, S.label, 0.0, line.response.rect);
            field_faults::within(ui, FieldScope::Section(k), |ui| {
                field_faults::show(ui, SECTION, line.response.rect, *section != before);
            });
            ui.horizontal(|ui| {
                ComboBox::from_id_salt("feed")
                    .width(120.0)
                    .selected_text(direction_label(section.cut_direction))
                    .show_ui(ui, |ui| {
                        for feed in
                            [None, Some(CutDirection::OutletToInlet), Some(CutDirection::InletToOutlet)]
                        {
                            ui.selectable_value(&mut section.cut_direction, feed, direction_label(feed));
                        }
                    })
                    .response
                    .labelled_by(title.id);
                if ui.button("Remove").clicked() {
                    remove = Some(k);
                }
            });
            if k > 0 && section.kind != SectionKind::Opening {
                let mut rest = section.kind == SectionKind::Rest;
                ui.checkbox(&mut rest, format!("Section {}: rest milling only", k + 1)).on_hover_text(
                    "Single plunges where earlier sections left a thick layer; for Min. stock only",
                );
                section.kind = if rest { SectionKind::Rest } else { SectionKind::Rows };
            }
        });
    }
    borders(ui, &mut setup.plunge.sections);
    if let Some(k) = remove {
        remove_sections(setup, |index, _| index == k);
    }
    if ui.button("Add section").clicked() {
        let from = setup.plunge.sections.last().map_or(1.0, |section| section.to);
        let tool = numbers.last().copied().unwrap_or(1);
        setup.plunge.sections.push(SectionSetup {
            tool,
            from,
            to: (from - 0.3).max(0.0),
            cut_direction: None,
            kind: SectionKind::Rows,
        });
    }
}

/// Removes the sections that are `gone`. The first section in the channel cannot be rest milling, as nothing
/// is cut before it.
fn remove_sections(setup: &mut Setup, gone: impl Fn(usize, &SectionSetup) -> bool) {
    let sections = std::mem::take(&mut setup.plunge.sections);
    let kept = sections.into_iter().enumerate().filter(|(index, section)| !gone(*index, section));
    setup.plunge.sections = kept.map(|(_, section)| section).collect();
    if let Some(first) = setup.plunge.sections.iter_mut().find(|s| s.kind != SectionKind::Opening) {
        first.kind = SectionKind::Rows;
    }
}

/// Checkbox: whether smaller tools are chosen for rest milling.
fn rest_checkbox(ui: &mut Ui, setup: &mut Setup) {
    ui.checkbox(&mut setup.plunge.rest, "Rest milling with smaller tools").on_hover_text(
        "Smaller tools remove the thick layer left beside overhanging walls; for Min. stock only",
    );
}

/// Copies the tools and sections that the program chose into the setup.
pub fn copy_sections(setup: &mut Setup, chosen: &Setup) {
    setup.tools.clone_from(&chosen.tools);
    setup.plunge.sections.clone_from(&chosen.plunge.sections);
}

/// Index of the section that begins where section `k` ends. Sections of rest milling lie over the others:
/// their borders are their own.
pub fn adjoining(sections: &[SectionSetup], k: usize) -> Option<usize> {
    let section = sections.get(k)?;
    let next = sections.iter().skip(k + 1).position(|next| next.kind == section.kind)? + k + 1;
    (sections[next].from == section.to).then_some(next)
}

/// Allowed range of the end of section `k`, in s.
pub fn border_range(sections: &[SectionSetup], k: usize) -> std::ops::RangeInclusive<f64> {
    let low = adjoining(sections, k).map_or(0.0, |next| sections[next].to + MIN_SECTION_LENGTH);
    low..=(sections[k].from - MIN_SECTION_LENGTH).max(low)
}

/// Moves the end of section `k` to `to`, with the start of an adjoining next section.
pub fn move_border(sections: &mut [SectionSetup], k: usize, to: f64) {
    let next = adjoining(sections, k);
    sections[k].to = to;
    if let Some(next) = next {
        sections[next].from = to;
    }
}

/// Sliders for the borders; adjoining sections move together.
fn borders(ui: &mut Ui, sections: &mut [SectionSetup]) {
    fields::form(ui, "borders", |ui| {
        for k in 0..sections.len() {
            let label = ui.label(match adjoining(sections, k) {
                Some(next) => format!("Border {} | {}", k + 1, next + 1),
                None => format!("End of section {}", k + 1),
            });
            ui.spacing_mut().slider_width = theme::FIELD_WIDTH;
            let (response, moved) = fields::slider(ui, sections[k].to, border_range(sections, k), 0.005);
            response.labelled_by(label.id);
            if let Some(to) = moved {
                move_border(sections, k, to);
            }
            ui.end_row();
        }
    });
}

/// Minimum length of a section at its border slider, in s.
const MIN_SECTION_LENGTH: f64 = 0.02;

/// An end of a section. `limits`: the least and greatest value, and what sets the greatest.
fn s_box(ui: &mut Ui, form: Id, value: &mut f64, limits: (f64, f64, &str)) -> egui::Response {
    ui.spacing_mut().interact_size.x = 44.0;
    let (least, most, why_most) = limits;
    let show = |s: f64| DisplayUnits::Metric.short(s, S.decimals);
    let (quantity, units) = (Quantity::Plain, DisplayUnits::Metric);
    let limits = TypedLimits { quantity, units, range: least..=most, why_least: "", why_most, show: &show };
    let (field, said) = typed::limited_field(ui, value, &limits, S.speed);
    // Both ends share a line below them.
    typed::keep(ui, form, S.label, 0.0, said);
    field.on_hover_text(S.tip)
}

fn direction_label(feed: Option<CutDirection>) -> &'static str {
    match feed {
        None => "Direction: auto",
        Some(CutDirection::OutletToInlet) => "Outlet to inlet",
        Some(CutDirection::InletToOutlet) => "Inlet to outlet",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::setup_file::{read_setup_bytes, write_setup};

    #[test]
    fn what_the_form_allows_can_be_saved_and_opened() {
        let mut setup = read_setup_bytes(
            "s.toml",
            b"[[tool]]\nnumber = 1\ndiameter = 30\ninsert_width = 10\ncorner_radius = 9\noverhang = 90\n\
              [[plunge.section]]\ntool = 1\nfrom = 0.8\nto = 0.5\n",
        )
        .expect("a setup");
        for (diameter, from, to) in [(11.0, 0.4, 0.5), (0.5, 0.0, 0.0), (200.0, 1.0, 1.0), (4.0, 0.01, 0.9)] {
            setup.tools[0].diameter = diameter;
            (setup.plunge.sections[0].from, setup.plunge.sections[0].to) = (from, to);
            tool_form::fit(&mut setup.tools[0]);
            fit_ends(&mut setup.plunge.sections[0]);
            let tool = &setup.tools[0];
            assert!(tool.insert_width <= tool.radius() && tool.corner_radius <= tool.radius(), "{tool:?}");
            let read = read_setup_bytes("s.toml", write_setup(&setup).as_bytes()).expect("opens");
            assert_eq!(
                (read.tools, read.plunge.sections),
                (setup.tools.clone(), setup.plunge.sections.clone())
            );
        }
    }
}
