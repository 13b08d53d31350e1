//! The plunges of a plan as cutters.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::{Point, Vector};
use crate::gpu::cutters::{AssemblyPiece, CutterInstance, CutterSet, CutterState, DrawnCutter};
use crate::plunge::Condition;
use crate::plunge::plan::{PlungePlan, Position, Unevaluated};
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
    let assemblies: Vec<Arc<[AssemblyPiece]>> =
        plan.sections.iter().map(|section| assembly(&section.tool)).collect();
    let mut all = Vec::with_capacity(plan.positions.len());
    for (id, position) in plan.positions.iter().enumerate() {
        let Some(section) = plan.sections.get(position.section) else { continue };
        let (state, retract) = evaluation(position);
        let instance = instance(&section.tool, position.tip, position.axis, retract, state);
        all.push(DrawnCutter {
            instance: CutterInstance { id: id as u32, ..instance },
            retract: to(retract.coords).into(),
            section: position.section,
            assembly: Arc::clone(&assemblies[position.section]),
        });
    }
    all
}

/// A tool at a place: its `tip`, and its unit `axis` up to its overhang.
pub fn single_cutter(tool: &Tool, tip: Point, axis: Vector, state: CutterState) -> DrawnCutter {
    let top = tip + axis * tool.overhang;
    DrawnCutter {
        instance: instance(tool, tip, axis, top, state),
        retract: to(top.coords).into(),
        section: 0,
        assembly: assembly(tool),
    }
}

/// A cutter from its `tip` to its `retract` point, with the number 0.
fn instance(tool: &Tool, tip: Point, axis: Vector, retract: Point, state: CutterState) -> CutterInstance {
    let (tip, retract) = (to(tip.coords), to(retract.coords));
    CutterInstance {
        tip,
        radius: tool.radius() as f32,
        axis: to(axis),
        height: Vec3::from(retract).distance(tip.into()).max(tool.radius() as f32),
        core_radius: tool.core_radius().clamp(0.0, tool.radius()) as f32,
        corner_radius: tool.corner_radius.clamp(0.0, tool.radius()) as f32,
        state: state as u32,
        id: 0,
    }
}

fn to(v: Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
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
