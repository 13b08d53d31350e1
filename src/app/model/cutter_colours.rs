//! What the cutters in the 3D view are coloured by: state, tool, lead angle or time.

use crate::palette::{CUTTER_CATEGORIES, ColourMap, Rgb, TABLE_LEN};
use crate::setup::AxisPolicy;

use crate::app::model::planned::DisplayPlan;

/// Quantity that colours the cutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutterColours {
    /// Sound, blocked or interfering.
    #[default]
    State,
    /// Tool.
    Tool,
    /// Lead angle.
    LeadAngle,
    /// Time in the program.
    Time,
}

/// What the colours mean.
#[derive(Clone, Debug, PartialEq)]
pub enum CutterLegend {
    /// A colour per class, with its name and its share of the time, 0…1.
    Classes(Vec<(Rgb, String, f64)>),
    /// A scale from one text to another.
    Scale(String, String),
}

impl CutterColours {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::State, Self::Tool, Self::LeadAngle, Self::Time];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::State => "State",
            Self::Tool => "Tool",
            Self::LeadAngle => "Lead angle",
            Self::Time => "Time",
        }
    }

    /// Colours of the positions of a plan; `None`: those of their states.
    pub fn of_plan(self, planned: &DisplayPlan, policy: AxisPolicy) -> Option<Vec<Rgb>> {
        let plan = planned.plan(policy);
        if self == Self::Tool {
            let tools = tool_numbers(planned, policy);
            let place = |number: u32| tools.iter().position(|&known| known == number).unwrap_or(0);
            let of_section = |section: usize| plan.sections.get(section).map_or(0, |s| place(s.tool.number));
            let colour = |section: usize| tool_colour(of_section(section));
            return Some(plan.positions.iter().map(|position| colour(position.section)).collect());
        }
        let values = self.values(planned, policy)?;
        let (low, high) = ends(&values);
        let table = ColourMap::Viridis.table();
        let colour = |value: f64| {
            let share = ((value - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
            table[(share * (TABLE_LEN - 1) as f64).round() as usize].map(|x| f32::from(x) / 255.0)
        };
        Some(values.into_iter().map(colour).collect())
    }

    /// What the colours mean; `None` for the states, which table and verdict name.
    pub fn legend(self, planned: &DisplayPlan, policy: AxisPolicy) -> Option<CutterLegend> {
        if self == Self::Tool {
            return Some(CutterLegend::Classes(tool_classes(planned, policy)));
        }
        let (low, high) = ends(&self.values(planned, policy)?);
        Some(match self {
            Self::LeadAngle => CutterLegend::Scale(format!("{low:.1}°"), format!("{high:.1}°")),
            _ => CutterLegend::Scale("0 min".to_owned(), format!("{:.0} min", high / 60.0)),
        })
    }

    /// Lead angles in degrees, or times in s.
    fn values(self, planned: &DisplayPlan, policy: AxisPolicy) -> Option<Vec<f64>> {
        let positions = &planned.plan(policy).positions;
        match self {
            Self::State | Self::Tool => None,
            Self::LeadAngle => Some(positions.iter().map(|p| p.alpha_rad.to_degrees()).collect()),
            Self::Time => (0..positions.len()).map(|k| planned.time_after(policy, k + 1)).collect(),
        }
    }
}

/// Colour of tool `index` of a program.
fn tool_colour(index: usize) -> Rgb {
    CUTTER_CATEGORIES[index % CUTTER_CATEGORIES.len()]
}

fn ends(values: &[f64]) -> (f64, f64) {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// Numbers of the tools that plunge, in the order of their first plunge.
fn tool_numbers(planned: &DisplayPlan, policy: AxisPolicy) -> Vec<u32> {
    let plan = planned.plan(policy);
    let mut numbers = Vec::new();
    for section in plan.positions.iter().filter_map(|position| plan.sections.get(position.section)) {
        if !numbers.contains(&section.tool.number) {
            numbers.push(section.tool.number);
        }
    }
    numbers
}

fn tool_classes(planned: &DisplayPlan, policy: AxisPolicy) -> Vec<(Rgb, String, f64)> {
    let plan = planned.plan(policy);
    let tools = tool_numbers(planned, policy);
    let mut times = vec![0.0; tools.len()];
    for (k, position) in plan.positions.iter().enumerate() {
        let number = plan.sections.get(position.section).map(|section| section.tool.number);
        let place = number.and_then(|number| tools.iter().position(|&known| known == number));
        let span = planned.time_after(policy, k + 1).zip(planned.time_after(policy, k));
        if let (Some(place), Some((end, start))) = (place, span) {
            times[place] += end - start;
        }
    }
    let whole: f64 = times.iter().sum();
    let diameter = |number: u32| {
        let section = plan.sections.iter().find(|section| section.tool.number == number);
        section.map_or(0.0, |section| section.tool.diameter)
    };
    let class = |(k, &number): (usize, &u32)| {
        let name = format!("T{number} Ø{}", diameter(number));
        (tool_colour(k), name, times[k] / whole.max(1e-9))
    };
    tools.iter().enumerate().map(class).collect()
}
