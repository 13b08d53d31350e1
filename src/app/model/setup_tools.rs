//! What an edit of a setup changes in all of its tools: the material their rates, a new number what names it.

use crate::io::tool_library::{flank_cutters, plunge_cutters};
use crate::setup::cutting_data::{CuttingData, fill_rates};
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
        let built_in = plunge_cutters().iter().chain(flank_cutters());
        let mut same = built_in.filter(|own| {
            let missing = |tool: &Tool| tool.assembly.missing_rates;
            own.diameter == tool.diameter && missing(tool).is_within(missing(own))
        });
        let rated = |own: &Tool, data: Option<&CuttingData>| {
            data.map_or_else(|| own.clone(), |data| data.scaled_from_steel(own))
        };
        let rates = |tool: &Tool| (tool.spindle, tool.plunge_feed);
        let same = same.find(|own| rates(&rated(own, was)) == rates(tool));
        match same {
            Some(own) => {
                let rated = rated(own, is);
                (tool.spindle, tool.plunge_feed) = rates(&rated);
                tool.assembly.missing_rates = rated.assembly.missing_rates;
            }
            None if tool.assembly.missing_rates != MissingRates::default() => fill_rates(tool, is),
            None => {
                let missing = followed_rates(tool, was);
                *tool = with_rates(tool, missing, is);
            }
        }
    }
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
    let named = setup.plunge.sections.iter_mut().map(|section| &mut section.tool);
    let locks = setup.plunge.edits.iter_mut().filter_map(|edit| match &mut edit.change {
        PlungeChange::Lock { tool, .. } => Some(tool),
        _ => None,
    });
    let tools = setup.tools.iter_mut().map(|tool| &mut tool.number);
    let all = named.chain(locks).chain(tools).chain(setup.flank.tool.as_mut());
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
