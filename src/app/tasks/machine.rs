//! The shown program on its machine, as `vanecut post` has it run: rotary positions chosen over the whole
//! program; those of NC code are read from it.

use std::path::Path;
use std::sync::Arc;

use super::Repaint;
use crate::app::model::machine::{AxisDemand, AxisPositions, ProgramOnMachine};
use crate::app::model::state::AppState;
use crate::app::model::timeline_program::TimelineProgram;
use crate::app::tasks::latest::Latest;
use crate::drawing::machine::DrawnTool;
use crate::io::InputError;
use crate::io::machine_file::read_machine;
use crate::io::nc::read_post;
use crate::job::machine_run::MachineRun;
use crate::machine::{BlankSize, MachineTool, MotionOptions, PlacedPart, Pose, gauge_length, move_clock};
use crate::monitor::Monitor;
use crate::plunge::{PlungePlan, Position};
use crate::toolpath::{ClProgram, ClTool};

/// A program, and the machine that is to run it.
#[derive(Clone, PartialEq)]
struct MachineRequest {
    program: TimelineProgram,
    machine: String,
    /// See [`MachineList::readings`](crate::app::model::machine_list::MachineList::readings).
    readings: u32,
}

/// The answer: the program on the machine, or why the machine is not known.
type MachineAnswer = Result<Arc<ProgramOnMachine>, InputError>;

/// Finds the positions of the axes in the background.
pub(in crate::app) struct MachineWork(Latest<MachineRequest, MachineAnswer>);

impl MachineWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        Self(Latest::new("machine", repaint, |request: &MachineRequest| run(request).map(Arc::new)))
    }

    /// Requests the shown program on its machine. Returns it once it is known; `None` without a machine.
    pub(in crate::app) fn follow(&mut self, state: &AppState) -> Option<MachineAnswer> {
        let program = state.timeline_program();
        let readings = state.machines.readings;
        let wanted = program.zip(state.timeline_machine()).map(|(program, machine)| MachineRequest {
            program,
            machine: machine.to_owned(),
            readings,
        });
        self.0.request(wanted.clone());
        // Positions of another program or machine would mislead.
        let (of, answer) = self.0.answer()?;
        wanted.filter(|wanted| wanted == of).map(|_| answer.clone())
    }

    /// Whether a request is being computed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.0.is_busy()
    }
}

fn run(request: &MachineRequest) -> Result<ProgramOnMachine, InputError> {
    let (part, allowances) = request.program.part();
    let blank = BlankSize::from_part(part, allowances);
    let (program, steps) = request.program.moves();
    let monitor = Monitor::default();
    let posted_for = match &request.program {
        TimelineProgram::Checked(checked) => checked.on_machine.as_ref(),
        _ => None,
    };
    let (machine, placed, run) = match posted_for {
        Some(on_machine) => {
            let run = MachineRun::as_read(on_machine, &program, blank, &monitor);
            (on_machine.machine.clone(), on_machine.placed, run)
        }
        None => {
            let machine = read_machine(Path::new(&request.machine))?;
            let placed = PlacedPart::from_placement(&machine.part, part);
            let post = read_post(&machine.control)?;
            let mut options = MotionOptions::new(machine.output, post.format.angle_decimals);
            options.blank = Some(blank);
            let run = MachineRun::chosen(&machine, &placed, &program, &options, &monitor);
            (machine, placed, run)
        }
    };
    let (poses, moves, fault) = match run {
        Ok(run) => (run.poses, move_clock(&machine, &program, &run.motion), None),
        Err(fault) => {
            let error = fault.explained();
            (Vec::new(), Vec::new(), Some((error.message, error.help)))
        }
    };
    let clock = if fault.is_none() { request.program.clock(&program, &steps, &moves) } else { Vec::new() };
    let at = |index: usize| axis_positions(&machine, &program, index, (*poses.get(index)?)?);
    let first = match request.program {
        TimelineProgram::Flank(_) => steps.first().copied().flatten(),
        _ => Some(0),
    };
    let start = first.and_then(at);
    let ends = if fault.is_none() { steps.iter().map(|end| at((*end)?)).collect() } else { Vec::new() };
    let demands = match &request.program {
        TimelineProgram::Plunges(planned, policy, _) => {
            let plan = planned.plan(*policy);
            plan.positions.iter().map(|position| demand(&machine, &placed, plan, position)).collect()
        }
        _ => Vec::new(),
    };
    Ok(ProgramOnMachine { machine, placed, blank, start, ends, clock, fault, demands })
}

/// What a position asks of the axes.
fn demand(machine: &MachineTool, placed: &PlacedPart, plan: &PlungePlan, position: &Position) -> AxisDemand {
    let axis = placed.vector_in_program(&position.axis);
    let tips = [position.tip, position.evaluation.retract].map(|tip| placed.point_in_program(&tip));
    let tool = plan.sections.get(position.section).map(|section| ClTool::from_tool(&section.tool));
    let length = gauge_length(machine, &tool.unwrap_or_default());
    AxisDemand { fault: machine.limit_fault(&axis, &tips, length), pole_rad: machine.pole_angle(&axis) }
}

/// All axes at the end of move `index`, whose pose is known.
fn axis_positions(
    machine: &MachineTool,
    program: &ClProgram,
    index: usize,
    pose: Pose,
) -> Option<AxisPositions> {
    let cutter = program.tools.get(program.moves.get(index)?.tool?)?;
    let tool = DrawnTool { radius: 0.5 * cutter.diameter, length: gauge_length(machine, cutter) };
    let joints = machine.joints(&pose.tip, &pose.angles, tool.length);
    Some(AxisPositions { pose, joints, tool })
}
