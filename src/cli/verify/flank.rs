//! Output of `vanecut verify` for flank programs.

use serde_json::{Map, Value, json};

use crate::cli::output::{assembly_keys, assembly_text, head, notes_text, number};
use crate::part::Impeller;
use crate::verify::FlankVerdict;

/// The object of `--json`, with the keys of a plunge program; those without meaning here are null.
pub(super) fn object(part: &Impeller, verdict: &FlankVerdict) -> Map<String, Value> {
    let layer = &verdict.layer;
    let mut map = head(part, Some(verdict.channels));
    let mut put = |key: &str, value: Value| {
        map.insert(key.to_owned(), value);
    };
    put("kind", json!("flank"));
    put("positions", json!(verdict.positions));
    put("tool_loads", json!(verdict.tool_loads));
    put("residual_mean", number(layer.mean.into()));
    put("residual_p95", number(layer.p95.into()));
    put("residual_max", number(layer.max.into()));
    put("uncut_share", number(layer.uncut_share.into()));
    put("unreachable_share", number(layer.unreachable_share.into()));
    put("max_overcut", number(verdict.max_overcut));
    put("max_undercut", number(verdict.max_undercut));
    put("unmilled_wall_share", number(verdict.unmilled_wall_share));
    let uncovered = &verdict.uncovered;
    put("uncovered_share", number(uncovered.share()));
    put("uncovered_fillet_share", number(uncovered.fillet));
    put("uncovered_no_axis_share", number(uncovered.no_axis));
    put("uncovered_gap_share", number(uncovered.gap));
    put("min_hub_clearance", number(verdict.min_hub_clearance));
    put("min_blade_clearance", number(verdict.min_blade_clearance));
    put("min_retract_clearance", number(verdict.min_retract_clearance));
    put("max_axis_change", number(verdict.max_axis_change_rad.to_degrees()));
    put("cut_share", number(1.0 - f64::from(layer.uncut_share)));
    put("deepest_cut", number(verdict.deepest_cut));
    put("cut_length", number(verdict.cut_length));
    put("rapid_length", number(verdict.rapid_length));
    put("time_estimate", number(verdict.time_estimate));
    put("feed_time", number(verdict.feed_time));
    map.extend(assembly_keys(&verdict.assembly));
    map
}

/// How much of the floor a flank program cuts, in words.
pub fn cut_words(verdict: &FlankVerdict) -> String {
    format!("cuts {:.1} % of the floor", 100.0 * (1.0 - verdict.layer.uncut_share))
}

/// The text report of a flank program.
pub fn text(verdict: &FlankVerdict) -> String {
    let channels = if verdict.channels == 1 { "channel" } else { "channels" };
    let mut text = format!(
        "flank program: {} moves under feed in {} {channels}, {:.0} mm; {:.0} mm in rapid; about {:.0} min, \
         {:.0} of them under feed\n",
        verdict.positions,
        verdict.channels,
        verdict.cut_length,
        verdict.rapid_length,
        verdict.time_estimate / 60.0,
        verdict.feed_time / 60.0
    );
    text += &format!("{}; deepest cut {:.1} mm\n", cut_words(verdict), verdict.deepest_cut);
    let (layer, uncovered) = (&verdict.layer, &verdict.uncovered);
    // It is that of the cut floor.
    let residual = match layer.uncut_share < 1.0 {
        true => format!("residual stock {:.2} mm on average, 95 % below {:.2} mm; ", layer.mean, layer.p95),
        false => String::new(),
    };
    text += &format!(
        "floor: {residual}more than allowed on {:.2} %: {:.2} % fillet beside blades, {:.2} % inaccessible, \
         {:.2} % gaps of the program\n",
        100.0 * uncovered.share(),
        100.0 * uncovered.fillet,
        100.0 * uncovered.no_axis,
        100.0 * uncovered.gap,
    );
    text += &walls_text(verdict);
    text += &format!(
        "least clearance: hub {:.4} mm, blades {:.4} mm; axis change up to {:.1}° per move\n",
        verdict.min_hub_clearance,
        verdict.min_blade_clearance,
        verdict.max_axis_change_rad.to_degrees()
    );
    text += &assembly_text(&verdict.assembly);
    text += &notes_text(&verdict.notes);
    text
}

/// The line about the walls, of a planned or any other flank program.
pub fn walls_text(verdict: &FlankVerdict) -> String {
    if verdict.max_undercut.is_finite() {
        format!(
            "walls: {:.4} mm overcut, {:.4} mm undercut where they are milled; {:.1} % not milled\n",
            verdict.max_overcut,
            verdict.max_undercut,
            100.0 * verdict.unmilled_wall_share
        )
    } else if verdict.unmilled_wall_share == 0.0 {
        format!("walls: no higher than the corner of the cutter; {:.4} mm overcut\n", verdict.max_overcut)
    } else {
        format!("walls: not milled; {:.4} mm overcut\n", verdict.max_overcut)
    }
}
