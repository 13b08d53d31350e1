//! Form of flank milling: tool, strategy, layer depth, scallop height and feed rates; display and colour key
//! of the passes.

use std::collections::BTreeSet;

use egui::{RichText, Ui};

use crate::drawing::flank::{FlankColours, RAPID_COLOUR, feed_range, region_colour};
use crate::flank::choice::selectable;
use crate::flank::region::{Region, WallName};
use crate::flank::{FlankPlan, MoveKind};
use crate::io::tool_library::flank_cutters;
use crate::job::flank::FlankOutcome;
use crate::palette::{ColourMap, Rgb, TABLE_LEN};
use crate::part::splitter_name;
use crate::setup::{FlankStrategy, Setup, Tool};

use super::fields::{self, ChoiceSpec, FieldSpec, ListEntry};
use crate::app::model::field_faults::FieldScope;
use crate::app::model::look::FlankLook;
use crate::app::model::number::Quantity;
use crate::app::views::command::Command;
use crate::app::views::field_faults;
use crate::app::views::swatch::swatch;
use crate::app::views::theme;
use crate::app::views::units;

const DEPTH: FieldSpec = FieldSpec::mm(
    "Layer depth",
    "Axial depth (ap) of a layer, from the hub up.\n\
     Smaller: less load on the cutter, but more layers and time",
    0.1,
    100.0,
)
.sliding(0.5, 10.0);
const ERROR: FieldSpec = FieldSpec::mm(
    "Scallop height",
    "Maximum scallop height between passes.\n\
     Smaller: a smoother floor, but narrower and more passes",
    0.001,
    10.0,
)
.sliding(0.02, 1.0);
const EXTENSION: FieldSpec =
    FieldSpec::mm("Lead-in/out", "Length of passes beyond the leading and trailing edge", 0.0, 200.0);

/// Feed rates by engagement.
const FEED: FieldSpec = feed("Feed rate", "Feed rate of passes beside a pass that is already cut");
const SLOT_FEED: FieldSpec = feed("Slot feed", "Feed rate of passes with stock on both sides");
const WALL_FEED: FieldSpec = feed("Wall feed", "Feed rate of the passes that finish the walls");
const RAMP_FEED: FieldSpec = feed("Ramp feed", "Feed rate of ramps down into stock");
const APPROACH_FEED: FieldSpec =
    feed("Approach feed", "Feed rate down to the stock at the start of a pass, where the cutter meets none");

const fn feed(label: &'static str, tip: &'static str) -> FieldSpec {
    FieldSpec { tip, ..FieldSpec::whole(label, Quantity::FeedRate, 20_000.0) }
}

/// Label of a strategy.
pub fn strategy_label(strategy: FlankStrategy) -> &'static str {
    match strategy {
        FlankStrategy::Isoparametric => "Isoparametric",
        FlankStrategy::Layers => "Layers",
        FlankStrategy::Regions => "Regions",
        FlankStrategy::Balanced => "Balanced",
    }
}

fn strategy_tip(strategy: FlankStrategy) -> &'static str {
    match strategy {
        FlankStrategy::Isoparametric => "Layers and passes through the whole channel: the baseline",
        FlankStrategy::Layers => "Layers of constant depth, isoparametric passes region by region",
        FlankStrategy::Regions => "Offsets of both walls that meet in the middle, as published",
        FlankStrategy::Balanced => "The fewest offsets that keep every gap within the stepover",
    }
}

const SCHEME: ChoiceSpec<FlankStrategy> = ChoiceSpec {
    label: "Strategy",
    tip: "Layout of the passes in a layer",
    all: &FlankStrategy::ALL,
    name: strategy_label,
    meaning: strategy_tip,
};

/// Colourings of the plan, with label and tooltip.
const COLOURS: [(FlankColours, &str, &str); 4] = [
    (FlankColours::Layer, "layer", "The passes, coloured by layer"),
    (FlankColours::Region, "region", "The passes, coloured by region of the channel"),
    (FlankColours::Feed, "feed", "The moves, coloured by feed rate: dark slow, light fast"),
    (FlankColours::Walls, "walls", "Residual stock on the walls, and overcut below the blade allowance"),
];

/// The tool: the one that fits best, with the one that was `taken`, or one of those there are.
fn tool_row(ui: &mut Ui, setup: &mut Setup, taken: Option<&Tool>) {
    let tip = "Cutter for all passes.\nAutomatic: the largest ball-end cutter that leaves room for several passes between the blades. If none in the setup fits, one is taken from the tool library";
    let units = units::display_units(ui);
    let entry = |tool: &Tool| {
        let source = if setup.tools.contains(tool) { "" } else { "From the tool library. " };
        ListEntry {
            value: Some(tool.number),
            name: format!("T{} {}", tool.number, units.diameter(tool.diameter)).into(),
            meaning: format!("{source}Stick-out {}", units.length(tool.overhang, 1)).into(),
        }
    };
    let automatic =
        ListEntry { value: None, name: "Automatic".into(), meaning: "The one that fits best".into() };
    let mut entries = vec![automatic];
    entries.extend(selectable(setup, flank_cutters()).map(entry));
    if let Some(number) = setup.flank.tool.filter(|_| entries.iter().all(|e| e.value != setup.flank.tool)) {
        let (name, meaning) = (
            format!("T{number}, missing"),
            "Neither the setup nor the tool library has a tool of this number",
        );
        entries.push(ListEntry { value: Some(number), name: name.into(), meaning: meaning.into() });
    }
    fields::list_row(ui, &mut setup.flank.tool, None, ("Tool", tip), &entries);
    if let Some(tool) = taken.filter(|_| setup.flank.tool.is_none()) {
        ui.label("");
        let text = format!("T{} {}", tool.number, units.diameter(tool.diameter));
        ui.label(RichText::new(text).weak()).on_hover_text("The cutter of the plan, chosen automatically");
        ui.end_row();
    }
}

/// Draws the fields of the setup. `planned` is the latest flank plan.
pub fn show(ui: &mut Ui, setup: &mut Setup, defaults: &Setup, planned: Option<&FlankOutcome>) {
    let default = &defaults.flank;
    let form = |ui: &mut Ui| {
        tool_row(ui, setup, planned.filter(|p| p.plan.reason.is_some()).map(|p| &p.plan.tool));
        fields::choice_row(ui, &mut setup.flank.strategy, default.strategy, &SCHEME);
        fields::number_row(ui, &mut setup.flank.layer_depth, default.layer_depth, &DEPTH);
        fields::number_row(ui, &mut setup.flank.scallop_height, default.scallop_height, &ERROR);
        let now = planned.map(|p| p.setup.flank.lead_in_out_for(&p.plan.tool));
        fields::optional_row(ui, &mut setup.flank.lead_in_out, &EXTENSION, now);
        let feeds = planned.map(|p| p.plan.feeds);
        fields::optional_row(ui, &mut setup.flank.feed_mm_per_min, &FEED, feeds.map(|f| f.step_mm_per_min));
        fields::optional_row(
            ui,
            &mut setup.flank.slot_feed_mm_per_min,
            &SLOT_FEED,
            feeds.map(|f| f.slot_mm_per_min),
        );
        fields::optional_row(
            ui,
            &mut setup.flank.wall_feed_mm_per_min,
            &WALL_FEED,
            feeds.map(|f| f.wall_mm_per_min),
        );
        fields::optional_row(
            ui,
            &mut setup.flank.ramp_feed_mm_per_min,
            &RAMP_FEED,
            feeds.map(|f| f.ramp_mm_per_min),
        );
        fields::optional_row(
            ui,
            &mut setup.flank.approach_feed_mm_per_min,
            &APPROACH_FEED,
            feeds.map(|f| f.approach_mm_per_min),
        );
    };
    field_faults::within(ui, FieldScope::Flank, |ui| fields::form(ui, "flank fields", form));
    if let Some(outcome) = planned.filter(|p| p.plan.reason.is_some() && p.has_library_cutter()) {
        let tool = &outcome.plan.tool;
        let text = format!(
            "Cutter T{} {}, from the tool library: no ball end of the setup fits into the channel",
            tool.number,
            units::display_units(ui).diameter(tool.diameter)
        );
        ui.add(egui::Label::new(RichText::new(text).weak()).wrap());
    }
}

/// Draws the fields of the display.
pub fn display(ui: &mut Ui, look: &mut FlankLook) {
    ui.checkbox(&mut look.shown, Command::FlankCurves.label()).on_hover_text(Command::FlankCurves.tip());
    ui.horizontal_wrapped(|ui| {
        for (colours, name, tip) in COLOURS {
            ui.selectable_value(&mut look.colours, colours, name).on_hover_text(tip);
        }
    });
}

/// What the passes are coloured by, in the menu of layers.
pub fn colour_radios(ui: &mut Ui, look: &mut FlankLook) {
    for (colours, name, tip) in COLOURS {
        let label = name[..1].to_uppercase() + &name[1..];
        ui.radio_value(&mut look.colours, colours, label).on_hover_text(tip);
    }
}

/// Name of a wall of a channel with some number of `splitters`.
fn wall_words(wall: WallName, splitters: usize) -> String {
    match wall {
        WallName::Low => "suction side".to_owned(),
        WallName::High => "pressure side".to_owned(),
        WallName::Splitter(number) => splitter_name(number, splitters),
    }
}

/// The same with the side of a splitter, which is that of the passage beside it.
pub fn wall_side_words(wall: WallName, beside: Region, splitters: usize) -> String {
    let name = wall_words(wall, splitters);
    match wall {
        WallName::Splitter(_) if beside.low == wall => format!("suction side of the {name}"),
        WallName::Splitter(_) => format!("pressure side of the {name}"),
        _ => name,
    }
}

/// Name of a region of a channel with some number of `splitters`.
pub fn region_words(region: Region, splitters: usize) -> String {
    let name = |wall: WallName| wall_words(wall, splitters);
    match (region, splitters) {
        (Region::INLET, 0) => "the whole channel".to_owned(),
        (Region::INLET, 1) => "inlet, and round the splitter".to_owned(),
        (Region::INLET, _) => "inlet, and round the splitters".to_owned(),
        // Without splitters only passes along the walls have a region of their own.
        (Region { low: WallName::Low, .. }, 0) => "along the suction side".to_owned(),
        (Region { .. }, 0) => "along the pressure side".to_owned(),
        (Region { low: WallName::Low, high }, _) => format!("{} to {}", name(high), name(WallName::Low)),
        (Region { low, high }, _) => format!("{} to {}", name(low), name(high)),
    }
}

/// The same in a word, for the table of passes.
pub fn short_region_words(region: Region, splitters: usize) -> &'static str {
    match region {
        Region::INLET if splitters == 0 => "channel",
        Region::INLET => "inlet",
        Region { low: WallName::Low, .. } => "suction",
        Region { high: WallName::High, .. } => "pressure",
        _ => "splitter",
    }
}

/// Width of an entry of the key beside its text, points.
const SWATCH_AND_SPACES: f32 = 22.0;

/// Colour key of the passes in a channel with some number of `splitters`.
pub fn key(ui: &mut Ui, colours: FlankColours, plan: &FlankPlan, splitters: usize) {
    let layers = plan.layout.layers.len();
    let patch = |ui: &mut Ui, rgb: Rgb, words: &str| {
        swatch(ui, rgb, 10.0);
        ui.label(words);
    };
    let table = ColourMap::Viridis.table();
    let end = |k: usize| table[k].map(|x| f32::from(x) / 255.0);
    match colours {
        FlankColours::Layer => {
            patch(ui, end(0), "layer 1, at the hub");
            if layers > 1 {
                patch(ui, end(TABLE_LEN - 1), &format!("layer {layers}"));
            }
        }
        FlankColours::Region => {
            // Stretch by stretch: a plan has tens of thousands of moves.
            let stretches = plan.moves.chunk_by(|a, b| a.region == b.region);
            let cut = stretches.filter(|moves| moves.iter().any(|step| step.kind != MoveKind::Rapid));
            let regions: BTreeSet<Region> = cut.map(|moves| moves[0].region).collect();
            let words = |region: &Region| region_words(*region, splitters);
            let width = |region: &Region| theme::width_of_text(ui, &words(region)) + SWATCH_AND_SPACES;
            let fits = regions.iter().map(width).sum::<f32>() < ui.available_width();
            for region in &regions {
                swatch(ui, region_colour(*region), 10.0);
                match fits {
                    true => ui.label(words(region)),
                    false => ui.label(short_region_words(*region, splitters)).on_hover_text(words(region)),
                };
            }
        }
        FlankColours::Feed => {
            let ((slow, fast), units) = (feed_range(&plan.moves), units::display_units(ui));
            patch(ui, end(0), &units.feed(slow));
            patch(ui, end(TABLE_LEN - 1), &units.feed(fast));
            patch(ui, RAPID_COLOUR, "rapid");
        }
        FlankColours::Walls => {
            ui.label("orange: below the blade allowance; violet: above it");
        }
    }
}
