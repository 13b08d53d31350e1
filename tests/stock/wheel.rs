//! The stock as a solid against the exact contact of cores and against the heightfield, on a sample wheel.

use std::sync::Arc;

use vanecut::geometry::{Meridional, Point, Vector, rotate_z};
use vanecut::io::part_file::read_part_bytes;
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::{BladeSide, Blank, Impeller, Workpiece};
use vanecut::setup::{AxisPolicy, Setup, Tool};
use vanecut::stock::excess::Excess;
use vanecut::stock::solid::{
    SolidBlank, SolidProgram, SolidStock, SpanEnd, StockSurface, ToolPart, TurnedOutline,
};
use vanecut::stock::{FloorGrid, field_cutters, residual_field};
use vanecut::toolpath::ClProgram;

/// The axes of a conventional plan, which interferes, with one cutter in one section.
fn planned() -> PlanOutcome {
    let text = include_bytes!("../../assets/parts/impeller9x9.toml");
    let part = Impeller::build(&read_part_bytes("a.toml", text, "toml").expect("readable")).expect("a wheel");
    let tool = Tool {
        number: 1,
        diameter: 16.0,
        corner_radius: 0.0,
        insert_width: 5.0,
        overhang: 150.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    };
    let mut setup = Setup { tools: vec![tool], ..Setup::default() };
    setup.plunge.sections = vec![vanecut::setup::SectionSetup {
        tool: 1,
        from: 1.0,
        to: 0.5,
        cut_direction: None,
        kind: vanecut::setup::SectionKind::Rows,
    }];
    let request = PlanRequest {
        part: Arc::new(part),
        setup,
        policy: AxisPolicy::Conventional,
        compare: false,
        field_cells: 32,
    };
    run(&request, &Monitor::default()).expect("it can be planned")
}

#[test]
fn contact_and_floor_agree_with_contact_and_heightfield() {
    let outcome = planned();
    let plan = &outcome.before.plan;
    let blank = Blank::from_part(&outcome.workpiece.part, 0.0);
    let outline = SolidBlank::Turned(TurnedOutline::of_blank(&outcome.workpiece.part, &blank));
    let spacing = 0.8;
    let mut stock = SolidStock::new(&outline, spacing).expect("it fits");
    let program = SolidProgram::new(&ClProgram::of_plan("a", plan), &outcome.setup).expect("it has a tool");
    let contacts = stock.make_moves(&program.tools, &program.moves, &Monitor::default()).expect("it ends");
    let cores = || contacts.iter().filter(|contact| contact.part == ToolPart::Core);
    assert!(contacts.iter().all(|c| c.part == ToolPart::Core), "rapids and holders are free: {contacts:?}");

    let (mut deep, mut worst) = (0, 0.0f64);
    for (index, position) in plan.positions.iter().enumerate() {
        // Each plunge is a rapid, the plunge, and a rapid back.
        let found = cores().find(|contact| contact.number as usize == 3 * index + 1);
        worst =
            worst.max((found.map_or(0.0, |contact| contact.depth) - position.evaluation.contact.depth).abs());
        deep += usize::from(position.evaluation.contact.depth > spacing);
    }
    assert!(deep > 10, "only {deep} of {} plunges interfere", plan.positions.len());
    assert!(worst <= 1.5 * spacing, "contact differs by {worst} mm");

    // Vertices on cut floor, against the height of stock at their feet on the hub.
    let surface = StockSurface::from_stock(&stock);
    let hub = outcome.workpiece.part.hub.curve();
    let mut heights = Vec::new();
    let (mut points, mut normals) = (Vec::new(), Vec::new());
    for ((p, n), by) in surface.points.iter().zip(&surface.normals).zip(&surface.cut_by) {
        if *by == SpanEnd::BLANK || n.norm_squared() < 0.5 {
            continue;
        }
        let (t, height) = hub.project(Meridional::from_point(p));
        let angle = p.y.atan2(p.x);
        let normal = hub.at(t).normal.direction_at_angle(angle);
        if height > 0.0 && height < 8.0 && n.dot(&normal) > 0.5 {
            let foot = hub.point(t).at_angle(angle);
            points.push([foot.x as f32, foot.y as f32, foot.z as f32]);
            normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
            heights.push(height);
        }
    }
    let count = points.len();
    assert!(count > 2000, "{count} vertices on the floor");
    let grid = FloorGrid {
        rows: 1,
        columns: count,
        points,
        normals,
        blank_heights: vec![200.0; count],
        areas: vec![1.0; count],
        floor: vec![true; count],
        reachable: vec![true; count],
    };
    let field = residual_field(&grid, &field_cutters(plan));
    let off = |k: usize| f64::from(field.heights[k]) - heights[k];
    // The field keeps the lowest cut: below stock that hangs over a cut it is lower, and never higher.
    let highest = (0..count).map(off).fold(f64::NEG_INFINITY, f64::max);
    assert!(highest <= 0.5 * spacing, "the field is {highest} mm higher");
    let near = (0..count).filter(|&k| off(k) >= -0.5 * spacing).count();
    assert!(near as f64 >= 0.99 * count as f64, "{near} of {count} vertices agree");
}

#[test]
fn excess_is_the_distance_to_hub_and_blades_and_negative_inside_them() {
    let text = include_bytes!("../../assets/parts/impeller9x9.toml");
    let part = Impeller::build(&read_part_bytes("a.toml", text, "toml").expect("readable")).expect("a wheel");
    let workpiece = Setup::default().allowances.workpiece_of(part);
    let Workpiece { part, channel, .. } = &workpiece;
    let excess = Excess::new(&workpiece);
    let all = Excess::new(&workpiece).in_all_channels();
    for by in [2.0, 0.5, 0.0, -0.5] {
        // Above the middle of the hub floor, and beside the middle of every wall, away from its edges.
        let passage = &channel.beside_splitter[0];
        let floor = passage.point(part, 0.8, 0.5, 0.0).expect("in the channel").point;
        let up = part.hub.normal(0.8).direction_at_angle(floor.y.atan2(floor.x));
        assert!(
            (excess.at(&(floor + up * by)) - by).abs() < 1e-6,
            "hub {by}: {}",
            excess.at(&(floor + up * by))
        );
        for channel in 0..part.blade_count {
            let turned = rotate_z(&(floor + up * by), part.pitch() * channel as f64);
            assert!((all.at(&turned) - by).abs() < 1e-6, "hub {by}, channel {channel}: {}", all.at(&turned));
        }
        for (k, side) in channel.sides.iter().enumerate() {
            let (p, by_u, by_v) = side.derivatives(0.5, 0.6);
            let other = channel.sides[k ^ 1].point(0.5, 0.6);
            let normal = by_u.cross(&by_v).normalize();
            let out = if normal.dot(&(other - p)) > 0.0 { -normal } else { normal };
            let found = excess.at(&(p + out * by));
            assert!((found - by).abs() < 1e-3, "side {k}, {by}: {found}");
        }
    }
    // Above the tips, as where a blank that is higher than the shroud was cut down to them.
    for pair in channel.sides.chunks_exact(2) {
        for u in [0.2, 0.5, 0.8] {
            let tip = nalgebra::center(&pair[0].point(u, 1.0), &pair[1].point(u, 1.0));
            let m = Meridional::from_point(&tip);
            let at = part.shroud.curve().project(m).0;
            let foot = part.shroud.curve().point(at);
            let away = part.shroud.curve().at(at).normal;
            for by in [0.3, 2.0] {
                let above = Meridional { r: foot.r + away.r * by, z: foot.z + away.z * by };
                let found = excess.at(&above.at_angle(tip.y.atan2(tip.x)));
                // Beyond the sides prolonged the edge of the tip is the nearest place, a little further.
                assert!((found - by).abs() < 0.1, "tip at {u}, {by}: {found}");
                // A quarter of a pitch beside it no tip is near.
                let between = above.at_angle(tip.y.atan2(tip.x) + 0.25 * part.pitch());
                let found = excess.at(&between);
                assert!(found > by + 2.0, "beside the tip at {u}, {by}: {found}");
            }
        }
    }
}

/// Between the sides of a blade prolonged, wherever the foot on a side lies.
#[test]
fn excess_is_positive_above_tips_that_lie_below_the_shroud() {
    let text = include_bytes!("../data/wheels/kj66_sections.toml");
    let part = Impeller::build(&read_part_bytes("k.toml", text, "toml").expect("readable")).expect("a wheel");
    let wheel = Setup::default().allowances.workpiece_of(part);
    let (excess, shroud) = (Excess::new(&wheel), wheel.part.shroud.curve());
    let steps = || (1..20).map(|k| f64::from(k) / 20.0);
    for pair in wheel.channel.sides.chunks_exact(2) {
        let tips = pair.iter().flat_map(|side| steps().map(|u| side.point(u, 1.0)));
        let highest =
            tips.map(|tip| shroud.project(Meridional::from_point(&tip)).1).fold(f64::NEG_INFINITY, f64::max);
        for u in steps() {
            let tip = nalgebra::center(&pair[0].point(u, 1.0), &pair[1].point(u, 1.0));
            let at = shroud.at(shroud.project(Meridional::from_point(&tip)).0);
            let foot = shroud.point(shroud.project(Meridional::from_point(&tip)).0);
            let by = highest + 0.3;
            let above = Meridional { r: foot.r + at.normal.r * by, z: foot.z + at.normal.z * by };
            let found = excess.at(&above.at_angle(tip.y.atan2(tip.x)));
            assert!(found > 0.0, "u {u}: {found} mm");
        }
    }
}

/// Triangles of a blade as it is drawn: its sides, and the strips between their edges; those of the foot
/// last, and their number.
fn drawn_blade(pair: &[BladeSide]) -> (Vec<[Point; 3]>, usize) {
    let (along, across) = (160, 24);
    // Finer towards both ends.
    let u = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / along as f64).cos();
    let v = |j: usize| j as f64 / across as f64;
    let mut triangles = Vec::new();
    let mut add = |corners: [Point; 4]| {
        let [a, b, c, d] = corners;
        triangles.extend([[a, b, c], [a, c, d]]);
    };
    let [s, p] = [&pair[0], &pair[1]];
    for (i, j) in (0..along).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let (u, v) = ([u(i), u(i + 1)], [v(j), v(j + 1)]);
        add([s.point(u[0], v[0]), s.point(u[1], v[0]), s.point(u[1], v[1]), s.point(u[0], v[1])]);
        add([p.point(u[0], v[0]), p.point(u[0], v[1]), p.point(u[1], v[1]), p.point(u[1], v[0])]);
    }
    for (j, end) in (0..across).flat_map(|j| [(j, 0.0), (j, 1.0)]) {
        let corners =
            [s.point(end, v(j)), p.point(end, v(j)), p.point(end, v(j + 1)), s.point(end, v(j + 1))];
        let [a, b, c, d] = corners;
        add(if end == 1.0 { corners } else { [a, d, c, b] });
    }
    for (v, i) in [1.0, 0.0].into_iter().flat_map(|v| (0..along).map(move |i| (v, i))) {
        let [a, b] = [u(i), u(i + 1)];
        let corners = [s.point(a, v), s.point(b, v), p.point(b, v), p.point(a, v)];
        let [a, b, c, d] = corners;
        add(if v == 1.0 { corners } else { [a, d, c, b] });
    }
    (triangles, 2 * along)
}

/// Distance of a point from a triangle: from its plane, or from its edges.
fn triangle_distance(p: &Point, t: &[Point; 3]) -> f64 {
    let normal = (t[1] - t[0]).cross(&(t[2] - t[0]));
    let edge = |k: usize| (t[k], t[(k + 1) % 3] - t[k]);
    let is_above = (0..3).all(|k| edge(k).1.cross(&(p - edge(k).0)).dot(&normal) >= 0.0);
    if is_above && normal.norm() > 0.0 {
        return (p - t[0]).dot(&normal).abs() / normal.norm();
    }
    let from_edge = |k: usize| {
        let (a, along) = edge(k);
        let share = (p - a).dot(&along) / along.norm_squared().max(1e-30);
        (p - (a + along * share.clamp(0.0, 1.0))).norm()
    };
    from_edge(0).min(from_edge(1)).min(from_edge(2))
}

/// Solid angle of a triangle seen from a point (Van Oosterom and Strackee).
fn solid_angle(p: &Point, t: &[Point; 3]) -> f64 {
    let [a, b, c] = t.map(|q| q - p);
    let (x, y, z) = (a.norm(), b.norm(), c.norm());
    2.0 * a.dot(&b.cross(&c)).atan2(x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
}

/// Around the edges of blades: of tips that are cut at an angle, of blunt ends, and of noses.
#[test]
fn excess_around_blades_is_the_distance_to_them_as_they_are_drawn() {
    let read = |name: &str, bytes: &[u8]| {
        Impeller::build(&read_part_bytes(name, bytes, "toml").expect("readable")).expect("a wheel")
    };
    for (name, bytes) in [
        ("kj66", &include_bytes!("../data/wheels/kj66_sections.toml")[..]),
        ("impeller9x9", &include_bytes!("../../assets/parts/impeller9x9.toml")[..]),
    ] {
        let wheel = Setup::default().allowances.workpiece_of(read(name, bytes));
        let (excess, hub) = (Excess::new(&wheel), wheel.part.hub.curve());
        let mut dice = dice();
        for (number, pair) in wheel.channel.sides.chunks_exact(2).enumerate() {
            let (triangles, foot) = drawn_blade(pair);
            let walls = &triangles[..triangles.len() - foot];
            let (mut inside, mut outside) = (0, 0);
            for k in 0..240 {
                // Near the edge of the tip, near both ends, and anywhere on a side.
                let mut share = || 0.5 + 0.5 * dice();
                let (u, v) = [(share(), 1.0), (1.0, share()), (0.0, share()), (share(), share())][k % 4];
                let off = Vector::new(dice(), dice(), dice()) * 1.5;
                let point = pair[k / 4 % 2].point(u, v) + off;
                let above_hub = hub.project(Meridional::from_point(&point)).1;
                if above_hub < 0.5 {
                    continue;
                }
                let away = walls.iter().map(|t| triangle_distance(&point, t)).fold(f64::INFINITY, f64::min);
                let turns = triangles.iter().map(|t| solid_angle(&point, t)).sum::<f64>().abs();
                let is_inside = turns > 2.0 * std::f64::consts::PI;
                let expected = if is_inside { -away } else { away.min(above_hub) };
                let found = excess.at(&point);
                let at = format!("{name} blade {number}, {off:?} from ({u:.3}, {v:.3})");
                if name == "kj66" {
                    // Its sections are noisy: where they fold a side, the nearest place may be missed.
                    let agree = expected.abs() < 0.15 || expected.signum() == found.signum();
                    assert!(agree, "{at}: {found} instead of {expected}");
                } else {
                    assert!((found - expected).abs() < 0.05, "{at}: {found} instead of {expected}");
                }
                if is_inside { inside += 1 } else { outside += 1 }
            }
            assert!(inside > 30 && outside > 80, "{name}: {inside} inside, {outside} outside");
        }
    }
}

/// Numbers from −1 to 1, the same on every machine.
fn dice() -> impl FnMut() -> f64 {
    let mut state = 17u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
