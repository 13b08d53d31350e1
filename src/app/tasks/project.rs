//! The open project as the content of a project file, and back.

use serde::{Deserialize, Serialize};

use crate::app::model::document::{Edited, WhatIf};
use crate::app::model::field_faults::ReplacedValue;
use crate::app::model::look::{Layers, Look, Operation};
use crate::app::model::part_source::PartSource;
use crate::app::model::planned::Side;
use crate::app::model::problem::Problem;
use crate::app::model::solid::SolidColours;
use crate::app::model::state::AppState;
use crate::drawing::flank::FlankColours;
use crate::gpu::camera::{Camera, Projection};
use crate::io::project_file::{PartLocation, PlanSelection, Project, StoredSet, Viewpoint};
use crate::io::setup_file::SetupEntryFault;

/// The open project; `None` while no part is open.
pub(in crate::app) fn project_of(state: &AppState, camera: Option<Camera>) -> Option<Project> {
    let part = state.document.part.as_ref()?;
    let edited = &state.document.edited;
    let place = match &part.source {
        PartSource::File(path) => PartLocation::File(path.clone()),
        PartSource::Mesh(path, choices) => {
            PartLocation::Mesh { file: path.clone(), choices: choices.clone() }
        }
        PartSource::Sample(name) => PartLocation::Sample(name.clone()),
    };
    let sets = edited.sets.iter().map(|set| StoredSet {
        name: set.name.clone(),
        setup: set.setup.clone(),
        figures: state.results.figures(&set.setup),
        faults: faults_of(&set.replaced),
    });
    Some(Project {
        part: place,
        part_hash: part.hash.fnv1a,
        setup: edited.setup.clone(),
        sets: sets.collect(),
        viewpoint: camera.as_ref().map(viewpoint),
        chosen: PlanSelection {
            before: state.look.side == Side::Before,
            position: state.look.selected,
            cut: state.look.cut_count,
            channels: state.look.shown_channels,
            channels_cut: state.look.channels_cut,
            channel: state.look.selected_channel,
            flank: state.look.operation == Operation::Flank,
        },
        layers: serde_json::to_value(ShownView::from_look(&state.look)).ok(),
        original: None,
        original_hash: None,
        // Nobody has said that the defaults in their place are meant.
        setup_faults: faults_of(&edited.replaced),
    })
}

/// What the view shows, as a project keeps it.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct ShownView {
    layers: Layers,
    stock_by: SolidColours,
    passes: bool,
    passes_by: FlankColours,
    /// Ends of the colour scale, mm, and the upper one of the scale of the walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wall_scale: Option<f64>,
}

impl ShownView {
    fn from_look(look: &Look) -> Self {
        // As a single is written: 0.1 is not 0.10000000149.
        let written = |mm: f32| mm.to_string().parse().unwrap_or_else(|_| f64::from(mm));
        let Look { layers, solid_colours, flank, range, wall_end, .. } = look;
        Self {
            layers: *layers,
            stock_by: *solid_colours,
            passes: flank.shown,
            passes_by: flank.colours,
            scale: range.map(|(low, high)| [low, high].map(written)),
            wall_scale: wall_end.map(written),
        }
    }
}

/// Shows what a project shows. Keys that this version does not know are skipped; with a value that it does
/// not know, all layers stay as they are. Scales that a project does not give are fitted to the plan.
pub(in crate::app) fn show_view_of(project: &Project, look: &mut Look) {
    let shown = project.layers.clone().and_then(|layers| serde_json::from_value(layers).ok());
    if let Some(ShownView { layers, stock_by, passes, passes_by, scale, wall_scale }) = shown {
        (look.layers, look.solid_colours) = (layers, stock_by);
        (look.flank.shown, look.flank.colours) = (passes, passes_by);
        let is_scale = |[low, high]: &[f64; 2]| low.is_finite() && high.is_finite() && low < high;
        look.range = scale.filter(is_scale).map(|[low, high]| (low as f32, high as f32));
        look.wall_end = wall_scale.filter(|end| end.is_finite() && *end > 0.0).map(|end| end as f32);
    }
}

fn faults_of(replaced: &[ReplacedValue]) -> Vec<SetupEntryFault> {
    replaced.iter().map(|value| value.fault.clone()).collect()
}

fn viewpoint(camera: &Camera) -> Viewpoint {
    Viewpoint {
        target: camera.target.to_array(),
        yaw: camera.yaw_rad,
        pitch: camera.pitch_rad,
        distance: camera.distance,
        parallel: camera.projection == Projection::Orthographic,
    }
}

/// Setup and variants of a project.
pub(in crate::app) fn edited_of(project: &Project) -> Edited {
    let value = |fault: &SetupEntryFault| ReplacedValue {
        fault: fault.clone(),
        field: Problem::of_replaced(fault).field,
    };
    let replaced = |faults: &[SetupEntryFault]| faults.iter().map(value).collect();
    let sets = project.sets.iter().map(|set| WhatIf {
        name: set.name.clone(),
        setup: set.setup.clone(),
        replaced: replaced(&set.faults),
    });
    Edited { setup: project.setup.clone(), sets: sets.collect(), replaced: replaced(&project.setup_faults) }
}

/// Source of a project's part.
pub(in crate::app) fn source_of(project: &Project) -> PartSource {
    match &project.part {
        PartLocation::File(path) => PartSource::File(path.clone()),
        PartLocation::Mesh { file, choices } => PartSource::Mesh(file.clone(), choices.clone()),
        PartLocation::Sample(name) => PartSource::Sample(name.clone()),
    }
}
