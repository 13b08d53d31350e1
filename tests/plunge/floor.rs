//! The floor under inclined walls: ray lengths and inaccessible floor, compared with cutters placed in the
//! corner and measured.

use vanecut::geometry::{CutterSolid, Point, Vector, rotate_vector_z, rotate_z, search, wrap_angle};
use vanecut::job::resolve;
use vanecut::monitor::Monitor;
use vanecut::part::{BladeDescription, Impeller, SideProbe, Workpiece};
use vanecut::plunge::Planner;
use vanecut::setup::{AllowanceSetup, AxisPolicy, Setup};
use vanecut::stock::{
    CutterStretch, FloorGrid, FloorObstacle, FloorSource, InaccessibleFloor, field_cutters, residual_field,
    statistics, stretches_of_setup,
};

use super::disc::disc;
use super::samples::sample;

const CELLS: usize = 400;
/// Largest angle of an axis from the isoparametric one, rad.
pub const MAX_TILT: f64 = std::f64::consts::FRAC_PI_4;

pub fn stock() -> AllowanceSetup {
    Setup::default().allowances
}

/// A flat disc with straight radial blades inclined by `lean`, rad, in the circumferential direction: towards
/// the channel at the first wall, away from it at the second.
fn leaning_disc(lean: f64) -> Impeller {
    let side = |y: f64| {
        let section = |z: f64| {
            let point = |k: i32| Point::new(60.0 + 4.5 * f64::from(k), y + z * lean.tan(), z);
            (0..=20).map(point).collect()
        };
        vec![section(-5.0), section(60.0)]
    };
    let blade = BladeDescription::Sections { suction: side(1.5), pressure: side(-1.5), line: 0 };
    disc((50.0, 30.0), 10, blade, Vec::new())
}

fn floor(workpiece: &Workpiece, cutters: &[CutterStretch]) -> FloorGrid {
    FloorGrid::new(&FloorSource { workpiece, stock: &stock(), cutters, max_tilt_rad: MAX_TILT }, CELLS)
}

fn everywhere(radius: f64) -> [CutterStretch; 1] {
    [CutterStretch { from: 1.0, to: 0.0, radius, tool: 1 }]
}

/// A corner of the floor: the cells of a row from one wall on.
struct Bench<'a> {
    workpiece: &'a Workpiece,
    sides: Vec<SideProbe>,
    grid: &'a FloorGrid,
    radius: f64,
}

impl<'a> Bench<'a> {
    fn new(workpiece: &'a Workpiece, grid: &'a FloorGrid, radius: f64) -> Self {
        let sides = workpiece.channel.sides.iter().map(|side| SideProbe::new(side, 0.0, 1.0)).collect();
        Self { workpiece, sides, grid, radius }
    }

    /// Cells of a row, counted from `wall`.
    fn cell(&self, row: usize, wall: usize, k: usize) -> usize {
        row * CELLS + if wall == 0 { k } else { CELLS - 1 - k }
    }

    fn ray(&self, cell: usize) -> (Point, Vector) {
        let double = |v: [f32; 3]| Vector::from(v.map(f64::from));
        (Point::from(double(self.grid.points[cell])), double(self.grid.normals[cell]))
    }

    /// Height at which a ray enters the allowance of a blade, by root search on measured distances; infinite
    /// where it does not below `top`.
    fn underside(&self, cell: usize, top: f64) -> f64 {
        let (foot, normal) = self.ray(cell);
        let clearance = |h: f64| {
            let p = foot + normal * h;
            let near = |side: &SideProbe| side.nearest_to_point(&p).distance;
            self.sides.iter().map(near).fold(f64::INFINITY, f64::min) - stock().blade_allowance
        };
        let steps = 60;
        let at = |k: i32| top * f64::from(k) / f64::from(steps);
        match (0..=steps).find(|&k| clearance(at(k)) < 0.0) {
            None => f64::INFINITY,
            Some(0) => 0.0,
            Some(k) => search::root(clearance, at(k - 1), at(k), 1e-4),
        }
    }

    /// Distance from `wall`, in cells, of the first ray whose stock a cutter removes. The cutter is as near
    /// to the wall as it clears, at `shift` along it, its axis inclined by `lean` across and `slope` along
    /// the wall. `None` where it does not clear.
    fn first_cut(
        &self,
        row: usize,
        wall: usize,
        heights: &[f64],
        [slope, lean, shift]: [f64; 3],
    ) -> Option<f64> {
        let s = self.grid.s_of_row(row);
        let at = |s: f64| {
            let theta = self.workpiece.channel.full.walls[wall]
                .at(&self.workpiece.part, s, 0.0)
                .expect("a wall")
                .theta;
            self.workpiece.part.hub.point(s).at_angle(theta)
        };
        let (foot, normal) = (at(s), self.ray(self.cell(row, wall, 0)).1);
        let along = (at(s + 0.01) - at(s - 0.01)).normalize();
        let into = self.ray(self.cell(row, wall, 20)).0 - foot;
        let across = normal.cross(&along).normalize();
        let across = if across.dot(&into) < 0.0 { -across } else { across };
        let axis = (along * slope + across * lean + normal).normalize();
        let put = |d: f64| {
            let tip = foot + along * shift + across * d;
            let mut cutter = CutterSolid { tip, axis, radius: self.radius, corner_radius: 0.0 };
            for _ in 0..12 {
                cutter.tip += axis * (stock().hub_allowance - self.workpiece.finished.hub_clearance(&cutter));
            }
            cutter
        };
        let clears = |d: f64| self.workpiece.finished.clears(&put(d), stock().blade_allowance);
        let step = 0.1 * self.radius;
        let mut free = (3..40).map(|k| step * f64::from(k)).find(|&d| clears(d))?;
        let mut blocked = free - step;
        for _ in 0..12 {
            let middle = 0.5 * (free + blocked);
            if clears(middle) { free = middle } else { blocked = middle }
        }
        let cutter = put(free);
        let [first, second] = [0, 1].map(|k| self.ray(self.cell(row, wall, k)));
        let turn = wrap_angle(second.0.y.atan2(second.0.x) - first.0.y.atan2(first.0.x));
        let cuts = |cells: f64| {
            let k = (cells as usize).min(heights.len() - 2);
            let height = heights[k] + (heights[k + 1] - heights[k]) * (cells - k as f64);
            let foot = rotate_z(&first.0, turn * cells);
            let entry = cutter.column_interval(self.radius, &foot, &rotate_vector_z(&first.1, turn * cells));
            entry.is_some_and(|(low, high)| high > 0.0 && low < height)
        };
        let first = (1..heights.len()).find(|&k| cuts(k as f64))?;
        let (mut out, mut cut) = (first as f64 - 1.0, first as f64);
        for _ in 0..8 {
            let middle = 0.5 * (out + cut);
            if cuts(middle) { cut = middle } else { out = middle }
        }
        Some(cut)
    }

    /// Distance from the wall, in cells, of the first ray that any cutter position cuts: grid search over
    /// axes and positions, refined by pattern search.
    fn first_cut_by_any(&self, row: usize, wall: usize, heights: &[f64]) -> f64 {
        let of = |x: [f64; 3]| self.first_cut(row, wall, heights, x).unwrap_or(heights.len() as f64);
        let mut best = (heights.len() as f64, [0.0; 3]);
        for slope in [-0.5, -0.25, 0.0, 0.25, 0.5] {
            for lean in 0..12 {
                let x = [slope, 0.08 * f64::from(lean), 0.0];
                best = std::cmp::min_by(best, (of(x), x), |a, b| a.0.total_cmp(&b.0));
            }
        }
        let mut steps = [0.12, 0.04, 0.5 * self.radius];
        while steps[1] > 0.001 {
            let mut improved = false;
            for k in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut x = best.1;
                    x[k] += sign * steps[k];
                    let cells = of(x);
                    if cells < best.0 {
                        (best, improved) = ((cells, x), true);
                    }
                }
            }
            if !improved {
                steps = steps.map(|step| 0.5 * step);
            }
        }
        best.0
    }

    /// Checks undersides and inaccessible floor beside one wall. Returns the width of the floor that remains
    /// uncut beside it, including the allowance, by search and by the masks, mm.
    fn check(&self, row: usize, wall: usize) -> [f64; 2] {
        let width = (self.ray(row * CELLS + 1).0 - self.ray(row * CELLS).0).norm();
        let cells = &self.grid.blank_heights[row * CELLS..(row + 1) * CELLS];
        let outline = f64::from(cells.iter().copied().fold(0.0, f32::max));
        let count = (0..CELLS / 2)
            .find(|&k| {
                let height = self.grid.blank_heights[self.cell(row, wall, k)];
                f64::from(height) >= outline
            })
            .unwrap_or(CELLS / 2);
        let heights: Vec<f64> =
            (0..count).map(|k| self.underside(self.cell(row, wall, k), outline).min(outline)).collect();
        for (k, &height) in heights.iter().enumerate() {
            let tabulated = f64::from(self.grid.blank_heights[self.cell(row, wall, k)]);
            // Beside a wall that is hardly inclined, the height changes much within a cell.
            let slack = 0.05 + 0.2 * (height - if k > 0 { heights[k - 1] } else { 0.0 }).abs();
            assert!(
                (tabulated - height).abs() < slack,
                "row {row} wall {wall} cell {k}: {tabulated} {height}"
            );
        }
        let free = |k: usize| {
            let cell = self.cell(row, wall, k);
            self.grid.floor[cell] && self.grid.reachable[cell]
        };
        let mask = (0..count).find(|&k| free(k)).unwrap_or(count);
        let found = self.first_cut_by_any(row, wall, &heights);
        [(found + 0.5) * width, mask as f64 * width]
    }
}

#[test]
fn the_corner_beside_a_flat_wall_is_as_wide_as_geometry_says() {
    let (lean, radius) = (20f64.to_radians(), 8.0);
    let workpiece = stock().workpiece_of(leaning_disc(lean));
    let grid = floor(&workpiece, &everywhere(radius));
    let AllowanceSetup { hub_allowance, blade_allowance, .. } = stock();
    let row = CELLS / 2;
    // Height of the point of the bottom edge nearest to the wall, with the cutter on the hub's allowance.
    let corner = hub_allowance + 2.0 * radius * lean.sin();
    let wanted = corner * lean.tan() + blade_allowance / lean.cos();
    let bench = Bench::new(&workpiece, &grid, radius);
    let [found, mask] = bench.check(row, 0);
    assert!((mask - wanted).abs() < 0.15, "{mask} mm inaccessible, {wanted} by geometry, {found} by search");
    assert!((found - wanted).abs() < 0.25, "{found} by search, {wanted} by geometry");
    let second: Vec<bool> = (CELLS / 2..CELLS).map(|j| grid.reachable[row * CELLS + j]).collect();
    assert!(second.iter().all(|&reachable| reachable), "the second wall leans away");
}

#[test]
fn upright_walls_leave_all_floor_in_reach() {
    let workpiece = stock().workpiece_of(leaning_disc(0.0));
    let grid = floor(&workpiece, &everywhere(8.0));
    assert!(grid.reachable.iter().all(|&reachable| reachable));
    for row in 0..CELLS {
        let cells = row * CELLS..(row + 1) * CELLS;
        let outline = grid.blank_heights[cells.start + CELLS / 2];
        assert!(cells.into_iter().all(|k| !grid.floor[k] || grid.blank_heights[k] == outline), "row {row}");
    }
}

#[test]
fn larger_cutters_leave_more_and_none_excuse_nothing() {
    let workpiece = stock().workpiece_of(leaning_disc(0.3));
    let out = |cutters: &[CutterStretch]| {
        floor(&workpiece, cutters).reachable.iter().filter(|&&reachable| !reachable).count()
    };
    let grid = floor(&workpiece, &[]);
    let bare = grid.blank_heights.iter().map(|&height| f64::from(height) <= stock().hub_allowance);
    let bare: Vec<bool> = bare.zip(&grid.floor).map(|(bare, &floor)| bare && floor).collect();
    let out_of_reach: Vec<bool> = grid.reachable.iter().map(|reachable| !reachable).collect();
    assert_eq!(out_of_reach, bare, "without a cutter only floor that holds no more than the allowance");
    assert!(out(&everywhere(4.0)) > 0 && out(&everywhere(8.0)) > out(&everywhere(4.0)));
    let both = [everywhere(8.0)[0], everywhere(4.0)[0]];
    assert_eq!(out(&both), out(&everywhere(4.0)), "the smaller of two that work in the same place counts");
}

#[test]
fn twisted_walls_agree_with_cutters_put_into_their_corners() {
    let wheel = sample("impeller9x9");
    let pump = sample("pump6");
    let large = sample("impeller532");
    for (part, radius, wall, s) in [
        (&wheel, 6.0, 0, 0.25),
        (&wheel, 6.0, 0, 0.7),
        (&wheel, 6.0, 1, 0.25),
        (&pump, 6.0, 0, 0.5),
        (&large, 15.0, 0, 0.5),
        (&large, 15.0, 1, 0.9),
    ] {
        let workpiece = stock().workpiece_of(part.clone());
        let grid = floor(&workpiece, &everywhere(radius));
        let bench = Bench::new(&workpiece, &grid, radius);
        let [found, mask] = bench.check((s * CELLS as f64) as usize, wall);
        // At most two cells more. Less is on the safe side; the masks neglect terms beyond the second order.
        let what =
            format!("{} s {s} wall {wall}: inaccessible {found:.2} mm by search, {mask:.2}", part.name);
        assert!((found - 0.5..found + 0.3).contains(&mask), "{what}");
    }
}

#[test]
fn the_causes_of_inaccessible_floor_add_up() {
    let share_of = |parts: &[InaccessibleFloor]| parts.iter().map(|part| part.share).sum::<f64>();
    let parts_of = |name: &str, radius: f64| {
        let workpiece = stock().workpiece_of(sample(name));
        let cutters = everywhere(radius);
        let source =
            FloorSource { workpiece: &workpiece, stock: &stock(), cutters: &cutters, max_tilt_rad: MAX_TILT };
        let (grid, parts) = FloorGrid::with_causes(&source, CELLS);
        let none = vec![0.0; CELLS * CELLS];
        let share = f64::from(statistics(&grid, &none, |_| true).unreachable_share);
        (parts, share)
    };
    let (pump, share) = parts_of("pump6", 6.0);
    assert!(share > 0.01 && (share_of(&pump) - share).abs() < 1e-5, "{pump:?} of {share}");
    assert_eq!(pump[0].obstacle, FloorObstacle::SuctionSide, "its blades lean that way: {pump:?}");
    assert!(pump.iter().all(|part| part.diameter == 12.0 && part.to < part.from), "{pump:?}");
    // A wheel with splitters.
    let (wheel, share) = parts_of("impeller9x9", 6.0);
    assert!((share_of(&wheel) - share).abs() < 1e-5, "{wheel:?} of {share}");
    let of_splitters = [FloorObstacle::SplitterSuctionSide, FloorObstacle::SplitterPressureSide];
    assert!(wheel.iter().any(|part| of_splitters.contains(&part.obstacle)), "{wheel:?}");
    let smaller = parts_of("impeller9x9", 3.0).0;
    assert!(share_of(&smaller) < 0.7 * share_of(&wheel), "a smaller cutter reaches further");
}

#[test]
fn no_plan_cuts_what_is_out_of_reach() {
    // A smaller cutter for rest milling would cut floor that is inaccessible to the others.
    let mut asked = Setup::default();
    asked.plunge.rest = false;
    let workpiece = asked.allowances.workpiece_of(sample("impeller9x9"));
    let setup = resolve(&asked, &workpiece).expect("a setup").setup;
    let planner = Planner::new(&workpiece, &setup);
    let grid = floor(&workpiece, &stretches_of_setup(&setup));
    let out = |k: &usize| grid.floor[*k] && !grid.reachable[*k];
    assert!((0..CELLS * CELLS).filter(out).count() > CELLS * CELLS / 50);
    for policy in [AxisPolicy::Conventional, AxisPolicy::Minimal] {
        let plan = planner.plan(policy, &Monitor::default()).expect("a plan");
        let heights = residual_field(&grid, &field_cutters(&plan)).heights;
        let cut = |k: &usize| heights[*k] < grid.blank_heights[*k] - 0.02;
        let count = (0..CELLS * CELLS).filter(|k| out(k) && cut(k)).count();
        // Beside the nose, where the wall is extrapolated, the border may be off by a cell.
        assert!(count * 10_000 < CELLS * CELLS, "{count} cells by {policy:?}");
    }
}
