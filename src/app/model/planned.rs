//! A plan with the data that the panels show, computed once, off the UI thread.

use std::ops::{Index, IndexMut};
use std::sync::Arc;

use crate::job::{PlanOutcome, PolicyResult};
use crate::plunge::{PlungePlan, Position};
use crate::setup::{AllowanceSetup, AxisPolicy, SectionSetup, Setup, Tool};
use crate::stock::{
    FieldCutter, FieldProgram, FloorGrid, FloorLevel, FloorLevels, ResidualField, field_cutters,
};

use crate::app::model::units::DisplayUnits;

/// One of the two plans that are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The conventional plan.
    Before,
    /// The plan by the requested policy.
    #[default]
    After,
}

impl Side {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Before => Self::After,
            Self::After => Self::Before,
        }
    }

    /// Label on the switch.
    pub fn label(self) -> &'static str {
        match self {
            Self::Before => "Before",
            Self::After => "After",
        }
    }
}

/// A value for each side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerSide<T> {
    before: T,
    after: T,
}

impl<T> PerSide<T> {
    /// The values that `make` gives.
    pub fn new(mut make: impl FnMut(Side) -> T) -> Self {
        Self { before: make(Side::Before), after: make(Side::After) }
    }

    /// The values, that of the conventional plan first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        [&self.before, &self.after].into_iter()
    }

    /// The same, to change them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        [&mut self.before, &mut self.after].into_iter()
    }
}

impl<T> Index<Side> for PerSide<T> {
    type Output = T;

    fn index(&self, side: Side) -> &T {
        match side {
            Side::Before => &self.before,
            Side::After => &self.after,
        }
    }
}

impl<T> IndexMut<Side> for PerSide<T> {
    fn index_mut(&mut self, side: Side) -> &mut T {
        match side {
            Side::Before => &mut self.before,
            Side::After => &mut self.after,
        }
    }
}

/// What the panels show of the plan of one policy.
#[derive(Clone, Debug)]
struct PolicyDisplay {
    policy: AxisPolicy,
    /// Mean residual stock on the hub under each position's cutter, mm; NaN without floor under it.
    stock: Vec<f32>,
    /// Its plunges over the floor.
    program: Arc<FieldProgram>,
    /// Time from the start to the end of each plunge, s.
    clock: Vec<f64>,
}

/// A finished plan with display data.
#[derive(Clone, Debug)]
pub struct DisplayPlan {
    /// The setup as requested; the plan is stale when the edited setup differs.
    pub setup: Setup,
    /// The plan.
    pub outcome: Arc<PlanOutcome>,
    policies: Vec<PolicyDisplay>,
    /// Time that semi-finishing takes for what the plan leaves in a channel, s; `None` where the goal does
    /// not count it.
    pub finishing_time_s: Option<f64>,
    /// Range of the colour scale, mm; the same for all policies.
    pub range: (f32, f32),
    /// The floor at the resolutions in which the device draws it.
    pub floor: Arc<FloorLevels>,
}

impl DisplayPlan {
    /// Whether it is the plan of `setup`: of what was asked for, or of the same with the tools and sections
    /// that the program chose for it.
    pub fn is_of(&self, setup: &Setup) -> bool {
        if self.setup.equals_except_flank(setup) {
            return true;
        }
        let chosen = &self.outcome.setup;
        if !self.setup.tools.is_empty() || !Tool::cut_alike(&setup.tools, &chosen.tools) {
            return false;
        }
        let mut asked = self.setup.clone();
        asked.tools.clone_from(&chosen.tools);
        asked.plunge.sections.clone_from(&chosen.plunge.sections);
        asked.equals_except_flank(setup)
    }

    /// Whether it would be the plan of `setup` with other edits by hand.
    pub fn is_of_but_for_edits(&self, setup: &Setup) -> bool {
        let mut asked = setup.clone();
        asked.plunge.edits.clone_from(&self.setup.plunge.edits);
        self.is_of(&asked)
    }

    /// Computes the display data of a plan, drawn over `floor`; see [`Self::floor_of`]. Programs of `known`
    /// are taken over where their plunges are the same; others are sorted here.
    pub fn new(
        setup: Setup,
        outcome: PlanOutcome,
        floor: &Arc<FloorLevels>,
        known: &[Arc<FieldProgram>],
    ) -> Self {
        let display = |result: &PolicyResult| PolicyDisplay {
            policy: result.plan.policy,
            stock: result.plan.positions.iter().map(|p| stock_under(&outcome, result, p)).collect(),
            program: program_of(field_cutters(&result.plan), floor, known),
            clock: outcome.clock.plunge_clock(&result.plan),
        };
        let policies = outcome.policies().into_iter().map(display).collect();
        let range = colour_range(&outcome.grid, [&outcome.before.field, &outcome.after.field]);
        let finishing_time_s = outcome.finishing_time_s(&outcome.after);
        let (outcome, floor) = (Arc::new(outcome), Arc::clone(floor));
        Self { setup, outcome, policies, finishing_time_s, range, floor }
    }

    /// The floor over which a plan with `grid` and `allowances` of the same part is drawn: that of this plan,
    /// shown before, if it is the same or has more cells. The latter is so while a slider moves.
    pub fn floor_of(&self, grid: &Arc<FloorGrid>, allowances: &AllowanceSetup) -> Option<Arc<FloorLevels>> {
        let cells = |level: &FloorLevel| level.grid.rows * level.grid.columns;
        let is_finer = self.outcome.setup.allowances == *allowances
            && self.floor.levels().last().is_some_and(|last| cells(last) > grid.rows * grid.columns);
        (self.floor.is_of(grid) || is_finer).then(|| Arc::clone(&self.floor))
    }

    /// The plunges of all policies, sorted into the tiles of [`Self::floor`].
    pub fn programs(&self) -> Vec<Arc<FieldProgram>> {
        self.policies.iter().map(|display| Arc::clone(&display.program)).collect()
    }

    /// The plunges of a policy, sorted into the tiles of [`Self::floor`].
    pub fn program(&self, policy: AxisPolicy) -> Option<&Arc<FieldProgram>> {
        self.display(policy).map(|display| &display.program)
    }

    /// Whether planning was stopped before the plan was finished.
    pub fn is_unfinished(&self) -> bool {
        self.outcome.after.plan.is_unfinished()
    }

    /// Whether a policy was planned.
    pub fn has(&self, policy: AxisPolicy) -> bool {
        self.display(policy).is_some()
    }

    fn display(&self, policy: AxisPolicy) -> Option<&PolicyDisplay> {
        self.policies.iter().find(|display| display.policy == policy)
    }

    /// Policy that a side shows unless the user chose another.
    pub fn default_policy(&self, side: Side) -> AxisPolicy {
        match side {
            Side::Before => self.outcome.before.plan.policy,
            Side::After => self.outcome.after.plan.policy,
        }
    }

    /// Plan, field and summary of a policy; those of the after side if it was not planned.
    pub fn result(&self, policy: AxisPolicy) -> &PolicyResult {
        let of = |result: &&PolicyResult| result.plan.policy == policy;
        self.outcome.policies().into_iter().find(of).unwrap_or(&self.outcome.after)
    }

    /// Plan of a policy.
    pub fn plan(&self, policy: AxisPolicy) -> &PlungePlan {
        &self.result(policy).plan
    }

    /// Time of the program from its start to the end of its first `count` plunges, s; `None` where it is not
    /// known.
    pub fn time_after(&self, policy: AxisPolicy, count: usize) -> Option<f64> {
        let clock = &self.display(policy)?.clock;
        if count == 0 { Some(0.0) } else { clock.get(count - 1).copied() }
    }

    /// What differs between the tools and sections of two plans, as a sentence; `None` if nothing does. Only
    /// for plans of one part.
    pub fn tool_change_since(&self, last: &Self, units: DisplayUnits) -> Option<String> {
        let words = |planned: &Self| tools_in_words(&planned.outcome.setup, units);
        let (then, now) = (words(last), words(self));
        let sorted = |mut sections: Vec<String>| {
            sections.sort();
            sections
        };
        if then == now {
            None
        } else if sorted(then.clone()) == sorted(now.clone()) {
            Some(format!("Sections cut in another order: {}", now.join(", ")))
        } else {
            Some(format!("Tools chosen anew: {} in place of {}", now.join(", "), then.join(", ")))
        }
    }

    /// Mean residual stock on the hub under the cutter of position `index`, mm; NaN without floor under it.
    pub fn stock(&self, policy: AxisPolicy, index: usize) -> f32 {
        self.display(policy).and_then(|display| display.stock.get(index)).copied().unwrap_or(f32::NAN)
    }
}

/// Tools of the sections of a complete setup, with their stretches.
fn tools_in_words(setup: &Setup, units: DisplayUnits) -> Vec<String> {
    let section = |section: &SectionSetup| {
        let tool = setup.tools.iter().find(|tool| tool.number == section.tool)?;
        let rest = section.kind.suffix();
        let diameter = units.diameter(tool.diameter);
        Some(format!("{diameter} ({:.2} to {:.2}{rest})", section.from, section.to))
    };
    setup.plunge.sections.iter().filter_map(section).collect()
}

/// The plunges `cutters` of a plan over a floor: one of `known`, if it has the same.
pub(in crate::app) fn program_of(
    cutters: Vec<FieldCutter>,
    floor: &Arc<FloorLevels>,
    known: &[Arc<FieldProgram>],
) -> Arc<FieldProgram> {
    let same = |known: &&Arc<FieldProgram>| Arc::ptr_eq(&known.floor, floor) && known.cutters == cutters;
    let known = known.iter().find(same).cloned();
    known.unwrap_or_else(|| Arc::new(FieldProgram::new(floor, cutters)))
}

/// Range of the colour scale: 0 to the 98th percentile over the machined floor, rounded up to a round value.
/// Floor that is not machined and single spikes would otherwise flatten the colours.
fn colour_range(grid: &FloorGrid, fields: [&ResidualField; 2]) -> (f32, f32) {
    let mut heights = Vec::new();
    for field in fields {
        let cells = field.heights.iter().zip(&grid.floor).zip(&grid.blank_heights);
        // Every seventh cell suffices for a percentile.
        heights.extend(cells.step_by(7).filter_map(|((&height, &floor), &blank)| {
            (floor && height.is_finite() && height < blank).then_some(height)
        }));
    }
    if heights.is_empty() {
        return (0.0, 1.0);
    }
    let at = (heights.len() - 1) * 98 / 100;
    let (_, top, _) = heights.select_nth_unstable_by(at, f32::total_cmp);
    let top = top.max(0.1);
    let decade = 10f32.powf(top.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    (0.0, steps.iter().map(|s| s * decade).find(|&value| value >= top).unwrap_or(top))
}

/// Mean height of the floor cells under a cutter, mm.
fn stock_under(outcome: &PlanOutcome, result: &PolicyResult, position: &Position) -> f32 {
    let (grid, field) = (&*outcome.grid, &result.field);
    let Some(radius) = result.plan.sections.get(position.section).map(|s| s.tool.radius() as f32) else {
        return f32::NAN;
    };
    let count = grid.rows * grid.columns;
    if grid.rows < 2
        || grid.columns < 2
        || [grid.points.len(), grid.floor.len(), field.heights.len()].iter().any(|&n| n < count)
    {
        return f32::NAN;
    }
    let tip: [f32; 3] = [position.tip.x as f32, position.tip.y as f32, position.tip.z as f32];
    let axis: [f32; 3] = [position.axis.x as f32, position.axis.y as f32, position.axis.z as f32];
    let near = |fraction: f64, n: usize| (fraction.clamp(0.0, 1.0) * (n - 1) as f64).round() as usize;
    let (i, j) = (near(position.s, grid.rows), near(position.lambda, grid.columns));
    let at = |i: usize, j: usize| grid.points[i * grid.columns + j];
    // Number of cells to either side within the disc, with a margin of 50 % for tilt and curvature.
    let reach = |a: [f32; 3], b: [f32; 3]| (1.5 * radius / distance(a, b).max(1e-3)).ceil() as usize;
    let i1 = if i + 1 < grid.rows { i + 1 } else { i - 1 };
    let j1 = if j + 1 < grid.columns { j + 1 } else { j - 1 };
    let (along, across) = (reach(at(i, j), at(i1, j)), reach(at(i, j), at(i, j1)));
    let (mut sum, mut cells) = (0.0f64, 0u32);
    for row in i.saturating_sub(along)..=(i + along).min(grid.rows - 1) {
        for column in j.saturating_sub(across)..=(j + across).min(grid.columns - 1) {
            let index = row * grid.columns + column;
            let height = field.heights[index];
            if grid.floor[index] && height.is_finite() && off_axis(grid.points[index], tip, axis) <= radius {
                sum += f64::from(height);
                cells += 1;
            }
        }
    }
    if cells == 0 { f32::NAN } else { (sum / f64::from(cells)) as f32 }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = difference(a, b);
    dot(d, d).sqrt()
}

fn off_axis(point: [f32; 3], tip: [f32; 3], axis: [f32; 3]) -> f32 {
    let d = difference(point, tip);
    let along = dot(d, axis);
    (dot(d, d) - along * along).max(0.0).sqrt()
}

/// A plan that is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownPlan<'a> {
    /// The set of plans it belongs to.
    pub planned: &'a Arc<DisplayPlan>,
    /// Policy of the plan.
    pub policy: AxisPolicy,
}

impl<'a> ShownPlan<'a> {
    /// The plan itself.
    pub fn plan(&self) -> &'a PlungePlan {
        self.planned.plan(self.policy)
    }

    /// Mean residual stock on the hub under a position's cutter, mm.
    pub fn stock(&self, position: usize) -> f32 {
        self.planned.stock(self.policy, position)
    }
}
