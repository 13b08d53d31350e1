//! glTF scenes of plans.

use serde_json::Value;
use vanecut::cutting::contact::CoreContact;
use vanecut::geometry::{Point, Vector};
use vanecut::io::gltf::{CutterNodes, GltfScene, PlanScene};
use vanecut::mesh::tessellate::Tessellation;
use vanecut::palette::{ColourMap, colour_of_value};
use vanecut::part::Impeller;
use vanecut::plunge::Blocked;
use vanecut::plunge::PlungePlan;
use vanecut::plunge::plan::{Evaluation, Position, SectionPlan};
use vanecut::setup::{AxisPolicy, CutDirection, SectionKind, Setup, Tool};
use vanecut::stock::{FloorGrid, FloorSource};

use super::file::GltfFile;
use super::{sample, written};

/// Cells of the floor grid in each direction.
const CELLS: usize = 24;

fn position(k: usize) -> Position {
    let angle = 0.3 + 0.02 * k as f64;
    let tip = Point::new(100.0 * angle.cos(), 100.0 * angle.sin(), -5.0 - k as f64);
    // The first axis is −Z, for which the shortest rotation from Z is not unique.
    let axis = if k == 0 { -Vector::z() } else { Vector::new(0.1 * k as f64, -0.2, -1.0).normalize() };
    Position {
        tip,
        axis,
        section: k % 2,
        row: 0,
        s: 0.9,
        lambda: 0.5,
        alpha_rad: 0.1,
        contact_point: tip,
        lift: 0.0,
        blocked: (k == 4).then_some(Blocked::Walls),
        limited_by: None,
        hub_clearance: 0.5,
        blade_clearance: f64::NAN,
        evaluation: Evaluation {
            contact: CoreContact { depth: if k.is_multiple_of(3) { 0.4 } else { 0.0 }, area_share: 0.0 },
            retract: tip + axis * 40.0,
            retract_clearance: 2.0,
            engagement: Default::default(),
            motion: Default::default(),
            breach: None,
        },
    }
}

fn plan() -> PlungePlan {
    let section = |number: u32, diameter: f64| SectionPlan {
        tool: Tool {
            number,
            diameter,
            corner_radius: 0.5,
            insert_width: 4.0,
            overhang: 50.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: Default::default(),
        },
        from: 1.0,
        to: 0.0,
        feed: CutDirection::OutletToInlet,
        rows: 1,
        kind: SectionKind::Rows,
        added: None,
    };
    PlungePlan {
        policy: AxisPolicy::Minimal,
        sections: vec![section(1, 12.0), section(2, 10.0)],
        positions: (0..9).map(position).collect(),
        dropped: Vec::new(),
        iterations: 1,
        converged: true,
    }
}

struct Planned {
    part: Impeller,
    shape: Tessellation,
    plan: PlungePlan,
    grid: FloorGrid,
    heights: Vec<f32>,
}

fn planned() -> Planned {
    let part = sample("pump6.toml");
    let (shape, _) = written(&part, 0.2);
    let setup = Setup::default();
    let workpiece = setup.allowances.workpiece_of(part.clone());
    let source = FloorSource::of_setup(&workpiece, &setup, &[]);
    let grid = FloorGrid::new(&source, CELLS);
    // A ramp, and a range of uncut cells.
    let heights = (0..CELLS * CELLS)
        .map(
            |k| if k < CELLS { grid.blank_heights[k] } else { 0.5 + 2.0 * k as f32 / (CELLS * CELLS) as f32 },
        )
        .collect();
    Planned { part, shape, plan: plan(), grid, heights }
}

fn file(p: &Planned, cutters: CutterNodes) -> GltfFile {
    let file = GltfFile::of_glb(
        &GltfScene::of_plan(&PlanScene {
            part: &p.part,
            shape: &p.shape,
            setup: &Setup::default(),
            plan: &p.plan,
            grid: &p.grid,
            heights: &p.heights,
            range: (0.5, 2.0),
            map: ColourMap::default(),
            cutters,
        })
        .glb(),
    );
    file.check();
    file
}

/// Rotation by a quaternion.
fn rotated(q: [f64; 4], p: [f64; 3]) -> [f64; 3] {
    let v = nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]);
    let turned = nalgebra::UnitQuaternion::from_quaternion(v) * Vector::from(p);
    turned.into()
}

fn floats<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|k| value[k].as_f64().expect("a number"))
}

fn assert_near(a: [f64; 3], b: [f64; 3], what: &str) {
    assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-6), "{what}: {a:?} against {b:?}");
}

#[test]
fn plain_cutters_stand_where_the_plan_has_them() {
    let p = planned();
    let file = file(&p, CutterNodes::Plain);
    assert_eq!(file.json["extensionsUsed"], serde_json::json!(["KHR_materials_unlit"]));
    for (k, position) in p.plan.positions.iter().enumerate() {
        let node = file.node(&format!("cutter_{}", k + 1));
        assert_near(floats(&node["translation"]), (position.tip.coords * 1e-3).into(), "tip");
        assert_near(rotated(floats(&node["rotation"]), [0.0, 0.0, 1.0]), position.axis.into(), "axis");
        let facts = &node["extras"]["vanecut"];
        assert_eq!(facts["condition"], position.condition().word());
        assert_eq!(facts["section"], position.section + 1);
        assert!(facts["blade_clearance"].is_null(), "what was not measured has no figure");
    }
}

#[test]
fn instanced_cutters_stand_in_the_same_places() {
    let p = planned();
    let file = file(&p, CutterNodes::Instanced);
    assert_eq!(
        file.json["extensionsUsed"],
        serde_json::json!(["KHR_materials_unlit", "EXT_mesh_gpu_instancing"])
    );
    assert!(file.json["extensionsRequired"].is_null());
    let mut seen = 0;
    let groups = file.node("cutters")["children"].as_array().expect("groups").clone();
    assert_eq!(groups.len(), 5, "two tools by the conditions that occur");
    for group in groups {
        let node = &file.json["nodes"][group.as_u64().expect("a node") as usize];
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let shifts = file.vectors::<3>(&attributes["TRANSLATION"]);
        let turns = file.vectors::<4>(&attributes["ROTATION"]);
        let (t, q): ([f64; 3], [f64; 4]) = (floats(&node["translation"]), floats(&node["rotation"]));
        let facts = node["extras"]["vanecut"]["positions"].as_array().expect("positions");
        assert_eq!((shifts.len(), turns.len()), (facts.len(), facts.len()));
        for ((shift, turn), facts) in shifts.iter().zip(&turns).zip(facts) {
            let position = &p.plan.positions[facts["position"].as_u64().expect("a number") as usize - 1];
            let moved = rotated(q, shift.map(f64::from));
            assert_near(std::array::from_fn(|k| moved[k] + t[k]), (position.tip.coords * 1e-3).into(), "tip");
            let axis = rotated(q, rotated(turn.map(f64::from), [0.0, 0.0, 1.0]));
            assert_near(axis, position.axis.into(), "axis");
            seen += 1;
        }
        let first = &p.plan.positions[facts[0]["position"].as_u64().expect("a number") as usize - 1];
        assert_near(t, (first.tip.coords * 1e-3).into(), "without the extension the first one shows");
    }
    assert_eq!(seen, p.plan.positions.len());
}

#[test]
fn a_cutter_has_its_dimensions_and_faces_outwards() {
    let p = planned();
    let file = file(&p, CutterNodes::Plain);
    let (points, triangles) = file.local("cutter_3");
    let radius = points.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f32::max);
    assert!((radius - 6e-3).abs() < 1e-8, "radius {radius} m");
    let facing = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| Vector::from(points[k as usize].map(f64::from)));
        // Radially outwards, or axially away from the middle.
        let (n, m) = ((b - a).cross(&(c - a)), (a + b + c) / 3.0);
        let middle = Vector::new(0.0, 0.0, 0.9e-3);
        n.dot(&(m - middle)) > 0.0
    };
    assert!(triangles.iter().all(facing), "a triangle faces inwards");
}

#[test]
fn stock_is_coloured_by_the_scale_of_the_window() {
    let p = planned();
    let file = file(&p, CutterNodes::Plain);
    let mesh = &file.json["meshes"][file.node("stock")["mesh"].as_u64().expect("a mesh") as usize];
    let attributes = &mesh["primitives"][0]["attributes"];
    let colours = file.colours(&attributes["COLOR_0"]);
    assert_eq!(colours.len(), CELLS * CELLS, "every cell of a small grid");
    let linear = |x: f32| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    let table = ColourMap::Cividis.table();
    for (k, colour) in colours.iter().enumerate() {
        let shown = if p.heights[k] >= p.grid.blank_heights[k] - 1e-3 {
            vanecut::palette::Theme::Light.greys().uncut
        } else {
            colour_of_value(&table, p.heights[k], (0.5, 2.0))
        };
        assert!((0..3).all(|c| (colour[c] - linear(shown[c])).abs() < 1e-4), "cell {k}: {colour:?}");
    }
    // On the allowance surface, facing the channel.
    let (points, triangles) = file.local("stock");
    let cell = CELLS * CELLS / 2;
    let (foot, normal) = (p.grid.points[cell], p.grid.normals[cell]);
    let raise = Setup::default().allowances.hub_allowance as f32;
    for k in 0..3 {
        assert!((points[cell][k] - 1e-3 * (foot[k] + raise * normal[k])).abs() < 1e-7);
    }
    for t in &triangles {
        let [a, b, c] = t.map(|k| Vector::from(points[k as usize].map(f64::from)));
        let normal = Vector::from(p.grid.normals[t[0] as usize].map(f64::from));
        assert!((b - a).cross(&(c - a)).dot(&normal) > 0.0, "a triangle of the stock faces the hub");
    }
}

#[test]
fn the_root_tells_the_setup() {
    let file = file(&planned(), CutterNodes::Instanced);
    let facts = &file.root()["extras"]["vanecut"];
    assert_eq!(facts["policy"], "minimal");
    assert_eq!(facts["positions"], 9);
    assert_eq!((&facts["interferential"], &facts["blocked"]), (&3.into(), &1.into()));
    assert_eq!(facts["hub_allowance"], Setup::default().allowances.hub_allowance);
    assert_eq!(facts["sections"][1]["diameter"], 10.0);
    assert_eq!(facts["stock_scale"], serde_json::json!([0.5, 2.0]));
}
