//! Writes APT: at most 72 columns, `$` continues a statement on the next line.

use crate::setup::CutDirection;
use crate::toolpath::{ClProgram, ClSection, ClTool, Motion, shortened_part_name};

const COLUMNS: usize = 72;

/// Writes a program as APT text: six decimals for lengths (mm), nine for axes, moves in their order. A tool
/// is loaded where the moves change to it.
///
/// The part name is truncated to its line, and control characters in it become spaces.
///
/// ```
/// let program = vanecut::toolpath::ClProgram { part: "wheel".to_owned(), ..Default::default() };
/// let text = vanecut::io::apt::write_apt(&program);
/// assert!(text.starts_with("PARTNO") && text.trim_end().ends_with("FINI"));
/// ```
pub fn write_apt(program: &ClProgram) -> String {
    let mut out = String::new();
    statement(&mut out, &["PARTNO ", &part_name(&program.part)]);
    statement(&mut out, &["UNITS/MM"]);
    statement(&mut out, &["MULTAX/ON"]);
    for (index, section) in program.sections.iter().enumerate() {
        statement(&mut out, &["PPRINT/", &section_words(index, section)]);
    }
    let mut tool = None;
    let mut feed = None;
    let mut rows = program.rows.iter().peekable();
    for (index, step) in program.moves.iter().enumerate() {
        if step.tool.is_some() && step.tool != tool {
            tool = step.tool;
            feed = None;
            if let Some(tool) = step.tool.and_then(|index| program.tools.get(index)) {
                load(&mut out, tool);
            }
        }
        while let Some(row) = rows.next_if(|row| row.first_move <= index) {
            let (section, row) = ((row.section + 1).to_string(), (row.row + 1).to_string());
            statement(&mut out, &["PPRINT/ROW ", &section, " ", &row]);
        }
        match step.motion {
            Motion::Rapid => {
                statement(&mut out, &["RAPID"]);
                // The feed rate is repeated after a rapid, so that each plunge can be read on its own.
                feed = None;
            }
            Motion::Feed(rate) if rate != feed => {
                if let Some(rate) = rate {
                    statement(&mut out, &["FEDRAT/", &short(rate), ",MMPM"]);
                }
                feed = rate;
            }
            Motion::Feed(_) => {}
        }
        let (tip, axis) = (step.tip, step.axis);
        let numbers = [
            fixed(tip.x, 6),
            fixed(tip.y, 6),
            fixed(tip.z, 6),
            fixed(axis.x, 9),
            fixed(axis.y, 9),
            fixed(axis.z, 9),
        ];
        list(&mut out, "GOTO/", &numbers);
    }
    statement(&mut out, &["FINI"]);
    out
}

/// The words that name a section in programs, counted from 1.
pub(in crate::io) fn section_words(index: usize, section: &ClSection) -> String {
    let ClSection { from, to, diameter, feed, kind } = section;
    let feed = match feed {
        CutDirection::OutletToInlet => "INWARD",
        CutDirection::InletToOutlet => "OUTWARD",
    };
    let [from, to, diameter] = [from, to, diameter].map(|x| short(*x));
    let kind = kind.word().map(|word| format!(" {word}")).unwrap_or_default();
    format!("SECTION {} FROM {from} TO {to} D {diameter} {feed}{kind}", index + 1)
}

fn load(out: &mut String, tool: &ClTool) {
    let number = tool.number.to_string();
    statement(out, &["LOADTL/", &number]);
    // d, r, e (axis to corner centre), f (tip to corner centre), a, b (bottom and side angles), h (length).
    let (d, r) = (tool.diameter, tool.corner_radius);
    let sizes = [d, r, d / 2.0 - r, r, 0.0, 0.0, tool.overhang.unwrap_or(0.0)];
    list(out, "CUTTER/", &sizes.map(|size| fixed(size, 6)));
    if let Some(width) = tool.insert_width {
        statement(out, &["PPRINT/INSERT WIDTH ", &number, " ", &fixed(width, 6)]);
    }
    if let Some(spindle) = tool.spindle_rpm {
        statement(out, &["SPINDL/", &short(spindle), ",RPM,CLW"]);
    }
    statement(out, &["COOLNT/ON"]);
}

fn statement(out: &mut String, parts: &[&str]) {
    for part in parts {
        out.push_str(part);
    }
    while out.ends_with(' ') {
        out.pop();
    }
    out.push('\n');
}

/// A word and its list of numbers, continued on the next line where a line is full.
fn list(out: &mut String, word: &str, numbers: &[String]) {
    let mut column = word.len();
    out.push_str(word);
    for (k, number) in numbers.iter().enumerate() {
        let comma = usize::from(k + 1 < numbers.len());
        // The line must hold the number, its comma and a `$`.
        if column > 0 && column + number.len() + 2 * comma > COLUMNS {
            out.push_str("$\n");
            column = 0;
        }
        out.push_str(number);
        if comma == 1 {
            out.push(',');
        }
        column += number.len() + comma;
    }
    out.push('\n');
}

/// A number with a fixed number of decimals, without negative zero.
fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        _ => text,
    }
}

/// A number with one to six decimals.
fn short(x: f64) -> String {
    let text = fixed(x, 6);
    let cut = text.trim_end_matches('0');
    if cut.ends_with('.') { format!("{cut}0") } else { cut.to_owned() }
}

/// The part name as a single line that APT takes literally.
pub(super) fn part_name(name: &str) -> String {
    let clean: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let clean = clean.trim().trim_start_matches(['/', ' ']);
    shortened_part_name(clean, COLUMNS - "PARTNO ".len()).trim_end().to_owned()
}
