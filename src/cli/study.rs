//! `vanecut study`, `study merge` and `study pareto`.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::Failure;
use super::args::{MergeArgs, ParetoArgs, StudyAction, StudyArgs};
use super::output::number;
use super::output_folder::check_directory;
use super::stdout::print_stdout;
use super::watch::run_with_progress;
use crate::error::ErrorCode;
use crate::io::write_atomically;
use crate::study::merge::{Merged, merge};
use crate::study::pareto::{ParetoSet, Table};
#[cfg(feature = "parquet")]
use crate::study::parquet::write_parquet;
use crate::study::{Execution, RunList, RunResult, RunStatus, Shard, StudyFile, Tally, execute};

/// Largest number of runs at a time.
const MAX_JOBS: usize = 1024;
/// Variables that say how many threads this process may use, before the number of cores.
const THREAD_VARIABLES: [&str; 2] = ["RAYON_NUM_THREADS", "SLURM_CPUS_PER_TASK"];

/// Does what the arguments say.
///
/// # Errors
/// [`Failure::input`] when arguments or files are invalid; [`Failure::work`] when runs fail, were stopped, or
/// have no results yet.
pub fn run(args: &StudyArgs) -> Result<(), Failure> {
    match (&args.action, &args.study) {
        (Some(StudyAction::Merge(args)), _) => run_merge(args),
        (Some(StudyAction::Pareto(args)), _) => run_pareto(args),
        (None, Some(study)) => run_study(study, args),
        (None, None) => {
            let help = "see `vanecut study --help`";
            Err(Failure::input(ErrorCode::Arguments, "no study is given", help))
        }
    }
}

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

fn run_study(path: &Path, args: &StudyArgs) -> Result<(), Failure> {
    let shard = match &args.shard {
        None => Shard::ALL,
        Some(text) => Shard::parse(text, &variable)
            .map_err(|e| Failure::input(e.code, format!("--shard {}", e.message), e.help))?,
    };
    let threads = threads();
    let jobs = args.jobs.unwrap_or(threads.min(MAX_JOBS));
    if !(1..=MAX_JOBS).contains(&jobs) {
        let help = format!("give 1 to {MAX_JOBS}");
        let failure = Failure::input(ErrorCode::Arguments, "not a number of runs", help);
        return Err(failure.at(format!("--jobs {jobs}")));
    }
    if let Some(folder) = &args.output {
        check_directory(folder)?;
    }
    let list = RunList::from_file(StudyFile::read(path)?)?;
    if args.list {
        return print_stdout(&list_text(&list, shard, args.output.as_deref()));
    }
    let Some(folder) = &args.output else {
        let what = "no folder for the results is given";
        return Err(Failure::input(ErrorCode::Arguments, what, "add -o DIR, or --list"));
    };
    let how = Execution { folder, shard, jobs, threads: (threads / jobs).max(1) };
    let tally = run_with_progress("planning", |monitor| execute(&list, &how, monitor))?;
    print_stdout(&tally_text(&tally, folder))?;
    check_tally(&tally)
}

/// Threads that this process may use.
fn threads() -> usize {
    let given = THREAD_VARIABLES.iter().find_map(|name| variable(name)?.trim().parse().ok());
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    given.filter(|threads| (1..=MAX_JOBS).contains(threads)).unwrap_or_else(cores)
}

/// The runs of a shard, one a line: name, part, values; with a folder, also the state of the result.
fn list_text(list: &RunList, shard: Shard, folder: Option<&Path>) -> String {
    let keys = list.keys();
    let state = folder.map(|_| "state").into_iter();
    let head = ["id", "part"].into_iter().chain(keys).chain(state).map(str::to_owned).collect();
    let ours = list.runs.iter().enumerate().filter(|(place, _)| shard.contains(*place));
    let rows = ours.map(|(_, run)| {
        let input = list.input(&run.choice);
        let mut row = vec![run.id.clone(), input.part.shown.clone()];
        row.extend(list.values(&run.choice).into_iter().map(ToString::to_string));
        row.extend(folder.map(|folder| {
            let result = RunResult::existing(folder, run, &input);
            result.map_or("missing", |result| result.status.name()).to_owned()
        }));
        row
    });
    columns([head].into_iter().chain(rows).collect())
}

/// Rows of texts as columns, two spaces apart.
fn columns(rows: Vec<Vec<String>>) -> String {
    let mut widths: Vec<usize> = Vec::new();
    for row in &rows {
        widths.resize(widths.len().max(row.len()), 0);
        for (width, field) in widths.iter_mut().zip(row) {
            *width = (*width).max(field.chars().count());
        }
    }
    let mut text = String::new();
    for row in rows {
        let line: Vec<String> =
            row.iter().zip(&widths).map(|(field, &width)| format!("{field:<width$}")).collect();
        text += line.join("  ").trim_end();
        text.push('\n');
    }
    text
}

fn tally_text(tally: &Tally, folder: &Path) -> String {
    let present = tally.kept + tally.computed;
    format!(
        "{present} of {} runs have results in {}: {} kept, {} computed; {} with faults, {} without a plan\n",
        tally.runs,
        folder.display(),
        tally.kept,
        tally.computed,
        tally.faulty,
        tally.failed,
    )
}

/// Fails when the study was stopped, or runs have no plan.
fn check_tally(tally: &Tally) -> Result<(), Failure> {
    if tally.stopped {
        let left = tally.runs - tally.kept - tally.computed;
        let what = format!("stopped: {left} of {} runs have no result", tally.runs);
        return Err(Failure::work(ErrorCode::PlanIncomplete, what, "the same command goes on"));
    }
    match &tally.first_failed {
        None => Ok(()),
        Some((id, error)) => {
            let what = format!("{} of {} runs have no plan", tally.failed, tally.runs);
            Err(Failure::work(ErrorCode::PlanIncomplete, what, format!("the first, {id}: {error}")))
        }
    }
}

fn run_merge(args: &MergeArgs) -> Result<(), Failure> {
    let name = args.output.display().to_string();
    let extension = args.output.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let bytes_of = table_writer(&extension).map_err(|failure| failure.at(&name))?;
    let merged = merge(&args.folder)?;
    write_atomically(&args.output, &bytes_of(&name, &merged)?)?;
    print_stdout(&format!("wrote {name}: {} runs\n", merged.rows))?;
    match merged.missing.first() {
        None => Ok(()),
        Some(first) => {
            let (missing, all) = (merged.missing.len(), merged.missing.len() + merged.rows);
            let what = format!("{missing} of {all} runs have no result, {first} is the first");
            let help = "run the study again to do what is left";
            Err(Failure::work(ErrorCode::PlanIncomplete, what, help))
        }
    }
}

/// The bytes of a merged table in a format; with the name of the file for messages.
type TableWriter = fn(&str, &Merged) -> Result<Vec<u8>, Failure>;

/// What writes tables with the ending `extension`.
fn table_writer(extension: &str) -> Result<TableWriter, Failure> {
    match extension {
        "csv" => Ok(|_, merged| Ok(merged.text.clone().into_bytes())),
        #[cfg(feature = "parquet")]
        "parquet" => Ok(|name, merged| {
            let table = Table::read_bytes(name, merged.text.as_bytes())?;
            write_parquet(&table).map_err(|error| Failure::from(error).at(name))
        }),
        #[cfg(not(feature = "parquet"))]
        "parquet" => {
            let what = "this program is built without Parquet";
            let help = "name a .csv file, or build with `--features parquet`";
            Err(Failure::input(ErrorCode::FileFormat, what, help))
        }
        _ => {
            let what = format!("`.{extension}` is not a format of tables");
            Err(Failure::input(ErrorCode::FileFormat, what, "name a .csv or .parquet file"))
        }
    }
}

fn run_pareto(args: &ParetoArgs) -> Result<(), Failure> {
    let table = Table::read(&args.table)?;
    let over: Vec<&str> = match &args.over {
        Some(named) => named.iter().map(|figure| figure.trim()).collect(),
        None => table.default_figures().to_vec(),
    };
    let set = table.pareto(&over).map_err(|error| Failure::from(error).at("--over"))?;
    let text = if args.json { pareto_json(&table, &set, &over) } else { pareto_text(&table, &set, &over) };
    print_stdout(&text)
}

/// Columns that tell the runs apart: those before the figures, without the state, which is `done`.
fn naming_columns(table: &Table) -> Vec<usize> {
    let end = table.column("positions").unwrap_or(table.columns.len());
    (0..end).filter(|&place| table.columns[place] != "status").collect()
}

fn pareto_text(table: &Table, set: &ParetoSet, over: &[&str]) -> String {
    let figures = over.iter().filter_map(|figure| table.column(figure));
    let mut places = naming_columns(table);
    places.extend(figures);
    let pick = |row: &[String]| places.iter().map(|&place| row[place].clone()).collect();
    let rows = set.rows.iter().map(|&row| pick(&table.rows[row]));
    let mut text = columns([pick(&table.columns)].into_iter().chain(rows).collect());
    text += &format!(
        "{} of {} plans without faults are beaten by no other of their part; {} rows left out\n",
        set.rows.len(),
        set.compared,
        set.left_out
    );
    text
}

fn pareto_json(table: &Table, set: &ParetoSet, over: &[&str]) -> String {
    let object = |row: &Vec<String>| {
        let fields = table.columns.iter().zip(row).map(|(column, field)| {
            // Names of runs are texts, also where all their digits are decimal.
            let text = ["id", "part", "part_hash", "program", "tools", "error"].contains(&column.as_str());
            let value = match field.parse::<f64>() {
                _ if field.is_empty() => Value::Null,
                Ok(value) if !text && value.is_finite() => number(value),
                _ => json!(field),
            };
            (column.clone(), value)
        });
        Value::Object(fields.collect::<Map<_, _>>())
    };
    let rows: Vec<Value> = set.rows.iter().map(|&row| object(&table.rows[row])).collect();
    let status = RunStatus::Done.name();
    let whole = json!({
        "over": over, "compared": set.compared, "left_out": set.left_out, "status": status, "rows": rows,
    });
    format!("{whole}\n")
}
