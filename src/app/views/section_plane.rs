//! The plane that cuts the 3D view open, and its controls.

use std::cell::RefCell;

use egui::{ComboBox, Id, Rect, Slider, Ui, Vec2};
use glam::{Quat, Vec3};

use super::overlay::{VIEW_BUTTONS, floating};
use super::panels::fields::{self, FieldSpec};
use super::typed::{self, TypedLimits};
use crate::app::model::look::{Look, PlaneOrientation, SectionPlaneLook};
use crate::app::model::state::AppState;
use crate::app::model::units::DisplayUnits;
use crate::gpu::scene::SectionPlane;
use crate::plunge::PlungePlan;
use crate::plunge::inspect::feed_direction;

/// The section plane in the part's frame; `None` if it needs a position and there is none.
pub(super) fn section_plane(state: &AppState, section: SectionPlaneLook) -> Option<SectionPlane> {
    let part = &state.document.part.as_ref()?.impeller;
    let to = |v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32));
    // The selected position, else one in the middle of the plan.
    let index = |plan: &PlungePlan| state.look.selected.unwrap_or(plan.positions.len() / 2);
    let turn = state.selected_turn_rad() as f32;
    let (normal, through) = match section.across {
        PlaneOrientation::Meridian => {
            let plan = state.shown().map(|shown| shown.plan());
            let position = plan.and_then(|plan| plan.positions.get(index(plan)));
            let at = position.map_or(0.0, |position| position.tip.y.atan2(position.tip.x) as f32) + turn;
            let (sin, cos) = (at + section.offset.to_radians()).sin_cos();
            let normal = Vec3::new(-sin, cos, 0.0) * if section.flipped { -1.0 } else { 1.0 };
            return Some(SectionPlane { normal, offset: 0.0 });
        }
        PlaneOrientation::X => (Vec3::X, Vec3::ZERO),
        PlaneOrientation::Y => (Vec3::Y, Vec3::ZERO),
        PlaneOrientation::Z => (Vec3::Z, Vec3::ZERO),
        PlaneOrientation::Row => {
            let plan = state.shown()?.plan();
            let k = index(plan);
            let position = plan.positions.get(k)?;
            let feed = to(feed_direction(part, plan, k).into());
            let to_channel = Quat::from_rotation_z(turn);
            let normal = feed.cross(to(position.axis.into()));
            (to_channel * normal, to_channel * to(position.tip.coords.into()))
        }
    };
    let normal = if section.flipped { -normal } else { normal };
    let moved = if section.flipped { -section.offset } else { section.offset };
    Some(SectionPlane { normal, offset: normal.dot(through) + moved })
}

/// Largest size of the controls of the section plane in two rows.
const SECTION_BAR: Vec2 = egui::vec2(300.0, 58.0);
/// Height of a third row.
const SECTION_ROW: f32 = 24.0;

/// Whether the controls of the section plane do not fit beside the buttons of views.
fn is_narrow(rect: Rect) -> bool {
    rect.width() < SECTION_BAR.x + VIEW_BUTTONS.x + 30.0
}

/// How far the controls of the section plane reach up from the lower edge of the view. In a narrow view they
/// stand above its buttons, in one row more.
pub fn section_bar_height(rect: Rect) -> f32 {
    let raised = if is_narrow(rect) { VIEW_BUTTONS.y + 10.0 + SECTION_ROW } else { 0.0 };
    SECTION_BAR.y + 10.0 + raised
}

/// Where the controls of the section plane stand in the view `rect`.
pub fn section_bar_rect(rect: Rect) -> Rect {
    let width = (rect.width() - 20.0).min(SECTION_BAR.x);
    let corner = egui::pos2(rect.min.x + 10.0, rect.max.y - section_bar_height(rect));
    let height = SECTION_BAR.y + if is_narrow(rect) { SECTION_ROW } else { 0.0 };
    Rect::from_min_size(corner, egui::vec2(width, height))
}

/// The side that is cut away, and what closes the section; `true` when it was clicked.
fn side_and_close(ui: &mut Ui, flipped: &mut bool) -> bool {
    ui.checkbox(flipped, "Flip").on_hover_text("Cuts away the other half");
    ui.small_button("Close").clicked()
}

/// Controls of the section plane through what lies within `bounds`, centre and radius: orientation, offset,
/// side.
pub fn section_bar(ui: &mut Ui, rect: Rect, look: &mut Look, bounds: (Vec3, f32)) {
    let units = look.units;
    let Some(section) = &mut look.section else { return };
    let (narrow, at) = (is_narrow(rect), section_bar_rect(rect));
    let (mut close, width) = (false, at.width());
    floating(ui, at, |ui| {
        ui.set_width(width - 8.0);
        let title = ui
            .horizontal(|ui| {
                let title = ui.label("Section plane");
                ComboBox::from_id_salt("section plane")
                    .width(96.0)
                    .selected_text(section.across.label())
                    .show_ui(ui, |ui| {
                        for across in PlaneOrientation::ALL {
                            if ui.selectable_value(&mut section.across, across, across.label()).changed() {
                                section.offset = across.middle(bounds.0.z);
                            }
                        }
                    })
                    .response
                    .labelled_by(title.id);
                if !narrow {
                    close = side_and_close(ui, &mut section.flipped);
                }
                title
            })
            .inner;
        if narrow {
            close = ui.horizontal(|ui| side_and_close(ui, &mut section.flipped)).inner;
        }
        ui.spacing_mut().slider_width = width - 90.0;
        section_offset(ui, section, (units, bounds), title.id);
    });
    if close {
        look.switch_section();
    }
}

/// The slider of the offset of the section plane through what lies within `bounds`, with a typed offset that
/// is not taken. `title`: what names it.
fn section_offset(
    ui: &mut Ui,
    section: &mut SectionPlaneLook,
    (units, bounds): (DisplayUnits, (Vec3, f32)),
    title: Id,
) {
    let (middle, reach) = (f64::from(section.across.middle(bounds.0.z)), f64::from(bounds.1));
    let tip = section.across.offset_tip();
    let spec = match section.across {
        PlaneOrientation::Meridian => FieldSpec::degrees("Offset", tip, -180.0, 180.0),
        _ => FieldSpec::mm("Offset", tip, middle - reach, middle + reach),
    };
    let spec = FieldSpec { decimals: 1, ..spec };
    let show = |offset: f64| fields::show(offset, &spec, units);
    let (quantity, range) = (spec.quantity, spec.min..=spec.max);
    let limits = TypedLimits { quantity, units, range, why_least: "", why_most: "", show: &show };
    let (shown, typed) = (show(section.offset.into()), RefCell::default());
    let slider = Slider::new(&mut section.offset, spec.min as f32..=spec.max as f32)
        .prefix(section.across.prefix())
        .custom_formatter(|offset, _| show(offset))
        .custom_parser(|text| limits.parse(text, &shown, &typed))
        .update_while_editing(false);
    let response = ui.add(slider).labelled_by(title).on_hover_text(spec.tip);
    let (form, offset) = (Id::unique("section plane"), section.offset.into());
    typed::keep(ui, form, spec.label, offset, typed.into_inner());
    typed::show(ui, form, spec.label, offset, response.rect);
}
