//! Data-driven tests of the command line: every directory of `tests/cli` is a case.
//!
//! | file | contents |
//! |---|---|
//! | `args` | the arguments, one per line |
//! | `stdin` | standard input; `@PATH` alone: the bytes of that file |
//! | `code` | accepted exit codes; absent: 0 |
//! | `stderr` | exact standard error; absent: empty; `*`: not checked |
//! | `error` | the code of the error; every run that fails has one |
//! | `environment` | variables of the run, `NAME=VALUE` a line |
//! | `stdout` | exact standard output |
//! | `contains` | lines that standard output must contain |
//! | `json` | checks of the JSON object on standard output, see [`json_fault`] |
//! | `same` | pairs of files that must be equal byte for byte |
//!
//! A case with several runs numbers them: `args`, `args.2`, `stdout.2` and so on. In all files `{parts}` is
//! the directory of the sample parts, `{data}` that of third-party files, `{out}` an empty directory.
//! Runs start in the case's directory. A run that exits with 2 must not write any files.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde_json::Value;
use vanecut::error::ErrorCode;

/// A run that takes longer hangs, on however busy a machine: it is ended, and its case fails.
const HANG: Duration = Duration::from_secs(600);

/// Variable with which the program prints the code of an error.
const CODES_VARIABLE: &str = "VANECUT_ERROR_CODES";

/// A case: its directory and the values of the placeholders.
struct Case {
    folder: PathBuf,
    words: [(&'static str, String); 3],
}

impl Case {
    fn path(&self, name: &str, run: usize) -> PathBuf {
        self.folder.join(if run == 1 { name.to_owned() } else { format!("{name}.{run}") })
    }

    fn filled(&self, text: &str) -> String {
        self.words.iter().fold(text.to_owned(), |text, (word, value)| text.replace(word, value))
    }

    /// A file of the case with its placeholders replaced.
    fn text(&self, name: &str, run: usize) -> Option<String> {
        fs::read_to_string(self.path(name, run)).ok().map(|text| self.filled(&text))
    }

    fn stdin(&self, run: usize) -> Vec<u8> {
        let Ok(bytes) = fs::read(self.path("stdin", run)) else { return Vec::new() };
        match std::str::from_utf8(&bytes).ok().and_then(|text| text.trim().strip_prefix('@')) {
            Some(path) => fs::read(self.filled(path)).unwrap_or_default(),
            None => bytes,
        }
    }

    /// Runs the program, which prints the code of an error behind its line.
    fn run(&self, arguments: &str, run: usize) -> Output {
        let variables = self.text("environment", run).unwrap_or_default();
        // Files, unlike pipes, take any amount while nobody reads.
        let (printed, errors) = (file_of(b""), file_of(b""));
        let mut child = Command::new(env!("CARGO_BIN_EXE_vanecut"))
            .args(arguments.lines())
            .current_dir(&self.folder)
            .env_remove("RUST_BACKTRACE")
            .env(CODES_VARIABLE, "1")
            .envs(variables.lines().filter_map(|line| line.split_once('=')))
            .stdin(file_of(&self.stdin(run)))
            .stdout(printed.try_clone().expect("a handle"))
            .stderr(errors.try_clone().expect("a handle"))
            .spawn()
            .expect("the program starts");
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("the program runs") {
                break status;
            }
            if started.elapsed() > HANG {
                child.kill().expect("the program ends");
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        Output { status, stdout: contents(printed), stderr: contents(errors) }
    }

    /// All deviations from what the case expects.
    fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut objects = Vec::new();
        for run in 1.. {
            let Some(arguments) = self.text("args", run) else { break };
            let before = self.all_files();
            let output = self.run(&arguments, run);
            let out = String::from_utf8_lossy(&output.stdout);
            let (err, error) = without_code(&String::from_utf8_lossy(&output.stderr));
            let mut fault = |what: String| faults.push(format!("run {run}: {what}"));
            let codes = self.text("code", run).unwrap_or("0".to_owned());
            let code = output.status.code().map_or("a signal".to_owned(), |code| code.to_string());
            if !codes.split_whitespace().any(|wanted| wanted == code) {
                fault(format!("exit {code}, not {codes}"));
            }
            let wanted = self.text("stderr", run).unwrap_or_default();
            if wanted.trim() != "*" && err != wanted {
                fault(format!("stderr is\n{err}instead of\n{wanted}"));
            }
            if code == "2" {
                let one_line = err.lines().count() == 1 && err.starts_with("vanecut: ") && err.contains("; ");
                if !one_line || !out.is_empty() {
                    fault("bad input must print `fault; help` in one line, and no more".to_owned());
                }
                if self.all_files() != before {
                    fault(format!("left files behind: {:?}", self.all_files()));
                }
            }
            let wanted = self.text("error", run).unwrap_or_default();
            if error.map_or("", ErrorCode::name) != wanted.trim() {
                fault(format!("the error is {error:?}, not {wanted:?}:\n{err}"));
            }
            if let Some(wanted) = self.text("stdout", run).filter(|wanted| *wanted != out) {
                fault(format!("stdout is\n{out}instead of\n{wanted}"));
            }
            for line in self.text("contains", run).unwrap_or_default().lines() {
                if !out.contains(line) {
                    fault(format!("stdout lacks `{line}`:\n{out}"));
                }
            }
            objects.push(serde_json::from_str(&out).unwrap_or(Value::Null));
            for line in self.text("json", run).unwrap_or_default().lines() {
                if let Some(what) = json_fault(line, &objects) {
                    fault(format!("`{line}` does not hold: {what}"));
                }
            }
        }
        for pair in self.text("same", 1).unwrap_or_default().lines() {
            let files: Vec<Vec<u8>> =
                pair.split(' ').map(|path| fs::read(path).unwrap_or_default()).collect();
            if files[0].is_empty() || files.iter().any(|bytes| *bytes != files[0]) {
                faults.push(format!("{pair} are not the same"));
            }
        }
        faults
    }

    /// Names of all files in the case's directory and in `{out}`.
    fn all_files(&self) -> BTreeSet<PathBuf> {
        let mut found = BTreeSet::new();
        let mut folders = vec![self.folder.clone(), PathBuf::from(self.filled("{out}"))];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let path = entry.path();
                if path.is_dir() {
                    folders.push(path.clone());
                }
                found.insert(path);
            }
        }
        found
    }
}

/// A temporary file with these bytes, at its beginning.
fn file_of(bytes: &[u8]) -> File {
    let mut file = tempfile::tempfile().expect("a temporary file");
    file.write_all(bytes).and_then(|()| file.rewind()).expect("it can be written");
    file
}

/// All bytes of a file.
fn contents(mut file: File) -> Vec<u8> {
    let mut bytes = Vec::new();
    file.rewind().and_then(|()| file.read_to_end(&mut bytes)).expect("it can be read");
    bytes
}

/// What the program prints to stderr, without the code behind its line, and the code.
fn without_code(text: &str) -> (String, Option<ErrorCode>) {
    let split = text.strip_suffix("]\n").and_then(|text| text.rsplit_once(" ["));
    match split.and_then(|(line, name)| Some((line, ErrorCode::named(name)?))) {
        Some((line, code)) => (format!("{line}\n"), Some(code)),
        None => (text.to_owned(), None),
    }
}

/// Why a check such as `before.interferential > 0` fails, or `None` if it holds.
///
/// A check is `PATH exists`, or `PATH OP VALUE` with OP one of `=` `>` `>=` `<` `<=` `~` (equal to 2e-6).
/// VALUE is JSON, or `$1.PATH`, a value of the first run's object.
fn json_fault(line: &str, objects: &[Value]) -> Option<String> {
    let mut words = line.splitn(3, ' ');
    let (path, operator, value) = (words.next()?, words.next()?, words.next().unwrap_or_default());
    let Some(found) = at(objects.last()?, path) else { return Some("there is no such value".to_owned()) };
    let wanted = match value.strip_prefix("$1.") {
        Some(path) => at(objects.first()?, path).cloned().unwrap_or(Value::Null),
        None => serde_json::from_str(value).unwrap_or(Value::Null),
    };
    let (a, b) = (found.as_f64().unwrap_or(f64::NAN), wanted.as_f64().unwrap_or(f64::NAN));
    let holds = match operator {
        "exists" => true,
        "=" => *found == wanted,
        ">" => a > b,
        ">=" => a >= b,
        "<" => a < b,
        "<=" => a <= b,
        "~" => (a - b).abs() <= 2e-6,
        other => return Some(format!("unknown operator {other}")),
    };
    (!holds).then(|| format!("{found} against {wanted}"))
}

/// Value at a dot-separated path of keys and indices.
fn at<'v>(object: &'v Value, path: &str) -> Option<&'v Value> {
    path.split('.').try_fold(object, |value, key| match key.parse::<usize>() {
        Ok(index) => value.get(index),
        Err(_) => value.get(key),
    })
}

#[test]
fn command_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders: Vec<PathBuf> =
        fs::read_dir(root.join("tests/cli")).expect("cases").map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    assert!(folders.len() > 40, "only {} cases found", folders.len());
    let faults_in = |folder: PathBuf| -> String {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let out = tempfile::tempdir().expect("a temporary folder");
        let words = [
            ("{parts}", root.join("assets/parts").display().to_string()),
            ("{data}", root.join("tests/data").display().to_string()),
            ("{out}", out.path().display().to_string()),
        ];
        Case { folder, words }.faults().iter().map(|fault| format!("{name}: {fault}\n")).collect()
    };
    let report: String = folders.into_par_iter().map(faults_in).collect();
    assert!(report.is_empty(), "\n{report}");
}

/// A reader that closes the pipe early causes neither a panic nor a message.
#[test]
fn a_reader_that_leaves_early() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_vanecut"))
        .arg("--help")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "", "a closed pipe is not an error");
    assert_eq!(output.status.code(), Some(0));
}

/// The code of an error is printed only when it is asked for.
#[test]
fn codes_are_shown_when_asked_for() {
    let errors = |shows: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vanecut"));
        command.arg("--nonsense").env(CODES_VARIABLE, shows);
        String::from_utf8(command.output().expect("the program starts").stderr).expect("UTF-8")
    };
    let plain = errors("");
    assert!(plain.starts_with("vanecut: ") && !plain.contains('['), "{plain}");
    assert_eq!(without_code(&errors("1")), (plain, Some(ErrorCode::Arguments)));
}

/// An error of the system, such as a full disk, is not reported as a fault of the input.
#[test]
#[cfg(target_os = "linux")]
fn output_that_cannot_be_written() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device of Linux");
    let mut command = Command::new(env!("CARGO_BIN_EXE_vanecut"));
    let output = command.arg("--help").env(CODES_VARIABLE, "1").stdout(full).output().expect("it starts");
    let (line, code) = without_code(&String::from_utf8_lossy(&output.stderr));
    assert_eq!((output.status.code(), code), (Some(1), Some(ErrorCode::System)), "{line}");
}

/// All `.rs` files below `folder`.
fn sources_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) = entries.partition(|path| path.is_dir());
    let below = folders.iter().flat_map(|folder| sources_in(folder));
    files.into_iter().filter(|file| file.extension().is_some_and(|e| e == "rs")).chain(below).collect()
}

/// Every code is what some test expects: a case here, or an assertion on `ErrorCode`.
#[test]
fn every_code_is_expected_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut expected = BTreeSet::new();
    for case in fs::read_dir(root.join("tests/cli")).expect("cases") {
        for file in fs::read_dir(case.unwrap().path()).expect("a case").map(|file| file.unwrap()) {
            if file.file_name().to_string_lossy().starts_with("error") {
                expected.insert(fs::read_to_string(file.path()).unwrap().trim().to_owned());
            }
        }
    }
    // Tests in `src` stand in files of their own, or behind the code.
    let is_tests =
        |path: &Path| path.to_string_lossy().ends_with("tests.rs") || path.iter().any(|f| f == "tests");
    let mut tests = String::new();
    for path in sources_in(&root.join("src")).into_iter().chain(sources_in(&root.join("tests"))) {
        let text = fs::read_to_string(&path).unwrap();
        let code_ends = if is_tests(&path) { 0 } else { text.find("#[cfg(test)]").unwrap_or(text.len()) };
        tests += &text[code_ends..];
    }
    // Errors that a test makes are not expected of the program.
    let tests = tests.replace("::new(ErrorCode::", "");
    let is_expected = |code: &ErrorCode| {
        let variant = format!("ErrorCode::{code:?}");
        let mut found = tests.match_indices(&variant).map(|(at, _)| &tests[at + variant.len()..]);
        expected.contains(code.name()) || found.any(|rest| !rest.starts_with(char::is_alphanumeric))
    };
    let missing: Vec<&str> =
        ErrorCode::all().filter(|code| !is_expected(code)).map(ErrorCode::name).collect();
    assert!(missing.is_empty(), "no test raises {}", missing.join(", "));
}
