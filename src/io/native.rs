//! The native part file, in TOML; lengths in mm, angles in degrees, rotation axis Z.
//!
//! ```toml
//! name = "impeller"
//! blades = 17
//! [hub]                                  # inlet → outlet, [r, z]; [shroud] likewise
//! points = [[30.0, 0.0], [100.0, 60.0]]  # or: control = [[r, z], …], degree = 3, knots = []
//! [shroud]
//! points = [[60.0, 0.0], [100.0, 50.0]]
//! [[main.span]]                          # two or more, hub → shroud
//! span = 0.0                             # 0 hub, 1 shroud
//! leading_edge = 0.0                     # fraction of the channel's meridional length, default 0
//! theta_leading_edge = 0.0               # default 0
//! angle = [[0.0, 30.0], [1.0, 45.0]]     # [fraction LE → TE, angle from the meridional direction]
//! thickness = [[0.0, 2.0], [1.0, 1.2]]   # [fraction LE → TE, mm]
//! [[splitter.span]]                      # splitters, as [main]; several under [[splitter]] headers
//! ```
//!
//! Instead of `span` tables, a blade may have `[[main.section]]` tables with `suction` and
//! `pressure`, lists of `[x, y, z]` points from leading to trailing edge.

use std::fmt::Write;

use super::InputError;
use super::source::{MAX_BLADES, MAX_COORDINATE, MAX_POINTS, Source, stem_of};
use super::table::{Located, NumberRange, NumberRows, TomlDocument, TomlTable, degrees_text, quoted};
use crate::error::ErrorCode;
use crate::geometry::Point;
use crate::part::{BladeDescription, CamberSpan, CurveDescription, Meridional, PartDescription};

/// Reads a native part. `file` is the file name used in messages; its stem names a part without `name`.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<PartDescription, InputError> {
    let document = TomlDocument::new(file, bytes, ErrorCode::PartFile)?;
    let tree = document.parse()?;
    let root = document.root(&tree);
    root.check_keys(&["name", "blades", "hub", "shroud", "main", "splitter"])?;
    let blades = root.whole("blades", 1, MAX_BLADES as u32)?.ok_or_else(|| {
        root.fault("the number of blades is missing", "add `blades = 17` before the first header")
            .with_code(ErrorCode::BladeCount)
    })?;
    let (hub, hub_line) = flowpath(&root, Source::new(file, ErrorCode::PartFile), "hub")?;
    let (shroud, shroud_line) = flowpath(&root, Source::new(file, ErrorCode::PartFile), "shroud")?;
    let main = root.table("main")?.ok_or_else(|| {
        root.fault("the main blade is missing", "add two or more [[main.span]] tables")
            .with_code(ErrorCode::MissingKey)
    })?;
    let mut points = 0;
    let main = blade(&main, &mut points)?;
    let splitters = splitters(&root)?.iter().map(|s| blade(s, &mut points)).collect::<Result<_, _>>()?;
    Ok(PartDescription {
        name: root.string("name")?.map_or_else(|| stem_of(file), |name| name.value.to_owned()),
        hub,
        shroud,
        blade_count: blades.value as usize,
        main,
        splitters,
        hub_line,
        shroud_line,
        count_line: document.line(blades.at),
        notes: Vec::new(),
        roles_by_shape: false,
    })
}

/// The `[[splitter]]` tables, or the single splitter written as `[splitter]` or `[[splitter.span]]`.
fn splitters<'t>(root: &TomlTable<'t>) -> Result<Vec<TomlTable<'t>>, InputError> {
    if let Ok(Some(one)) = root.table("splitter") {
        return Ok(vec![one]);
    }
    root.tables("splitter")
}

fn flowpath(
    root: &TomlTable<'_>,
    source: Source<'_>,
    name: &str,
) -> Result<(CurveDescription, usize), InputError> {
    let table = root.table(name)?.ok_or_else(|| {
        root.fault(format!("the {name} is missing"), format!("add [{name}] with points = [[r, z], …]"))
            .with_code(ErrorCode::MissingKey)
    })?;
    table.check_keys(&["points", "control", "degree", "knots"])?;
    let meridional = |rows: Located<NumberRows<2>>| -> Result<Vec<Meridional>, InputError> {
        rows.value
            .into_iter()
            .map(|row| {
                let [r, z] = row.value;
                if r < 0.0 {
                    let what = format!("a point of the {name} has r = {r}");
                    return Err(table.fault_at(row.at, what, "give [r, z] with r of 0 or more"));
                }
                Ok(Meridional { r, z })
            })
            .collect()
    };
    match (table.rows::<2>("points")?, table.rows::<2>("control")?) {
        (Some(rows), None) => {
            if let Some(degree) = table.whole("degree", 1, 3)? {
                let help = "use `control` instead of `points`, or remove `degree`";
                return Err(table
                    .fault_at(degree.at, "`degree` goes with `control`", help)
                    .with_code(ErrorCode::ConflictingKeys));
            }
            if table.numbers("knots")?.is_some() {
                let help = "use `control` instead of `points`, or remove `knots`";
                return Err(table
                    .fault("`knots` go with `control`", help)
                    .with_code(ErrorCode::ConflictingKeys));
            }
            Ok((source.curve(table.line(), name, meridional(rows)?)?, table.line()))
        }
        (None, Some(rows)) => {
            let control = meridional(rows)?;
            Ok((spline(&table, name, control)?, table.line()))
        }
        (Some(_), Some(_)) => Err(table
            .fault(format!("the {name} has both `points` and `control`"), "keep one of them")
            .with_code(ErrorCode::ConflictingKeys)),
        (None, None) => Err(table
            .fault(format!("the {name} is empty"), "add points = [[r, z], …]")
            .with_code(ErrorCode::MissingKey)),
    }
}

fn spline(
    table: &TomlTable<'_>,
    name: &str,
    control: Vec<Meridional>,
) -> Result<CurveDescription, InputError> {
    if control.len() < 2 {
        let what = format!("the {name} has {} control point(s)", control.len());
        return Err(table.fault(what, "give two or more"));
    }
    let highest = (control.len() - 1).min(3) as u32;
    let degree = table.whole("degree", 1, highest)?.map_or(highest, |d| d.value) as usize;
    let knots = table.numbers("knots")?;
    if let Some(knots) = knots.as_ref().filter(|knots| !knots.value.is_empty()) {
        let wanted = control.len() + degree + 1;
        if knots.value.len() != wanted {
            let what = format!("{} knots for {} control points", knots.value.len(), control.len());
            let help = format!("give {wanted} (degree {degree}), or leave `knots` out");
            return Err(table.fault_at(knots.at, what, help));
        }
        // The domain of a B-spline runs from knot `degree` to knot `control.len()`.
        let domain = knots.value.get(control.len()).zip(knots.value.get(degree)).map(|(b, a)| b - a);
        if !knots.value.is_sorted() || domain.is_none_or(|d| d <= 0.0) {
            let help = "give them in rising order, or leave `knots` out";
            return Err(table
                .fault_at(knots.at, "the knots do not rise", help)
                .with_code(ErrorCode::FlowCurve));
        }
    }
    Ok(CurveDescription::BSpline { control, degree, knots: knots.map_or_else(Vec::new, |k| k.value) })
}

fn blade(table: &TomlTable<'_>, points: &mut usize) -> Result<BladeDescription, InputError> {
    table.check_keys(&["span", "section"])?;
    let (spans, sections) = (table.tables("span")?, table.tables("section")?);
    let blade = match (spans.first(), sections.first()) {
        (Some(_), Some(_)) => {
            let what = format!("{} has both spans and sections", table.shown());
            return Err(table.fault(what, "keep one kind").with_code(ErrorCode::ConflictingKeys));
        }
        (Some(first), None) => {
            let line = first.line();
            BladeDescription::Camber { spans: camber(&spans, points)?, line }
        }
        (None, Some(first)) => {
            let line = first.line();
            let mut sides = (Vec::new(), Vec::new());
            for section in &sections {
                section.check_keys(&["suction", "pressure"])?;
                sides.0.push(side(section, "suction", points)?);
                sides.1.push(side(section, "pressure", points)?);
            }
            BladeDescription::Sections { suction: sides.0, pressure: sides.1, line }
        }
        (None, None) => {
            return Err(table
                .fault(
                    format!("{} holds no spans and no sections", table.shown()),
                    "add two or more `span` tables, hub to shroud",
                )
                .with_code(ErrorCode::MissingKey));
        }
    };
    if spans.len().max(sections.len()) < 2 {
        let what = format!("{} has only one span section", table.shown());
        return Err(table.fault(what, "give two or more, hub to shroud").with_code(ErrorCode::BladeSections));
    }
    Ok(blade)
}

fn count(section: &TomlTable<'_>, points: &mut usize, more: usize) -> Result<(), InputError> {
    *points += more;
    if *points > MAX_POINTS {
        return Err(section
            .fault("the blades hold more than 1,000,000 points", "give fewer points")
            .with_code(ErrorCode::FileTooLarge));
    }
    Ok(())
}

fn side(section: &TomlTable<'_>, key: &str, points: &mut usize) -> Result<Vec<Point>, InputError> {
    let rows = section.rows::<3>(key)?.ok_or_else(|| {
        section
            .fault(
                format!("{} has no `{key}` side", section.shown()),
                format!("add {key} = [[x, y, z], …] from leading to trailing edge"),
            )
            .with_code(ErrorCode::MissingKey)
    })?;
    if rows.value.len() < 2 {
        let what = format!("`{key}` has {} point(s)", rows.value.len());
        return Err(section.fault_at(rows.at, what, "give two or more"));
    }
    count(section, points, rows.value.len())?;
    Ok(rows.value.iter().map(|row| Point::from(row.value)).collect())
}

fn camber(tables: &[TomlTable<'_>], points: &mut usize) -> Result<Vec<CamberSpan>, InputError> {
    let mut spans: Vec<CamberSpan> = Vec::with_capacity(tables.len());
    for table in tables {
        table.check_keys(&["span", "leading_edge", "theta_leading_edge", "angle", "thickness"])?;
        let span = table.number("span", NumberRange::Between(0.0, 1.0))?.ok_or_else(|| {
            table
                .fault(format!("{} has no `span`", table.shown()), "add span = 0.0 (hub) … 1.0 (shroud)")
                .with_code(ErrorCode::MissingKey)
        })?;
        if let Some(below) = spans.last().filter(|below| below.span >= span.value) {
            let what = format!("span {} comes after span {}", span.value, below.span);
            return Err(table
                .fault_at(span.at, what, "order the spans from hub to shroud")
                .with_code(ErrorCode::BladeSections));
        }
        let angle = stations(table, "angle", NumberRange::Within(-90.0, 90.0), points)?;
        spans.push(CamberSpan {
            span: span.value,
            leading_edge: table.number_or("leading_edge", NumberRange::Between(0.0, 0.99), 0.0)?,
            theta_leading_edge: table
                .number_or("theta_leading_edge", NumberRange::Between(-3600.0, 3600.0), 0.0)?
                .to_radians(),
            angle: angle.into_iter().map(|(u, degrees)| (u, degrees.to_radians())).collect(),
            thickness: stations(table, "thickness", NumberRange::Between(0.0, MAX_COORDINATE), points)?,
        });
    }
    Ok(spans)
}

/// Reads (fraction, value) rows from LE to TE; fractions increase within 0…1.
fn stations(
    table: &TomlTable<'_>,
    key: &str,
    range: NumberRange,
    points: &mut usize,
) -> Result<Vec<(f64, f64)>, InputError> {
    let rows = table.rows::<2>(key)?.ok_or_else(|| {
        table
            .fault(format!("{} has no `{key}`", table.shown()), format!("add {key} = [[0.0, …], [1.0, …]]"))
            .with_code(ErrorCode::MissingKey)
    })?;
    if rows.value.is_empty() {
        return Err(table
            .fault_at(rows.at, format!("`{key}` is empty"), "give one or more [fraction, value]")
            .with_code(ErrorCode::BladeValues));
    }
    count(table, points, rows.value.len())?;
    let mut stations: Vec<(f64, f64)> = Vec::with_capacity(rows.value.len());
    for row in &rows.value {
        let [fraction, value] = row.value;
        let rises = stations.last().is_none_or(|(before, _)| *before < fraction);
        if !rises || !(0.0..=1.0).contains(&fraction) {
            let help = "let the fractions rise from 0 (leading edge) to 1 (trailing edge)";
            return Err(table
                .fault_at(row.at, format!("`{key}` has the fraction {fraction} here"), help)
                .with_code(ErrorCode::BladeValues));
        }
        range.check(value).map_err(|help| {
            table
                .fault_at(row.at, format!("`{key}` has the value {value} here"), help)
                .with_code(ErrorCode::BladeValues)
        })?;
        stations.push((fraction, value));
    }
    Ok(stations)
}

/// Writes a part as a native file (mm, degrees). Reading it back gives the same part except for line
/// numbers and the last bit of angles.
pub fn write_native(part: &PartDescription) -> String {
    let mut out = String::new();
    push(&mut out, format_args!("name = {}\nblades = {}\n", quoted(&part.name), part.blade_count));
    write_flowpath(&mut out, "hub", &part.hub);
    write_flowpath(&mut out, "shroud", &part.shroud);
    write_blade(&mut out, "main", &part.main);
    for splitter in &part.splitters {
        out.push_str("\n[[splitter]]\n");
        write_blade(&mut out, "splitter", splitter);
    }
    out
}

/// Appends formatted text; `write!` to a `String` cannot fail.
fn push(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = out.write_fmt(text);
}

fn write_list<T>(out: &mut String, key: &str, list: &[T], row: impl Fn(&T) -> String) {
    push(out, format_args!("{key} = ["));
    for item in list {
        push(out, format_args!("\n  {},", row(item)));
    }
    out.push_str(if list.is_empty() { "]\n" } else { "\n]\n" });
}

fn write_flowpath(out: &mut String, name: &str, curve: &CurveDescription) {
    let row = |p: &Meridional| format!("[{:?}, {:?}]", p.r, p.z);
    push(out, format_args!("\n[{name}] # [r, z] in mm, inlet to outlet\n"));
    match curve {
        CurveDescription::Points(points) => write_list(out, "points", points, row),
        CurveDescription::BSpline { control, degree, knots } => {
            push(out, format_args!("degree = {degree}\nknots = {knots:?}\n"));
            write_list(out, "control", control, row);
        }
    }
}

fn write_blade(out: &mut String, name: &str, blade: &BladeDescription) {
    match blade {
        BladeDescription::Sections { suction, pressure, .. } => {
            let row = |p: &Point| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z);
            for (suction, pressure) in suction.iter().zip(pressure) {
                push(out, format_args!("\n[[{name}.section]] # [x, y, z] in mm, leading to trailing edge\n"));
                write_list(out, "suction", suction, row);
                write_list(out, "pressure", pressure, row);
            }
        }
        BladeDescription::Camber { spans, .. } => {
            for span in spans {
                push(out, format_args!("\n[[{name}.span]] # angles in degrees, thickness in mm\n"));
                push(out, format_args!("span = {:?}\nleading_edge = {:?}\n", span.span, span.leading_edge));
                let theta = degrees_text(span.theta_leading_edge);
                push(out, format_args!("theta_leading_edge = {theta}\n"));
                write_list(out, "angle", &span.angle, |(u, a)| format!("[{u:?}, {}]", degrees_text(*a)));
                write_list(out, "thickness", &span.thickness, |(u, t)| format!("[{u:?}, {t:?}]"));
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A small valid part with every kind of key.
    pub const SAMPLE: &str = r#"
name = "small \"one\""
blades = 9
[hub]
points = [[20, 0.0], [25.0, 30.0], [50.0, 45.0]]
[shroud]
control = [[40.0, 0.0], [40.0, 25.0], [50.0, 38.0]]
degree = 2
knots = [0, 0, 0, 1, 1, 1]
[main]
[[main.span]]
span = 0.0
theta_leading_edge = -12.5
angle = [[0.0, 30.0], [0.4, 41.3], [1.0, 45.0]]
thickness = [[0.0, 2.0], [1.0, 1.2]]
[[main.span]]
span = 1.0
angle = [[0.0, 50.0], [1.0, 45.0]]
thickness = [[0.0, 1.0]]
[[splitter]]
[[splitter.section]]
suction = [[20.0, 1.0, 5.0], [50.0, 20.0, 40.0]]
pressure = [[20.0, 1.0, 5.0], [50.0, 18.0, 40.0]]
[[splitter.section]]
suction = [[40.0, 1.0, 5.0], [50.0, 20.0, 35.0]]
pressure = [[40.0, 1.0, 5.0], [50.0, 18.0, 35.0]]
"#;

    fn sample() -> PartDescription {
        read("sample.toml", SAMPLE.as_bytes()).expect("the sample is valid")
    }

    fn fault(from: &str, to: &str) -> InputError {
        assert!(SAMPLE.contains(from), "{from} must be in the sample");
        read("sample.toml", SAMPLE.replacen(from, to, 1).as_bytes()).expect_err("must be refused")
    }

    #[test]
    fn reads_every_key() {
        let part = sample();
        assert_eq!((part.name.as_str(), part.blade_count, part.count_line), ("small \"one\"", 9, 3));
        assert_eq!((part.hub_line, part.shroud_line), (4, 6));
        let BladeDescription::Camber { spans, line } = &part.main else { panic!("camber expected") };
        assert_eq!((*line, spans.len(), spans[0].angle.len()), (11, 2, 3));
        assert_eq!(spans[0].theta_leading_edge, (-12.5f64).to_radians());
        let BladeDescription::Sections { pressure, .. } = &part.splitters[0] else { panic!("sections") };
        assert_eq!(pressure[1][1], Point::new(50.0, 18.0, 35.0));
    }

    #[test]
    fn written_part_reads_back_the_same() {
        let text = write_native(&sample());
        let again = read("sample.toml", text.as_bytes()).expect("the writer's text is valid");
        assert_eq!(write_native(&again), text);
        let part = sample();
        assert_eq!((&again.hub, &again.shroud, &again.name), (&part.hub, &part.shroud, &part.name));
        let (BladeDescription::Camber { spans: a, .. }, BladeDescription::Camber { spans: b, .. }) =
            (&again.main, &part.main)
        else {
            panic!("camber expected")
        };
        assert_eq!(a, b);
    }

    #[test]
    fn one_splitter_needs_no_header_of_its_own() {
        let part = read("s.toml", SAMPLE.replace("[[splitter]]\n", "").as_bytes()).unwrap();
        assert_eq!(part.splitters.len(), 1);
    }

    #[test]
    fn faults_name_line_and_cure() {
        let unknown = fault("thickness = [[0.0, 2.0]", "thicknes = [[0.0, 2.0]");
        assert_eq!(
            unknown.to_string(),
            "sample.toml:15: unknown key `thicknes` in [main.span]; \
             use `thickness`, the nearest known key, or remove it"
        );
        for (from, to, line) in [
            ("blades = 9", "blades = 10000", 3),
            ("blades = 9", "blades = 0", 3),
            ("blades = 9", "blades = -1", 3),
            ("blades = 9", "blades = 9.5", 3),
            ("blades = 9", "blades = ", 3),
            ("[20, 0.0]", "[20, nan]", 5),
            ("[20, 0.0]", "[20, 1e300]", 5),
            ("[20, 0.0]", "[20, 1e400]", 5),
            ("[20, 0.0]", "[-20, 0.0]", 5),
            ("[20, 0.0]", "[20]", 5),
            ("[20, 0.0], [25.0, 30.0], [50.0, 45.0]", "[20, 0.0]", 4),
            ("degree = 2", "degree = 3", 8),
            ("[0, 0, 0, 1, 1, 1]", "[0, 0, 1, 1, 1]", 9),
            ("[0, 0, 0, 1, 1, 1]", "[0, 0, 1, 0, 1, 1]", 9),
            ("[0.4, 41.3]", "[1.4, 41.3]", 14),
            ("[0.4, 41.3]", "[0.4, 90.0]", 14),
            ("span = 1.0", "span = 0.0", 17),
            ("[[0.0, 1.0]]", "[]", 19),
            ("[[0.0, 1.0]]", "[[0.0, -1.0]]", 19),
        ] {
            let error = fault(from, to);
            assert_eq!(error.line, line, "{from} → {to}: {error}");
            assert!(!error.to_string().contains('\n'), "one line: {error}");
        }
    }

    #[test]
    fn missing_pieces_have_their_code() {
        for (from, to, code) in [
            ("[hub]", "[shaft]", ErrorCode::UnknownKey),
            ("blades = 9", "", ErrorCode::BladeCount),
            ("[hub]\npoints = [[20, 0.0], [25.0, 30.0], [50.0, 45.0]]", "", ErrorCode::MissingKey),
            ("[main]", "[[main.section]]", ErrorCode::ConflictingKeys),
            ("angle = [[0.0, 50.0], [1.0, 45.0]]", "", ErrorCode::MissingKey),
        ] {
            let error = fault(from, to);
            assert_eq!(error.code, code, "{error}");
        }
        let one = SAMPLE.find("[[main.span]]\nspan = 1.0").zip(SAMPLE.find("[[splitter]]"));
        let (a, b) = one.expect("both are in the sample");
        let text = format!("{}{}", &SAMPLE[..a], &SAMPLE[b..]);
        let error = read("s.toml", text.as_bytes()).unwrap_err();
        assert_eq!(error.code, ErrorCode::BladeSections, "{error}");
    }
}
