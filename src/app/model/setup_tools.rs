//! What an edit of a setup changes in all of its tools: the material their rates, a new number what names it.

use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::setup::cutting_data::{CuttingData, MAX_SPINDLE, PLUNGE_FEED_RANGE, fill_rates};
use crate::setup::{MissingRates, PlungeChange, Setup, Tool};

/// Gives the tools of a setup, whose material was `before`, the rates for its material now. Only rates that
/// nobody entered follow: those of the built-in library, those that are missing, and those that followed from
/// cutting data, as files of former versions have them.
pub fn follow_material(setup: &mut Setup, before: Option<&str>) {
    let was = before.and_then(CuttingData::of_name);
    let is = setup.allowances.cutting_data();
    if was.map(|data| data.names) == is.map(|data| data.names) {
        return;
    }
    for tool in &mut setup.tools {
        let before = tool.clone();
        follow(tool, (&before, was), is);
    }
}

/// Gives a tool, whose diameter was edited from that of `before`, rates for its diameter now, as far as
/// nobody entered them. Those of the built-in library keep cutting speed and feed per revolution.
pub fn follow_diameter(tool: &mut Tool, before: &Tool, material: Option<&CuttingData>) {
    let given = |tool: &Tool| (rates(tool), tool.assembly.missing_rates);
    if tool.diameter != before.diameter && given(tool) == given(before) {
        follow(tool, (before, material), material);
    }
}

/// Gives a tool of a library, where rates that nobody entered are those for steel, rates for a material.
pub fn take_for_material(tool: &mut Tool, material: Option<&CuttingData>) {
    let before = tool.clone();
    follow(tool, (&before, None), material);
}

/// Spindle speed and plunge feed.
fn rates(tool: &Tool) -> (f64, f64) {
    (tool.spindle, tool.plunge_feed)
}

/// Gives `tool` rates for the material `is`, as far as nobody entered those that it had as the tool `before`
/// in the material `was`.
fn follow(tool: &mut Tool, (before, was): (&Tool, Option<&CuttingData>), is: Option<&CuttingData>) {
    let missing = before.assembly.missing_rates;
    match built_in(before, was) {
        Some(own) => {
            let rated = rated(own, tool.diameter, is);
            (tool.spindle, tool.plunge_feed) = rates(&rated);
            tool.assembly.missing_rates = rated.assembly.missing_rates;
        }
        None if missing != MissingRates::default() => fill_rates(tool, is),
        None => *tool = with_rates(tool, followed_rates(before, was), is),
    }
}

/// The tool of the built-in library whose rates `tool` has in a material: one of its diameter, or else of the
/// nearest.
fn built_in(tool: &Tool, material: Option<&CuttingData>) -> Option<&'static Tool> {
    let missing = tool.assembly.missing_rates;
    let has_rates = |own: &&Tool| {
        missing.is_within(own.assembly.missing_rates)
            && rates(&rated(own, tool.diameter, material)) == rates(tool)
    };
    let away = |own: &&Tool| (own.diameter - tool.diameter).abs();
    let known = plunge_cutters().iter().chain(flank_cutters()).filter(has_rates);
    known.min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// A tool of the built-in library with its rates in a material and, where its `diameter` is another one, at
/// the same cutting speed and feed per revolution.
fn rated(own: &Tool, diameter: f64, material: Option<&CuttingData>) -> Tool {
    let rated = material.map_or_else(|| own.clone(), |data| data.scaled_from_steel(own));
    if diameter == own.diameter {
        return rated;
    }
    let slower = own.diameter / diameter;
    let within = |rate: f64, [least, most]: [f64; 2]| (rate * slower).round().clamp(least, most);
    let mut resized = Tool {
        diameter,
        spindle: within(rated.spindle, [1.0, MAX_SPINDLE.max(rated.spindle)]),
        plunge_feed: within(rated.plunge_feed, [1.0, PLUNGE_FEED_RANGE[1]]),
        ..rated
    };
    fill_rates(&mut resized, material);
    resized
}

/// The rates of a tool that are those of cutting data for the material `was`.
fn followed_rates(tool: &Tool, was: Option<&CuttingData>) -> MissingRates {
    let feed = MissingRates { plunge_feed: true, spindle: false };
    let plunge_feed = with_rates(tool, feed, was).plunge_feed == tool.plunge_feed;
    // Another speed alone would change the feed per tooth.
    let spindle = plunge_feed && with_rates(tool, MissingRates::ALL, was).spindle == tool.spindle;
    MissingRates { plunge_feed, spindle }
}

/// `tool`, whose rates are all given, with those for a material in place of those that are `missing`.
fn with_rates(tool: &Tool, missing: MissingRates, material: Option<&CuttingData>) -> Tool {
    let mut filled = tool.clone();
    filled.assembly.missing_rates = missing;
    fill_rates(&mut filled, material);
    filled.with_given_rates()
}

/// Gives the tool of `setup` of number `was` the number `is`, also where that number is named. `false` where
/// another tool has it.
pub fn renumber(setup: &mut Setup, was: u32, is: u32) -> bool {
    if setup.tools.iter().any(|tool| tool.number == is) {
        return was == is;
    }
    setup.tools.iter_mut().filter(|tool| tool.number == was).for_each(|tool| tool.renumber(is));
    let named = setup.plunge.sections.iter_mut().map(|section| &mut section.tool);
    let locks = setup.plunge.edits.iter_mut().filter_map(|edit| match &mut edit.change {
        PlungeChange::Lock { tool, .. } => Some(tool),
        _ => None,
    });
    let all = named.chain(locks).chain(setup.flank.tool.as_mut());
    all.filter(|number| **number == was).for_each(|number| *number = is);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Changes the material of `setup`.
    fn choose(setup: &mut Setup, material: Option<&str>) {
        let before = std::mem::replace(&mut setup.allowances.material, material.map(str::to_owned));
        follow_material(setup, before.as_deref());
    }

    #[test]
    fn rates_that_nobody_entered_follow_the_material_and_others_stay() {
        let own = plunge_cutters().iter().find(|tool| tool.number == 64).expect("a tool").clone();
        let entered = Tool { number: 2, spindle: own.spindle + 30.0, ..own.clone() };
        let blank = with_rates(&entered, MissingRates::ALL, None);
        let named = Tool { number: 64, ..own.clone() };
        let mut setup =
            Setup { tools: vec![named, entered.clone(), Tool { number: 3, ..blank }], ..Setup::default() };
        let first = setup.tools.clone();
        choose(&mut setup, Some("steel"));
        assert_eq!(setup.tools[0], first[0], "the library has the rates of steel");
        choose(&mut setup, Some("titanium"));
        let data = setup.allowances.cutting_data().expect("known");
        assert_eq!(setup.tools[0], data.scaled_from_steel(&own));
        assert_eq!(setup.tools[1], entered);
        assert_eq!(setup.tools[2].spindle, data.spindle_for(own.diameter));
        let note = setup.allowances.too_fast(&setup.tools).expect("one is for steel");
        assert!(note.starts_with("much faster than the 40 m/min for titanium: T2 11"), "{note}");
        choose(&mut setup, None);
        assert_eq!(setup.tools, first);
        // Rates that are not given follow, whatever they are, and stay those that are not given.
        let mut missing = entered.clone();
        missing.assembly.missing_rates.spindle = true;
        setup.tools = vec![missing];
        choose(&mut setup, Some("titanium"));
        let tool = &setup.tools[0];
        assert_eq!((tool.spindle, tool.plunge_feed), (data.spindle_for(own.diameter), entered.plunge_feed));
        assert!(tool.assembly.missing_rates.spindle && !tool.assembly.missing_rates.plunge_feed);
        choose(&mut setup, None);
        assert_eq!(setup.allowances.too_fast(&setup.tools), None);
    }

    /// A tool that was chosen, and then made larger or longer, is still one whose rates nobody entered.
    #[test]
    fn rates_follow_an_edited_diameter_and_then_the_material() {
        let own = plunge_cutters().iter().find(|tool| tool.number == 52).expect("a tool").clone();
        let mut tool = own.clone();
        for diameter in [12.3, 12.7, 14.0, 12.7] {
            let before = tool.clone();
            (tool.diameter, tool.overhang) = (diameter, own.overhang + diameter);
            follow_diameter(&mut tool, &before, None);
        }
        let scaled = |rate: f64| (rate * own.diameter / 12.7).round();
        assert_eq!(rates(&tool), (scaled(own.spindle), scaled(own.plunge_feed)));
        // As it is saved and opened again.
        let saved = crate::io::write_setup(&Setup { tools: vec![tool.clone()], ..Setup::default() });
        let mut setup = crate::io::setup_file::read_setup_bytes("s.toml", saved.as_bytes()).expect("opens");
        choose(&mut setup, Some("titanium"));
        let data = setup.allowances.cutting_data().expect("known");
        assert_eq!(setup.tools[0].spindle, scaled(data.scaled_from_steel(&own).spindle));
        assert_eq!(setup.allowances.too_fast(&setup.tools), None);
        choose(&mut setup, None);
        assert_eq!(rates(&setup.tools[0]), rates(&tool));
        let before = tool.clone();
        tool.diameter = own.diameter;
        follow_diameter(&mut tool, &before, None);
        assert_eq!(rates(&tool), rates(&own), "as the library has it");
        // What was entered stays.
        let entered = Tool { spindle: own.spindle + 30.0, ..own.clone() };
        let mut tool = Tool { diameter: 12.7, ..entered.clone() };
        follow_diameter(&mut tool, &entered, None);
        assert_eq!(rates(&tool), rates(&entered));
    }

    #[test]
    fn a_number_changes_everywhere_and_none_is_given_twice() {
        let own = plunge_cutters()[..2].to_vec();
        let [a, b] = [own[0].number, own[1].number];
        let mut setup = Setup { tools: own, ..Setup::default() };
        setup.flank.tool = Some(a);
        assert!(!renumber(&mut setup, a, b), "it is that of another tool");
        assert!(renumber(&mut setup, a, 905));
        assert_eq!((setup.tools[0].number, setup.tools[1].number, setup.flank.tool), (905, b, Some(905)));
    }
}
