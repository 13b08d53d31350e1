//! Statements about tools: speed, number and size.

use super::Reader;
use crate::error::ErrorCode;
use crate::io::{InputError, source};
use crate::toolpath::ClTool;

impl Reader<'_> {
    /// `SPINDL/…`: speed of this and later tools, or `OFF`.
    pub(super) fn spindl(&mut self, words: &[String]) {
        let number = words.iter().find_map(|word| source::number(word).ok());
        self.spindle_stopped = words.iter().any(|word| word == "OFF") || number.is_some_and(|n| n <= 0.0);
        let Some(speed) = number.filter(|speed| *speed > 0.0) else { return };
        self.spindle_rpm = Some(speed);
        if let Some(tool) = self.tool.and_then(|index| self.program.tools.get_mut(index)) {
            tool.spindle_rpm.get_or_insert(speed);
        }
    }

    fn add(&mut self, tool: ClTool) {
        self.tool = Some(self.program.tools.len());
        self.program.tools.push(tool);
        self.used = false;
    }

    /// Loads a tool by number `n`; Creo adds `LENGTH,l`.
    pub(super) fn load(&mut self, words: &[String]) {
        // A tool change happens away from the part: the program does not give the moves there and back.
        self.unknown_position = None;
        let number = words.iter().find_map(|w| w.trim_end_matches('.').parse::<u32>().ok()).unwrap_or(0);
        let after = |name: &str| {
            let at = words.iter().position(|word| word == name)?;
            words.get(at + 1).and_then(|word| source::number(word).ok())
        };
        let length = after("LENGTH").map(|l| l * self.unit_mm).filter(|l| *l > 0.0);
        let known = self.program.tools.iter().rposition(|tool| tool.number == number && tool.diameter > 0.0);
        let described = self.tool.filter(|_| !self.used && !self.numbered);
        match (described.and_then(|index| self.program.tools.get_mut(index)), known) {
            // NX gives the size before the number.
            (Some(tool), _) => tool.number = number,
            (None, Some(index)) => {
                self.tool = Some(index);
                self.used = true;
            }
            (None, None) => self.add(ClTool { number, ..ClTool::default() }),
        }
        self.numbered = true;
        let width = self.insert_widths.iter().rev().find(|(n, _)| *n == number).map(|(_, w)| *w);
        if let Some(tool) = self.tool.and_then(|index| self.program.tools.get_mut(index)) {
            tool.overhang = length.or(tool.overhang);
            tool.insert_width = tool.insert_width.or(width);
        }
    }

    /// `CUTTER/d,r,…,h`: h is the seventh number, or `length` if the statement gives it separately.
    pub(super) fn cutter(
        &mut self,
        line: usize,
        words: &[String],
        length: Option<Option<f64>>,
    ) -> Result<(), InputError> {
        let size = |k: usize| match words.get(k).filter(|word| !word.is_empty()) {
            Some(word) => Ok(self.number(line, "CUTTER", word)?.max(0.0) * self.unit_mm),
            None => Ok(0.0),
        };
        let (diameter, corner_radius) = (size(0)?, size(1)?);
        let height = match length {
            Some(length) => length.map(|l| l * self.unit_mm),
            None => Some(size(6)?).filter(|h| *h > 0.0),
        };
        if corner_radius > diameter / 2.0 + 1e-6 {
            let what =
                format!("CUTTER: corner radius {corner_radius} is larger than the radius {}", diameter / 2.0);
            return Err(self
                .source
                .fault(line, what, "correct the cutter")
                .with_code(ErrorCode::ProgramTool));
        }
        let same = |tool: &ClTool| tool.diameter == diameter && tool.corner_radius == corner_radius;
        let number = self.tool.and_then(|index| self.program.tools.get(index)).map(|tool| tool.number);
        let current = self.tool.and_then(|index| self.program.tools.get(index));
        if !current.is_some_and(|tool| !self.used || same(tool)) {
            // A cutter of another size after moves is another tool, even with the same number.
            self.numbered = false;
            self.add(ClTool { number: number.unwrap_or(0), ..ClTool::default() });
        }
        if let Some(tool) = self.tool.and_then(|index| self.program.tools.get_mut(index)) {
            (tool.diameter, tool.corner_radius) = (diameter, corner_radius);
            tool.overhang = tool.overhang.or(height);
        }
        Ok(())
    }
}
