//! Plunge cutters as instances of one mesh: transparent wall and bottom, solid core, dark rim.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::camera::ViewRay;
use super::mesh::{LineColour, Segment, polyline};
use crate::palette::Rgb;

/// State of a position, shown by its colour.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutterState {
    /// The core meets no stock.
    #[default]
    Sound = 0,
    /// The axis that the policy requires is not possible there.
    Blocked = 1,
    /// The core meets stock.
    Interfering = 2,
    /// Selected by the user.
    Selected = 3,
    /// Contact of the core is not evaluated yet.
    Unevaluated = 4,
}

/// Which cutters are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutterFilter {
    /// None, except the selected one.
    Hidden,
    /// The one that cut last, while only part of the positions is shown, and the selected one.
    Last,
    /// Interfering and blocked plunges.
    Faulty,
    /// All.
    #[default]
    All,
}

/// Instance data of one cutter. 48 bytes, matches `CutterIn` of `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CutterInstance {
    /// Centre of the bottom, mm.
    pub tip: [f32; 3],
    /// R, mm.
    pub radius: f32,
    /// Unit axis, tip → holder.
    pub axis: [f32; 3],
    /// Drawn length, mm.
    pub height: f32,
    /// R − w, mm.
    pub core_radius: f32,
    /// Corner radius, mm.
    pub corner_radius: f32,
    /// [`CutterState`] in the lowest three bits; see [`Self::set_colour`] for the others.
    pub state: u32,
    /// Index of the position in the plan.
    pub id: u32,
}

impl CutterInstance {
    /// Flag of [`Self::state`]: the upper three bytes are a colour.
    const COLOURED: u32 = 8;

    /// The [`CutterState`] as a number.
    fn state_number(&self) -> u32 {
        self.state & 7
    }

    /// Sets a colour that replaces that of the state, or removes it.
    pub fn set_colour(&mut self, colour: Option<Rgb>) {
        self.state = self.state_number();
        if let Some(colour) = colour {
            let [r, g, b] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u32);
            self.state |= Self::COLOURED | r << 8 | g << 16 | b << 24;
        }
    }

    /// The colour that replaces that of the state, if there is one.
    fn colour(&self) -> Option<Rgb> {
        let byte = |shift: u32| (self.state >> shift & 255) as f32 / 255.0;
        (self.state & Self::COLOURED != 0).then(|| [byte(8), byte(16), byte(24)])
    }
}

/// A position of a plan, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnCutter {
    /// Instance at full length, up to the retract point; its state ignores the selection.
    pub instance: CutterInstance,
    /// Retract point, mm.
    pub retract: Vec3,
    /// Index of the section.
    pub section: usize,
    /// Shank and holder above the cutter.
    pub assembly: Arc<[AssemblyPiece]>,
}

impl DrawnCutter {
    /// The same turned about Z by an angle, given by its sine and cosine.
    pub fn turned_z(&self, turn: (f32, f32)) -> Self {
        let turn = |point| turned_z(point, turn);
        let instance =
            CutterInstance { tip: turn(self.instance.tip), axis: turn(self.instance.axis), ..self.instance };
        Self { instance, retract: turn(self.retract.to_array()).into(), ..self.clone() }
    }
}

/// A point turned about Z by an angle, given by its sine and cosine.
fn turned_z([x, y, z]: [f32; 3], (sin, cos): (f32, f32)) -> [f32; 3] {
    [x * cos - y * sin, x * sin + y * cos, z]
}

/// A channel in which the cutters of a plan are drawn once more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnChannel {
    /// Its turn about Z, rad.
    pub turn_rad: f32,
    /// Draws only positions before this one.
    pub up_to: Option<usize>,
    /// Whether the last of them, at full length, is the tool.
    pub has_tool: bool,
}

impl DrawnChannel {
    /// Which cutters it shows, where `choice` holds for channel 1. None is selected in it.
    pub fn choice(&self, choice: &CutterChoice) -> CutterChoice {
        CutterChoice { up_to: self.up_to, hides_last: !self.has_tool, selected: None, ..*choice }
    }
}

/// A cylinder or cone of a shank or holder, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssemblyPiece {
    /// Heights of its ends above the tip.
    pub heights: [f32; 2],
    /// Radii at its ends.
    pub radii: [f32; 2],
}

/// The cutters of a plan, in cutting order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutterSet {
    /// The cutters.
    pub cutters: Vec<DrawnCutter>,
    /// Number of sections of the plan, also of those without cutters.
    pub sections: usize,
}

/// Which cutters to draw, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutterChoice {
    /// Which ones.
    pub filter: CutterFilter,
    /// Draws only positions before this one, the last of them at full length.
    pub up_to: Option<usize>,
    /// Whether the last of them is drawn like the others: the tool is in another channel.
    pub hides_last: bool,
    /// Selected position; always drawn at full length.
    pub selected: Option<usize>,
    /// Drawn length of the other sound cutters, in diameters; faulty ones are longer.
    pub stub: f32,
}

impl CutterChoice {
    /// The instance to draw for a cutter, or `None` when it is not shown.
    pub fn instance(&self, cutter: &DrawnCutter) -> Option<CutterInstance> {
        let mut instance = cutter.instance;
        let id = instance.id as usize;
        if self.selected == Some(id) {
            instance.state = CutterState::Selected as u32;
            return Some(instance);
        }
        let is_last = match self.up_to {
            Some(at) if id >= at => return None,
            Some(at) => id + 1 == at && !self.hides_last,
            None => false,
        };
        let shown = match self.filter {
            CutterFilter::Hidden => false,
            CutterFilter::Last => is_last,
            CutterFilter::Faulty => instance.state_number() != CutterState::Sound as u32,
            CutterFilter::All => true,
        };
        if !shown {
            return None;
        }
        if !is_last {
            // Faulty cutters also differ in length, for users who cannot tell the colours apart.
            let stretch = match instance.state_number() {
                0 | 4 => 1.0,
                1 => 1.5,
                _ => 2.0,
            };
            instance.height = instance.height.min(2.0 * instance.radius * self.stub * stretch);
        }
        Some(instance)
    }
}

/// Colour of the rim of a cutter in a state.
fn rim_colour(state: u32) -> LineColour {
    match state {
        0 => LineColour::Sound,
        1 => LineColour::Blocked,
        2 => LineColour::Interfering,
        3 => LineColour::Selected,
        _ => LineColour::Unevaluated,
    }
}

/// Unit vectors across an axis.
fn perpendiculars(axis: Vec3) -> (Vec3, Vec3) {
    axis.any_orthonormal_pair()
}

/// Appends the rims of a drawn cutter: the bottom edge, the core's upper edge, and the upper end if it is
/// drawn at full length (`whole`).
pub fn append_rims(instance: &CutterInstance, steps: usize, whole: bool, into: &mut Vec<Segment>) {
    let tip = Vec3::from_array(instance.tip);
    let axis = Vec3::from_array(instance.axis);
    let (x, y) = perpendiculars(axis);
    let named = rim_colour(instance.state_number());
    let own = instance.colour();
    let mut circle = |radius: f32, height: f32, width: f32| {
        let points: Vec<Vec3> = (0..=steps)
            .map(|i| {
                let (sin, cos) = (i as f32 / steps as f32 * std::f32::consts::TAU).sin_cos();
                tip + axis * height + (x * cos + y * sin) * radius
            })
            .collect();
        let rim = polyline(&points, width, named).map(|line| match own {
            Some(colour) => Segment::coloured(line.a, line.b, line.width, colour.map(|x| 0.7 * x)),
            None => line,
        });
        into.extend(rim.map(Segment::on_part));
    };
    let width = match instance.state_number() {
        0 | 4 => 1.1,
        3 => 2.6,
        _ => 1.6,
    };
    circle(instance.radius, instance.corner_radius.min(instance.height), width);
    // Cores overlap in a typical plan; their upper rims make them distinguishable.
    circle(instance.core_radius, instance.height, 1.2);
    if whole {
        circle(instance.radius, instance.height, width * 0.7);
    }
}

/// Axis of a cutter from its tip to the retract point.
pub fn axis_line(cutter: &DrawnCutter, selected: bool) -> Segment {
    Segment {
        a: cutter.instance.tip,
        width: if selected { 2.0 } else { 1.0 },
        b: cutter.retract.to_array(),
        colour: if selected { LineColour::Selected } else { LineColour::Axis } as u32,
    }
}

/// Appends the outlines of shank and holder above a cutter: the rims of every piece, and lines between them.
pub fn append_holder(cutter: &DrawnCutter, into: &mut Vec<Segment>) {
    const STEPS: usize = 24;
    let axis = Vec3::from_array(cutter.instance.axis);
    let tip = Vec3::from_array(cutter.instance.tip);
    let (x, y) = perpendiculars(axis);
    for AssemblyPiece { heights, radii } in cutter.assembly.iter() {
        let [low, high] = [0, 1].map(|end| -> Vec<Vec3> {
            let at = |i: usize| {
                let (sin, cos) = (i as f32 / STEPS as f32 * std::f32::consts::TAU).sin_cos();
                tip + axis * heights[end] + (x * cos + y * sin) * radii[end]
            };
            (0..=STEPS).map(at).collect()
        });
        let mut add = |points: &[Vec3], width| {
            into.extend(polyline(points, width, LineColour::Axis).map(Segment::on_part));
        };
        add(&low, 1.6);
        add(&high, 1.0);
        for i in (0..STEPS).step_by(STEPS / 8) {
            add(&[low[i], high[i]], 1.0);
        }
    }
}

/// Appends the rapids between the retract points of consecutive positions of one section, up to position
/// `at`, in the channel turned about Z by the angle whose sine and cosine are `turn`.
pub fn append_links(cutters: &[DrawnCutter], at: Option<usize>, turn: (f32, f32), into: &mut Vec<Segment>) {
    let cut = cutters.iter().filter(|c| at.is_none_or(|at| (c.instance.id as usize) < at));
    let retract = |cutter: &DrawnCutter| Vec3::from_array(turned_z(cutter.retract.to_array(), turn));
    let mut before: Option<&DrawnCutter> = None;
    for cutter in cut {
        if let Some(before) = before.filter(|b| b.section == cutter.section) {
            into.extend(polyline(&[retract(before), retract(cutter)], 1.0, LineColour::Axis));
        }
        before = Some(cutter);
    }
}

/// One corner of the unit cutter. 20 bytes, matches the first part of `CutterIn`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct UnitVertex {
    /// cos and sin of the angle about the axis.
    pub ring: [f32; 2],
    /// Index of the instance's radius and of its height, as listed in the shader.
    pub reach: [f32; 2],
    /// Part of the cutter (wall, corner, annulus, core), numbered as in the shader.
    pub part: u32,
}

/// Mesh of which every cutter is an instance: first the solid part, then the transparent one.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitCutter {
    /// Corners.
    pub vertices: Vec<UnitVertex>,
    /// Vertex indices, three per triangle.
    pub indices: Vec<u32>,
    /// Number of indices of the solid part; the others are transparent.
    pub solid: u32,
}

impl UnitCutter {
    /// Builds the mesh with `steps` facets around the axis.
    pub fn new(steps: usize) -> Self {
        const WALL: u32 = 0;
        const CORNER: u32 = 1;
        const ANNULUS: u32 = 2;
        const CORE_WALL: u32 = 3;
        const CORE_DISC: u32 = 4;
        let mut mesh = Self { vertices: Vec::new(), indices: Vec::new(), solid: 0 };
        mesh.band(steps, CORE_DISC, [0.0, 0.0], [1.0, 0.0]);
        mesh.band(steps, CORE_WALL, [1.0, 0.0], [1.0, 3.0]);
        mesh.band(steps, CORE_DISC, [1.0, 3.0], [0.0, 3.0]);
        mesh.solid = mesh.indices.len() as u32;
        mesh.band(steps, ANNULUS, [1.0, 0.0], [2.0, 0.0]);
        mesh.band(steps, CORNER, [2.0, 0.0], [3.0, 1.0]);
        mesh.band(steps, CORNER, [3.0, 1.0], [4.0, 2.0]);
        mesh.band(steps, WALL, [4.0, 2.0], [4.0, 3.0]);
        mesh
    }

    fn band(&mut self, steps: usize, part: u32, from: [f32; 2], to: [f32; 2]) {
        let base = self.vertices.len() as u32;
        for i in 0..=steps {
            let (sin, cos) = (i as f32 / steps as f32 * std::f32::consts::TAU).sin_cos();
            for reach in [from, to] {
                self.vertices.push(UnitVertex { ring: [cos, sin], reach, part });
            }
        }
        for i in 0..steps as u32 {
            let a = base + 2 * i;
            self.indices.extend([a, a + 2, a + 1, a + 1, a + 2, a + 3]);
        }
    }
}

/// Distance along a ray to a cutter's cylinder, mm; `None` if the ray misses it. Only the stretch `kept` of
/// the ray, mm along it, counts.
pub fn ray_distance(instance: &CutterInstance, ray: &ViewRay, kept: (f32, f32)) -> Option<f32> {
    let axis = Vec3::from_array(instance.axis);
    let from = ray.origin - Vec3::from_array(instance.tip);
    let (along_origin, along_ray) = (from.dot(axis), ray.direction.dot(axis));
    let p = from - axis * along_origin;
    let d = ray.direction - axis * along_ray;
    let r2 = instance.radius * instance.radius;
    let (a, b, c) = (d.dot(d), p.dot(d), p.dot(p) - r2);
    // Interval of the ray inside the infinite cylinder, clipped by the slab between bottom and top.
    let (mut enter, mut leave) = if a > 1e-12 {
        let root = b * b - a * c;
        if root < 0.0 {
            return None;
        }
        ((-b - root.sqrt()) / a, (-b + root.sqrt()) / a)
    } else if c <= 0.0 {
        (f32::NEG_INFINITY, f32::INFINITY)
    } else {
        return None;
    };
    if along_ray.abs() > 1e-9 {
        let (t0, t1) = (-along_origin / along_ray, (instance.height - along_origin) / along_ray);
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    } else if !(0.0..=instance.height).contains(&along_origin) {
        return None;
    }
    let (enter, leave) = (enter.max(kept.0).max(0.0), leave.min(kept.1));
    (enter <= leave && leave > 0.0).then_some(enter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cutter(id: u32, state: CutterState) -> DrawnCutter {
        DrawnCutter {
            instance: CutterInstance {
                axis: [0.0, 0.0, 1.0],
                radius: 5.0,
                core_radius: 2.0,
                height: 60.0,
                state: state as u32,
                id,
                ..Default::default()
            },
            retract: Vec3::new(0.0, 0.0, 60.0),
            section: 0,
            assembly: Arc::new([AssemblyPiece { heights: [40.0, 55.0], radii: [10.0, 10.0] }]),
        }
    }

    #[test]
    fn scrubbing_shows_what_is_cut_and_the_last_at_full_length() {
        let choice = CutterChoice { up_to: Some(3), stub: 0.5, ..Default::default() };
        let heights: Vec<Option<f32>> =
            (0..5).map(|id| choice.instance(&cutter(id, CutterState::Sound)).map(|i| i.height)).collect();
        assert_eq!(heights, [Some(5.0), Some(5.0), Some(60.0), None, None]);
    }

    #[test]
    fn another_channel_shows_its_own_progress() {
        let first = CutterChoice { up_to: Some(1), selected: Some(0), stub: 0.5, ..Default::default() };
        let other = DrawnChannel { turn_rad: std::f32::consts::FRAC_PI_2, up_to: Some(2), has_tool: true };
        let height =
            |choice: &CutterChoice, id| choice.instance(&cutter(id, CutterState::Sound)).map(|i| i.height);
        let shown = |channel: DrawnChannel| [0, 1, 2].map(|id| height(&channel.choice(&first), id));
        assert_eq!(shown(other), [Some(5.0), Some(60.0), None], "none is selected, the last is the tool");
        assert_eq!(shown(DrawnChannel { has_tool: false, ..other }), [Some(5.0), Some(5.0), None]);
        let mut turned = cutter(0, CutterState::Sound);
        turned.instance.tip = [2.0, 0.0, 1.0];
        let turned = turned.turned_z(other.turn_rad.sin_cos());
        assert!(Vec3::from_array(turned.instance.tip).distance(Vec3::new(0.0, 2.0, 1.0)) < 1e-6);
    }

    #[test]
    fn filters_keep_the_faulty_and_never_hide_the_selected() {
        let choice = CutterChoice { filter: CutterFilter::Faulty, stub: 0.5, ..Default::default() };
        assert!(choice.instance(&cutter(0, CutterState::Sound)).is_none());
        assert!(choice.instance(&cutter(1, CutterState::Blocked)).is_some());
        let choice = CutterChoice { filter: CutterFilter::Hidden, selected: Some(7), ..Default::default() };
        let selected = choice.instance(&cutter(7, CutterState::Interfering)).expect("shown");
        assert_eq!(selected.state, CutterState::Selected as u32);
    }

    #[test]
    fn a_ray_meets_the_cylinder_where_it_should() {
        let cutter = cutter(0, CutterState::Sound).instance;
        let ray = |o: [f32; 3], d: [f32; 3]| ViewRay {
            origin: Vec3::from_array(o),
            direction: Vec3::from_array(d).normalize(),
        };
        let whole = (0.0, f32::INFINITY);
        let distance = |o, d| ray_distance(&cutter, &ray(o, d), whole);
        assert_eq!(distance([20.0, 0.0, 10.0], [-1.0, 0.0, 0.0]), Some(15.0));
        assert_eq!(distance([1.0, 1.0, 100.0], [0.0, 0.0, -1.0]), Some(40.0));
        assert_eq!(distance([20.0, 0.0, 70.0], [-1.0, 0.0, 0.0]), None);
        assert_eq!(distance([20.0, 6.0, 10.0], [-1.0, 0.0, 0.0]), None);
        assert_eq!(distance([20.0, 0.0, 10.0], [1.0, 0.0, 0.0]), None);
        let cut = |kept| ray_distance(&cutter, &ray([20.0, 0.0, 10.0], [-1.0, 0.0, 0.0]), kept);
        assert_eq!(cut((18.0, 100.0)), Some(18.0), "from the section plane in it");
        assert_eq!(cut((0.0, 12.0)), None, "before the plane");
    }

    #[test]
    fn the_unit_cutter_has_a_solid_and_a_glass_part() {
        let unit = UnitCutter::new(24);
        assert_eq!(unit.solid, 24 * 3 * 6);
        assert_eq!(unit.indices.len(), 24 * 7 * 6);
        assert!(unit.indices.iter().all(|&i| (i as usize) < unit.vertices.len()));
    }
}
