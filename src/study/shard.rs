//! Shards: which runs of a study one process does, by hand or from the index that a scheduler gives.

use crate::error::{ErrorCode, UserError};

/// Largest number of shards.
const MAX_SHARDS: usize = 1_000_000;

/// One of several equal shares of a study. Run k belongs to shard k mod `count`: neighbouring runs differ
/// least and take about as long, so that dealing them out balances the shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which share, from 0.
    pub index: usize,
    /// Number of shares.
    pub count: usize,
}

/// A variable of the environment, by its name.
pub type Lookup<'a> = &'a dyn Fn(&str) -> Option<String>;

/// A scheduler that numbers the jobs of an array.
struct Scheduler {
    name: &'static str,
    index: &'static str,
    /// Variables of the number of jobs; the first that is set counts. Slurm sets its own, the others are up
    /// to the user.
    counts: &'static [&'static str],
}

const SCHEDULERS: [Scheduler; 4] = [
    Scheduler { name: "Slurm", index: "SLURM_ARRAY_TASK_ID", counts: &["SLURM_ARRAY_TASK_COUNT"] },
    Scheduler {
        name: "Kubernetes",
        index: "JOB_COMPLETION_INDEX",
        counts: &["JOB_COMPLETIONS", "COMPLETIONS"],
    },
    Scheduler { name: "PBS", index: "PBS_ARRAY_INDEX", counts: &["PBS_ARRAY_COUNT"] },
    Scheduler { name: "Torque", index: "PBS_ARRAYID", counts: &["PBS_ARRAY_COUNT"] },
];

impl Shard {
    /// The whole study.
    pub const ALL: Self = Self { index: 0, count: 1 };

    /// Whether the run at `position` (from 0) of the study belongs to this shard.
    pub fn contains(self, position: usize) -> bool {
        position % self.count == self.index
    }

    /// Parses `I/N`, `auto` or `auto/N`; `environment` is asked for the variables of schedulers.
    ///
    /// # Errors
    /// When the text is none of these, or the environment does not say which shard it is.
    pub fn parse(text: &str, environment: Lookup<'_>) -> Result<Self, UserError> {
        let (index, count) = match text.split_once('/') {
            Some((index, count)) => (index, Some(count)),
            None => (text, None),
        };
        let wrong = || fault(format!("{text}: not a shard"), "give I/N with I from 1 to N, or auto");
        let count = match count {
            Some(count) => Some(number(count).filter(|n| (1..=MAX_SHARDS).contains(n)).ok_or_else(wrong)?),
            None => None,
        };
        if index == "auto" {
            return Self::from_environment(count, environment)
                .map_err(|error| fault(format!("{text}: {}", error.message), error.help));
        }
        let (index, count) = (number(index).ok_or_else(wrong)?, count.ok_or_else(wrong)?);
        if !(1..=count).contains(&index) {
            return Err(wrong());
        }
        Ok(Self { index: index - 1, count })
    }

    /// The shard of this job of an array; `count` replaces the number of jobs.
    fn from_environment(count: Option<usize>, environment: Lookup<'_>) -> Result<Self, UserError> {
        let set = |name: &str| environment(name).filter(|value| !value.trim().is_empty());
        let Some((scheduler, given)) =
            SCHEDULERS.iter().find_map(|scheduler| Some((scheduler, set(scheduler.index)?)))
        else {
            let names = SCHEDULERS.map(|scheduler| scheduler.index).join(", ");
            let what = format!("no scheduler says which shard this is ({names} are not set)");
            return Err(fault(what, "start it as an array job, or give --shard I/N"));
        };
        let whole = |name: &str, value: &str| {
            number(value.trim()).ok_or_else(|| {
                fault(format!("{name} is {value:?}, not a whole number"), "give --shard I/N instead of auto")
            })
        };
        let index = whole(scheduler.index, &given)?;
        let (name, value) = match (count, scheduler.counts.iter().find_map(|name| Some((*name, set(name)?))))
        {
            (Some(count), _) => ("N", count),
            (None, Some((name, value))) => (name, whole(name, &value)?),
            (None, None) => {
                let what = format!("{} gives the index {index} but no number of jobs", scheduler.name);
                let help = format!("set {} to it, or give --shard auto/N", scheduler.counts[0]);
                return Err(fault(what, help));
            }
        };
        if !(1..=MAX_SHARDS).contains(&value) {
            let what = format!("{name} is {value}, not a number of shards");
            return Err(fault(what, format!("give 1 to {MAX_SHARDS}")));
        }
        let index = match scheduler.name {
            "Slurm" if count.is_none() => slurm_place(index, value, &set, &whole)?,
            // A job of Kubernetes counts from 0 to N − 1.
            "Kubernetes" if index >= value => {
                let what = format!("JOB_COMPLETION_INDEX is {index}, but {name} is {value}");
                return Err(fault(what, format!("correct {name}")));
            }
            // An array begins where its user says. Any N consecutive numbers have all remainders, so that the
            // remainder needs no start, and a job that is submitted again under its number keeps its shard.
            _ => index,
        };
        Ok(Self { index: index % value, count: value })
    }
}

/// Number of a Slurm task whose remainder by `count` is its shard. An array may begin anywhere and have a
/// step, but no gaps: with gaps some shards would be done twice and others never.
fn slurm_place(
    index: usize,
    count: usize,
    set: &dyn Fn(&str) -> Option<String>,
    whole: &dyn Fn(&str, &str) -> Result<usize, UserError>,
) -> Result<usize, UserError> {
    let other = |name: &str| set(name).map(|value| whole(name, &value)).transpose();
    let least = other("SLURM_ARRAY_TASK_MIN")?;
    let most = other("SLURM_ARRAY_TASK_MAX")?;
    let step = other("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
    let from = least.unwrap_or(0);
    let place = index.checked_sub(from).filter(|beyond| beyond % step == 0).map(|beyond| beyond / step);
    let tasks = most.map(|most| most.saturating_sub(from) / step + 1);
    match place {
        // Without its start, an array is taken to begin at 0 or 1.
        Some(place)
            if (place < count || least.is_none() && place == count)
                && tasks.is_none_or(|tasks| tasks == count) =>
        {
            Ok(if step == 1 { index } else { place })
        }
        _ => {
            let what = format!("task {index} does not belong to a Slurm array of {count} without gaps");
            let last = count.saturating_sub(1);
            Err(fault(what, format!("start it with --array=0-{last}, or give --shard auto/N")))
        }
    }
}

/// An error of the argument or of the scheduler's variables.
fn fault(what: impl Into<String>, help: impl Into<String>) -> UserError {
    UserError::new(ErrorCode::Arguments, what, help)
}

fn number(text: &str) -> Option<usize> {
    // `parse` accepts a sign.
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, variables: &[(&str, &str)]) -> Result<(usize, usize), String> {
        let lookup = |name: &str| {
            variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
        };
        Shard::parse(text, &lookup).map(|shard| (shard.index, shard.count)).map_err(|error| error.to_string())
    }

    #[test]
    fn shards_by_hand() {
        assert_eq!(parse("1/1", &[]), Ok((0, 1)));
        assert_eq!(parse("3/20", &[]), Ok((2, 20)));
        for bad in
            ["0/3", "4/3", "3", "", "/", "1/", "/3", "1/0", "-1/3", "+1/3", "1/3/5", "a/b", "1/9999999"]
        {
            let error = parse(bad, &[]).expect_err(bad);
            assert!(error.contains("; give I/N"), "{bad}: {error}");
        }
        assert!((0..10).all(|k| (0..3).filter(|&index| Shard { index, count: 3 }.contains(k)).count() == 1));
    }

    #[test]
    fn the_environment_of_each_scheduler() {
        let slurm = |id, least, most, step, count| {
            [
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_MIN", least),
                ("SLURM_ARRAY_TASK_MAX", most),
                ("SLURM_ARRAY_TASK_STEP", step),
                ("SLURM_ARRAY_TASK_COUNT", count),
            ]
        };
        assert_eq!(parse("auto", &slurm("0", "0", "19", "1", "20")), Ok((0, 20)));
        assert_eq!(parse("auto", &slurm("20", "1", "20", "1", "20")), Ok((0, 20)));
        assert_eq!(parse("auto", &slurm("7", "1", "10", "3", "4")), Ok((2, 4)));
        // One task that is submitted again does what is left of all.
        assert_eq!(parse("auto", &slurm("5", "5", "5", "1", "1")), Ok((0, 1)));
        // … or keeps its shard.
        assert_eq!(parse("auto/20", &slurm("5", "5", "7", "2", "2")), Ok((5, 20)));
        let kubernetes = [("JOB_COMPLETION_INDEX", "3"), ("JOB_COMPLETIONS", "8")];
        assert_eq!(parse("auto", &kubernetes), Ok((3, 8)));
        assert_eq!(parse("auto/4", &kubernetes[..1]), Ok((3, 4)));
        for index in ["PBS_ARRAY_INDEX", "PBS_ARRAYID"] {
            let mut seen: Vec<_> = (1..=4)
                .map(|k: usize| {
                    parse("auto", &[(index, k.to_string().as_str()), ("PBS_ARRAY_COUNT", "4")]).unwrap().0
                })
                .collect();
            seen.sort_unstable();
            assert_eq!(seen, [0, 1, 2, 3], "{index}");
        }
    }

    #[test]
    fn wrong_environments_are_refused_in_one_line() {
        let cases: [(&[(&str, &str)], &str); 9] = [
            (&[], "no scheduler says"),
            (&[("SLURM_ARRAY_TASK_ID", "")], "no scheduler says"),
            (
                &[("SLURM_ARRAY_TASK_ID", "x"), ("SLURM_ARRAY_TASK_COUNT", "3")],
                "SLURM_ARRAY_TASK_ID is \"x\"",
            ),
            (&[("SLURM_ARRAY_TASK_ID", "1")], "set SLURM_ARRAY_TASK_COUNT"),
            (&[("SLURM_ARRAY_TASK_ID", "4"), ("SLURM_ARRAY_TASK_COUNT", "3")], "--array=0-2"),
            (
                &[
                    ("SLURM_ARRAY_TASK_ID", "1"),
                    ("SLURM_ARRAY_TASK_MIN", "1"),
                    ("SLURM_ARRAY_TASK_MAX", "7"),
                    ("SLURM_ARRAY_TASK_COUNT", "3"),
                ],
                "without gaps",
            ),
            (&[("JOB_COMPLETION_INDEX", "8"), ("JOB_COMPLETIONS", "8")], "correct JOB_COMPLETIONS"),
            (&[("PBS_ARRAY_INDEX", "2")], "--shard auto/N"),
            (&[("PBS_ARRAYID", "2"), ("PBS_ARRAY_COUNT", "0")], "give 1 to"),
        ];
        for (variables, words) in cases {
            let error = parse("auto", variables).expect_err(words);
            assert!(error.contains(words) && error.lines().count() == 1, "{variables:?}: {error}");
        }
    }
}
