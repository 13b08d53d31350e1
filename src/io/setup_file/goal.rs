//! Reading what a plan of `minimal` is for: the keys of `[plunge]` that say so.

use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::quote_for_message;
use crate::io::table::{NumberRange, TomlTable};
use crate::io::tool_file::{LENGTH, RATE};
use crate::setup::{Goal, SemiFinishing};

const MINUTES: NumberRange = NumberRange::Above(0.0, 100_000.0);

/// Reads the goal; `None` where the table does not say.
pub(super) fn read_goal(table: &TomlTable<'_>) -> Result<Option<Goal>, InputError> {
    let [time, stock, rate, depth, pass_time] = [
        ("max_time", MINUTES),
        ("max_stock", LENGTH),
        ("finish_rate", RATE),
        ("finish_depth", LENGTH),
        ("finish_pass_time", MINUTES),
    ]
    .map(|(key, range)| table.number(key, range));
    let (time, stock, rate, depth, pass_time) = (time?, stock?, rate?, depth?, pass_time?);
    // The goal that each key belongs to.
    let given = [
        ("max_time", "stock", &time),
        ("max_stock", "time", &stock),
        ("finish_rate", "total", &rate),
        ("finish_depth", "total", &depth),
        ("finish_pass_time", "total", &pass_time),
    ];
    let mut given = given.into_iter().filter_map(|(key, of, number)| Some((key, of, number.as_ref()?.at)));
    let max_time_min = time.as_ref().map(|minutes| minutes.value);
    let Some(goal) = table.string("goal")? else {
        // A limit of time needs no goal: it is one of the usual goal.
        return match given.find(|(key, ..)| *key != "max_time") {
            Some((key, of, at)) => {
                let what = format!("`{key}` is given without `goal = \"{of}\"`");
                let help = format!("add the goal, or remove `{key}`");
                Err(table.fault_at(at, what, help).with_code(ErrorCode::ConflictingKeys))
            }
            None => Ok(max_time_min.map(|_| Goal::Stock { max_time_min })),
        };
    };
    let fault =
        |code: ErrorCode, what: String, help: &str| table.fault_at(goal.at, what, help).with_code(code);
    if !["stock", "time", "balance", "total"].contains(&goal.value) {
        let what = format!("{} is not a goal", quote_for_message(goal.value));
        let help = "use \"stock\", \"time\", \"balance\" or \"total\"";
        return Err(fault(ErrorCode::UnknownName, what, help));
    }
    if let Some((key, ..)) = given.find(|(_, of, _)| *of != goal.value) {
        let what = format!("`{key}` does not fit this goal");
        return Err(fault(ErrorCode::ConflictingKeys, what, &format!("remove `{key}`")));
    }
    let missing = |what: &str, help: &str| fault(ErrorCode::MissingKey, what.to_owned(), help);
    Ok(Some(match goal.value {
        "stock" => Goal::Stock { max_time_min },
        "time" => {
            let needed = || missing("the goal \"time\" needs a limit of stock", "add `max_stock`");
            Goal::Time { max_stock: stock.ok_or_else(needed)?.value }
        }
        "balance" => Goal::Balance,
        _ => {
            let numbers = [rate, depth, pass_time].map(|number| number.map(|number| number.value));
            let fault = |(code, what, help): FinishingFault| fault(code, what.to_owned(), help);
            Goal::Total { finishing: semi_finishing(numbers).map_err(fault)? }
        }
    }))
}

/// What is wrong with the keys of semi-finishing, and what to do.
type FinishingFault = (ErrorCode, &'static str, &'static str);

/// Semi-finishing by its rate, or by depth and time of a pass.
fn semi_finishing([rate, depth, pass_time]: [Option<f64>; 3]) -> Result<SemiFinishing, FinishingFault> {
    match (rate, depth, pass_time) {
        (Some(mm3_per_min), None, None) => Ok(SemiFinishing::Rate { mm3_per_min }),
        (None, Some(depth), Some(pass_time_min)) => Ok(SemiFinishing::Passes { depth, pass_time_min }),
        (Some(_), ..) => Err((
            ErrorCode::ConflictingKeys,
            "semi-finishing has a rate and passes",
            "remove `finish_rate`, or `finish_depth` and `finish_pass_time`",
        )),
        (None, Some(_), None) => {
            Err((ErrorCode::MissingKey, "a pass of semi-finishing has no time", "add `finish_pass_time`"))
        }
        (None, None, Some(_)) => {
            Err((ErrorCode::MissingKey, "a pass of semi-finishing has no depth", "add `finish_depth`"))
        }
        (None, None, None) => Err((
            ErrorCode::MissingKey,
            "the goal \"total\" needs the time of semi-finishing",
            "add `finish_rate` in mm³/min, or `finish_depth` and `finish_pass_time`",
        )),
    }
}
