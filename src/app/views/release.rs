//! The question before a file is written that something speaks against: a program, or a library that would
//! lose data.

use egui::{Modal, RichText, Ui};

use super::modal::{self, is_dismissed};
use super::theme::Condition;

/// Answer to the question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseAnswer {
    /// Calculate the current setup, then ask again or write.
    Recalculate,
    /// Write the program.
    Export,
    /// Write nothing.
    Cancel,
}

/// Whether the plan of the file can be calculated anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recalculation {
    /// It would change nothing.
    None,
    /// It may change what speaks against the file.
    Offered,
    /// It ended while the question was asked.
    Done,
}

/// A question that says something else than at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Renewal {
    /// How long ago that began, s.
    pub since_s: f64,
    /// Whether there is another plan.
    pub has_new_plan: bool,
}

impl Renewal {
    /// What is said of it, where something speaks against the file or nothing does.
    fn words(self, is_sound: bool) -> &'static str {
        match (self.has_new_plan, is_sound) {
            (true, true) => {
                "The plan was calculated anew while this was asked. Nothing speaks against it now."
            }
            (true, false) => "The plan was calculated anew while this was asked. Now:",
            (false, true) => "Nothing speaks against it any more.",
            (false, false) => "Something else became known while this was asked. Now:",
        }
    }
}

/// Time for which nothing is exported after the question has changed, s: who was about to click reads first.
const READING_TIME_S: f64 = 1.0;

/// What the question says of the kind of file.
#[derive(Debug)]
pub struct ReleaseWords {
    title: &'static str,
    /// What stands above the list; may be empty.
    above: &'static str,
    /// What stands below it; may be empty.
    below: &'static str,
    /// The button that writes the file although something speaks against it.
    anyway: &'static str,
    /// The button that writes it once nothing does any more.
    now: &'static str,
}

/// Of a program.
pub const PROGRAM: ReleaseWords = ReleaseWords {
    title: "Export this program?",
    above: "",
    below: "",
    anyway: "Export anyway",
    now: "Export",
};
/// Of the setup sheet of a plan.
pub const SHEET: ReleaseWords = ReleaseWords { title: "Export the setup sheet of this plan?", ..PROGRAM };
/// Of a scene.
pub const SCENE: ReleaseWords = ReleaseWords { title: "Export the scene of this plan?", ..PROGRAM };
/// Of the stock that a plan leaves.
pub const STOCK: ReleaseWords = ReleaseWords { title: "Export the stock of this plan?", ..PROGRAM };
/// Of a tool library in the format of Fusion.
pub const LIBRARY: ReleaseWords = ReleaseWords {
    title: "Write a Fusion library?",
    above: "It is written anew from what Vanecut knows of the tools. It does not hold:",
    below: "A .toml library keeps all that is shown here.",
    anyway: "Write anyway",
    now: "Write",
};

/// Of one that exists.
pub const EXISTING_LIBRARY: ReleaseWords = ReleaseWords {
    title: "Write into the Fusion library?",
    above: "What it has beyond the tools shown here stays. Before you write into it:",
    below: "A .toml library keeps all that is shown here; the file of Fusion then stays as it is.",
    anyway: "Write into it",
    now: "Write into it",
};

/// Draws the question with what speaks against `file`, by name; returns the answer once.
pub fn ask(
    ui: &Ui,
    (words, file): (&ReleaseWords, &str),
    concerns: &[String],
    recalculation: Recalculation,
    renewal: Option<Renewal>,
) -> Option<ReleaseAnswer> {
    let mut answer = None;
    let content = |ui: &mut Ui| {
        ui.label(RichText::new(words.title).strong());
        ui.label(RichText::new(file).weak());
        ui.add_space(4.0);
        if !words.above.is_empty() {
            ui.label(words.above);
        }
        if let Some(renewal) = renewal {
            let said = renewal.words(concerns.is_empty());
            ui.label(RichText::new(said).color(Condition::Blocked.text(ui.visuals())));
        }
        let colour = Condition::Interfering.text(ui.visuals());
        for concern in concerns {
            ui.label(RichText::new(format!("• {concern}")).color(colour));
        }
        if !words.below.is_empty() {
            ui.label(RichText::new(words.below).weak());
        }
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let tip = "Calculates the current setup, then goes on with the export";
            if recalculation != Recalculation::None {
                let button = egui::Button::new("Recalculate");
                let button = ui.add_enabled(recalculation == Recalculation::Offered, button);
                if button.on_hover_text(tip).on_disabled_hover_text("It was calculated anew").clicked() {
                    answer = Some(ReleaseAnswer::Recalculate);
                }
            }
            let is_read = renewal.is_none_or(|renewal| renewal.since_s >= READING_TIME_S);
            let write = if concerns.is_empty() { words.now } else { words.anyway };
            if ui.add_enabled(is_read, egui::Button::new(write)).clicked() {
                answer = Some(ReleaseAnswer::Export);
            }
            if !is_read {
                ui.ctx().request_repaint_after_secs(READING_TIME_S as f32);
            }
            if ui.button("Cancel").clicked() {
                answer = Some(ReleaseAnswer::Cancel);
            }
        });
    };
    let id = egui::Id::unique("release");
    let modal = Modal::new(id).show(ui.ctx(), |ui| modal::fitting(ui, 420.0, content));
    answer.or(is_dismissed(&modal).then_some(ReleaseAnswer::Cancel))
}
