//! The stock as a solid against the exact contact of cores and against the heightfield, on a sample wheel.

use std::sync::Arc;

use vanecut::geometry::Meridional;
use vanecut::io::part_file::read_part_bytes;
use vanecut::job::{PlanOutcome, PlanRequest, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Blank, Impeller, Workpiece};
use vanecut::setup::{AxisPolicy, Setup, Tool};
use vanecut::stock::excess::Excess;
use vanecut::stock::solid::{
    SolidBlank, SolidProgram, SolidStock, SpanEnd, StockSurface, ToolPart, TurnedOutline,
};
use vanecut::stock::{FloorGrid, field_cutters, residual_field};
use vanecut::toolpath::ClProgram;

/// The axes of a conventional plan, which interferes, with one cutter in one section.
fn planned() -> PlanOutcome {
    let text = include_bytes!("../assets/parts/impeller9x9.toml");
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
    let blank = Blank::of(&outcome.workpiece.part, 0.0);
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
    let surface = StockSurface::of(&stock);
    let hub = outcome.workpiece.part.hub.curve();
    let mut heights = Vec::new();
    let (mut points, mut normals) = (Vec::new(), Vec::new());
    for ((p, n), by) in surface.points.iter().zip(&surface.normals).zip(&surface.cut_by) {
        if *by == SpanEnd::BLANK || n.norm_squared() < 0.5 {
            continue;
        }
        let (t, height) = hub.project(Meridional::of(p));
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
    let text = include_bytes!("../assets/parts/impeller9x9.toml");
    let part = Impeller::build(&read_part_bytes("a.toml", text, "toml").expect("readable")).expect("a wheel");
    let workpiece = Setup::default().allowances.workpiece_of(part);
    let Workpiece { part, channel, .. } = &workpiece;
    let excess = Excess::new(&workpiece);
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
            let m = Meridional::of(&tip);
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
    let text = include_bytes!("data/wheels/kj66_sections.toml");
    let part = Impeller::build(&read_part_bytes("k.toml", text, "toml").expect("readable")).expect("a wheel");
    let wheel = Setup::default().allowances.workpiece_of(part);
    let (excess, shroud) = (Excess::new(&wheel), wheel.part.shroud.curve());
    let steps = || (1..20).map(|k| f64::from(k) / 20.0);
    for pair in wheel.channel.sides.chunks_exact(2) {
        let tips = pair.iter().flat_map(|side| steps().map(|u| side.point(u, 1.0)));
        let highest =
            tips.map(|tip| shroud.project(Meridional::of(&tip)).1).fold(f64::NEG_INFINITY, f64::max);
        for u in steps() {
            let tip = nalgebra::center(&pair[0].point(u, 1.0), &pair[1].point(u, 1.0));
            let at = shroud.at(shroud.project(Meridional::of(&tip)).0);
            let foot = shroud.point(shroud.project(Meridional::of(&tip)).0);
            let by = highest + 0.3;
            let above = Meridional { r: foot.r + at.normal.r * by, z: foot.z + at.normal.z * by };
            let found = excess.at(&above.at_angle(tip.y.atan2(tip.x)));
            assert!(found > 0.0, "u {u}: {found} mm");
        }
    }
}
