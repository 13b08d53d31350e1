//! A machine as simple solids, moved by its axes, in the frame of the part: the part and the camera stay, the
//! table and the head turn about them.
//!
//! Where the axes are and how they turn is exact. What they carry is not known to a machine file: a table has
//! the size of the blank, a head that of a usual spindle.

use crate::geometry::{Point, Vector};
use crate::gpu::mesh::{Mesh, Paint, Vertex};
use crate::machine::{AxisSide, BlankSize, MachineBody, MachineTool, PlacedPart};
use crate::palette::Rgb;

/// Colours of table, what carries it, head, what carries it, holder and cutter.
const TABLE: Rgb = [0.38, 0.47, 0.58];
const CRADLE: Rgb = [0.47, 0.53, 0.60];
const BASE: Rgb = [0.30, 0.33, 0.37];
const HEAD: Rgb = [0.62, 0.58, 0.50];
const RAM: Rgb = [0.46, 0.44, 0.40];
const HOLDER: Rgb = [0.70, 0.70, 0.72];
const CUTTER: Rgb = [0.85, 0.72, 0.35];

/// Facets of a cylinder.
const FACETS: usize = 32;
/// Thickness of a table, of the plate below it, and of the arms beside it, in radii of the blank.
const THICK: f64 = 0.12;
/// Radius of a table, in radii of the blank.
const TABLE_RADIUS: f64 = 1.15;
/// Radius and height of a spindle, mm.
const SPINDLE: (f64, f64) = (55.0, 150.0);
/// Half the width of a ram, mm.
const RAM_HALF: f64 = 90.0;
/// Steepest direction of an axis that counts as level, and flattest that counts as vertical: z of its unit
/// vector.
const LEVEL: f64 = 0.3;
const VERTICAL: f64 = 0.95;

/// A tool as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnTool {
    /// Radius of the cutter, mm.
    pub radius: f64,
    /// Length from the gauge point to the tip, mm.
    pub length: f64,
}

/// A machine with its axes at one position.
#[derive(Clone, Copy, Debug)]
pub struct PosedMachine<'a> {
    /// The machine.
    pub machine: &'a MachineTool,
    /// How the part lies on it.
    pub placed: &'a PlacedPart,
    /// Extent of the blank.
    pub blank: BlankSize,
    /// Machine coordinates X Y Z, mm.
    pub joints: [f64; 3],
    /// Rotary positions, rad.
    pub angles: [f64; 2],
    /// The tool in the spindle.
    pub tool: DrawnTool,
}

/// The solids of a machine, in the part frame, with corners by [`Vertex::painted`].
pub fn machine_mesh(posed: &PosedMachine<'_>) -> Mesh {
    let mut mesh = mesh_without_head(posed);
    mesh.append(&head_mesh(posed));
    mesh
}

/// The same without what [`head_mesh`] has: table and cutter.
pub fn mesh_without_head(posed: &PosedMachine<'_>) -> Mesh {
    let mut solids = Solids { posed, mesh: Mesh::default() };
    solids.table();
    solids.cutter();
    solids.mesh
}

/// Holder, spindle, and what carries them.
pub fn head_mesh(posed: &PosedMachine<'_>) -> Mesh {
    let mut solids = Solids { posed, mesh: Mesh::default() };
    solids.head();
    solids.mesh
}

struct Solids<'a> {
    posed: &'a PosedMachine<'a>,
    mesh: Mesh,
}

impl Solids<'_> {
    /// Tables and what carries them, from the part downwards.
    fn table(&mut self) {
        let PosedMachine { machine, placed, blank, .. } = *self.posed;
        let radius = blank.radius;
        let ends = [blank.z.0, blank.z.1].map(|z| placed.point_in_program(&Point::new(0.0, 0.0, z)).z);
        let mut top = machine.part.origin + Vector::z() * ends[0].min(ends[1]);
        let carried: Vec<usize> = (0..2).filter(|&i| machine.rotary[i].side == AxisSide::Table).collect();
        let down = |top: Point, by: f64| top - Vector::z() * (by * radius);
        for (&axis, is_last) in carried.iter().zip((1..=carried.len()).map(|n| n == carried.len())) {
            let (turned, k) = (MachineBody::Table(axis), machine.rotary[axis].direction);
            let carrier = if is_last { MachineBody::Base } else { MachineBody::Table(axis + 1) };
            if k.z.abs() > VERTICAL {
                let centre = Point::new(machine.rotary[axis].point.x, machine.rotary[axis].point.y, top.z);
                self.cylinder(turned, [down(centre, THICK), centre], [TABLE_RADIUS * radius; 2], TABLE);
                top = down(centre, THICK);
            } else if k.z.abs() < LEVEL {
                self.cradle(axis, carrier, top);
                return;
            } else {
                self.knuckle(axis, carrier, top);
                return;
            }
        }
        self.cuboid(MachineBody::Base, down(top, 1.5 * THICK), Vector::x(), [1.3, 1.3, 1.5 * THICK], BASE);
    }

    /// A cradle that hangs between two journals on a level axis, and the posts that hold these.
    fn cradle(&mut self, axis: usize, carrier: MachineBody, top: Point) {
        let radius = self.posed.blank.radius;
        let rotary = &self.posed.machine.rotary[axis];
        let along = Vector::new(rotary.direction.x, rotary.direction.y, 0.0).normalize();
        let turned = MachineBody::Table(axis);
        let plate = top - Vector::z() * (0.5 * THICK * radius);
        self.cuboid(turned, plate, along, [1.36, 0.6, 0.5 * THICK], CRADLE);
        let pivot = Point::new(top.x, top.y, rotary.point.z);
        let (high, low) = (pivot.z.max(plate.z) + 0.2 * radius, pivot.z.min(plate.z) - 0.2 * radius);
        for side in [-1.0, 1.0] {
            let out = |distance: f64| along * (side * distance * radius);
            let middle = Point::new(top.x, top.y, 0.5 * (high + low)) + out(1.3);
            self.cuboid(turned, middle, along, [0.06, 0.3, 0.5 * (high - low) / radius], CRADLE);
            self.cylinder(turned, [pivot + out(1.36), pivot + out(1.6)], [0.16 * radius; 2], CRADLE);
            let post = pivot + out(1.7) - Vector::z() * (0.35 * radius);
            self.cuboid(carrier, post, along, [0.1, 0.35, 0.6], BASE);
        }
    }

    /// A knuckle on a slanting axis below the table, and the base that holds it.
    fn knuckle(&mut self, axis: usize, carrier: MachineBody, top: Point) {
        let radius = self.posed.blank.radius;
        let rotary = &self.posed.machine.rotary[axis];
        let down = if rotary.direction.z < 0.0 { rotary.direction } else { -rotary.direction };
        let turned = MachineBody::Table(axis);
        let plate = [top - Vector::z() * (THICK * radius), top];
        self.cylinder(turned, plate, [0.7 * radius; 2], CRADLE);
        // From where the axis is below the plate.
        let below = ((rotary.point.z - plate[0].z) / -down.z).max(0.0);
        let at = |further: f64| rotary.point + down * (below + further * radius);
        self.cylinder(turned, [at(0.1), at(0.7)], [0.4 * radius; 2], CRADLE);
        self.cylinder(carrier, [at(0.7), at(1.1)], [0.5 * radius; 2], BASE);
    }

    /// Rotary axes of the head, from the ram on, and what carries the tool.
    fn spindle(&self) -> (Vec<usize>, MachineBody) {
        let is_carried = |&i: &usize| self.posed.machine.rotary[i].side == AxisSide::Head;
        let carried: Vec<usize> = (0..2).filter(is_carried).collect();
        let spindle = carried.last().map_or(MachineBody::Ram, |&axis| MachineBody::Head(axis));
        (carried, spindle)
    }

    /// Where the holder begins, from the gauge point, mm.
    fn shoulder(&self) -> f64 {
        -self.posed.machine.holder_length.min(self.posed.tool.length)
    }

    /// The cutter up to its holder.
    fn cutter(&mut self) {
        let tool = self.posed.tool;
        let ends = [-tool.length, self.shoulder()].map(|z| Point::new(0.0, 0.0, z));
        self.cylinder(self.spindle().1, ends, [tool.radius; 2], CUTTER);
    }

    /// Holder, spindle, and the heads that carry it, from the cutter upwards.
    fn head(&mut self) {
        let PosedMachine { machine, tool, .. } = *self.posed;
        let ((carried, spindle), shoulder) = (self.spindle(), self.shoulder());
        let at = |z: f64| Point::new(0.0, 0.0, z);
        let slim = (1.3 * tool.radius).max(0.3 * SPINDLE.0).min(SPINDLE.0);
        self.cylinder(spindle, [at(shoulder), at(0.0)], [slim, 0.8 * SPINDLE.0], HOLDER);
        let mut top = SPINDLE.1;
        for (&axis, before) in carried.iter().rev().zip(carried.iter().rev().skip(1).map(Some).chain([None]))
        {
            let (body, rotary) = (MachineBody::Head(axis), &machine.rotary[axis]);
            let carrier = before.map_or(MachineBody::Ram, |&axis| MachineBody::Head(axis));
            if rotary.direction.z.abs() > VERTICAL {
                let centre = Point::new(rotary.point.x, rotary.point.y, top);
                let ends = [centre, centre + Vector::z() * 60.0];
                self.cylinder(body, ends, [1.3 * SPINDLE.0; 2], HEAD);
                top += 60.0;
            } else {
                self.fork(axis, carrier);
                top = rotary.point.z + 2.4 * SPINDLE.0;
            }
        }
        if carried.is_empty() {
            self.cylinder(MachineBody::Ram, [at(0.0), at(top)], [SPINDLE.0; 2], HEAD);
        }
        let ram = Point::new(0.0, 0.0, top + 120.0);
        self.block(MachineBody::Ram, ram, Vector::x(), [RAM_HALF, RAM_HALF, 120.0], RAM);
    }

    /// The spindle on a tilting axis, and the fork that holds it.
    fn fork(&mut self, axis: usize, carrier: MachineBody) {
        let rotary = &self.posed.machine.rotary[axis];
        let (body, pivot) = (MachineBody::Head(axis), rotary.point);
        let level = Vector::new(rotary.direction.x, rotary.direction.y, 0.0);
        let along = level.try_normalize(1e-9).unwrap_or_else(Vector::y);
        let nose = Point::new(pivot.x, pivot.y, 0.0);
        self.cylinder(body, [nose, pivot], [SPINDLE.0; 2], HEAD);
        let half = 1.2 * SPINDLE.0;
        let reach = rotary.direction * half;
        self.cylinder(body, [pivot - reach, pivot + reach], [1.15 * SPINDLE.0; 2], HEAD);
        for side in [-1.0, 1.0] {
            let cheek = pivot + along * (side * 1.4 * SPINDLE.0) + Vector::z() * (0.7 * SPINDLE.0);
            let size = [0.2 * SPINDLE.0, SPINDLE.0, 1.4 * SPINDLE.0];
            self.block(carrier, cheek, along, size, RAM);
        }
        let yoke = pivot + Vector::z() * (2.1 * SPINDLE.0);
        let size = [1.6 * SPINDLE.0, SPINDLE.0, 0.3 * SPINDLE.0];
        self.block(carrier, yoke, along, size, RAM);
    }

    /// A cuboid whose half sizes are given in radii of the blank.
    fn cuboid(&mut self, body: MachineBody, centre: Point, along: Vector, half: [f64; 3], colour: Rgb) {
        let radius = self.posed.blank.radius;
        self.block(body, centre, along, half.map(|x| x * radius), colour);
    }

    /// A cuboid about `centre`, with half sizes (mm) along the level direction `along`, across it, and up.
    fn block(&mut self, body: MachineBody, centre: Point, along: Vector, half: [f64; 3], colour: Rgb) {
        let edges = [along * half[0], Vector::z().cross(&along) * half[1], Vector::z() * half[2]];
        for face in 0..3 {
            let [u, v] = [edges[(face + 1) % 3], edges[(face + 2) % 3]];
            for side in [-1.0, 1.0] {
                let middle = centre + edges[face] * side;
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
                self.face(body, &corners.map(|(a, b)| middle + u * a + v * b), colour);
            }
        }
    }

    /// A cylinder or cone between two points, with its radius at each, mm.
    fn cylinder(&mut self, body: MachineBody, ends: [Point; 2], radii: [f64; 2], colour: Rgb) {
        let Some(along) = (ends[1] - ends[0]).try_normalize(1e-9) else { return };
        let across = if along.z.abs() < 0.9 { Vector::z() } else { Vector::x() };
        let u = along.cross(&across).normalize();
        let v = along.cross(&u);
        let rim = |end: usize, k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / FACETS as f64).sin_cos();
            ends[end] + (u * cos + v * sin) * radii[end]
        };
        for k in 0..FACETS {
            self.face(body, &[rim(0, k), rim(0, k + 1), rim(1, k + 1), rim(1, k)], colour);
        }
        for end in [0, 1] {
            let circle: Vec<Point> = (0..FACETS).map(|k| rim(end, k)).collect();
            self.face(body, &circle, colour);
        }
    }

    /// A flat convex face; corners where all axes are at 0.
    fn face(&mut self, body: MachineBody, corners: &[Point], colour: Rgb) {
        let PosedMachine { machine, placed, joints, angles, .. } = *self.posed;
        let first = self.mesh.vertices.len() as u32;
        let vertex = |corner: &Point| {
            let point = placed.point_in_part(&machine.body_point(body, corner, &joints, &angles));
            // Without a normal, each face is lit as a flat one.
            Vertex::painted(
                [point.x as f32, point.y as f32, point.z as f32],
                [0.0; 3],
                0.0,
                Paint::whole(colour),
            )
        };
        self.mesh.vertices.extend(corners.iter().map(vertex));
        let fan = (1..corners.len() as u32 - 1).flat_map(|k| [first, first + k, first + k + 1]);
        self.mesh.indices.extend(fan);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::io::machine_file::read_machine;

    const TOOL: DrawnTool = DrawnTool { radius: 8.0, length: 190.0 };
    const BLANK: BlankSize = BlankSize { radius: 120.0, z: (-10.0, 90.0) };

    /// Corners of one colour, of a machine whose tool stands in `tip` (program coordinates) at `angles`.
    fn corners(name: &str, tip: Point, angles: [f64; 2], colour: Rgb) -> (Vec<Point>, Point, Vector) {
        let machine = read_machine(Path::new(name)).expect("a machine of the program");
        let placed = PlacedPart::new(&machine.part, false);
        let joints = machine.joints(&tip, &angles, TOOL.length);
        let (machine, placed) = (&machine, &placed);
        let mesh = machine_mesh(&PosedMachine { machine, placed, blank: BLANK, joints, angles, tool: TOOL });
        let painted = Vertex::painted([0.0; 3], [0.0; 3], 0.0, Paint::whole(colour)).uncut.to_bits();
        let of_colour = mesh.vertices.iter().filter(|vertex| vertex.uncut.to_bits() == painted);
        let corners = of_colour.map(|vertex| Point::from(vertex.position.map(f64::from))).collect();
        let axis = placed.vector_in_part(&machine.tool_axis(&angles));
        (corners, placed.point_in_part(&tip), axis)
    }

    const MACHINES: [&str; 5] = ["ac-trunnion", "bc-trunnion", "b-head-c-table", "bc-head", "nutating-table"];
    const ANGLES: [[f64; 2]; 3] = [[0.0, 0.0], [0.7, 0.4], [-2.1, 0.9]];

    #[test]
    fn the_holder_stands_above_the_tip_along_the_axis_of_the_tool() {
        for name in MACHINES {
            for angles in ANGLES {
                let (holder, tip, axis) = corners(name, Point::new(40.0, -25.0, 30.0), angles, HOLDER);
                let heights: Vec<f64> = holder.iter().map(|corner| (corner - tip).dot(&axis)).collect();
                let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
                let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert!((low - 90.0).abs() < 1e-3 && (high - 190.0).abs() < 1e-3, "{name}: {low} to {high}");
                let wide = |corner: &Point| (corner - tip).cross(&axis).norm() <= SPINDLE.0;
                assert!(holder.iter().all(wide), "{name}: about the axis");
            }
        }
    }

    #[test]
    fn the_table_stays_with_the_part_and_the_base_turns_about_it() {
        let tip = Point::new(40.0, -25.0, 30.0);
        for name in MACHINES {
            let of = |angles, colour| corners(name, tip, angles, colour).0;
            let moved = |colour| {
                let pairs = of(ANGLES[0], colour).into_iter().zip(of(ANGLES[1], colour));
                pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
            };
            assert!(moved(TABLE) < 1e-3, "{name}: the table");
            let turns = name != "bc-head";
            assert_eq!(moved(BASE) > 10.0, turns, "{name}: the base by {}", moved(BASE));
            // The part stands on it: in the part frame, its inlet down, that is above the highest z.
            let floor = if turns { TABLE } else { BASE };
            let lowest = of(ANGLES[1], floor).iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
            assert!((lowest - 90.0).abs() < 1e-3, "{name}: {lowest}");
        }
    }
}
