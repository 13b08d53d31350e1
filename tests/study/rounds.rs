//! Studies as they are run: shards, resumption, merge, schedulers.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A study in a folder of its own.
struct Study {
    folder: tempfile::TempDir,
}

/// Variables of schedulers, none of which may reach the program from outside.
const VARIABLES: [&str; 9] = [
    "SLURM_ARRAY_TASK_ID",
    "SLURM_ARRAY_TASK_COUNT",
    "SLURM_ARRAY_TASK_MIN",
    "SLURM_ARRAY_TASK_MAX",
    "SLURM_CPUS_PER_TASK",
    "JOB_COMPLETION_INDEX",
    "JOB_COMPLETIONS",
    "PBS_ARRAY_INDEX",
    "PBS_ARRAYID",
];

impl Study {
    /// Seven runs of a small wheel with few plunges: one has inserts wider than the cutter's radius,
    /// conventional ones have faults.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let part = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
        let text = format!(
            "part = {:?}\n[setup.plunge]\nstep = 12\nstepover = 14\nrest = false\n\
             [[setup.tool]]\ndiameter = 16\noverhang = 80\n\
             [[axis]]\nkey = \"policy\"\nvalues = [\"conventional\", \"staircase\"]\n\
             [[axis]]\nkey = \"tool.1.insert_width\"\nvalues = [4, 6]\n\
             [[axis]]\nkey = \"tool.1.diameter\"\nvalues = [10, 16]\n\
             [[exclude]]\ntool.1.insert_width = 6\ntool.1.diameter = 10\npolicy = \"staircase\"\n",
            part.display().to_string()
        );
        fs::write(folder.path().join("study.toml"), text).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vanecut"));
        for name in VARIABLES {
            command.env_remove(name);
        }
        command.arg("study").args(arguments).envs(variables.iter().copied());
        command.current_dir(self.folder.path()).output().expect("the program starts")
    }

    /// Runs the study; all runs have results afterwards, and those that fail make exit code 1.
    fn plan(&self, out: &str, more: &[&str], variables: &[(&str, &str)]) -> String {
        let output = self.run(&[&["study.toml", "-o", out], more].concat(), variables);
        assert!(output.status.code() < Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn merged(&self, out: &str) -> String {
        let table = format!("{out}.csv");
        let output = self.run(&["merge", out, "-o", &table], &[]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read_to_string(self.path(&table)).unwrap()
    }

    fn results(&self, out: &str) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> =
            fs::read_dir(self.path(out).join("runs")).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }
}

#[test]
fn shards_merge_to_the_table_of_a_single_run() {
    let study = Study::new();
    let single = study.run(&["study.toml", "-o", "single", "--jobs", "1"], &[]);
    // The runs without a plan are counted at the end.
    let error = String::from_utf8_lossy(&single.stderr);
    assert_eq!(single.status.code(), Some(1), "{error}");
    assert!(error.contains(" of 7 runs have no plan; the first, "), "{error}");
    let whole = study.merged("single");
    assert_eq!(whole.lines().count(), 8, "{whole}");
    assert!(whole.contains(",done,") && whole.contains(",faults,") && whole.contains(",error,"), "{whole}");
    // Three shards in another order, by hand and by two schedulers, with other numbers of threads.
    study.plan("shards", &["--shard", "3/3", "--jobs", "2"], &[]);
    let slurm = [
        ("SLURM_ARRAY_TASK_ID", "0"),
        ("SLURM_ARRAY_TASK_COUNT", "3"),
        ("SLURM_ARRAY_TASK_MIN", "0"),
        ("SLURM_ARRAY_TASK_MAX", "2"),
        ("SLURM_CPUS_PER_TASK", "3"),
    ];
    study.plan("shards", &["--shard", "auto"], &slurm);
    let missing = study.run(&["merge", "shards", "-o", "part.csv"], &[]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("2 of 7 runs have no result, "));
    study.plan("shards", &["--shard", "auto"], &[("JOB_COMPLETION_INDEX", "1"), ("JOB_COMPLETIONS", "3")]);
    assert_eq!(study.merged("shards"), whole);

    // What is there is kept; what a kill cut off, or another program wrote, is redone.
    let files = study.results("shards");
    fs::remove_file(&files[0]).unwrap();
    let text = fs::read_to_string(&files[1]).unwrap();
    fs::write(&files[1], &text[..text.len() / 2]).unwrap();
    fs::write(&files[2], "").unwrap();
    let text = fs::read_to_string(&files[3]).unwrap();
    fs::write(&files[3], text.replacen("\"program\": \"", "\"program\": \"0.", 1)).unwrap();
    let again = study.plan("shards", &[], &[]);
    assert!(again.starts_with("7 of 7 runs have results in shards: 3 kept, 4 computed"), "{again}");
    assert_eq!(study.merged("shards"), whole);
    let again = study.plan("shards", &[], &[]);
    assert!(again.contains("7 kept, 0 computed"), "{again}");

    // The Pareto set of the table.
    let output = study.run(&["pareto", "single.csv", "--json"], &[]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let set: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let done = whole.lines().filter(|line| line.contains(",done,")).count();
    assert_eq!(set["compared"], done);
    let rows = set["rows"].as_array().unwrap();
    assert!(
        !rows.is_empty() && rows.iter().all(|row| row["faults"] == 0.0 && row["time_estimate"].is_number())
    );
}

#[test]
fn shards_list_all_runs_once() {
    let study = Study::new();
    let ids = |arguments: &[&str], variables: &[(&str, &str)]| -> Vec<String> {
        let output = study.run(&[&["study.toml", "--list"], arguments].concat(), variables);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().skip(1).map(|line| line.split(' ').next().unwrap().to_owned()).collect()
    };
    let mut all = ids(&[], &[]);
    all.sort();
    assert_eq!(all.len(), 7);
    let mut dealt: Vec<String> = (1..=4)
        .flat_map(|index: usize| {
            ids(&["--shard", "auto/4"], &[("PBS_ARRAY_INDEX", index.to_string().as_str())])
        })
        .collect();
    dealt.sort();
    assert_eq!(dealt, all);
    assert!(!study.path("runs").exists(), "a list writes nothing");
}

#[test]
fn bad_arguments_are_refused_in_one_line() {
    let study = Study::new();
    for (arguments, words) in [
        (&[][..], "no study is given"),
        (&["none.toml", "--list"], "none.toml: cannot be read"),
        (&["study.toml"], "add -o DIR"),
        (&["study.toml", "-o", "study.toml"], "is not a directory"),
        (&["study.toml", "-o", "out", "--shard", "4/3"], "not a shard"),
        (&["study.toml", "-o", "out", "--shard", "auto"], "no scheduler says which shard"),
        (&["study.toml", "-o", "out", "--jobs", "0"], "give 1 to"),
        (&["merge", ".", "-o", "r.csv"], "not the folder of a study"),
        (&["merge", "none", "-o", "r.csv"], "not the folder of a study"),
        (&["merge", ".", "-o", "r.xlsx"], "name a .csv or .parquet file"),
        #[cfg(not(feature = "parquet"))]
        (&["merge", ".", "-o", "r.parquet"], "name a .csv file, or build with `--features parquet`"),
        (&["pareto", "none.csv"], "cannot be read"),
        (&["pareto", "study.toml"], "study merge"),
    ] {
        let output = study.run(arguments, &[]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(words) && error.contains("; ") && error.lines().count() == 1, "{error}");
        assert!(!study.path("out").exists() && !study.path("r.csv").exists(), "{arguments:?} left files");
    }
}

/// Files that a base setup names stand beside it, runs have the time of the machine, and go by what its file
/// says.
#[test]
fn runs_on_a_machine() {
    let study = Study::new();
    let base = "[plunge]\nstep = 12\nstepover = 14\nrest = false\n[[plunge.section]]\ntool = 52\nfrom = 1\nto = 0.9\n\
        [[tool]]\nnumber = 52\ndiameter = 12\ncorner_radius = 0.8\ninsert_width = 4\noverhang = 60\n\
        [machine]\nfile = \"own.toml\"\n";
    let part = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    let text = format!(
        "part = {:?}\nbase = \"setups/base.toml\"\n[[axis]]\nkey = \"plunge.step\"\nvalues = [10, 14]\n\
         [[axis]]\nkey = \"policy\"\nvalues = [\"monotone\"]\n",
        part.display().to_string()
    );
    let machine = include_str!("../../assets/machines/ac-trunnion.toml");
    fs::create_dir(study.path("setups")).unwrap();
    fs::write(study.path("setups/base.toml"), base).unwrap();
    fs::write(study.path("setups/own.toml"), machine).unwrap();
    fs::write(study.path("study.toml"), text).unwrap();
    let ids = || {
        let output = study.run(&["study.toml", "--list"], &[]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let first = ids();
    study.plan("out", &[], &[]);
    let table = study.merged("out");
    let columns: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let (estimate, time) = (column("time_estimate"), column("machine_time"));
    for row in table.lines().skip(1) {
        let row: Vec<&str> = row.split(',').collect();
        let of = |at: usize| row[at].parse::<f64>().unwrap_or(f64::NAN);
        // Accelerations, turns and the tool change come to the estimate.
        assert!(of(time) > of(estimate), "{row:?}");
    }
    let output = study.run(&["pareto", "out.csv", "--json"], &[]);
    let set: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(set["over"], serde_json::json!(["machine_time", "residual_p95"]));
    // Another machine in the same file makes other runs; a file that is none is named.
    fs::write(study.path("setups/own.toml"), machine.replace("rapid = 18000", "rapid = 9000")).unwrap();
    assert_ne!(ids(), first);
    fs::write(study.path("setups/own.toml"), machine.replace("side = \"table\"", "side = \"tabel\""))
        .unwrap();
    let output = study.run(&["study.toml", "--list"], &[]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("own.toml:15: unknown side `tabel`"), "{error}");
    // Beside a tilt it is read for times alone, and each run says what is wrong.
    fs::write(study.path("setups/base.toml"), format!("{base}max_axis_tilt = 100\n")).unwrap();
    let output = study.run(&["study.toml", "-o", "faulty"], &[]);
    let text =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let table = study.merged("faulty");
    assert!(
        table.contains("own.toml:15: unknown side `tabel`") || text.contains("own.toml:15"),
        "{text}{table}"
    );
}
