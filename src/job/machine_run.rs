//! A program on a machine, as the window shows it and `verify` times it: by the rotary positions that NC code
//! names, or by those that `post` chooses.

use crate::io::program_file::NcMachine;
use crate::machine::{
    BlankSize, MachineProgram, MachineTool, MotionFault, MotionOptions, MoveAngles, OutputKind, PlacedPart,
    Pose, machine_program,
};
use crate::monitor::Monitor;
use crate::toolpath::{ClProgram, Move};

/// Decimals of the rotary positions that a control chooses itself for vectors and planes, degrees.
const CHOSEN_DECIMALS: usize = 4;

/// The motion of a program, with the pose at the end of each of its moves.
#[derive(Clone, Debug)]
pub struct MachineRun {
    /// One for each move; `None` where the program does not tell.
    pub poses: Vec<Option<Pose>>,
    /// The blocks.
    pub motion: MachineProgram,
}

impl MachineRun {
    /// The motion by the rotary positions that the program names, one for each move; `None` where it names
    /// none at all, since the control chooses them. Moves of the retract position are no blocks of it.
    pub fn by_angles(placed: &PlacedPart, program: &ClProgram, angles: &[MoveAngles]) -> Option<Self> {
        if !angles.iter().any(|angles| matches!(angles, MoveAngles::Named(_))) {
            return None;
        }
        let poses = known_poses(placed, program, angles);
        let kept = poses.iter().zip(angles).map(|(pose, angles)| pose.filter(|_| !angles.is_retract()));
        let motion = MachineProgram::of_poses(program, &kept.collect::<Vec<_>>());
        Some(Self { poses, motion })
    }

    /// The motion of NC code that was read: by the rotary positions that it names, one for each move; where
    /// it leaves them to the control, by those that `post` would choose for tool vectors.
    ///
    /// # Errors
    /// When the code names no positions and the machine cannot run it, or on a cancel.
    pub fn as_read(
        NcMachine { machine, placed, angles }: &NcMachine,
        program: &ClProgram,
        blank: BlankSize,
        monitor: &Monitor,
    ) -> Result<Self, MotionFault> {
        if let Some(run) = Self::by_angles(placed, program, angles) {
            return Ok(run);
        }
        let mut options = MotionOptions::new(OutputKind::TcpVectors, CHOSEN_DECIMALS);
        options.blank = Some(blank);
        let is_retract = |index: &usize| angles.get(*index).is_some_and(|angles| angles.is_retract());
        let kept: Vec<usize> = (0..program.moves.len()).filter(|index| !is_retract(index)).collect();
        let moves = kept.iter().filter_map(|&index| program.moves.get(index).cloned()).collect();
        let without = ClProgram { moves, ..program.clone() };
        let mut run = Self::chosen(machine, placed, &without, &options, monitor)?;
        let mut poses = known_poses(placed, program, angles);
        for (&index, pose) in kept.iter().zip(&run.poses) {
            poses[index] = *pose;
        }
        for step in &mut run.motion.steps {
            step.source = kept.get(step.source).copied().unwrap_or(step.source);
        }
        Ok(Self { poses, ..run })
    }

    /// The motion that `post` makes with `options`.
    ///
    /// # Errors
    /// When the machine cannot run the program, or on a cancel.
    pub fn chosen(
        machine: &MachineTool,
        placed: &PlacedPart,
        program: &ClProgram,
        options: &MotionOptions,
        monitor: &Monitor,
    ) -> Result<Self, MotionFault> {
        let motion = machine_program(machine, placed, program, options, monitor)?;
        let mut poses = vec![None; program.moves.len()];
        // Steps before the one that ends a move lead to it, and one after it may leave the part.
        for step in &motion.steps {
            let end = program.moves.get(step.source).map(|end| placed.point_in_program(&end.tip));
            if let (Some(tip), Some(pose)) = (end, poses.get_mut(step.source))
                && step.pose.tip == tip
            {
                *pose = Some(step.pose);
            }
        }
        Ok(Self { poses, motion })
    }
}

/// The pose at the end of each move whose rotary positions are known.
fn known_poses(placed: &PlacedPart, program: &ClProgram, angles: &[MoveAngles]) -> Vec<Option<Pose>> {
    let pose = |(step, angles): (&Move, &MoveAngles)| {
        let (tip, axis) = (placed.point_in_program(&step.tip), placed.vector_in_program(&step.axis));
        angles.known().map(|angles| Pose { tip, axis, angles })
    };
    program.moves.iter().zip(angles).map(pose).collect()
}
