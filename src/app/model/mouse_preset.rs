//! Mouse presets of the camera, by the names of the programs that they match.

use serde::{Deserialize, Serialize};

/// Assignment of mouse buttons, named after the program it matches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MousePreset {
    /// Vanecut's own: works with two buttons.
    #[default]
    Vanecut,
    /// CAD: the middle button orbits, shift pans.
    Nx,
    /// CAD: the middle button orbits, control pans.
    Solidworks,
    /// CAD: the right button orbits, the middle one pans.
    Onshape,
    /// Middle button, or left with alt.
    Blender,
}
