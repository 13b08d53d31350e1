//! The shown plan on the chosen machine, as `vanecut post` has it run: rotary positions chosen over the whole
//! program.

use std::path::Path;
use std::sync::Arc;

use super::Repaint;
use crate::app::model::look::Operation;
use crate::app::model::machine::{AxisDemand, AxisPositions, PlanOnMachine};
use crate::app::model::planned::DisplayPlan;
use crate::app::model::state::AppState;
use crate::app::tasks::latest::Latest;
use crate::drawing::machine::DrawnTool;
use crate::io::InputError;
use crate::io::machine_file::read_machine;
use crate::io::nc::read_post;
use crate::machine::{
    BlankSize, MachineProgram, MachineTool, MotionOptions, PlacedPart, gauge_length, machine_program,
};
use crate::monitor::Monitor;
use crate::plunge::{PlungePlan, Position};
use crate::setup::AxisPolicy;
use crate::toolpath::{ClProgram, ClTool};

/// A plan, and the machine that is to run it.
#[derive(Clone)]
struct MachineRequest {
    planned: Arc<DisplayPlan>,
    policy: AxisPolicy,
    machine: String,
}

impl PartialEq for MachineRequest {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        (self.policy, &self.machine) == (other.policy, &other.machine)
            && Arc::ptr_eq(&self.planned, &other.planned)
    }
}

/// The answer: the plan on the machine, or why the machine is not known.
type MachineAnswer = Result<Arc<PlanOnMachine>, InputError>;

/// Finds the positions of the axes in the background.
pub(in crate::app) struct MachineWork(Latest<MachineRequest, MachineAnswer>);

impl MachineWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("machine", repaint, |request: &MachineRequest| run(request).map(Arc::new)))
    }

    /// Requests the shown plan on the machine of the setup. Returns it once it is known; `None` without a
    /// machine.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<MachineAnswer> {
        let machine = state.document.edited.setup.machine.file.clone();
        let machine = machine.filter(|_| state.look.operation == Operation::Roughing);
        let wanted = machine.zip(state.shown()).map(|(machine, shown)| MachineRequest {
            planned: Arc::clone(shown.planned),
            policy: shown.policy,
            machine,
        });
        self.0.request(wanted.clone());
        // Positions of another plan or machine would mislead.
        let (of, answer) = self.0.answer()?;
        wanted.filter(|wanted| wanted == of).map(|_| answer.clone())
    }

    /// Whether a request is being computed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}

fn run(request: &MachineRequest) -> Result<PlanOnMachine, InputError> {
    let machine = read_machine(Path::new(&request.machine))?;
    let post = read_post(&machine.control)?;
    let outcome = &request.planned.outcome;
    let part = &outcome.workpiece.part;
    let plan = request.planned.plan(request.policy);
    let mut program = ClProgram::of_plan(&part.name, plan);
    for (number, step) in (1..).zip(&mut program.moves) {
        step.line = number;
    }
    let placed = PlacedPart::of(&machine.part, part);
    let mut options = MotionOptions::new(machine.output, post.format.angle_decimals);
    let blank = BlankSize::of(part, &outcome.setup.allowances);
    options.blank = Some(blank);
    let made = machine_program(&machine, &placed, &program, &options, &Monitor::default());
    let (start, plunges, fault) = match made {
        Ok(motion) => {
            let (start, plunges) = axis_positions(&machine, plan, &program, &motion);
            (start, plunges, None)
        }
        Err(fault) => {
            let error = fault.explained();
            (None, Vec::new(), Some((error.message, error.help)))
        }
    };
    let demands = plan.positions.iter().map(|position| demand(&machine, &placed, plan, position)).collect();
    Ok(PlanOnMachine { machine, placed, blank, start, plunges, fault, demands })
}

/// What a position asks of the axes.
fn demand(machine: &MachineTool, placed: &PlacedPart, plan: &PlungePlan, position: &Position) -> AxisDemand {
    let axis = placed.vector_in_program(&position.axis);
    let tips = [position.tip, position.evaluation.retract].map(|tip| placed.point_in_program(&tip));
    let tool = plan.sections.get(position.section).map(|section| ClTool::of(&section.tool));
    let length = gauge_length(machine, &tool.unwrap_or_default());
    AxisDemand { fault: machine.limit_fault(&axis, &tips, length), pole_rad: machine.pole_angle(&axis) }
}

/// The axes before the first plunge, and at the end of each.
fn axis_positions(
    machine: &MachineTool,
    plan: &PlungePlan,
    program: &ClProgram,
    motion: &MachineProgram,
) -> (Option<AxisPositions>, Vec<Option<AxisPositions>>) {
    // The step that ends each move: a move may have several.
    let mut ends = vec![None; program.moves.len()];
    for (index, step) in motion.steps.iter().enumerate() {
        if let Some(end) = ends.get_mut(step.source) {
            *end = Some(index);
        }
    }
    let after = |index: usize| {
        let step = motion.steps.get(ends.get(index).copied().flatten()?)?;
        let cutter = program.tools.get(step.tool)?;
        let tool = DrawnTool { radius: 0.5 * cutter.diameter, length: gauge_length(machine, cutter) };
        let joints = machine.joints(&step.pose.tip, &step.pose.angles, tool.length);
        Some(AxisPositions { pose: step.pose, joints, tool })
    };
    let at_bottoms = program.bottoms_of(plan).into_iter().map(|bottom| after(bottom?)).collect();
    (after(0), at_bottoms)
}
