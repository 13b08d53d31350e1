//! Stretches of flank passes that are not cut, by the reason why.

use super::units::DisplayUnits;
use crate::flank::UncutLength;
use crate::report::words::left_out_text;

/// Stretches of passes that are not cut for the same reason.
#[derive(Clone, Debug, PartialEq)]
pub struct SkippedReason {
    /// The reason.
    pub message: &'static str,
    /// The stretches.
    pub stretches: Vec<UncutLength>,
}

/// The reasons of the stretches that are not cut, the longest first.
pub fn skipped_by_reason(uncut: &[UncutLength]) -> Vec<SkippedReason> {
    let mut reasons: Vec<SkippedReason> = Vec::new();
    for left in uncut {
        match reasons.iter_mut().find(|reason| reason.message == left.why.message) {
            Some(reason) => reason.stretches.push(left.clone()),
            None => {
                reasons.push(SkippedReason { message: left.why.message, stretches: vec![left.clone()] });
            }
        }
    }
    let length = |reason: &SkippedReason| sum(&reason.stretches);
    reasons.sort_by(|a, b| length(b).total_cmp(&length(a)));
    reasons
}

fn sum(stretches: &[UncutLength]) -> f64 {
    stretches.iter().map(|stretch| stretch.length).sum()
}

/// Length of passes that are not cut, in words.
pub fn skipped_length(stretches: &[UncutLength], units: DisplayUnits) -> String {
    left_out_text(sum(stretches), |mm| units.length(mm, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flank::UncutReason;
    use crate::flank::region::Region;

    #[test]
    fn reasons_are_summed_over_layers_and_the_longest_comes_first() {
        let left = |layer, length, message| UncutLength {
            layer,
            region: Region::INLET,
            length,
            why: UncutReason::new(message),
            overhang: None,
        };
        let uncut = [left(0, 0.04, "too short"), left(0, 3.0, "too near"), left(1, 2.0, "too near")];
        let reasons = skipped_by_reason(&uncut);
        let words: Vec<_> = reasons
            .iter()
            .map(|r| (r.message, r.stretches.len(), skipped_length(&r.stretches, DisplayUnits::Metric)))
            .collect();
        assert_eq!(words, [("too near", 2, "5.0 mm".into()), ("too short", 1, "less than 0.1 mm".into())]);
    }
}
