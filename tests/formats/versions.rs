//! Files of earlier versions still open, and mean what they meant.

use std::collections::BTreeSet;
use std::path::Path;

use vanecut::error::ErrorCode;
use vanecut::io::flank_file::read_flank_bytes;
use vanecut::io::plan_file::read_plan_bytes;
use vanecut::io::project_file::read_project_bytes;
use vanecut::io::read_setup_bytes;
use vanecut::monitor::Monitor;
use vanecut::setup::{AxisPolicy, CutDirection, FlankStrategy, Setup};

fn bytes(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/versions").join(name);
    std::fs::read(&path).expect("comes with the tests")
}

/// All files were written from the same setup, by the keys of its first version.
fn check_setup(setup: &Setup) {
    assert_eq!((setup.plunge.axis, setup.plunge.step), (AxisPolicy::Monotone, Some(9.0)));
    assert_eq!(setup.plunge.stepover, Some(18.0));
    assert_eq!(setup.plunge.sections[0].cut_direction, Some(CutDirection::InletToOutlet));
    assert_eq!(setup.flank.scallop_height, 8.0);
}

#[test]
fn setup_of_version_1() {
    let text = bytes("setup-1.toml");
    let setup = read_setup_bytes("setup-1.toml", &text).expect("opens");
    check_setup(&setup);
    let newer = [b"version = 99\n".as_slice(), &text].concat();
    let error = read_setup_bytes("s.toml", &newer).expect_err("of a newer program");
    assert_eq!((error.line, error.code), (1, ErrorCode::NewerFile), "{error}");
}

#[test]
fn plunge_plan_of_version_1() {
    let stored = read_plan_bytes("plan-1.json", &bytes("plan-1.json")).expect("opens");
    check_setup(&stored.setup);
    let plan = &stored.plan;
    assert_eq!((plan.positions.len(), stored.channels, stored.part.name.as_str()), (28, 1, "pump6"));
    let first = &plan.positions[0];
    assert!((first.s - 0.8).abs() < 0.05, "it begins at the inlet end: {}", first.s);
    let interfering = plan.positions.iter().filter(|p| p.evaluation.contact.depth > 0.01).count();
    assert_eq!(interfering, 3);
}

#[test]
fn flank_plan_of_version_1() {
    let stored = read_flank_bytes("flank-1.json", &bytes("flank-1.json")).expect("opens");
    check_setup(&stored.setup);
    assert_eq!((stored.scheme, stored.layers, stored.feed_mm_per_min), (FlankStrategy::Balanced, 2, 307.2));
    assert_eq!(stored.channels, 1);
}

/// Of one channel; files of several came with version 3.
#[test]
fn flank_plan_of_version_2() {
    let stored = read_flank_bytes("flank-2.json", &bytes("flank-2.json")).expect("opens");
    check_setup(&stored.setup);
    assert_eq!((stored.scheme, stored.layers, stored.channels), (FlankStrategy::Balanced, 2, 1));
    let rates: BTreeSet<u64> = stored.moves.iter().map(|step| step.feed_mm_per_min as u64).collect();
    assert!(rates.len() > 2, "each move has a feed rate of its own: {rates:?}");
    let program = stored.program(&Monitor::default()).expect("not cancelled").expect("with its tool");
    assert_eq!(program.moves.len(), stored.moves.len());
    let newer = String::from_utf8(bytes("flank-2.json")).expect("text").replacen(":2,", ":99,", 1);
    let error = read_flank_bytes("flank.json", newer.as_bytes()).expect_err("of a newer program");
    assert_eq!(error.code, ErrorCode::NewerFile, "{error}");
}

#[test]
fn projects_of_versions_1_to_4() {
    for (version, channels) in [(1, 1), (2, 1), (3, 3), (4, 3)] {
        let name = &format!("project-{version}.vanecut");
        let project = read_project_bytes(Path::new(name), &bytes(name)).expect(name);
        check_setup(&project.setup);
        if let Some(set) = project.sets.first() {
            assert_eq!((set.name.as_str(), set.setup.plunge.stepover), ("Wider steps", Some(21.0)));
            assert_eq!((project.chosen.before, project.chosen.position), (true, Some(4)));
        }
        let is_flank = version == 4;
        assert_eq!((project.chosen.channels, project.chosen.flank), (channels, is_flank), "{name}");
        let count =
            project.setup_faults.len() + project.sets.iter().map(|set| set.faults.len()).sum::<usize>();
        assert_eq!(count, usize::from(version == 4), "{name}");
    }
}
