//! `plan.json`: a plunge plan with everything needed to display it again, including part and setup.

use serde::{Deserialize, Serialize};

use super::InputError;
use super::native::write_native;
use super::setup_file::write_full_setup;
use super::source::Source;
use super::stored;
use super::stored::{ByName, Named, StoredInputs, are_coordinates, damaged};
use crate::cutting::contact::{CoreContact, Engagement};
use crate::error::ErrorCode;
use crate::monitor::{Cancelled, Monitor};
use crate::part::{Impeller, PartDescription};
use crate::plunge::channels::plan_channels;
use crate::plunge::{
    AddedPlunges, Blocked, DropReason, Dropped, Evaluation, LimitedBy, Pecking, PlungeMotion, PlungePlan,
    Position, SectionPlan, StopReason,
};
use crate::setup::{AxisPolicy, CutDirection, Setup, tool_of};
use crate::toolpath::ClProgram;

/// Version of the file format; newer files are rejected.
pub(super) const VERSION: u32 = 2;

#[derive(Serialize, Deserialize)]
struct PlanRecord {
    vanecut_plan: u32,
    /// The part in the native format.
    part: String,
    /// The setup with every default filled in.
    setup: String,
    policy: AxisPolicy,
    channels: usize,
    rounds: usize,
    settled: bool,
    rows: Vec<usize>,
    /// In which direction each section is cut. Absent in files of earlier versions.
    #[serde(default)]
    directions: Vec<CutDirection>,
    /// Plunges added to each section and why adding stopped. Absent in files of earlier versions.
    #[serde(default)]
    added: Vec<Option<(usize, ByName<StopReason>)>>,
    positions: Vec<PositionRecord>,
    dropped: Vec<(usize, usize, f64)>,
    /// Why each entry of `dropped` was left out. Absent in files of earlier versions.
    #[serde(default)]
    dropped_why: Vec<ByName<DropReason>>,
    /// Overhang with which each entry of `dropped` could be cut, mm. Absent where there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    dropped_stick_out: Vec<Option<f64>>,
}

/// One plunge; lengths in mm, angles in degrees, part frame.
#[derive(Serialize, Deserialize)]
struct PositionRecord {
    section: usize,
    row: usize,
    s: f64,
    lambda: f64,
    tip: [f64; 3],
    axis: [f64; 3],
    retract: [f64; 3],
    contact_point: [f64; 3],
    alpha: f64,
    contact_depth: f64,
    contact_area: f64,
    /// Absent in files of earlier versions.
    #[serde(default)]
    lift: f64,
    blocked: Option<ByName<Blocked>>,
    #[serde(default)]
    held: Option<ByName<LimitedBy>>,
    hub_clearance: f64,
    blade_clearance: f64,
    retract_clearance: f64,
    /// Engaged arcs, degrees: the largest over the plunge, and that at its end. Absent in files of earlier
    /// versions, as all that follows.
    #[serde(default)]
    engaged_arc: f64,
    #[serde(default)]
    bottom_arc: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    towards_stock: [f64; 3],
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    interrupted: bool,
    /// Feed rate where it is not that of the tool, mm/min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    feed: Option<f64>,
    /// Way off the stock at the end, mm.
    #[serde(default, alias = "lift_off", skip_serializing_if = "is_zero")]
    lead_out: [f64; 3],
    /// Height at which it enters the blank, and depth between two interruptions, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    peck: Option<[f64; 2]>,
    /// Height above the tip at which the rapid down ends, where that is below the retract point, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    approach: Option<f64>,
}

/// Has a plan file hold these by their name.
macro_rules! by_name {
    ($($kind:ty),*) => {
        $(impl Named for $kind {
            const ALL: &[Self] = &Self::ALL;

            fn name(self) -> &'static str {
                self.name()
            }
        })*
    };
}

by_name!(StopReason, DropReason, Blocked, LimitedBy);

/// Whether a direction is absent.
fn is_zero(direction: &[f64; 3]) -> bool {
    direction.iter().all(|x| *x == 0.0)
}

impl PositionRecord {
    fn new(p: &Position) -> Self {
        let Evaluation { contact, retract, retract_clearance, engagement, motion, breach: _ } = p.evaluation;
        Self {
            section: p.section,
            row: p.row,
            s: p.s,
            lambda: p.lambda,
            tip: p.tip.coords.into(),
            axis: p.axis.into(),
            retract: retract.coords.into(),
            contact_point: p.contact_point.coords.into(),
            alpha: p.alpha_rad.to_degrees(),
            contact_depth: contact.depth,
            contact_area: contact.area_share,
            lift: p.lift,
            blocked: p.blocked.map(ByName),
            held: p.limited_by.map(ByName),
            hub_clearance: p.hub_clearance,
            blade_clearance: p.blade_clearance,
            retract_clearance,
            engaged_arc: engagement.max_arc_rad.to_degrees(),
            bottom_arc: engagement.bottom_arc_rad.to_degrees(),
            towards_stock: engagement.towards_stock.into(),
            interrupted: engagement.is_interrupted,
            feed: motion.feed_mm_per_min,
            lead_out: motion.lead_out.into(),
            peck: motion.pecking.map(|pecking| [pecking.from, pecking.depth]),
            approach: motion.approach,
        }
    }

    /// The position of a plan with this many sections; `None` if the record is damaged.
    fn position(&self, sections: usize) -> Option<Position> {
        let moved =
            self.lead_out.iter().chain(self.peck.iter().flatten()).chain(&self.feed).chain(&self.approach);
        let is_sound =
            are_coordinates(self.tip.iter().chain(&self.retract).chain(moved)) && self.section < sections;
        Some(Position {
            tip: stored::point(self.tip),
            axis: stored::unit_axis(self.axis).filter(|_| is_sound)?,
            section: self.section,
            row: self.row,
            s: self.s,
            lambda: self.lambda,
            alpha_rad: self.alpha.to_radians(),
            contact_point: stored::point(self.contact_point),
            lift: self.lift,
            blocked: self.blocked.map(|ByName(why)| why),
            limited_by: self.held.map(|ByName(cause)| cause),
            hub_clearance: self.hub_clearance,
            blade_clearance: self.blade_clearance,
            evaluation: Evaluation {
                contact: CoreContact { depth: self.contact_depth, area_share: self.contact_area },
                retract: stored::point(self.retract),
                retract_clearance: self.retract_clearance,
                engagement: Engagement {
                    max_arc_rad: self.engaged_arc.to_radians(),
                    bottom_arc_rad: self.bottom_arc.to_radians(),
                    towards_stock: self.towards_stock.into(),
                    is_interrupted: self.interrupted,
                },
                motion: PlungeMotion {
                    feed_mm_per_min: self.feed.filter(|feed| *feed > 0.0),
                    lead_out: self.lead_out.into(),
                    pecking: self
                        .peck
                        .filter(|[from, depth]| *from > 0.0 && *depth > 0.0)
                        .map(|[from, depth]| Pecking { from, depth }),
                    approach: self.approach.filter(|height| *height > 0.0),
                },
                // It follows from the setup.
                breach: None,
            },
        })
    }
}

/// A plan read back.
#[derive(Debug)]
pub struct StoredPlan {
    /// Description of the part when the plan was made.
    pub description: PartDescription,
    /// The part built from it.
    pub part: Impeller,
    /// The setup the plan was made with.
    pub setup: Setup,
    /// The plan.
    pub plan: PlungePlan,
    /// Number of channels that it is repeated for.
    pub channels: usize,
}

impl StoredPlan {
    /// Its program, for all channels that it is repeated for.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    pub fn program(&self, monitor: &Monitor) -> Result<ClProgram, Cancelled> {
        let channels = self.channels.clamp(1, self.part.blade_count);
        let allowances = &self.setup.allowances;
        let blank = allowances.blank_of(&self.part);
        let plan = plan_channels(&self.plan, &self.part, &blank, &self.setup, channels, monitor)?;
        Ok(ClProgram::of_plan(&self.part.name, &plan))
    }
}

/// Writes a plan file (JSON); lengths in mm, angles in degrees, part frame. `channels` is the number of
/// channels that the plan is repeated for.
pub fn write_plan(
    description: &PartDescription,
    setup: &Setup,
    plan: &PlungePlan,
    channels: usize,
) -> String {
    // It may have been made by another strategy than that of the setup.
    let mut setup = setup.clone();
    setup.plunge.axis = plan.policy;
    let file = PlanRecord {
        vanecut_plan: VERSION,
        part: write_native(description),
        setup: write_full_setup(&setup),
        policy: plan.policy,
        channels,
        rounds: plan.iterations,
        settled: plan.converged,
        rows: plan.sections.iter().map(|s| s.rows).collect(),
        directions: plan.sections.iter().map(|s| s.feed).collect(),
        added: plan
            .sections
            .iter()
            .map(|s| s.added.map(|added| (added.count, ByName(added.stopped))))
            .collect(),
        positions: plan.positions.iter().map(PositionRecord::new).collect(),
        dropped: plan.dropped.iter().map(|d| (d.section, d.row, d.s)).collect(),
        dropped_why: plan.dropped.iter().map(|d| ByName(d.why)).collect(),
        dropped_stick_out: match plan.dropped.iter().any(|d| d.stick_out.is_some()) {
            true => plan.dropped.iter().map(|d| d.stick_out).collect(),
            false => Vec::new(),
        },
    };
    let mut text = serde_json::to_string_pretty(&file).unwrap_or_default();
    text.push('\n');
    text
}

/// Reads a plan file; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not a plan file of a supported version, or hold unusable values.
pub fn read_plan_bytes(name: &str, bytes: &[u8]) -> Result<StoredPlan, InputError> {
    let help = "give a plan.json that `vanecut plan` wrote";
    let source = Source::new(name, ErrorCode::PlanFile);
    let file: PlanRecord =
        serde_json::from_slice(bytes).map_err(|e| source.not_json(&e, "a plan file", help))?;
    stored::check_version(name, "plan file", file.vanecut_plan, VERSION)?;
    let StoredInputs { description, part, setup } =
        stored::read_inputs(name, &file.part, &file.setup, Some(file.policy))?;
    let mut sections = Vec::new();
    for (index, section) in setup.plunge.sections.iter().enumerate() {
        sections.push(SectionPlan {
            tool: tool_of(&setup, section.tool)
                .map_err(|e| damaged(name, e.message).with_code(ErrorCode::UndefinedTool))?
                .clone(),
            from: section.from,
            to: section.to,
            feed: file.directions.get(index).copied().unwrap_or_else(|| section.direction()),
            rows: file.rows.get(index).copied().unwrap_or(0),
            kind: section.kind,
            added: file
                .added
                .get(index)
                .copied()
                .flatten()
                .map(|(count, ByName(stopped))| AddedPlunges { count, stopped }),
        });
    }
    let mut positions = Vec::with_capacity(file.positions.len());
    for (index, record) in file.positions.iter().enumerate() {
        let position = record.position(sections.len());
        let mut position =
            position.ok_or_else(|| damaged(name, format!("position {} is damaged", index + 1)))?;
        position.evaluation.breach = position.breach(&part, &setup);
        positions.push(position);
    }
    let why =
        file.dropped_why.into_iter().map(|ByName(why)| why).chain(std::iter::repeat(DropReason::Blades));
    let stick_out = file.dropped_stick_out.into_iter().chain(std::iter::repeat(None));
    let dropped = file.dropped.into_iter().zip(why).zip(stick_out);
    let plan = PlungePlan {
        policy: file.policy,
        sections,
        positions,
        dropped: dropped
            .map(|(((section, row, s), why), stick_out)| Dropped { section, row, s, why, stick_out })
            .collect(),
        iterations: file.rounds,
        converged: file.settled,
    };
    Ok(StoredPlan { description, part, setup, plan, channels: file.channels })
}

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use super::*;

    fn assert_read_back<T: Named + Debug + PartialEq>() {
        for value in T::ALL {
            let text = serde_json::to_string(&ByName(*value)).expect("a name");
            let ByName(read) = serde_json::from_str::<ByName<T>>(&text).expect("known");
            assert_eq!(read, *value, "{text}");
        }
    }

    #[test]
    fn names_are_read_back_and_others_are_refused() {
        assert_read_back::<StopReason>();
        assert_read_back::<DropReason>();
        assert_read_back::<Blocked>();
        assert_read_back::<LimitedBy>();
        let error = serde_json::from_str::<ByName<Blocked>>("\"wind\"").err().expect("unknown").to_string();
        assert!(error.contains("`wind`; known: walls, shroud_end, tilt_limit"), "{error}");
    }
}
