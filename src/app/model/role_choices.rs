//! Choices of the roles dialog: initial guess, edits, and conversion to mesh options.

use crate::mesh::axis::Axis;
use crate::mesh::nodes::{MeshNode, guess_roles, revolution_axis_of, wheel_width};
use crate::mesh::options::{FileUnit, likely_unit};
use crate::mesh::{LengthUnit, MeshOptions, Role};
use crate::part::Rotation;

/// Choices of the roles dialog.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleChoices {
    /// Roles of the nodes.
    pub roles: Vec<Option<Role>>,
    /// Unit of the file's numbers.
    pub unit: LengthUnit,
    /// What the format says of it.
    pub file_unit: FileUnit,
    /// Axis of rotation; `None`: found from the hub.
    pub axis: Option<Axis>,
    /// Number of main blades; `None`: as many as the file has.
    pub blades: Option<usize>,
    /// Sense of rotation; `None`: from the file, else from the sweep of the blades.
    pub rotation: Option<Rotation>,
    /// Index of the selected node.
    pub selected: Option<usize>,
    /// Whether the keyboard changed the selection, so that the list scrolls to it.
    pub scroll_to_selected: bool,
    /// Whether a role applies to all nodes of the same shape.
    pub apply_to_identical: bool,
}

impl RoleChoices {
    /// Initial choices: from `said`, the options given before, else from names and, with `is_guessed`, from
    /// shapes. A part that opened needs no guess: what has no role is left to the reader, which knows more of
    /// the shapes.
    pub fn new(nodes: &[MeshNode], file_unit: FileUnit, said: &MeshOptions, is_guessed: bool) -> Self {
        let by_name = || nodes.iter().map(|node| node.named_role).collect();
        let mut roles = if is_guessed { guess_roles(nodes) } else { by_name() };
        for (node, role) in nodes.iter().zip(&mut roles) {
            let own = |key: &str| key == node.key || key.to_lowercase() == node.name.to_lowercase();
            if let Some((_, given)) = said.roles.iter().rev().find(|(key, _)| own(key)) {
                *role = Some(*given);
            }
        }
        let mut choices = Self {
            roles,
            unit: file_unit.own(),
            file_unit,
            axis: said.axis,
            blades: said.blades,
            rotation: said.rotation,
            selected: None,
            scroll_to_selected: false,
            apply_to_identical: true,
        };
        if file_unit != FileUnit::Stated {
            let (across, own) = (choices.wheel_width(nodes), file_unit.own());
            choices.unit = said.unit.or_else(|| likely_unit(across, own)).unwrap_or(own);
        }
        choices
    }

    /// Whether the reader finds hub and blades by itself, as no node has the role of either.
    pub fn are_roles_found(&self) -> bool {
        !self.roles.iter().any(|role| matches!(role, Some(Role::Hub | Role::Blade)))
    }

    /// Names of the nodes that are left out: those without a role, where hub and blades have theirs.
    pub fn left_out<'n>(&self, nodes: &'n [MeshNode]) -> Vec<&'n str> {
        if ![Role::Hub, Role::Blade].iter().all(|role| self.roles.contains(&Some(*role))) {
            return Vec::new();
        }
        let without = nodes.iter().zip(&self.roles).filter(|(_, role)| role.is_none());
        without.map(|(node, _)| node.name.as_str()).collect()
    }

    /// The choices as mesh options; roles that follow from names are left out.
    pub fn options(&self, nodes: &[MeshNode]) -> MeshOptions {
        let named = |(node, role): (&MeshNode, &Option<Role>)| {
            // A node without role whose name implies one must be ignored explicitly.
            let role = role.or(node.named_role.map(|_| Role::Ignored))?;
            (node.named_role != Some(role)).then(|| (node.key.clone(), role))
        };
        MeshOptions {
            roles: nodes.iter().zip(&self.roles).filter_map(named).collect(),
            unit: match self.file_unit {
                FileUnit::Stated => None,
                FileUnit::Specified(own) => Some(self.unit).filter(|unit| *unit != own),
                // Nothing is assumed any more.
                FileUnit::Assumed(_) => Some(self.unit),
            },
            axis: self.axis,
            blades: self.blades,
            rotation: self.rotation,
        }
    }

    /// Sets the role of the selected node and, with `apply_to_identical`, of all nodes of the same shape.
    pub fn set_role(&mut self, nodes: &[MeshNode], role: Option<Role>) {
        let Some(chosen) = self.selected.and_then(|k| nodes.get(k)) else { return };
        for (node, own) in nodes.iter().zip(&mut self.roles) {
            if node.node == chosen.node || self.apply_to_identical && node.is_like(chosen) {
                *own = role;
            }
        }
    }

    /// Largest extent of the nodes of the wheel along an axis, in the file's unit.
    pub fn wheel_width(&self, nodes: &[MeshNode]) -> f64 {
        wheel_width(nodes, &self.roles)
    }

    /// The file's axis that is vertical in the picture: the given one, else the axis of revolution of the
    /// hub or, without one, of all nodes.
    pub fn vertical_axis(&self, nodes: &[MeshNode]) -> Axis {
        let hub = || nodes.iter().zip(&self.roles).find(|(_, role)| **role == Some(Role::Hub));
        let of_hub = || hub().map(|(node, _)| node.revolution_axis());
        self.axis.or_else(of_hub).unwrap_or_else(|| revolution_axis_of(nodes))
    }
}

/// A help text with command line options replaced by the dialog's terms.
pub fn hint_for_dialog(help: &str) -> String {
    [
        ("--role NODE=", "the role "),
        ("NODE=", ""),
        ("--rotation-axis", "the axis of rotation"),
        ("--rotation cw", "the sense of rotation clockwise"),
        ("--rotation ccw", "the sense of rotation counter-clockwise"),
        ("--rotation", "the sense of rotation"),
        ("their number with --blades N", "the number of main blades"),
        ("--blades N", "the number of main blades"),
        ("--unit", "the unit"),
    ]
    .iter()
    .fold(help.to_owned(), |text, (option, words)| text.replace(option, words))
}
