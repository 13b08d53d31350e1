//! What the window knows: document, results, look, and the rules that connect them. Nothing here draws, runs
//! in the background, or knows egui.

pub mod checked;
pub mod cutter_colours;
pub mod document;
pub mod exported;
pub mod field_faults;
pub mod figures;
pub mod file_purpose;
pub mod flank_passes;
pub mod history;
pub mod known_goals;
pub mod layout;
pub mod library_state;
pub mod listing;
pub mod look;
pub mod machine;
pub mod mouse_preset;
pub mod number;
pub mod panels;
pub mod part_source;
pub mod planned;
pub mod plunge_edits;
pub mod post_target;
pub mod preview;
pub mod problem;
pub mod release;
pub mod results;
pub mod role_choices;
pub mod shop_library;
pub mod shown_channels;
pub mod solid;
pub mod state;
pub mod study_table;
pub mod table_scroll;
pub mod timeline_program;
pub mod units;
