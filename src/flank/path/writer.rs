//! Writes the moves of passes one after another, with those between them.

use super::approach::ApproachStep;
use super::entry::{EntryFinder, EntryMoves, PassEnd, positions_from};
use super::inputs::{LayerPasses, Pass, PathMaker};
use super::moves::{FlankMove, MoveKind, MoveOrigin, Program, RAPID_MARGIN, is_same};
use crate::cutting::link::LinkMove;
use crate::cutting::retract::NearBottom;
use crate::flank::strategies::PassRole;
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::toolpath::RAPID_MM_PER_MIN;

/// Maximum number of iterations that raise the ends of a rapid until it is clear.
const MAX_RAISE_ITERATIONS: usize = 30;

/// A program while it is written.
pub(super) struct ProgramWriter<'a> {
    maker: &'a PathMaker<'a>,
    entries: EntryFinder<'a>,
    moves: Vec<FlankMove>,
    /// One per move.
    origins: Vec<MoveOrigin>,
    /// The end of the last pass, on the layer being written.
    at: Option<PassEnd>,
    /// Indices of the rapids from above the end of a pass to above the start of the next.
    rapids: Vec<usize>,
}

impl<'a> ProgramWriter<'a> {
    /// Before the first pass.
    pub(super) fn new(maker: &'a PathMaker<'a>) -> Self {
        Self {
            maker,
            entries: EntryFinder::new(maker),
            moves: Vec::new(),
            origins: Vec::new(),
            at: None,
            rapids: Vec::new(),
        }
    }

    /// Begins a layer.
    pub(super) fn begin_layer(&mut self) {
        self.at = None;
        self.entries.begin_layer();
    }

    /// The program, with all rapids clear of the blank.
    ///
    /// # Errors
    /// When the monitor is cancelled.
    pub(super) fn finish(mut self, monitor: &Monitor) -> Result<Program, Cancelled> {
        self.retract();
        self.raise_rapids(monitor)?;
        Ok(Program { moves: self.moves, origins: self.origins })
    }

    fn push(&mut self, step: FlankMove, origin: MoveOrigin) {
        self.moves.push(step);
        self.origins.push(origin);
    }

    /// Writes `pass`, given the indices of its layer and of itself.
    pub(super) fn write_pass(
        &mut self,
        layer: &LayerPasses,
        pass: &Pass,
        (index, number): (usize, usize),
        feed: f64,
    ) {
        let entry = self.entries.entry(layer, pass, self.at, feed);
        let reversed = entry.end == 1;
        let count = pass.positions.len();
        let positions = positions_from(pass, entry.end);
        let about = |kind: MoveKind, (tip, axis): (Point, Vector)| FlankMove {
            kind,
            tip,
            axis,
            feed_mm_per_min: if kind == MoveKind::Rapid { RAPID_MM_PER_MIN } else { feed },
            layer: layer.number,
            region: pass.region,
            along_wall: matches!(pass.role, PassRole::Wall(_)),
        };
        let in_pass = |k: usize| if reversed { count - 1 - k } else { k };
        let origin = |k: usize| MoveOrigin {
            layer: index,
            pass: number,
            to: in_pass(k),
            from: None,
            is_beside: false,
        };
        match entry.moves {
            EntryMoves::Link(link) => {
                link.into_iter().for_each(|p| self.push(about(MoveKind::Link, p), origin(0)));
            }
            EntryMoves::Descent { above, steps, link } => {
                self.retract();
                let over = |k: usize| MoveOrigin { is_beside: !link.is_empty(), ..origin(k) };
                let above = about(MoveKind::Rapid, above);
                if !self.moves.is_empty() {
                    self.rapids.push(self.moves.len());
                    self.push(above, over(0));
                }
                self.push(above, over(0));
                for ApproachStep { position, over: k, feed: kind } in steps {
                    let step = about(MoveKind::Approach, position);
                    let feed_mm_per_min = self.maker.approach_feed(kind, feed);
                    self.push(FlankMove { feed_mm_per_min, ..step }, over(k));
                }
                let feed_mm_per_min = self.maker.link_feed(feed);
                for &position in &link {
                    let step = about(MoveKind::Link, position);
                    self.push(FlankMove { feed_mm_per_min, ..step }, over(0));
                }
            }
        }
        for (k, &p) in positions.iter().enumerate().skip(1) {
            self.push(about(MoveKind::Cut, p), MoveOrigin { from: Some(in_pass(k - 1)), ..origin(k) });
        }
        self.at = positions.last().map(|&position| PassEnd { place: pass.ends[1 - entry.end], position });
        self.entries.add_cut(pass);
    }

    /// Retracts along the axis until the bottom of the tool is clear of the blank.
    fn retract(&mut self) {
        let Some(&last) = self.moves.last() else { return };
        if last.kind != MoveKind::Rapid {
            let tip = self.entries.above((last.tip, last.axis));
            if let Some(&origin) = self.origins.last() {
                self.push(
                    FlankMove { kind: MoveKind::Rapid, tip, feed_mm_per_min: RAPID_MM_PER_MIN, ..last },
                    origin,
                );
            }
        }
        self.at = None;
    }

    /// Raises both ends of every rapid until the bottom of the tool stays clear of the blank all along.
    ///
    /// # Errors
    /// When the monitor is cancelled.
    fn raise_rapids(&mut self, monitor: &Monitor) -> Result<(), Cancelled> {
        let rapids = std::mem::take(&mut self.rapids);
        for round in 0..MAX_RAISE_ITERATIONS {
            let mut clear = true;
            for &k in &rapids {
                monitor.check()?;
                let short = self.missing_clearance(k);
                if short > 0.0 {
                    clear = false;
                    let lift = (1.0 + 0.3 * round as f64) * short + 0.25 * self.maker.safety_distance + 1e-3;
                    for end in [k - 1, k] {
                        let axis = self.moves[end].axis;
                        self.moves[end].tip += axis * lift;
                    }
                }
            }
            if clear {
                break;
            }
        }
        self.drop_repeated_positions();
        Ok(())
    }

    /// Removes the moves of no length: a rapid that was not raised ends where the approach begins, and a
    /// curve may be split at one of its points.
    fn drop_repeated_positions(&mut self) {
        let mut last: Option<FlankMove> = None;
        let is_kept = |step: &FlankMove| {
            let moves = last.is_none_or(|last| !is_same((last.tip, last.axis), (step.tip, step.axis)));
            if moves {
                last = Some(*step);
            }
            moves
        };
        let kept: Vec<bool> = self.moves.iter().map(is_kept).collect();
        let (mut of_moves, mut of_origins) = (kept.iter().copied(), kept.iter().copied());
        self.moves.retain(|_| of_moves.next().unwrap_or(true));
        self.origins.retain(|_| of_origins.next().unwrap_or(true));
    }

    /// Missing clearance of the tool bottom above the blank on the rapid to move `k`, mm; not positive where
    /// it is clear.
    fn missing_clearance(&self, k: usize) -> f64 {
        let PathMaker { tool, blank, .. } = *self.maker;
        let [from, to] = [k - 1, k].map(|k| (self.moves[k].tip, self.moves[k].axis));
        let [start, end] =
            [from, to].map(|(tip, axis)| NearBottom::from_cutter(&tool.placed(tip, axis), blank));
        let wanted = self.maker.safety_distance + RAPID_MARGIN;
        let between = LinkMove { tool, blank, from, to }.clearance([&start, &end], wanted);
        wanted - between.min(start.clearance).min(end.clearance)
    }
}
