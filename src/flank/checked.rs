//! Leaves out of a program what a check of all its moves finds fault with: pieces of passes, or ways over a layer.

use std::collections::{BTreeMap, BTreeSet};

use super::layer::LayerPoint;
use super::passes::{LeftOut, is_open};
use super::path::{FlankMove, LayerPasses, MoveKind, Pass, PathMaker, Program};
use crate::geometry::{Point, Vector};
use crate::monitor::{Cancelled, Monitor};
use crate::part::Tool;

/// A move that must not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveFault {
    /// Its index.
    pub index: usize,
    /// What is wrong with it, for people.
    pub why: &'static str,
}

/// Finds fault with moves of a cutter.
pub type Check<'a> = dyn FnMut(&Tool, &[FlankMove], &Monitor) -> Result<Vec<MoveFault>, Cancelled> + 'a;

/// A program that was checked.
pub(super) struct Checked {
    pub(super) moves: Vec<FlankMove>,
    pub(super) left_out: Vec<LeftOut>,
    /// What no leaving out has cured.
    pub(super) faults: Vec<MoveFault>,
}

/// Rounds in which pieces of passes are left out, and then whole passes.
const ROUNDS_OF_PIECES: usize = 6;
/// Rounds after which a layer on which a way from pass to pass is at fault has none any more.
const ROUNDS_OF_LINKS: usize = 2;
const ROUNDS: usize = 24;

/// The program of `layers`, given in cutting order, without what `check` finds fault with.
pub(super) fn checked(
    path: &PathMaker,
    layers: &mut [LayerPasses],
    extension: f64,
    check: &mut Check,
    monitor: &Monitor,
) -> Result<Checked, Cancelled> {
    let mut left_out = Vec::new();
    let mut round = 0;
    loop {
        let program = path.program(layers, monitor)?;
        let faults = check(path.tool, &program.moves, monitor)?;
        if faults.is_empty() || round == ROUNDS {
            return Ok(Checked { moves: program.moves, left_out, faults });
        }
        leave_out(layers, &program, &faults, round, extension, &mut left_out);
        round += 1;
    }
}

/// What is to be left out of a pass.
#[derive(Default)]
struct Cuts {
    /// Indices of the positions at which ways to the next one begin that are not gone, and why.
    ways: BTreeMap<usize, &'static str>,
    /// The whole pass, and why.
    whole: Option<&'static str>,
    unlinked: bool,
}

/// Takes the moves with `faults` out of the passes that they come from, or, after some rounds, these passes.
fn leave_out(
    layers: &mut [LayerPasses],
    program: &Program,
    faults: &[MoveFault],
    round: usize,
    extension: f64,
    left_out: &mut Vec<LeftOut>,
) {
    let mut cuts: BTreeMap<(usize, usize), Cuts> = BTreeMap::new();
    for MoveFault { index, why } in faults {
        let (Some(step), Some(origin)) = (program.moves.get(*index), program.origins.get(*index)) else {
            continue;
        };
        let count = layers[origin.layer].passes[origin.pass].positions.len();
        let cut = cuts.entry((origin.layer, origin.pass)).or_default();
        let nearest = origin.to.min(count.saturating_sub(2));
        match step.kind {
            MoveKind::Link => cut.unlinked = true,
            _ if round >= ROUNDS_OF_PIECES => cut.whole = Some(why),
            MoveKind::Rapid => cut.whole = Some(why),
            MoveKind::Cut => {
                let from = origin.from.map_or(nearest, |from| from.min(origin.to));
                cut.ways.insert(from, why);
            }
            MoveKind::Approach => {
                cut.ways.insert(nearest, why);
            }
        }
    }
    if round >= ROUNDS_OF_LINKS {
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
                Some(cut) => pieces_without(layer, pass, cut, extension, left_out),
                None => layer.passes.push(pass),
            }
        }
    }
}

/// Puts what a cut leaves of a pass back onto its layer.
fn pieces_without(
    layer: &mut LayerPasses,
    pass: Pass,
    cut: &Cuts,
    extension: f64,
    left_out: &mut Vec<LeftOut>,
) {
    let mut note = |length: f64, why: &'static str| {
        let known = |l: &&mut LeftOut| l.layer == layer.number && l.region == pass.region && l.why == why;
        match left_out.iter_mut().find(known) {
            Some(known) => known.length += length,
            None => left_out.push(LeftOut { layer: layer.number, region: pass.region, length, why }),
        }
    };
    if let Some(why) = cut.whole {
        note(length(&pass.positions), why);
        return;
    }
    if cut.ways.is_empty() {
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
        let why = cut.ways.get(&k).copied();
        if !ends && why.is_none() {
            continue;
        }
        let piece = &pass.positions[first..=k];
        let why = why.unwrap_or(last_why);
        // A piece shorter than the way to its neighbour is not worth the way down to it.
        if piece.len() < 2 || length(piece) < layer.interval {
            note(length(piece), why);
        } else {
            pieces.push((first, k));
        }
        if !ends {
            note(length(&pass.positions[k..=k + 1]), why);
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
            open: ends.map(|end| is_open(layer.layer, end, extension)),
            linked: pass.linked && !cut.unlinked,
        });
    }
}

/// Where the positions of a pass stand on its layer.
fn places(layer: &LayerPasses, pass: &Pass) -> Vec<LayerPoint> {
    let mut y = pass.ends[0].y;
    let place = |(tip, axis): &(Point, Vector)| {
        let (place, _) = layer.layer.place(&(tip + axis * layer.corner_radius), y, None);
        y = place.y;
        place
    };
    pass.positions.iter().map(place).collect()
}

/// Way of the tip, mm.
fn length(positions: &[(Point, Vector)]) -> f64 {
    positions.windows(2).map(|w| (w[1].0 - w[0].0).norm()).sum()
}
