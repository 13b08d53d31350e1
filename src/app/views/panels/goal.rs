//! Rows of the goal of a plan of `minimal`, with its limit or the time of semi-finishing.

use egui::Ui;

use super::fields::{self, ChoiceSpec, FieldSpec};
use crate::app::model::known_goals::KnownGoals;
use crate::app::model::number::Quantity;
use crate::setup::{Goal, SemiFinishing, Tool};

/// What a plan of `minimal` is for, without its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum GoalKind {
    Stock,
    Balance,
    Time,
    Total,
}

impl GoalKind {
    fn from_goal(goal: Goal) -> Self {
        match goal {
            Goal::Stock { .. } => Self::Stock,
            Goal::Balance => Self::Balance,
            Goal::Time { .. } => Self::Time,
            Goal::Total { .. } => Self::Total,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Stock => "Least stock",
            Self::Balance => "Balance",
            Self::Time => "Least time",
            Self::Total => "Least total",
        }
    }

    fn tip(self) -> &'static str {
        match self {
            Self::Stock => "The least stock on the hub, within a time if one is given",
            Self::Balance => "Where more time begins to buy little",
            Self::Time => "The least time that leaves no more stock than given",
            Self::Total => "The least time of plunging and of semi-finishing what the plunges leave",
        }
    }
}

const GOAL: ChoiceSpec<GoalKind> = ChoiceSpec {
    label: "Goal",
    tip: "What a plan of Min. stock is for. \"Time against stock\" in the menu Plan shows what each costs",
    all: &[GoalKind::Stock, GoalKind::Balance, GoalKind::Time, GoalKind::Total],
    name: GoalKind::label,
    meaning: GoalKind::tip,
};
const MAX_TIME: FieldSpec = FieldSpec {
    quantity: Quantity::Duration,
    speed: 0.5,
    decimals: 1,
    ..FieldSpec::mm(
        "Max time",
        "How long a channel may take: on the machine if the setup names one, else without tool changes.\n\
         Smaller: fewer plunges, but more stock on the hub",
        0.1,
        100_000.0,
    )
    .or_none()
};
const MAX_STOCK: FieldSpec = FieldSpec::mm(
    "Max stock",
    "Stock above the hub allowance that may stay, at the 95th percentile.\n\
     Larger: fewer plunges and less time",
    0.001,
    100.0,
);
/// Stock that may stay when the goal becomes the least time, as a share of the first tool's diameter: about
/// twice what plans of least stock leave, so that there is time to save.
const MAX_STOCK_SHARE: f64 = 0.1;

/// Semi-finishing when the goal becomes the least total: in steel with a ball-end mill of medium size.
const FINISHING: SemiFinishing = SemiFinishing::Rate { mm3_per_min: 1500.0 };
/// The same in passes.
const FINISHING_PASSES: SemiFinishing = SemiFinishing::Passes { depth: 0.5, pass_time_min: 10.0 };

/// How the time of semi-finishing is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FinishingKind {
    Rate,
    Passes,
}

impl FinishingKind {
    fn from_finishing(finishing: SemiFinishing) -> Self {
        match finishing {
            SemiFinishing::Rate { .. } => Self::Rate,
            SemiFinishing::Passes { .. } => Self::Passes,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Rate => "Removal rate",
            Self::Passes => "Passes",
        }
    }

    fn tip(self) -> &'static str {
        match self {
            Self::Rate => {
                "By the volume that is left, with what stays uncut. The value is an example at first"
            }
            Self::Passes => {
                "By the passes that the thickness on 95 % of the cut floor needs. The values are an example at first"
            }
        }
    }
}

const FINISHING_KIND: ChoiceSpec<FinishingKind> = ChoiceSpec {
    label: "Semi-finishing",
    tip: "What the time of semi-finishing goes by",
    all: &[FinishingKind::Rate, FinishingKind::Passes],
    name: FinishingKind::label,
    meaning: FinishingKind::tip,
};
const FINISH_RATE: FieldSpec = FieldSpec {
    quantity: Quantity::RemovalRate,
    speed: 20.0,
    decimals: 0,
    ..FieldSpec::mm(
        "Finish rate",
        "Volume that semi-finishing removes per minute.\n\
         Larger: fewer plunges, and more is left to semi-finishing",
        1.0,
        1e6,
    )
};
const FINISH_DEPTH: FieldSpec = FieldSpec::mm(
    "Finish depth",
    "Stock that a pass of semi-finishing removes.\n\
     Larger: fewer plunges, and more is left to semi-finishing",
    0.001,
    100.0,
);
const FINISH_PASS_TIME: FieldSpec = FieldSpec {
    quantity: Quantity::Duration,
    speed: 0.5,
    decimals: 1,
    ..FieldSpec::mm(
        "Pass time",
        "Time of a pass of semi-finishing over one channel.\n\
         Smaller: fewer plunges, and more is left to semi-finishing",
        0.1,
        100_000.0,
    )
};

/// Rows of the time of semi-finishing; `known` are the values given before.
fn finishing_rows(ui: &mut Ui, finishing: &mut SemiFinishing, known: &KnownGoals) {
    let before = FinishingKind::from_finishing(*finishing);
    let mut kind = before;
    fields::choice_row(ui, &mut kind, FinishingKind::from_finishing(FINISHING), &FINISHING_KIND);
    if kind != before {
        let is_it = |goal: &Goal| matches!(goal, Goal::Total { finishing } if FinishingKind::from_finishing(*finishing) == kind);
        *finishing = match (known.latest(is_it), kind) {
            (Some(Goal::Total { finishing }), _) => finishing,
            (_, FinishingKind::Rate) => FINISHING,
            (_, FinishingKind::Passes) => FINISHING_PASSES,
        };
    }
    match finishing {
        SemiFinishing::Rate { mm3_per_min } => {
            fields::plain_row(ui, mm3_per_min, &FINISH_RATE);
        }
        SemiFinishing::Passes { depth, pass_time_min } => {
            fields::plain_row(ui, depth, &FINISH_DEPTH);
            fields::plain_row(ui, pass_time_min, &FINISH_PASS_TIME);
        }
    }
}

/// Rows of the goal and its limit; `first` is the first tool of the plan, `known` what was given before.
pub fn goal_rows(ui: &mut Ui, goal: &mut Goal, known: &mut KnownGoals, default: Goal, first: Option<&Tool>) {
    known.note(*goal);
    let before = GoalKind::from_goal(*goal);
    let mut kind = before;
    fields::choice_row(ui, &mut kind, GoalKind::from_goal(default), &GOAL);
    let share = MAX_STOCK_SHARE * first.map_or(20.0, |tool| tool.diameter);
    let default_stock = (100.0 * share).round() / 100.0;
    if kind != before {
        let given = known.latest(|goal| GoalKind::from_goal(*goal) == kind);
        *goal = given.unwrap_or(match kind {
            GoalKind::Stock => Goal::Stock { max_time_min: None },
            GoalKind::Balance => Goal::Balance,
            GoalKind::Time => Goal::Time { max_stock: default_stock },
            GoalKind::Total => Goal::Total { finishing: FINISHING },
        });
    }
    match goal {
        Goal::Stock { max_time_min } => {
            fields::optional_row(ui, max_time_min, &MAX_TIME, None);
        }
        Goal::Balance => {}
        Goal::Time { max_stock } => {
            fields::number_row(ui, max_stock, default_stock, &MAX_STOCK);
        }
        Goal::Total { finishing } => finishing_rows(ui, finishing, known),
    }
}
