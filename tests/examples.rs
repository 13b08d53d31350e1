//! The programs of `examples/`, run as a reader of the documentation would run them.

#![allow(clippy::disallowed_methods, reason = "tests make and read their own files")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the example `name`, which cargo builds beside the tests.
fn example(name: &str, arguments: &[&Path]) -> Output {
    let binary = Path::new(env!("CARGO_BIN_EXE_vanecut"));
    let folder = binary.parent().expect("binaries are in a folder").join("examples");
    let path = folder.join(name).with_extension(std::env::consts::EXE_EXTENSION);
    Command::new(&path).args(arguments).output().unwrap_or_else(|error| {
        panic!("{}: {error}; `cargo test` builds it, `--test examples` alone does not", path.display())
    })
}

fn part() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller532.toml")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn a_program_is_planned_written_and_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = folder.path().join("plunge.apt");
    let planned = example("plan_and_verify", &[&part(), &program]);
    assert!(planned.status.success(), "{}", text(&planned));
    assert!(text(&planned).contains("plunge.apt: 0 faults"), "{}", text(&planned));
    let judged = example("judge_program", &[&part(), &program]);
    assert_eq!(judged.status.code(), Some(0), "{}", text(&judged));

    // Half a millimetre deeper, every plunge breaks the hub's allowance.
    let lines = std::fs::read_to_string(&program).expect("was written");
    let deeper = lines.replace("CUTTER/", "TRANS/0,0,-0.5\nCUTTER/");
    std::fs::write(&program, deeper).expect("writable");
    let judged = example("judge_program", &[&part(), &program]);
    assert_eq!(judged.status.code(), Some(1), "{}", text(&judged));
    assert!(text(&judged).contains("hub"), "{}", text(&judged));
}

#[test]
fn a_section_is_planned_with_a_tool_of_its_own() {
    let planned = example("own_tools", &[&part()]);
    assert!(planned.status.success(), "{}", text(&planned));
    assert!(text(&planned).contains("plunges with D 16"), "{}", text(&planned));
}
