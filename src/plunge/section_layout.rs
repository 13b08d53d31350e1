//! Layout of a section: its stretches of the passages, the wall axes of the cutter in them and the λ of its
//! rows. It does not depend on the policy, so all policies share it.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::error::PlanError;
use super::lane::Lane;
use super::row::{Runs, Station};
use super::row_density::RowDensity;
use super::spacing::max_shroud_spacing;
use crate::cutting::drop_cutter::DepthSurface;
use crate::part::{Division, Passage, Workpiece};
use crate::setup::{SectionSetup, Setup, Tool, tool_of};

/// Layout of one stretch for one cutter, shared by all policies.
#[derive(Debug)]
pub(super) struct StretchLayout<'a> {
    pub stretch: PassageStretch<'a>,
    pub lane: Lane<'a>,
    /// Hub, offset by allowance and corner radius.
    pub hub: DepthSurface<'a>,
    pub rows: Vec<RowLayout>,
}

/// A row of a stretch, with caches of its conventional stations.
#[derive(Debug)]
pub(super) struct RowLayout {
    /// λ within the stretch.
    pub lambda: f64,
    /// Conventional first stations, by s.
    pub firsts: Memo<Option<Station>>,
    /// Cuttable stretches of the row, by s of its start.
    pub runs: Memo<Runs>,
    /// Conventional rows, by s of their start.
    pub conventional: Memo<Vec<Station>>,
}

/// Thread-safe cache keyed by s.
#[derive(Debug)]
pub(super) struct Memo<T>(Mutex<Vec<(f64, T)>>);

impl<T: Clone> Memo<T> {
    fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// The value at `s`, computed by `make` on the first call. The lock is held meanwhile, so `make` must not
    /// start work on other threads.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get_or_make<E>(&self, s: f64, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, answer)) = known.iter().find(|(at, _)| *at == s) {
            return Ok(answer.clone());
        }
        let answer = make()?;
        known.push((s, answer.clone()));
        Ok(answer)
    }
}

/// A stretch of a passage that one section cuts.
#[derive(Debug)]
pub(super) struct PassageStretch<'a> {
    pub passage: &'a Passage,
    /// λ of the passage's walls across the whole channel.
    pub lambdas: (f64, f64),
    /// s of the outlet end.
    pub from: f64,
    /// s of the inlet end.
    pub to: f64,
}

impl PassageStretch<'_> {
    /// s at `share` (0…1) of the distance from the outlet end to the inlet end.
    pub fn s_at(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }

    /// λ across the whole channel of a row at `lambda` of the stretch.
    pub fn lambda_in_channel(&self, lambda: f64) -> f64 {
        self.lambdas.0 + lambda * (self.lambdas.1 - self.lambdas.0)
    }
}

/// What the layout of a section follows from.
struct SectionGround<'a, 's> {
    workpiece: &'a Workpiece,
    setup: &'s Setup,
    tool: &'s Tool,
    density: RowDensity,
}

impl<'a> SectionGround<'a, '_> {
    /// The stretches of a section, outlet end first.
    fn stretches(&self, section: &SectionSetup) -> Vec<PassageStretch<'a>> {
        let whole = PassageStretch {
            passage: &self.workpiece.channel.full,
            lambdas: (0.0, 1.0),
            from: section.from,
            to: section.to,
        };
        self.divided(whole, self.workpiece.channel.division.as_deref())
    }

    /// The stretches into which `division` divides the stretch `whole` of a passage.
    fn divided(&self, whole: PassageStretch<'a>, division: Option<&'a Division>) -> Vec<PassageStretch<'a>> {
        let Some(division) = division else { return vec![whole] };
        let [hub, shroud] = division.s;
        let PassageStretch { from, to, .. } = whole;
        // The passages join upstream of the splitter's nose by the radius and allowance of the cutter.
        let reach =
            (self.tool.radius() + self.setup.allowances.blade_allowance) / self.workpiece.part.hub.length();
        let nose = (hub.min(shroud) - reach).max(0.0);
        let mut stretches = Vec::new();
        let mut joined = nose;
        if from > nose {
            let s = 0.5 * (from.min(1.0) + to).max(hub.max(shroud));
            let lambdas = self.lambdas_beside(division, whole.lambdas, s);
            for ((&passage, lambdas), inner) in division.passages.iter().zip(lambdas).zip(&division.inner) {
                let passage = &self.workpiece.channel.passages[passage];
                // Upstream of the nose the extended flanks may converge; the rows end where the cutter no
                // longer fits.
                let to = self.fits_until(passage, to.max(nose), hub.min(shroud));
                joined = joined.max(to);
                stretches
                    .extend(self.divided(PassageStretch { passage, lambdas, from, to }, inner.as_deref()));
            }
        }
        if to < joined {
            stretches.push(PassageStretch { from: from.min(joined), ..whole });
        }
        stretches
    }

    fn lane(&self, passage: &'a Passage) -> Lane<'a> {
        Lane::new(self.workpiece, passage, self.tool, &self.setup.allowances)
    }

    /// The s down to which the cutter fits in `passage` when going inwards from `from`, at most to `to`.
    fn fits_until(&self, passage: &'a Passage, to: f64, from: f64) -> f64 {
        let lane = self.lane(passage);
        let steps = 16;
        let mut open = from.max(to);
        for i in 1..=steps {
            let s = from + (to - from) * f64::from(i) / f64::from(steps);
            if s >= from || lane.wall_pair(s, s).is_none() {
                break;
            }
            open = s;
        }
        open
    }

    /// λ across the whole channel of the passages beside a splitter, by the angles of their feet at `s`;
    /// those of the passage that it divides are `(low, high)`.
    fn lambdas_beside(&self, division: &Division, (low, high): (f64, f64), s: f64) -> [(f64, f64); 2] {
        let angles = |p: &Passage| p.wall_angles(&self.workpiece.part, s, 0.0);
        let [near, far] = division.passages.map(|passage| angles(&self.workpiece.channel.passages[passage]));
        let (near, far) = match (angles(&self.workpiece.channel.full), near, far) {
            (Some(full), Some(near), Some(far)) => {
                let width = full[1] - full[0];
                (
                    (low + (near[1] - near[0]) / width).clamp(low, high),
                    (high - (far[1] - far[0]) / width).clamp(low, high),
                )
            }
            _ => (0.5 * (low + high), 0.5 * (low + high)),
        };
        [(low, near), (far, high)]
    }

    /// λ of the rows of a stretch: both walls, and between them equal gaps that exceed neither the stepover
    /// on the hub nor the distance that leaves uncut stock at the shroud. Empty where the cutter fits
    /// nowhere.
    fn row_lambdas(&self, lane: &Lane, stretch: &PassageStretch) -> Vec<f64> {
        let spacing = self.density.stepover(&self.setup.plunge, self.tool);
        let widths: Vec<Option<(f64, f64)>> =
            (0..=8).into_par_iter().map(|i| lane.width(stretch.s_at(f64::from(i) / 8.0))).collect();
        let mut gaps = 0.0f64;
        let mut widest = 0.0f64;
        if widths.iter().all(Option::is_none) {
            return Vec::new();
        }
        for (hub, shroud) in widths.into_iter().flatten() {
            gaps = gaps.max(hub / spacing).max(shroud / max_shroud_spacing(self.tool));
            widest = widest.max(hub);
        }
        if widest < 0.1 * self.tool.radius() {
            return vec![0.5];
        }
        let count = (gaps - 1e-9).ceil().clamp(1.0, 400.0) as usize;
        (0..=count).map(|i| i as f64 / count as f64).collect()
    }
}

/// Layout of a section, with rows of this `density`.
///
/// # Errors
/// When the section's tool is missing.
pub(super) fn section_layout<'a>(
    workpiece: &'a Workpiece,
    setup: &Setup,
    section: &SectionSetup,
    density: RowDensity,
) -> Result<Vec<StretchLayout<'a>>, PlanError> {
    let tool = tool_of(setup, section.tool)?;
    let ground = SectionGround { workpiece, setup, tool, density };
    let layouts = ground.stretches(section).into_iter().map(|stretch| {
        let lane = ground.lane(stretch.passage);
        let floor = setup.allowances.hub_allowance + tool.corner_radius;
        let hub = DepthSurface::new(workpiece.part.hub.curve(), floor);
        let rows = ground.row_lambdas(&lane, &stretch).into_iter().map(|lambda| RowLayout {
            lambda,
            firsts: Memo::new(),
            runs: Memo::new(),
            conventional: Memo::new(),
        });
        Ok(StretchLayout { rows: rows.collect(), stretch, lane, hub })
    });
    layouts.collect()
}
