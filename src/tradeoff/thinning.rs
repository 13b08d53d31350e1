//! The order in which plunges are left out of a plan: lazy greedy.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};
use std::sync::{Mutex, PoisonError};

use super::clock::PlanClock;
use super::cores::Cores;
use super::floor::{FloorChange, ThinnedFloor};
use super::limits::ThinningLimits;
use super::neighbours::KeptNeighbours;
use super::walls::WallRows;
use crate::cutting::contact::Columns;
use crate::monitor::{Cancelled, Monitor};
use crate::part::Blank;
use crate::plunge::{PlungePlan, Position};
use crate::setup::{PlungePose, SectionKind, Setup};
use crate::stock::{FloorGrid, ResidualStatistics, field_cutters, statistics};

/// Time that leaving a plunge out saves at least, s: a divisor.
const MIN_SAVED: f64 = 1e-3;
/// Plunges left out between two checks of the monitor.
const CHECK_EVERY: usize = 16;

/// What a plan is thinned with.
#[derive(Clone, Copy, Debug)]
pub struct ThinningInput<'a> {
    /// The whole plan of one channel.
    pub plan: &'a PlungePlan,
    /// Its setup.
    pub setup: &'a Setup,
    /// The blank before the first cut.
    pub blank: &'a Blank,
    /// The floor of the channel.
    pub grid: &'a FloorGrid,
    /// How far plunges may go.
    pub limits: ThinningLimits,
    /// Plunges that stay: the user locked them.
    pub locked: &'a [PlungePose],
    /// What tells the time of plans.
    pub clock: &'a PlanClock,
}

/// The plunges of a plan in the order in which they can be left out.
pub struct Thinning<'a> {
    input: ThinningInput<'a>,
    floor: ThinnedFloor<'a>,
    cores: Cores<'a>,
    /// Share of the reachable floor that the plan with all its plunges leaves uncut.
    uncut_share: f64,
    /// Plunges that can be left out, the first one first.
    order: Vec<usize>,
    /// Whether a stop ended the search for it.
    is_cut_short: bool,
    /// Times computed so far, by the number of plunges left out.
    times_s: Mutex<HashMap<usize, f64>>,
}

impl<'a> Thinning<'a> {
    /// Finds the order, down to where nothing more can be left out or the limit of `input` is reached.
    ///
    /// # Errors
    /// When `monitor` is cancelled. After a stop the order ends early.
    pub fn new(input: ThinningInput<'a>, monitor: &Monitor) -> Result<Self, Cancelled> {
        let cutters = field_cutters(input.plan);
        let floor = ThinnedFloor::new(input.grid, &cutters, input.setup.allowances.hub_allowance);
        let cores = Cores::new(input.plan, input.blank);
        let uncut_share = floor.uncut_share_with(0.0);
        let (order, times_s) = (Vec::new(), Mutex::default());
        let mut thinning = Self { input, floor, cores, uncut_share, order, is_cut_short: false, times_s };
        thinning.find_order(monitor)?;
        Ok(thinning)
    }

    /// Lazy greedy: the price of a plunge, stock per second, only rises as others go, so the cheapest of the
    /// queue is the cheapest of all once its price is up to date. A plunge that the core of a later one needs
    /// waits until that one goes; one that floor or wall need stays.
    fn find_order(&mut self, monitor: &Monitor) -> Result<(), Cancelled> {
        let plunges = self.input.plan.positions.len();
        let mut kept = vec![true; plunges];
        let mut rows = KeptNeighbours::unlinked(plunges);
        rows.link(&(0..plunges).collect::<Vec<_>>());
        let input = self.input;
        let mut walls = WallRows::new(input.plan, input.setup);
        let max_uncut = self.max_uncut_share();
        let price = |change: &FloorChange, rows: &KeptNeighbours, plunge: usize| {
            change.cost / input.saved_time(rows, plunge).max(MIN_SAVED)
        };
        let candidate = |floor: &ThinnedFloor, rows: &KeptNeighbours, plunge: usize| QueuedPlunge {
            price: price(&floor.change_without(plunge), rows, plunge),
            plunge,
        };
        // Those above the shroud make room for shank and holder of the others.
        let plan = input.plan;
        let opens =
            |&plunge: &usize| plan.sections[plan.positions[plunge].section].kind == SectionKind::Opening;
        let mut queue: BinaryHeap<QueuedPlunge> = (0..plunges)
            .filter(|plunge| !opens(plunge) && !input.is_locked(*plunge))
            .map(|plunge| candidate(&self.floor, &rows, plunge))
            .collect();
        let mut order = Vec::new();
        // Plunges that the core of each one needs.
        let mut waiting: Vec<Vec<usize>> = vec![Vec::new(); plunges];
        while let Some(QueuedPlunge { price: before, plunge }) = queue.pop() {
            if monitor.is_stopped() {
                self.is_cut_short = true;
                break;
            }
            let change = self.floor.change_without(plunge);
            let now = price(&change, &rows, plunge);
            if now > before && queue.peek().is_some_and(|next| next.price < now) {
                queue.push(QueuedPlunge { price: now, plunge });
                continue;
            }
            if self.floor.uncut_share_with(change.uncut_area) > max_uncut
                || self.floor.rise_with(&change) > input.limits.max_mean_rise
                || !walls.stay_smooth_without(plunge)
            {
                continue;
            }
            if let Err(later) = self.cores.leave_out(plunge, &mut kept) {
                waiting[later].push(plunge);
                continue;
            }
            self.floor.leave_out(plunge, &change);
            rows.leave_out(plunge);
            walls.leave_out(plunge);
            order.push(plunge);
            for freed in std::mem::take(&mut waiting[plunge]) {
                queue.push(candidate(&self.floor, &rows, freed));
            }
            if order.len() % CHECK_EVERY == 0 {
                monitor.check()?;
            }
        }
        self.order = order;
        monitor.check()
    }

    /// Stock that must stay on the hub, mm.
    pub(super) fn hub_allowance(&self) -> f64 {
        self.input.setup.allowances.hub_allowance
    }

    /// The plan with all its plunges.
    pub fn plan(&self) -> &'a PlungePlan {
        self.input.plan
    }

    /// Share of the reachable floor that the plan with all its plunges leaves uncut.
    pub(super) fn uncut_share(&self) -> f64 {
        self.uncut_share
    }

    /// Share of the floor that may be uncut when plunges are left out.
    pub fn max_uncut_share(&self) -> f64 {
        self.input.limits.max_uncut_share(self.uncut_share)
    }

    /// Whether a stop ended the search for the order: more plunges may be left out.
    pub fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }

    /// Number of plunges that can be left out.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether no plunge can be left out.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The columns of the plunges that are kept.
    pub fn columns_of(&self, kept: &[bool]) -> Columns {
        self.cores.columns_of(kept)
    }

    /// Whether each plunge is kept when the first `count` are left out.
    pub fn kept_without(&self, count: usize) -> Vec<bool> {
        let mut kept = vec![true; self.input.plan.positions.len()];
        for &plunge in self.order.iter().take(count) {
            kept[plunge] = false;
        }
        kept
    }

    /// Time of the plan without the first `count` plunges, s, before links are raised anew.
    pub fn time_without(&self, count: usize) -> f64 {
        let mut times_s = self.times_s.lock().unwrap_or_else(PoisonError::into_inner);
        *times_s.entry(count).or_insert_with(|| self.find_time_without(count))
    }

    fn find_time_without(&self, count: usize) -> f64 {
        let plan = self.input.plan;
        let kept = self.kept_without(count);
        let positions =
            plan.positions.iter().zip(kept).filter(|(_, kept)| *kept).map(|(p, _)| p.clone()).collect();
        self.input.clock.time_s(&PlungePlan { positions, ..plan.clone() })
    }

    /// Stock that stays when the first `count` plunges are left out.
    pub fn stock_without(&self, count: usize) -> ResidualStatistics {
        let kept = self.kept_without(count);
        statistics(self.input.grid, &self.floor.heights(|plunge| kept[plunge]), |_| true)
    }
}

impl ThinningInput<'_> {
    /// Whether the user locked `plunge`.
    fn is_locked(&self, plunge: usize) -> bool {
        let Position { tip, axis, .. } = self.plan.positions[plunge];
        self.locked.iter().any(|locked| locked.is(&PlungePose { tip, axis }))
    }

    /// Time saved by leaving `plunge` out, s: its cut, its retract, and the links to and from it less the one
    /// that takes their place.
    fn saved_time(&self, rows: &KeptNeighbours, plunge: usize) -> f64 {
        let plan = self.plan;
        let position = &plan.positions[plunge];
        let tool_of = |p: &Position| &plan.sections[p.section].tool;
        let tool = tool_of(position);
        let depth = (position.evaluation.retract - position.tip).norm();
        let same_tool = |k: Option<usize>| {
            k.map(|k| &plan.positions[k]).filter(|other| tool_of(other).number == tool.number)
        };
        let (previous, next) = (same_tool(rows.before(plunge)), same_tool(rows.after(plunge)));
        let link = |a: Option<&Position>, b: Option<&Position>| {
            a.zip(b).map_or(0.0, |(a, b)| self.clock.link_s(a, b))
        };
        let links = link(previous, Some(position)) + link(Some(position), next) - link(previous, next);
        60.0 * (depth / plan.feed_of(plunge) + depth / self.clock.link_rate()) + links
    }
}

/// A plunge in the queue, cheapest first; ties by number, so that the order does not depend on the heap.
struct QueuedPlunge {
    price: f64,
    plunge: usize,
}

impl Ord for QueuedPlunge {
    fn cmp(&self, other: &Self) -> Ordering {
        other.price.total_cmp(&self.price).then(other.plunge.cmp(&self.plunge))
    }
}

impl PartialOrd for QueuedPlunge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QueuedPlunge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for QueuedPlunge {}
