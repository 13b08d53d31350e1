//! The tiled kernel against the plain definition, in f32 (equal) and in f64 (within tolerance).

use proptest::prelude::*;

use super::*;

/// A saddle of about 60 × 20 mm, far enough from the origin that rounding shows, under a sloped blank.
pub(crate) fn saddle(rows: usize, columns: usize) -> FloorGrid {
    let mut grid = FloorGrid {
        rows,
        columns,
        points: Vec::new(),
        normals: Vec::new(),
        blank_heights: Vec::new(),
        areas: Vec::new(),
        floor: Vec::new(),
        reachable: vec![true; rows * columns],
    };
    for i in 0..rows {
        for j in 0..columns {
            let x = 60.0 * i as f64 / (rows - 1).max(1) as f64 - 30.0;
            let y = 20.0 * j as f64 / (columns - 1).max(1) as f64 - 10.0;
            let z = x * x / 120.0 - y * y / 80.0;
            let normal = nalgebra::Vector3::new(-x / 60.0, y / 40.0, 1.0).normalize();
            grid.points.push([x as f32 + 180.0, y as f32, z as f32 + 40.0]);
            grid.normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
            grid.blank_heights.push((20.0 + 0.2 * x) as f32);
            grid.areas.push(0.2 + 0.001 * (i + j) as f32);
            grid.floor.push((i + 2 * j) % 7 != 0);
        }
    }
    grid
}

pub(crate) fn any_cutter() -> impl Strategy<Value = FieldCutter> {
    let place = (-35.0..35.0, -13.0..13.0, -1.0..4.0);
    let direction = (0.0..0.9_f64, 0.0..6.2_f64);
    let shape = (2.0..8.0, 0.0..0.9, prop_oneof![Just(0.0), 0.02..1.0, Just(1.0)]);
    (place, direction, shape).prop_map(|((x, y, lift), (tilt, turn), (radius, core, corner))| {
        let z = x * x / 120.0 - y * y / 80.0 + lift;
        let axis = [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()];
        FieldCutter {
            tip: [x as f32 + 180.0, y as f32, z as f32 + 40.0],
            radius: radius as f32,
            axis: axis.map(|x| x as f32),
            core_radius: (radius * core) as f32,
            corner_radius: (radius * corner) as f32,
        }
    })
}

/// The definition without tiles, cell by cell.
fn untiled(grid: &FloorGrid, cutters: &[FieldCutter]) -> ResidualField {
    let mut heights = grid.blank_heights.clone();
    let mut traces = vec![TraceSums::default(); cutters.len()];
    let unit = VolumeUnit::from_grid(grid);
    for (trace, cutter) in traces.iter_mut().zip(cutters) {
        let (squared, core) = (cutter.radius * cutter.radius, cutter.core_radius * cutter.core_radius);
        for (cell, height) in heights.iter_mut().enumerate() {
            let meeting = Meeting::new(grid.points[cell], grid.normals[cell], cutter);
            let (mut entry, exit) = meeting.interval(squared);
            if meeting.discriminant(squared) <= 0.0 || entry >= exit || entry >= grid.blank_heights[cell] {
                continue;
            }
            if cutter.corner_radius > 0.0 {
                entry = meeting.corner_entry(entry, cutter);
            }
            let before = *height;
            *height = before.min(entry);
            if grid.floor[cell] {
                let depth = meeting.contact_depth(core, before);
                trace.contact_depth = trace.contact_depth.max(depth);
                trace.contact_cells += u32::from(depth > CONTACT_TOLERANCE);
                trace.swept_cells += u32::from(entry < grid.blank_heights[cell]);
                trace.cut_cells += u32::from(before - *height > CUT_TOLERANCE);
                let units = unit.per_height(grid.areas[cell]);
                trace.removed_units += whole_units_between(before * units, *height * units);
            }
        }
    }
    ResidualField { heights, traces: traces.iter().map(|sums| sums.trace(unit)).collect() }
}

/// Entry height by definition, f64: distance to the grown or shrunk body, first root along the ray by
/// ternary search and bisection. `grow` moves every face of the body outwards.
fn exact_entry(grid: &FloorGrid, cell: usize, cutter: &FieldCutter, grow: f64) -> Option<f64> {
    let vector = |v: [f32; 3]| nalgebra::Vector3::new(v[0].into(), v[1].into(), f64::from(v[2]));
    let (p, n) = (vector(grid.points[cell]), vector(grid.normals[cell]));
    let (tip, axis) = (vector(cutter.tip), vector(cutter.axis).normalize());
    let corner = f64::from(cutter.corner_radius);
    let distance = |h: f64| {
        let q = p + n * h - tip;
        let z = q.dot(&axis);
        let out = (q - axis * z).norm() - (f64::from(cutter.radius) - corner);
        let down = corner - z;
        let outside = out.max(0.0).hypot(down.max(0.0));
        outside + out.max(down).min(0.0) - corner - grow
    };
    if distance(0.0) <= 0.0 {
        return Some(0.0);
    }
    let (mut low, mut high) = (0.0, 200.0);
    for _ in 0..80 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(a) <= distance(b) { high = b } else { low = a }
    }
    if distance(low) > 0.0 {
        return None;
    }
    let (mut outside, mut inside) = (0.0, low);
    for _ in 0..50 {
        let middle = 0.5 * (outside + inside);
        if distance(middle) > 0.0 { outside = middle } else { inside = middle }
    }
    Some(inside)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn tiles_change_nothing(cutters in proptest::collection::vec(any_cutter(), 0..24)) {
        let grid = saddle(53, 37);
        let tiled = residual_field(&grid, &cutters);
        let plain = untiled(&grid, &cutters);
        prop_assert_eq!(&tiled.heights, &plain.heights);
        prop_assert_eq!(&tiled.traces, &plain.traces);
    }

    /// Cells so small that most rows are swept whole, and plunges repeated so that they are passed over.
    #[test]
    fn rows_decided_as_a_whole_change_nothing(
        cutters in proptest::collection::vec(any_cutter(), 1..12),
        again in proptest::collection::vec(0..12_usize, 12),
    ) {
        let grid = saddle(61, 403);
        let repeated = again.iter().map(|k| cutters[k % cutters.len()]);
        let cutters: Vec<_> = cutters.iter().copied().chain(repeated).collect();
        prop_assert_eq!(residual_field(&grid, &cutters), untiled(&grid, &cutters));
    }

    /// However the plunges overlap, each bit of stock is removed once.
    #[test]
    fn removed_volumes_and_what_is_left_make_up_the_blank(
        cutters in proptest::collection::vec(any_cutter(), 1..24),
    ) {
        let grid = saddle(53, 37);
        let volume = |heights: &[f32]| -> f64 {
            let cells = (0..heights.len()).filter(|&cell| grid.floor[cell]);
            cells.map(|cell| f64::from(heights[cell]) * f64::from(grid.areas[cell])).sum()
        };
        let field = residual_field(&grid, &cutters);
        let removed: f64 = field.traces.iter().map(|trace| f64::from(trace.removed_volume)).sum();
        let missing = volume(&grid.blank_heights) - volume(&field.heights);
        prop_assert!((removed - missing).abs() <= 1e-6 * volume(&grid.blank_heights), "{removed} {missing}");
    }

    /// Rays that graze a wall jump between missing and hitting, so the f64 heights of a body grown and
    /// shrunk by a hair enclose the f32 heights.
    #[test]
    fn heights_agree_with_double_precision(cutters in proptest::collection::vec(any_cutter(), 1..6)) {
        let grid = saddle(13, 11);
        let field = residual_field(&grid, &cutters);
        for (cell, &height) in field.heights.iter().enumerate() {
            let bound = |grow: f64| {
                let blank = f64::from(grid.blank_heights[cell]);
                let entries = cutters.iter().filter_map(|c| exact_entry(&grid, cell, c, grow));
                entries.fold(blank, f64::min)
            };
            let (low, high) = (bound(1e-3) - 1e-4, bound(-1e-3) + 1e-4);
            prop_assert!((low..=high).contains(&f64::from(height)), "cell {cell}: {low} {height} {high}");
        }
    }
}

/// A flat floor, 64 × 64 mm in 1 mm cells, under 10 mm of stock.
fn plate() -> FloorGrid {
    let cells = 64 * 64;
    FloorGrid {
        rows: 64,
        columns: 64,
        points: (0..cells).map(|c| [(c / 64) as f32 + 0.5, (c % 64) as f32 + 0.5, 0.0]).collect(),
        normals: vec![[0.0, 0.0, 1.0]; cells],
        blank_heights: vec![10.0; cells],
        areas: vec![1.0; cells],
        floor: vec![true; cells],
        reachable: vec![true; cells],
    }
}

fn vertical(x: f32, y: f32, z: f32) -> FieldCutter {
    FieldCutter { tip: [x, y, z], radius: 8.0, axis: [0.0, 0.0, 1.0], core_radius: 4.0, corner_radius: 0.0 }
}

#[test]
fn a_vertical_plunge_leaves_a_flat_hole() {
    let grid = plate();
    let field = residual_field(&grid, &[vertical(32.0, 32.0, 0.5)]);
    let inside = |cell: usize, r: f32| {
        let p = grid.points[cell];
        (p[0] - 32.0).hypot(p[1] - 32.0) < r
    };
    for (cell, &height) in field.heights.iter().enumerate() {
        assert_eq!(height, if inside(cell, 8.0) { 0.5 } else { 10.0 }, "cell {cell}");
    }
    let count = |r| (0..grid.points.len()).filter(|&c| inside(c, r)).count() as u32;
    let expected = PositionTrace {
        contact_depth: 9.5,
        contact_cells: count(4.0),
        swept_cells: count(8.0),
        cut_cells: count(8.0),
        removed_volume: 9.5 * count(8.0) as f32,
    };
    assert_eq!(field.traces, [expected]);
}

#[test]
fn the_same_plunge_twice_is_an_air_cut_without_contact() {
    let field = residual_field(&plate(), &[vertical(32.0, 32.0, 0.5), vertical(32.0, 32.0, 0.5)]);
    let again = field.traces[1];
    assert_eq!((again.cut_cells, again.contact_cells, again.contact_depth), (0, 0, 0.0));
    assert_eq!(again.removed_volume, 0.0);
    assert_eq!(again.swept_cells, field.traces[0].swept_cells);
}

#[test]
fn a_lower_neighbour_meets_the_step_and_a_higher_one_does_not() {
    // 3 mm beside the first, the core (4 mm) lies wholly on the floor of the first plunge.
    let falling = residual_field(&plate(), &[vertical(29.0, 32.0, 1.0), vertical(32.0, 32.0, 0.7)]);
    assert!((falling.traces[1].contact_depth - 0.3).abs() < 1e-6, "{:?}", falling.traces[1]);
    let rising = residual_field(&plate(), &[vertical(29.0, 32.0, 1.0), vertical(32.0, 32.0, 1.0)]);
    assert_eq!(rising.traces[1].contact_cells, 0);
}

#[test]
fn cells_off_the_floor_have_heights_and_leave_no_trace() {
    let mut grid = plate();
    grid.floor.fill(false);
    let field = residual_field(&grid, &[vertical(32.0, 32.0, 0.5)]);
    assert!(field.heights.contains(&0.5), "heights are computed everywhere");
    assert_eq!(field.traces, [PositionTrace::default()]);
}

#[test]
fn a_ball_leaves_its_sphere() {
    let mut ball = vertical(32.0, 32.0, 0.5);
    ball.corner_radius = 8.0;
    let grid = plate();
    let field = residual_field(&grid, &[ball]);
    for (cell, &height) in field.heights.iter().enumerate() {
        let p = grid.points[cell];
        let r = f64::from(p[0] - 32.0).hypot(f64::from(p[1] - 32.0));
        let sphere = if r < 8.0 { 8.5 - (64.0 - r * r).sqrt() } else { 10.0 };
        assert!((f64::from(height) - sphere).abs() < 1e-3, "cell {cell}: {height} {sphere}");
    }
}

#[test]
fn empty_inputs_give_empty_results() {
    let field = residual_field(&saddle(0, 0), &[vertical(0.0, 0.0, 0.0)]);
    assert_eq!((field.heights.len(), field.traces.len()), (0, 1));
    let grid = plate();
    assert_eq!(residual_field(&grid, &[]).heights, grid.blank_heights);
}
