//! The plane that cuts the 3D view open.

use glam::{Quat, Vec3};

use crate::app::model::look::{PlaneOrientation, SectionPlaneLook};
use crate::app::model::state::AppState;
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
        PlaneOrientation::Z => {
            let middle = 0.5 * (part.hub.point(0.0).z + part.hub.point(1.0).z);
            (Vec3::Z, Vec3::Z * middle as f32)
        }
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
