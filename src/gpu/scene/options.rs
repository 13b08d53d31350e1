//! The display options of a scene.

use std::str::FromStr;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::error::UserError;
use crate::gpu::camera::ViewRay;
use crate::gpu::cutters::{CutterChoice, CutterFilter};
use crate::gpu::unknown_colours;
use crate::palette::{ColourMap, Theme};

/// Quantity shown as colours on the floor of the active channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorColours {
    /// Height of stock left above the finished hub.
    #[default]
    Residual,
    /// Contact depth of the cores that end there.
    Interference,
    /// Other values per corner of the floor, set by [`super::Scene::set_values`].
    Values,
    /// Residual stock on the walls of the channel, set by [`super::Scene::set_values`]; the walls replace the
    /// blades.
    Walls,
    /// No colours.
    Plain,
}

/// Display options of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Hub of the wheel, with its body.
    pub show_hub: bool,
    /// Blades.
    pub show_blades: bool,
    /// Shroud, transparent.
    pub show_shroud: bool,
    /// Which cutters are shown.
    pub show_cutters: CutterFilter,
    /// Axes of the shown cutters, from tip to retract point.
    pub show_axes: bool,
    /// Holders of the cutters drawn at full length.
    pub show_holders: bool,
    /// Rapids from retract point to retract point.
    pub show_links: bool,
    /// Colours of the floor.
    pub show_floor_colours: FloorColours,
    /// The stock as a solid, instead of hub and blades; see [`super::Scene::set_solid`].
    pub show_solid: bool,
    /// The machine; see [`super::Scene::set_machine`].
    pub show_machine: bool,
    /// Draws stock raised by its height instead of as flat colours on the hub.
    pub relief: bool,
    /// Draws the walls of the active channel transparent where they hide it.
    pub cut_away: bool,
    /// Values at the ends of the colour table, mm.
    pub range_mm: (f32, f32),
    /// Colour table of floor and wall values.
    pub map: ColourMap,
    /// Light or dark.
    pub theme: Theme,
    /// Shows only positions before this one, the last of them at full length.
    pub up_to: Option<usize>,
    /// Draws the last of them like the others: the tool is in another channel.
    pub hides_last: bool,
    /// Selected position.
    pub selected: Option<usize>,
    /// Drawn length, in diameters, of sound cutters that are neither selected nor last; faulty ones are
    /// longer.
    pub cutter_stub: f32,
    /// Physical pixels per logical point, so that lines keep their width on high-density screens.
    pub pixel_scale: f32,
    /// Section plane; the part beyond it is not drawn.
    pub section: Option<SectionPlane>,
    /// Borders between sections.
    pub show_borders: bool,
    /// Leaves the background transparent.
    pub transparent: bool,
    /// Draft quality for speed: coarser meshes, cutters with fewer facets.
    pub draft: bool,
}

/// A plane that clips the part (world frame).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlane {
    /// Unit normal; the side it points to is clipped away.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal, mm.
    pub offset: f32,
}

impl SectionPlane {
    /// Interval of a ray (mm along it) that is not clipped; `None` when all of it is.
    pub(super) fn unclipped_interval(&self, ray: &ViewRay) -> Option<(f32, f32)> {
        let (height, slope) = (self.normal.dot(ray.origin) - self.offset, self.normal.dot(ray.direction));
        if slope.abs() < 1e-9 {
            return (height <= 0.0).then_some((0.0, f32::INFINITY));
        }
        let at = -height / slope;
        if slope > 0.0 { (at > 0.0).then_some((0.0, at)) } else { Some((at.max(0.0), f32::INFINITY)) }
    }
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            show_hub: true,
            show_blades: true,
            show_shroud: false,
            show_cutters: CutterFilter::All,
            show_axes: false,
            show_holders: false,
            show_links: false,
            show_floor_colours: FloorColours::Residual,
            show_solid: false,
            show_machine: false,
            relief: false,
            cut_away: true,
            range_mm: (0.0, 4.0),
            map: ColourMap::Cividis,
            theme: Theme::Light,
            up_to: None,
            hides_last: false,
            selected: None,
            cutter_stub: 0.15,
            pixel_scale: 1.0,
            section: None,
            show_borders: false,
            transparent: false,
            draft: false,
        }
    }
}

impl FromStr for FloorColours {
    type Err = UserError;

    fn from_str(word: &str) -> Result<Self, UserError> {
        Ok(match word {
            "residual" => Self::Residual,
            "interference" => Self::Interference,
            "plain" => Self::Plain,
            _ => {
                let help = "use residual, interference, plain or solid";
                return Err(unknown_colours(word, help));
            }
        })
    }
}

impl SceneOptions {
    /// Default options for a picture of `colours`. Cutters are shown for interference only; elsewhere they
    /// would hide the floor.
    pub fn for_colours(colours: FloorColours) -> Self {
        let show_cutters = match colours {
            FloorColours::Interference => CutterFilter::All,
            FloorColours::Residual | FloorColours::Values | FloorColours::Walls | FloorColours::Plain => {
                CutterFilter::Hidden
            }
        };
        Self { show_floor_colours: colours, show_cutters, ..Self::default() }
    }

    /// Which cutters are drawn with these options, and how.
    pub fn cutter_choice(&self) -> CutterChoice {
        CutterChoice {
            filter: self.show_cutters,
            up_to: self.up_to,
            hides_last: self.hides_last,
            selected: self.selected,
            stub: self.cutter_stub,
        }
    }
}
