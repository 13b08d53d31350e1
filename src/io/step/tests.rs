//! Surfaces against closed forms, a real wheel, and damage.

use std::f64::consts::PI;

use super::body::{MeshedBody, SurfaceKind};
use super::read::{StepScene, read_scene_bytes};
use crate::error::ErrorCode;

/// Compressor wheel of the KJ66 jet engine, from a CAD system; its licence is beside it.
const KJ66: &[u8] = include_bytes!("../../../tests/data/step/kj66_impeller.step");

fn file(unit: &str, data: &str) -> String {
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;\n\
         #1=(LENGTH_UNIT()NAMED_UNIT(*){unit});\n\
         #2=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#1))\
         REPRESENTATION_CONTEXT('',''));\n\
         #3=ADVANCED_BREP_SHAPE_REPRESENTATION('body',(#4),#2);\n\
         #5=CARTESIAN_POINT('',(0.,0.,0.));#6=DIRECTION('',(0.,0.,1.));#7=DIRECTION('',(1.,0.,0.));\n\
         #8=AXIS2_PLACEMENT_3D('',#5,#6,#7);\n{data}\nENDSEC;END-ISO-10303-21;"
    )
}

const MM: &str = "SI_UNIT(.MILLI.,.METRE.)";

/// A solid of one face without borders.
fn closed(surface: &str) -> String {
    format!(
        "#4=MANIFOLD_SOLID_BREP('ball',#10);#10=CLOSED_SHELL('',(#11));\n\
         #11=ADVANCED_FACE('',(#12),#13,.T.);#12=FACE_BOUND('',#14,.T.);#14=VERTEX_LOOP('',#15);\n\
         #15=VERTEX_POINT('',#5);#13={surface};"
    )
}

/// A can: a cylinder (or a cone) with a seam, between two discs.
fn can(side: &str, bottom: f64, top: f64, height: f64) -> String {
    format!(
        "#4=MANIFOLD_SOLID_BREP('can',#10);#10=CLOSED_SHELL('',(#20,#21,#22));\n\
         #30=CARTESIAN_POINT('',({bottom},0.,0.));#31=VERTEX_POINT('',#30);\n\
         #32=CARTESIAN_POINT('',({top},0.,{height}));#33=VERTEX_POINT('',#32);\n\
         #34=CARTESIAN_POINT('',(0.,0.,{height}));#35=AXIS2_PLACEMENT_3D('',#34,#6,#7);\n\
         #36=CIRCLE('',#8,{bottom});#37=EDGE_CURVE('',#31,#31,#36,.T.);\n\
         #38=CIRCLE('',#35,{top});#39=EDGE_CURVE('',#33,#33,#38,.T.);\n\
         #40=POLYLINE('',(#30,#32));#41=EDGE_CURVE('',#31,#33,#40,.T.);\n\
         #42=ORIENTED_EDGE('',*,*,#37,.T.);#43=ORIENTED_EDGE('',*,*,#41,.T.);\n\
         #44=ORIENTED_EDGE('',*,*,#39,.F.);#45=ORIENTED_EDGE('',*,*,#41,.F.);\n\
         #46=EDGE_LOOP('',(#42,#43,#44,#45));#47=FACE_OUTER_BOUND('',#46,.T.);\n\
         #20=ADVANCED_FACE('',(#47),#48,.T.);#48={side};\n\
         #49=ORIENTED_EDGE('',*,*,#37,.F.);#50=EDGE_LOOP('',(#49));#51=FACE_BOUND('',#50,.T.);\n\
         #52=PLANE('',#8);#21=ADVANCED_FACE('',(#51),#52,.F.);\n\
         #53=ORIENTED_EDGE('',*,*,#39,.T.);#54=EDGE_LOOP('',(#53));#55=FACE_BOUND('',#54,.T.);\n\
         #56=PLANE('',#35);#22=ADVANCED_FACE('',(#55),#56,.T.);"
    )
}

fn measure(body: &MeshedBody) -> (f64, f64) {
    let corner = |i: u32| body.mesh.points[i as usize].coords;
    body.mesh.triangles.iter().map(|t| t.map(corner)).fold((0.0, 0.0), |(v, s), [a, b, c]| {
        (v + a.dot(&b.cross(&c)) / 6.0, s + 0.5 * (b - a).cross(&(c - a)).norm())
    })
}

fn scene(text: &str, chord_mm: f64) -> StepScene {
    read_scene_bytes("a.step", text.as_bytes(), Some(chord_mm)).expect("sound")
}

#[test]
fn surfaces_meet_their_closed_forms() {
    let cone = "CONICAL_SURFACE('',#8,5.,-0.24497866312686414)";
    let slant = f64::hypot(8.0, 2.0);
    for (data, volume, area) in [
        (closed("SPHERICAL_SURFACE('',#8,5.)"), 500.0 * PI / 3.0, 100.0 * PI),
        (closed("TOROIDAL_SURFACE('',#8,10.,2.)"), 80.0 * PI * PI, 80.0 * PI * PI),
        (can("CYLINDRICAL_SURFACE('',#8,5.)", 5.0, 5.0, 8.0), 200.0 * PI, 130.0 * PI),
        (can(cone, 5.0, 3.0, 8.0), 8.0 * PI / 3.0 * 49.0, PI * (25.0 + 9.0 + 8.0 * slant)),
    ] {
        let mut before = f64::INFINITY;
        for chord in [0.05, 0.005] {
            let scene = scene(&file(MM, &data), chord);
            let body = &scene.bodies[0];
            assert_eq!((body.open_edges, &*body.faults), (0, &[][..]), "{data}");
            let (v, a) = measure(body);
            let off = ((v - volume) / volume).abs().max(((a - area) / area).abs());
            // A polygon with sagitta s in a circle of radius r lacks 4 s / 3 r of its area; r is 2 at least.
            assert!(off < 0.75 * chord && off < before, "{off} at {chord}: {v} {volume}, {a} {area}");
            before = off;
        }
    }
}

/// The borders of a face and the sense of its surface contradict each other: its neighbours tell that the
/// borders are right.
#[test]
fn a_face_with_the_wrong_sense_follows_its_neighbours() {
    let data = can("CYLINDRICAL_SURFACE('',#8,5.)", 5.0, 5.0, 8.0);
    let wrong = data.replace("#21=ADVANCED_FACE('',(#51),#52,.F.)", "#21=ADVANCED_FACE('',(#51),#52,.T.)");
    assert_ne!(wrong, data);
    let [right, wrong] = [data, wrong].map(|data| scene(&file(MM, &data), 0.05));
    assert_eq!(wrong.bodies[0].open_edges, 0);
    assert_eq!(measure(&wrong.bodies[0]), measure(&right.bodies[0]));
}

#[test]
fn triangles_between_slanted_borders_run_along_a_cylinder() {
    // Half a cylinder from the plane z = 0 to the plane z = 40 + 0.6 x.
    let s = f64::sqrt(1.36);
    let data = format!(
        "#4=SHELL_BASED_SURFACE_MODEL('',(#10));#10=OPEN_SHELL('',(#20));\n\
         #30=CARTESIAN_POINT('',(5.,0.,0.));#31=VERTEX_POINT('',#30);\n\
         #32=CARTESIAN_POINT('',(-5.,0.,0.));#33=VERTEX_POINT('',#32);\n\
         #34=CARTESIAN_POINT('',(-5.,0.,37.));#35=VERTEX_POINT('',#34);\n\
         #36=CARTESIAN_POINT('',(5.,0.,43.));#37=VERTEX_POINT('',#36);\n\
         #38=CARTESIAN_POINT('',(0.,0.,40.));#39=DIRECTION('',(-0.6,0.,1.));#40=DIRECTION('',(1.,0.,0.6));\n\
         #41=AXIS2_PLACEMENT_3D('',#38,#39,#40);#42=ELLIPSE('',#41,{},5.);#43=CIRCLE('',#8,5.);\n\
         #44=POLYLINE('',(#32,#34));#45=POLYLINE('',(#36,#30));\n\
         #46=EDGE_CURVE('',#31,#33,#43,.T.);#47=EDGE_CURVE('',#33,#35,#44,.T.);\n\
         #48=EDGE_CURVE('',#37,#35,#42,.T.);#49=EDGE_CURVE('',#37,#31,#45,.T.);\n\
         #50=ORIENTED_EDGE('',*,*,#46,.T.);#51=ORIENTED_EDGE('',*,*,#47,.T.);\n\
         #52=ORIENTED_EDGE('',*,*,#48,.F.);#53=ORIENTED_EDGE('',*,*,#49,.T.);\n\
         #54=EDGE_LOOP('',(#50,#51,#52,#53));#55=FACE_OUTER_BOUND('',#54,.T.);\n\
         #56=CYLINDRICAL_SURFACE('',#8,5.);#20=ADVANCED_FACE('',(#55),#56,.T.);",
        5.0 * s
    );
    let scene = scene(&file(MM, &data), 0.01);
    let body = &scene.bodies[0];
    let corner = |i: u32| body.mesh.points[i as usize];
    let edges = body.mesh.triangles.iter().flat_map(|t| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3])));
    let middles = edges.map(|(a, b)| nalgebra::center(&corner(a), &corner(b)));
    let off = middles.map(|p| 5.0 - p.x.hypot(p.y)).fold(0.0, f64::max);
    // Of a chord over two steps.
    assert!(off < 0.04, "an edge of the triangles is {off} mm off the cylinder");
    let (_, area) = measure(body);
    assert!((area / (200.0 * PI) - 1.0).abs() < 2e-3, "{area}");
}

#[test]
fn units_are_those_of_the_representation() {
    let can = can("CYLINDRICAL_SURFACE('',#8,5.)", 5.0, 5.0, 8.0);
    let inch = "CONVERSION_BASED_UNIT('INCH',#60)";
    let measure_of_inch = "#60=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#61);\
         #61=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));";
    for (unit, scale) in
        [(MM, 1.0), ("SI_UNIT(.CENTI.,.METRE.)", 10.0), ("SI_UNIT($,.METRE.)", 1e3), (inch, 25.4)]
    {
        let scene = scene(&file(unit, &format!("{can}{measure_of_inch}")), 0.001 * scale);
        let high = scene.bodies[0].mesh.points.iter().map(|p| p.z).fold(0.0, f64::max);
        assert!((high - 8.0 * scale).abs() < 1e-9 * scale, "{unit}: {high}");
    }
}

#[test]
fn a_wheel_from_cad_is_closed_and_has_its_volume() {
    let scene = read_scene_bytes("kj66.step", KJ66, None).expect("sound");
    assert_eq!(scene.bodies.len(), 11);
    assert!(scene.notes().is_empty(), "{:?}", scene.notes());
    assert_eq!(scene.bodies.iter().map(|b| b.faces.len()).sum::<usize>(), 92);
    let free = scene.bodies.iter().flat_map(|b| &b.faces).filter(|f| f.kind == SurfaceKind::Free);
    assert_eq!(free.count(), 48);
    let (volume, area) = scene.bodies.iter().map(measure).fold((0.0, 0.0), |s, m| (s.0 + m.0, s.1 + m.1));
    // Reference: Open CASCADE, 78,552.4 mm³ and 54,439.6 mm².
    assert!((volume / 78_552.4 - 1.0).abs() < 1e-3, "{volume}");
    assert!((area / 54_439.6 - 1.0).abs() < 2e-4, "{area}");
    let (_, along) = scene.axis().expect("it has bodies of revolution");
    assert!(along.y.abs() > 1.0 - 1e-9);
}

#[test]
fn faults_name_the_instance() {
    let ball = closed("SPHERICAL_SURFACE('',#8,5.)");
    let net = |knots: &str| {
        closed(&format!("B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#5,#5),(#5,#5)),.U.,.F.,.F.,.U.,{knots},.U.)"))
    };
    let bad = ErrorCode::StepFile;
    for (data, code, instance) in [
        (ball.replace("#10=CLOSED_SHELL('',(#11))", "#10=CLOSED_SHELL('',(#99))"), bad, "#10: "),
        (ball.replace("#8,5.", "#8,-5."), bad, "#13: "),
        (ball.replace("#13=SPHERICAL", "#13=HYPERBOLIC"), bad, "#13: "),
        (closed("OFFSET_SURFACE('',#13,1.,.F.)"), bad, "#13: "),
        (net("(1000000000,2),(2,2),(0.,1.),(0.,1.)"), bad, "#13: "),
        (net("(2,2),(2,2),(1.,0.),(0.,1.)"), bad, "#13: "),
        (net("(2,3),(2,2),(0.,1.),(0.,1.)"), bad, "#13: "),
        ("#4=MANIFOLD_SOLID_BREP('',#4);".to_owned(), bad, "#4: "),
        ("#4=GEOMETRIC_SET('',());".to_owned(), ErrorCode::StepFile, ""),
    ] {
        let error = read_scene_bytes("a.step", file(MM, &data).as_bytes(), Some(0.1)).expect_err(&data);
        assert_eq!(error.code, code, "{error}");
        assert!(error.message.starts_with(instance), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}

#[test]
fn an_assembly_that_contains_itself_is_refused() {
    let ball = closed("SPHERICAL_SURFACE('',#8,5.)");
    let map = "#70=REPRESENTATION_MAP(#8,#3);#71=MAPPED_ITEM('',#70,#8);";
    let text = file(MM, &format!("{ball}{map}")).replace("'body',(#4)", "'body',(#4,#71)");
    // No representation is outermost: the body is taken as it is, once.
    assert_eq!(scene(&text, 0.1).bodies.len(), 1);
    let outer = "#72=SHAPE_REPRESENTATION('outer',(#73),#2);#73=MAPPED_ITEM('',#70,#8);";
    let error =
        read_scene_bytes("a.step", text.replace("#70=", &format!("{outer}#70=")).as_bytes(), Some(0.1));
    let error = error.expect_err("a circle");
    assert!(error.code == ErrorCode::StepFile && error.message.starts_with("#3: "), "{error}");
}

#[test]
fn damaged_files_end_in_a_fault_or_a_scene() {
    let whole = file(MM, &can("CYLINDRICAL_SURFACE('',#8,5.)", 5.0, 5.0, 8.0)).into_bytes();
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..400 {
        let mut bytes = whole.clone();
        for _ in 0..=next(3) {
            let at = next(bytes.len());
            bytes[at] = b"0123456789#,.()'$*-E;"[next(21)];
        }
        if let Err(error) = read_scene_bytes("a.step", &bytes, Some(0.2)) {
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }
}
