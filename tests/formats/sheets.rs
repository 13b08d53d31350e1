//! STEP files of surface models: every face a sheet with borders of its own.

use std::collections::{BTreeMap, BTreeSet};

use vanecut::geometry::MeridionalCurve;
use vanecut::io::step::{read_bytes, read_scene_bytes};
use vanecut::mesh::MeshOptions;
use vanecut::part::Impeller;

/// Wheels of solids, made by scripts beside them: in one body, and of seven.
const OPEN_WHEEL: &str = include_str!("../data/step/open_wheel.step");
const PUMP_COVERED: &str = include_str!("../data/step/pump_covered.step");

/// The instances that a text refers to.
fn references(text: &str) -> Vec<u32> {
    let ends = |rest: &str| rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    text.split('#').skip(1).filter_map(|rest| rest[..ends(rest)].parse().ok()).collect()
}

/// The text with all references moved on by `by`.
fn renumbered(text: &str, by: u32) -> String {
    let mut parts = text.split('#');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for rest in parts {
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let number: u32 = rest[..end].parse().expect("a number");
        out += &format!("#{}{}", number + by, &rest[end..]);
    }
    out
}

/// A point or direction turned about Z by an angle, rad; anything else as it is.
fn turned(text: &str, angle: f64) -> String {
    let is_place = text.starts_with("CARTESIAN_POINT") || text.starts_with("DIRECTION");
    let Some((start, end)) = text.rfind('(').zip(text.find(')')).filter(|_| is_place) else {
        return text.to_owned();
    };
    let numbers: Vec<f64> = text[start + 1..end].split(',').filter_map(|x| x.trim().parse().ok()).collect();
    let [x, y, z] = numbers[..] else { return text.to_owned() };
    let (sin, cos) = angle.sin_cos();
    format!("{}({:.12},{:.12},{z:.12}))", &text[..start], x * cos - y * sin, x * sin + y * cos)
}

/// The file with each face of its solids as a sheet that shares nothing with others; every other one is
/// reversed. The first `round` faces are whole ones of revolution: each gets its seam at another place.
fn exploded(file: &str, round: usize) -> String {
    let (head, data) = file.split_once("DATA;").expect("data");
    let (data, tail) = data.split_once("ENDSEC;").expect("its end");
    let instances: BTreeMap<u32, String> = data
        .split(';')
        .filter_map(|line| line.trim().strip_prefix('#')?.split_once('='))
        .filter_map(|(id, text)| Some((id.trim().parse().ok()?, text.trim().replace('\n', ""))))
        .collect();
    let is = |id: &u32, keyword: &str| instances.get(id).is_some_and(|text| text.starts_with(keyword));
    let faces: Vec<u32> = instances.keys().copied().filter(|id| is(id, "ADVANCED_FACE")).collect();
    let step = instances.keys().last().expect("instances") + 10;
    let (mut out, mut sheets) = (String::new(), Vec::new());
    for (k, face) in faces.iter().enumerate() {
        let by = step * (k as u32 + 1);
        let (mut waiting, mut seen) = (vec![*face], BTreeSet::from([*face]));
        while let Some(id) = waiting.pop() {
            let text = instances.get(&id).expect("an instance");
            waiting.extend(references(text).into_iter().filter(|id| seen.insert(*id)));
            let angle = if k < round { 0.4 * k as f64 } else { 0.0 };
            out += &format!("#{}={};\n", id + by, renumbered(&turned(text, angle), by));
        }
        let (shell, oriented, sheet) = (by + step - 3, by + step - 2, by + step - 1);
        let sense = if k % 2 == 0 { ".T." } else { ".F." };
        out += &format!("#{oriented}=ORIENTED_FACE('',*,#{},{sense});\n", face + by);
        out += &format!("#{shell}=OPEN_SHELL('',(#{oriented}));\n");
        out += &format!("#{sheet}=SHELL_BASED_SURFACE_MODEL('',(#{shell}));\n");
        sheets.push(format!("#{sheet}"));
    }
    // They take the place of the solids.
    for (id, text) in instances.iter().filter(|(id, _)| !is(id, "MANIFOLD_SOLID_BREP")) {
        let mut text = text.clone();
        if is(id, "ADVANCED_BREP_SHAPE_REPRESENTATION") {
            // Between its placement and its context; those of further solids keep nothing else.
            let (own, all) = (references(&text), std::mem::take(&mut sheets));
            let items = std::iter::once(format!("#{}", own[0])).chain(all).collect::<Vec<_>>().join(",");
            text = format!("SHAPE_REPRESENTATION('',({items}),#{})", own[own.len() - 1]);
        }
        out += &format!("#{id}={text};\n");
    }
    format!("{head}DATA;\n{out}ENDSEC;{tail}")
}

fn built(name: &str, text: &str) -> Impeller {
    let part = read_bytes(name, text.as_bytes(), &MeshOptions::default());
    match part {
        Ok(part) => Impeller::build(&part).expect("a wheel"),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn sheets_of_single_faces_are_the_bodies_that_they_make_up() {
    // The hub of the second has six faces, a cover of four and five blades follow.
    for (name, solids, count, round) in [("open.step", OPEN_WHEEL, 1, 0), ("pump.step", PUMP_COVERED, 7, 6)] {
        let sheets = exploded(solids, round);
        let scene = read_scene_bytes(name, sheets.as_bytes(), None).expect("sound");
        assert!(scene.notes().is_empty(), "{name}: {:?}", scene.notes());
        assert_eq!(scene.bodies.len(), count, "{name}");
        for body in &scene.bodies {
            assert!(body.solid && body.open_edges == 0, "{name}: {} open edges", body.open_edges);
            let corner = |i: u32| body.mesh.points[i as usize].coords;
            let sixfold =
                body.mesh.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(&b.cross(&c)));
            assert!(sixfold.sum::<f64>() > 0.0, "{name}: a body is inside out");
        }
        let (part, own) = (built(name, solids), built(name, &sheets));
        assert_eq!(
            (part.blade_count, part.splitters.len()),
            (own.blade_count, own.splitters.len()),
            "{name}"
        );
        let apart = |a: &MeridionalCurve, b: &MeridionalCurve| {
            let points = (0..=50).map(|k| b.point(b.length() * f64::from(k) / 50.0));
            points.map(|p| a.project(p).1.abs()).fold(0.0, f64::max)
        };
        assert!(apart(part.hub.curve(), own.hub.curve()) < 0.01, "{name}: hub");
        assert!(apart(part.shroud.curve(), own.shroud.curve()) < 0.01, "{name}: shroud");
    }
}
