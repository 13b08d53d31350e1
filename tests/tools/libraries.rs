//! Tool libraries of Fusion and FreeCAD, and our own.

use serde_json::{Value, json};
use vanecut::io::setup_file::read_setup_bytes;
use vanecut::io::shop_tools::{
    LibraryFormat, LibraryTool, ToolLibrary, read_library_bytes, write_fusion, write_toml,
};
use vanecut::setup::{MissingRates, Tool};

fn library() -> Value {
    json!({"version": 36, "data": [
        {
            "type": "face mill", "unit": "inches", "description": "cutter with inserts",
            "geometry": {"DC": 1.0, "RE": 0.03125, "LCF": 0.4, "LB": 3.0, "NOF": 3, "SFDM": 0.75,
                "shoulder-length": 1.0, "shoulder-diameter": 0.9},
            "expressions": {"tool_diameter": "1.25 in", "tool_bodyLength": "tool_fluteLength * 8",
                "tool_fluteLength": "10 mm"},
            "post-process": {"number": 7, "length-offset": 8, "diameter-offset": 9},
            "start-values": {"presets": [{"n": 900, "v_f_plunge": 10.0, "f_z": 0.004, "v_c": 300,
                "expressions": {"tool_feedPlunge": "tool_feedCutting / 2", "tool_feedCutting": "20 inpm"}}]},
            "holder": {"unit": "millimeters", "gaugeLength": 70.0, "segments": [
                {"height": 30, "lower-diameter": 40, "upper-diameter": 50},
                {"height": 40, "lower-diameter": 50, "upper-diameter": 50},
                {"height": 2, "lower-diameter": 46, "upper-diameter": 46}]}
        },
        {
            "type": "flat end mill", "unit": "millimeters", "description": "old",
            "geometry": {"DC": 4, "LB": 50, "LCF": 10, "NOF": 3, "RE": 0, "SFDM": 6, "shoulder-length": 14},
            "post-process": {"number": 7},
            "start-values": {"*": {"n": 20000, "v_f_plunge": 150, "f_z": 0.005, "v_c": 251.3}}
        },
        {"type": "drill", "unit": "millimeters", "description": "drill", "geometry": {"DC": 3}},
    ]})
}

fn read(tree: &Value) -> ToolLibrary {
    read_library_bytes("shop.json", tree.to_string().as_bytes(), LibraryFormat::FusionJson).expect("reads")
}

#[test]
fn units_expressions_presets_and_segments_of_fusion() {
    let library = read(&library());
    let [first, second] = library.tools.as_slice() else { panic!("two mills: {library:?}") };
    let tool = &first.tool;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    near(tool.diameter, 31.75);
    near(tool.overhang, 80.0);
    near(tool.insert_width, 0.45 * 31.75);
    near(tool.plunge_feed, 254.0);
    near(tool.assembly.feed_per_tooth.unwrap(), 0.1016);
    near(tool.assembly.cutting_speed.unwrap(), 91.44);
    near(tool.assembly.flute_length.unwrap(), 10.0);
    assert_eq!((tool.number, tool.spindle, tool.assembly.teeth), (7, 900.0, Some(3)));
    assert_eq!((tool.assembly.length_offset, tool.assembly.diameter_offset), (Some(8), Some(9)));
    // The holder is in mm inside an inch tool; the segment beyond the gauge line is in the spindle.
    assert_eq!(tool.assembly.holder, [[40.0, 50.0, 30.0], [50.0, 50.0, 40.0]]);
    let shank = &tool.assembly.shank;
    near(shank[0][0], 22.86);
    near(shank[0][1], 15.4);
    near(shank[1][0], 19.05);
    near(shank[1][1], 54.6);
    assert!(first.notes.iter().any(|note| note.contains("insert width assumed")), "{:?}", first.notes);
    let old = &second.tool;
    assert_eq!((old.number, old.plunge_feed, old.spindle), (8, 150.0, 20000.0), "the number 7 is taken");
    assert_eq!(old.assembly.shank, [[4.0, 4.0], [6.0, 36.0]]);
    assert!(library.notes.iter().any(|note| note.contains("drill")), "{:?}", library.notes);
}

#[test]
fn what_is_written_reads_back() {
    let library = read(&library());
    let text = write_toml(&library);
    assert!(text.contains("# insert width assumed"), "{text}");
    let own = read_library_bytes("t.toml", text.as_bytes(), LibraryFormat::Toml).expect("reads");
    let tools = |library: &ToolLibrary| library.tools.iter().map(|t| t.tool.clone()).collect::<Vec<_>>();
    assert_eq!(tools(&own), tools(&library));
    let fusion = read_library_bytes("t.json", write_fusion(&library).as_bytes(), LibraryFormat::FusionJson);
    let fusion = tools(&fusion.expect("reads"));
    for (written, read) in tools(&library).iter().zip(&fusion) {
        assert_eq!(
            (written.number, written.assembly.holder.len()),
            (read.number, read.assembly.holder.len())
        );
        // Lengths pass through the unit of the file.
        for (written, read) in written.assembly.holder.iter().zip(&read.assembly.holder) {
            assert!(written.iter().zip(read).all(|(w, r)| (w - r).abs() < 1e-9), "{written:?}, not {read:?}");
        }
        assert_eq!((written.diameter, written.overhang), (read.diameter, read.overhang));
        assert_eq!((written.plunge_feed, written.spindle), (read.plunge_feed, read.spindle));
        let shank = |tool: &Tool| tool.assembly.shank.clone();
        assert_eq!(shank(written).len(), shank(read).len());
        for (written, read) in shank(written).iter().zip(&shank(read)) {
            assert!(written.iter().zip(read).all(|(w, r)| (w - r).abs() < 1e-9), "{written:?}, not {read:?}");
        }
    }
}

/// A ZIP archive with one member, stored or deflated.
fn zip(member: &str, content: &[u8], deflate: bool) -> Vec<u8> {
    let packed = if deflate { miniz_oxide::deflate::compress_to_vec(content, 6) } else { content.to_vec() };
    let crc = !content.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    });
    let mut common = Vec::new();
    common.extend([20, 0, 0, 0, if deflate { 8 } else { 0 }, 0, 0, 0, 0, 0]);
    for word in [crc, packed.len() as u32, content.len() as u32] {
        common.extend(word.to_le_bytes());
    }
    common.extend((member.len() as u16).to_le_bytes());
    common.extend([0, 0]);
    let mut out = b"PK\x03\x04".to_vec();
    out.extend(&common);
    out.extend(member.as_bytes());
    out.extend(&packed);
    let directory = out.len() as u32;
    out.extend(b"PK\x01\x02\x14\x00");
    out.extend(&common);
    out.extend([0; 14]);
    out.extend(member.as_bytes());
    let size = out.len() as u32 - directory;
    out.extend(b"PK\x05\x06\x00\x00\x00\x00\x01\x00\x01\x00");
    out.extend(size.to_le_bytes());
    out.extend(directory.to_le_bytes());
    out.extend([0, 0]);
    out
}

#[test]
fn archives_stored_and_deflated() {
    let expected = read(&library());
    for deflate in [false, true] {
        let bytes = zip("tools.json", library().to_string().as_bytes(), deflate);
        let found = read_library_bytes("shop.tools", &bytes, LibraryFormat::FusionTools).expect("reads");
        assert_eq!(found, expected);
    }
}

#[test]
fn no_cut_or_changed_archive_panics_or_passes_as_another_library() {
    let expected = read(&library());
    let whole = zip("tools.json", library().to_string().as_bytes(), true);
    for end in 0..whole.len() {
        assert!(read_library_bytes("x.tools", &whole[..end], LibraryFormat::FusionTools).is_err(), "{end}");
    }
    for at in 0..whole.len() {
        let mut changed = whole.clone();
        changed[at] ^= 0x55;
        if let Ok(found) = read_library_bytes("x.tools", &changed, LibraryFormat::FusionTools) {
            assert_eq!(found, expected, "byte {at}");
        }
    }
}

#[test]
fn a_tool_bit_of_freecad() {
    let bit = json!({"version": 2, "name": "6 mm Bull Nose", "shape": "bullnose.fcstd",
        "shape-type": "Bullnose", "attribute": {}, "parameter": {
            "CuttingEdgeHeight": "40.0000 mm", "Diameter": "6.0000 mm", "CornerRadius": "1.5000 mm",
            "Length": "50.0000 mm", "ShankDiameter": "3.0000 mm"}});
    let read =
        read_library_bytes("b.fctb", bit.to_string().as_bytes(), LibraryFormat::FreeCadBit).expect("reads");
    let tool = &read.tools[0].tool;
    assert_eq!((tool.diameter, tool.corner_radius, tool.overhang), (6.0, 1.5, 50.0));
    assert_eq!((tool.assembly.flute_length, tool.assembly.shank.clone()), (Some(40.0), vec![[3.0, 10.0]]));
    assert!((tool.insert_width - 2.7).abs() < 1e-12, "it has a core, as from Fusion: {}", tool.insert_width);
    // The holder is known once it is given.
    let mut entry = LibraryTool::clone(&read.tools[0]);
    assert!(entry.notes.iter().any(|note| note.contains("holder")), "{:?}", entry.notes);
    let mut held = entry.tool.clone();
    held.assembly.holder = vec![[20.0, 20.0, 40.0]];
    entry.replace(held);
    assert!(entry.notes.iter().all(|note| !note.contains("holder")), "{:?}", entry.notes);
}

/// Older versions give the radius of the flat bottom.
#[test]
fn a_bull_nose_of_an_older_freecad() {
    let bit = json!({"version": 2, "name": "5 mm Bull Nose", "shape": "bullnose.fcstd", "parameter": {
        "CuttingEdgeHeight": "40 mm", "Diameter": "5 mm", "FlatRadius": "1.5 mm", "Length": "50 mm"}});
    let read =
        read_library_bytes("b.fctb", bit.to_string().as_bytes(), LibraryFormat::FreeCadBit).expect("reads");
    assert_eq!(read.tools[0].tool.corner_radius, 1.0);
    assert!(read.tools[0].notes.iter().all(|note| !note.contains("corner")), "{:?}", read.tools[0].notes);
}

#[test]
fn a_mill_with_a_fault_is_left_out_and_the_only_one_refused() {
    let faulty = with("/data/0/unit", json!("feet"));
    let whole = read(&library());
    let left = read_library_bytes("shop", faulty.as_bytes(), LibraryFormat::FusionJson).expect("the others");
    assert_eq!(left.tools.len() + 1, whole.tools.len());
    assert!(left.notes.iter().any(|note| note.contains("`feet`")), "{:?}", left.notes);
    let mut alone: Value = serde_json::from_str(&faulty).unwrap();
    alone["data"].as_array_mut().unwrap().truncate(1);
    let error = read_library_bytes("shop", alone.to_string().as_bytes(), LibraryFormat::FusionJson);
    assert!(error.expect_err("no other mill").to_string().contains("`feet`"));
    let drill = json!({"name": "d", "shape": "drill.fcstd", "parameter": {"Diameter": "6 mm"}}).to_string();
    let error = read_library_bytes("d.fctb", drill.as_bytes(), LibraryFormat::FreeCadBit);
    assert!(error.expect_err("no mill").to_string().contains("not a mill"));
}

/// Sets the value at a JSON pointer.
fn with(pointer: &str, value: Value) -> String {
    let mut tree = library();
    *tree.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer} must be in the library")) = value;
    tree.to_string()
}

#[test]
fn thirty_broken_libraries_are_named_in_one_line() {
    use LibraryFormat::{FreeCadBit, FreeCadLibrary, FusionJson, FusionTools, Toml};
    let segments = "/data/0/holder/segments";
    let many = Value::Array(vec![json!({"height": 1, "lower-diameter": 9, "upper-diameter": 9}); 51]);
    let bit = |key: &str, value: Value| {
        let mut tree = json!({"name": "x", "shape": "endmill.fcstd", "parameter": {"Diameter": "6 mm"}});
        tree["parameter"][key] = value;
        tree.to_string()
    };
    let toml = |line: &str| format!("[[tool]]\ndiameter = 10\noverhang = 50\n{line}\n");
    let archive = |name: &str, content: &[u8]| zip(name, content, true);
    let mut encrypted = archive("tools.json", b"{}");
    let at = encrypted.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
    encrypted[at + 8] = 1;
    let cases: Vec<(LibraryFormat, Vec<u8>, &str)> = vec![
        (FusionJson, b"".to_vec(), "empty"),
        (FusionJson, b"{\"data\": [".to_vec(), "not valid JSON"),
        (FusionJson, b"[]".to_vec(), "no list `data`"),
        (FusionJson, b"{\"data\": 3}".to_vec(), "no list `data`"),
        (FusionJson, b"{\"data\": []}".to_vec(), "no end mill"),
        (FusionJson, b"{\"data\": [7]}".to_vec(), "entry 1: it is not a tool"),
        (FusionJson, vec![b'['; 100_000], "not valid JSON"),
        (
            FusionJson,
            format!("{{\"data\": [{{\"type\": [{}0]}}]}}", "0,".repeat(100_001)).into_bytes(),
            "more than 100000 values",
        ),
        (
            FusionJson,
            format!("{{\"data\": [{}0]}}", "0,".repeat(200_001)).into_bytes(),
            "more than 200000 entries",
        ),
        (FusionJson, with("/data/0/unit", json!("feet")).into(), "`feet`"),
        (FusionJson, with("/data/0/unit", json!(3)).into(), "neither millimeters nor inches"),
        (FusionJson, with("/data/0/geometry", json!(null)).into(), "no `geometry`"),
        (FusionJson, with("/data/1/geometry/DC", json!(-4)).into(), "-4"),
        (FusionJson, with("/data/1/geometry/DC", json!("4 mm")).into(), "`DC` is not a number"),
        (FusionJson, with("/data/1/geometry/DC", json!(null)).into(), "no diameter"),
        (FusionJson, with("/data/1/geometry/DC", json!(1e300)).into(), "`diameter`"),
        (FusionJson, with("/data/0/holder/unit", json!("mils")).into(), "its holder has the unit `mils`"),
        (FusionJson, with(segments, json!("none")).into(), "not a list"),
        (FusionJson, with(segments, many).into(), "51 segments"),
        (FusionJson, with(&format!("{segments}/0/height"), json!(-30)).into(), "negative"),
        (FusionJson, with(&format!("{segments}/0/height"), json!(null)).into(), "no `height`"),
        (FusionJson, with("/data/0/start-values/presets", json!(1)).into(), "`presets` is not a list"),
        (FusionTools, b"PK".to_vec(), "not a ZIP archive"),
        (FusionTools, archive("tools.txt", b"{}"), "no .json"),
        (FusionTools, archive("tools.json", b"{}"), "no list `data`"),
        (FusionTools, encrypted, "encrypted"),
        (FreeCadBit, b"{}".to_vec(), "no object `parameter`"),
        (FreeCadBit, bit("Diameter", json!("six")).into(), "`Diameter` is not a length"),
        (FreeCadBit, bit("Diameter", json!("0 mm")).into(), "no `Diameter`"),
        (FreeCadBit, bit("Length", json!("1e9 mm")).into(), "`Length` is not a length"),
        (FreeCadLibrary, b"{\"version\": 1}".to_vec(), "no list `tools`"),
        (FreeCadLibrary, b"{\"tools\": [{\"nr\": 1}]}".to_vec(), "no `path`"),
        (
            FreeCadLibrary,
            b"{\"tools\": [{\"path\": \"../../etc/x.fctb\"}]}".to_vec(),
            "not a .fctb file beside",
        ),
        (Toml, toml("holdr = 3").into(), "nearest known key"),
        (Toml, toml("holder = [[40, 50]]").into(), "3 numbers"),
        (Toml, toml("holder = [[40, 50, 0]]").into(), "segment 1 of `holder`"),
        (Toml, toml("shank = [[8, 60]]").into(), "no flute length"),
        (Toml, toml("flute_length = 60").into(), "longer than the overhang"),
        (Toml, "[[tool]]\ndiameter = 8\n".repeat(50_001).into(), "more than 50000 tools"),
        (Toml, toml("teeth = 0").into(), "whole number"),
        (Toml, toml("feed_per_tooth = 1e-12").into(), "give a number from 0.0001 to 5"),
        (Toml, toml("cutting_speed = 1e5").into(), "give a number from 0.1 to 10000"),
        (Toml, toml("plunge_feed = 1e-9").into(), "give a number from 0.01 to 100000"),
        (Toml, toml("spindle = 1e-9").into(), "give a number from 1 to 1000000"),
        (Toml, toml("teeth = 200\nfeed_per_tooth = 5\nspindle = 20000").into(), "2.000e7 mm/min"),
        (Toml, "[[tool]]\ndiameter = 0.001\ncutting_speed = 9999\n".into(), "rev/min of a diameter of 0.001"),
        (Toml, toml("taper = 80").into(), "`taper` is 80"),
        (Toml, toml(&format!("name = \"{}\"", "x".repeat(201))).into(), "more than 200"),
    ];
    for (format, bytes, words) in cases {
        let error = match read_library_bytes("shop", &bytes, format) {
            // A mill with a fault beside others is left out.
            Ok(library) => {
                let left_out = library.notes.iter().find(|note| note.contains(words)).expect(words);
                assert!(left_out.contains("is left out: "), "{left_out}");
                continue;
            }
            Err(error) => error.to_string(),
        };
        assert!(error.contains(words) && error.starts_with("shop"), "{words}: {error}");
        assert!(error.lines().count() == 1 && error.len() < 400, "{error}");
    }
}

/// A library of `count` end mills in inches with holders in mm, of three lengths each, and a drill for each
/// ten.
fn large(count: usize) -> Vec<u8> {
    let mut tools = Vec::new();
    for k in 0..count {
        let diameter = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 1.0][k % 7];
        let length = diameter * [2.5, 4.0, 6.0][k % 3] + 0.001 * k as f64 / count as f64;
        tools.push(json!({
            "guid": format!("{k:08x}-0000-4000-8000-000000000000"), "unit": "inches", "BMC": "carbide",
            "type": if k % 10 == 9 { "drill" } else { ["flat end mill", "bull nose end mill", "ball end mill"][k % 3] },
            "description": format!("{diameter} in end mill, no. {k} \"XL\" [long] {{coated}}"), "vendor": "maker",
            "geometry": {"DC": diameter, "RE": if k % 3 == 1 { 0.03 } else { 0.0 }, "LCF": 1.5 * diameter,
                "LB": length, "OAL": length + 1.5, "NOF": 4, "SFDM": diameter, "shoulder-length": 1.6 * diameter,
                "shoulder-diameter": diameter, "CSP": false, "HAND": true, "assemblyGaugeLength": length + 3.0},
            "expressions": {"tool_diameter": format!("{diameter} in"), "tool_description": "'x'"},
            "holder": {"type": "holder", "unit": "millimeters", "gaugeLength": 60.0, "description": "ER16", "segments": [
                {"height": 20, "lower-diameter": 22, "upper-diameter": 28},
                {"height": 40, "lower-diameter": 40, "upper-diameter": 40},
                {"height": 2, "lower-diameter": 46, "upper-diameter": 46}]},
            "post-process": {"number": 0, "length-offset": 0, "diameter-offset": 0},
            "start-values": {"presets": [{"name": "steel", "n": 0, "f_z": 0, "v_f_plunge": 0}]},
        }));
    }
    serde_json::to_vec(&json!({"data": tools, "version": 36})).expect("writes")
}

#[test]
fn a_library_of_a_maker_with_many_thousand_tools_is_read_and_reported_in_few_lines() {
    // More tools than there are numbers of four digits.
    let bytes = large(12_000);
    let library = read_library_bytes("maker.json", &bytes, LibraryFormat::FusionJson).expect("reads");
    assert_eq!(library.tools.len(), 10_800);
    let numbers: std::collections::BTreeSet<u32> = library.tools.iter().map(|t| t.tool.number).collect();
    assert_eq!(numbers.len(), 10_800, "each has a number of its own");
    let remarks = library.remarks();
    assert!(remarks.len() < 30, "{remarks:#?}");
    assert!(remarks.iter().any(|line| line.starts_with("1200 tools are left out: `drill`")), "{remarks:#?}");
    let text = write_toml(&library);
    let own = read_library_bytes("t.toml", text.as_bytes(), LibraryFormat::Toml).expect("reads");
    assert_eq!(own.tools.len(), 10_800);
    let mills = library.tools.iter().zip(&own.tools);
    assert!(mills.into_iter().all(|(read, own)| read.tool == own.tool));
}

#[test]
fn a_setup_with_a_library_of_thousands_is_resolved_with_what_the_part_needs() {
    let library = read_library_bytes("maker.json", &large(6_000), LibraryFormat::FusionJson).expect("reads");
    let part = super::assembly::pump();
    let setup = read_setup_bytes("s.toml", write_toml(&library).as_bytes()).expect("a setup");
    assert_eq!(setup.tools.len(), 5_400);
    let workpiece = setup.allowances.workpiece_of(part);
    let resolved = vanecut::job::resolve(&setup, &workpiece).expect("a choice");
    let used = &resolved.setup.tools;
    assert!((1..=5).contains(&used.len()), "{} tools stay in the plan", used.len());
    assert!(used.iter().all(Tool::is_flat), "balls do not plunge where there are others");
}

#[test]
fn rates_that_a_library_does_not_say_stay_unknown() {
    let mut tree = library();
    tree["data"][0]["start-values"]["presets"][0] = json!({"name": "x"});
    tree["data"][1]["start-values"]["*"] = json!({"f_z": 0.005, "v_c": 251.3});
    let read = read(&tree);
    let [first, second] = read.tools.as_slice() else { panic!("two mills") };
    assert_eq!(first.tool.assembly.missing_rates, MissingRates::ALL);
    assert!(first.notes.iter().any(|note| note.contains("by `material`")), "{:?}", first.notes);
    // What follows from the cutting data of the tool is no guess.
    assert!(!second.notes.iter().any(|note| note.contains("by `material`")), "{:?}", second.notes);
    assert!((second.tool.spindle - 251_300.0 / (4.0 * std::f64::consts::PI)).abs() < 1e-6);
    let text = write_toml(&read);
    assert!(!text.contains("spindle =") && !text.contains("plunge_feed ="), "{text}");
    for (material, spindle) in [("titanium", 40.0), ("aluminium", 400.0)] {
        let setup = format!("{text}\n[stock]\nmaterial = \"{material}\"\n");
        let setup = read_setup_bytes("s.toml", setup.as_bytes()).expect("reads");
        let wanted = spindle * 1e3 / (std::f64::consts::PI * 31.75);
        assert!((setup.tools[0].spindle - wanted).abs() <= 0.5, "{material}: {}", setup.tools[0].spindle);
        assert_eq!(setup.tools[1].spindle, second.tool.spindle, "its own cutting speed stands");
    }
    let fusion: Value = serde_json::from_str(&write_fusion(&read)).expect("JSON");
    assert_eq!(fusion["data"][0]["start-values"]["presets"][0]["n"], Value::Null);
    let again = read_library_bytes("t.json", write_fusion(&read).as_bytes(), LibraryFormat::FusionJson);
    assert_eq!(again.expect("reads").tools[0].tool.assembly.missing_rates, MissingRates::ALL);
    let own = read_library_bytes("t.toml", text.as_bytes(), LibraryFormat::Toml).expect("reads");
    assert_eq!(own.tools[0].tool.assembly.missing_rates, MissingRates::ALL);
}

#[test]
fn corner_radii_that_are_assumed_or_changed_are_named() {
    for (kind, given, taken, words) in [
        ("ball end mill", json!(0), 2.0, "corner radius assumed: half of the diameter"),
        ("ball end mill", json!(null), 2.0, "corner radius assumed: half of the diameter"),
        ("ball end mill", json!(1), 2.0, "1 mm does not fit a ball end mill"),
        ("lollipop mill", json!(2), 2.0, ""),
        ("bull nose end mill", json!(9), 2.0, "9 mm does not fit a bull nose end mill"),
        ("bull nose end mill", json!(0), 0.0, "a sharp corner"),
        ("flat end mill", json!(-1), 0.0, "-1 mm does not fit a flat end mill"),
        ("flat end mill", json!(0), 0.0, ""),
    ] {
        let mut tree = library();
        tree["data"][1]["type"] = json!(kind);
        tree["data"][1]["geometry"]["RE"] = given.clone();
        let read = read(&tree);
        let found = &read.tools[1];
        assert_eq!(found.tool.corner_radius, taken, "{kind}, {given}");
        let corner: Vec<&String> = found.notes.iter().filter(|note| note.contains("corner")).collect();
        match words {
            "" => assert!(corner.is_empty(), "{corner:?}"),
            words => assert!(corner.len() == 1 && corner[0].contains(words), "{kind}, {given}: {corner:?}"),
        }
    }
}

#[test]
fn impossible_rates_of_a_preset_are_left_out_and_named() {
    let mut tree = library();
    tree["data"][1]["start-values"]["*"] = json!({"n": 20000, "v_f_plunge": 1e-9, "f_z": 1e-12, "v_c": 1e9});
    let read = read(&tree);
    let found = &read.tools[1];
    assert_eq!((found.tool.assembly.feed_per_tooth, found.tool.assembly.cutting_speed), (None, None));
    let missing = found.tool.assembly.missing_rates;
    assert!(missing.plunge_feed && !missing.spindle);
    for key in ["`v_f_plunge`", "`f_z`", "`v_c`"] {
        assert!(found.notes.iter().any(|note| note.contains(key)), "{key}: {:?}", found.notes);
    }
}

#[test]
fn fractions_and_commas_of_freecad_are_lengths_and_bits_at_fault_are_left_out() {
    let bit = |diameter: &str, shape: &str| {
        // Older files have the teeth among the attributes.
        let flutes = if shape == "endmill" { ["Flutes", "Other"] } else { ["Other", "Flutes"] };
        json!({"name": "x", "shape": shape, "parameter": {"Diameter": diameter, "Length": "2 1/2\"",
            "CuttingEdgeHeight": "12,5 mm", flutes[0]: "3"}, "attribute": {flutes[1]: "3"}})
        .to_string()
    };
    for (text, mm) in [("1/4 in", 6.35), ("5,0 mm", 5.0), ("1 1/4\"", 31.75), ("0.375 \"", 9.525)] {
        let read = read_library_bytes("b.fctb", bit(text, "endmill").as_bytes(), LibraryFormat::FreeCadBit);
        let tool = &read.expect(text).tools[0].tool;
        assert!((tool.diameter - mm).abs() < 1e-9, "{text}: {}", tool.diameter);
        assert_eq!((tool.overhang, tool.assembly.flute_length), (63.5, Some(12.5)));
        assert_eq!(tool.assembly.teeth, Some(3));
    }
    let folder = tempfile_folder("fctl");
    std::fs::write(folder.join("good.fctb"), bit("6 mm", "endmill.fcstd")).unwrap();
    std::fs::write(folder.join("bad.fctb"), bit("six", "endmill.fcstd")).unwrap();
    let mut tools = vec![json!({"nr": 4, "path": "good.fctb"}), json!({"nr": 1, "path": "bad.fctb"})];
    tools.push(json!({"nr": 2}));
    tools.push(json!({"nr": 3, "path": "../up.fctb"}));
    tools.push(json!({"nr": 90, "path": "gone.fctb"}));
    for k in 0..40 {
        std::fs::write(folder.join(format!("d{k}.fctb")), bit("6 mm", "drill.fcstd")).unwrap();
        tools.push(json!({"nr": 10 + k, "path": format!("d{k}.fctb")}));
    }
    // Bits in a folder beside that of the library.
    let bits = folder.join("ToolBits");
    std::fs::create_dir_all(&bits).unwrap();
    std::fs::write(bits.join("beside.fctb"), bit("8 mm", "endmill.fcstd")).unwrap();
    std::fs::create_dir_all(folder.join("Library")).unwrap();
    let elsewhere = json!({"tools": [{"nr": 5, "path": "beside.fctb"}]}).to_string();
    let path = folder.join("Library/shop.fctl");
    std::fs::write(&path, elsewhere).unwrap();
    let read = vanecut::io::shop_tools::read_library(&path, LibraryFormat::FreeCadLibrary).expect("one bit");
    assert_eq!((read.tools[0].tool.number, read.tools[0].tool.diameter), (5, 8.0));
    let path = folder.join("shop.fctl");
    std::fs::write(&path, json!({"tools": tools}).to_string()).unwrap();
    let read =
        vanecut::io::shop_tools::read_library(&path, LibraryFormat::FreeCadLibrary).expect("one is good");
    assert_eq!(read.tools.iter().map(|t| t.tool.number).collect::<Vec<_>>(), [4]);
    assert!(read.tools[0].tool.assembly.missing_rates.spindle, "FreeCAD has no feeds");
    assert_eq!(read.notes.len(), 5, "{:#?}", read.notes);
    for named in ["tool 1, `bad.fctb`,", "tool 2 is", "tool 3, `../up.fctb`,", "tool 90, `gone.fctb`,"] {
        assert!(read.notes.iter().any(|note| note.starts_with(named)), "{named}: {:#?}", read.notes);
    }
    assert_eq!(read.tools[0].tool.assembly.teeth, Some(3));
    std::fs::remove_dir_all(&folder).unwrap();
}

fn tempfile_folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("vanecut-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
