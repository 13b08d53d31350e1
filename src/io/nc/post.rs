//! Posts: the words of a control as data. `docs/formats.md` lists the keys.

use std::collections::BTreeMap;
use std::path::Path;

use super::format::NumberFormat;
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::source::{name_of, quote_for_message, read_bytes};
use crate::io::table::{Located, TomlDocument, TomlTable};
use crate::machine::OutputKind;

/// The grammar of a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// Klartext of the TNC.
    Heidenhain,
    /// Sinumerik 840D sl.
    Siemens,
    /// Fanuc 30i/31i.
    Fanuc,
    /// Haas NGC.
    Haas,
    /// LinuxCNC.
    LinuxCnc,
}

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 5] = [Self::Heidenhain, Self::Siemens, Self::Fanuc, Self::Haas, Self::LinuxCnc];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Heidenhain => "heidenhain",
            Self::Siemens => "siemens",
            Self::Fanuc => "fanuc",
            Self::Haas => "haas",
            Self::LinuxCnc => "linuxcnc",
        }
    }

    /// Text of the post that comes with the program.
    fn text(self) -> &'static str {
        match self {
            Self::Heidenhain => include_str!("../../../assets/posts/heidenhain.toml"),
            Self::Siemens => include_str!("../../../assets/posts/siemens.toml"),
            Self::Fanuc => include_str!("../../../assets/posts/fanuc.toml"),
            Self::Haas => include_str!("../../../assets/posts/haas.toml"),
            Self::LinuxCnc => include_str!("../../../assets/posts/linuxcnc.toml"),
        }
    }
}

/// Groups of blocks of a post, in the order of a program; the last two take the place of `start` and `end`
/// where a program is called by another.
pub(super) const GROUPS: [&str; 8] =
    ["start", "retract", "tool", "ready", "leave", "end", "sub_start", "sub_end"];
/// Words in braces that the writer fills in.
const WORDS: [&str; 16] = [
    "name",
    "number",
    "machine",
    "offset",
    "preset",
    "retract",
    "tool",
    "length_offset",
    "diameter",
    "spindle",
    "x",
    "y",
    "angles",
    "p1",
    "p2",
    "p3",
];
/// Longest list of blocks.
const MAX_BLOCKS: usize = 100;

/// A post.
#[derive(Clone, Debug, PartialEq)]
pub struct Post {
    /// Its name: that of the control, or of its file.
    pub name: String,
    /// The grammar.
    pub dialect: Dialect,
    /// Numbers.
    pub format: NumberFormat,
    /// Blocks by group; see `GROUPS`.
    pub(super) blocks: BTreeMap<&'static str, Vec<String>>,
    /// Blocks that switch an output on; an output without them is not to be had.
    pub(super) on: BTreeMap<OutputKind, Vec<String>>,
    /// Blocks that switch it off.
    pub(super) off: BTreeMap<OutputKind, Vec<String>>,
    /// Whether another program calls what it writes.
    pub(super) is_called: bool,
}

impl Post {
    /// Outputs that the control takes.
    pub fn outputs(&self) -> impl Iterator<Item = OutputKind> + '_ {
        self.on.keys().copied()
    }

    /// Where programs retract to, for those who run them, on a machine with this `retract_z`, mm: a control
    /// that calls the upper limit of Z otherwise would take the tool elsewhere.
    pub fn retract_words(&self, retract_z: f64) -> String {
        let blocks = self.blocks.get("retract").map(Vec::as_slice).unwrap_or_default();
        let to = if blocks.iter().any(|block| block.contains("{retract}")) {
            format!("Z {retract_z} in the control's machine coordinates")
        } else {
            "the retract position of the post".to_owned()
        };
        format!("Retracts to {to}, which must be the upper limit of Z")
    }

    /// Whether the post says how a program begins and ends that another one calls.
    pub fn takes_subprograms(&self) -> bool {
        ["sub_start", "sub_end"].iter().all(|group| self.blocks.contains_key(group))
    }

    /// The post of programs that another one calls: they choose no work offset, and return at their end.
    ///
    /// # Errors
    /// When the post does not say how they begin and end.
    pub fn into_subprogram(mut self) -> Result<Self, UserError> {
        let (Some(start), Some(end)) = (self.blocks.remove("sub_start"), self.blocks.remove("sub_end"))
        else {
            let what = format!("the post {} has no `sub_start` and `sub_end`", self.name);
            return Err(UserError::new(ErrorCode::MissingKey, what, "give it both, as in assets/posts"));
        };
        self.blocks.insert("start", start);
        self.blocks.insert("end", end);
        self.is_called = true;
        Ok(self)
    }
}

/// Names of the posts that come with the program.
pub fn built_in_posts() -> impl Iterator<Item = &'static str> {
    Dialect::ALL.into_iter().map(Dialect::name)
}

/// The post of a control by its name, or read from the file of that name.
///
/// # Errors
/// When the name is neither that of a control nor of a file, or the file is not valid.
pub fn read_post(name_or_path: &str) -> Result<Post, InputError> {
    if let Some(dialect) = Dialect::ALL.into_iter().find(|dialect| dialect.name() == name_or_path) {
        return read_post_bytes(name_or_path, dialect.text().as_bytes());
    }
    let path = Path::new(name_or_path);
    if !path.exists() && !name_or_path.contains(['/', '\\', '.']) {
        let known: Vec<&str> = built_in_posts().collect();
        let what = format!("no post for the control {} is known", quote_for_message(name_or_path));
        return Err(InputError::new(
            ErrorCode::UnknownName,
            "",
            0,
            what,
            format!("use {}, or a post file", known.join(", ")),
        ));
    }
    read_post_bytes(&name_of(path), &read_bytes(path)?)
}

/// Reads a post from bytes; `name` is the file name used in messages. With `extends` it changes a post that
/// comes with the program.
///
/// # Errors
/// When the bytes are not TOML, a key is unknown, or a word in braces is.
pub fn read_post_bytes(name: &str, bytes: &[u8]) -> Result<Post, InputError> {
    let document = TomlDocument::new(name, bytes, ErrorCode::MachineFile)?;
    let tree = document.parse()?;
    let root = document.root(&tree);
    root.check_keys(&["dialect", "extends", "format", "blocks", "on", "off"])?;
    let named = |key: &str| -> Result<Option<Dialect>, InputError> {
        let Some(text) = root.string(key)? else { return Ok(None) };
        let found = Dialect::ALL.into_iter().find(|dialect| dialect.name() == text.value);
        found.map(Some).ok_or_else(|| {
            let known: Vec<&str> = built_in_posts().collect();
            let what = format!("unknown control {}", quote_for_message(text.value));
            root.fault_at(text.at, what, format!("use one of {}", known.join(", ")))
                .with_code(ErrorCode::UnknownName)
        })
    };
    let mut post = match (named("dialect")?, named("extends")?) {
        (None, Some(base)) => read_post_bytes(base.name(), base.text().as_bytes())?,
        (Some(dialect), None) => Post {
            name: String::new(),
            dialect,
            format: NumberFormat {
                decimals: 4,
                angle_decimals: 4,
                vector_decimals: 8,
                feed_decimals: 1,
                comma: false,
                plus: false,
                short: true,
                numbers: None,
            },
            blocks: BTreeMap::new(),
            on: BTreeMap::new(),
            off: BTreeMap::new(),
            is_called: false,
        },
        _ => {
            return Err(root
                .fault("the post names no control", "give either `extends` or `dialect`")
                .with_code(ErrorCode::MissingKey));
        }
    };
    post.name = name.to_owned();
    if let Some(table) = root.table("format")? {
        format(&table, &mut post.format)?;
    }
    if let Some(table) = root.table("blocks")? {
        table.check_keys(&GROUPS)?;
        for group in GROUPS {
            if let Some(lines) = lines(&table, group)? {
                post.blocks.insert(group, lines);
            }
        }
    }
    for (key, map) in [("on", &mut post.on), ("off", &mut post.off)] {
        let Some(table) = root.table(key)? else { continue };
        table.check_keys(&OutputKind::ALL.map(OutputKind::name))?;
        for output in OutputKind::ALL {
            if let Some(lines) = lines(&table, output.name())? {
                map.insert(output, lines);
            }
        }
    }
    Ok(post)
}

fn format(table: &TomlTable<'_>, format: &mut NumberFormat) -> Result<(), InputError> {
    table.check_keys(&[
        "decimals",
        "angle_decimals",
        "vector_decimals",
        "feed_decimals",
        "comma",
        "plus",
        "short",
        "numbers",
    ])?;
    for (key, low, high, value) in [
        ("decimals", 1, 9, &mut format.decimals),
        ("angle_decimals", 1, 9, &mut format.angle_decimals),
        ("vector_decimals", 4, 12, &mut format.vector_decimals),
        ("feed_decimals", 0, 6, &mut format.feed_decimals),
    ] {
        if let Some(number) = table.whole(key, low, high)? {
            *value = number.value as usize;
        }
    }
    for (key, value) in
        [("comma", &mut format.comma), ("plus", &mut format.plus), ("short", &mut format.short)]
    {
        if let Some(choice) = table.boolean(key)? {
            *value = choice.value;
        }
    }
    if let Some(Located { value, at }) = table.numbers("numbers")? {
        let whole = |x: &f64| x.fract() == 0.0 && (0.0..=1e6).contains(x);
        format.numbers = match value.as_slice() {
            [] => None,
            [first, step] if whole(first) && whole(step) && *step >= 1.0 => {
                Some((*first as u32, *step as u32))
            }
            _ => {
                return Err(table.fault_at(
                    at,
                    "`numbers` is not a first number and a step",
                    "give [10, 10] or []",
                ));
            }
        };
    }
    Ok(())
}

/// A list of blocks, whose words in braces are known.
fn lines(table: &TomlTable<'_>, key: &str) -> Result<Option<Vec<String>>, InputError> {
    let Some(lines) = table.strings(key)? else { return Ok(None) };
    if lines.len() > MAX_BLOCKS {
        let what = format!("`{key}` has more than {MAX_BLOCKS} blocks");
        return Err(table.fault(what, "give fewer").with_code(ErrorCode::FileTooLarge));
    }
    for Located { value, at } in &lines {
        if value.chars().any(char::is_control) {
            return Err(table.fault_at(*at, "a block is more than one line", "give each block its own text"));
        }
        for piece in value.split('{').skip(1) {
            let word = piece.split('}').next().unwrap_or_default();
            if !WORDS.contains(&word) || !piece.contains('}') {
                let what = format!("unknown word {} in braces", quote_for_message(word));
                return Err(table
                    .fault_at(*at, what, format!("use one of {}", WORDS.join(", ")))
                    .with_code(ErrorCode::UnknownName));
            }
        }
    }
    Ok(Some(lines.into_iter().map(|line| line.value.to_owned()).collect()))
}
