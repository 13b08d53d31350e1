use std::fs;
use std::path::PathBuf;

use super::*;
use crate::geometry::Point;
use crate::part::BladeDescription;

const INF: &str = "! export\nAxis of Rotation: Z\nNumber of Blade Sets: 9\nNumber of Blades Per Set: 2\n\
    Geometry Units: CM\nHub Data File: hub.curve\nShroud Data File: shroud.curve\n\
    Profile Data File: p.curve\n";
const HUB: &str = "2 0 0\n2 0 0\n0 3 2\n5 0 3\n";
const SHROUD: &str = "4 0 0\n4 0 1\n5 0 2\n";

/// A loop from radius 2 to 5 that wraps towards smaller θ; the side of larger θ has y + 0.1.
fn profile(marks: [&str; 4], lift: f64) -> String {
    let [a, b, c, d] = marks;
    format!(
        "2.0 0.0 {lift} {a}\n3.0 -1.0 {z}\n4.98 -3.0 {top} {b}\n\
         4.98 -2.9 {top} {c}\n3.1 -0.8 {z} {d}\n2.0 0.0 {lift}\n",
        z = lift + 1.0,
        top = lift + 2.0,
    )
}

fn files(inf: &str, profile: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.inf");
    fs::write(&path, inf).unwrap();
    fs::write(folder.path().join("hub.curve"), HUB).unwrap();
    fs::write(folder.path().join("Stage_Shroud.curve"), SHROUD).unwrap();
    fs::write(folder.path().join("p.curve"), profile).unwrap();
    (folder, path)
}

fn blade(name: &str, marks: [&str; 4]) -> String {
    let (low, high) = (profile(marks, 0.0), profile(marks, 0.5));
    format!("{name}# Profile 1 at 0.0000%\n{low}\n# Profile 2 at 100.0%\n{high}")
}

fn sides(blade: &BladeDescription) -> (&Vec<Point>, &Vec<Point>) {
    match blade {
        BladeDescription::Sections { suction, pressure, .. } => (&suction[0], &pressure[0]),
        BladeDescription::Camber { .. } => panic!("sections expected"),
    }
}

#[test]
fn reads_flowpath_and_named_blades() {
    let profile = format!(
        "{}{}",
        blade("## Splitter\n", ["le", "te1", "te2", ""]),
        blade("## Main Blade\n", ["le", "te1", "te2", ""])
    );
    let (_folder, path) = files(INF, &profile);
    let part = read(&path).unwrap();
    assert_eq!((part.name.as_str(), part.blade_count, part.count_line), ("set", 9, 3));
    let CurveDescription::Points(hub) = &part.hub else { panic!("points expected") };
    assert_eq!(hub.len(), 3, "the repeated point is one");
    assert_eq!((hub[1].r, hub[1].z, part.hub_line), (30.0, 20.0, 6));
    assert_eq!(part.splitters.len(), 1);
}

#[test]
fn marked_and_unmarked_edges_split_alike() {
    for marks in [["le", "te1", "te2", ""], ["", "", "", ""]] {
        let (_folder, path) = files(INF, &blade("", marks));
        let part = read(&path).unwrap();
        let (suction, pressure) = sides(&part.main);
        assert_eq!((suction.len(), pressure.len()), (3, 3), "{marks:?}");
        assert_eq!((suction[0], pressure[0]), (Point::new(20.0, 0.0, 0.0), Point::new(20.0, 0.0, 0.0)));
        // Wrap towards smaller θ: the wheel turns towards larger θ, where the pressure side is.
        assert_eq!((suction[2].y, pressure[2].y), (-30.0, -29.0));
    }
}

#[test]
fn unnamed_blades_are_distinguished_by_their_span() {
    let (_folder, path) = files(INF, &format!("{0}{0}", blade("", ["le", "te1", "te2", ""])));
    assert_eq!(read(&path).unwrap().splitters.len(), 1);
}

#[test]
fn other_axes_map_to_z() {
    for (axis, order) in [("X", [2, 0, 1]), ("y", [1, 2, 0])] {
        let turned = |text: &str| -> String {
            let turn = |line: &str| {
                let words: Vec<&str> = line.split_whitespace().collect();
                match words.as_slice() {
                    [_, _, _, ..] if !line.starts_with('#') => {
                        let tail = words[3..].join(" ");
                        format!("{} {} {} {tail}\n", words[order[0]], words[order[1]], words[order[2]])
                    }
                    _ => format!("{line}\n"),
                }
            };
            text.lines().map(turn).collect()
        };
        let plain = blade("", ["le", "te1", "te2", ""]);
        let (folder, path) =
            files(&INF.replace("Rotation: Z", &format!("Rotation: {axis}")), &turned(&plain));
        fs::write(folder.path().join("hub.curve"), turned(HUB)).unwrap();
        fs::write(folder.path().join("Stage_Shroud.curve"), turned(SHROUD)).unwrap();
        let (_plain, plain) = files(INF, &plain);
        assert_eq!(read(&path).unwrap(), read(&plain).unwrap(), "axis {axis}");
    }
}

#[test]
fn faults_name_the_file_they_are_in() {
    let good = blade("", ["le", "te1", "te2", ""]);
    let fault = |inf: &str, profile: &str| {
        let (_folder, path) = files(inf, profile);
        let error = read(&path).expect_err("must be refused");
        let place = error.place();
        (error.code, place.rsplit(['/', '\\']).next().unwrap_or_default().to_owned())
    };
    for (from, to, code, place) in [
        ("Sets: 9", "Sets: 10000", ErrorCode::BladeCount, "set.inf:3"),
        ("Sets: 9", "Sets: 0", ErrorCode::BladeCount, "set.inf:3"),
        ("Geometry Units: CM\n", "", ErrorCode::MissingKey, "set.inf"),
        ("Units: CM", "Units: LY", ErrorCode::UnknownName, "set.inf:5"),
        ("Rotation: Z", "Rotation: Q", ErrorCode::UnknownName, "set.inf:2"),
        ("hub.curve", "nub.curve", ErrorCode::FileUnreadable, "set.inf:6"),
        ("Hub Data File: hub.curve\n", "", ErrorCode::MissingKey, "set.inf"),
    ] {
        assert_eq!(fault(&INF.replace(from, to), &good), (code, place.to_owned()), "{from} → {to}");
    }
    for (from, to, code, place) in [
        ("3.0 -1.0 1", "3.0 nan 1", ErrorCode::InvalidNumber, "p.curve:3"),
        ("3.0 -1.0 1", "3.0 -1.0", ErrorCode::PartFile, "p.curve:3"),
        ("3.0 -1.0 1", "3.0 2e5 1", ErrorCode::InvalidNumber, "p.curve:3"),
        ("# Profile 1 at 0.0000%\n", "", ErrorCode::PartFile, "p.curve:1"),
        ("# Profile 2 at 100.0%\n", "", ErrorCode::BladeSections, "p.curve:1"),
    ] {
        assert!(good.contains(from), "{from} must be in the sample");
        assert_eq!(fault(INF, &good.replacen(from, to, 1)), (code, place.to_owned()), "{from} → {to}");
    }
    let points = fault(INF, "# Profile 1 at 0%\n1 1 1\n# Profile 2 at 1%\n1 1 1\n");
    assert_eq!(points, (ErrorCode::BladeSections, "p.curve:1".to_owned()));
    assert_eq!(fault(INF, ""), (ErrorCode::FileEmpty, "p.curve".to_owned()));
}
