//! The solid against closed forms, finer models, and itself.

mod surface;
mod unions;

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

use vanecut::geometry::{Meridional, Point, Vector};
use vanecut::mesh::TriangleMesh;
use vanecut::monitor::{Cancelled, Monitor};
use vanecut::setup::Tool;
use vanecut::stock::solid::{
    Contact, Lattice, MAX_RUN, MeshBlank, MeshFault, SolidBlank, SolidError, SolidMove, SolidSegment,
    SolidStock, SolidTool, SpanEnd, StockSurface, ToolPart, ToolPose, TurnedOutline,
};

/// A turned disc of radius 40 between z = 0 and 30.
fn disc() -> SolidBlank {
    let corner = |r: f64, z: f64| Meridional { r, z };
    let points = vec![corner(0.0, 0.0), corner(40.0, 0.0), corner(40.0, 30.0), corner(0.0, 30.0)];
    SolidBlank::Turned(TurnedOutline::new(points))
}

fn tool(diameter: f64, corner_radius: f64) -> Tool {
    Tool {
        number: 1,
        diameter,
        corner_radius,
        insert_width: 0.5 * diameter,
        overhang: 80.0,
        plunge_feed: 300.0,
        spindle: 1000.0,
        assembly: Default::default(),
    }
}

fn pose(tip: [f64; 3], axis: [f64; 3]) -> ToolPose {
    ToolPose { tip: Point::from(tip), axis: Vector::from(axis).normalize() }
}

fn feed(number: u32, from: ToolPose, to: ToolPose) -> SolidMove {
    SolidMove { number, tool: 0, rapid: false, checks_core: true, from, to }
}

/// A plunge along its axis from 60 mm above.
fn plunge(number: u32, to: ToolPose) -> SolidMove {
    feed(number, ToolPose { tip: to.tip + to.axis * 60.0, ..to }, to)
}

fn cut(blank: &SolidBlank, spacing: f64, tool: &Tool, moves: &[SolidMove]) -> (SolidStock, Vec<Contact>) {
    cut_with(blank, spacing, &[SolidTool::from_tool(tool)], moves)
}

fn cut_with(
    blank: &SolidBlank,
    spacing: f64,
    tools: &[SolidTool],
    moves: &[SolidMove],
) -> (SolidStock, Vec<Contact>) {
    let mut stock = SolidStock::new(blank, spacing).expect("it fits");
    let contacts = stock.make_moves(tools, moves, &Monitor::default()).expect("nobody cancels");
    (stock, contacts)
}

/// What moves remove, by the surface of what they leave.
fn removed(blank: &SolidBlank, spacing: f64, tool: &Tool, moves: &[SolidMove]) -> f64 {
    blank.volume() - StockSurface::from_stock(&cut(blank, spacing, tool, moves).0).volume()
}

fn assert_near(what: &str, found: f64, exact: f64, share: f64) {
    assert!((found - exact).abs() <= share * exact, "{what}: {found} instead of {exact}");
}

#[test]
fn blanks_have_the_volume_of_their_outline() {
    let SolidBlank::Turned(outline) = disc() else { unreachable!("it is turned") };
    assert_near("disc", outline.volume(), PI * 1600.0 * 30.0, 1e-9);
    let stock = SolidStock::new(&disc(), 0.25).expect("it fits");
    assert_near("disc, by rays", stock.volume(), outline.volume(), 5e-3);
    assert_near("disc", StockSurface::from_stock(&stock).volume(), outline.volume(), 2e-5);
}

#[test]
fn plunges_remove_what_their_cutters_sweep() {
    let straight = pose([1.0, 2.0, 10.0], [0.0, 0.0, 1.0]);
    let spacing = 0.2;
    for (corner, bottom) in [
        (0.0, 0.0),
        // A ball leaves a cylinder less a half ball; a corner, by Pappus, a square less its quarter disc.
        (8.0, PI * 64.0 * 8.0 - 2.0 / 3.0 * PI * 512.0),
        (2.0, 2.0 * PI * (4.0 * 7.0 - PI * (6.0 + 4.0 * 2.0 / (3.0 * PI)))),
    ] {
        let found = removed(&disc(), spacing, &tool(16.0, corner), &[plunge(0, straight)]);
        assert_near(&format!("corner {corner}"), found, PI * 64.0 * 20.0 - bottom, 1e-3);
    }
    // Tilted by 30°: the ends of the column are cut obliquely, its axis is as long as the mean.
    let tilt = PI / 6.0;
    let through = pose([0.0, 0.0, -20.0], [tilt.sin(), 0.0, tilt.cos()]);
    let found = removed(&disc(), spacing, &tool(10.0, 0.0), &[plunge(0, through)]);
    assert_near("tilted", found, PI * 25.0 * 30.0 / tilt.cos(), 1e-3);
}

#[test]
fn straight_moves_are_exact_whatever_their_direction() {
    // A slot across the disc, and a ramp whose bottom falls by a quarter of its length.
    let axis = [0.0, 0.0, 1.0];
    let slot = feed(0, pose([-60.0, 0.0, 20.0], axis), pose([60.0, 0.0, 20.0], axis));
    let width = |x: f64| 2.0 * (1600.0 - x * x).sqrt();
    let integral = |f: &dyn Fn(f64) -> f64| {
        (0..2000).map(|i| f(-5.0 + (f64::from(i) + 0.5) / 200.0) / 200.0).sum::<f64>()
    };
    let exact = 10.0 * integral(&width);
    assert_near("slot", removed(&disc(), 0.25, &tool(10.0, 0.0), &[slot]), exact, 1e-3);
    let ball = integral(&|y: f64| width(y) * (10.0 - (5.0 - (25.0 - y * y).sqrt())));
    assert_near("ball slot", removed(&disc(), 0.25, &tool(10.0, 5.0), &[slot]), ball, 1e-3);
    let corner = |y: f64| {
        let out = (y.abs() - 3.0).max(0.0);
        2.0 - (4.0 - out * out).sqrt()
    };
    let bull = integral(&|y: f64| width(y) * (10.0 - corner(y)));
    assert_near("bull slot", removed(&disc(), 0.25, &tool(10.0, 2.0), &[slot]), bull, 2e-3);
}

#[test]
fn a_ramp_equals_its_fine_subdivision() {
    let axis = [0.2, -0.1, 1.0];
    for corner in [0.0, 1.5, 4.0] {
        let cutter = tool(8.0, corner);
        let (from, to) = (pose([-30.0, -9.0, 27.0], axis), pose([25.0, 6.0, 14.0], axis));
        let whole = feed(0, from, to);
        let fine: Vec<SolidMove> = (0..300)
            .map(|i| {
                let end = |k: u32| whole.pose(f64::from(k) / 300.0);
                feed(0, end(i), end(i + 1))
            })
            .collect();
        let (one, many) = (cut(&disc(), 0.5, &cutter, &[whole]).0, cut(&disc(), 0.5, &cutter, &fine).0);
        let off = deviation(&one, &many);
        assert!(off < 1e-6 + if corner == 1.5 { 0.05 } else { 0.0 }, "corner {corner}: {off}");
    }
}

/// The rays of a stock: direction, and node of the other two coordinates.
fn rays(stock: &SolidStock) -> impl Iterator<Item = (usize, usize, usize)> {
    let counts = stock.lattice().counts;
    (0..3).flat_map(move |direction| {
        let (a, b) = Lattice::across(direction);
        (0..counts[a]).flat_map(move |u| (0..counts[b]).map(move |v| (direction, u, v)))
    })
}

/// Greatest distance of the surfaces of two stocks, by the stretches of rays that only one of them has. A
/// stretch between both surfaces counts across them; one between two surfaces of the same stock is a corner
/// or a grazed flank, which is flatter than half its length across the steeper side.
fn deviation(one: &SolidStock, other: &SolidStock) -> f64 {
    let mut worst = 0.0f64;
    for (direction, u, v) in rays(one) {
        let mut ends: Vec<(f64, usize, f64)> = Vec::new();
        for (source, stock) in [one, other].into_iter().enumerate() {
            for span in stock.spans(direction, u, v) {
                let across = |end: &SpanEnd| end.normal()[direction].abs();
                ends.push((span.from, source, across(&span.start)));
                ends.push((span.to, source, across(&span.end)));
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut inside = [false; 2];
        for pair in ends.windows(2) {
            inside[pair[0].1] ^= true;
            if inside[0] != inside[1] {
                let across = (pair[1].0 - pair[0].0) * pair[0].2.min(pair[1].2);
                worst = worst.max(if pair[0].1 == pair[1].1 { 0.5 * across } else { across });
            }
        }
    }
    worst
}

#[test]
fn a_move_that_turns_equals_a_hundred_times_finer_one() {
    let spacing = 1.0;
    let turned = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [sin, 0.1, cos]
    };
    for corner in [0.0, 5.0] {
        let whole = feed(0, pose([-18.0, -10.0, 16.0], turned(-10.0)), pose([12.0, 8.0, 18.0], turned(10.0)));
        let steps = 2000;
        let fine: Vec<SolidMove> = (0..steps)
            .map(|i| {
                let end = |k: u32| whole.pose(f64::from(k) / f64::from(steps));
                feed(0, end(i), end(i + 1))
            })
            .collect();
        let cutter = tool(10.0, corner);
        let (one, many) =
            (cut(&disc(), spacing, &cutter, &[whole]).0, cut(&disc(), spacing, &cutter, &fine).0);
        let off = deviation(&one, &many);
        assert!(off <= 0.1 * spacing, "corner {corner}: {off}");
        assert_near("volume", one.volume(), many.volume(), 1e-3);
    }
}

#[test]
fn runs_of_short_cuts_equal_the_cuts_one_by_one() {
    // A pass on an arc with an axis that tilts more and more, in moves of 0.5 mm.
    let spacing = 0.5;
    let at = |k: u32| {
        let turn = f64::from(k) / 60.0;
        let tilt = 0.2 * turn;
        let tip = [30.0 * turn.cos(), 30.0 * turn.sin(), 12.0 - 2.0 * turn];
        pose(tip, [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()])
    };
    let moves: Vec<SolidMove> = (0..60).map(|k| feed(k, at(k), at(k + 1))).collect();
    let bare = [SolidTool { segments: Vec::new(), ..SolidTool::from_tool(&tool(8.0, 2.0)) }];
    let mut whole = SolidStock::new(&disc(), spacing).expect("a stock");
    let mut single = whole.clone();
    whole.make_moves(&bare, &moves, &Monitor::default()).expect("made");
    for step in &moves {
        single.make_moves(&bare, std::slice::from_ref(step), &Monitor::default()).expect("made");
    }
    let off = deviation(&whole, &single);
    assert!(off > 0.0, "runs are used");
    // Runs are within .04 spacings of their cuts, and the pieces of moves that turn within .06 of these.
    assert!(off < 0.16 * spacing, "{off} mm");
}

#[test]
fn assemblies_are_those_of_the_setup() {
    let plain = SolidTool::from_tool(&tool(10.0, 1.0));
    assert_eq!(plain.segments.len(), 1);
    assert_eq!(plain.segments[0].part, ToolPart::Holder);
    let mut described = tool(10.0, 1.0);
    described.assembly.flute_length = Some(15.0);
    described.assembly.shank = vec![[8.0, 20.0]];
    described.assembly.holder = vec![[24.0, 30.0, 12.0], [50.0, 50.0, 20.0]];
    let solid = SolidTool::from_tool(&described);
    assert_eq!(solid.cutting_length, 15.0);
    let parts: Vec<ToolPart> = solid.segments.iter().map(|segment| segment.part).collect();
    assert_eq!(parts, [ToolPart::Shank, ToolPart::Holder, ToolPart::Holder]);
    assert_eq!(solid.segments[1].from, described.overhang);
    assert_eq!((solid.segments[1].lower, solid.segments[1].upper), (12.0, 15.0));
}

/// Plunges all over the disc, tilted in all directions.
fn many_plunges(count: u32) -> Vec<SolidMove> {
    (0..count)
        .map(|i| {
            let angle = 2.4 * f64::from(i);
            let r = 38.0 * (f64::from(i) / f64::from(count)).sqrt();
            let (sin, cos) = angle.sin_cos();
            let axis = [0.4 * (1.7 * angle).cos(), 0.4 * (1.3 * angle).sin(), 1.0];
            plunge(i, pose([r * cos, r * sin, 8.0 + f64::from(i * 7 % 11)], axis))
        })
        .collect()
}

fn ends_of(stock: &SolidStock) -> Vec<(u64, u64)> {
    let spans = rays(stock).flat_map(|(direction, u, v)| stock.spans(direction, u, v));
    spans.map(|span| (span.from.to_bits(), span.to.to_bits())).collect()
}

/// The deepest contact of each move and part, in their order.
fn deepest(contacts: Vec<Contact>) -> Vec<Contact> {
    let mut deepest: BTreeMap<(u32, ToolPart), Contact> = BTreeMap::new();
    for contact in contacts {
        let known = deepest.entry((contact.number, contact.part)).or_insert(contact);
        if contact.depth > known.depth {
            *known = contact;
        }
    }
    deepest.into_values().collect()
}

#[test]
fn the_order_of_plunges_and_the_number_of_threads_do_not_matter() {
    let moves = many_plunges(40);
    let cutter = tool(12.0, 2.0);
    let (first, contacts) = cut(&disc(), 0.7, &cutter, &moves);
    let reversed: Vec<SolidMove> = moves.iter().rev().copied().collect();
    assert_eq!(ends_of(&first), ends_of(&cut(&disc(), 0.7, &cutter, &reversed).0));
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let (alone, same) = single.install(|| cut(&disc(), 0.7, &cutter, &moves));
    assert_eq!(ends_of(&first), ends_of(&alone));
    assert_eq!(first.volume().to_bits(), alone.volume().to_bits());
    assert_eq!(contacts, same);
    let surfaces = [StockSurface::from_stock(&first), single.install(|| StockSurface::from_stock(&alone))];
    assert_eq!(surfaces[0].triangles, surfaces[1].triangles);
    assert_eq!(surfaces[0].points, surfaces[1].points);
}

/// Plunges from which on a state of the stock is kept.
const PLUNGES_UNTIL_KEPT: u32 = 1 << 12;

#[test]
fn a_program_goes_on_from_a_stock_kept_on_the_way() {
    let tools = [SolidTool::from_tool(&tool(10.0, 1.0))];
    let monitor = Monitor::default();
    // The states on the way, and the stock at the end.
    let states = |moves: &[SolidMove]| {
        let mut stock = SolidStock::new(&disc(), 3.0).expect("a stock");
        let mut kept = Vec::new();
        let keep = |made: usize, stock: &SolidStock, contacts: &[Contact]| {
            kept.push((made, stock.clone(), contacts.to_vec()));
        };
        stock.make_moves_from(0, &tools, moves, &monitor, keep).expect("made");
        (kept, stock)
    };
    // Plunges nearly up to the first state, then cuts that form runs, and rapids that meet stock.
    let mut moves = many_plunges(PLUNGES_UNTIL_KEPT);
    moves.truncate(states(&moves).0[0].0 - 4);
    let at =
        |k: u32| pose([-45.0 + 0.25 * f64::from(k % 360), 0.1 * f64::from(k / 90), 6.0], [0.1, 0.0, 1.0]);
    let count = moves.len() as u32;
    moves.extend((0..600).map(|k| {
        let (rapid, step) = (k % 90 == 89, feed(count + k, at(k), at(k + 1)));
        let down = Vector::z() * if rapid { 4.0 } else { 0.0 };
        SolidMove { rapid, to: ToolPose { tip: step.to.tip - down, ..step.to }, ..step }
    }));
    let (mut kept, stock) = states(&moves);
    let (made, mut later, mut contacts) = kept.swap_remove(0);
    assert!(made > count as usize && made + MAX_RUN < moves.len(), "the state is within the runs: {made}");
    // Another program from the first place on that allows it.
    let (head, tail) = moves.split_at(made + MAX_RUN);
    let lifted = |pose: ToolPose| ToolPose { tip: pose.tip + pose.axis * 1.5, ..pose };
    let tail = tail.iter().map(|step| SolidMove { from: lifted(step.from), to: lifted(step.to), ..*step });
    let other: Vec<SolidMove> = head.iter().copied().chain(tail).collect();
    contacts.extend(later.make_moves_from(made, &tools, &other, &monitor, |_, _, _| ()).expect("made"));
    let (whole, all) = cut_with(&disc(), 3.0, &tools, &other);
    assert_eq!(ends_of(&later), ends_of(&whole));
    assert!(contacts.iter().any(|contact| contact.number as usize > made), "also after the state");
    assert_eq!(deepest(contacts), all);
    assert_ne!(ends_of(&stock), ends_of(&whole), "the programs differ");
}

#[test]
fn a_core_is_found_as_deep_as_it_is_in_stock() {
    let cutter = Tool { insert_width: 3.0, ..tool(16.0, 0.0) };
    let spacing = 0.5;
    // In full stock the core meets it over the whole depth, beside a wider hole not at all.
    let first = plunge(3, pose([0.0, 0.0, 12.0], [0.0, 0.0, 1.0]));
    let (_, contacts) = cut(&disc(), spacing, &cutter, &[first]);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    assert_eq!((contacts[0].number, contacts[0].part), (3, ToolPart::Core));
    assert!((contacts[0].depth - 18.0).abs() < 1e-6, "{contacts:?}");
    let wide = SolidTool::from_tool(&tool(30.0, 0.0));
    let tools = [wide, SolidTool::from_tool(&cutter)];
    let second = SolidMove { tool: 1, ..plunge(4, first.to) };
    let (_, contacts) = cut_with(&disc(), spacing, &tools, &[first, second]);
    assert!(contacts.is_empty(), "{contacts:?}");
    let deeper = SolidMove { tool: 1, ..plunge(4, pose([0.0, 0.0, 9.0], [0.0, 0.0, 1.0])) };
    let (_, contacts) = cut_with(&disc(), spacing, &tools, &[first, deeper]);
    assert!((contacts[0].depth - 3.0).abs() < 1e-6, "{contacts:?}");
    // Rounding leaves nothing between the corner and the flank of an inclined cutter.
    let round = [SolidTool::from_tool(&tool(30.0, 0.8)), SolidTool::from_tool(&cutter)];
    for i in 0..40 {
        let axis = [0.01 * f64::from(i), 0.3 - 0.013 * f64::from(i), 1.0];
        let first = plunge(3, pose([1.0, 2.0, 12.0], axis));
        let second = SolidMove { tool: 1, ..plunge(4, first.to) };
        let (_, contacts) = cut_with(&disc(), 1.5, &round, &[first, second]);
        assert!(contacts.is_empty(), "{axis:?}: {contacts:?}");
    }
}

#[test]
fn rapids_and_holders_in_stock_are_found() {
    let axis = [0.0, 0.0, 1.0];
    let short = Tool { overhang: 12.0, ..tool(10.0, 0.0) };
    // The holder, 20 mm wide, comes 6 mm below the top.
    let deep = plunge(1, pose([0.0, 0.0, 12.0], axis));
    let (_, contacts) = cut(&disc(), 0.5, &short, &[deep]);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    assert_eq!(contacts[0].part, ToolPart::Holder);
    assert!((contacts[0].depth - 5.0).abs() < 0.75, "{contacts:?}");
    // A retract in the own hole is free; a rapid across it is not, and removes nothing.
    let back = SolidMove { rapid: true, number: 2, from: deep.to, to: deep.from, ..deep };
    let across = SolidMove { to: pose([20.0, 0.0, 12.0], axis), ..back };
    let cutter = tool(10.0, 0.0);
    assert!(cut(&disc(), 0.5, &cutter, &[deep, back]).1.is_empty());
    let (left, contacts) = cut(&disc(), 0.5, &cutter, &[deep, across]);
    assert_eq!(contacts.iter().map(|c| (c.number, c.part)).collect::<Vec<_>>(), [(2, ToolPart::Cutter)]);
    assert!(contacts[0].depth > 4.0, "{contacts:?}");
    assert_eq!(left.volume(), cut(&disc(), 0.5, &cutter, &[deep]).0.volume());
    let above =
        SolidMove { from: pose([-50.0, 0.0, 30.1], axis), to: pose([50.0, 0.0, 30.1], axis), ..across };
    assert!(cut(&disc(), 0.5, &cutter, &[above]).1.is_empty());
}

#[test]
fn shanks_and_tapers_are_cones() {
    // A cone of half angle 20° plunged to 10 mm below the top, with a tip of 1 mm radius.
    let taper = 20f64.to_radians();
    let cutter =
        SolidTool { taper_rad: taper, cutting_length: 40.0, ..SolidTool::from_tool(&tool(2.0, 0.0)) };
    let top = 1.0 + 10.0 * taper.tan();
    let step = feed(0, pose([0.0, 0.0, 40.0], [0.0, 0.0, 1.0]), pose([0.0, 0.0, 20.0], [0.0, 0.0, 1.0]));
    let bare = [SolidTool { segments: Vec::new(), ..cutter }];
    let surface = StockSurface::from_stock(&cut_with(&disc(), 0.2, &bare, &[step]).0);
    assert_near("cone", disc().volume() - surface.volume(), PI / 3.0 * 10.0 * (1.0 + top + top * top), 2e-3);
    // A shank wider than its cutter rubs where the cutter left too little room.
    let segment = SolidSegment { part: ToolPart::Shank, from: 5.0, length: 50.0, lower: 6.0, upper: 8.0 };
    let thin =
        SolidTool { cutting_length: 5.0, segments: vec![segment], ..SolidTool::from_tool(&tool(8.0, 0.0)) };
    let (_, contacts) =
        cut_with(&disc(), 0.5, &[thin], &[plunge(0, pose([0.0, 0.0, 20.0], [0.0, 0.0, 1.0]))]);
    assert_eq!(contacts.iter().map(|c| c.part).collect::<Vec<_>>(), [ToolPart::Shank]);
}

fn cube(side: f64) -> TriangleMesh {
    let points = (0..8u32).map(|i| Point::from([0, 1, 2].map(|k| side * f64::from(i >> k & 1))));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { points: points.collect(), triangles }
}

#[test]
fn a_closed_mesh_is_a_blank_and_an_open_one_is_not() {
    let mut mesh = cube(20.0);
    let blank = MeshBlank::new(&mesh).expect("it is closed");
    assert_near("cube", blank.volume(), 8000.0, 1e-12);
    let stock = SolidStock::new(&SolidBlank::Mesh(blank), 0.3).expect("it fits");
    let surface = StockSurface::from_stock(&stock);
    assert_near("cube", surface.volume(), 8000.0, 1e-5);
    assert_closed(&surface);
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(MeshBlank::new(&mesh).is_ok(), "inside out is turned round");
    mesh.triangles.pop();
    let fault = MeshBlank::new(&mesh).expect_err("a triangle is missing");
    assert!(matches!(fault, MeshFault::Open { count: 3, .. }), "{fault}");
    mesh.triangles.clear();
    assert_eq!(MeshBlank::new(&mesh).expect_err("nothing is there"), MeshFault::Empty);
}

#[test]
fn impossible_spacings_are_refused() {
    for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(SolidStock::new(&disc(), spacing), Err(SolidError::Spacing(_))), "{spacing}");
    }
    let Err(SolidError::Memory { least, .. }) = SolidStock::new(&disc(), 1e-4) else {
        unreachable!("a tenth of a micrometre does not fit")
    };
    assert!((0.01..0.1).contains(&least), "{least}");
    // So coarse that the disc would be between two rays: nothing would be left of it.
    for spacing in [3.3, 1000.0, 1e300] {
        let Err(error) = SolidStock::new(&disc(), spacing) else { unreachable!("too coarse: {spacing}") };
        let SolidError::Coarse { most, .. } = error else { unreachable!("{spacing}: {error}") };
        assert!((most - 3.2).abs() < 1e-9, "{most}");
        assert!(error.to_string().len() < 100, "{error}");
    }
    let coarse = SolidStock::new(&disc(), 3.2).expect("coarse, but possible");
    let surface = StockSurface::from_stock(&coarse);
    assert_closed(&surface);
    assert_near("coarse disc", surface.volume(), disc().volume(), 0.05);
}

#[test]
fn a_cancelled_run_ends() {
    let monitor = Monitor::default();
    monitor.cancel();
    let mut stock = SolidStock::new(&disc(), 1.0).expect("it fits");
    let tools = [SolidTool::from_tool(&tool(10.0, 0.0))];
    let result = stock.make_moves(&tools, &many_plunges(3), &monitor);
    assert_eq!(result, Err(SolidError::Cancelled(Cancelled)));
}

/// Every edge has one triangle on each side.
fn assert_closed(surface: &StockSurface) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in &surface.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            assert_ne!(a, b);
            *edges.entry((a, b)).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
    }
}
