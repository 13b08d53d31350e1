//! What the cutters in the 3D view are coloured by, and the classes of that which can be hidden.

use serde::{Deserialize, Serialize};

use super::number::with_minus_signs;
use super::planned::ShownPlan;
use super::units::DisplayUnits;
use crate::palette::{self, ColourMap, Rgb, TABLE_LEN, category};
use crate::plunge::{Condition, PlungePlan};

/// Quantity that colours the cutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutterColours {
    /// Sound, blocked or interfering.
    #[default]
    State,
    /// Tool.
    Tool,
    /// Section.
    Section,
    /// Lead angle.
    LeadAngle,
    /// Feed rate of the plunge.
    FeedRate,
    /// Mean residual stock under the cutter.
    Residual,
    /// Time in the program.
    Time,
}

/// A class of cutters that one colour shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutterClass {
    /// Cutters in this state.
    State(Condition),
    /// Those of the tool with this number.
    Tool(u32),
    /// Those of the section with this index.
    Section(usize),
}

/// A class in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassShare {
    /// The class.
    pub class: CutterClass,
    /// Its colour.
    pub colour: Rgb,
    /// Its name.
    pub name: String,
    /// Its share of the time of the program of each plan in view, 0…1.
    pub shares: Vec<f64>,
}

/// What the colours stand for in all plans in view: the same in each, or they could not be compared.
#[derive(Clone, Debug, PartialEq)]
pub enum CutterKey {
    /// Classes, in the order of their first plunge.
    Classes(Vec<CutterClass>),
    /// Values, the least and the greatest.
    Range(f64, f64),
}

/// What the colours mean.
#[derive(Clone, Debug, PartialEq)]
pub enum CutterLegend {
    /// Classes, in the order of their first plunge.
    Classes(Vec<ClassShare>),
    /// A scale from one text to another.
    Scale(String, String),
}

impl CutterColours {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::State, Self::Tool, Self::Section, Self::LeadAngle, Self::FeedRate, Self::Residual, Self::Time];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::State => "State",
            Self::Tool => "Tool",
            Self::Section => "Section",
            Self::LeadAngle => "Lead angle",
            Self::FeedRate => "Feed rate",
            Self::Residual => "Residual",
            Self::Time => "Time",
        }
    }

    /// Class of a position, where the colours show classes.
    pub fn class_of(self, plan: &PlungePlan, index: usize) -> Option<CutterClass> {
        let position = plan.positions.get(index)?;
        match self {
            Self::State => Some(CutterClass::State(position.condition())),
            Self::Tool => Some(CutterClass::Tool(plan.sections.get(position.section)?.tool.number)),
            Self::Section => Some(CutterClass::Section(position.section)),
            Self::LeadAngle | Self::FeedRate | Self::Residual | Self::Time => None,
        }
    }

    /// What the colours stand for in the plans `in_view`.
    pub fn key(self, in_view: &[ShownPlan]) -> CutterKey {
        let values: Option<Vec<Vec<f64>>> = in_view.iter().map(|shown| self.values(shown)).collect();
        match values {
            Some(values) if self.is_scale() => {
                let (low, high) = ends(&values.concat());
                CutterKey::Range(low, high)
            }
            _ => CutterKey::Classes(self.classes(in_view)),
        }
    }

    /// Colours of the positions of a plan by the `key` of all plans in view; `None`: those of their states.
    pub fn of_plan(self, shown: &ShownPlan, key: &CutterKey) -> Option<Vec<Rgb>> {
        let plan = shown.plan();
        match (self, key) {
            (Self::State, _) => None,
            (_, CutterKey::Classes(classes)) if !self.is_scale() => {
                let colour = |k: usize| {
                    let class = self.class_of(plan, k);
                    category(classes.iter().position(|known| Some(*known) == class).unwrap_or_default())
                };
                Some((0..plan.positions.len()).map(colour).collect())
            }
            (_, CutterKey::Classes(_)) => None,
            (_, &CutterKey::Range(low, high)) => {
                let table = ColourMap::Viridis.table();
                let colour = |value: f64| {
                    let share = ((value - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
                    table[(share * (TABLE_LEN - 1) as f64).round() as usize].map(|x| f32::from(x) / 255.0)
                };
                Some(self.values(shown)?.into_iter().map(colour).collect())
            }
        }
    }

    /// What the colours mean in the plans `in_view`; `None` where these have no positions.
    pub fn legend(self, in_view: &[ShownPlan], units: DisplayUnits) -> Option<CutterLegend> {
        if in_view.iter().all(|shown| shown.plan().positions.is_empty()) {
            return None;
        }
        Some(match (self, self.key(in_view)) {
            (_, CutterKey::Classes(classes)) => {
                CutterLegend::Classes(self.class_shares(&classes, in_view, units))
            }
            (Self::LeadAngle, CutterKey::Range(low, high)) => {
                let text = |degrees: f64| with_minus_signs(&format!("{degrees:.1}°"));
                CutterLegend::Scale(text(low), text(high))
            }
            (Self::FeedRate, CutterKey::Range(low, high)) => {
                CutterLegend::Scale(units.number(low, 0), units.feed(high))
            }
            (Self::Residual, CutterKey::Range(low, high)) => {
                CutterLegend::Scale(units.number(low, 2), units.length(high, 2))
            }
            (_, CutterKey::Range(_, high)) => {
                CutterLegend::Scale("0 min".to_owned(), format!("{:.0} min", high / 60.0))
            }
        })
    }

    /// Whether the colours show values rather than classes.
    fn is_scale(self) -> bool {
        matches!(self, Self::LeadAngle | Self::FeedRate | Self::Residual | Self::Time)
    }

    /// Value of each position; `None` where the colours show classes, or the times are not known.
    fn values(self, shown: &ShownPlan) -> Option<Vec<f64>> {
        let plan = shown.plan();
        let count = plan.positions.len();
        match self {
            Self::State | Self::Tool | Self::Section => None,
            Self::LeadAngle => Some(plan.positions.iter().map(|p| p.alpha_rad.to_degrees()).collect()),
            Self::FeedRate => Some((0..count).map(|k| plan.feed_of(k)).collect()),
            Self::Residual => Some((0..count).map(|k| f64::from(shown.stock(k))).collect()),
            Self::Time => (0..count).map(|k| shown.planned.time_after(shown.policy, k + 1)).collect(),
        }
    }

    /// The classes of the plans `in_view`, in the order of their first plunge; states from sound to
    /// interfering.
    fn classes(self, in_view: &[ShownPlan]) -> Vec<CutterClass> {
        let mut classes = Vec::new();
        for plan in in_view.iter().map(ShownPlan::plan) {
            for class in (0..plan.positions.len()).filter_map(|k| self.class_of(plan, k)) {
                if !classes.contains(&class) {
                    classes.push(class);
                }
            }
        }
        if self == Self::State {
            let all = [Condition::Sound, Condition::Blocked, Condition::Interfering].map(CutterClass::State);
            classes = all.into_iter().filter(|class| classes.contains(class)).collect();
        }
        classes
    }

    /// Share of each of the `classes` in the time of the program of a plan.
    fn shares(self, classes: &[CutterClass], shown: &ShownPlan) -> Vec<f64> {
        let (plan, planned, policy) = (shown.plan(), shown.planned, shown.policy);
        let mut times = vec![0.0; classes.len()];
        for k in 0..plan.positions.len() {
            let class = self.class_of(plan, k);
            let place = classes.iter().position(|known| Some(*known) == class);
            let span = planned.time_after(policy, k + 1).zip(planned.time_after(policy, k));
            if let (Some(place), Some((end, start))) = (place, span) {
                times[place] += end - start;
            }
        }
        let whole: f64 = times.iter().sum();
        times.into_iter().map(|time| time / whole.max(1e-9)).collect()
    }

    fn class_shares(
        self,
        classes: &[CutterClass],
        in_view: &[ShownPlan],
        units: DisplayUnits,
    ) -> Vec<ClassShare> {
        let shares: Vec<Vec<f64>> = in_view.iter().map(|shown| self.shares(classes, shown)).collect();
        let share = |(k, &class): (usize, &CutterClass)| ClassShare {
            class,
            colour: match class {
                CutterClass::State(Condition::Sound) => palette::SOUND,
                CutterClass::State(Condition::Blocked) => palette::BLOCKED,
                CutterClass::State(Condition::Interfering) => palette::INTERFERING,
                CutterClass::Tool(_) | CutterClass::Section(_) => category(k),
            },
            name: name_of(class, in_view, units),
            shares: shares.iter().map(|of_plan| of_plan[k]).collect(),
        };
        classes.iter().enumerate().map(share).collect()
    }
}

fn name_of(class: CutterClass, in_view: &[ShownPlan], units: DisplayUnits) -> String {
    match class {
        CutterClass::State(condition) => condition.label().to_owned(),
        CutterClass::Tool(number) => {
            let mut sections = in_view.iter().flat_map(|shown| &shown.plan().sections);
            let section = sections.find(|section| section.tool.number == number);
            format!("T{number} {}", units.diameter(section.map_or(0.0, |section| section.tool.diameter)))
        }
        CutterClass::Section(index) => {
            let section = in_view.iter().find_map(|shown| shown.plan().sections.get(index));
            format!("Section {}{}", index + 1, section.map_or("", |section| section.kind.suffix()))
        }
    }
}

fn ends(values: &[f64]) -> (f64, f64) {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 0.0) }
}
