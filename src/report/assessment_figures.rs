//! The figures of an assessment as HTML tables.

use super::html::escaped;
use crate::assess::reach::ReachSides;
use crate::assess::{Assessment, BladeMeasure};
use crate::job::assess::AssessedPart;

/// Passages, blades, and what each tool of the setup reaches of the floor; mm and degrees.
pub(super) fn tables(assessed: &AssessedPart) -> String {
    let AssessedPart { assessment, .. } = assessed;
    format!("{}{}{}", passages(assessment), blades(assessment), reach(assessed))
}

fn row(tag: &str, cells: impl IntoIterator<Item = String>) -> String {
    let cells: String = cells.into_iter().map(|cell| format!("<{tag}>{cell}</{tag}>")).collect();
    format!("<tr>{cells}</tr>\n")
}

fn table(title: &str, rows: &str) -> String {
    format!("<h2>{title}</h2>\n<table>\n{rows}</table>\n")
}

/// A number; a dash where it could not be measured.
fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "–".to_owned() }
}

fn passages(assessment: &Assessment) -> String {
    let (narrow, wide) = assessment.width_range();
    let rows = [
        ("Largest cutter along the whole channel, mm", number(assessment.largest_cutter(), 2)),
        ("Width of passages, mm", format!("{} to {}", number(narrow, 2), number(wide, 2))),
        ("Depth up to, mm", number(assessment.depth(), 2)),
    ];
    let rows = rows.map(|(name, value)| row("td", [name.to_owned(), value]));
    table("Passages", &rows.concat())
}

/// A figure of a blade: its name and its text.
type BladeRow = (&'static str, fn(&BladeMeasure) -> String);

const BLADE_FIGURES: [BladeRow; 5] = [
    ("Twist, greatest angle between chords of the camber line and the rotation axis, °", |blade| {
        number(blade.twisting().to_degrees(), 1)
    }),
    ("Turn of the normal from hub to tip, °", |blade| number(blade.shape.normal_turn_rad.to_degrees(), 1)),
    ("Bow between hub and tip, mm", |blade| number(blade.shape.bow.offset, 3)),
    ("Sharpest bow, °", |blade| number(blade.shape.sharpest_bow.angle_rad.to_degrees(), 2)),
    ("Gap between the wall and its ruled envelope, mm", |blade| number(blade.envelope_gap(), 3)),
];

/// A column for each blade: there are fewer of them than figures.
fn blades(assessment: &Assessment) -> String {
    let names = assessment.blades.iter().map(|blade| escaped(&blade.name));
    let mut rows = row("th", std::iter::once("Blade".to_owned()).chain(names));
    for (name, figure) in BLADE_FIGURES {
        rows += &row("td", std::iter::once(name.to_owned()).chain(assessment.blades.iter().map(figure)));
    }
    table("Blades", &rows)
}

fn reach(assessed: &AssessedPart) -> String {
    let title = "Share of the floor that is reached, %";
    let Some(map) = &assessed.assessment.reach else {
        let why = assessed.no_reach.as_ref().map(|fault| escaped(&fault.to_string()));
        return format!("<h2>{title}</h2>\n<p>Not known: {}</p>\n", why.unwrap_or_default());
    };
    let percent = |share: f64| number(100.0 * share, 1);
    let heads = ["Section", "Tool", "Stick-out, mm", "From any side", "Outlet", "Inlet", "Both"];
    let mut rows = row("th", heads.map(str::to_owned));
    for section in assessed.sections() {
        let (from, to, tool) = (section.from, section.to, section.tool);
        let name = [format!("{from:.2} to {to:.2}"), format!("T{} D {}", tool.number, tool.diameter)];
        let shares = ReachSides::CLASSES.map(|class| percent(map.share_between(from, to, class)));
        rows += &row("td", name.into_iter().chain([number(tool.overhang, 0)]).chain(shares));
    }
    let all = ["All".to_owned(), String::new(), String::new()];
    rows += &row("td", all.into_iter().chain(ReachSides::CLASSES.map(|class| percent(map.share(class)))));
    table(title, &rows)
}
