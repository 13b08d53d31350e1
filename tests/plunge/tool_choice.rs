//! Automatic choice of tools and sections for real parts.

use vanecut::error::ErrorCode;
use vanecut::io::part_file::read_part_bytes;
use vanecut::io::tool_library::plunge_cutters;
use vanecut::job::{PlanRequest, resolve, run};
use vanecut::monitor::Monitor;
use vanecut::part::{Channel, Impeller, PassageWidth};
use vanecut::plunge::sections;
use vanecut::plunge::sections::Resolved;
use vanecut::setup::{AxisPolicy, SectionKind, SectionSetup, Setup, SetupPlace, Tool};

use super::samples::{SAMPLES, sample, sample_path};

/// The part described by a TOML text.
fn part_of(text: &str) -> Impeller {
    let description = read_part_bytes("part.toml", text.as_bytes(), "toml").expect("readable");
    Impeller::build(&description).expect("an impeller")
}

fn chosen(part: &Impeller, setup: &Setup) -> Resolved {
    resolve(setup, &setup.allowances.workpiece_of(part.clone())).expect("tools and sections")
}

/// Diameters in the order of cutting, mm.
fn diameters(resolved: &Resolved) -> Vec<f64> {
    resolved.setup.tools.iter().map(|tool| tool.diameter).collect()
}

fn tool(number: u32, diameter: f64) -> Tool {
    Tool {
        number,
        diameter,
        corner_radius: 0.0,
        insert_width: 0.3 * diameter,
        overhang: 120.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    }
}

#[test]
fn every_chosen_tool_fits_the_samples() {
    for name in SAMPLES {
        let part = sample(name);
        let channel = Channel::from_part(&part);
        let resolved = chosen(&part, &Setup::default());
        let setup = &resolved.setup;
        assert!((1..=4).contains(&setup.tools.len()), "{name}: {:?}", diameters(&resolved));
        assert!(diameters(&resolved).is_sorted_by(|a, b| a > b), "{name}: large to small");
        let (rest, sections): (Vec<_>, Vec<_>) =
            setup.plunge.sections.iter().partition(|section| section.kind == SectionKind::Rest);
        assert_eq!(
            (sections[0].from, sections[sections.len() - 1].to),
            (1.0, 0.0),
            "{name}: all of the floor"
        );
        assert!(sections.windows(2).all(|pair| pair[0].to == pair[1].from), "{name}: without a gap");
        assert!(resolved.reasons.len() == setup.plunge.sections.len());
        assert!(resolved.reasons.iter().all(Option::is_some));
        for section in sections.into_iter().chain(rest) {
            let tool = setup.tools.iter().find(|tool| tool.number == section.tool).expect("in the setup");
            assert!(plunge_cutters().contains(tool), "{name}: tool {} is from the library", tool.number);
            for i in 0..=10 {
                let s = section.to + (section.from - section.to) * f64::from(i) / 10.0;
                let beside = channel.splitter_s.is_some_and(|[hub, shroud]| s >= hub.min(shroud));
                let passages =
                    if beside { &channel.beside_splitter[..] } else { std::slice::from_ref(&channel.full) };
                for passage in passages {
                    let width = PassageWidth::new(&part, passage).min_width(s);
                    // 1 mm less, because passages may be narrower between the stations that the choice
                    // examines.
                    assert!(
                        width - 1.0 > 1.1 * tool.diameter,
                        "{name}: D {} at s = {s}: {width}",
                        tool.diameter
                    );
                    let end = |eta: f64| passage.point(&part, s, 0.5, eta).expect("inside the channel").point;
                    let depth = (end(1.0) - end(0.0)).norm();
                    assert!(tool.overhang > depth + 2.0, "{name}: D {} at s = {s}: {depth}", tool.diameter);
                }
            }
        }
    }
}

/// At the narrowest place of the channel a cutter of the whole free width cannot tilt, and one of less than
/// half of it needs a third row where a larger one needs two.
#[test]
fn fewer_blades_get_larger_cutters() {
    let text = std::fs::read_to_string(sample_path("impeller532")).expect("readable");
    let open = text.replace("blades = 17", "blades = 11");
    assert_ne!(text, open, "the part has 17 blades");
    let mut setup = Setup::default();
    setup.plunge.rest = false;
    let cutters = |text: &str| {
        let part = part_of(text);
        let channel = Channel::from_part(&part);
        let passage = PassageWidth::new(&part, &channel.full);
        let width = (0..=50).map(|i| passage.min_width(f64::from(i) / 50.0)).fold(f64::INFINITY, f64::min);
        let free = width - 2.0 * setup.allowances.blade_allowance;
        let diameters = diameters(&chosen(&part, &setup));
        let smallest = *diameters.last().expect("a cutter");
        assert!((0.5 * free..free).contains(&smallest), "D {smallest} in {free} mm");
        diameters
    };
    let (narrow, wide) = (cutters(&text), cutters(&open));
    assert!(wide.last() > narrow.last() && wide.first() >= narrow.first(), "{narrow:?}, then {wide:?}");
}

#[test]
fn tools_of_the_setup_are_the_only_ones_chosen_from() {
    let part = sample("impeller532");
    let setup = Setup { tools: vec![tool(3, 9.0), tool(7, 20.0), tool(8, 70.0)], ..Setup::default() };
    let resolved = chosen(&part, &setup);
    assert_eq!(resolved.setup.tools, setup.tools, "the list stays as it was given");
    let numbers = |rest: bool| -> Vec<u32> {
        let sections = resolved
            .setup
            .plunge
            .sections
            .iter()
            .filter(|section| (section.kind == SectionKind::Rest) == rest);
        sections.map(|section| section.tool).collect()
    };
    assert_eq!(numbers(false), [7, 3], "both that fit");
    assert_eq!(numbers(true), [3], "and what the larger leaves is for the smaller");
}

#[test]
fn sections_of_the_setup_stay_and_have_no_reason() {
    let part = sample("impeller532");
    let given = chosen(&part, &Setup::default()).setup;
    let again = chosen(&part, &given);
    assert_eq!(again.setup, given, "nothing is left to choose");
    assert!(again.reasons.iter().all(Option::is_none), "{:?}", again.reasons);
}

#[test]
fn very_many_places_ask_for_a_larger_cutter() {
    let text = std::fs::read_to_string(sample_path("pump6")).expect("readable");
    // The largest cutter as a share of the width between the allowances at the outlet.
    let share = |blades: u32| {
        let part = part_of(&text.replace("blades = 6", &format!("blades = {blades}")));
        let Resolved { setup, .. } = chosen(&part, &Setup::default());
        let channel = Channel::from_part(&part);
        let passage = PassageWidth::new(&part, &channel.full);
        let widths = (35..=50).map(|i| passage.min_width(f64::from(i) / 50.0));
        let free = widths.fold(f64::INFINITY, f64::min) - 2.0 * setup.allowances.blade_allowance;
        setup.tools.iter().map(|tool| tool.diameter).fold(0.0, f64::max) / free
    };
    let [few, many] = [12, 29].map(share);
    assert!(few <= 0.66, "three rows fit: {few}");
    assert!(0.66 < many && many <= 0.86, "two rows fit, but not three: {many}");
}

#[test]
fn a_library_of_wide_cutters_only_is_refused_in_one_line() {
    let part = sample("pump6");
    let workpiece = Setup::default().allowances.workpiece_of(part);
    let fault = sections::resolve(&Setup::default(), &[tool(1, 220.0)], &workpiece, None).unwrap_err();
    assert!(matches!(fault.place, SetupPlace::Section { index: 0, tool: 1 }), "{fault}");
    let given = Setup { tools: vec![tool(1, 220.0)], ..Setup::default() };
    let fault = resolve(&given, &workpiece).unwrap_err();
    assert_eq!(fault.code, ErrorCode::CutterTooWide, "{fault}");
    assert!(fault.help.starts_with("use a cutter of at most D "), "{fault}");
}

#[test]
fn a_cutter_that_fits_part_of_its_section_is_planned_there() {
    let part = sample("impeller532");
    // Wider than the channel at the leading edge, but much narrower than at the rim.
    let mut setup = Setup { tools: vec![tool(1, 30.0)], ..Setup::default() };
    let section = SectionSetup { tool: 1, from: 1.0, to: 0.0, cut_direction: None, kind: SectionKind::Rows };
    setup.plunge.sections = vec![section];
    let channel = Channel::from_part(&part);
    let width = PassageWidth::new(&part, &channel.full).min_width(0.0);
    assert!(width < 30.0 + 2.0 * setup.allowances.blade_allowance, "too narrow at the leading edge: {width}");
    let request = PlanRequest {
        part: part.into(),
        setup,
        policy: AxisPolicy::Minimal,
        compare: false,
        field_cells: 64,
    };
    let outcome = run(&request, &Monitor::default()).expect("planned where it fits");
    let plan = &outcome.after.plan;
    assert!(plan.positions.len() > 50, "{} positions", plan.positions.len());
    assert!(plan.dropped.iter().any(|dropped| dropped.s < 0.3), "what it cannot reach is listed");
    assert!(outcome.after.summary.uncut_share > 0.01, "and counted");
}

#[test]
fn defaults_follow_the_size_of_the_wheel() {
    for name in SAMPLES {
        assert_eq!(Setup::for_part(&sample(name)), Setup::default(), "{name} is of usual size");
    }
    let mut before = 0.0;
    for scale in [2.0, 10.0, 40.0, 100.0] {
        let part = wheel(scale);
        let setup = Setup::for_part(&part);
        let stock = &setup.allowances;
        assert!(stock.safety_distance > before, "scale {scale}: {stock:?}");
        before = stock.safety_distance;
        assert!(stock.blade_allowance > 0.0 && stock.hub_allowance > 0.0, "scale {scale}: {stock:?}");
        let channel = Channel::from_part(&part);
        let narrowest = PassageWidth::new(&part, &channel.full);
        let width = (0..=20).map(|i| narrowest.min_width(f64::from(i) / 20.0)).fold(f64::INFINITY, f64::min);
        assert!(stock.blade_allowance <= 0.11 * width, "scale {scale}: {stock:?} in {width} mm");
        // The defaults find cutters on wheels of every size.
        assert!(!diameters(&chosen(&part, &setup)).is_empty(), "scale {scale}");
    }
}

/// A wheel with a diameter of 8 × `scale`, mm.
fn wheel(scale: f64) -> Impeller {
    let points = |points: [[f64; 2]; 4]| points.map(|[r, z]| [scale * r, scale * z]);
    let hub = points([[0.8, 0.0], [0.8, 1.4], [1.6, 2.4], [4.0, 2.6]]);
    let shroud = points([[2.0, 0.0], [2.0, 1.0], [2.6, 2.0], [4.0, 2.1]]);
    let thickness = [0.1 * scale, 0.08 * scale];
    let span = |span: f64, angles: [f64; 2]| {
        format!(
            "[[main.span]]\nspan = {span:?}\nleading_edge = 0.1\nangle = [[0.0, {:?}], [1.0, {:?}]]\n\
             thickness = [[0.0, {:?}], [1.0, {:?}]]\n",
            angles[0], angles[1], thickness[0], thickness[1]
        )
    };
    part_of(&format!(
        "name = \"wheel\"\nblades = 7\n[hub]\ncontrol = {hub:?}\n[shroud]\ncontrol = {shroud:?}\n{}{}",
        span(0.0, [20.0, 35.0]),
        span(1.0, [40.0, 40.0])
    ))
}

#[test]
fn tiny_and_huge_wheels_find_cutters_too() {
    let mut before = 0.0;
    for scale in [1.0, 10.0, 100.0, 500.0] {
        let mut setup = Setup::default();
        setup.allowances.blade_allowance = 0.01 * scale;
        setup.allowances.hub_allowance = 0.01 * scale;
        let found = diameters(&chosen(&wheel(scale), &setup));
        assert!(found[0] > before, "scale {scale}: {found:?}");
        before = found[0];
    }
}

/// Ten blades and splitters turned by `turn` degrees from them at the inlet: well inside the channel at -30,
/// a millimetre off a blade at -18.
fn with_splitters_at(turn: f64) -> Impeller {
    let blade = |kind: &str, leading_edge: f64, theta: f64| {
        let span = |span: f64, angle: f64, thickness: [f64; 2]| {
            format!(
                "[[{kind}.span]]\nspan = {span:?}\nleading_edge = {leading_edge}\n\
                 theta_leading_edge = {theta}\nangle = [[0.0, {angle}], [1.0, -36.5]]\n\
                 thickness = [[0.0, {}], [1.0, {}]]\n",
                thickness[0], thickness[1]
            )
        };
        span(0.0, -26.5, [1.9, 1.4]) + &span(1.0, -52.8, [0.7, 0.95])
    };
    part_of(&format!(
        "name = \"close\"\nblades = 10\n\
         [hub]\ncontrol = [[22.5, 0], [22.5, 45.5], [52.9, 73.3], [98.5, 73.3]]\n\
         [shroud]\ncontrol = [[50.3, 0], [50.3, 40.6], [67.2, 65.4], [98.5, 65.4]]\n{}{}",
        blade("main", 0.06, 0.0),
        blade("splitter", 0.42, turn)
    ))
}

/// A cutter for a passage of one millimetre would take tens of thousands of plunges in the wide one beside
/// it.
#[test]
fn a_splitter_close_to_a_blade_does_not_make_the_cutters_of_the_wide_passage_tiny() {
    let narrowest = |part: &Impeller| {
        let passages = Channel::from_part(part).beside_splitter;
        passages.iter().map(|p| PassageWidth::new(part, p).min_width(0.9)).fold(f64::INFINITY, f64::min)
    };
    let names_narrow = |resolved: &Resolved| {
        resolved.reasons.iter().flatten().any(|reason| reason.contains("without regard to a passage"))
    };
    let (inside, close) = (with_splitters_at(-30.0), with_splitters_at(-18.0));
    assert!(narrowest(&close) < 1.5 && narrowest(&inside) > 5.0);
    let resolved = chosen(&close, &Setup::default());
    assert!(diameters(&resolved).iter().all(|&diameter| diameter > 2.0), "{:?}", diameters(&resolved));
    assert!(names_narrow(&resolved), "{:?}", resolved.reasons);
    let resolved = chosen(&inside, &Setup::default());
    assert!(!names_narrow(&resolved), "every passage counts: {:?}", resolved.reasons);
}

/// A wheel whose walls lean so far at the rim that they come close there; its channels are 60 mm and more
/// deep.
const CLOSE_AT_THE_RIM: &str = r#"
name = "close"
blades = 11
[hub]
control = [[30.15, 0], [30.15, 58.05], [77.29, 93.63], [148, 93.63]]
[shroud]
control = [[90.89, 0], [90.89, 50.03], [110.88, 80.7], [148, 80.7]]
[[main.span]]
span = 0.0
leading_edge = 0.06
theta_leading_edge = 0.0
angle = [[0.0, 31.08], [1.0, 29.44]]
thickness = [[0.0, 2.84], [1.0, 2.13]]
[[main.span]]
span = 1.0
leading_edge = 0.06
theta_leading_edge = 0.0
angle = [[0.0, 49.74], [1.0, 29.44]]
thickness = [[0.0, 1.07], [1.0, 1.42]]
[[splitter.span]]
span = 0.0
leading_edge = 0.42
theta_leading_edge = 16.364
angle = [[0.0, 31.08], [1.0, 29.44]]
thickness = [[0.0, 2.84], [1.0, 2.13]]
[[splitter.span]]
span = 1.0
leading_edge = 0.42
theta_leading_edge = 16.364
angle = [[0.0, 49.74], [1.0, 29.44]]
thickness = [[0.0, 1.07], [1.0, 1.42]]
"#;

#[test]
fn walls_close_to_each_other_at_the_rim_do_not_make_cutters_too_short_for_the_inlet() {
    let part = part_of(CLOSE_AT_THE_RIM);
    let resolved = chosen(&part, &Setup::default());
    let innermost = resolved.setup.plunge.sections.iter().find(|section| section.to == 0.0);
    let number = innermost.expect("a section at the inlet").tool;
    let tool = resolved.setup.tools.iter().find(|tool| tool.number == number).expect("its tool");
    let depth = part.hub.point(0.0).distance(part.shroud.point(0.0));
    assert!(tool.overhang >= depth, "D {}, {} mm long, in {depth} mm", tool.diameter, tool.overhang);
}

#[test]
fn a_tool_whose_holder_is_in_the_way_is_not_chosen() {
    let part = sample("impeller532");
    let mut setup = Setup { tools: vec![tool(1, 20.0), tool(2, 20.0)], ..Setup::default() };
    setup.plunge.rest = false;
    let used = |setup: &Setup| {
        let mut numbers: Vec<u32> =
            chosen(&part, setup).setup.plunge.sections.iter().map(|section| section.tool).collect();
        numbers.dedup();
        numbers
    };
    (setup.tools[0].overhang, setup.tools[1].overhang) = (90.0, 160.0);
    assert_eq!(used(&setup), [1], "the shorter one is long enough");
    // A holder as wide as the channel begins where the flutes of that tool end.
    setup.tools[0].assembly.flute_length = Some(20.0);
    setup.tools[0].assembly.shank = vec![[160.0, 70.0]];
    assert_eq!(used(&setup), [2], "its shank does not pass between the blades");
    let with_reason = Setup { tools: vec![setup.tools[0].clone()], ..setup.clone() };
    let reasons = chosen(&part, &with_reason).reasons;
    let reason = reasons[0].as_deref().expect("a reason");
    assert!(reason.contains("shank or holder"), "{reason}");
}

/// On a machine the choice counts its tool changes, and the accelerations of each plunge.
#[test]
fn tools_are_chosen_by_their_times_on_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.toml");
    let part = sample("impeller532");
    let text = include_str!("../../assets/machines/ac-trunnion.toml");
    let chosen_on = |text: &str| -> Vec<u32> {
        std::fs::write(&path, text).unwrap();
        let mut setup = Setup::for_part(&part);
        setup.plunge.rest = false;
        setup.machine.file = Some(path.to_string_lossy().into_owned());
        let setup = chosen(&part, &setup).setup;
        setup.plunge.sections.iter().map(|section| section.tool).collect()
    };
    let usual = chosen_on(text);
    let line = text.lines().find(|line| line.starts_with("tool_change_time")).unwrap();
    let slow = chosen_on(&text.replace(line, "tool_change_time = 9000"));
    assert!(usual.len() > 1 && slow.len() == 1, "{usual:?}, with slow changes {slow:?}");
}

/// The window does not plan again for them.
#[test]
fn a_setup_with_the_tools_that_were_chosen_for_it_resolves_to_itself() {
    for name in SAMPLES {
        let part = sample(name);
        let first = chosen(&part, &Setup::default()).setup;
        assert_eq!(chosen(&part, &first).setup, first, "{name}");
    }
}
