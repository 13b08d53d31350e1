//! The order in which sections of blades are given, put right where a file clearly has another one: sides run
//! from leading to trailing edge, sections follow from hub to shroud. Each change is a line for the user.

use std::borrow::Cow;

use crate::geometry::{Meridional, MeridionalCurve, Point};

/// Share of the distance between the ends of a section by which its radius has to fall for it to run from
/// trailing to leading edge.
const CLEAR_FALL: f64 = 0.1;
/// Shares of the length of a section at which its height is measured: between slanted edges.
const LOOKS: [f64; 8] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// Relative height by which one section has to lie below another everywhere.
const CLEARLY_BELOW: f64 = 0.002;

/// The sections of one side in order, and what was changed.
pub(super) struct OrderedSide<'a> {
    pub(super) sections: Cow<'a, [Vec<Point>]>,
    pub(super) changes: SideChanges,
}

/// How the sections of a side were put in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SideChanges {
    /// Numbers, from 1 in the order of the file, of sections that ran from trailing to leading edge.
    turned: Vec<usize>,
    order: SpanOrder,
    /// Number of sections of the side.
    count: usize,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum SpanOrder {
    #[default]
    Kept,
    /// From shroud to hub.
    Reversed,
    Mixed,
}

/// Puts the sections of a side in order: each from leading to trailing edge, which is the outer end in a
/// centrifugal wheel, and one after the other from hub to shroud.
pub(super) fn ordered_side<'a>(
    sections: &'a [Vec<Point>],
    hub: &MeridionalCurve,
    shroud: &MeridionalCurve,
) -> OrderedSide<'a> {
    let mut sections = Cow::Borrowed(sections);
    let turned: Vec<usize> = (0..sections.len()).filter(|&k| runs_inwards(&sections[k])).collect();
    for &k in &turned {
        sections.to_mut()[k].reverse();
    }
    let heights: Vec<[f64; LOOKS.len()]> = sections.iter().map(|s| heights_of(s, hub, shroud)).collect();
    let below = |a: usize, b: usize| heights[a].iter().zip(&heights[b]).all(|(a, b)| a + CLEARLY_BELOW < *b);
    let falls = (1..sections.len()).filter(|&k| below(k, k - 1)).count();
    let order = match falls {
        0 => SpanOrder::Kept,
        all if all + 1 == sections.len() => SpanOrder::Reversed,
        _ => SpanOrder::Mixed,
    };
    match order {
        SpanOrder::Kept => {}
        SpanOrder::Reversed => sections.to_mut().reverse(),
        SpanOrder::Mixed => {
            let mean = |k: usize| heights[k].iter().sum::<f64>();
            let mut by_height: Vec<usize> = (0..sections.len()).collect();
            by_height.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
            sections = Cow::Owned(by_height.iter().map(|&k| sections[k].clone()).collect());
        }
    }
    let changes =
        SideChanges { turned: turned.iter().map(|k| k + 1).collect(), order, count: sections.len() };
    OrderedSide { sections, changes }
}

/// Whether a section begins clearly further from the axis than it ends.
fn runs_inwards(section: &[Point]) -> bool {
    let (Some(first), Some(last)) = (section.first(), section.last()) else { return false };
    Meridional::from_point(first).r - Meridional::from_point(last).r > CLEAR_FALL * (last - first).norm()
}

/// Heights of a section between hub (0) and shroud (1), at equal shares of its length.
fn heights_of(section: &[Point], hub: &MeridionalCurve, shroud: &MeridionalCurve) -> [f64; LOOKS.len()] {
    let mut lengths = vec![0.0];
    for pair in section.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let whole = lengths[lengths.len() - 1];
    LOOKS.map(|share| {
        let at = lengths.partition_point(|l| *l < share * whole).min(section.len().saturating_sub(1));
        let Some(point) = section.get(at) else { return 0.0 };
        let (above, below) =
            (hub.project(Meridional::from_point(point)).1, shroud.project(Meridional::from_point(point)).1);
        // Both are measured in the direction from hub to shroud.
        let depth = above - below;
        if depth.abs() > 1e-9 { above / depth } else { 0.0 }
    })
}

/// Lines about the changes to both sides of the blade `name`.
pub(super) fn notes_of(name: &str, sides: [(&str, &SideChanges); 2]) -> Vec<String> {
    let mut notes = Vec::new();
    let alike = sides[0].1 == sides[1].1;
    for (side, changes) in sides.into_iter().take(if alike { 1 } else { 2 }) {
        let whose = if alike { format!("the {name}") } else { format!("the {side} side of the {name}") };
        if changes.turned.len() == changes.count && changes.count > 0 {
            notes.push(format!(
                "the sections of {whose} run from trailing to leading edge; they are reversed"
            ));
        } else if !changes.turned.is_empty() {
            let list = changes.turned.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            notes.push(match changes.turned.len() {
                1 => format!("section {list} of {whose} runs from trailing to leading edge; it is reversed"),
                _ => {
                    format!("sections {list} of {whose} run from trailing to leading edge; they are reversed")
                }
            });
        }
        match changes.order {
            SpanOrder::Kept => {}
            SpanOrder::Reversed => notes
                .push(format!("the sections of {whose} run from shroud to hub; they are taken in reverse")),
            SpanOrder::Mixed => notes.push(format!(
                "the sections of {whose} are not in order from hub to shroud; they are sorted"
            )),
        }
    }
    notes
}
