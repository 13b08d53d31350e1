//! Removes from a program what a check of all its moves rejects: pieces of passes, or the links of a layer.

use std::collections::{BTreeMap, BTreeSet};

use super::layer::LayerPoint;
use super::passes::{UncutLength, is_open};
use super::path::{FlankMove, LayerPasses, MoveKind, Pass, PathMaker, Program, path_length};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::setup::Tool;

/// A move that the check rejects.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveFault {
    /// Index in the program.
    pub index: usize,
    /// What is wrong with it, as a message.
    pub why: &'static str,
}

/// Checks the moves of a tool and returns the rejected ones, or [`Cancelled`].
pub type MoveCheck<'a> = dyn FnMut(&Tool, &[FlankMove], &Monitor) -> Result<Vec<MoveFault>, Cancelled> + 'a;

/// A program after the check.
pub(super) struct CheckedMoves {
    pub(super) moves: Vec<FlankMove>,
    pub(super) left_out: Vec<UncutLength>,
    /// Faults that remain after the last iteration.
    pub(super) faults: Vec<MoveFault>,
}

/// Iterations that remove pieces of passes; later ones remove whole passes.
const PIECE_ITERATIONS: usize = 10;
/// Iterations after which a layer with a rejected link loses all its links.
const LINK_ITERATIONS: usize = 2;
/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 24;

/// The program of `layers`, given in cutting order, without what `check` rejects: iterates removal and check.
/// `lead_in_out` is the length of lead-in and lead-out, mm.
///
/// # Errors
/// When the monitor is cancelled.
pub(super) fn remove_faults(
    path: &PathMaker,
    layers: &mut [LayerPasses],
    lead_in_out: f64,
    check: &mut MoveCheck,
    monitor: &Monitor,
) -> Result<CheckedMoves, Cancelled> {
    let mut left_out = Vec::new();
    let mut round = 0;
    loop {
        let program = path.program(layers, monitor)?;
        let faults = check(path.tool, &program.moves, monitor)?;
        if faults.is_empty() || round == MAX_ITERATIONS {
            return Ok(CheckedMoves { moves: program.moves, left_out, faults });
        }
        remove_faulty_moves(layers, &program, &faults, round, lead_in_out, &mut left_out);
        round += 1;
    }
}

/// What to remove from a pass.
#[derive(Default)]
struct PassRemovals {
    /// Moves to remove, each by the index of the position it begins at, with the reason.
    moves: BTreeMap<usize, &'static str>,
    /// The reason for removing the whole pass.
    whole: Option<&'static str>,
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
    for MoveFault { index, why } in faults {
        let (Some(step), Some(origin)) = (program.moves.get(*index), program.origins.get(*index)) else {
            continue;
        };
        let count = layers[origin.layer].passes[origin.pass].positions.len();
        let cut = cuts.entry((origin.layer, origin.pass)).or_default();
        let nearest = origin.to.min(count.saturating_sub(2));
        match step.kind {
            MoveKind::Link => cut.unlinked = true,
            _ if round >= PIECE_ITERATIONS => cut.whole = Some(why),
            MoveKind::Rapid => cut.whole = Some(why),
            MoveKind::Cut => {
                let from = origin.from.map_or(nearest, |from| from.min(origin.to));
                cut.moves.insert(from, why);
            }
            MoveKind::Approach => {
                cut.moves.insert(nearest, why);
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
    let mut note = |length: f64, why: &'static str| {
        let known = |l: &&mut UncutLength| l.layer == layer.number && l.region == pass.region && l.why == why;
        match left_out.iter_mut().find(known) {
            Some(known) => known.length += length,
            None => left_out.push(UncutLength { layer: layer.number, region: pass.region, length, why }),
        }
    };
    if let Some(why) = cut.whole {
        note(path_length(&pass.positions), why);
        return;
    }
    if cut.moves.is_empty() {
        layer.passes.push(Pass { linked: pass.linked && !cut.unlinked, ..pass });
        return;
    }
    let places = places(layer, &pass);
    let mut first = 0;
    let mut last_why = "";
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
