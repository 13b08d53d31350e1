use super::*;
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::setup::{CutDirection, SectionKind};
use crate::toolpath::{ClProgram, ClRow, ClSection, ClTool, Motion, Move};
use proptest::prelude::*;

fn read(text: &str) -> ClProgram {
    read_apt_bytes("p.apt", text.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn fault(text: &str) -> InputError {
    read_apt_bytes("p.apt", text.as_bytes()).expect_err("must be refused")
}

fn plunge(tip: Point, axis: Vector, tool: usize) -> [Move; 3] {
    let retract = tip + axis * 80.0;
    let at = |motion, tip| Move { motion, tip, axis, tool: Some(tool), line: 0 };
    [at(Motion::Rapid, retract), at(Motion::Feed(Some(300.0)), tip), at(Motion::Rapid, retract)]
}

fn sample() -> ClProgram {
    let tool = |number, diameter| ClTool {
        number,
        diameter,
        corner_radius: 0.8,
        insert_width: Some(diameter / 3.0),
        overhang: Some(120.0),
        feed_mm_per_min: Some(300.0),
        spindle_rpm: Some(1200.0),
        length_offset: None,
    };
    let mut moves = Vec::new();
    moves.extend(plunge(Point::new(-199.5, 0.25, 30.0), Vector::new(0.6, 0.0, 0.8), 0));
    moves.extend(plunge(
        Point::new(-123.456789, -234.567891, -345.678912),
        Vector::new(-0.48, -0.64, -0.6),
        0,
    ));
    moves.extend(plunge(Point::new(-100.0, 1e-9, -0.0), Vector::z(), 1));
    ClProgram {
        part: "impeller $$ 532".to_owned(),
        tools: vec![tool(1, 30.0), tool(2, 16.0)],
        moves,
        ..ClProgram::default()
    }
}

#[test]
fn moves_under_feed_with_a_stopped_spindle_are_noted() {
    let start = "LOADTL/1\nCUTTER/10\nSPINDL/1200,RPM,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,1\nSPINDL/OFF\nRAPID\n";
    let lines = |rest: &str| read(&format!("{start}{rest}\nFINI")).stopped_spindle_lines;
    assert_eq!(lines("GOTO/0,0,9\nGOTO/0,0,8\nGOTO/0,0,7"), [9, 10]);
    assert_eq!(lines("GOTO/0,0,9\nSPINDL/ON\nGOTO/0,0,8"), [0; 0]);
    assert_eq!(lines("GOTO/0,0,9\nSPINDL/0,RPM,CLW\nGOTO/0,0,8\nSPINDL/900\nGOTO/0,0,7"), [10]);
}

#[test]
fn writes_statements_in_the_documented_form() {
    let text = write_apt(&sample());
    let start = "PARTNO impeller $$ 532\nUNITS/MM\nMULTAX/ON\nLOADTL/1\n\
        CUTTER/30.000000,0.800000,14.200000,0.800000,0.000000,0.000000,$\n120.000000\n\
        PPRINT/INSERT WIDTH 1 10.000000\nSPINDL/1200.0,RPM,CLW\nCOOLNT/ON\nRAPID\n\
        GOTO/-151.500000,0.250000,94.000000,0.600000000,0.000000000,0.800000000\n\
        FEDRAT/300.0,MMPM\n";
    assert!(text.starts_with(start), "{text}");
    assert!(
        text.ends_with(
            "RAPID\nGOTO/-100.000000,0.000000,80.000000,0.000000000,0.000000000,1.000000000\nFINI\n"
        )
    );
    assert!(text.lines().all(|line| line.len() <= 72), "{text}");
}

#[test]
fn reads_back_what_it_writes() {
    let (wrote, got) = (sample(), read(&write_apt(&sample())));
    assert_eq!((&got.part, got.warnings.len(), got.moves.len()), (&wrote.part, 0, wrote.moves.len()));
    assert_eq!(got.tools.len(), 2);
    assert_eq!(got.tools[0], wrote.tools[0]);
    assert!((got.tools[1].insert_width.unwrap() - 16.0 / 3.0).abs() < 1e-6);
    for (a, b) in wrote.moves.iter().zip(&got.moves) {
        assert_eq!((a.motion, a.tool), (b.motion, b.tool));
        assert!((a.tip - b.tip).norm() < 1e-6 && (a.axis - b.axis).norm() < 2e-9, "{a:?} {b:?}");
    }
    assert_eq!(got.moves[0].line, 11);
}

#[test]
fn rapid_holds_for_one_goto() {
    let p = read("rapid\nGoto / 0, 0, 10 $$ up\nFEDRAT/120\nGOTO/0,0,0\nGOTO/1,0,0\nFINI\nGOTO/9,9,9");
    let motions: Vec<_> = p.moves.iter().map(|m| m.motion).collect();
    assert_eq!(motions, [Motion::Rapid, Motion::Feed(Some(120.0)), Motion::Feed(Some(120.0))]);
    assert!(p.warnings.is_empty(), "{:?}", p.warnings);
}

#[test]
fn short_gotos_keep_the_last_axis() {
    let p = read("GOTO/0,0,1\nMULTAX/ON\nGOTO/0,0,2,0,0.6,0.8\nMULTAX/OFF\nGOTO/0,0,3\nFINI");
    let axes: Vec<_> = p.moves.iter().map(|m| m.axis).collect();
    assert_eq!(axes, [Vector::z(), Vector::new(0.0, 0.6, 0.8), Vector::new(0.0, 0.6, 0.8)]);
    assert_eq!(p.moves[0].tool, None);
    assert_eq!(p.moves[0].motion, Motion::Feed(None));
}

#[test]
fn statements_go_on_after_a_dollar() {
    let p =
        read("GOTO/1,2, $ \n  3, $$ a comment ends a line, not a statement\nGOTO/1,2,$\n3,0,0,$\n1\nFINI");
    assert_eq!(p.moves.len(), 2);
    assert_eq!((p.moves[0].tip, p.moves[1].line), (Point::new(1.0, 2.0, 3.0), 3));
}

#[test]
fn inches_and_relative_moves() {
    let p = read(
        "UNITS/INCHES\nFROM/0,0,1\nCUTTER/1.0,0.1\nFEDRAT/IPM,10\nGODLTA/0,0,-1\nGODLTA/2\nGOTO/1,0,0\nFINI",
    );
    assert_eq!(p.moves[0].tip, Point::new(0.0, 0.0, 0.0));
    assert_eq!(p.moves[1].tip, Point::new(0.0, 0.0, 50.8));
    assert_eq!((p.moves[2].tip.x, p.moves[2].motion), (25.4, Motion::Feed(Some(254.0))));
    assert_eq!((p.tools[0].diameter, p.tools[0].feed_mm_per_min), (25.4, Some(254.0)));
}

#[test]
fn nx_dialect() {
    let p = read(
        "TOOL PATH/ROUGH_1,TOOL,MILL_D16\nTLDATA/MILL,16.0000,0.8000,75.0000,0.0000,0.0000\n\
         MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000\n\
         $$ centerline data\nPAINT/PATH\nPAINT/SPEED,10\nLOAD/TOOL,3,ADJUST,1\nSPINDL/RPM,1500,CLW\nRAPID\n\
         GOTO/10.,20.,30.,0.0000000,0.0000000,1.0000000\nPAINT/COLOR,42\nFEDRAT/MMPM,150.\nGOTO/10.,20.,5.\n\
         END-OF-PATH\nTOOL PATH/ROUGH_2,TOOL,MILL_D8\nTLDATA/MILL,8.0,0.0,50.0,0.0,0.0\nLOAD/TOOL,4\n\
         FEDRAT/90.,MMPM\nGOTO/1.,2.,3.\nEND-OF-PATH\n",
    );
    assert!(p.warnings.is_empty(), "{:?}", p.warnings);
    let tools: Vec<_> =
        p.tools.iter().map(|t| (t.number, t.diameter, t.overhang, t.feed_mm_per_min)).collect();
    assert_eq!(tools, [(3, 16.0, Some(75.0), Some(150.0)), (4, 8.0, Some(50.0), Some(90.0))]);
    assert_eq!((p.tools[0].corner_radius, p.tools[0].spindle_rpm), (0.8, Some(1500.0)));
    assert_eq!(p.moves.iter().map(|m| m.tool).collect::<Vec<_>>(), [Some(0), Some(0), Some(1)]);
}

#[test]
fn creo_dialect() {
    let p = read(
        "$$* Pro/CLfile\n$$-> MFGNO / IMPELLER\nPARTNO / IMPELLER\n$$-> FEATNO / 55\nMACHIN / UNCX01, 1\n\
         $$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_CENTER\nUNITS / MM\nLOADTL / 1, OSETNO, 1, LENGTH, 120.\n\
         $$-> CUTTER / 12.500000\n$$-> CSYS / 1.0000000000, 0.0000000000, 0.0000000000, 0.0000000000, $\n\
         \x20          0.0000000000, 1.0000000000, 0.0000000000, 0.0000000000, $\n\
         \x20          0.0000000000, 0.0000000000, 1.0000000000, 0.0000000000\n\
         MULTAX / ON\nSPINDL / RPM, 1200.000000,  CLW\nRAPID\nGOTO / 1.5, 2.5, 30.0, $\n0.0, 0.0, 1.0\n\
         FEDRAT / 200.000000,  MMPM\nGOTO / 1.5, 2.5, 3.0, 0., 0., 1.\nSPINDL / OFF\n$$-> END /\nFINI\n",
    );
    let tool = &p.tools[0];
    assert_eq!((p.part.as_str(), p.tools.len(), p.moves.len()), ("IMPELLER", 1, 2));
    assert_eq!((tool.number, tool.diameter, tool.overhang), (1, 12.5, Some(120.0)));
    assert_eq!((tool.spindle_rpm, tool.feed_mm_per_min, p.moves[0].line), (Some(1200.0), Some(200.0), 16));
}

#[test]
fn a_tool_comes_back_and_a_cutter_changes() {
    let p = read(
        "LOADTL/1\nCUTTER/10\nGOTO/0,0,0\nLOADTL/2\nCUTTER/8\nGOTO/0,0,0\nLOADTL/1\nGOTO/0,0,0\n\
         LOADTL/1\nCUTTER/10\nGOTO/0,0,0\nCUTTER/6\nGOTO/0,0,0\nFINI",
    );
    assert_eq!(
        p.tools.iter().map(|t| (t.number, t.diameter)).collect::<Vec<_>>(),
        [(1, 10.0), (2, 8.0), (1, 6.0)]
    );
    assert_eq!(p.moves.iter().filter_map(|m| m.tool).collect::<Vec<_>>(), [0, 1, 0, 0, 2]);
}

#[test]
fn faults_and_warnings() {
    for (text, line, code) in [
        ("\nGOTO/1,2,x", 2, ErrorCode::InvalidNumber),
        ("GOTO/1,2", 1, ErrorCode::AptStatement),
        ("GOTO/1,2,3,4", 1, ErrorCode::AptStatement),
        ("GOTO/1,,3", 1, ErrorCode::InvalidNumber),
        ("GOTO/1,2,nan", 1, ErrorCode::InvalidNumber),
        ("GOTO/1,2,1e300", 1, ErrorCode::InvalidNumber),
        ("INCHES\nGOTO/1,2,9e5", 2, ErrorCode::InvalidNumber),
        ("GOTO/1,2,3,0,0,0", 1, ErrorCode::AptStatement),
        ("GOTO/1,2,$", 1, ErrorCode::AptStatement),
        ("UNITS/FURLONGS", 1, ErrorCode::AptStatement),
        ("CUTTER/10,6", 1, ErrorCode::ProgramTool),
        ("PARTNO x\nFINI", 2, ErrorCode::NothingMoves),
        ("", 0, ErrorCode::FileEmpty),
        ("GOTO/0\0", 1, ErrorCode::NotText),
    ] {
        let error = fault(text);
        assert_eq!((error.line, error.code), (line, code), "{text:?}: {error}");
    }
    assert_eq!(fault(&"LOADTL/1\n".repeat(2000)).code, ErrorCode::FileTooLarge);
    let p = read("FEDRAT/0\nWOBBLE/0,0,0,1\nGOTO/1,2,3,\nWOBBLE\n");
    let lines: Vec<_> = p.warnings.iter().map(|w| w.line).collect();
    assert_eq!(lines, [1, 2, 4], "{:?}", p.warnings);
    assert!(
        p.warnings[1].message.contains("`WOBBLE` is not known and was left out, 2 times"),
        "{:?}",
        p.warnings
    );
}

#[test]
fn what_moves_and_is_not_followed_is_an_error() {
    for (statement, help) in [
        ("CIRCLE/0,0,0,0,0,1,5", "straight moves"),
        ("MOVARC/0,0,0,0,0,1,5,ANGLE,90", "straight moves"),
        ("CYCLE/DRILL,DEPTH,5", "single moves"),
        ("COPY/1,TRANSL,1,0,0,3", "repetitions"),
        ("INDEX/1", "repetitions"),
        ("ORIGIN/0,0,5", "coordinates of the part"),
        ("REFSYS/M1", "coordinates of the part"),
        ("MODE/INCR", "coordinates of the part"),
        ("TRANS/SCALE,2", "correct or export again"),
        ("TRACUT/2,0,0,0,0,2,0,0,0,0,2,0", "rotation"),
        ("TRACUT/1,0,0,0", "12 numbers"),
        ("GOFWD/L1", "locations"),
        ("GOTO/1,2,3,0,0,.5", "unit vector"),
        ("RETRCT\nGOTO/1,2,3", "by GOTO"),
    ] {
        let text = format!("FEDRAT/100\nGOTO/1,2,3\n{statement}\nGOTO/4,5,6\nFINI\n");
        let fault = fault(&text);
        assert_eq!(fault.line, 3, "{statement}: {fault}");
        assert!(fault.to_string().contains(help), "{statement}: {fault}");
    }
    for harmless in ["CYCLE/OFF", "ORIGIN/0,0,0", "MODE/ABSOL", "CUTCOM/OFF", "STOP", "GOHOME"] {
        let p = read(&format!("FEDRAT/100\nGOTO/1,2,3\n{harmless}\nFINI\n"));
        assert!(p.warnings.is_empty(), "{harmless}: {:?}", p.warnings);
    }
}

#[test]
fn positions_are_transformed() {
    // A quarter turn about z, then a shift; the lengths of both are in the program's unit.
    let p = read(
        "UNITS/CM\nTRACUT/0,-1,0,1,1,0,0,0,0,0,1,0\nTRANS/0,0,2\nGOTO/1,2,3,1,0,0\nTRACUT/NOMORE\n\
         GOTO/1,2,3\nTRANS/0,0,0\nGODLTA/1\nFINI\n",
    );
    let at: Vec<_> = p.moves.iter().map(|m| (m.tip, m.axis)).collect();
    assert_eq!(at[0], (Point::new(-10.0, 10.0, 50.0), Vector::y()));
    assert_eq!(at[1], (Point::new(10.0, 20.0, 50.0), Vector::x()));
    assert_eq!(at[2], (Point::new(20.0, 20.0, 30.0), Vector::x()));
}

#[test]
fn sections_and_rows_come_back() {
    let section =
        |from, to, kind| ClSection { from, to, diameter: 30.0, feed: CutDirection::InletToOutlet, kind };
    let mut wrote = sample();
    wrote.sections = vec![section(1.0, 0.5, SectionKind::Rows), section(1.0, 0.0, SectionKind::Rest)];
    wrote.rows = [(0, 0, 0), (3, 0, 1), (6, 1, 0)]
        .map(|(first_move, section, row)| ClRow { first_move, section, row })
        .to_vec();
    let text = write_apt(&wrote);
    assert!(text.contains("PPRINT/SECTION 2 FROM 1.0 TO 0.0 D 30.0 OUTWARD REST\n"), "{text}");
    assert!(text.contains("PPRINT/ROW 1 2\nRAPID\n"), "{text}");
    let got = read(&text);
    assert_eq!((got.sections, got.rows), (wrote.sections, wrote.rows));
}

fn tool(number: u32) -> impl Strategy<Value = ClTool> {
    (0.5..500.0, 0.0..0.5, 0.01..1.0, 1.0..1000.0, 1.0..20000.0).prop_map(
        move |(d, r, w, h, n): (f64, _, _, _, _)| ClTool {
            number,
            diameter: d,
            corner_radius: d * r,
            insert_width: Some(d / 2.0 * w),
            overhang: Some(h),
            feed_mm_per_min: None,
            spindle_rpm: Some(n),
            length_offset: None,
        },
    )
}

fn step() -> impl Strategy<Value = (bool, f64, [f64; 3], [f64; 3], bool)> {
    let direction = prop::array::uniform3(-1.0..1.0)
        .prop_filter("an axis", |[x, y, z]: &[f64; 3]| x * x + y * y + z * z > 1e-4);
    (any::<bool>(), 1.0..5000.0, prop::array::uniform3(-9e5..9e5), direction, any::<bool>())
}

proptest! {
    #[test]
    fn any_program_survives(
        name in "[ -~]{0,80}", tools in (tool(1), tool(2)), steps in prop::collection::vec(step(), 1..40),
    ) {
        let mut at = 0;
        let moves = steps.into_iter().map(|(rapid, feed, tip, axis, change)| {
            at = if change { 1 - at } else { at };
            let motion = if rapid { Motion::Rapid } else { Motion::Feed(Some(feed)) };
            let axis = Vector::from(axis).normalize();
            Move { motion, tip: Point::from(tip), axis, tool: Some(at), line: 0 }
        }).collect();
        let wrote = ClProgram { part: name, tools: vec![tools.0, tools.1], moves, ..ClProgram::default() };
        let text = write_apt(&wrote);
        prop_assert!(text.lines().all(|line| line.len() <= 72));
        let got = read(&text);
        prop_assert_eq!(&got.part, &write::part_name(&wrote.part));
        prop_assert!(got.warnings.is_empty());
        prop_assert_eq!(got.moves.len(), wrote.moves.len());
        for (a, b) in wrote.moves.iter().zip(&got.moves) {
            prop_assert!((a.tip - b.tip).amax() <= 5.1e-7, "{} {}", a.tip, b.tip);
            prop_assert!((a.axis - b.axis).amax() <= 2e-9, "{} {}", a.axis, b.axis);
            let (ta, tb) = (&wrote.tools[a.tool.unwrap()], &got.tools[b.tool.unwrap()]);
            prop_assert_eq!(ta.number, tb.number);
            prop_assert!((ta.diameter - tb.diameter).abs() < 1e-6);
            prop_assert!((ta.corner_radius - tb.corner_radius).abs() < 1e-6);
            prop_assert!((ta.insert_width.unwrap() - tb.insert_width.unwrap()).abs() < 1e-6);
            match (a.motion, b.motion) {
                (Motion::Feed(Some(f)), Motion::Feed(Some(g))) => prop_assert!((f - g).abs() < 1e-6),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }
}
