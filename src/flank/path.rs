//! From passes to a program: the order of the passes and the moves between them.
//!
//! Layers are cut from the top down, a layer region by region: first the inner passes of each fixed axis,
//! zigzag from side to side, then the passes along the walls. Between passes the tool links over the layer at
//! feed rate where that is fast and free of collision. Otherwise it retracts along its axis, moves in rapid
//! above the blank, and comes down again: fast through what is cut, to an end of the next pass, or of a cut
//! one from which it goes on over the layer, or by a ramp into stock, whatever takes least time. Each pass
//! has one feed rate, by its engagement: full stock on both sides, beside a cut pass, or along a wall.
//!
//! | file | contents |
//! |---|---|
//! | `inputs` | the passes by layer, the tool and its feed rates |
//! | `moves` | the moves, their origins and times |
//! | `writer` | writes pass after pass, and the rapids between them |
//! | `entry` | the fastest way to a pass |
//! | `approach` | the moves down to it, with its ramp |
//! | `cut_space` | where stock still stands above a position |

mod approach;
mod cut_space;
mod entry;
mod inputs;
mod moves;
mod writer;

use super::engagement::CutPasses;
use super::strategies::PassRole;
use crate::monitor::{Cancelled, Monitor};
use writer::ProgramWriter;

pub use inputs::{CollisionCheck, LayerPasses, Pass, PathMaker};
pub use moves::{FlankMove, MoveKind, MoveOrigin, Program, Times};
pub(super) use moves::{RAPID_MARGIN, path_length};

impl PathMaker<'_> {
    /// The program of all `layers`, given in cutting order.
    ///
    /// # Errors
    /// When the monitor is cancelled.
    pub fn program(&self, layers: &[LayerPasses], monitor: &Monitor) -> Result<Program, Cancelled> {
        let mut writer = ProgramWriter::new(self);
        for (index, layer) in layers.iter().enumerate() {
            let mut rest: Vec<(usize, &Pass)> = layer.passes.iter().enumerate().collect();
            // Regions from the inlet on; in each the inner passes by axis, then the walls, side by side.
            rest.sort_by(|(_, a), (_, b)| {
                let key = |p: &Pass| (p.region, matches!(p.role, PassRole::Wall(_)), p.group);
                let side = |p: &Pass| p.ends[0].y + p.ends[1].y;
                key(a).cmp(&key(b)).then(side(a).total_cmp(&side(b)))
            });
            let mut cut = CutPasses::new(self.tool, layer.stepover);
            writer.begin_layer();
            for (number, pass) in rest {
                monitor.check()?;
                writer.write_pass(layer, pass, (index, number), self.feed_of(pass, &cut));
                cut.add(&pass.positions);
            }
        }
        writer.finish(monitor)
    }
}
