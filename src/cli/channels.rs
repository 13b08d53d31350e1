//! Several channels on the command line: how many, in which order, and what is said of it.

use serde_json::{Map, Value, json};

use super::Failure;
use super::args::ChannelArgs;
use crate::error::ErrorCode;
use crate::io::setup_file::{parse_channel_order, parse_channel_sequence};
use crate::part::Impeller;
use crate::setup::ChannelSetup;

impl ChannelArgs {
    /// Replaces the order of channels by what the arguments give.
    ///
    /// # Errors
    /// When a name is not known.
    pub(super) fn order(&self, channels: &mut ChannelSetup) -> Result<(), Failure> {
        if let Some(name) = &self.channel_order {
            let order = parse_channel_order(name);
            channels.order = order.map_err(|error| Failure::from(error).at("--channel-order"))?;
        }
        if let Some(name) = &self.channel_sequence {
            let sequence = parse_channel_sequence(name);
            channels.sequence = sequence.map_err(|error| Failure::from(error).at("--channel-sequence"))?;
        }
        Ok(())
    }

    /// The number of channels.
    ///
    /// # Errors
    /// When the part does not have as many.
    pub(super) fn count(&self, part: &Impeller) -> Result<usize, Failure> {
        let (word, all) = (&*self.channels, part.blade_count);
        match word {
            "all" => Ok(all),
            _ => word.parse().ok().filter(|n| (1..=all).contains(n)).ok_or_else(|| {
                let help = format!("give 1 to {all}, or all");
                Failure::input(ErrorCode::Arguments, "not a number of channels", help)
                    .at(format!("--channels {word}"))
            }),
        }
    }
}

/// Keys of `--json` for the order of several channels.
pub(super) fn channel_keys(order: ChannelSetup) -> Map<String, Value> {
    let ChannelSetup { order, sequence } = order;
    let keys = [("channel_order", order.name()), ("channel_sequence", sequence.name())];
    keys.into_iter().map(|(key, name)| (key.to_owned(), json!(name))).collect()
}

/// The line about the time of the program of all channels (s); none where it is not known. Without a machine
/// that times it, tool changes and accelerations are left out.
pub(super) fn wheel_text(
    part: &Impeller,
    order: ChannelSetup,
    time_s: Option<f64>,
    is_timed: bool,
) -> String {
    let Some(time_s) = time_s else { return String::new() };
    let what = if is_timed { "" } else { " (tool changes and accelerations left out)" };
    let (count, order) = (part.blade_count, order.words());
    format!("the wheel, {count} channels, {order}: {:.1} min{what}\n", time_s / 60.0)
}
