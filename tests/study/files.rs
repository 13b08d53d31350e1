//! Study files: what they list, and what is refused.

use std::path::{Path, PathBuf};

use vanecut::error::ErrorCode;
use vanecut::study::{RunList, StudyFile};

fn parts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts")
}

fn list(text: &str) -> Result<RunList, String> {
    let file = StudyFile::read_bytes("s.toml", text.as_bytes(), &parts()).map_err(|e| e.to_string())?;
    RunList::from_file(file).map_err(|e| e.to_string())
}

const SAMPLE: &str = r#"parts = ["pump6.toml"]
[setup]
stock.hub_allowance = 0.4
[[setup.tool]]
number = 3
diameter = 20
[[axis]]
key = "policy"
values = ["conventional", "monotone"]
[[axis]]
key = "plunge.step"
values = [6, 8, 10]
[[axis]]
key = "tool.3.diameter"
range = [16, 20, 4]
[[exclude]]
policy = "monotone"
plunge.step = [6, 8.0]
"#;

/// Values of a run, without its part.
fn shown(list: &RunList) -> Vec<String> {
    let row =
        |choice: &[u32]| list.values(choice).iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    list.runs.iter().map(|run| row(&run.choice)).collect()
}

#[test]
fn every_combination_that_is_not_excluded_is_a_run() {
    let study = list(SAMPLE).unwrap();
    assert_eq!(study.keys(), ["plunge.axis", "plunge.step", "tool.3.diameter"]);
    assert_eq!(
        shown(&study),
        [
            "conventional 6 16",
            "conventional 6 20",
            "conventional 8 16",
            "conventional 8 20",
            "conventional 10 16",
            "conventional 10 20",
            "monotone 10 16",
            "monotone 10 20",
        ]
    );
    let input = study.input(&study.runs[2].choice);
    let setup = input.setup.unwrap();
    assert_eq!((setup.plunge.step, setup.tools[0].diameter), (Some(8.0), 16.0));
    assert_eq!(setup.allowances.hub_allowance, 0.4);
}

#[test]
fn names_of_runs_follow_the_whole_input_and_nothing_else() {
    let ids = |text: &str| list(text).unwrap().runs.iter().map(|run| run.id.clone()).collect::<Vec<_>>();
    let first = ids(SAMPLE);
    // The same settings written in another way.
    assert_eq!(first, ids(&SAMPLE.replace("[6, 8, 10]", "[6.0, 8.0, 10.0]")));
    assert_eq!(first, ids(&SAMPLE.replace("range = [16, 20, 4]", "values = [16, 20]")));
    // A value more leaves the names of the others.
    let more = ids(&SAMPLE.replace("[6, 8, 10]", "[6, 8, 10, 12]"));
    assert!(first.iter().all(|id| more.contains(id)) && more.len() == first.len() + 4);
    // Another setup or another part changes all.
    for (from, to) in [("0.4", "0.41"), ("pump6", "impeller9x9")] {
        let other = ids(&SAMPLE.replace(from, to));
        assert!(other.len() == first.len() && first.iter().all(|id| !other.contains(id)), "{from} → {to}");
    }
}

#[test]
fn a_limit_picks_evenly() {
    assert_eq!(
        shown(&list(&format!("limit = 3\n{SAMPLE}")).unwrap()),
        ["conventional 6 16", "conventional 8 16", "conventional 10 20",]
    );
    assert_eq!(list(&format!("limit = 99\n{SAMPLE}")).unwrap().runs.len(), 8);
}

#[test]
fn a_value_that_fails_in_some_combinations_makes_runs_that_fail() {
    let text = "part = \"pump6.toml\"\n[[setup.tool]]\ndiameter = 20\n\
                [[axis]]\nkey = \"tool.1.insert_width\"\nvalues = [6, 9]\n\
                [[axis]]\nkey = \"tool.1.diameter\"\nvalues = [16, 20]\n";
    let study = list(text).unwrap();
    let fault = study.input(&study.runs[2].choice).setup.unwrap_err();
    assert_eq!(fault.code, ErrorCode::ValueRange, "{fault}");
    assert!(study.input(&study.runs[3].choice).setup.is_ok());
}

#[test]
fn bad_studies_are_refused_in_one_line() {
    for (from, to, line, words) in [
        ("parts", "prts", 1, "`parts`"),
        ("parts = [\"pump6.toml\"]", "", 1, "no part"),
        ("pump6.toml", "pump7.toml", 0, "pump7.toml: cannot be read"),
        ("hub_allowance = 0.4", "hub_alowance = 0.4", 3, "`hub_allowance`"),
        ("hub_allowance = 0.4", "hub_allowance = -1", 3, "from 0"),
        ("tool.3.diameter", "stock.hub_alowance", 15, "`hub_allowance`, the nearest known key"),
        ("tool.3.diameter", "plnge.max_tilt", 15, "`plunge`, the nearest known key"),
        ("key = \"policy\"", "key = \"flank.tool\"", 8, "does not change a plunge plan"),
        ("key = \"policy\"", "key = \"\"", 8, "not the path"),
        ("key = \"policy\"", "key = \"plunge.step\"", 10, "varies on two axes"),
        ("key = \"policy\"", "kye = \"policy\"", 8, "`key`"),
        ("\"conventional\", ", "\"conventoinal\", ", 9, "`conventional`"),
        ("\"conventional\", ", "\"monotone\", ", 9, "twice"),
        ("\"monotone\"]", "2026-01-01]", 9, "datetime"),
        ("[6, 8, 10]", "[]", 10, "no values"),
        ("[6, 8, 10]", "[6, 8, 0]", 12, "greater than 0"),
        ("[6, 8, 10]", "[6, 8, nan]", 12, "finite"),
        ("[6, 8, 10]", "[6, 8]\nrange = [1, 2, 1]", 13, "keep one of them"),
        ("tool.3", "tool.1", 15, "s.toml:15: `tool.1.diameter`: the base setup has no tool `1`"),
        ("range = [16, 20, 4]", "range = [20, 16, 4]", 15, "no step"),
        ("range = [16, 20, 4]", "range = [16, 20]", 15, "three"),
        ("range = [16, 20, 4]", "range = [1, 2, 1e-9]", 15, "at most 100000"),
        ("range = [16, 20, 4]", "range = [16, 20, 1e-4]", 1, "2 × 3 × 40001 combinations are more"),
        ("policy = \"monotone\"", "polcy = \"monotone\"", 17, "use one of `part`, `plunge.axis`"),
        ("plunge.step = [6, 8.0]", "plunge.stp = [6, 8.0]", 18, "`plunge.step`, the nearest known axis"),
        ("policy = \"monotone\"", "policy = \"minimal\"", 17, "not a value on the axis"),
        ("plunge.step = [6, 8.0]", "plunge.step = [7]", 18, "`7` is not a value"),
        (
            "policy = \"monotone\"\nplunge.step = [6, 8.0]",
            "plunge.step = [6, 8, 10]",
            0,
            "every run is excluded",
        ),
        ("policy = \"monotone\"\nplunge.step = [6, 8.0]", "", 16, "exclusion is empty"),
        ("[setup]", "limit = 0\n[setup]", 2, "whole number"),
        ("[setup]", "base = \"x.toml\"\n[setup]", 2, "both `base` and [setup]"),
        ("[[axis]]", "[axis]", 7, "TOML"),
    ] {
        assert!(SAMPLE.contains(from), "{from} must be in the sample");
        let error = list(&SAMPLE.replacen(from, to, 1)).err().unwrap_or_else(|| panic!("{to} was accepted"));
        assert!(error.contains(words) && error.contains("; "), "{from} → {to}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        if line > 0 && words != "TOML" {
            assert!(error.starts_with(&format!("s.toml:{line}: ")), "{from} → {to}: line {line}, {error}");
        }
    }
}
