//! What is uploaded of the cutters for a picture: instances, lines and caps.

use super::cutter_caps::{CutterCap, append_caps};
use super::cutters::{self, CutterChoice, CutterInstance, DrawnCutter};
use super::mesh::Segment;
use super::scene::SceneOptions;

/// The cutters that a picture shows.
#[derive(Default)]
pub(super) struct DrawnCutters {
    pub instances: Vec<CutterInstance>,
    pub lines: Vec<Segment>,
    pub caps: Vec<CutterCap>,
}

impl DrawnCutters {
    /// Adds a cutter if `choice` shows it. Its rims have `steps` facets; without `has_rims` only one that is
    /// selected or at full length has any.
    pub fn add(
        &mut self,
        cutter: &DrawnCutter,
        choice: &CutterChoice,
        options: &SceneOptions,
        steps: usize,
        has_rims: bool,
    ) {
        let Some(instance) = choice.instance(cutter) else { return };
        let selected = choice.selected == Some(instance.id as usize);
        let whole = instance.height >= cutter.instance.height;
        if has_rims || selected || whole {
            cutters::append_rims(&instance, steps, whole, &mut self.lines);
        }
        if options.show_holders && whole {
            cutters::append_holder(cutter, &mut self.lines);
        }
        if options.show_axes || selected {
            self.lines.push(cutters::axis_line(cutter, selected));
        }
        if let Some(plane) = &options.section {
            append_caps(cutter, &instance, options.show_holders && whole, plane, &mut self.caps);
        }
        self.instances.push(instance);
    }
}
