//! What a position asks of the axes of the machine, in a cell and in words.

use egui::{RichText, Ui};

use super::cells::cell;
use crate::app::model::machine::AxisDemand;
use crate::app::model::number::with_minus_signs;
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::app::views::theme::Condition;
use crate::machine::LimitFault;

/// The worst that a position asks of the axes: an axis with its excess, or the angle from the pole.
pub fn axis_warning(ui: &mut Ui, demand: Option<&AxisDemand>, units: DisplayUnits) {
    let Some(demand) = demand.filter(|demand| demand.is_warning()) else { return };
    let (text, condition) = match &demand.fault {
        Some(LimitFault::Unreachable { .. }) => ("none".to_owned(), Condition::Interfering),
        Some(fault @ LimitFault::Beyond { letter, is_rotary, .. }) => {
            let excess = fault.excess().unwrap_or_default();
            let text = if *is_rotary {
                // A decimal only where it fits into the column.
                let degrees = excess.to_degrees();
                if degrees < 9.95 {
                    format!("{letter} +{degrees:.1}°")
                } else {
                    format!("{letter} +{degrees:.0}°")
                }
            } else {
                format!("{letter} +{}", units.number(excess, 0))
            };
            (text, Condition::Interfering)
        }
        None => (format!("P {:.1}°", demand.pole_rad.to_degrees()), Condition::Blocked),
    };
    cell(ui, RichText::new(text).color(condition.text(ui.visuals())).strong());
}

/// The position of an axis: its name, and its value with its unit: degrees, or mm without one.
pub fn axis_text<N: std::fmt::Display>((name, value, unit): (N, f64, &str), units: DisplayUnits) -> String {
    match unit {
        "°" => with_minus_signs(&format!("{name} {value:.3}{unit}")),
        _ => format!("{name} {}", units.number(value, 3)),
    }
}

/// What a position asks of the axes, in words.
pub fn axis_remarks(ui: &mut Ui, state: &AppState, k: usize) {
    let Some((plan, demand)) = state.on_machine().zip(state.axis_demand(k)) else { return };
    if let Some(fault) = &demand.fault {
        ui.label(format!("{}: {fault}", plan.machine.name));
    } else if demand.is_near_pole() {
        let [first, angle] = [plan.machine.rotary[0].letter.to_string(), degrees(demand.pole_rad)];
        let ratio = 1.0 / demand.pole_rad.sin().max(1e-3);
        ui.label(format!(
            "{}: {angle} from the pole, the line of {first}, which turns {ratio:.0} times as much as the tool",
            plan.machine.name
        ));
    }
}

fn degrees(angle_rad: f64) -> String {
    format!("{:.1}°", angle_rad.to_degrees())
}
