//! Files of the library that use each other, straight or through others.
//!
//! A file uses another where it names an item that the other declares, through re-exports too. Methods do not
//! count: an `impl` block may stand in another file than its type.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use super::{code, identifier, sources_below};

/// Folders whose files may use each other, with the reason.
const TOGETHER: [(&str, &str); 1] =
    [("src/app/", "`App` holds what views and control keep between frames, and these draw and change it")];

/// Path of a module below the crate, such as `["plunge", "minimal", "path"]`.
type ModulePath = Vec<String>;

/// An item that `use` brings in.
struct Import {
    path: ModulePath,
    name: String,
    is_public: bool,
}

/// A source file.
struct SourceFile {
    name: String,
    /// Names of its items.
    items: BTreeSet<String>,
    imports: Vec<Import>,
    /// Its text without `use` declarations.
    body: String,
}

/// Code without string literals and without its unit tests.
fn bare(code: &str) -> String {
    let code = code.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut out = String::with_capacity(code.len());
    let (mut in_text, mut before) = (false, ' ');
    for c in code.chars() {
        let is_quote = c == '"' && before != '\\' && (in_text || before != '\'');
        if is_quote {
            in_text = !in_text;
        } else if !in_text {
            out.push(c);
        }
        // A backslash that is escaped itself escapes nothing.
        before = if before == '\\' { ' ' } else { c };
    }
    out
}

/// The paths that a tree of `use` names: `a::{b, c::d as e}` gives `a::b` as b, and `a::c::d` as e.
fn expand(prefix: &[String], tree: &str, is_public: bool, out: &mut Vec<Import>) {
    let (mut depth, mut begins) = (0, 0);
    let mut parts = Vec::new();
    for (i, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&tree[begins..i]);
                begins = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&tree[begins..]);
    for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        let words = |text: &str| -> Vec<String> {
            text.split("::").map(|word| word.trim().to_owned()).filter(|word| !word.is_empty()).collect()
        };
        if let Some((head, rest)) = part.split_once('{') {
            let prefix = [prefix, &words(head)].concat();
            expand(&prefix, rest.trim_end().trim_end_matches('}'), is_public, out);
            continue;
        }
        let (text, alias) = part.split_once(" as ").map_or((part, None), |(text, name)| (text, Some(name)));
        let mut path = [prefix, &words(text)].concat();
        path.pop_if(|last| last == "self");
        let Some(last) = path.last() else { continue };
        let name = alias.map_or_else(|| last.clone(), |name| name.trim().to_owned());
        out.push(Import { path, name, is_public });
    }
}

impl SourceFile {
    fn new(name: String, code: &str) -> Self {
        let mut file = Self { name, items: BTreeSet::new(), imports: Vec::new(), body: String::new() };
        let text = bare(code);
        let mut rest = text.as_str();
        while let Some(at) = rest.find("use ") {
            let begins_line = rest[..at].rsplit('\n').next().is_some_and(|line| {
                let line = line.trim();
                line.is_empty() || line == "pub" || line.starts_with("pub(") && line.ends_with(')')
            });
            let end = rest[at..].find(';').map(|end| at + end).filter(|_| begins_line);
            let Some(end) = end else {
                file.body.push_str(&rest[..at + 4]);
                rest = &rest[at + 4..];
                continue;
            };
            let start = rest[..at].rfind('\n').map_or(0, |line| line + 1);
            file.body.push_str(&rest[..start]);
            expand(&[], &rest[at + 4..end], rest[start..at].contains("pub"), &mut file.imports);
            rest = &rest[end + 1..];
        }
        file.body.push_str(rest);
        let kinds = ["fn", "struct", "enum", "trait", "const", "static", "type", "macro_rules!"];
        for line in file.body.lines().filter(|line| !line.starts_with(' ')) {
            let mut words = line.split_whitespace().skip_while(|word| word.starts_with("pub"));
            let mut word = words.next().unwrap_or_default();
            let mut next = words.next().unwrap_or_default();
            if word == "const" && next == "fn" {
                (word, next) = (next, words.next().unwrap_or_default());
            }
            if kinds.contains(&word) {
                file.items.extend(identifier(next));
            }
        }
        file
    }

    /// The paths of two names or more in its body that begin with a name of a module.
    fn paths_in_body(&self) -> BTreeSet<ModulePath> {
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let mut paths = BTreeSet::new();
        for word in self.body.split(|c: char| !is_part(c)).filter(|word| word.contains("::")) {
            let names: ModulePath = word.split("::").map(str::to_owned).collect();
            let first = names[0].chars().next();
            if first.is_some_and(|c| c.is_lowercase()) && names.iter().all(|name| !name.is_empty()) {
                paths.insert(names);
            }
        }
        paths
    }
}

/// All files by their modules.
struct Library(BTreeMap<ModulePath, SourceFile>);

impl Library {
    /// A path as it is written in module `from`, from the crate on; `None` for other crates.
    fn absolute(&self, from: &[String], path: &[String]) -> Option<ModulePath> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => return Some(rest.to_vec()),
            "self" => return Some([from, rest].concat()),
            "super" => {
                let ups = path.iter().take_while(|word| *word == "super").count();
                let above = from.get(..from.len().checked_sub(ups)?)?;
                return Some([above, &path[ups..]].concat());
            }
            _ => {}
        }
        let child = [from, path].concat();
        if self.0.contains_key(&child[..=from.len()]) {
            return Some(child);
        }
        let file = self.0.get(from)?;
        let is_of_crate = |import: &&Import| ["crate", "super", "self"].contains(&import.path[0].as_str());
        let import = file.imports.iter().filter(is_of_crate).find(|import| import.name == *first)?;
        Some([self.absolute(from, &import.path)?, rest.to_vec()].concat())
    }

    /// The module that declares the item at a path from the crate on, through re-exports.
    fn declared_in(&self, path: &[String], seen: &mut BTreeSet<ModulePath>) -> Option<ModulePath> {
        if !seen.insert(path.to_vec()) {
            return None;
        }
        let depth = (0..=path.len()).rev().find(|&depth| self.0.contains_key(&path[..depth]))?;
        let (module, rest) = path.split_at(depth);
        let (file, name) = (&self.0[module], rest.first()?);
        if file.items.contains(name) {
            return Some(module.to_vec());
        }
        file.imports.iter().filter(|import| import.name == *name || import.name == "*").find_map(|import| {
            let mut target = self.absolute(module, &import.path)?;
            if import.name == "*" {
                target.pop();
                target.push(name.clone());
            }
            self.declared_in(&[target, rest[1..].to_vec()].concat(), seen)
        })
    }

    /// The modules that one uses.
    fn used_by(&self, module: &ModulePath) -> BTreeSet<ModulePath> {
        let file = &self.0[module];
        let words: BTreeSet<&str> = file.body.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        let named = file.imports.iter().filter(|i| !i.is_public || words.contains(i.name.as_str()));
        let paths = named.map(|import| import.path.clone()).chain(file.paths_in_body());
        paths
            .filter_map(|path| self.declared_in(&self.absolute(module, &path)?, &mut BTreeSet::new()))
            .filter(|other| other != module)
            .collect()
    }

    /// Groups of modules each of which uses all others of its group, straight or through others.
    fn cycles(&self) -> Vec<BTreeSet<&str>> {
        let uses: BTreeMap<&ModulePath, BTreeSet<ModulePath>> =
            self.0.keys().map(|module| (module, self.used_by(module))).collect();
        let reached = |from: &ModulePath| {
            let mut found = BTreeSet::new();
            let mut open: Vec<&ModulePath> = uses[from].iter().collect();
            while let Some(module) = open.pop() {
                if found.insert(module) {
                    open.extend(&uses[module]);
                }
            }
            found
        };
        let reached: BTreeMap<&ModulePath, BTreeSet<&ModulePath>> =
            self.0.keys().map(|module| (module, reached(module))).collect();
        let mut groups: Vec<BTreeSet<&str>> = Vec::new();
        for (module, below) in &reached {
            let name = self.0[*module].name.as_str();
            if !below.contains(module) || groups.iter().any(|group| group.contains(name)) {
                continue;
            }
            let both_ways = below.iter().filter(|other| reached[**other].contains(module));
            groups.push(both_ways.map(|other| self.0[*other].name.as_str()).collect());
        }
        groups
    }
}

/// The files below a folder `src`, by their modules.
fn library(src: &Path) -> Library {
    let root = src.parent().expect("a folder above src");
    let files = sources_below(src).into_iter().filter_map(|path| {
        let mut module: ModulePath = path
            .strip_prefix(src)
            .ok()?
            .with_extension("")
            .iter()
            .map(|part| part.to_string_lossy().into())
            .collect();
        if module == ["main"] {
            return None;
        }
        module.pop_if(|last| last == "mod" || last == "lib");
        let name = path.strip_prefix(root).ok()?.display().to_string();
        Some((module, SourceFile::new(name, &code(&path))))
    });
    Library(files.collect())
}

#[test]
fn no_files_use_each_other() {
    let library = library(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(library.0.len() > 400, "files are found");
    let may_be = |group: &BTreeSet<&str>| {
        TOGETHER.iter().any(|(folder, _)| group.iter().all(|file| file.starts_with(folder)))
    };
    let cycles: Vec<String> = library
        .cycles()
        .into_iter()
        .filter(|group| !may_be(group))
        .map(|group| group.into_iter().collect::<Vec<_>>().join(", "))
        .collect();
    assert!(cycles.is_empty(), "move what both need to a third file:\n{}", cycles.join("\n"));
}

#[test]
fn files_that_use_each_other_are_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let src = folder.path().join("src");
    fs::create_dir_all(src.join("b")).expect("a folder");
    for (name, text) in [
        ("lib.rs", "pub mod a;\npub mod b;\npub mod c;\n"),
        // Through a re-export, and by a path in its body.
        (
            "a.rs",
            "use crate::b::{\n    self, Item as I};\npub const NUMBER: u32 = 1;\nfn f(i: I) { b::run() }\n",
        ),
        ("b/mod.rs", "mod inner;\npub use inner::{Item, run};\n"),
        ("b/inner.rs", "pub struct Item;\npub fn run() -> u32 {\n    crate::a::NUMBER\n}\n"),
        // A text and a re-export use nothing.
        ("c.rs", "pub use crate::a::NUMBER;\nconst TEXT: &str = \"crate::a::NUMBER\";\n"),
    ] {
        fs::write(src.join(name), text).expect("written");
    }
    let library = library(&src);
    assert_eq!(library.cycles(), [BTreeSet::from(["src/a.rs", "src/b/inner.rs"])]);
}
