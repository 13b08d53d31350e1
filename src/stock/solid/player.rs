//! The stock after any move of one program, for a timeline: checkpoints on the way keep the work of a jump
//! small.

use super::{Contact, SolidError, SolidProgram, SolidStock};
use crate::monitor::Monitor;

/// Checkpoints of a program.
const CHECKPOINTS: usize = 64;
/// Memory that checkpoints may take together, bytes.
const CHECKPOINT_BYTES: usize = 384 << 20;

/// A stock and the number of moves of the program that were made on it.
#[derive(Clone, Debug)]
struct Made {
    count: usize,
    stock: SolidStock,
}

/// A program played on a blank.
#[derive(Debug)]
pub struct StockPlayer {
    program: SolidProgram,
    /// Stock at some counts, ascending, from the blank on.
    checkpoints: Vec<Made>,
    bytes: usize,
    /// The stock that was asked for last.
    current: Option<Made>,
    /// Number of moves that were ever made, and what met stock in them.
    seen: usize,
    contacts: Vec<Contact>,
}

impl StockPlayer {
    /// Plays `program` on `blank`.
    pub fn new(program: SolidProgram, blank: SolidStock) -> Self {
        let bytes = blank.bytes();
        let checkpoints = vec![Made { count: 0, stock: blank }];
        Self { program, checkpoints, bytes, current: None, seen: 0, contacts: Vec::new() }
    }

    /// The program.
    pub fn program(&self) -> &SolidProgram {
        &self.program
    }

    /// The stock after the first `count` moves of the program, and what met stock in them that must not.
    ///
    /// # Errors
    /// When cancelled, which loses no finished stretch, or when the stock falls into too many pieces.
    pub fn at(&mut self, count: usize, monitor: &Monitor) -> Result<(&SolidStock, &[Contact]), SolidError> {
        let count = count.min(self.program.count);
        let near = self.checkpoints.partition_point(|made| made.count <= count) - 1;
        let current = self
            .current
            .take()
            .filter(|made| made.count <= count && made.count >= self.checkpoints[near].count);
        let mut made = current.unwrap_or_else(|| self.checkpoints[near].clone());
        let stretch = self.program.count.div_ceil(CHECKPOINTS).max(1);
        while made.count < count {
            let to = count.min((made.count / stretch + 1) * stretch);
            let (from, until) = (self.program.first(made.count).len(), self.program.first(to).len());
            let moves = &self.program.moves[from..until];
            monitor.check()?;
            let found = made.stock.make_moves(&self.program.tools, moves, monitor)?;
            made.count = to;
            if to > self.seen {
                self.contacts.extend(found.into_iter().filter(|c| c.number as usize >= self.seen));
                self.seen = to;
            }
            let Some(last) = self.checkpoints.last().filter(|last| to > last.count) else { continue };
            // States share the tiles that no cut between them met.
            let size = made.stock.bytes_beside(&last.stock);
            if to.is_multiple_of(stretch) && self.bytes + size <= CHECKPOINT_BYTES {
                self.bytes += size;
                self.checkpoints.push(made.clone());
            }
        }
        let before = self.contacts.partition_point(|contact| (contact.number as usize) < count);
        Ok((&self.current.insert(made).stock, &self.contacts[..before]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{SolidBlank, SolidMove, SolidTool, ToolPose, TurnedOutline};
    use super::*;
    use crate::geometry::{Meridional, Point, Vector};
    use crate::setup::Tool;

    /// A disc of radius 30 mm and 10 mm thick, with a row of plunges across it.
    fn plunges(count: u32) -> (SolidProgram, SolidStock) {
        let tool = Tool {
            number: 1,
            diameter: 6.0,
            corner_radius: 0.0,
            insert_width: 2.0,
            overhang: 60.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: Default::default(),
        };
        let pose = |k: u32, z: f64| ToolPose {
            tip: Point::new(-25.0 + 50.0 * f64::from(k) / f64::from(count), 0.5, z),
            axis: Vector::z(),
        };
        let moves = (0..count)
            .map(|number| SolidMove {
                number,
                tool: 0,
                rapid: false,
                checks_core: true,
                from: pose(number, 30.0),
                to: pose(number, 4.0),
            })
            .collect();
        let corners = [(0.0, 0.0), (30.0, 0.0), (30.0, 10.0), (0.0, 10.0)];
        let outline = TurnedOutline::new(corners.map(|(r, z)| Meridional { r, z }).to_vec());
        let blank = SolidStock::new(&SolidBlank::Turned(outline), 0.5).expect("small");
        (SolidProgram { tools: vec![SolidTool::from_tool(&tool)], moves, count: count as usize }, blank)
    }

    #[test]
    fn every_count_in_any_order_is_the_stock_made_from_the_blank() {
        let (program, blank) = plunges(50);
        let mut player = StockPlayer::new(program.clone(), blank.clone());
        for count in [50, 3, 4, 49, 0, 17, 16, 60] {
            let mut fresh = blank.clone();
            let moves = program.first(count);
            let found = fresh.make_moves(&program.tools, moves, &Monitor::default()).expect("runs");
            let (stock, contacts) = player.at(count, &Monitor::default()).expect("runs");
            assert!((stock.volume() - fresh.volume()).abs() < 1e-9, "after {count}");
            assert_eq!(contacts, found, "after {count}");
            assert_eq!(contacts.is_empty(), count == 0, "the first plunge is a full one");
        }
    }

    #[test]
    fn a_cancelled_jump_leaves_the_player_usable() {
        let (program, blank) = plunges(200);
        let mut player = StockPlayer::new(program, blank);
        let whole = player.at(200, &Monitor::default()).expect("runs").0.volume();
        let cancelled = Monitor::default();
        cancelled.cancel();
        assert!(player.at(7, &cancelled).is_err());
        let volume = player.at(200, &Monitor::default()).expect("runs").0.volume();
        assert!((volume - whole).abs() < 1e-9);
    }
}
