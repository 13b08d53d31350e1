//! What the cutters in the 3D view are coloured by, and the classes of that which can be hidden.

use super::planned::DisplayPlan;
use super::units::DisplayUnits;
use crate::palette::{self, ColourMap, Rgb, TABLE_LEN, category};
use crate::plunge::{Condition, PlungePlan};
use crate::setup::AxisPolicy;

/// Quantity that colours the cutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    /// Its share of the time of the program, 0…1.
    pub share: f64,
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

    /// Colours of the positions of a plan; `None`: those of their states.
    pub fn of_plan(self, planned: &DisplayPlan, policy: AxisPolicy) -> Option<Vec<Rgb>> {
        let plan = planned.plan(policy);
        match self {
            Self::State => None,
            Self::Tool | Self::Section => {
                let classes = self.classes(plan);
                let colour = |k: usize| {
                    let class = self.class_of(plan, k);
                    category(classes.iter().position(|known| Some(*known) == class).unwrap_or_default())
                };
                Some((0..plan.positions.len()).map(colour).collect())
            }
            Self::LeadAngle | Self::FeedRate | Self::Residual | Self::Time => {
                let values = self.values(planned, policy)?;
                let (low, high) = ends(&values);
                let table = ColourMap::Viridis.table();
                let colour = |value: f64| {
                    let share = ((value - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
                    table[(share * (TABLE_LEN - 1) as f64).round() as usize].map(|x| f32::from(x) / 255.0)
                };
                Some(values.into_iter().map(colour).collect())
            }
        }
    }

    /// What the colours mean; `None` where the plan has no positions.
    pub fn legend(
        self,
        planned: &DisplayPlan,
        policy: AxisPolicy,
        units: DisplayUnits,
    ) -> Option<CutterLegend> {
        let plan = planned.plan(policy);
        if plan.positions.is_empty() {
            return None;
        }
        let Some(values) = self.values(planned, policy) else {
            return Some(CutterLegend::Classes(self.shares(planned, policy, units)));
        };
        let (low, high) = ends(&values);
        Some(match self {
            Self::LeadAngle => CutterLegend::Scale(format!("{low:.1}°"), format!("{high:.1}°")),
            Self::FeedRate => CutterLegend::Scale(units.number(low, 0), units.feed(high)),
            Self::Residual => CutterLegend::Scale(units.number(low, 2), units.length(high, 2)),
            _ => CutterLegend::Scale("0 min".to_owned(), format!("{:.0} min", high / 60.0)),
        })
    }

    /// Value of each position; `None` where the colours show classes, or the times are not known.
    fn values(self, planned: &DisplayPlan, policy: AxisPolicy) -> Option<Vec<f64>> {
        let plan = planned.plan(policy);
        let count = plan.positions.len();
        match self {
            Self::State | Self::Tool | Self::Section => None,
            Self::LeadAngle => Some(plan.positions.iter().map(|p| p.alpha_rad.to_degrees()).collect()),
            Self::FeedRate => Some((0..count).map(|k| plan.feed_of(k)).collect()),
            Self::Residual => Some((0..count).map(|k| f64::from(planned.stock(policy, k))).collect()),
            Self::Time => (0..count).map(|k| planned.time_after(policy, k + 1)).collect(),
        }
    }

    /// The classes of a plan, in the order of their first plunge; states from sound to interfering.
    fn classes(self, plan: &PlungePlan) -> Vec<CutterClass> {
        let mut classes = Vec::new();
        for class in (0..plan.positions.len()).filter_map(|k| self.class_of(plan, k)) {
            if !classes.contains(&class) {
                classes.push(class);
            }
        }
        if self == Self::State {
            let all = [Condition::Sound, Condition::Blocked, Condition::Interfering].map(CutterClass::State);
            classes = all.into_iter().filter(|class| classes.contains(class)).collect();
        }
        classes
    }

    fn shares(self, planned: &DisplayPlan, policy: AxisPolicy, units: DisplayUnits) -> Vec<ClassShare> {
        let plan = planned.plan(policy);
        let classes = self.classes(plan);
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
        let share = |(k, &class): (usize, &CutterClass)| ClassShare {
            class,
            colour: match class {
                CutterClass::State(Condition::Sound) => palette::SOUND,
                CutterClass::State(Condition::Blocked) => palette::BLOCKED,
                CutterClass::State(Condition::Interfering) => palette::INTERFERING,
                CutterClass::Tool(_) | CutterClass::Section(_) => category(k),
            },
            name: name_of(class, plan, units),
            share: times[k] / whole.max(1e-9),
        };
        classes.iter().enumerate().map(share).collect()
    }
}

fn name_of(class: CutterClass, plan: &PlungePlan, units: DisplayUnits) -> String {
    match class {
        CutterClass::State(condition) => condition.label().to_owned(),
        CutterClass::Tool(number) => {
            let section = plan.sections.iter().find(|section| section.tool.number == number);
            format!("T{number} {}", units.diameter(section.map_or(0.0, |section| section.tool.diameter)))
        }
        CutterClass::Section(index) => {
            let rest = plan.sections.get(index).map_or("", |section| section.kind.suffix());
            format!("Section {}{rest}", index + 1)
        }
    }
}

fn ends(values: &[f64]) -> (f64, f64) {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 0.0) }
}
