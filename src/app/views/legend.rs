//! The legend below the 3D view: what the colours mean, the ends of the scale, and the value under the
//! cursor. It lies beside the picture, so that it hides nothing of it.

use egui::{Rect, RichText, Sense, Ui, UiBuilder, Vec2};

use crate::drawing::flank::RAPID_COLOUR;
use crate::gpu::scene::FloorColours;
use crate::palette::{ColourMap, INTERFERING, Rgb, Theme, category};

use crate::app::model::checked::CheckedProgram;
use crate::app::model::cutter_colours::{ClassShare, CutterClass, CutterColours, CutterLegend};
use crate::app::model::figures::format_class_share;
use crate::app::model::look::{Arrangement, Operation};
use crate::app::model::planned::Side;
use crate::app::model::solid::SolidColours;
use crate::app::model::state::AppState;
use crate::app::tasks::solid::SolidPicture;
use crate::app::views::overlay::floating;
use crate::app::views::panels::flank;
use crate::app::views::scale_ends::{FIELD_MARGIN, MARGIN, fit_width, hub_ends, wall_ends};
use crate::app::views::swatch::{colour_bar, swatch};
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;

/// Height of the legend, points.
pub const HEIGHT: f32 = 26.0;

/// Values under the cursor, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// Stock on the hub, on the side under the cursor.
    pub here: Option<f32>,
    /// Stock on a wall above the blade allowance, where the walls are shown; negative where it is overcut.
    pub deviation: Option<f32>,
    /// Stock on the hub at the same point of the other side, where both are shown.
    pub other: Option<(Side, f32)>,
}

/// What the solid stock shows, at the lower left: volume and collisions of each side in view, while its solid
/// is known, and the names of its colours.
pub fn solid_legend(ui: &mut Ui, rect: Rect, sides: &[(Side, Option<&SolidPicture>)], above: f32) {
    let solids = || sides.iter().filter_map(|(_, solid)| *solid);
    let names = solids().next_back().map_or(&[][..], |solid| &solid.names);
    // The text on collisions takes two lines.
    let lines = sides.len() + 2 * solids().filter(|solid| solid.collisions > 0).count();
    let height = 10.0 + 16.0 * (lines + names.len()) as f32;
    let corner = egui::pos2(rect.min.x + 10.0, rect.max.y - above - height);
    let at = Rect::from_min_size(corner, egui::vec2(236.0, height)).intersect(rect);
    floating(ui, at, |ui| {
        ui.spacing_mut().item_spacing = egui::vec2(4.0, 2.0);
        for (side, solid) in sides {
            let of = if sides.len() > 1 { format!("{}: stock", side.label()) } else { "Stock".to_owned() };
            match solid {
                Some(solid) => solid_lines(ui, &of, solid),
                None => drop(ui.label(RichText::new(format!("{of}: calculating…")).size(12.0))),
            }
        }
        for (colour, name) in names {
            ui.horizontal(|ui| {
                swatch(ui, *colour, 12.0);
                ui.label(RichText::new(name).size(12.0));
            });
        }
    });
}

/// Volume and collisions of a solid; `of`: what it is.
fn solid_lines(ui: &mut Ui, of: &str, solid: &SolidPicture) {
    let refined = if solid.is_coarse { ", refining…" } else { "" };
    let units = units::display_units(ui);
    let text = format!("{of} {}{refined}", units.volume(solid.volume));
    ui.label(RichText::new(text).size(12.0)).on_hover_text(format!(
        "Volume of the whole blank after the moves up to here; rays every {}",
        units.length(solid.spacing, 2)
    ));
    if solid.collisions > 0 {
        let word = if solid.collisions == 1 { "move meets" } else { "moves meet" };
        let colour = Condition::Interfering.text(ui.visuals());
        let text = format!("{} {word} stock with core, shank, holder or in rapid", solid.collisions);
        ui.label(RichText::new(text).size(12.0).color(colour));
    }
}

/// A scale: its heading, colours, and whether it is symmetric about zero with ends that are not edited.
struct Scale {
    head: &'static str,
    map: ColourMap,
    difference: bool,
    walls: Option<f32>,
}

/// The scale of the colours in view; `None` where no colours mean a value.
fn scale(state: &AppState) -> Option<Scale> {
    let of = |head, map, difference, walls| Some(Scale { head, map, difference, walls });
    if state.look.layers.stock {
        let distance = state.look.solid_colours == SolidColours::Distance;
        return distance.then(|| of("Distance to part", ColourMap::Cividis, false, None)).flatten();
    }
    // Walls and difference map are those of whole plans, wherever the timeline stands.
    let is_cut_part = state.timeline_cut().is_some_and(|cut| cut < state.timeline_len());
    if let Some(most) = state.shown_deviation() {
        let head = if is_cut_part { "Finished walls" } else { "Residual on walls" };
        return of(head, ColourMap::Difference, true, Some(most));
    }
    if state.look.operation != Operation::Roughing
        || state.results.planned.is_none()
        || !state.look.layers.hub
    {
        return None;
    }
    match state.look.layers.floor {
        _ if state.look.difference => {
            let head = if is_cut_part { "Finished: after − before" } else { "Stock after − before" };
            of(head, ColourMap::Difference, true, None)
        }
        FloorColours::Residual => of("Residual on hub", ColourMap::Cividis, false, None),
        FloorColours::Interference => of("Core contact", ColourMap::Contact, false, None),
        _ => None,
    }
}

/// Whether the side before shows its stock while the one after shows how much that differs: two scales.
fn shows_both_scales(state: &AppState, scale: &Scale) -> bool {
    scale.difference
        && scale.walls.is_none()
        && state.look.shown_arrangement() != Arrangement::One
        && state.look.layers.floor == FloorColours::Residual
}

/// The scale of the side before, whose ends are those of the side after.
fn show_scale_before(ui: &mut Ui, state: &AppState) {
    let ((low, high), units) = (state.range(), state.look.units);
    ui.label("Residual before");
    ui.label(units.length(low.into(), 2));
    colour_bar(ui, ColourMap::Cividis, 60.0);
    ui.label(units.length(high.into(), 2));
    ui.separator();
}

/// Draws the legend in the strip `rect` below the picture.
pub fn show(ui: &mut Ui, rect: Rect, state: &mut AppState, values: Values) {
    ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
    let inner = rect.shrink2(Vec2::new(8.0, 2.0));
    ui.scope_builder(UiBuilder::new().max_rect(inner), |ui| {
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        ui.horizontal_centered(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            if let Some(checked) = state.results.checked.as_ref().filter(|_| shows_program(state)) {
                program_key(ui, checked);
                return;
            }
            if let Some(shown) = cutter_legend(ui, state) {
                show_cutter_legend(ui, &shown, &mut state.look.hidden_classes);
                // In a narrow view the colours that were asked for have priority over those of the floor.
                if shown.has_text && ui.available_width() < MIN_SCALE_WIDTH {
                    return;
                }
                ui.separator();
            }
            match scale(state) {
                Some(scale) => {
                    if shows_both_scales(state, &scale) && ui.available_width() > TWO_SCALES {
                        show_scale_before(ui, state);
                    }
                    show_scale(ui, state, &scale, values);
                }
                None => {
                    let passes = state.shown_flank().filter(|_| !state.look.layers.stock);
                    if let Some((outcome, colours)) = passes {
                        flank::key(ui, colours, &outcome.plan, outcome.workpiece.part.splitters.len());
                    }
                }
            }
        });
    });
}

/// Whether the moves of a checked program are in view.
fn shows_program(state: &AppState) -> bool {
    state.look.operation == Operation::Program && !state.look.layers.stock
}

/// What the lines of a checked program mean: cuts by tool, rapids, faults.
fn program_key(ui: &mut Ui, checked: &CheckedProgram) {
    let units = units::display_units(ui);
    egui::ScrollArea::horizontal().id_salt("program").show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let mut entry = |colour: Rgb, name: String| {
                swatch(ui, colour, 10.0);
                ui.label(name);
            };
            for (k, tool) in checked.program.tools.iter().enumerate() {
                let is_known = tool.diameter > 0.0;
                let diameter = if is_known { units.diameter(tool.diameter) } else { String::new() };
                entry(category(k), format!("T{} {diameter}", tool.number));
            }
            entry(RAPID_COLOUR, "rapid".to_owned());
            if !checked.findings.is_empty() {
                entry(INTERFERING, "fault".to_owned());
            }
        });
    });
}

/// The legend of the cutters as it is drawn.
struct ShownCutterLegend {
    legend: CutterLegend,
    /// Whether its classes have names and shares beside their colours.
    has_text: bool,
}

/// What the cutters are coloured by; `None` while they are hidden. The states, which table and verdict name
/// too, have no text where that does not fit beside the scale of the floor.
fn cutter_legend(ui: &Ui, state: &AppState) -> Option<ShownCutterLegend> {
    let layers = state.look.layers;
    let in_view = layers.cutters && !layers.stock && state.look.operation == Operation::Roughing;
    let shown = if in_view { state.plans_in_view() } else { Vec::new() };
    let mut legend = layers.cutter_colours.legend(&shown, state.look.units)?;
    let is_optional = layers.cutter_colours == CutterColours::State;
    let fits = |legend: &CutterLegend| width_of(ui, legend) + MIN_SCALE_WIDTH < ui.available_width();
    if !is_optional || fits(&legend) {
        return Some(ShownCutterLegend { legend, has_text: true });
    }
    let bare = legend.clone();
    // Of both plans there are more states, and each has two shares.
    if let CutterLegend::Classes(classes) = &mut legend {
        classes.iter_mut().for_each(|class| class.shares.clear());
    }
    if shown.len() > 1 && fits(&legend) {
        return Some(ShownCutterLegend { legend, has_text: true });
    }
    let CutterLegend::Classes(classes) = &bare else { return None };
    let width = classes.len() as f32 * BARE_CLASS + MIN_BARE_SCALE_WIDTH;
    (width < ui.available_width()).then_some(ShownCutterLegend { legend: bare, has_text: false })
}

/// Width of a legend of classes, points.
fn width_of(ui: &Ui, legend: &CutterLegend) -> f32 {
    let CutterLegend::Classes(classes) = legend else { return 0.0 };
    let width = |share: &ClassShare| theme::width_of_text(ui, &class_text(share));
    classes.iter().map(|share| width(share) + SWATCH_AND_SPACES).sum()
}

/// Width below which the scale of the floor is left out beside that of the cutters, points.
const MIN_SCALE_WIDTH: f32 = 270.0;
/// Least width for the scales of both sides, points.
const TWO_SCALES: f32 = 560.0;
/// The same beside classes without text, points.
const MIN_BARE_SCALE_WIDTH: f32 = 178.0;
/// Width of a class without text, and of its swatch, points.
const BARE_CLASS: f32 = BARE_SWATCH + 5.0;
const BARE_SWATCH: f32 = 12.0;
/// Width of a class beside its text, points.
const SWATCH_AND_SPACES: f32 = 30.0;

/// Name and share of a class; of several plans the shares as "84/97 %".
fn class_text(share: &ClassShare) -> String {
    let shares: Vec<String> = share.shares.iter().map(|&share| format_class_share(share)).collect();
    let (last, before) =
        shares.split_last().map_or(("", &shares[..0]), |(last, before)| (last.as_str(), before));
    let before: String =
        before.iter().map(|share| format!("{}/", share.trim_end_matches('%').trim_end())).collect();
    match share.shares.is_empty() {
        true => share.name.clone(),
        false => format!("{}, {before}{last}", share.name),
    }
}

/// Draws the legend of the cutters; a click on a class hides it, or shows it again.
fn show_cutter_legend(ui: &mut Ui, shown: &ShownCutterLegend, hidden: &mut Vec<CutterClass>) {
    match &shown.legend {
        CutterLegend::Classes(classes) if !shown.has_text => {
            for share in classes {
                class_button(ui, share, false, hidden);
            }
        }
        CutterLegend::Classes(classes) => {
            // Many classes are wider than the view.
            egui::ScrollArea::horizontal().id_salt("classes").show(ui, |ui| {
                ui.horizontal_centered(|ui| {
                    for share in classes {
                        class_button(ui, share, true, hidden);
                    }
                });
            });
        }
        CutterLegend::Scale(low, high) => {
            ui.label(low);
            colour_bar(ui, ColourMap::Viridis, 80.0);
            ui.label(high);
        }
    }
}

fn class_button(ui: &mut Ui, share: &ClassShare, has_text: bool, hidden: &mut Vec<CutterClass>) {
    let ClassShare { class, colour, .. } = share;
    let is_hidden = hidden.contains(class);
    let does = if is_hidden { "show" } else { "hide" };
    let of = if share.shares.len() > 1 { "programs before and after" } else { "program" };
    let tip = format!("Share of the time of the {of}; a click {does}s these cutters");
    let response = if has_text {
        swatch(ui, *colour, 10.0);
        let text = RichText::new(class_text(share));
        let text = if is_hidden { text.strikethrough().weak() } else { text };
        ui.add(egui::Button::new(text).frame(false)).on_hover_text(tip)
    } else {
        let (at, response) = ui.allocate_exact_size(Vec2::splat(BARE_SWATCH), Sense::click());
        let (shape, fill) = (at.shrink(1.0), theme::colour(*colour));
        match is_hidden {
            true => ui.painter().rect_stroke(shape, 2.0, (1.5, fill), egui::StrokeKind::Inside),
            false => ui.painter().rect_filled(shape, 2.0, fill),
        };
        let name = class_text(share);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        response.on_hover_text(format!("{name}\n{tip}"))
    };
    if response.clicked() {
        match is_hidden {
            true => hidden.retain(|known| known != class),
            false => hidden.push(*class),
        }
    }
}

/// Least length of the bar of a scale, points.
const MIN_BAR: f32 = 40.0;
/// Space between two things, points.
const SPACE: f32 = 5.0;

fn show_scale(ui: &mut Ui, state: &mut AppState, scale: &Scale, values: Values) {
    let (width, units) = (ui.available_width(), state.look.units);
    let value = match (scale.walls, values.other) {
        (Some(_), _) => values.deviation.map(|d| format!("{} here", units.deviation(d.into()))),
        (None, Some((side, other))) => values.here.map(|stock| {
            let [number, other] = [units.number(stock.into(), 2), units.length(other.into(), 2)];
            format!("{number}, {} {other}", side.label().to_lowercase())
        }),
        (None, None) => values.here.map(|stock| format!("{} here", units.length(stock.into(), 2))),
    };
    let (low, high) = state.range();
    let ends_of_scale = match scale.walls {
        Some(most) => [-most, most].map(|end| units.deviation(end.into())),
        None => [low, high].map(|end| units.length(end.into(), 2)),
    };
    let has_fit = match scale.walls {
        Some(_) => state.look.wall_end.is_some(),
        None => state.range() != state.fitting_range(),
    };
    let fit = if has_fit { fit_width(ui) } else { 0.0 };
    let text_width = |text: &str| theme::width_of_text(ui, text);
    let taken: f32 = ends_of_scale.iter().map(|end| text_width(end) + FIELD_MARGIN).sum();
    let of_value = value.as_deref().map_or(0.0, |value| text_width(value) + SPACE);
    // In a narrow view the value under the cursor takes the place of the heading.
    let rest = width + MARGIN - fit - taken - of_value - MIN_BAR - 2.0 * SPACE;
    let head = text_width(scale.head) + SPACE;
    let has_head = rest > head;
    if has_head {
        ui.label(scale.head);
    }
    // No longer than what is beside it leaves.
    let most = rest + MIN_BAR - if has_head { head } else { 0.0 };
    let bar = (width - fit - 330.0).min(most).clamp(MIN_BAR, 180.0);
    match scale.walls {
        Some(most) => {
            wall_ends(ui, state, most, bar);
            unmilled(ui, state, of_value);
        }
        None => hub_ends(ui, state, (scale.map, scale.difference), bar),
    }
    if let Some(value) = value {
        ui.label(RichText::new(value).strong());
    }
}

/// What the grey of the walls means, where there is any, and where that fits beside the value under the
/// cursor.
fn unmilled(ui: &mut Ui, state: &AppState, of_value: f32) {
    const TEXT: &str = "not milled";
    let verdict = state.results.flank.as_ref().and_then(|outcome| outcome.verdict.as_ref());
    if verdict.is_none_or(|verdict| verdict.unmilled_wall_share == 0.0) {
        return;
    }
    if ui.available_width() - of_value < theme::width_of_text(ui, TEXT) + SWATCH_AND_SPACES {
        return;
    }
    let of = if ui.visuals().dark_mode { Theme::Dark } else { Theme::Light };
    ui.add_space(SPACE);
    swatch(ui, of.greys().uncut, 10.0);
    ui.label(TEXT).on_hover_text("No cutter of the program comes near");
}
