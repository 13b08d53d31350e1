//! Repairs what a check of all moves of a program rejects: positions that cut a little below the allowance of
//! a blade are moved off it; of the rest, pieces of passes are removed, or the links of a layer.

use std::collections::{BTreeMap, BTreeSet};

use super::layer::LayerPoint;
use super::passes::is_open;
use super::path::{FlankMove, LayerPasses, MoveKind, MoveOrigin, Pass, PathMaker, Program, path_length};
use super::uncut::{UncutLength, UncutReason};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::setup::Tool;

/// A move that the check rejects.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveFault {
    /// Index in the program.
    pub index: usize,
    /// Why it is not cut.
    pub why: UncutReason,
    /// How far it cuts below the allowance of a blade, mm; `None` where something else is wrong.
    pub overcut: Option<f64>,
    /// The overhang with which a holder in the way would be clear, mm.
    pub overhang: Option<f64>,
}

/// Why a piece of a pass is removed, and the overhang with which it could be cut, mm.
type RemovalCause = (UncutReason, Option<f64>);

/// Unit direction across the axis in which a cutter, given by tip and axis, gets off the nearest blade, and
/// the length of the way for each mm of distance from it; `None` where there is none.
pub(super) type WayOffBlades<'a> = dyn Fn(Point, Vector) -> Option<(Vector, f64)> + 'a;

/// Checks the moves of a tool and returns the rejected ones, or [`Cancelled`].
pub type MoveCheck<'a> = dyn FnMut(&Tool, &[FlankMove], &Monitor) -> Result<Vec<MoveFault>, Cancelled> + 'a;

/// A program after the check.
pub(super) struct CheckedMoves {
    pub(super) moves: Vec<FlankMove>,
    pub(super) left_out: Vec<UncutLength>,
    /// Faults that remain after the last iteration.
    pub(super) faults: Vec<MoveFault>,
}

/// Overcut up to which positions are moved off the blade instead of being removed, mm: what stays on the
/// blade then is much less than where a piece of a pass is missing.
const MAX_MOVED_OVERCUT: f64 = 0.05;
/// Overcut that is left where they are moved, mm.
const OVERCUT_LEFT: f64 = 0.0045;
/// Iterations that move positions.
const MOVE_ITERATIONS: usize = 6;
/// Iterations that remove pieces of passes; later ones remove whole passes.
const PIECE_ITERATIONS: usize = 10;
/// Iterations after which a layer with a rejected link loses all its links.
const LINK_ITERATIONS: usize = 2;
/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 24;

/// The program of `layers`, given in cutting order, without what `check` rejects: iterates repair and check.
/// `lead_in_out` is the length of lead-in and lead-out, mm.
///
/// # Errors
/// When the monitor is cancelled.
pub(super) fn remove_faults(
    path: &PathMaker,
    layers: &mut [LayerPasses],
    lead_in_out: f64,
    way_off_blades: &WayOffBlades,
    check: &mut MoveCheck,
    monitor: &Monitor,
) -> Result<CheckedMoves, Cancelled> {
    let mut left_out = Vec::new();
    let (mut moves, mut round) = (0, 0);
    loop {
        let program = path.program(layers, monitor)?;
        let mut faults = check(path.tool, &program.moves, monitor)?;
        if faults.is_empty() || round == MAX_ITERATIONS {
            return Ok(CheckedMoves { moves: program.moves, left_out, faults });
        }
        if moves < MOVE_ITERATIONS && move_off_blades(layers, &program, &mut faults, way_off_blades) {
            moves += 1;
        }
        if !faults.is_empty() {
            remove_faulty_moves(layers, &program, &faults, round, lead_in_out, &mut left_out);
            round += 1;
        }
    }
}

/// Moves the positions at both ends of moves that cut a little below the allowance of a blade off it, and
/// takes these from `faults`. Returns whether there were any.
fn move_off_blades(
    layers: &mut [LayerPasses],
    program: &Program,
    faults: &mut Vec<MoveFault>,
    way_off_blades: &WayOffBlades,
) -> bool {
    // The longest way of each position, by layer, pass and position.
    let mut ways: BTreeMap<(usize, usize, usize), Vector> = BTreeMap::new();
    let count = faults.len();
    faults.retain(|fault| {
        let way = way_off(program, fault, way_off_blades);
        let Some((way, [from, to])) = way else { return true };
        for end in [from, to].into_iter().flatten() {
            let longest = ways.entry((end.layer, end.pass, end.to)).or_insert(way);
            if way.norm() > longest.norm() {
                *longest = way;
            }
        }
        false
    });
    for ((layer, pass, position), way) in ways {
        layers[layer].passes[pass].positions[position].0 += way;
    }
    faults.len() < count
}

/// The way off the blade that a move of a pass cuts, mm, and the origins of its ends that lie on the pass;
/// `None` for other faults, and where the cut is too deep.
fn way_off(
    program: &Program,
    fault: &MoveFault,
    way_off_blades: &WayOffBlades,
) -> Option<(Vector, [Option<MoveOrigin>; 2])> {
    let overcut = fault.overcut.filter(|&overcut| overcut <= MAX_MOVED_OVERCUT)?;
    let (b, to) = (program.moves.get(fault.index)?, *program.origins.get(fault.index)?);
    if !matches!(b.kind, MoveKind::Cut | MoveKind::Approach) || to.is_beside {
        return None;
    }
    let before = fault.index.checked_sub(1)?;
    let a = &program.moves[before];
    let from = Some(program.origins[before]).filter(|from| (from.layer, from.pass) == (to.layer, to.pass));
    let middle = (a.tip + (b.tip - a.tip) * 0.5, (a.axis + b.axis).try_normalize(1e-9)?);
    let (direction, length) = way_off_blades(middle.0, middle.1)?;
    Some((direction * (length * (overcut - OVERCUT_LEFT)), [from, Some(to)]))
}

/// What to remove from a pass.
#[derive(Default)]
struct PassRemovals {
    /// Moves to remove, each by the index of the position it begins at, with the reason.
    moves: BTreeMap<usize, RemovalCause>,
    /// The reason for removing the whole pass.
    whole: Option<RemovalCause>,
    unlinked: bool,
}

/// Removes the moves with `faults` from the passes that they come from, or, after some iterations, these
/// passes.
fn remove_faulty_moves(
    layers: &mut [LayerPasses],
    program: &Program,
    faults: &[MoveFault],
    round: usize,
    lead_in_out: f64,
    left_out: &mut Vec<UncutLength>,
) {
    let mut cuts: BTreeMap<(usize, usize), PassRemovals> = BTreeMap::new();
    for MoveFault { index, why, overhang, .. } in faults {
        let cause = (*why, *overhang);
        let (Some(step), Some(origin)) = (program.moves.get(*index), program.origins.get(*index)) else {
            continue;
        };
        let count = layers[origin.layer].passes[origin.pass].positions.len();
        let cut = cuts.entry((origin.layer, origin.pass)).or_default();
        let nearest = origin.to.min(count.saturating_sub(2));
        match step.kind {
            _ if origin.is_beside => cut.unlinked = true,
            MoveKind::Link => cut.unlinked = true,
            _ if round >= PIECE_ITERATIONS => cut.whole = Some(cause),
            MoveKind::Rapid => cut.whole = Some(cause),
            MoveKind::Cut => {
                let from = origin.from.map_or(nearest, |from| from.min(origin.to));
                cut.moves.insert(from, cause);
            }
            MoveKind::Approach => {
                cut.moves.insert(nearest, cause);
            }
        }
    }
    if round >= LINK_ITERATIONS {
        let unlinked: BTreeSet<usize> =
            cuts.iter().filter(|(_, cut)| cut.unlinked).map(|(at, _)| at.0).collect();
        for layer in unlinked {
            layers[layer].passes.iter_mut().for_each(|pass| pass.linked = false);
        }
    }
    let touched: BTreeSet<usize> = cuts.keys().map(|at| at.0).collect();
    for index in touched {
        let layer = &mut layers[index];
        for (number, pass) in std::mem::take(&mut layer.passes).into_iter().enumerate() {
            match cuts.get(&(index, number)) {
                Some(cut) => split_pass(layer, pass, cut, lead_in_out, left_out),
                None => layer.passes.push(pass),
            }
        }
    }
}

/// Puts the remaining pieces of a pass back onto its layer.
fn split_pass(
    layer: &mut LayerPasses,
    pass: Pass,
    cut: &PassRemovals,
    lead_in_out: f64,
    left_out: &mut Vec<UncutLength>,
) {
    let mut note = |length: f64, (why, overhang): RemovalCause| {
        let known = |l: &&mut UncutLength| l.layer == layer.number && l.region == pass.region && l.why == why;
        match left_out.iter_mut().find(known) {
            Some(known) => known.add(length, overhang),
            None => {
                let (layer, region) = (layer.number, pass.region);
                left_out.push(UncutLength { layer, region, length, why, overhang });
            }
        }
    };
    if let Some(why) = cut.whole {
        note(path_length(&pass.positions), why);
        return;
    }
    let Some(&first_why) = cut.moves.values().next() else {
        layer.passes.push(Pass { linked: pass.linked && !cut.unlinked, ..pass });
        return;
    };
    let places = places(layer, &pass);
    let (mut first, mut last_why) = (0, first_why);
    let count = pass.positions.len();
    let mut pieces = Vec::new();
    for k in 0..count {
        let ends = k + 1 == count;
        let why = cut.moves.get(&k).copied();
        if !ends && why.is_none() {
            continue;
        }
        let piece = &pass.positions[first..=k];
        let why = why.unwrap_or(last_why);
        // A piece shorter than the stepover is not worth an approach.
        if piece.len() < 2 || path_length(piece) < layer.stepover {
            note(path_length(piece), why);
        } else {
            pieces.push((first, k));
        }
        if !ends {
            note(path_length(&pass.positions[k..=k + 1]), why);
        }
        (first, last_why) = (k + 1, why);
    }
    for (first, last) in pieces {
        let ends = [places[first], places[last]];
        layer.passes.push(Pass {
            role: pass.role,
            region: pass.region,
            group: pass.group,
            positions: pass.positions[first..=last].to_vec(),
            ends,
            open: ends.map(|end| is_open(layer.layer, end, lead_in_out)),
            linked: pass.linked && !cut.unlinked,
        });
    }
}

/// Layer points of the positions of a pass.
fn places(layer: &LayerPasses, pass: &Pass) -> Vec<LayerPoint> {
    let mut y = pass.ends[0].y;
    let place = |(tip, axis): &(Point, Vector)| {
        let (place, _) = layer.layer.project(&(tip + axis * layer.corner_radius), y, None);
        y = place.y;
        place
    };
    pass.positions.iter().map(place).collect()
}
