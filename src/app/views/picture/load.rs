//! Loading the scene of a picture. Every loader compares with what is loaded, and does nothing if that is the
//! same.

use std::sync::Arc;

use super::coloured::ColouredCutters;
use super::{Content, ShownFlank, SidePicture};
use crate::app::model::checked::CheckedProgram;
use crate::app::model::cutter_colours::{CutterClass, CutterColours};
use crate::app::model::machine::ShownMachine;
use crate::app::model::preview::ShownCutters;
use crate::app::model::state::ShownPlan;
use crate::app::tasks::solid::SolidPicture;
use crate::drawing::cutters::cutter_set;
use crate::drawing::flank::{self, FlankColours};
use crate::drawing::floor::{contact_mesh, floor_meshes, value_mesh};
use crate::gpu::cutters::DrawnChannel;
use crate::gpu::mesh::{Mesh, Segment};

impl SidePicture {
    /// Loads the content; does nothing if it is loaded already.
    pub fn load(&mut self, content: Option<Content>) {
        let (same_picture, same_plan, same_heights) = match (&self.content, &content) {
            (Some(old), Some(new)) => (old.same_picture(new), old.same_plan(new), old.same_heights(new)),
            (None, None) => (true, true, true),
            _ => (false, false, false),
        };
        let was_difference = self.content.as_ref().is_some_and(|content| content.more_than.is_some());
        self.content = content;
        // Heights of the core that arrive later are not drawn; they are read under the cursor.
        if same_picture && (same_heights || self.stock_floor.is_some()) {
            return;
        }
        self.generation += 1;
        let content = self.content.as_ref();
        let plan = content.map(|content| content.planned.plan(content.policy));
        if !same_plan {
            self.scene.set_cutters(plan.map(cutter_set).unwrap_or_default());
        }
        // Walls replace the floor; `load_flank` loads the floor again afterwards.
        if self.shows_walls() {
            return;
        }
        let grid = content.map(|content| &*content.planned.outcome.grid);
        let contact = || grid.zip(plan).map(|(grid, plan)| contact_mesh(grid, plan));
        if self.stock_floor.is_some() {
            // The stock itself is computed when it is drawn, at the resolution of the picture.
            self.scene.set_floor(&self.gpu, None);
            self.scene.set_contact(&self.gpu, contact().as_ref());
            return;
        }
        let values = content.map(|content| {
            (0..content.planned.outcome.grid.points.len())
                .map(|cell| content.value(cell).unwrap_or_default())
                .collect::<Vec<f32>>()
        });
        let floor = grid.zip(values.as_deref());
        match (floor, content.is_some_and(|content| content.more_than.is_some())) {
            (Some((grid, values)), true) => {
                if let Some(mesh) = value_mesh(grid, values) {
                    self.scene.set_values(&self.gpu, mesh);
                }
            }
            (Some((grid, heights)), false) if same_plan && !was_difference => {
                if let Some(meshes) = floor_meshes(grid, heights) {
                    self.scene.set_heights(&self.gpu, meshes);
                }
            }
            (floor, _) => {
                let meshes = floor.and_then(|(grid, heights)| floor_meshes(grid, heights));
                self.scene.set_floor(&self.gpu, meshes);
                self.scene.set_contact(&self.gpu, contact().as_ref());
            }
        }
    }

    /// Colours the cutters of the loaded content, one of the plans `in_view`, and leaves out those of the
    /// hidden classes of these colours; does nothing if that is so already.
    pub fn load_cutter_colours(
        &mut self,
        colours: CutterColours,
        hidden: &[CutterClass],
        in_view: &[ShownPlan],
    ) {
        let wanted = self.content.as_ref().map(|content| ColouredCutters {
            colours,
            hidden: hidden.to_vec(),
            planned: Arc::clone(&content.planned),
            policy: content.policy,
            in_view: in_view.iter().map(|shown| (Arc::clone(shown.planned), shown.policy)).collect(),
        });
        if self.coloured == wanted {
            return;
        }
        if let Some(ColouredCutters { hidden, planned, policy, .. }) = &wanted {
            let hid = self.coloured.as_ref().is_some_and(|coloured| !coloured.hidden.is_empty());
            if hid || !hidden.is_empty() {
                let plan = planned.plan(*policy);
                let mut set = cutter_set(plan);
                let is_hidden = |index| colours.class_of(plan, index).is_some_and(|c| hidden.contains(&c));
                set.cutters.retain(|cutter| !is_hidden(cutter.instance.id as usize));
                self.scene.set_cutters(set);
            }
        }
        let of_plan = wanted.as_ref().and_then(|wanted| {
            let shown = ShownPlan { planned: &wanted.planned, policy: wanted.policy };
            colours.of_plan(&shown, &colours.key(in_view))
        });
        self.scene.set_cutter_colours(of_plan.as_deref());
        self.coloured = wanted;
        self.generation += 1;
    }

    /// Shows the passes of a flank plan, or none; does nothing if they are shown already.
    pub fn load_flank(&mut self, shown: Option<ShownFlank>) {
        if self.flank == shown {
            return;
        }
        let walls = |shown: Option<&ShownFlank>| {
            shown.filter(|shown| shown.colours == FlankColours::Walls).map(|shown| Arc::as_ptr(&shown.run))
        };
        let same_walls = walls(self.flank.as_ref()) == walls(shown.as_ref());
        let lines = shown.as_ref().map(ShownFlank::lines);
        self.scene.set_paths(&self.gpu, &lines.unwrap_or_default());
        if self.shows_walls() && !same_walls {
            // Forces the floor to be loaded again.
            self.clear_floor();
            self.content = None;
        }
        self.flank = shown;
        if let Some(flank) = self.flank.as_ref().filter(|_| self.shows_walls() && !same_walls) {
            let outcome = &flank.run.outcome;
            let (mesh, _) = flank::wall_deviations(&outcome.workpiece.part, &outcome.shown_walls());
            // All channels are cut alike.
            let mut walls = Mesh::default();
            flank.run.turns_rad().iter().for_each(|&turn| walls.append(&mesh.rotated_about_z(turn)));
            self.scene.set_values(&self.gpu, walls);
        }
        self.generation += 1;
    }

    /// Shows the moves of a checked program, or none; does nothing if they are shown already. Call after
    /// [`Self::load_flank`], whose lines they replace.
    pub fn load_program(&mut self, shown: Option<&Arc<CheckedProgram>>) {
        let same = match (&self.program, shown) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if same {
            return;
        }
        if shown.is_some() || self.flank.is_none() {
            self.scene.set_paths(&self.gpu, shown.map_or(&[], |checked| &checked.lines));
        }
        self.program = shown.cloned();
        self.generation += 1;
    }

    /// Shows these cutters, those of a running plan for example, instead of the plan's; `None`: the plan's.
    pub fn load_preview(&mut self, preview: Option<&ShownCutters>) {
        let same = match (&self.preview, preview) {
            (Some(a), Some(b)) => a.is_same(b),
            (None, None) => true,
            _ => false,
        };
        if !same {
            self.scene.set_preview(preview.map(|preview| Arc::clone(&preview.cutters)));
            self.preview = preview.cloned();
            self.generation += 1;
        }
    }

    /// Draws the cutters in these channels, too; does nothing if they are drawn already.
    pub fn load_channels(&mut self, channels: Vec<DrawnChannel>) {
        if self.channels != channels {
            self.scene.set_channels(channels.clone());
            self.channels = channels;
            self.generation += 1;
        }
    }

    /// Shows section borders as lines on the floor.
    pub fn load_borders(&mut self, lines: Vec<Segment>) {
        if self.borders != lines {
            self.scene.set_borders(&self.gpu, &lines);
            self.borders = lines;
            self.generation += 1;
        }
    }

    /// Shows the stock as a solid, or nothing of it; see [`crate::gpu::SceneOptions::show_solid`].
    pub fn load_solid(&mut self, solid: Option<Arc<SolidPicture>>) {
        let same = match (&self.solid, &solid) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            self.scene.set_solid(&self.gpu, solid.as_ref().map(|solid| Arc::clone(&solid.mesh)));
            // A card draws the fine one fast enough.
            let draft = solid.as_ref().and_then(|solid| solid.draft.as_ref());
            if let Some(draft) = draft.filter(|_| self.gpu.is_software()) {
                self.scene.set_solid_draft(&self.gpu, draft);
            }
            self.solid = solid;
            self.generation += 1;
        }
    }

    /// Shows a machine, or none.
    pub fn load_machine(&mut self, machine: Option<ShownMachine>) {
        let same = match (&self.machine, &machine) {
            (Some(a), Some(b)) => a.is_same(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            let mesh = machine.as_ref().and_then(ShownMachine::mesh);
            self.scene.set_machine(&self.gpu, mesh.as_ref());
            self.machine = machine;
            self.generation += 1;
        }
    }

    /// Draws a mesh over the scene, coloured by its values; `None` removes it.
    pub fn highlight(&mut self, mesh: Option<Mesh>) {
        match mesh {
            Some(mesh) => self.scene.set_values(&self.gpu, mesh),
            None => self.clear_floor(),
        }
        self.generation += 1;
    }

    fn clear_floor(&mut self) {
        self.scene.set_floor(&self.gpu, None);
        self.scene.set_contact(&self.gpu, None);
    }
}
