//! The tables of a TOML document: keys are checked by name, numbers by range, and every error has the line of
//! its value.

mod document;
mod range;
mod text;

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::InputError;
use super::source::{self, quote_for_message};
use crate::error::{ErrorCode, UserError};
pub use document::TomlDocument;
pub use range::NumberRange;
pub use text::{degrees_text, known_or_none, nearest_note, quoted};

impl<'a> TomlDocument<'a> {
    /// The root table.
    pub fn root<'t>(&'t self, table: &'t Spanned<DeTable<'a>>) -> TomlTable<'t> {
        TomlTable { doc: self, name: String::new(), table: table.get_ref(), at: 0, renamed: &[] }
    }
}

/// A dotted key with its values.
pub(crate) type DottedScalars = (String, Vec<Located<Scalar>>);

/// A value and its byte offset.
#[derive(Clone, Copy)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Byte offset, for [`TomlDocument::fault`].
    pub at: usize,
}

/// A value that is neither a list nor a table.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
pub enum Scalar {
    /// True or false.
    Flag(bool),
    /// An integer.
    Whole(i64),
    /// A number with a decimal point.
    Number(f64),
    /// A string.
    Text(String),
}

impl std::fmt::Display for Scalar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => write!(f, "{text}"),
        }
    }
}

/// Rows of `N` numbers, each with its byte offset.
pub type NumberRows<const N: usize> = Vec<Located<[f64; N]>>;

/// One table of a document.
pub struct TomlTable<'t> {
    doc: &'t TomlDocument<'t>,
    name: String,
    table: &'t DeTable<'t>,
    at: usize,
    renamed: RenamedKeys,
}

/// Keys with their former names, which files may still use: (name, former name).
pub type RenamedKeys = &'static [(&'static str, &'static str)];

impl<'t> TomlTable<'t> {
    /// The table, in which each of `renamed` is found by its former name too.
    pub fn with_renamed_keys(self, renamed: RenamedKeys) -> Self {
        Self { renamed, ..self }
    }

    /// Folder of the file, for paths that are relative to it; empty where the document is not a file.
    pub fn folder(&self) -> &Path {
        Path::new(self.doc.file()).parent().unwrap_or(Path::new(""))
    }

    /// Line of the table's header.
    pub fn line(&self) -> usize {
        self.doc.line(self.at)
    }

    /// An error of the table as a whole.
    pub fn fault(&self, what: impl Into<String>, help: impl Into<String>) -> InputError {
        self.doc.fault(self.at, what, help)
    }

    /// Name of the table in messages.
    pub fn shown(&self) -> String {
        if self.name.is_empty() { "the file".to_owned() } else { format!("[{}]", self.name) }
    }

    /// Line of `key`, if present.
    pub fn line_of(&self, key: &str) -> Option<usize> {
        self.get(key).map(|value| self.doc.line(value.span().start))
    }

    fn get(&self, key: &str) -> Option<&'t Spanned<DeValue<'t>>> {
        let former = || self.renamed.iter().find(|(name, _)| *name == key);
        self.table.get(key).or_else(|| self.table.get(former()?.1))
    }

    /// Checks that the table has no keys other than `known` and their former names.
    ///
    /// # Errors
    /// At the first unknown key, with the nearest known one where one is near; at a former name beside the
    /// present one.
    pub fn check_keys(&self, known: &[&str]) -> Result<(), InputError> {
        for (name, former) in self.renamed {
            if let (Some(_), Some(value)) = (self.table.get(*name), self.table.get(*former)) {
                return Err(self
                    .doc
                    .fault(
                        value.span().start,
                        format!("`{former}` is the former name of `{name}`, which is given too"),
                        format!("remove `{former}`"),
                    )
                    .with_code(ErrorCode::ConflictingKeys));
            }
        }
        let is_former = |key: &str| self.renamed.iter().any(|(_, former)| *former == key);
        let is_known = |key: &str| known.contains(&key) || is_former(key);
        let mut unknown: Vec<_> = self.table.keys().filter(|key| !is_known(key.get_ref())).collect();
        unknown.sort_by_key(|key| key.span().start);
        let Some(key) = unknown.first() else { return Ok(()) };
        let name: &str = key.get_ref();
        Err(self
            .doc
            .fault(
                key.span().start,
                format!("unknown key {} in {}", quote_for_message(name), self.shown()),
                known_or_none("key", name, known),
            )
            .with_code(ErrorCode::UnknownKey))
    }

    /// A number within `range`, if the key is present.
    ///
    /// # Errors
    /// When the value is not a number or is outside `range`.
    pub fn number(&self, key: &str, range: NumberRange) -> Result<Option<Located<f64>>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        // A number that is not read as it is too large is out of the range, too: that says what fits.
        let x = self.number_of(key, value, |x| range.check(x).err())?;
        let at = value.span().start;
        range.check(x).map_err(|help| {
            self.doc.fault(at, format!("`{key}` is {x}"), help).with_code(ErrorCode::ValueRange)
        })?;
        Ok(Some(Located { value: x, at }))
    }

    /// A number within `range`, or `default` when the key is absent.
    ///
    /// # Errors
    /// As [`Self::number`].
    pub fn number_or(&self, key: &str, range: NumberRange, default: f64) -> Result<f64, InputError> {
        Ok(self.number(key, range)?.map_or(default, |x| x.value))
    }

    /// Reads a number; `help` says what to give instead of one that is too large.
    fn number_of(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        help: impl Fn(f64) -> Option<String>,
    ) -> Result<f64, InputError> {
        let at = value.span().start;
        let token = match value.get_ref() {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            other => {
                let what = format!("`{key}` holds {}, not a number", type_name(other));
                return Err(self.doc.value_type_fault(at, what, "give a decimal number"));
            }
        };
        source::number(token).map_err(|fault| {
            let help = fault.value.and_then(help).unwrap_or_else(|| fault.help.to_owned());
            self.doc
                .fault(at, format!("`{key}`: {}", fault.message), help)
                .with_code(ErrorCode::InvalidNumber)
        })
    }

    /// A whole number from `low` to `high`, if the key is present.
    ///
    /// # Errors
    /// When the value is not such a number.
    pub fn whole(&self, key: &str, low: u32, high: u32) -> Result<Option<Located<u32>>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let at = value.span().start;
        let whole = match value.get_ref() {
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse::<u32>().ok(),
            _ => None,
        };
        match whole {
            Some(n) if (low..=high).contains(&n) => Ok(Some(Located { value: n, at })),
            _ => Err(self
                .doc
                .fault(
                    at,
                    format!("`{key}` is not a whole number from {low} to {high}"),
                    format!("give a whole number from {low} to {high}"),
                )
                .with_code(ErrorCode::ValueRange)),
        }
    }

    /// A string, if the key is present.
    ///
    /// # Errors
    /// When the value is not a string.
    pub fn string(&self, key: &str) -> Result<Option<Located<&'t str>>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let at = value.span().start;
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(Located { value: text.as_ref(), at })),
            other => {
                let what = format!("`{key}` holds {}, not a text", type_name(other));
                Err(self.doc.value_type_fault(at, what, "put it in quotes"))
            }
        }
    }

    /// A boolean, if the key is present.
    ///
    /// # Errors
    /// When the value is not a boolean.
    pub fn boolean(&self, key: &str) -> Result<Option<Located<bool>>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let at = value.span().start;
        match value.get_ref() {
            DeValue::Boolean(value) => Ok(Some(Located { value: *value, at })),
            other => {
                let what = format!("`{key}` holds {}, not true or false", type_name(other));
                Err(self.doc.value_type_fault(at, what, "write true or false, without quotes"))
            }
        }
    }

    fn child(&self, key: &str, value: &'t Spanned<DeValue<'t>>) -> Result<Self, InputError> {
        let name = if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) };
        match value.get_ref() {
            DeValue::Table(table) => {
                Ok(TomlTable { doc: self.doc, name, table, at: value.span().start, renamed: &[] })
            }
            _ => Err(self.doc.value_type_fault(
                value.span().start,
                format!("`{key}` is not a table"),
                format!("write it under a header [{name}]"),
            )),
        }
    }

    /// The table `[key]`, if present.
    ///
    /// # Errors
    /// When the value is not a table.
    pub fn table(&self, key: &str) -> Result<Option<Self>, InputError> {
        self.get(key).map(|value| self.child(key, value)).transpose()
    }

    /// The tables `[[key]]`, in file order; none when the key is absent.
    ///
    /// # Errors
    /// When the value is not a list of tables.
    pub fn tables(&self, key: &str) -> Result<Vec<Self>, InputError> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        match value.get_ref() {
            DeValue::Array(list) => list.iter().map(|item| self.child(key, item)).collect(),
            _ => Err(self.doc.value_type_fault(
                value.span().start,
                format!("`{key}` is not a list of tables"),
                format!("write each under a header [[{key}]] with two brackets"),
            )),
        }
    }

    /// A list of numbers, if the key is present.
    ///
    /// # Errors
    /// When the value is not a list of finite numbers.
    pub fn numbers(&self, key: &str) -> Result<Option<Located<Vec<f64>>>, InputError> {
        let Some((list, at)) = self.list(key)? else { return Ok(None) };
        let numbers =
            list.iter().map(|item| self.number_of(key, item, |_| None)).collect::<Result<_, _>>()?;
        Ok(Some(Located { value: numbers, at }))
    }

    /// A list of rows of `N` numbers, if the key is present; each row with its byte offset.
    ///
    /// # Errors
    /// When the value is not a list of such rows.
    pub fn rows<const N: usize>(&self, key: &str) -> Result<Option<Located<NumberRows<N>>>, InputError> {
        let Some((list, at)) = self.list(key)? else { return Ok(None) };
        let mut rows = Vec::with_capacity(list.len());
        for item in list {
            let place = item.span().start;
            let row = match item.get_ref() {
                DeValue::Array(row) if row.len() == N => row,
                _ => {
                    let what = format!("`{key}` has a row that is not {N} numbers");
                    return Err(self.doc.value_type_fault(
                        place,
                        what,
                        format!("give {N} numbers in brackets"),
                    ));
                }
            };
            let mut numbers = [0.0; N];
            for (number, value) in numbers.iter_mut().zip(row.iter()) {
                *number = self.number_of(key, value, |_| None)?;
            }
            rows.push(Located { value: numbers, at: place });
        }
        Ok(Some(Located { value: rows, at }))
    }

    /// A list of strings, if the key is present; each with its byte offset.
    ///
    /// # Errors
    /// When the value is not a list of strings.
    pub fn strings(&self, key: &str) -> Result<Option<Vec<Located<&'t str>>>, InputError> {
        let Some((list, _)) = self.list(key)? else { return Ok(None) };
        let mut texts = Vec::with_capacity(list.len());
        for item in list {
            let at = item.span().start;
            let DeValue::String(text) = item.get_ref() else {
                let what = format!("`{key}` holds {}, not a text", type_name(item.get_ref()));
                return Err(self.doc.value_type_fault(at, what, "put it in quotes"));
            };
            texts.push(Located { value: text.as_ref(), at });
        }
        Ok(Some(texts))
    }

    /// A list of values of any kind, if the key is present; each with its byte offset. A single value counts
    /// as a list of one.
    ///
    /// # Errors
    /// When an item is a list, a table or a date, or a number is not finite.
    pub fn scalars(&self, key: &str) -> Result<Option<Vec<Located<Scalar>>>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::Array(list) => {
                self.list(key)?;
                list.iter().map(|item| self.scalar_of(key, item)).collect::<Result<_, _>>().map(Some)
            }
            _ => Ok(Some(vec![self.scalar_of(key, value)?])),
        }
    }

    fn scalar_of(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Result<Located<Scalar>, InputError> {
        let at = value.span().start;
        let scalar = match value.get_ref() {
            DeValue::Boolean(flag) => Scalar::Flag(*flag),
            DeValue::String(text) => Scalar::Text(text.as_ref().to_owned()),
            DeValue::Integer(integer) if integer.radix() == 10 => {
                let number = self.number_of(key, value, |_| None)?;
                Scalar::Whole(integer.as_str().parse().unwrap_or(number as i64))
            }
            DeValue::Float(_) => Scalar::Number(self.number_of(key, value, |_| None)?),
            other => {
                let what = format!("`{key}` holds {}", type_name(other));
                return Err(self.doc.value_type_fault(at, what, "give numbers, texts, true or false"));
            }
        };
        Ok(Located { value: scalar, at })
    }

    /// All keys of the table and of the tables in it that hold something else than a table, as dotted paths,
    /// in file order.
    ///
    /// # Errors
    /// As [`Self::scalars`].
    pub fn dotted_scalars(&self) -> Result<Vec<DottedScalars>, InputError> {
        let mut keys: Vec<_> = self.table.iter().collect();
        keys.sort_by_key(|(key, _)| key.span().start);
        let mut found = Vec::new();
        for (key, value) in keys {
            let key: &str = key.get_ref();
            if let DeValue::Table(_) = value.get_ref() {
                let inner = self.child(key, value)?.dotted_scalars()?;
                found.extend(inner.into_iter().map(|(rest, values)| (format!("{key}.{rest}"), values)));
            } else if let Some(values) = self.scalars(key)? {
                found.push((key.to_owned(), values));
            }
        }
        Ok(found)
    }

    fn list(&self, key: &str) -> Result<Option<(&'t toml::de::DeArray<'t>, usize)>, InputError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let at = value.span().start;
        match value.get_ref() {
            DeValue::Array(list) if list.len() > source::MAX_POINTS => Err(self
                .doc
                .fault(at, format!("`{key}` holds more than 1,000,000 points"), "give fewer points")
                .with_code(ErrorCode::FileTooLarge)),
            DeValue::Array(list) => Ok(Some((list, at))),
            other => {
                let what = format!("`{key}` holds {}, not a list", type_name(other));
                Err(self.doc.value_type_fault(at, what, "put it in brackets"))
            }
        }
    }

    /// `error` at a byte offset of this document.
    pub fn locate(&self, at: usize, error: UserError) -> InputError {
        self.doc.fault(at, error.message, error.help).with_code(error.code)
    }

    /// An error at a byte offset of this document.
    pub fn fault_at(&self, at: usize, what: impl Into<String>, help: impl Into<String>) -> InputError {
        self.doc.fault(at, what, help)
    }
}

/// TOML's name for the type of a value, with its article.
fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "an integer",
        DeValue::Float(_) => "a float",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a datetime",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_nesting() {
        let text = "a = 1\n\n[b]\nc = [[1, 2],\n [3, nan]]\n[[d.e]]\nf = 1";
        let doc = TomlDocument::new("f", text.as_bytes(), ErrorCode::SetupFile).unwrap();
        let tree = doc.parse().unwrap();
        let root = doc.root(&tree);
        let b = root.table("b").unwrap().unwrap();
        assert_eq!(b.line(), 3);
        assert_eq!(b.rows::<2>("c").err().unwrap().line, 5);
        assert_eq!(root.table("d").unwrap().unwrap().tables("e").unwrap()[0].line(), 6);
        assert_eq!(root.check_keys(&["a", "b"]).unwrap_err().line, 6);
        let deep = "[".repeat(200_000);
        assert!(
            TomlDocument::new("f", format!("a = {deep}").as_bytes(), ErrorCode::SetupFile)
                .unwrap()
                .parse()
                .is_err()
        );
    }
}
