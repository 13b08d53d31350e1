//! geomTurbo parts: text, one statement per line, in nested blocks; rotation axis Z.
//!
//! ```text
//! UNITS Meters                       default: metres
//! UNITS-FACTOR 1
//! NI_BEGIN CHANNEL
//!   NI_BEGIN basic_curve
//!     NAME hub_1
//!     NI_BEGIN zrcurve
//!       ZR
//!       +2                           number of points, then z r
//!       0.0 0.1
//!       0.1 0.2
//!     NI_END zrcurve
//!   NI_END basic_curve
//!   NI_BEGIN channel_curve hub       or shroud
//!     VERTEX CURVE_P hub_1 0         from start (0) …
//!     VERTEX CURVE_P hub_1 1         … to end (1); 1 then 0 runs backwards
//!   NI_END channel_curve hub
//! NI_END CHANNEL
//! NI_BEGIN nirow                     only the first row is read
//!   PERIODICITY 12
//!   NI_BEGIN NIBlade                 main blade, then splitters
//!     NI_BEGIN nibladegeometry
//!       units 1                      relative to the file's unit
//!       number_of_blades 12          default: PERIODICITY
//!       suction                      and pressure, in either order
//!       SECTIONAL
//!       2                            number of sections, hub → tip
//!       # section 1
//!       XYZ                          or ZRTH: z r θ in rad
//!       +110                         number of points, LE → TE
//! ```
//!
//! Keywords are case-insensitive; unknown keys and blocks are skipped.

use std::collections::HashMap;

use super::InputError;
use super::source;
use super::source::{JOINT, MAX_COORDINATE, MAX_POINTS, Source, quote_for_message, stem_of};
use crate::error::ErrorCode;
use crate::geometry::Point;
use crate::mesh::LengthUnit;
use crate::mesh::options::size_fault;
use crate::part::{BladeDescription, CurveDescription, Meridional, PartDescription};

/// Reads a geomTurbo part. `file` is the file name used in messages; its stem is the part's name. A given
/// `unit` prevails over that of the file, which is often left at the default.
pub(super) fn read(
    file: &str,
    bytes: &[u8],
    unit: Option<LengthUnit>,
) -> Result<PartDescription, InputError> {
    let source = Source::new(file, ErrorCode::PartFile);
    let text = source::text(source, bytes)?;
    let mut lines = StatementReader { source, rest: text.lines(), line: 0, points: 0 };
    let mut found = GeomTurboContents::default();
    found.file(&mut lines)?;
    if let Some(unit) = unit {
        (found.unit, found.factor) = (Some(unit.mm() / 1000.0), None);
    }
    let mm = found.unit_mm();
    let part = found.part(source)?;
    // A unit that was given is meant.
    match size_fault(part.diameter() / mm, mm).filter(|_| unit.is_none()) {
        None => Ok(part),
        Some(fault) => {
            let help = format!("{}, or state it in the file, as `UNITS Millimeters`", fault.help);
            Err(source.fault(0, fault.message, help).with_code(fault.code))
        }
    }
}

/// The statements of a file.
struct StatementReader<'a> {
    source: Source<'a>,
    rest: std::str::Lines<'a>,
    line: usize,
    points: usize,
}

impl<'a> StatementReader<'a> {
    /// The next line that is neither empty nor a comment.
    fn next(&mut self) -> Option<&'a str> {
        loop {
            let text = self.rest.next()?.trim();
            self.line += 1;
            if !text.is_empty() && !text.starts_with('#') {
                return Some(text);
            }
        }
    }

    fn need(&mut self, what: &str) -> Result<&'a str, InputError> {
        self.next().ok_or_else(|| self.source.cut_off(self.line, format!("ends before {what}")))
    }

    fn fault(&self, what: impl Into<String>, help: impl Into<String>) -> InputError {
        self.source.fault(self.line, what, help)
    }

    /// Reads a count such as `+100`.
    fn count(&mut self, what: &str) -> Result<usize, InputError> {
        let text = self.need(&format!("the number of {what}"))?;
        let token = text.split_whitespace().next().unwrap_or_default();
        match token.trim_start_matches('+').parse::<usize>() {
            Ok(count) if count <= MAX_POINTS => Ok(count),
            _ => Err(self.fault(
                format!("{} is not a valid number of {what}", quote_for_message(token)),
                format!("give a whole number from 0 to {MAX_POINTS}"),
            )),
        }
    }

    /// Reads `count` lines of `N` numbers.
    fn rows<const N: usize>(&mut self, count: usize) -> Result<Vec<[f64; N]>, InputError> {
        self.points += count;
        if self.points > MAX_POINTS {
            return Err(self
                .fault("holds more than 1,000,000 points", "give fewer points")
                .with_code(ErrorCode::FileTooLarge));
        }
        let mut rows = Vec::new();
        for k in 0..count {
            let text = self.need(&format!("point {} of {count}", k + 1))?;
            let mut row = [0.0; N];
            let mut tokens = text.split_whitespace();
            for number in &mut row {
                let token = tokens.next().ok_or_else(|| {
                    let what = format!("point {} of {count} has fewer than {N} numbers", k + 1);
                    self.fault(what, format!("give {N} numbers a line"))
                })?;
                *number = self.source.number(self.line, token)?;
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// Skips to the end of the block that has just begun.
    fn skip_block(&mut self) {
        let mut depth = 1_usize;
        while depth > 0
            && let Some(text) = self.next()
        {
            let word = text.split_whitespace().next().unwrap_or_default();
            if word.eq_ignore_ascii_case("NI_BEGIN") {
                depth += 1;
            } else if word.eq_ignore_ascii_case("NI_END") {
                depth -= 1;
            }
        }
    }
}

/// First word in lower case and the rest of the line.
fn split(text: &str) -> (String, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word.to_ascii_lowercase(), rest.trim())
}

/// A channel curve: its vertices (curve name, at its end, line) and the line of its block.
#[derive(Default)]
struct Chain {
    vertices: Vec<(String, bool, usize)>,
    line: usize,
}

/// A blade in the file's unit; `blades` is the number of blades and its line.
struct GeomTurboBlade {
    line: usize,
    unit: f64,
    blades: Option<(usize, usize)>,
    suction: Vec<Vec<Point>>,
    pressure: Vec<Vec<Point>>,
}

/// What has been read so far, in the file's unit.
#[derive(Default)]
struct GeomTurboContents {
    unit: Option<f64>,
    factor: Option<f64>,
    curves: HashMap<String, Vec<Meridional>>,
    chains: HashMap<String, Chain>,
    row_seen: bool,
    periodicity: Option<(usize, usize)>,
    blades: Vec<GeomTurboBlade>,
}

impl GeomTurboContents {
    fn file(&mut self, lines: &mut StatementReader<'_>) -> Result<(), InputError> {
        let mut blocks: Vec<(String, usize)> = Vec::new();
        let mut curve_name = String::new();
        while let Some(text) = lines.next() {
            let (word, rest) = split(text);
            let inside = blocks.last().map_or("", |(kind, _)| kind.as_str());
            match (inside, word.as_str()) {
                (_, "ni_begin") => {
                    let (kind, name) = split(rest);
                    match kind.as_str() {
                        "nirow" if self.row_seen => lines.skip_block(),
                        "nibladegeometry" if inside == "niblade" => self.blade(lines)?,
                        "channel" | "basic_curve" | "zrcurve" | "channel_curve" | "nirow" | "niblade" => {
                            self.row_seen |= kind == "nirow";
                            if kind != "zrcurve" {
                                curve_name = name.to_ascii_lowercase();
                            }
                            if kind == "channel_curve" {
                                self.begin_chain(&curve_name, lines.line);
                            }
                            blocks.push((kind, lines.line));
                        }
                        _ => lines.skip_block(),
                    }
                }
                (_, "ni_end") => {
                    let (kind, _) = split(rest);
                    if let Some(at) = blocks.iter().rposition(|(open, _)| *open == kind) {
                        blocks.truncate(at);
                    }
                }
                ("basic_curve", "name") => {
                    curve_name = rest.to_ascii_lowercase();
                    self.curves.entry(curve_name.clone()).or_default();
                }
                ("channel_curve", "name") if curve_name.is_empty() => {
                    curve_name = rest.to_ascii_lowercase();
                    self.begin_chain(&curve_name, lines.line);
                }
                ("zrcurve", "zr") => {
                    let count = lines.count("points")?;
                    let points = lines.rows::<2>(count)?.into_iter().map(|[z, r]| Meridional { r, z });
                    let curve = self.curves.entry(curve_name.clone()).or_default();
                    if curve.is_empty() {
                        curve.extend(points);
                    }
                }
                ("channel_curve", "vertex") => self.vertex(lines, &curve_name, rest)?,
                ("", "units") => self.unit = Some(unit_in_metres(lines, rest)?),
                ("", "units-factor") => self.factor = Some(scale(lines, rest)?),
                ("nirow", "periodicity") => {
                    self.periodicity = Some((lines.source.blades(lines.line, rest)?, lines.line));
                }
                _ => {}
            }
        }
        match blocks.last() {
            Some((kind, line)) => {
                let what = format!("ends inside the block {} of line {line}", quote_for_message(kind));
                Err(lines.source.cut_off(lines.line, what))
            }
            None => Ok(()),
        }
    }

    fn begin_chain(&mut self, name: &str, line: usize) {
        self.chains.entry(name.to_owned()).or_insert_with(|| Chain { vertices: Vec::new(), line });
    }

    /// Reads a vertex `CURVE_P name 0|1` of a channel curve.
    fn vertex(&mut self, lines: &StatementReader<'_>, chain: &str, rest: &str) -> Result<(), InputError> {
        let (kind, rest) = split(rest);
        let Some(chain) = self.chains.get_mut(chain).filter(|_| kind == "curve_p") else { return Ok(()) };
        let (name, end) = rest.rsplit_once(char::is_whitespace).unwrap_or((rest, ""));
        let end = match source::number(end) {
            Ok(0.0) => false,
            Ok(1.0) => true,
            _ => {
                let what = format!("{} is not an end of a curve", quote_for_message(end));
                return Err(lines.fault(what, "give 0 (start) or 1 (end)"));
            }
        };
        chain.vertices.push((name.trim().to_ascii_lowercase(), end, lines.line));
        Ok(())
    }

    /// Reads the inside of a `nibladegeometry` block, to its end.
    fn blade(&mut self, lines: &mut StatementReader<'_>) -> Result<(), InputError> {
        let mut blade = GeomTurboBlade {
            line: lines.line,
            unit: 1.0,
            blades: None,
            suction: Vec::new(),
            pressure: Vec::new(),
        };
        loop {
            let text = lines.need(&format!("the end of the blade of line {}", blade.line))?;
            let (word, rest) = split(text);
            match word.as_str() {
                "ni_end" => break,
                "ni_begin" => lines.skip_block(),
                "units" => blade.unit = scale(lines, rest)?,
                "number_of_blades" => {
                    blade.blades = Some((lines.source.blades(lines.line, rest)?, lines.line));
                }
                "suction" if rest.is_empty() => blade.suction = side(lines)?,
                "pressure" if rest.is_empty() => blade.pressure = side(lines)?,
                _ => {}
            }
        }
        let (s, p) = (blade.suction.len(), blade.pressure.len());
        if s != p {
            let what = format!("the blade has {s} suction and {p} pressure sections");
            return Err(lines
                .source
                .fault(blade.line, what, "give both sides the same sections")
                .with_code(ErrorCode::BladeSections));
        }
        if s < 2 {
            let what = format!("the blade has {s} span section(s)");
            return Err(lines
                .source
                .fault(blade.line, what, "give two or more, hub to tip")
                .with_code(ErrorCode::BladeSections));
        }
        self.blades.push(blade);
        Ok(())
    }

    /// Length of the file's unit, mm.
    fn unit_mm(&self) -> f64 {
        let metres = match (self.unit, self.factor) {
            // A factor that only repeats the unit ("Millimeters", 0.001) is applied once.
            (Some(unit), Some(factor)) if (unit / factor - 1.0).abs() < 1e-6 => unit,
            (unit, factor) => unit.unwrap_or(1.0) * factor.unwrap_or(1.0),
        };
        metres * 1000.0
    }

    fn part(self, source: Source<'_>) -> Result<PartDescription, InputError> {
        let mm = self.unit_mm();
        let (hub, hub_line) = self.channel_curve(source, "hub", mm)?;
        let (shroud, shroud_line) = self.channel_curve(source, "shroud", mm)?;
        let mut blades = self.blades.into_iter();
        let main = blades.next().ok_or_else(|| {
            source
                .fault(0, "holds no blade", "export it with an nirow that has a nibladegeometry")
                .with_code(ErrorCode::BladeSections)
        })?;
        let (blade_count, count_line) = main.blades.or(self.periodicity).ok_or_else(|| {
            source
                .fault(main.line, "the number of blades is missing", "add PERIODICITY or number_of_blades")
                .with_code(ErrorCode::BladeCount)
        })?;
        Ok(PartDescription {
            name: stem_of(source.file),
            hub,
            shroud,
            blade_count,
            main: main.scaled(source, mm)?,
            splitters: blades.map(|blade| blade.scaled(source, mm)).collect::<Result<_, _>>()?,
            hub_line,
            shroud_line,
            count_line,
            notes: Vec::new(),
            roles_by_shape: false,
        })
    }

    /// Chains a channel curve from its basic curves, in mm.
    fn channel_curve(
        &self,
        source: Source<'_>,
        name: &str,
        mm: f64,
    ) -> Result<(CurveDescription, usize), InputError> {
        let chain = self.chains.get(name).ok_or_else(|| {
            let help = format!("export it with a `channel_curve {name}` block");
            source.fault(0, format!("the {name} is missing"), help).with_code(ErrorCode::FlowCurve)
        })?;
        let mut points: Vec<Meridional> = Vec::new();
        let mut push = |run: &mut dyn Iterator<Item = &Meridional>, line: usize| {
            for p in run {
                let p = Meridional { r: p.r * mm, z: p.z * mm };
                if points.len() >= MAX_POINTS || p.r.abs().max(p.z.abs()) > MAX_COORDINATE {
                    let what = format!("the {name} has too many points or points beyond 1,000,000 mm");
                    return Err(source.fault(line, what, "check the channel and the units of the file"));
                }
                if points.last().is_none_or(|q| (p.r - q.r).hypot(p.z - q.z) >= JOINT) {
                    points.push(p);
                }
            }
            Ok(())
        };
        let mut vertices = chain.vertices.iter().peekable();
        while let Some((curve, start, line)) = vertices.next() {
            // A basic_curve without points is valid and adds nothing.
            let basic = self.curves.get(curve).ok_or_else(|| {
                let what =
                    format!("the {name} names the curve {}, which does not exist", quote_for_message(curve));
                source.fault(*line, what, "name a basic_curve of the CHANNEL block")
            })?;
            let end = vertices.next_if(|(next, _, _)| next == curve).map(|(_, end, _)| *end);
            match (*start, end) {
                (false, Some(true)) => push(&mut basic.iter(), *line)?,
                (true, Some(false)) => push(&mut basic.iter().rev(), *line)?,
                (false, _) => push(&mut basic.first().into_iter(), *line)?,
                (true, _) => push(&mut basic.last().into_iter(), *line)?,
            }
        }
        if let Some(p) = points.iter().find(|p| p.r < -JOINT) {
            let what = format!("the {name} has a point at r = {} mm", p.r);
            return Err(source.fault(chain.line, what, "give z r with r of 0 or more"));
        }
        for p in &mut points {
            p.r = p.r.max(0.0);
        }
        Ok((source.curve(chain.line, name, points)?, chain.line))
    }
}

impl GeomTurboBlade {
    fn scaled(self, source: Source<'_>, mm: f64) -> Result<BladeDescription, InputError> {
        let scale = mm * self.unit;
        let scaled = |side: Vec<Vec<Point>>| -> Result<Vec<Vec<Point>>, InputError> {
            let side: Vec<Vec<Point>> =
                side.into_iter().map(|s| s.into_iter().map(|p| p * scale).collect()).collect();
            if side.iter().flatten().any(|p| p.coords.amax() > MAX_COORDINATE) {
                let what = "the blade has points beyond 1,000,000 mm";
                return Err(source.fault(self.line, what, "check the units of the file"));
            }
            Ok(side)
        };
        Ok(BladeDescription::Sections {
            suction: scaled(self.suction)?,
            pressure: scaled(self.pressure)?,
            line: self.line,
        })
    }
}

/// Reads one side of a blade: `SECTIONAL`, the number of sections, the sections.
fn side(lines: &mut StatementReader<'_>) -> Result<Vec<Vec<Point>>, InputError> {
    let kind = lines.need("the blade's sections")?;
    if !kind.eq_ignore_ascii_case("SECTIONAL") {
        let what = format!("{} instead of SECTIONAL", quote_for_message(kind));
        return Err(lines.fault(what, "export the blade as sections"));
    }
    let count = lines.count("sections")?;
    let mut sections = Vec::new();
    for _ in 0..count {
        let kind = lines.need("the next section")?;
        let polar = match kind.to_ascii_uppercase().as_str() {
            "XYZ" => false,
            "ZRTH" => true,
            _ => {
                let what = format!("{} instead of XYZ or ZRTH", quote_for_message(kind));
                return Err(lines.fault(what, "export the sections as XYZ or ZRTH"));
            }
        };
        let points = lines.count("points")?;
        if points < 2 {
            return Err(lines
                .fault(format!("a section of {points} point(s)"), "give two or more")
                .with_code(ErrorCode::BladeSections));
        }
        let rows = lines.rows::<3>(points)?;
        let point = |[a, b, c]: [f64; 3]| match polar {
            true => Point::new(b * c.cos(), b * c.sin(), a),
            false => Point::new(a, b, c),
        };
        sections.push(rows.into_iter().map(point).collect());
    }
    Ok(sections)
}

/// Reads a unit factor greater than 0.
fn scale(lines: &StatementReader<'_>, text: &str) -> Result<f64, InputError> {
    match source::number(text) {
        Ok(x) if x > 0.0 => Ok(x),
        _ => Err(lines.fault(
            format!("{} is not a valid unit", quote_for_message(text)),
            "give a number greater than 0",
        )),
    }
}

/// Length in metres of the named unit.
fn unit_in_metres(lines: &StatementReader<'_>, text: &str) -> Result<f64, InputError> {
    match text.to_ascii_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => Ok(1.0),
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => Ok(0.01),
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Ok(0.001),
        "in" | "inch" | "inches" => Ok(0.0254),
        "ft" | "foot" | "feet" => Ok(0.3048),
        _ => Err(lines.fault(
            format!("{} is not a known unit", quote_for_message(text)),
            "give Meters, Millimeters or Inches",
        )),
    }
}

#[cfg(test)]
#[path = "geomturbo_tests.rs"]
pub(super) mod tests;
