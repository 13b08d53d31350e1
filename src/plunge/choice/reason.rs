//! Text for why a section was chosen: one line with checkable facts.

use std::collections::BTreeSet;

use super::estimate::Estimator;
use super::fit::ToolFit;
use super::search::{SectionChoice, ToolStretch, cheapest};
use crate::plunge::survey::SurveyStation;
use crate::setup::Tool;

/// Data from which the reasons of a choice are derived.
pub struct Reasons<'a> {
    /// Costs and rules.
    pub estimator: &'a Estimator<'a>,
    /// The available tools, large to small.
    pub candidates: &'a [&'a Tool],
    /// Maximum diameter that was considered, mm.
    pub limit: Option<f64>,
    /// The choice.
    pub found: &'a SectionChoice,
}

impl Reasons<'_> {
    /// Why section `index` has its tool, why it ends where it does, and how much time the best choice with
    /// another diameter there would take.
    pub fn tell_section(&self, index: usize) -> String {
        let stretch = self.found.stretches[index];
        let parts = [
            Some(self.size(stretch)),
            Some(self.end(index)),
            self.set_aside(stretch),
            self.broken(stretch),
            self.rival(stretch),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
    }

    fn tool(&self, stretch: ToolStretch) -> &Tool {
        self.candidates[stretch.tool]
    }

    fn station(&self, index: usize) -> &SurveyStation {
        &self.estimator.survey.stations[index]
    }

    fn fit(&self, tool: &Tool, station: usize) -> ToolFit {
        self.estimator.rules.fit(tool, self.station(station))
    }

    fn size(&self, stretch: ToolStretch) -> String {
        let tool = self.tool(stretch);
        let mut larger = self.candidates.iter().filter(|t| t.diameter > tool.diameter).peekable();
        let largest = larger.peek().is_none();
        let fits =
            |t: &Tool| (stretch.to..=stretch.from).all(|station| self.fit(t, station) == ToolFit::Good);
        match self.limit {
            _ if self.candidates.len() == 1 => "the only cutter available".to_owned(),
            Some(limit) if largest => {
                format!("largest cutter with room for rows side by side at the outlet (at most D {limit:.1})")
            }
            None if largest => "largest cutter for plunges".to_owned(),
            _ if larger.any(|t| fits(t)) => "larger ones would fit".to_owned(),
            _ => "largest cutter with room to tilt".to_owned(),
        }
    }

    fn end(&self, index: usize) -> String {
        let stretch = self.found.stretches[index];
        let (s, width) = (self.station(stretch.to).s, self.station(stretch.to).narrowest);
        let Some(next) = self.found.stretches.get(index + 1) else {
            let widths = (0..=stretch.from).map(|i| self.station(i).narrowest);
            let narrowest = widths.fold(f64::INFINITY, f64::min);
            return format!("to the leading edge through a passage down to {narrowest:.1} mm wide");
        };
        if self.estimator.survey.joints.contains(&stretch.to) {
            return format!("to s = {s:.2}, where the passages beside the splitter join");
        }
        match stretch.to.checked_sub(1).map(|further| self.fit(self.tool(stretch), further)) {
            Some(ToolFit::Wide | ToolFit::Tight) => {
                format!("to s = {s:.2}, where the passage narrows to {width:.1} mm")
            }
            Some(ToolFit::Hindered) => {
                format!("to s = {s:.2}, where its shank or holder comes too near")
            }
            Some(ToolFit::Short) => {
                format!("to s = {s:.2}, where the channel gets too deep for its overhang")
            }
            _ => format!("to s = {s:.2}, from where D {} takes less time", self.tool(*next).diameter),
        }
    }

    /// The passages that the choice does not go by, if any.
    fn set_aside(&self, stretch: ToolStretch) -> Option<String> {
        let aside = (stretch.to..=stretch.from).flat_map(|i| &self.station(i).aside);
        let width = aside.map(|across| across.narrowest).reduce(f64::min)?;
        Some(format!("chosen without regard to a passage down to {width:.1} mm wide, too narrow or too deep"))
    }

    /// The rule of fit that the cutter breaks, if any.
    fn broken(&self, stretch: ToolStretch) -> Option<String> {
        let tool = self.tool(stretch);
        let within = stretch.to..=stretch.from;
        let fits: Vec<ToolFit> = within.clone().map(|station| self.fit(tool, station)).collect();
        if fits.contains(&ToolFit::Hindered) {
            return Some("its shank or holder comes too near to part or blank in places".to_owned());
        }
        if fits.contains(&ToolFit::Tight) {
            return Some("without room to tilt in places".to_owned());
        }
        let needed = within.map(|i| self.estimator.rules.overhang(self.station(i))).fold(0.0, f64::max);
        fits.contains(&ToolFit::Short).then(|| {
            format!("its overhang of {:.0} mm is less than the {needed:.0} mm needed there", tool.overhang)
        })
    }

    /// Comparison with the best choice that has another diameter in the middle of this stretch.
    fn rival(&self, stretch: ToolStretch) -> Option<String> {
        let diameter = |stretch: ToolStretch| self.tool(stretch).diameter;
        let middle = (stretch.from + stretch.to) / 2;
        let holds_middle = |s: ToolStretch| s.to <= middle && middle < s.from;
        let other = |s: ToolStretch| !holds_middle(s) || diameter(s) != diameter(stretch);
        let rival = cheapest(self.estimator, self.candidates, other)?;
        let instead = diameter(rival.stretches.iter().copied().find(|&s| holds_middle(s))?);
        let (cost, best) = (rival.cost, self.found.cost);
        if (cost.misfits, cost.wanting) > (best.misfits, best.wanting) {
            return Some("any other would lack room or overhang".to_owned());
        }
        let percent = 100.0 * (cost.seconds / best.seconds - 1.0);
        let tools =
            |found: &SectionChoice| found.stretches.iter().map(|s| s.tool).collect::<BTreeSet<_>>().len();
        let effect = match percent {
            _ if percent >= 0.05 => format!("{percent:.1} % longer"),
            _ if percent <= -0.05 => format!("{:.1} % less", -percent),
            _ => "as long".to_owned(),
        };
        let count = match (tools(&rival), tools(self.found)) {
            (rival, ours) if rival == ours => String::new(),
            (1, _) => ", with one cutter".to_owned(),
            (rival, _) => format!(", with {rival} cutters"),
        };
        Some(format!("with D {instead} in its place the channel would take {effect}{count}"))
    }
}
