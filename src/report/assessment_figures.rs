//! The figures of an assessment, and how they stand in its page as HTML tables.

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

/// The size of a figure of a blade; NaN where it could not be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BladeSize {
    /// An angle, rad.
    AngleRad(f64),
    /// A length, mm.
    LengthMm(f64),
}

/// A figure by which a blade is assessed.
#[derive(Clone, Copy, Debug)]
pub struct BladeFigure {
    /// Its name.
    pub name: &'static str,
    /// What it measures.
    pub meaning: &'static str,
    /// Its size for a blade.
    pub size: fn(&BladeMeasure) -> BladeSize,
}

/// The figures of each blade, for the page and for the window.
pub const BLADE_FIGURES: [BladeFigure; 5] = [
    BladeFigure {
        name: "Twist",
        meaning: "Greatest angle between the chords of the camber line and the axis of rotation, span by span",
        size: |blade| BladeSize::AngleRad(blade.twisting()),
    },
    BladeFigure {
        name: "Turn",
        meaning: "How far the blade's normal turns from hub to tip; about 0 for cylindrical blades",
        size: |blade| BladeSize::AngleRad(blade.shape.normal_turn_rad),
    },
    BladeFigure {
        name: "Bow",
        meaning: "Distance of the middle of the span from the straight line between hub and tip",
        size: |blade| BladeSize::LengthMm(blade.shape.bow.offset),
    },
    BladeFigure {
        name: "Sharpest bow",
        meaning: "Greatest angle by which a line from hub to tip bends in its middle",
        size: |blade| BladeSize::AngleRad(blade.shape.sharpest_bow.angle_rad),
    },
    BladeFigure {
        name: "Envelope gap",
        meaning: "Gap between the wall and its ruled envelope: what a flank of a cutter cannot follow",
        size: |blade| BladeSize::LengthMm(blade.envelope_gap()),
    },
];

/// A column for each blade: there are fewer of them than figures.
fn blades(assessment: &Assessment) -> String {
    let names = assessment.blades.iter().map(|blade| escaped(&blade.name));
    let mut rows = row("th", std::iter::once("Blade".to_owned()).chain(names));
    for figure in BLADE_FIGURES {
        let sizes = assessment.blades.iter().map(|blade| match (figure.size)(blade) {
            BladeSize::AngleRad(angle) => format!("{}°", number(angle.to_degrees(), 1)),
            BladeSize::LengthMm(length) => format!("{} mm", number(length, 3)),
        });
        let name = format!("{}<br><small>{}</small>", figure.name, escaped(figure.meaning));
        rows += &row("td", std::iter::once(name).chain(sizes));
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
    for (index, section) in assessed.sections().into_iter().enumerate() {
        let (from, to, tool) = (section.from, section.to, section.tool);
        let name = [
            format!("{from:.2} to {to:.2}{}", section.kind.suffix()),
            format!("T{} D {}", tool.number, tool.diameter),
        ];
        let shares = ReachSides::CLASSES.map(|class| percent(map.share_of_section(index, class)));
        rows += &row("td", name.into_iter().chain([number(tool.overhang, 0)]).chain(shares));
    }
    let all = ["All".to_owned(), String::new(), String::new()];
    rows += &row("td", all.into_iter().chain(ReachSides::CLASSES.map(|class| percent(map.share(class)))));
    table(title, &rows)
}
