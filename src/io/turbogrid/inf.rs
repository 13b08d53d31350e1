//! The `.inf` file: its keys, the files that it names, and the frame of their points.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::error::ErrorCode;
use crate::geometry::Point;
use crate::io::InputError;
use crate::io::source::{JOINT, MAX_POINTS, Source, name_of, quote_for_message, read_bytes, text};
use crate::part::Meridional;

/// The keys of an `.inf` file, in lower case, each with its value and line.
pub(super) struct Inf<'a> {
    source: Source<'a>,
    keys: HashMap<String, (&'a str, usize)>,
}

impl<'a> Inf<'a> {
    pub(super) fn parse(source: Source<'a>, text: &'a str) -> Self {
        let mut keys = HashMap::new();
        for (at, line) in text.lines().enumerate() {
            let line = line.split('!').next().unwrap_or_default();
            if let Some((key, value)) = line.split_once(':') {
                let key = key.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
                keys.entry(key).or_insert((value.trim().trim_matches('"'), at + 1));
            }
        }
        Self { source, keys }
    }

    pub(super) fn need(&self, key: &str, example: &str) -> Result<(&'a str, usize), InputError> {
        self.keys.get(key).copied().ok_or_else(|| {
            let (name, _) = example.split_once(':').unwrap_or((example, ""));
            self.source
                .fault(0, format!("the key `{name}` is missing"), format!("add `{example}`"))
                .with_code(ErrorCode::MissingKey)
        })
    }

    /// Path of the hub, shroud or profile file, and its line in the `.inf` file.
    pub(super) fn data_file(&self, folder: &Path, kind: &str) -> Result<(PathBuf, usize), InputError> {
        let title = format!("{}{}", kind.get(..1).unwrap_or_default().to_uppercase(), &kind[1..]);
        let example = format!("{title} Data File: {kind}.curve");
        let (name, line) = self.need(&format!("{kind} data file"), &example)?;
        let path = folder.join(name.replace('\\', "/"));
        if path.is_file() {
            return Ok((path, line));
        }
        similar_file(folder, &path).map(|path| (path, line)).ok_or_else(|| {
            let what = format!("the {kind} file {} does not exist", quote_for_message(name));
            self.source
                .fault(line, what, "put it beside the .inf file, or correct its name")
                .with_code(ErrorCode::FileUnreadable)
        })
    }

    pub(super) fn flowpath(
        &self,
        folder: &Path,
        kind: &str,
        frame: TurboGridFrame,
    ) -> Result<(Vec<Meridional>, usize), InputError> {
        let (path, line) = self.data_file(folder, kind)?;
        let name = name_of(&path);
        let source = Source::new(&name, ErrorCode::PartFile);
        let bytes = read_bytes(&path)?;
        let mut points: Vec<Meridional> = Vec::new();
        for (at, line) in text(source, &bytes)?.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with(['#', '!']) {
                continue;
            }
            let (p, _) = frame.point(source, at + 1, line)?;
            let p = Meridional { r: p.x.hypot(p.y), z: p.z };
            if points.last().is_none_or(|q| (p.r - q.r).hypot(p.z - q.z) >= JOINT) {
                points.push(p);
            }
            if points.len() > MAX_POINTS {
                return Err(source
                    .fault(at + 1, "holds more than 1,000,000 points", "give fewer points")
                    .with_code(ErrorCode::FileTooLarge));
            }
        }
        if points.len() < 2 {
            let what = format!("the {kind} has {} distinct point(s)", points.len());
            return Err(source
                .fault(0, what, "give two or more, upstream to downstream")
                .with_code(ErrorCode::FlowCurve));
        }
        Ok((points, line))
    }
}

/// The only file of the folder with this name in another case or with a prefix: exported sets are often
/// renamed together (`stage1_hub.curve` for `hub.curve`).
fn similar_file(folder: &Path, path: &Path) -> Option<PathBuf> {
    let wanted = path.file_name()?.to_string_lossy().to_lowercase();
    let suffix = format!("_{wanted}");
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut similar = std::fs::read_dir(folder).ok()?.take(10_000).filter_map(|entry| {
        let path = entry.ok()?.path();
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        ((name == wanted || name.ends_with(&suffix)) && path.is_file()).then_some(path)
    });
    let first = similar.next()?;
    similar.next().is_none().then_some(first)
}

/// Transform from the file's axis and unit to the part frame: mm, rotation axis Z.
#[derive(Clone, Copy)]
pub(super) struct TurboGridFrame {
    /// Indices of the file's coordinates that become x, y, z.
    order: [usize; 3],
    /// Length of the file's unit, mm.
    unit_mm: f64,
}

impl TurboGridFrame {
    pub(super) fn from_inf(inf: &Inf<'_>) -> Result<Self, InputError> {
        let (unit, line) = inf.need("geometry units", "Geometry Units: MM")?;
        let unit = match unit.to_ascii_uppercase().as_str() {
            "MM" => 1.0,
            "CM" => 10.0,
            "M" => 1000.0,
            "IN" | "INCH" => 25.4,
            "FT" => 304.8,
            _ => {
                let what = format!("{} is not a known unit", quote_for_message(unit));
                return Err(inf
                    .source
                    .fault(line, what, "give MM, CM, M, IN or FT")
                    .with_code(ErrorCode::UnknownName));
            }
        };
        let (axis, line) = inf.keys.get("axis of rotation").copied().unwrap_or(("Z", 0));
        let order = match axis.to_ascii_uppercase().as_str() {
            "Z" => [0, 1, 2],
            "X" => [1, 2, 0],
            "Y" => [2, 0, 1],
            _ => {
                let what = format!("{} is not a known axis", quote_for_message(axis));
                return Err(inf.source.fault(line, what, "give X, Y or Z").with_code(ErrorCode::UnknownName));
            }
        };
        Ok(Self { order, unit_mm: unit })
    }

    /// Parses `x y z` into a point in the part frame (mm), and the token that follows.
    pub(super) fn point<'t>(
        self,
        source: Source<'_>,
        line: usize,
        text: &'t str,
    ) -> Result<(Point, &'t str), InputError> {
        let mut tokens =
            text.split(|c: char| c.is_whitespace() || c == ',').filter(|token| !token.is_empty());
        let mut xyz = [0.0; 3];
        for coordinate in &mut xyz {
            let token = tokens.next().ok_or_else(|| {
                source.fault(line, "a point has fewer than 3 numbers", "give x y z on a line")
            })?;
            *coordinate = source.length(line, token, self.unit_mm)?;
        }
        let [x, y, z] = self.order.map(|k| xyz.get(k).copied().unwrap_or_default());
        Ok((Point::new(x, y, z), tokens.next().unwrap_or("")))
    }
}
