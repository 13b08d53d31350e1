//! A program on a machine, as the window shows it and `verify` times it: by the rotary positions that NC code
//! names, or by those that `post` chooses.

use crate::machine::{
    BlankSize, MachineProgram, MachineTool, MotionFault, MotionOptions, OutputKind, PlacedPart, Pose,
    machine_program,
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
    /// The motion by the rotary positions (rad) that the program names, one for each move; `None` where it
    /// names none at all, since the control chooses them.
    pub fn by_angles(placed: &PlacedPart, program: &ClProgram, angles: &[Option<[f64; 2]>]) -> Option<Self> {
        if angles.iter().all(Option::is_none) {
            return None;
        }
        let pose = |(step, angles): (&Move, &Option<[f64; 2]>)| {
            let (tip, axis) = (placed.point_in_program(&step.tip), placed.vector_in_program(&step.axis));
            angles.map(|angles| Pose { tip, axis, angles })
        };
        let poses: Vec<_> = program.moves.iter().zip(angles).map(pose).collect();
        let motion = MachineProgram::of_poses(program, &poses);
        Some(Self { poses, motion })
    }

    /// The motion of NC code that was read: by the rotary positions (rad) that it names, one for each move;
    /// where it leaves them to the control, by those that `post` would choose for tool vectors.
    ///
    /// # Errors
    /// When the code names no positions and the machine cannot run it, or on a cancel.
    pub fn as_read(
        machine: &MachineTool,
        placed: &PlacedPart,
        program: &ClProgram,
        angles: &[Option<[f64; 2]>],
        blank: BlankSize,
        monitor: &Monitor,
    ) -> Result<Self, MotionFault> {
        if let Some(run) = Self::by_angles(placed, program, angles) {
            return Ok(run);
        }
        let mut options = MotionOptions::new(OutputKind::TcpVectors, CHOSEN_DECIMALS);
        options.blank = Some(blank);
        Self::chosen(machine, placed, program, &options, monitor)
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
