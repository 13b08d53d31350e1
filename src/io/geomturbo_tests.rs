use super::*;
use crate::error::ErrorCode;

fn read(file: &str, bytes: &[u8]) -> Result<PartDescription, InputError> {
    super::read(file, bytes, None)
}

/// A small valid file: two basic curves for the hub (the second in reverse), two rows.
pub const SAMPLE: &str = "GEOMETRY TURBO
VERSION 5.5
UNITS Meters
UNITS-FACTOR 1
NI_BEGIN CHANNEL
 NI_BEGIN basic_curve
  NAME hub a
  NI_BEGIN zrcurve
   ZR
   +2
   -0.01 0.02
   0.0 0.02
  NI_END zrcurve
 NI_END basic_curve
 NI_BEGIN basic_curve
  NAME empty
 NI_END basic_curve
 NI_BEGIN basic_curve
  NAME hub_b
  NI_BEGIN zrcurve
   ZR
   3
   0.03 0.05
   0.02 0.03
   0.000000001 0.02
  NI_END zrcurve
 NI_END basic_curve
 NI_BEGIN basic_curve
  NAME shr
  NI_BEGIN zrcurve
   ZR
   +2
   0.0 0.04
   0.02 0.05
  NI_END zrcurve
 NI_END basic_curve
 NI_BEGIN channel_curve hub
  NAME hub
  VERTEX CURVE_P hub a 0
  VERTEX CURVE_P hub a 1
  VERTEX CURVE_P empty 0
  VERTEX CURVE_P empty 1
  VERTEX CURVE_P hub_b 1
  VERTEX CURVE_P hub_b 0
 NI_END channel_curve hub
 NI_BEGIN channel_curve shroud
  VERTEX CURVE_P shr 0
  VERTEX CURVE_P shr 1
 NI_END channel_curve shroud
NI_END CHANNEL
NI_BEGIN nirow
 NAME row
 PERIODICITY 7
 ROTATION_SPEED -1000
 NI_BEGIN NIBlade
  NI_BEGIN NITipGap
   NI_BEGIN unknown
   NI_END unknown
   WIDTH 0.1
  NI_END NITipGap
  NI_BEGIN nibladegeometry
   TYPE GEOMTURBO
   units 0.001
   pressure
   SECTIONAL
   2
   # section 1
   XYZ
   +2
   20.0 0.0 0.0
   50.0 0.0 25.0
   ZRTH
   2
   1.0 40.0 0.5
   18.0 50.0 0.25
   SUCTION
   SECTIONAL
   2
   XYZ
   2
   20.0 0.0 0.0
   50.0 1.0 25.0
   XYZ
   2
   30.0 0.0 1.0
   50.0 1.0 18.0
  NI_END nibladegeometry
 NI_END NIBlade
NI_END nirow
NI_BEGIN nirow
 PERIODICITY 99
 NI_BEGIN NIBlade
  NI_BEGIN nibladegeometry
  NI_END nibladegeometry
 NI_END NIBlade
NI_END nirow
NI_END GEOMTURBO
";

fn fault(from: &str, to: &str) -> InputError {
    assert!(SAMPLE.contains(from), "{from} must be in the sample");
    read("a/b.geomTurbo", SAMPLE.replacen(from, to, 1).as_bytes()).expect_err("must be refused")
}

#[test]
fn chains_curves_and_turns_them() {
    let part = read("a/b.geomTurbo", SAMPLE.as_bytes()).unwrap();
    let CurveDescription::Points(hub) = &part.hub else { panic!("points expected") };
    let rounded: Vec<_> = hub.iter().map(|p| (p.r.round(), p.z.round())).collect();
    assert_eq!(rounded, [(20.0, -10.0), (20.0, 0.0), (30.0, 20.0), (50.0, 30.0)]);
    assert_eq!((part.name.as_str(), part.blade_count, part.count_line), ("b", 7, 53));
    assert!(part.splitters.is_empty(), "the second row is not the impeller's");
}

#[test]
fn blade_units_order_and_polar_sections() {
    let part = read("b.geomTurbo", SAMPLE.as_bytes()).unwrap();
    let BladeDescription::Sections { suction, pressure, line } = &part.main else { panic!("sections") };
    assert_eq!((*line, suction.len(), pressure.len()), (61, 2, 2));
    assert!((suction[0][1] - Point::new(50.0, 1.0, 25.0)).norm() < 1e-9, "{:?}", suction[0][1]);
    let polar = Point::new(40.0 * 0.5f64.cos(), 40.0 * 0.5f64.sin(), 1.0);
    assert!((pressure[1][0] - polar).norm() < 1e-9, "{:?}", pressure[1][0]);
}

#[test]
fn file_units_scale_channel_and_blades() {
    for header in ["UNITS Millimeters\nUNITS-FACTOR 1", "UNITS mm\nUNITS-FACTOR 0.001", "UNITS-FACTOR 0.001"]
    {
        let text = SAMPLE.replace("UNITS Meters\nUNITS-FACTOR 1", header).replace("units 0.001", "units 1");
        let part = read("b.geomTurbo", text.as_bytes()).unwrap();
        let CurveDescription::Points(shroud) = &part.shroud else { panic!("points expected") };
        assert!((shroud[0].r - 0.04).abs() < 1e-12, "{header}: {:?}", shroud[0]);
        let BladeDescription::Sections { suction, .. } = &part.main else { panic!("sections") };
        assert!((suction[0][1].x - 50.0).abs() < 1e-9, "{header}: {:?}", suction[0][1]);
    }
}

#[test]
fn a_size_that_no_wheel_has_is_refused_unless_the_unit_is_given() {
    // Millimetres, but the file says metres.
    let scale = |line: &str| {
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == 2 && !line.contains('+') => {
                numbers.iter().map(|x| (1000.0 * x).to_string()).collect::<Vec<_>>().join(" ")
            }
            _ => line.to_owned(),
        }
    };
    let text: Vec<String> = SAMPLE.replace("units 0.001", "units 1").lines().map(scale).collect();
    let text = text.join("\n");
    let error = read("b.geomTurbo", text.as_bytes()).unwrap_err();
    assert_eq!(error.code, ErrorCode::MeshUnit, "{error}");
    assert!(error.help.contains("--unit mm (100.0200 mm)"), "{error}");
    let part = super::read("b.geomTurbo", text.as_bytes(), Some(LengthUnit::Millimetre)).unwrap();
    assert!((part.diameter() - 100.02).abs() < 1e-3, "{}", part.diameter());
    let CurveDescription::Points(hub) = &part.hub else { panic!("points expected") };
    assert!((hub[0].r - 20.0).abs() < 1e-9, "{:?}", hub[0]);
}

#[test]
fn case_of_keywords_does_not_matter() {
    assert!(read("b.geomTurbo", SAMPLE.to_uppercase().as_bytes()).is_ok());
    assert!(read("b.geomTurbo", SAMPLE.to_lowercase().as_bytes()).is_ok());
    assert!(read("b.geomTurbo", SAMPLE.replace('\n', "\r\n").as_bytes()).is_ok());
}

#[test]
fn faults_name_their_line() {
    for (from, to, below) in [
        ("0.02 0.03", "0.02 nan", 0),
        ("0.02 0.03", "0.02 1e300", 0),
        ("0.02 0.03", "0.02", 0),
        ("+2\n", "+99999999999\n", 0),
        ("CURVE_P hub_b 1", "CURVE_P hub_b 0.5", 0),
        ("CURVE_P hub_b 1", "CURVE_P hub_c 1", 0),
        ("PERIODICITY 7", "PERIODICITY 10000", 0),
        ("PERIODICITY 7", "PERIODICITY 0", 0),
        ("units 0.001", "units 0", 0),
        ("units 0.001", "units 1000", -2),
        ("UNITS Meters", "UNITS Parsecs", 0),
        ("SECTIONAL", "BEZIER", 0),
        ("   ZRTH", "   RTHZ", 0),
        ("   2\n   # section 1", "   1\n", -5),
    ] {
        let error = fault(from, to);
        let at = SAMPLE.find(from).unwrap();
        let line = 1 + SAMPLE[..at].matches('\n').count() as isize + below;
        assert_eq!(error.line as isize, line, "{from} → {to}: {error}");
    }
    assert!(fault("0.02 0.03", "0.02 -0.03").message.contains("r = -30"));
}

#[test]
fn missing_pieces_have_their_code() {
    for (from, to, code) in [
        ("channel_curve shroud", "channel_curve nozzle", ErrorCode::FlowCurve),
        (" PERIODICITY 7\n", "", ErrorCode::BladeCount),
        ("nibladegeometry", "something", ErrorCode::BladeSections),
        ("SUCTION", "NOTHING", ErrorCode::BladeSections),
    ] {
        let error = fault(from, to);
        assert_eq!(error.code, code, "{error}");
    }
    let one = SAMPLE
        .replace("   2\n   # section 1", "   1\n")
        .replace("SECTIONAL\n   2\n   XYZ", "SECTIONAL\n   1\n   XYZ");
    let error = read("b.geomTurbo", one.as_bytes()).unwrap_err();
    assert_eq!(error.code, ErrorCode::BladeSections, "{error}");
    let cut = SAMPLE.find("NI_END nirow").map(|at| &SAMPLE[..at]).unwrap();
    let error = read("b.geomTurbo", cut.as_bytes()).unwrap_err();
    assert_eq!(error.code, ErrorCode::FileCutOff, "{error}");
}
