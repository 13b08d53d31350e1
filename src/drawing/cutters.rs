//! The plunges of a plan as cutters.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::Point;
use crate::gpu::cutters::{AssemblyPiece, CutterInstance, CutterSet, CutterState, DrawnCutter};
use crate::plunge::plan::{Condition, PlungePlan, Position, Unevaluated};
use crate::setup::{OutlineKind, OutlinePiece, Tool};

/// The cutters of a plan. Positions whose section does not exist are skipped.
pub fn cutter_set(plan: &PlungePlan) -> CutterSet {
    CutterSet { cutters: evaluated_cutters(plan), sections: plan.sections.len() }
}

/// The plunges of an evaluated plan, each in the state of its [`Condition`].
pub fn evaluated_cutters(plan: &PlungePlan) -> Vec<DrawnCutter> {
    drawn_cutters(plan, |position| {
        let state = match position.condition() {
            Condition::Sound => CutterState::Sound,
            Condition::Blocked => CutterState::Blocked,
            Condition::Interfering => CutterState::Interfering,
        };
        (state, position.evaluation.retract)
    })
}

/// The plunges of a plan that is not evaluated yet, without retracts.
pub fn placed_cutters(plan: &PlungePlan<Unevaluated>) -> Vec<DrawnCutter> {
    drawn_cutters(plan, |position| (CutterState::Unevaluated, position.tip))
}

/// The plunges of a plan with the state and retract point that `evaluation` gives.
fn drawn_cutters<E>(
    plan: &PlungePlan<E>,
    evaluation: impl Fn(&Position<E>) -> (CutterState, Point),
) -> Vec<DrawnCutter> {
    let to = |p: [f64; 3]| p.map(|x| x as f32);
    let assemblies: Vec<Arc<[AssemblyPiece]>> =
        plan.sections.iter().map(|section| assembly(&section.tool)).collect();
    let mut all = Vec::with_capacity(plan.positions.len());
    for (id, position) in plan.positions.iter().enumerate() {
        let Some(section) = plan.sections.get(position.section) else { continue };
        let tool = &section.tool;
        let (state, retract) = evaluation(position);
        let tip = to(position.tip.into());
        let retract = Vec3::from_array(to(retract.into()));
        all.push(DrawnCutter {
            instance: CutterInstance {
                tip,
                radius: tool.radius() as f32,
                axis: to(position.axis.into()),
                height: retract.distance(Vec3::from_array(tip)).max(tool.radius() as f32),
                core_radius: tool.core_radius().clamp(0.0, tool.radius()) as f32,
                corner_radius: tool.corner_radius.clamp(0.0, tool.radius()) as f32,
                state: state as u32,
                id: id as u32,
            },
            retract,
            section: position.section,
            assembly: Arc::clone(&assemblies[position.section]),
        });
    }
    all
}

/// What a tool has above its cutter.
fn assembly(tool: &Tool) -> Arc<[AssemblyPiece]> {
    let is_above = |piece: &OutlinePiece| !matches!(piece.kind, OutlineKind::Cutter | OutlineKind::Body);
    let drawn = |piece: OutlinePiece| AssemblyPiece {
        heights: [piece.from as f32, (piece.from + piece.length) as f32],
        radii: piece.radii.map(|radius| radius as f32),
    };
    tool.outline().into_iter().filter(is_above).map(drawn).collect()
}
