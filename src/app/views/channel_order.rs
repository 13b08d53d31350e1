//! Fields of the order of several channels: wherever a number of channels is asked for, the setup says how
//! they follow each other.

use egui::Ui;

use super::panels::fields::{self, ChoiceSpec};
use crate::setup::{ChannelOrder, ChannelSequence, ChannelSetup};

const ORDER: ChoiceSpec<ChannelOrder> = ChoiceSpec {
    label: "Channel order",
    tip: "What a program of several channels finishes first; kept in the setup",
    all: &ChannelOrder::ALL,
    name: |order| match order {
        ChannelOrder::ToolByTool => "Tool by tool",
        ChannelOrder::ChannelByChannel => "Channel by channel",
    },
    meaning: |order| match order {
        ChannelOrder::ToolByTool => "Each tool is loaded once, and cuts all channels",
        ChannelOrder::ChannelByChannel => {
            "Each channel is finished before the next: tools are loaded anew for each"
        }
    },
};

const SEQUENCE: ChoiceSpec<ChannelSequence> = ChoiceSpec {
    label: "Channel sequence",
    tip: "Which channel follows which; kept in the setup",
    all: &ChannelSequence::ALL,
    name: |sequence| match sequence {
        ChannelSequence::Adjacent => "Neighbouring",
        ChannelSequence::Opposite => "Opposite",
    },
    meaning: |sequence| match sequence {
        ChannelSequence::Adjacent => "Each channel is followed by its neighbour: short links",
        ChannelSequence::Opposite => {
            "Each channel is followed by the one opposite to it, so that the wheel is relieved evenly;\n\
             links lead across the wheel"
        }
    },
};

/// Rows of a grid with the fields.
pub fn rows(ui: &mut Ui, channels: &mut ChannelSetup) {
    let ChannelSetup { order, sequence } = ChannelSetup::default();
    fields::choice_row(ui, &mut channels.order, order, &ORDER);
    fields::choice_row(ui, &mut channels.sequence, sequence, &SEQUENCE);
}
