//! The shown program on its machine: where all axes stand at the end of each step of the timeline.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use glam::Vec2;

use crate::drawing::machine::{DrawnTool, PosedMachine, head_mesh, machine_mesh, mesh_without_head};
use crate::gpu::camera::{Camera, ViewRay};
use crate::gpu::mesh::Mesh;
use crate::io::InputError;
use crate::io::machine_file::read_machine;
use crate::machine::{BlankSize, LINEAR_NAMES, LimitFault, MachineTool, NEAR_POLE_RAD, PlacedPart, Pose};
use crate::setup::Setup;

/// All axes at one moment of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPositions {
    /// Tool and rotary positions, in program coordinates.
    pub pose: Pose,
    /// Machine coordinates X Y Z, mm.
    pub joints: [f64; 3],
    /// The tool in the spindle.
    pub tool: DrawnTool,
}

/// A program as a machine runs it.
#[derive(Clone, Debug)]
pub struct ProgramOnMachine {
    /// The machine.
    pub machine: MachineTool,
    /// How the part lies on it.
    pub placed: PlacedPart,
    /// Extent of the blank.
    pub blank: BlankSize,
    /// Before the first step of the timeline.
    pub start: Option<AxisPositions>,
    /// At the end of each step; empty where the machine cannot run the program.
    pub ends: Vec<Option<AxisPositions>>,
    /// Time from the start of the program to the end of each step, s, with accelerations and tool changes;
    /// empty as `ends`.
    pub clock: Vec<f64>,
    /// Why it cannot: what is wrong, and what to do.
    pub fault: Option<(String, String)>,
    /// What each position of a plunge plan asks of the axes; empty for other programs.
    pub demands: Vec<AxisDemand>,
}

/// What a position asks of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisDemand {
    /// What keeps the machine from it, at the tip or at the retract point.
    pub fault: Option<LimitFault>,
    /// Angle from the pole, rad.
    pub pole_rad: f64,
}

impl AxisDemand {
    /// Whether it is beyond a limit, or near the pole.
    pub fn is_warning(&self) -> bool {
        self.fault.is_some() || self.is_near_pole()
    }

    /// Whether it is near the pole; see [`NEAR_POLE_RAD`].
    pub fn is_near_pole(&self) -> bool {
        self.pole_rad < NEAR_POLE_RAD
    }

    /// Order of warnings: the larger, the worse. What is beyond limits comes before what is near the pole.
    pub fn weight(&self) -> f64 {
        match &self.fault {
            // More than a turn, so that no angle from the pole weighs as much; mm count as rad.
            Some(fault) => fault.excess().map_or(f64::MAX, |excess| TAU + excess),
            None => -self.pole_rad,
        }
    }
}

impl ProgramOnMachine {
    /// The axes after `cut` steps of the timeline; `None`: after all.
    pub fn at(&self, cut: Option<usize>) -> Option<&AxisPositions> {
        match cut.unwrap_or(self.ends.len()).min(self.ends.len()) {
            0 => self.start.as_ref(),
            count => self.ends.get(count - 1)?.as_ref(),
        }
    }

    /// The machine after `cut` steps; see [`Self::at`].
    fn posed(&self, cut: Option<usize>) -> Option<PosedMachine<'_>> {
        let AxisPositions { pose, joints, tool } = *self.at(cut)?;
        let (machine, placed, blank) = (&self.machine, &self.placed, self.blank);
        Some(PosedMachine { machine, placed, blank, joints, angles: pose.angles, tool })
    }

    /// Whether the head hides most of the middle of a picture of `aspect` = width / height after `cut` steps:
    /// the eye is in it, or looks at its back.
    pub fn head_hides(&self, cut: Option<usize>, camera: &Camera, aspect: f32) -> bool {
        /// Rays across the middle of the picture, and its share of the whole one.
        const RAYS: usize = 7;
        const MIDDLE: f32 = 0.5;
        let Some(posed) = self.posed(cut) else { return false };
        let (head, back) = (head_mesh(&posed), camera.basis().2);
        let size = Vec2::new(aspect, 1.0);
        let at = |k: usize| 0.5 + MIDDLE * ((k as f32 + 0.5) / RAYS as f32 - 0.5);
        let rays = (0..RAYS * RAYS).map(|k| camera.ray(Vec2::new(at(k % RAYS), at(k / RAYS)) * size, size));
        let is_hidden = |ray: &ViewRay| {
            let hit = head.hit(ray).map(|hit| ray.origin + ray.direction * hit.distance);
            hit.is_some_and(|point| (point - camera.target).dot(back) > 0.0)
        };
        2 * rays.filter(is_hidden).count() > RAYS * RAYS
    }

    /// Name and position of each axis, with its unit: X Y Z, then the rotary axes by their letters.
    pub fn named(&self, at: &AxisPositions) -> [(char, f64, &'static str); 5] {
        let linear = |i: usize| (LINEAR_NAMES[i], at.joints[i], "");
        let rotary = |i: usize| (self.machine.rotary[i].letter, at.pose.angles[i].to_degrees(), "°");
        let [a, b] = self.rotary_by_letter();
        [linear(0), linear(1), linear(2), rotary(a), rotary(b)]
    }

    /// Indices of the rotary axes in the order of their letters.
    pub fn rotary_by_letter(&self) -> [usize; 2] {
        if self.machine.rotary[0].letter <= self.machine.rotary[1].letter { [0, 1] } else { [1, 0] }
    }
}

/// A machine in a picture.
#[derive(Clone, Debug)]
pub struct ShownMachine {
    /// The machine with its program.
    pub program: Arc<ProgramOnMachine>,
    /// Steps of the timeline that are done; `None`: all.
    pub cut: Option<usize>,
    /// Whether its head is drawn.
    pub has_head: bool,
}

impl ShownMachine {
    /// Whether `other` looks the same.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.program, &other.program) && (self.cut, self.has_head) == (other.cut, other.has_head)
    }

    /// Its solids.
    pub fn mesh(&self) -> Option<Mesh> {
        let posed = self.program.posed(self.cut)?;
        Some(if self.has_head { machine_mesh(&posed) } else { mesh_without_head(&posed) })
    }
}

/// Chooses the machine of a setup by its name, or none; the planner then keeps to the tilt that it reaches.
///
/// # Errors
/// When the machine cannot be read.
pub fn choose_machine(setup: &mut Setup, name: Option<&str>) -> Result<(), InputError> {
    match name {
        Some(name) => take_machine(setup, name.to_owned(), &read_machine(Path::new(name))?),
        None => setup.machine = Setup::default().machine,
    }
    Ok(())
}

/// Makes the machine of that name or file the machine of a setup; the planner then keeps to the tilt that
/// it reaches.
pub fn take_machine(setup: &mut Setup, name: String, machine: &MachineTool) {
    setup.machine.max_axis_tilt_rad = machine.max_axis_tilt_rad();
    setup.machine.file = Some(name);
}
