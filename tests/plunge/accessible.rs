//! Inaccessible floor, compared with a search over the poses of a cutter that would cut a cell.

use std::f64::consts::TAU;

use vanecut::geometry::{CutterSolid, Meridional, Point, Vector, frame_about, wrap_angle};
use vanecut::io::part_file::read_part_bytes;
use vanecut::part::{Impeller, Workpiece, passage_angle};
use vanecut::setup::AllowanceSetup;
use vanecut::stock::{CutterStretch, FloorGrid, FloorSource};

use super::floor::{MAX_TILT, stock};
use super::samples::sample;

const CELLS: usize = 256;
/// Rings of axes, and directions from the centre of the bottom to a cell.
const RINGS: usize = 5;
const DIRECTIONS: usize = 16;
/// Clearance that may be missing, mm.
const TOLERANCE: f64 = 0.02;

/// A wheel whose blades lean by 45° and more at the outlet: its isoparametric axes lean by 60° and more to
/// the hub.
const LEANING_OUTLET: &str = r#"
blades = 9
hub = { control = [[22, -50], [22, -22.5], [44, 0], [80, 0]] }
shroud = { control = [[50, -50], [50, -31], [56, -13.8], [80, -12]] }
[[main.span]]
span = 0
leading_edge = 0.05
angle = [[0, 35], [1, 35]]
thickness = [[0, 2.5], [1, 2.5]]
[[main.span]]
span = 0.5
leading_edge = 0.05
theta_leading_edge = 6.7
angle = [[0, 40], [1, 35]]
thickness = [[0, 2.1], [1, 2.1]]
[[main.span]]
span = 1
leading_edge = 0.05
theta_leading_edge = 13.4
angle = [[0, 45], [1, 35]]
thickness = [[0, 1.7], [1, 1.7]]
"#;

/// A cell of the floor under a blade, and a cutter that is to cut it.
struct CellSearch<'a> {
    workpiece: &'a Workpiece,
    foot: Point,
    normal: Vector,
    /// Height of the stock over the cell, mm.
    height: f64,
    radius: f64,
}

impl CellSearch<'_> {
    /// The isoparametric axis of a cutter between the walls with its tip at `tip`.
    fn isoparametric(&self, tip: &Point) -> Vector {
        let Workpiece { part, channel, .. } = self.workpiece;
        let (pitch, reach) = (part.pitch(), self.radius + stock().blade_allowance);
        let s = part.hub.s_at(part.hub.curve().project(Meridional::from_point(tip)).0);
        let ends = |wall: usize| {
            let inward = reach * pitch.signum() * if wall == 0 { 1.0 } else { -1.0 };
            channel.full.walls[wall].ruling_offset(part, [s, s], inward).expect("a ruling")
        };
        let (low, high) = (ends(0), ends(1));
        let theta = tip.y.atan2(tip.x);
        let share =
            (passage_angle(low[0], theta, pitch) / passage_angle(low[0], high[0], pitch)).clamp(0.0, 1.0);
        let turn = |ends: [f64; 2]| wrap_angle(ends[1] - ends[0]);
        let turn = turn(low) + share * (turn(high) - turn(low));
        let (hub, shroud) = (part.hub.point(s), part.shroud.point(s));
        (shroud.at_angle(theta + turn) - hub.at_angle(theta)).normalize()
    }

    /// Clearance of the cutter with `axis` whose rim, in the direction `phi`, meets the ray of the cell as
    /// low as the hub lets it, mm: negative where it meets a blade, an axis beyond the limit or no stock.
    fn margin(&self, axis: Vector, phi: f64) -> f64 {
        let finished = &self.workpiece.finished;
        let AllowanceSetup { hub_allowance, blade_allowance, .. } = stock();
        let (u, v) = frame_about(&axis);
        let to_rim = (u * phi.cos() + v * phi.sin()) * self.radius;
        let put = |h: f64| {
            let tip = self.foot + self.normal * h - to_rim;
            CutterSolid { tip, axis, radius: self.radius, corner_radius: 0.0 }
        };
        let mut height = hub_allowance;
        let mut over = f64::NEG_INFINITY;
        for _ in 0..6 {
            over = finished.hub_clearance(&put(height)) - hub_allowance;
            height = (height - over).clamp(0.0, self.height);
        }
        let cutter = put(height);
        let tilt = self.isoparametric(&cutter.tip).angle(&axis);
        if tilt > MAX_TILT {
            return -self.radius * (1.0 + tilt - MAX_TILT);
        }
        let beside = finished.blade_clearance_below(&cutter, blade_allowance + 1.0) - blade_allowance;
        if over < -TOLERANCE { beside.min(over) } else { beside }
    }

    /// Whether some pose cuts the cell: a grid of axes, and compass searches from the best ones.
    fn is_cut_by_some_pose(&self) -> bool {
        let middle = self.isoparametric(&self.foot);
        let (x, y) = frame_about(&middle);
        let of = |at: [f64; 3]| self.margin((middle + x * at[0] + y * at[1]).normalize(), at[2]);
        let mut tried = Vec::new();
        for ring in 0..=RINGS {
            let tan = (1.1 * MAX_TILT * ring as f64 / RINGS as f64).tan();
            for k in 0..(4 * ring).max(1) {
                let (sin, cos) = (TAU * k as f64 / (4 * ring).max(1) as f64).sin_cos();
                for direction in 0..DIRECTIONS {
                    let at = [tan * cos, tan * sin, TAU * direction as f64 / DIRECTIONS as f64];
                    let margin = of(at);
                    if margin >= -TOLERANCE {
                        return true;
                    }
                    tried.push((margin, at));
                }
            }
        }
        tried.sort_by(|a, b| b.0.total_cmp(&a.0));
        tried.iter().step_by(4).take(6).any(|&(margin, at)| {
            let (mut here, mut steps) = ((margin, at), [0.12, 0.12, 0.2]);
            while steps[0] > 0.005 && here.0 < -TOLERANCE {
                let mut moved = false;
                for (k, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
                    let mut at = here.1;
                    at[k] += sign * steps[k];
                    let margin = of(at);
                    if margin > here.0 {
                        (here, moved) = ((margin, at), true);
                    }
                }
                if !moved {
                    steps = steps.map(|step| 0.5 * step);
                }
            }
            here.0 >= -TOLERANCE
        })
    }
}

/// Cells under the blades of `part`, evenly spread, of which a cutter of `radius` is said to reach some that
/// no pose cuts, and not to reach some that a pose cuts; and the number of those looked at.
fn disagreeing(part: Impeller, radius: f64, count: usize) -> (usize, usize, usize) {
    let workpiece = stock().workpiece_of(part);
    let cutters = [CutterStretch { from: 1.0, to: 0.0, radius, tool: 1 }];
    let source =
        FloorSource { workpiece: &workpiece, stock: &stock(), cutters: &cutters, max_tilt_rad: MAX_TILT };
    let grid = FloorGrid::new(&source, CELLS);
    let is_under_blade = |&cell: &usize| {
        let row = cell / CELLS * CELLS;
        let outline = grid.blank_heights[row..row + CELLS].iter().copied().fold(0.0, f32::max);
        let height = grid.blank_heights[cell];
        grid.floor[cell] && height < 0.999 * outline && f64::from(height) > stock().hub_allowance
    };
    let under: Vec<usize> = (0..CELLS * CELLS).filter(is_under_blade).collect();
    let (mut unreached, mut reached) = (0, 0);
    let picked: Vec<usize> = (0..count).map(|k| under[(2 * k + 1) * under.len() / (2 * count)]).collect();
    for &cell in &picked {
        let double = |v: [f32; 3]| Vector::from(v.map(f64::from));
        let search = CellSearch {
            workpiece: &workpiece,
            foot: Point::from(double(grid.points[cell])),
            normal: double(grid.normals[cell]),
            height: 0.998 * f64::from(grid.blank_heights[cell]),
            radius,
        };
        match (grid.reachable[cell], search.is_cut_by_some_pose()) {
            (true, false) => unreached += 1,
            (false, true) => reached += 1,
            _ => {}
        }
    }
    (unreached, reached, picked.len())
}

#[test]
fn floor_is_inaccessible_where_no_pose_cuts_it() {
    let leaning = read_part_bytes("leaning.toml", LEANING_OUTLET.as_bytes(), "toml").expect("readable");
    let leaning = Impeller::build(&leaning).expect("a wheel");
    for (part, radius) in [(leaning, 4.0), (sample("pump6"), 6.0)] {
        let name = part.name.clone();
        let (unreached, reached, count) = disagreeing(part, radius, 20);
        let what =
            format!("{name}: of {count} cells {unreached} said to be reached and {reached} not, wrongly");
        assert!(unreached <= 1 && reached <= 1, "{what}");
    }
}
