//! The grammar of Fusion libraries as shops export them: decimal commas, flanges, holders without unit.

use std::sync::Arc;

use serde_json::{Value, json};
use vanecut::io::shop_tools::{LibraryFormat, ToolLibrary, merge_fusion, read_library_bytes, write_fusion};
use vanecut::setup::Tool;

fn read(tree: &Value) -> ToolLibrary {
    read_library_bytes("shop.json", tree.to_string().as_bytes(), LibraryFormat::FusionJson).expect("reads")
}

/// A library of these entries.
fn with_tools(tools: Value) -> Value {
    json!({"version": 36, "data": tools})
}

/// What Fusion exports in a country with a decimal comma: lengths such as `(29,5) mm`, the whole holder with
/// its flange, a shaft that reaches into it, and a face mill with inserts at 45°.
#[test]
fn lengths_with_a_decimal_comma_flanges_and_chamfered_face_mills_of_fusion() {
    let read = read(&with_tools(json!([
        {
            "BMC": "hss", "type": "ball end mill", "unit": "millimeters", "description": "ball 5",
            "expressions": {"holder_description": "'BT30'", "tool_bodyLength": "(29,5) mm",
                "tool_diameter": "5mm", "tool_description": "'ball 5'", "tool_numberOfFlutes": "2",
                "tool_shoulderLength": "(7,25) mm"},
            "geometry": {"CSP": false, "DC": 5, "HAND": true, "LB": 29, "LCF": 4, "NOF": 3, "OAL": 41,
                "SFDM": 6, "assemblyGaugeLength": 47.5, "shoulder-diameter": 4.8, "shoulder-length": 7},
            "holder": {"description": "BT30", "gaugeLength": 17.999, "type": "holder", "unit": "millimeters",
                "segments": [
                    {"height": 1, "lower-diameter": 44, "upper-diameter": 46},
                    {"height": 5.5, "lower-diameter": 46, "upper-diameter": 46},
                    {"height": 2.309, "lower-diameter": 46, "upper-diameter": 38},
                    {"height": 3.381, "lower-diameter": 38, "upper-diameter": 38},
                    {"height": 2.309, "lower-diameter": 38, "upper-diameter": 46},
                    {"height": 1.5, "lower-diameter": 46, "upper-diameter": 46},
                    {"height": 2, "lower-diameter": 31.75000000000001, "upper-diameter": 31.75000000000001}]},
            "shaft": {"type": "shaft", "segments": [
                {"height": 10, "lower-diameter": 6, "upper-diameter": 6},
                {"height": 90, "lower-diameter": 8, "upper-diameter": 8}]},
            "post-process": {"number": 12, "length-offset": 12, "diameter-offset": 12, "turret": 0},
            "start-values": {"presets": [{"name": "Default preset", "n": 3000, "v_f_plunge": 25, "f_z": 0.03,
                "v_c": 37.7, "expressions": {"tool_feedPlunge": "(22,5) mmpm", "use_tool_stepdown": "true"}}]}
        },
        {
            "type": "face mill", "unit": "millimeters", "description": "face mill 45°",
            "expressions": {"tool_taperAngle": "45 degrees", "tool_assemblyGaugeLength": "70 mm"},
            "geometry": {"DC": 50, "DCX": 64, "LB": 70, "LCF": 7, "NOF": 4, "OAL": 73, "RE": 0, "SFDM": 40,
                "TA": 44, "shoulder-diameter": 64, "shoulder-length": 40, "upper-radius": 0},
            "post-process": {"number": 21}
        },
        {"type": "tapered mill", "tapered-type": "tapered_ball", "unit": "inches", "description": "tapered",
            "geometry": {"DC": 0.25, "RE": 0.05, "TA": 10, "LB": 1, "LCF": 0.75},
            "start-values": {"presets": [{"v_f_plunge": 15, "n": 18000}]}},
        {"type": "circle segment barrel", "unit": "millimeters", "geometry": {"DC": 6, "profile-radius": 100}}
    ])));
    let [ball, face, tapered] = read.tools.as_slice() else { panic!("three mills: {read:?}") };
    assert_eq!(
        (tapered.tool.diameter, tapered.tool.corner_radius, tapered.tool.plunge_feed),
        (2.54, 1.27, 381.0)
    );
    assert!(tapered.notes.iter().any(|note| note.contains("that of its ball")), "{:?}", tapered.notes);
    let tool = &ball.tool;
    assert_eq!((tool.overhang, tool.corner_radius, tool.plunge_feed), (29.5, 2.5, 22.5));
    assert_eq!(tool.assembly.teeth, Some(2), "by the expression");
    assert_eq!(
        (tool.assembly.material.as_deref(), tool.assembly.description.as_deref()),
        (Some("hss"), None)
    );
    let shank = [[4.8, 3.25], [6.0, 10.0], [8.0, 90.0]];
    assert_eq!(tool.assembly.shank, shank);
    // The shaft ends at the holder.
    let ends = tool.assembly.segments(tool.overhang).iter().map(|s| s.from + s.length).collect::<Vec<_>>();
    assert_eq!(ends[..4], [7.25, 17.25, 29.5, 30.5]);
    let lengths: f64 = tool.assembly.holder.iter().map(|[_, _, length]| length).sum();
    assert!((lengths - 17.999).abs() < 1e-9 && tool.assembly.holder.len() == 7, "{:?}", tool.assembly.holder);
    assert_eq!(tool.assembly.holder[2], [46.0, 38.0, 2.309]);
    assert!(!ball.notes.iter().any(|note| note.contains("cannot be computed")), "{:?}", ball.notes);
    assert!((face.tool.assembly.taper_rad.unwrap().to_degrees() - 45.0).abs() < 1e-9);
    assert_eq!(face.tool.assembly.shank, [[64.0, 33.0], [40.0, 30.0]]);
    assert!(read.notes.iter().any(|note| note.contains("circle segment barrel")), "{:?}", read.notes);
}

#[test]
fn a_holder_without_unit_has_that_by_which_the_assembly_is_as_long_as_it_is_said_to_be() {
    for (unit, said, gauge, mm, words) in [
        ("inches", None, 2.5, 63.5, "inches assumed, as the tool"),
        ("inches", Some(6.5), 2.5, 63.5, "inches assumed, by the length"),
        ("inches", Some(6.5), 63.5, 63.5, "mm assumed, by the length"),
        ("millimeters", Some(91.5), 2.5, 63.5, "inches assumed, by the length"),
        ("millimeters", Some(300.0), 63.5, 63.5, "mm assumed, as the tool"),
    ] {
        let length = if unit == "inches" { 4.0 } else { 28.0 };
        let mut geometry =
            json!({"DC": 0.1 * length, "LB": length, "LCF": 0.3 * length, "SFDM": 0.1 * length});
        if let Some(said) = said {
            geometry["assemblyGaugeLength"] = json!(said);
        }
        let segment = json!({"height": gauge, "lower-diameter": gauge, "upper-diameter": gauge});
        let read = read(&with_tools(json!([{
            "type": "flat end mill", "unit": unit, "description": "no unit", "geometry": geometry,
            "holder": {"gaugeLength": gauge, "segments": [segment]},
        }])));
        let found = read.tools[0].tool.assembly.holder[0];
        assert!(found.iter().all(|x| (x - mm).abs() < 1e-9), "{unit}, {said:?}, {gauge}: {found:?}");
        assert!(read.tools[0].notes.iter().any(|note| note.contains(words)), "{:?}", read.tools[0].notes);
    }
}

/// A library with what Vanecut does not know: vendors, coolant, a drill, identifiers, old presets.
const SHOP: &str = r#"{
  "data" : [
    {"BMC":"carbide", "vendor":"maker", "guid":"1-2-3", "type":"bull nose end mill", "unit":"inches",
     "description":"bull 1/2", "product-link":"https://example.org/\u00e9",
     "geometry":{"DC":0.5, "RE":0.03, "LCF":1, "LB":2, "NOF":4, "SFDM":0.5, "OAL":4, "assemblyGaugeLength":4.5},
     "expressions":{"tool_bodyLength":"2 in", "tool_diameter":".5 in"},
     "holder":{"description":"ER16", "guid":"h", "unit":"millimeters", "gaugeLength":63.5, "segments":[
       {"height":20, "lower-diameter":22, "upper-diameter":28}, {"height":43.5, "lower-diameter":40, "upper-diameter":40},
       {"height":2, "lower-diameter":46, "upper-diameter":46}]},
     "post-process":{"number":3, "length-offset":3, "comment":"keep"},
     "start-values":{"presets":[
       {"name":"steel", "n":4000, "v_f":60, "v_f_plunge":20, "tool-coolant":"flood", "expressions":{"tool_feedPlunge":"20 ipm"}},
       {"name":"wood", "n":9000, "v_f_plunge":90}]}},
    {"type":"drill","unit":"millimeters","description":"drill 3","geometry":{"DC":3},"vendor":"other"} ,
    {"type":"flat end mill", "unit":"millimeters", "description":"old 4", "geometry":{"DC":4,"LB":50,"LCF":10},
     "post-process":{"number":7}, "start-values":{"*":{"n":20000,"v_f_plunge":150,"v_f_ramp":80}}}
  ],
  "version" : 36
}
"#;

/// A tool as text: the last segment of its shank runs on to the holder, and the width of inserts is assumed.
fn shown(tool: &Tool) -> String {
    let mut tool = tool.clone();
    tool.assembly.shank.last_mut().into_iter().for_each(|[_, length]| *length = 0.0);
    tool.insert_width = 0.0;
    format!("{tool:.6?}")
}

fn merged(existing: &str, library: &ToolLibrary) -> (String, [usize; 3]) {
    let merged = merge_fusion("shop.json", existing.as_bytes(), library).expect("merges");
    (merged.text, [merged.changed, merged.added, merged.kept])
}

#[test]
fn a_fusion_library_that_is_written_to_keeps_what_vanecut_does_not_know() {
    let read =
        |text: &str| read_library_bytes("shop.json", text.as_bytes(), LibraryFormat::FusionJson).unwrap();
    let mut library = read(SHOP);
    assert_eq!(merged(SHOP, &library), (SHOP.to_owned(), [0, 0, 3]), "nothing differs");
    let words = |tool: &Tool| (tool.assembly.description.clone(), tool.assembly.material.clone());
    assert_eq!(words(&library.tools[0].tool), (Some("keep".to_owned()), Some("carbide".to_owned())));
    assert_eq!(words(&library.tools[1].tool), (None, None));
    // A longer overhang, a wider holder, another feed; one more tool; and another one that has its number.
    let tool = &mut Arc::make_mut(&mut library.tools[0]).tool;
    tool.overhang = 63.5;
    tool.plunge_feed = 254.0;
    tool.assembly.holder[1][1] = 42.0;
    let mut more = (*library.tools[1]).clone();
    more.tool.diameter = 5.0;
    more.tool.assembly.name = Some("new 5".to_owned());
    library.tools[1] = Arc::new(more);
    let (text, counts) = merged(SHOP, &library);
    assert_eq!(counts, [1, 1, 2]);
    let untouched =
        SHOP.find("    {\"type\":\"drill\"").map(|at| &SHOP[at..SHOP.rfind("\n  ],").unwrap()]).unwrap();
    assert!(text.contains(untouched), "{text}");
    let tree: Value = serde_json::from_str(&text).expect("JSON");
    let bull = &tree["data"][0];
    for (pointer, value) in [
        ("/vendor", json!("maker")),
        ("/guid", json!("1-2-3")),
        ("/product-link", json!("https://example.org/é")),
        ("/geometry/LB", json!(2.5)),
        ("/geometry/OAL", json!(4)),
        ("/geometry/assemblyGaugeLength", json!(5.0)),
        ("/expressions", json!({"tool_diameter": ".5 in"})),
        ("/holder/description", json!("ER16")),
        ("/holder/gaugeLength", json!(63.5)),
        ("/holder/segments/1/upper-diameter", json!(42.0)),
        ("/holder/segments/2/lower-diameter", json!(46)),
        ("/post-process/comment", json!("keep")),
        ("/start-values/presets/0/v_f_plunge", json!(10.0)),
        ("/start-values/presets/0/v_f", json!(60)),
        ("/start-values/presets/0/tool-coolant", json!("flood")),
        ("/start-values/presets/1/v_f_plunge", json!(90)),
    ] {
        assert_eq!(bull.pointer(pointer), Some(&value), "{pointer}");
    }
    assert_eq!((&tree["data"][3]["description"], &tree["version"]), (&json!("new 5"), &json!(36)));
    let again = read(&text);
    assert_eq!(shown(&again.tools[0].tool), shown(&library.tools[0].tool));
    let numbers: Vec<u32> = again.tools.iter().map(|entry| entry.tool.number).collect();
    assert_eq!(numbers, [3, 7, 8], "the old one keeps the number that the new one had, too");
    // Of an empty one nothing can be kept; a file of another kind is refused.
    let empty = merge_fusion("e.json", b"{\"data\": []}", &library).expect("writes");
    assert_eq!((empty.text, empty.added), (write_fusion(&library), 2));
    assert!(merge_fusion("e.json", b"{\"data\": 3}", &library).is_err());
}

/// A drill has its place in the magazine, too.
#[test]
fn no_tool_gets_the_number_of_one_that_is_left_out() {
    let shop = with_tools(json!([
        {"type": "flat end mill", "unit": "millimeters", "geometry": {"DC": 4}, "post-process": {"number": 9}},
        {"type": "drill", "unit": "millimeters", "geometry": {"DC": 3}, "post-process": {"number": 10}},
        {"type": "flat end mill", "unit": "millimeters", "geometry": {"DC": 6}}
    ]));
    let mut library = read(&shop);
    let numbers =
        |library: &ToolLibrary| -> Vec<u32> { library.tools.iter().map(|entry| entry.tool.number).collect() };
    assert_eq!((numbers(&library), library.free_number()), (vec![9, 11], 12));
    // From another library, which does not know the drill.
    let mut other = (*library.tools[0]).clone();
    other.tool.number = 10;
    other.tool.assembly.name = Some("another 4".to_owned());
    (other.tool.assembly.length_offset, other.tool.assembly.diameter_offset) = (Some(10), Some(210));
    library = ToolLibrary { tools: vec![Arc::new(other)], ..ToolLibrary::default() };
    let merged = merge_fusion("shop.json", shop.to_string().as_bytes(), &library).expect("merges");
    assert_eq!(merged.notes, ["tool 10: another tool there has its number: it is tool 12"]);
    assert_eq!(numbers(&merged.library), [12]);
    // Written again, by its number there or by that of its own library, it is the same one.
    for again in [&merged.library, &library] {
        let again = merge_fusion("shop.json", merged.text.as_bytes(), again).expect("merges");
        assert_eq!((again.text, again.added, again.changed), (merged.text.clone(), 0, 0));
        assert_eq!(numbers(&again.library), [12]);
    }
    let tree: Value = serde_json::from_str(&merged.text).expect("JSON");
    let post = &tree["data"][3]["post-process"];
    let keys = ["number", "length-offset", "diameter-offset"].map(|key| post[key].clone());
    assert_eq!(keys, [json!(12), json!(12), json!(210)], "{}", merged.text);
}

/// What is not edited stays as it is written, in the entry that is edited, too.
#[test]
fn an_edited_entry_keeps_the_order_and_the_writing_of_what_was_not_edited() {
    let read =
        |text: &str| read_library_bytes("shop.json", text.as_bytes(), LibraryFormat::FusionJson).unwrap();
    let mut library = read(SHOP);
    Arc::make_mut(&mut library.tools[0]).tool.assembly.teeth = Some(5);
    Arc::make_mut(&mut library.tools[1]).tool.spindle = 15_000.0;
    let wanted = SHOP.replace("\"NOF\":4,", "\"NOF\":5,").replace("\"n\":20000,", "\"n\":15000.0,");
    assert_eq!(merged(SHOP, &library), (wanted, [2, 0, 1]));
}

/// Entries are named as the window names tools: their place in the list says nothing.
#[test]
fn entries_that_are_left_out_are_named_by_number_and_name() {
    let notes = read(&with_tools(json!([
        {"type": "drill", "unit": "millimeters", "description": "drill 3", "post-process": {"number": 17}},
        {"type": "flat end mill", "unit": "millimeters", "geometry": {"DC": 4}, "post-process": {"number": 5}},
        {"type": "chamfer mill", "unit": "millimeters", "post-process": {"number": 0}},
        {"type": "tap", "unit": "millimeters", "description": "M6"}
    ])))
    .notes;
    let named: Vec<&str> = notes.iter().filter_map(|note| note.split(" is left out").next()).collect();
    assert_eq!(named, ["tool 17 (`drill 3`)", "entry 3", "entry 4 (`M6`)"]);
}

/// Every value that a tool of ours may differ in, in both units and both kinds of presets, reads back.
#[test]
fn whatever_is_changed_in_a_tool_is_read_back_from_the_library_it_was_written_to() {
    let read =
        |text: &str| read_library_bytes("shop.json", text.as_bytes(), LibraryFormat::FusionJson).unwrap();
    type Change = fn(&mut Tool);
    let changes: [Change; 16] = [
        |tool| tool.diameter = 11.0,
        |tool| tool.corner_radius = 0.5,
        |tool| tool.overhang = 71.25,
        |tool| tool.spindle = 1234.0,
        |tool| tool.plunge_feed = 77.0,
        |tool| tool.assembly.name = Some("else".to_owned()),
        |tool| tool.assembly.flute_length = Some(9.0),
        |tool| tool.assembly.teeth = Some(5),
        |tool| tool.assembly.taper_rad = Some(3f64.to_radians()),
        |tool| tool.assembly.shank = vec![[3.5, 11.0], [8.0, 17.0]],
        |tool| tool.assembly.holder = vec![[33.0, 44.0, 21.0]],
        |tool| tool.assembly.length_offset = Some(88),
        |tool| tool.assembly.feed_per_tooth = Some(0.055),
        |tool| tool.assembly.cutting_speed = Some(123.0),
        |tool| tool.assembly.description = Some("for slots".to_owned()),
        |tool| tool.assembly.material = Some("hss".to_owned()),
    ];
    for (number, change) in changes.iter().enumerate() {
        for index in [0, 1] {
            let mut library = read(SHOP);
            let entry = Arc::make_mut(&mut library.tools[index]);
            change(&mut entry.tool);
            let (text, counts) = merged(SHOP, &library);
            assert_eq!(counts[..2], [1, 0], "change {number} of tool {index}: {text}");
            let found = &read(&text).tools[index].tool;
            assert_eq!(shown(found), shown(&library.tools[index].tool), "change {number} of tool {index}");
        }
    }
}

/// Without a flute length the shank begins where its length from the holder says: a library that lets it
/// begin at the end of the overhang has none.
#[test]
fn a_shank_without_a_flute_length_stays_where_it_is() {
    let setup =
        "[[tool]]\nnumber = 7\ndiameter = 4.0\noverhang = 50.0\nshank = [[8, 30]]\nholder = [[30, 40, 50]]\n";
    let library = read_library_bytes("t.toml", setup.as_bytes(), LibraryFormat::Toml).expect("reads");
    let shank = |library: &ToolLibrary, number: u32| -> Vec<(f64, f64, [f64; 2])> {
        let entry = library.tools.iter().find(|entry| entry.tool.number == number).expect("is there");
        let segments = entry.tool.assembly.segments(entry.tool.overhang);
        segments.iter().map(|segment| (segment.from, segment.length, segment.radii)).collect()
    };
    let wanted = shank(&library, 7);
    assert_eq!(wanted[0], (20.0, 30.0, [4.0; 2]));
    let again =
        |text: &str| read_library_bytes("t.json", text.as_bytes(), LibraryFormat::FusionJson).unwrap();
    assert_eq!(shank(&again(&write_fusion(&library)), 7), wanted);
    // Into an entry whose edges end 10 mm above the tip, and beside the others.
    assert_eq!(shank(&again(&merged(SHOP, &library).0), 7)[0], wanted[0]);
    let mut other = library.clone();
    Arc::make_mut(&mut other.tools[0]).tool.number = 8;
    assert_eq!(shank(&again(&merged(SHOP, &other).0), 8), wanted);
}
