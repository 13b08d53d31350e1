//! Reading a setup that has faults, for projects: nothing else of the project may be lost by them.

use super::read::read_setup_bytes;
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::setup::Setup;

/// Number of faults after which the rest of a setup is not looked at.
const MAX_FAULTS: usize = 100;

/// The entry of a setup that is faulty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetupEntry {
    /// Name of its table, such as `stock`, `tool` or `plunge.section`.
    pub table: String,
    /// Number of the table among those of this name that are left in the setup, from 0.
    pub index: usize,
    /// The key; `None` where the whole table was left out.
    pub key: Option<String>,
}

/// A fault of a setup, with the entry that has its default for that.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupEntryFault {
    /// What is wrong, and where in the file.
    pub error: InputError,
    /// The faulty entry; `None` where the fault is in none.
    pub entry: Option<SetupEntry>,
}

/// A setup without its faulty entries, and what was wrong with each.
#[derive(Clone, Debug, PartialEq)]
pub struct TolerantSetup {
    /// The setup; what was faulty has its default.
    pub setup: Setup,
    /// The faults, in the order in which they were found; empty for a valid setup.
    pub faults: Vec<SetupEntryFault>,
}

/// Reads a setup as [`read_setup_bytes`] does, but leaves a faulty entry out and reads on: a key, or a whole
/// table where the fault is that of the table (a tool without a diameter). Lines keep their numbers, so that
/// every fault has the line of the text as it is.
///
/// # Errors
/// When the setup is that of a newer version.
pub fn read_setup_tolerantly(name: &str, text: &str) -> Result<TolerantSetup, InputError> {
    let whole: Vec<&str> = text.lines().collect();
    let mut lines = whole.clone();
    let mut faults = Vec::new();
    // Headers of tables that lost a faulty key. A later "missing key" fault there is not reported again.
    let mut incomplete: Vec<usize> = Vec::new();
    for _ in 0..MAX_FAULTS {
        let fault = match read_setup_bytes(name, lines.join("\n").as_bytes()) {
            Ok(setup) => {
                let with_entry = |error: InputError| {
                    let entry = entry_of(&whole, &lines, error.line);
                    SetupEntryFault { error, entry }
                };
                return Ok(TolerantSetup { setup, faults: faults.into_iter().map(with_entry).collect() });
            }
            Err(fault) if fault.code == ErrorCode::NewerFile => return Err(fault),
            Err(fault) => fault,
        };
        let entry = faulty_entry(&lines, fault.line);
        if !entry.as_ref().is_some_and(|entry| incomplete.contains(&entry.start)) {
            faults.push(fault);
        }
        let Some(entry) = entry else { break };
        incomplete.extend(lines[..=entry.start].iter().rposition(|line| table_name(line).is_some()));
        lines[entry].fill("");
    }
    let faults = faults.into_iter().map(|error| SetupEntryFault { error, entry: None }).collect();
    Ok(TolerantSetup { setup: Setup::default(), faults })
}

/// The entry in line `line` (from 1) of the `whole` text; `left` are its lines without faulty entries.
fn entry_of(whole: &[&str], left: &[&str], line: usize) -> Option<SetupEntry> {
    let at = line.checked_sub(1).filter(|&at| at < whole.len())?;
    let header = whole[..=at].iter().rposition(|line| table_name(line).is_some())?;
    let table = table_name(whole[header])?.trim().to_owned();
    let index = left[..header].iter().filter(|line| table_name(line) == table_name(whole[header])).count();
    let key = whole[at].split_once('=').map(|(key, _)| key.trim().to_owned()).filter(|_| at > header);
    Some(SetupEntry { table, index, key })
}

/// The lines of the entry that has a fault in line `line` (from 1): of a table up to the next one that is not
/// part of it, of a key up to the next key. `None` when the fault is in no line, or nothing is in it.
fn faulty_entry(lines: &[&str], line: usize) -> Option<std::ops::Range<usize>> {
    let first =
        line.checked_sub(1).filter(|&first| lines.get(first).is_some_and(|l| !l.trim().is_empty()))?;
    let end = |is_next: &dyn Fn(&str) -> bool| {
        lines[first + 1..].iter().position(|line| is_next(line)).map_or(lines.len(), |n| first + 1 + n)
    };
    let last = match table_name(lines[first]) {
        Some(name) => {
            let is_within = |other: &str| other.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
            end(&|line| table_name(line).is_some_and(|other| !is_within(other)))
        }
        None => end(&|line| line.trim().is_empty() || line.contains('=') || table_name(line).is_some()),
    };
    Some(first..last)
}

/// The name in the header of a table; `None` for other lines. An array's lines begin with a bracket, too, but
/// not with a bracket and a name.
fn table_name(line: &str) -> Option<&str> {
    let name = line.trim_start().strip_prefix('[')?.trim_start_matches('[');
    let name = &name[..name.find(']')?];
    name.starts_with(|c: char| c.is_ascii_alphabetic()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETUP: &str = r#"[stock]
hub_allowance = 0.25
[[tool]]
number = 7
diameter = 30.0
insert_width = 20
holder = [
  [40, 50, 30],
]
[[tool]]
number = 9
diameter = 16.0
[[plunge.section]]
tool = 7
from = 1.0
to = 0.5
"#;

    fn faults_of(text: &str) -> (Setup, Vec<(usize, String)>) {
        let TolerantSetup { setup, faults } = read_setup_tolerantly("p (setup)", text).expect("reads");
        (setup, faults.into_iter().map(|fault| (fault.error.line, fault.error.message)).collect())
    }

    #[test]
    fn the_faulty_entry_is_named() {
        let text = SETUP.replace("diameter = 30.0\n", "").replace("diameter = 16.0", "diameter = -16");
        let text = format!("{text}[plunge]\nstep = 0\n").replace("insert_width = 20\n", "");
        let TolerantSetup { faults, .. } = read_setup_tolerantly("p (setup)", &text).expect("reads");
        let entries: Vec<_> = faults.into_iter().filter_map(|fault| fault.entry).collect();
        let entry = |table: &str, index, key: Option<&str>| SetupEntry {
            table: table.to_owned(),
            index,
            key: key.map(str::to_owned),
        };
        assert!(entries.contains(&entry("tool", 0, None)), "{entries:?}");
        // Without a diameter the tool goes, too; the key that is wrong is that of the first that was left.
        assert!(entries.contains(&entry("tool", 0, Some("diameter"))), "{entries:?}");
        assert!(entries.contains(&entry("plunge", 0, Some("step"))), "{entries:?}");
    }

    #[test]
    fn a_faulty_key_has_its_default_and_the_rest_stays() {
        let (setup, faults) = faults_of(SETUP);
        assert_eq!(setup.allowances.hub_allowance, 0.25);
        assert_eq!(setup.tools.iter().map(|tool| tool.diameter).collect::<Vec<_>>(), [30.0, 16.0]);
        assert!(setup.tools[0].insert_width <= 15.0, "{}", setup.tools[0].insert_width);
        assert_eq!(setup.plunge.sections.len(), 1);
        let [(line, message)] = faults.as_slice() else { panic!("{faults:?}") };
        assert!(*line == 6 && message.contains("insert_width"), "{line}: {message}");
    }

    #[test]
    fn a_faulty_table_goes_with_all_that_is_in_it() {
        let (setup, faults) = faults_of(&SETUP.replace("diameter = 30.0\n", ""));
        assert_eq!(setup.tools.iter().map(|tool| tool.number).collect::<Vec<_>>(), [9], "{faults:?}");
        assert!(setup.tools[0].assembly.holder.is_empty(), "the holder was that of the other tool");
        assert!(setup.plunge.sections.is_empty(), "its tool is gone");
        assert_eq!(faults.len(), 2, "{faults:?}");
    }

    #[test]
    fn what_is_no_setup_gives_the_defaults_with_a_fault() {
        for text in ["= = =\n[[[", "\u{0}", "[stock\n[stock\n", "a = [\n1,\n2"] {
            let (setup, faults) = faults_of(text);
            assert_eq!(setup, Setup::default(), "{text:?}");
            assert!(!faults.is_empty(), "{text:?}");
        }
        assert!(read_setup_tolerantly("p (setup)", "version = 99\n").is_err(), "it would be saved with less");
    }
}
