//! The ends of the colour scales of the legend, which are edited, and the button that fits them to the plan.

use egui::Ui;

use crate::app::model::number::Quantity;
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::swatch::colour_bar;
use crate::app::views::theme;
use crate::app::views::typed::{self, Typed, TypedLimits};
use crate::palette::ColourMap;

/// Label of the button that fits the scale.
const FIT: &str = "Fit scale";
/// How far the scale may reach into the margin of the legend, points.
pub const MARGIN: f32 = 6.0;
/// Width of a field beside its text, points.
pub const FIELD_MARGIN: f32 = 12.0;
/// Least difference of the ends of a scale, mm.
const MIN_RANGE: f32 = 0.05;
/// Least and greatest end of a scale, mm.
const END_LIMITS: (f32, f32) = (-10.0, 100.0);

/// The bar of the stock on the hub with its ends, which are edited by dragging or typing; those of a
/// difference are symmetric.
pub fn hub_ends(ui: &mut Ui, state: &mut AppState, (map, is_difference): (ColourMap, bool), bar: f32) {
    let ((mut low, mut high), units) = (state.range(), state.look.units);
    let before = (low, high);
    ui.spacing_mut().interact_size.x = 40.0;
    let mut refused = None;
    if is_difference {
        ui.label(format!("−{}", units.length(high.into(), 2)));
    } else {
        let end = ScaleEnd {
            name: "Scale minimum",
            tip: "Drag or type: stock at the lower end of the colour scale",
            range: (END_LIMITS.0, high - MIN_RANGE),
            why: ("", ", below the upper end. For more, raise that first"),
        };
        refused = end.show(ui, &mut low, units);
    }
    colour_bar(ui, map, bar);
    let end = ScaleEnd {
        name: "Scale maximum",
        tip: "Drag or type: stock at the upper end of the colour scale, and above",
        range: (low + MIN_RANGE, END_LIMITS.1),
        why: (if is_difference { "" } else { ", above the lower end. For less, lower that first" }, ""),
    };
    refused = end.show(ui, &mut high, units).or(refused);
    let fitting = state.fitting_range();
    if state.range() != fitting && fit_clicked(ui) {
        state.look.range = Some(fitting);
    } else if (low, high) != before {
        state.look.range = Some((low, high));
    }
    // The reason does not fit below these fields.
    if let Some(reason) = refused {
        state.report_refusal(reason);
    }
}

/// Draws the button that fits the scale if it has enough space. Returns whether it was clicked.
fn fit_clicked(ui: &mut Ui) -> bool {
    let tip = "The scale stays while plans change; this fits it to the plan that is shown";
    let has_room = ui.available_width() + MARGIN > fit_width(ui);
    has_room && ui.add(egui::Button::new(FIT).small()).on_hover_text(tip).clicked()
}

/// Least and greatest upper end of the scale of the walls, mm.
const WALL_LIMITS: (f32, f32) = (0.005, 10.0);

/// The bar of the walls with its ends, of which the upper one, `most`, is edited: the scale is symmetric.
pub fn wall_ends(ui: &mut Ui, state: &mut AppState, most: f32, bar: f32) {
    let (units, mut end) = (state.look.units, most);
    ui.spacing_mut().interact_size.x = 40.0;
    ui.label(units.deviation((-most).into()));
    colour_bar(ui, ColourMap::Difference, bar);
    let field = ScaleEnd {
        name: "Scale maximum",
        tip: "Drag or type: stock above the blade allowance at the upper end of the colour scale; as much \
              overcut is at the lower end",
        range: WALL_LIMITS,
        why: ("", ""),
    };
    let show = |mm: f64| units.deviation(mm);
    let refused = field.show_as(ui, &mut end, units, &show, f64::from(most) / 200.0);
    if state.look.wall_end.is_some() && fit_clicked(ui) {
        state.look.wall_end = None;
    } else if end != most {
        state.look.wall_end = Some(end);
    }
    if let Some(reason) = refused {
        state.report_refusal(reason);
    }
}

/// Width of the button that fits the scale, with the space before it, points.
pub fn fit_width(ui: &Ui) -> f32 {
    theme::width_of_text(ui, FIT) + FIELD_MARGIN
}

/// A length of a scale, mm, as it is written: 0.05 is not 0.05000000075.
fn rounded(mm: f32) -> f64 {
    (1e4 * f64::from(mm)).round() / 1e4
}

/// A field for an end of a scale.
struct ScaleEnd {
    name: &'static str,
    tip: &'static str,
    /// Least and greatest value, mm.
    range: (f32, f32),
    /// What sets them, as ends of sentences.
    why: (&'static str, &'static str),
}

impl ScaleEnd {
    /// Draws it; returns why what was typed is not taken.
    fn show(&self, ui: &mut Ui, value: &mut f32, units: DisplayUnits) -> Option<String> {
        self.show_as(ui, value, units, &|mm| units.length(mm, 2), 0.02)
    }

    /// The same with the value as `show` writes it, which changes by `speed` per dragged point, mm.
    fn show_as(
        &self,
        ui: &mut Ui,
        value: &mut f32,
        units: DisplayUnits,
        show: &dyn Fn(f64) -> String,
        speed: f64,
    ) -> Option<String> {
        let limits = TypedLimits {
            quantity: Quantity::Length,
            units,
            range: rounded(self.range.0)..=rounded(self.range.1),
            why_least: self.why.0,
            why_most: self.why.1,
            show,
        };
        let (field, typed) = typed::limited_field(ui, value, &limits, speed);
        let shown = f64::from(*value);
        field.widget_info(|| {
            let mut info = egui::WidgetInfo::drag_value(true, shown);
            info.label = Some(self.name.to_owned());
            info
        });
        field.on_hover_text(self.tip);
        match typed {
            Typed::Refused(reason) => Some(format!("{}: {reason}", self.name)),
            Typed::Nothing | Typed::Unchanged | Typed::Taken => None,
        }
    }
}
