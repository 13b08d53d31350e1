use super::estimate::Cost;
use super::search::{MAX_TOOLS, ToolStretch, is_section, worthwhile};
use super::*;
use crate::plunge::spacing::step_limit;
use crate::plunge::survey::{PassageExtent, SurveyStation};

fn tool(number: u32, diameter: f64) -> Tool {
    Tool {
        number,
        diameter,
        corner_radius: 0.0,
        insert_width: 0.3 * diameter,
        overhang: 200.0,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: Default::default(),
    }
}

/// A channel of these widths, mm, from leading edge to rim, 40 mm deep.
fn channel(widths: &[f64], joint: Option<usize>) -> Survey {
    let last = widths.len() - 1;
    let station = |(i, &width): (usize, &f64)| {
        let passage = usize::from(joint.is_some_and(|joint| i >= joint));
        SurveyStation {
            s: i as f64 / last as f64,
            narrowest: width,
            deepest: 40.0,
            clear_diameter: f64::INFINITY,
            hindered: Vec::new(),
            passages: vec![PassageExtent {
                passage,
                narrowest: width,
                hub: width,
                shroud: 1.1 * width,
                depth: 40.0,
                advance: 200.0,
                turn_rad: 1.0,
            }],
            aside: Vec::new(),
        }
    };
    Survey { stations: widths.iter().enumerate().map(station).collect(), joints: joint.into_iter().collect() }
}

/// A channel that opens evenly from `inlet` to `outlet`, mm.
fn opening(inlet: f64, outlet: f64) -> Survey {
    let widths: Vec<f64> = (0..=50).map(|i| inlet + (outlet - inlet) * f64::from(i) / 50.0).collect();
    channel(&widths, None)
}

fn tools_of(chosen: &[ChosenSection]) -> Vec<u32> {
    chosen.iter().map(|chosen| chosen.section.tool).collect()
}

/// Adds to `best` the minimum cost, by number of tools, of everything that can follow `so_far`.
fn every_choice(
    estimator: &Estimator,
    tools: &[&Tool],
    (so_far, cost): (&mut Vec<ToolStretch>, Cost),
    best: &mut [Option<Cost>; MAX_TOOLS],
) {
    let before = so_far.last().copied();
    let from = before.map_or(estimator.survey.stations.len() - 1, |before| before.to);
    let mut numbers: Vec<usize> = so_far.iter().map(|stretch| stretch.tool).collect();
    numbers.dedup();
    if from == 0 {
        let best = &mut best[numbers.len() - 1];
        *best = Some(best.map_or(cost, |best| if cost < best { cost } else { best }));
        return;
    }
    for (t, tool) in tools.iter().enumerate() {
        let follows = before.is_none_or(|before| {
            let goes_on = estimator.survey.joints.contains(&from) && before.tool == t;
            goes_on || (tools[before.tool].diameter > tool.diameter && numbers.len() < MAX_TOOLS)
        });
        if !follows {
            continue;
        }
        let begun = cost.and(estimator.beginning(tool, from, before.map(|before| tools[before.tool])));
        for to in (0..from).filter(|&to| is_section(estimator, from, to)) {
            let cost = begun.and(estimator.stretch(tool, from, to));
            so_far.push(ToolStretch { tool: t, from, to });
            every_choice(estimator, tools, (&mut *so_far, cost), best);
            so_far.pop();
        }
    }
}

#[test]
fn no_choice_beats_the_one_found() {
    let setup = Setup::default();
    // Deterministic pseudorandom numbers.
    let mut state = 7u64;
    let mut chance = |from: f64, to: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut counts = [0; MAX_TOOLS];
    for case in 0..60 {
        let widths: Vec<f64> = (0..8).map(|i| chance(8.0, 14.0) + f64::from(i) * chance(0.0, 20.0)).collect();
        let survey = channel(&widths, (case % 3 == 0).then_some(2 + case % 4));
        let mut tools: Vec<Tool> = (1..=5).map(|number| tool(number, chance(5.0, 40.0).round())).collect();
        for tool in &mut tools {
            tool.plunge_feed = chance(80.0, 600.0);
            tool.overhang = chance(30.0, 90.0);
        }
        let candidates = candidates(&tools, None);
        let estimator = Estimator::new(&survey, &setup, &candidates, MoveTimes::default());
        let mut best = [None; MAX_TOOLS];
        every_choice(&estimator, &candidates, (&mut Vec::new(), Cost::default()), &mut best);
        let wanted = worthwhile(&best).and_then(|index| best[index]).expect("there is a choice");
        let found = cheapest(&estimator, &candidates, |_| true).expect("there is a choice");
        assert_eq!(
            (found.cost.misfits, found.cost.wanting),
            (wanted.misfits, wanted.wanting),
            "case {case}: rules"
        );
        assert!((found.cost.seconds - wanted.seconds).abs() < 1e-6, "case {case}: {found:?}, not {wanted:?}");
        let mut used: Vec<usize> = found.stretches.iter().map(|stretch| stretch.tool).collect();
        used.dedup();
        counts[used.len() - 1] += 1;
    }
    assert!(counts[..3].iter().all(|&count| count > 0), "cases with one, two and three tools: {counts:?}");
}

#[test]
fn cutters_fit_and_follow_each_other_from_rim_to_leading_edge() {
    let setup = Setup::default();
    let survey = opening(13.0, 90.0);
    let tools: Vec<Tool> =
        [40.0, 30.0, 20.0, 16.0, 12.0, 10.0, 8.0].iter().zip(1..).map(|(&d, n)| tool(n, d)).collect();
    let chosen = choose(&tools, None, &survey, &setup, MoveTimes::default());
    assert!((2..=MAX_TOOLS).contains(&chosen.len()), "a narrowing channel takes some cutters: {chosen:?}");
    let sections: Vec<&SectionSetup> = chosen.iter().map(|chosen| &chosen.section).collect();
    assert_eq!((sections[0].from, sections[sections.len() - 1].to), (1.0, 0.0), "from rim to leading edge");
    assert!(sections.windows(2).all(|pair| pair[0].to == pair[1].from), "without a gap");
    for section in sections {
        let diameter = tools[section.tool as usize - 1].diameter;
        for station in &survey.stations[survey.covered(section.from, section.to)] {
            assert!(station.narrowest - 1.0 >= 1.12 * diameter, "D {diameter} has room at s = {}", station.s);
        }
        assert_eq!(section.cut_direction, None, "the feed is left to the planner");
    }
}

#[test]
fn a_wider_channel_gets_larger_cutters() {
    let setup = Setup::default();
    let tools: Vec<Tool> = (3..=50).map(|d| tool(d, f64::from(d))).collect();
    let diameters = |inlet, outlet| {
        tools_of(&choose(&tools, None, &opening(inlet, outlet), &setup, MoveTimes::default()))
    };
    let (narrow, wide) = (diameters(12.0, 40.0), diameters(24.0, 80.0));
    assert!(wide.first() > narrow.first() && wide.last() > narrow.last(), "{narrow:?}, then {wide:?}");
}

#[test]
fn a_new_section_begins_where_passages_join() {
    let setup = Setup::default();
    let chosen =
        choose(&[tool(4, 12.0)], None, &channel(&[30.0; 51], Some(20)), &setup, MoveTimes::default());
    let borders: Vec<(f64, f64)> = chosen.iter().map(|c| (c.section.from, c.section.to)).collect();
    assert_eq!(borders, [(1.0, 0.4), (0.4, 0.0)], "the same cutter, twice");
}

#[test]
fn the_shortest_cutter_that_is_long_enough_is_taken() {
    let setup = Setup::default();
    let cutters = [200.0, 60.0, 40.0].map(|overhang| Tool {
        number: overhang as u32,
        overhang,
        plunge_feed: 300.0 - overhang,
        ..tool(0, 12.0)
    });
    let of =
        |tools: &[Tool]| tools_of(&choose(tools, None, &opening(20.0, 30.0), &setup, MoveTimes::default()));
    assert_eq!(of(&cutters), [60], "40 mm deep, and room to lean");
    let chosen = choose(&cutters[2..], None, &opening(20.0, 30.0), &setup, MoveTimes::default());
    assert_eq!(tools_of(&chosen), [40], "a short one is better than none");
    assert!(chosen[0].reason.contains("overhang of 40 mm is less than"), "and says so: {}", chosen[0].reason);
}

#[test]
fn places_are_those_of_rows_a_stepover_apart() {
    let (setup, survey) = (Setup::default(), opening(40.0, 40.0));
    let tools = [tool(1, 12.0)];
    let chosen = choose(&tools, None, &survey, &setup, MoveTimes::default());
    let rules = Rules::new(&setup.allowances);
    let gaps = (rules.free_width(40.0) - 12.0) / 8.0;
    let shroud_gaps = (rules.free_width(44.0) - 12.0) / 11.4;
    let [wall, inner] = [true, false].map(|wall_row| step_limit(&setup.plunge, &tools[0], wall_row));
    // Half a gap more is what rounding up adds on average.
    let inner_rows = f64::max(gaps, shroud_gaps) + 0.5 - 1.0;
    let expected = 200.0 * (2.0 / wall + inner_rows / inner);
    let places: f64 = chosen.iter().map(|chosen| chosen.places).sum();
    assert!((places - expected).abs() < 1e-9 * expected, "{places}, not {expected}");
}

#[test]
fn a_limit_leaves_large_cutters_aside_but_never_all() {
    let setup = Setup::default();
    let tools = [tool(1, 20.0), tool(2, 12.0), tool(3, 8.0)];
    let of =
        |limit| tools_of(&choose(&tools, Some(limit), &opening(40.0, 60.0), &setup, MoveTimes::default()));
    assert_eq!(of(15.0), [2]);
    assert_eq!(of(5.0), [3], "all are larger: the smallest");
    assert!(
        choose(&[], None, &opening(40.0, 60.0), &setup, MoveTimes::default()).is_empty(),
        "no tools, no sections"
    );
}

#[test]
fn a_passage_that_no_tool_reaches_does_not_decide_on_the_cutters_of_the_other() {
    let setup = Setup::default();
    let rules = Rules::new(&setup.allowances);
    let mut survey = channel(&[30.0; 51], Some(20));
    // Beside the splitter: a third as wide, and deeper than any tool for it is long.
    for station in &mut survey.stations[20..] {
        let beside = PassageExtent { passage: 2, narrowest: 10.0, depth: 60.0, ..station.passages[0] };
        station.passages.push(beside);
        station.narrowest = 10.0;
    }
    let tools = [tool(1, 20.0), Tool { overhang: 50.0, ..tool(2, 6.0) }];
    let chosen = |survey: &Survey| choose(&tools, None, survey, &setup, MoveTimes::default());
    assert_eq!(tools_of(&chosen(&survey))[0], 2, "of all passages only the narrow one counts");
    let long = [tool(1, 20.0), Tool { overhang: 60.0, ..tool(2, 6.0) }];
    let mut reached = survey.clone();
    reached.set_inaccessible_aside(|across| rules.any_reaches(&long, across));
    assert_eq!(reached.stations[50].passages.len(), 2, "a tool reaches its hub");
    survey.set_inaccessible_aside(|across| rules.any_reaches(&tools, across));
    assert_eq!(survey.stations[50].aside.len(), 1);
    let chosen = chosen(&survey);
    assert_eq!(tools_of(&chosen)[0], 1);
    assert!(chosen[0].reason.contains("without regard to a passage down to 10.0 mm wide"), "{chosen:?}");
    survey.set_inaccessible_aside(|_| false);
    assert!(survey.stations.iter().all(|station| !station.passages.is_empty()), "never all of them");
}

#[test]
fn reasons_name_the_border_and_the_price_of_another_size() {
    let setup = Setup::default();
    let tools = [tool(1, 25.0), tool(2, 12.0), tool(3, 10.0)];
    let chosen = choose(&tools, None, &opening(15.0, 60.0), &setup, MoveTimes::default());
    assert_eq!(tools_of(&chosen), [1, 2]);
    let reason = &chosen[0].reason;
    assert!(
        reason.starts_with("largest cutter for plunges; to s = 0.32, where the passage narrows to"),
        "{reason}"
    );
    assert!(reason.contains("% longer"), "{reason}");
    assert!(chosen[1].reason.contains("to the leading edge through a passage down to 15.0 mm"), "{chosen:?}");
}

#[test]
fn a_smaller_cutter_with_room_and_length_cuts_the_rest() {
    let tools = [tool(1, 30.0), tool(2, 20.0), tool(3, 12.0), tool(4, 4.0)];
    let setup = Setup::default();
    let section = |tool: u32, from: f64, to: f64| SectionSetup {
        tool,
        from,
        to,
        cut_direction: None,
        kind: SectionKind::Rows,
    };
    let rest = |sections: &[SectionSetup], tools: &[Tool], survey: &Survey| {
        let chosen = choose_rest(sections, tools, survey, &setup.allowances);
        assert!(chosen.iter().all(|chosen| chosen.section.kind == SectionKind::Rest));
        chosen.iter().map(|c| (c.section.tool, c.section.from, c.section.to)).collect::<Vec<_>>()
    };
    let wide = opening(60.0, 60.0);
    // D 20 is too large after D 30, and neighbours with the same cutter are merged.
    assert_eq!(rest(&[section(1, 1.0, 0.5), section(1, 0.5, 0.0)], &tools, &wide), [(3, 1.0, 0.0)]);
    // Large to small, each for the section whose rest it mills.
    assert_eq!(
        rest(&[section(2, 1.0, 0.5), section(3, 0.5, 0.0)], &tools, &wide),
        [(3, 1.0, 0.5), (4, 0.5, 0.0)]
    );
    assert_eq!(rest(&[section(4, 1.0, 0.0)], &tools, &wide), []);
    let short = [tool(1, 30.0), Tool { overhang: 30.0, ..tool(3, 12.0) }, tool(4, 4.0)];
    assert_eq!(rest(&[section(1, 1.0, 0.0)], &short, &wide), [(4, 1.0, 0.0)]);
    // None of them is long enough for the inlet: what fits is planned.
    let mut deep = opening(60.0, 60.0);
    for station in deep.stations.iter_mut().filter(|station| station.s < 0.399) {
        station.deepest = 250.0;
    }
    assert_eq!(rest(&[section(1, 1.0, 0.0)], &tools, &deep), [(3, 1.0, 0.4)]);
}

#[test]
fn of_many_tools_few_are_looked_at_and_the_choice_is_hardly_worse() {
    let setup = Setup::default();
    let rules = Rules::new(&setup.allowances);
    // Deterministic pseudorandom numbers.
    let mut state = 19u64;
    let mut chance = |from: f64, to: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for (inlet, outlet) in [(20.0, 30.0), (12.0, 60.0), (8.0, 9.0)] {
        let survey = opening(inlet, outlet);
        let mut tools: Vec<Tool> = (1..=400).map(|number| tool(number, chance(0.5, 80.0))).collect();
        for tool in &mut tools {
            tool.plunge_feed = chance(80.0, 600.0);
            tool.overhang = chance(1.0, 8.0) * tool.diameter;
            tool.corner_radius = if chance(0.0, 1.0) < 0.3 { tool.radius() } else { 0.0 };
            tool.assembly.taper_rad = (chance(0.0, 1.0) < 0.1).then_some(0.1);
        }
        let few = preselection::preselect(&tools, &survey, &rules, &setup.plunge);
        assert!(few.len() <= 150, "{}", few.len());
        assert!(few.iter().all(|tool| tool.is_flat() && !tool.is_tapered()));
        let suited: Vec<Tool> =
            tools.iter().filter(|tool| tool.is_flat() && !tool.is_tapered()).cloned().collect();
        let cost = |tools: &[Tool]| {
            let candidates = candidates(tools, None);
            let estimator = Estimator::new(&survey, &setup, &candidates, MoveTimes::default());
            cheapest(&estimator, &candidates, |_| true).expect("there is a choice").cost
        };
        let (all, preselected) = (cost(&suited), cost(&few));
        assert_eq!(
            (preselected.misfits, preselected.wanting),
            (all.misfits, all.wanting),
            "{inlet}, {outlet}"
        );
        assert!(preselected.seconds <= 1.15 * all.seconds, "{} of {}", preselected.seconds, all.seconds);
    }
    let flat: Vec<Tool> = (1..=100).map(|number| tool(number, 0.3 * f64::from(number))).collect();
    let all = preselection::preselect(&flat, &opening(20.0, 30.0), &rules, &setup.plunge);
    assert_eq!(all, flat, "of a hundred none is left out");
}
