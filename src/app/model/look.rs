//! How part and plan are displayed: selection, table rows, layers, arrangement of the two plans, timeline.
//! Nothing here changes the plan.

use serde::{Deserialize, Serialize};

use crate::drawing::flank::FlankColours;
use crate::gpu::scene::FloorColours;
use crate::plunge::inspect::CutPlane;
use crate::setup::{AxisPolicy, PlungePose};

use crate::app::model::cutter_colours::{CutterClass, CutterColours};
use crate::app::model::edit_fields::EditFields;
use crate::app::model::known_goals::KnownGoals;
use crate::app::model::mouse_preset::MousePreset;
use crate::app::model::panels::Panels;
use crate::app::model::planned::{PerSide, Side};
use crate::app::model::solid::SolidColours;
use crate::app::model::table_scroll::TableScroll;
use crate::app::model::units::DisplayUnits;

/// Visibility of the layers of the 3D view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layers {
    /// Hub, coloured by residual stock.
    pub hub: bool,
    /// Blades.
    pub blades: bool,
    /// Shroud, transparent.
    pub shroud: bool,
    /// Cutters at the end of their plunges.
    pub cutters: bool,
    /// Axes up to the retract points.
    pub axes: bool,
    /// Holders, above the stick-out of the tools.
    pub holders: bool,
    /// Rapids from retract point to retract point.
    pub links: bool,
    /// The stock as a solid, instead of hub and blades.
    pub stock: bool,
    /// The machine of the setup as simple solids.
    pub machine: bool,
    /// Quantity that colours the floor of the current channel.
    pub floor: FloorColours,
    /// Quantity that colours the cutters.
    pub cutter_colours: CutterColours,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            hub: true,
            blades: true,
            shroud: false,
            cutters: true,
            axes: false,
            holders: false,
            links: false,
            stock: false,
            machine: false,
            floor: FloorColours::Residual,
            cutter_colours: CutterColours::State,
        }
    }
}

/// Operations on the part. The selected one is shown and edited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Operation {
    /// Plunge roughing.
    #[default]
    Roughing,
    /// Flank milling.
    Flank,
    /// A program from anywhere that is checked.
    Program,
}

impl Operation {
    /// All, in the order of the list.
    pub const ALL: [Self; 3] = [Self::Roughing, Self::Flank, Self::Program];

    /// Label in the list of operations.
    pub fn label(self) -> &'static str {
        match self {
            Self::Roughing => "Roughing",
            Self::Flank => "Flank",
            Self::Program => "Program",
        }
    }
}

/// Display of the flank plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FlankLook {
    /// Whether the passes are shown.
    pub shown: bool,
    /// Quantity that colours them.
    pub colours: FlankColours,
    /// Timeline: number of moves made; `None`: all.
    pub cut: Option<usize>,
    /// Selected pass, index in cutting order.
    pub pass: Option<usize>,
    /// Whether the table scrolls to the selected pass in the next frame.
    pub reveal: bool,
}

/// Row filter of the position table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// All.
    #[default]
    All,
    /// Interfering plunges: their core meets stock.
    Interfering,
    /// Positions without the axis their policy asks for.
    Blocked,
    /// Positions beyond a limit of the machine or near its pole.
    AxisWarnings,
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 4] = [Self::All, Self::Interfering, Self::Blocked, Self::AxisWarnings];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::All => "All positions",
            Self::Interfering => "Interfering only",
            Self::Blocked => "Blocked only",
            Self::AxisWarnings => "Axis warnings only",
        }
    }
}

/// Columns of the position table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableColumn {
    /// Number in cutting order.
    #[default]
    Order,
    /// Row within its section.
    Row,
    /// Diameter of the tool.
    Diameter,
    /// Lead angle between hub normal and axis.
    Alpha,
    /// Depth of core contact.
    Contact,
    /// Residual stock under the cutter.
    Hub,
    /// Limits and pole of the machine.
    Axes,
}

impl TableColumn {
    /// All columns, left to right; the last one only with a machine.
    pub const ALL: [Self; 7] =
        [Self::Order, Self::Row, Self::Diameter, Self::Alpha, Self::Contact, Self::Hub, Self::Axes];

    /// Head of the column.
    pub fn label(self) -> &'static str {
        match self {
            Self::Order => "#",
            Self::Row => "Row",
            Self::Diameter => "D",
            Self::Alpha => "Lead °",
            Self::Contact => "Contact",
            Self::Hub => "Hub",
            Self::Axes => "Axes",
        }
    }

    /// Short name of the column's quantity.
    pub fn name(self) -> &'static str {
        match self {
            Self::Order => "cutting order",
            Self::Row => "row",
            Self::Diameter => "diameter",
            Self::Alpha => "lead angle",
            Self::Contact => "contact",
            Self::Hub => "residual stock",
            Self::Axes => "axis warnings",
        }
    }

    /// Tooltip: the column's quantity and unit.
    pub fn tip(self) -> &'static str {
        match self {
            Self::Order => "Number in cutting order",
            Self::Row => "Row within its section, 1 at the suction wall",
            Self::Diameter => "Diameter of the tool",
            Self::Alpha => "Lead angle: between hub normal and axis, positive towards the inlet",
            Self::Contact => "Height above the tip at which the core meets stock",
            Self::Hub => "Mean residual stock on the hub under the cutter",
            Self::Axes => {
                "Machine: how far an axis would be beyond its limits; or, below 5.7°, the angle of \
                 the tool axis from the pole, the line of the rotary axis nearest to the workpiece. Near it \
                 that axis turns by more than ten times as much as the tool"
            }
        }
    }
}

/// Order of the table's rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sort {
    /// Sort column.
    pub column: TableColumn,
    /// Largest first.
    pub descending: bool,
}

impl Sort {
    /// Order after a click on the head of `column`; a second click reverses it. Contact, residual stock and
    /// axis warnings start with the largest, as the worst positions are of interest.
    pub fn clicked(self, column: TableColumn) -> Self {
        if self.column == column {
            Self { column, descending: !self.descending }
        } else {
            Self {
                column,
                descending: matches!(column, TableColumn::Contact | TableColumn::Hub | TableColumn::Axes),
            }
        }
    }
}

/// Arrangement of the two plans in the middle of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// One plan alone.
    #[default]
    One,
    /// Both side by side, with one camera.
    Both,
    /// One over the other, with a divider to drag.
    Wipe,
}

/// Machine for which NC code is read and written unless another is chosen: that of `vanecut post`.
pub const DEFAULT_MACHINE: &str = "ac-trunnion";

/// Number of frames; see [`Look::reveal_selection`].
pub const REVEAL: u8 = 3;

/// Display state of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The selected operation.
    pub operation: Operation,
    /// Active side: shown alone, and described by table and sectional view.
    pub side: Side,
    /// Policy of each side; `None`: conventional before, the setup's after.
    pub policies: PerSide<Option<AxisPolicy>>,
    /// Arrangement of the sides.
    pub arrangement: Arrangement,
    /// Position of the wipe's divider, 0…1 of the width.
    pub wipe: f32,
    /// Selected position of the active side, index in cutting order.
    pub selected: Option<usize>,
    /// Channel of the selected position, in pitches ahead of channel 1: where the timeline runs through
    /// several, that of the plunge cut last.
    pub selected_channel: usize,
    /// Number of frames for which the table still scrolls to the selection, while the panel below takes its
    /// height.
    pub reveal_selection: u8,
    /// Row filter of the table.
    pub filter: Filter,
    /// Sort order of the rows.
    pub sort: Sort,
    /// Layers of the 3D view.
    pub layers: Layers,
    /// What the colours of the solid stock show.
    pub solid_colours: SolidColours,
    /// Display of the flank plan.
    pub flank: FlankLook,
    /// Timeline: number of positions of channel 1 that are cut; `None`: all.
    pub cut_count: Option<usize>,
    /// Number of channels whose plunges are shown, from the first of their sequence on. With more than one
    /// the timeline runs through all of them.
    pub shown_channels: usize,
    /// Timeline of several channels: number of plunges cut; `None`: all.
    pub channels_cut: Option<usize>,
    /// While the timeline plays: time of its last step, in seconds on the window's clock.
    pub playing: Option<f64>,
    /// Speed of playing; 1 is [`crate::app::model::state::PLAY_RATE`].
    pub play_speed: f64,
    /// Whether playing starts again at the end.
    pub play_loop: bool,
    /// Classes of cutters that are hidden while the colours show them.
    pub hidden_classes: Vec<CutterClass>,
    /// Scrolling of the table of positions.
    pub table: TableScroll,
    /// Whether the panels have not been drawn for this part yet: their scroll places and open headings are
    /// then those of a new part.
    pub is_fresh: bool,
    /// Ends of the colour scale, mm; `None`: fitted to the plan. The first finished plan sets them.
    pub range: Option<(f32, f32)>,
    /// Upper end of the colour scale of the walls, mm; `None`: fitted to the flank plan.
    pub wall_end: Option<f32>,
    /// Whether the floor of the after side shows residual stock after minus before.
    pub difference: bool,
    /// Selected fault of the checked program.
    pub finding: Option<usize>,
    /// Number of frames in which the list of faults scrolls to the selected one; see
    /// [`Look::reveal_selection`].
    pub reveal_finding: u8,
    /// Timeline of the checked program: number of moves made; `None`: all.
    pub program_cut: Option<usize>,
    /// Machine that checked NC code was posted for, by name or file; `None`: that of the setup.
    pub check_machine: Option<String>,
    /// Its control, or the file of its post; `None`: that of the machine.
    pub check_control: Option<String>,
    /// Whether the camera zooms to the selection in the next frame.
    pub fly: bool,
    /// Section plane, if shown.
    pub section: Option<SectionPlaneLook>,
    /// The one that was closed last: it opens as it was.
    pub closed_section: SectionPlaneLook,
    /// Measured points while measuring, mm; at most two.
    pub measure: Option<Vec<glam::Vec3>>,
    /// Which panels are open, and which float.
    pub panels: Panels,
    /// Tab of the selected position.
    pub tab: Tab,
    /// Fields of the tab that edits it.
    pub edit: EditFields,
    /// Goals that were given before.
    pub known_goals: KnownGoals,
    /// The plunge to be selected when the plan that cuts it in another order arrives, unless another one is
    /// selected before.
    pub followed: Option<PlungePose>,
    /// Display of the sectional view.
    pub sectional: SectionalLook,
    /// Mouse preset of the camera.
    pub mouse: MousePreset,
    /// Units of lengths and feed rates.
    pub units: DisplayUnits,
}

/// Display of the sectional view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionalLook {
    /// Its plane; `None`: through the deepest contact where the core meets stock, else along the row.
    pub plane: Option<CutPlane>,
    /// Part of the drawing beside the figures of the position.
    pub docked: DrawingPart,
    /// Part of the enlarged drawing.
    pub enlarged: DrawingPart,
}

/// The part of a drawing that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawingPart {
    /// Magnification; 1 shows all that matters.
    pub zoom: f64,
    /// Shift of the drawing to the right and down, points at zoom 1.
    pub pan: [f64; 2],
}

impl Default for DrawingPart {
    fn default() -> Self {
        Self { zoom: 1.0, pan: [0.0; 2] }
    }
}

/// Tabs of the selected position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tab {
    /// Sectional view through it.
    #[default]
    Section,
    /// Figures.
    Facts,
    /// What can be changed by hand.
    Edit,
}

/// Orientation of a section plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaneOrientation {
    /// Contains tool axis and cutting direction of the selected position.
    #[default]
    Row,
    /// Contains the axis of rotation and the selected position; its offset is an angle.
    Meridian,
    /// Normal to X.
    X,
    /// Normal to Y.
    Y,
    /// Normal to Z, the axis of rotation.
    Z,
}

impl PlaneOrientation {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Row, Self::Meridian, Self::X, Self::Y, Self::Z];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::Row => "Along the row",
            Self::Meridian => "Meridional",
            Self::X => "Normal to X",
            Self::Y => "Normal to Y",
            Self::Z => "Normal to Z",
        }
    }

    /// What stands before an offset that is a coordinate.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Row | Self::Meridian => "",
            Self::X => "X ",
            Self::Y => "Y ",
            Self::Z => "Z ",
        }
    }

    /// What the offset counts from.
    pub fn offset_tip(self) -> &'static str {
        match self {
            Self::Row => "Distance from the tip of the selected position, else of the middle one",
            Self::Meridian => {
                "Angle about the axis of rotation from the selected position, else the middle one"
            }
            Self::X | Self::Y | Self::Z => "Coordinate of the plane, from the zero of the part",
        }
    }

    /// Offset of the plane in the middle of a part whose middle is at the height `z`, mm, degrees.
    pub fn middle(self, z: f32) -> f32 {
        if self == Self::Z { z } else { 0.0 }
    }
}

/// A section plane of the 3D view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionPlaneLook {
    /// Orientation.
    pub across: PlaneOrientation,
    /// Coordinate of a plane normal to an axis, mm; distance along the normal from the tip of a position, mm;
    /// of a meridional plane the angle about the axis of rotation, degrees.
    pub offset: f32,
    /// Whether the other half is cut away.
    pub flipped: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            operation: Operation::Roughing,
            side: Side::After,
            policies: PerSide::default(),
            arrangement: Arrangement::One,
            wipe: 0.5,
            selected: None,
            selected_channel: 0,
            reveal_selection: 0,
            filter: Filter::All,
            sort: Sort::default(),
            layers: Layers::default(),
            solid_colours: SolidColours::default(),
            flank: FlankLook::default(),
            cut_count: None,
            shown_channels: 1,
            channels_cut: None,
            playing: None,
            play_speed: 1.0,
            play_loop: false,
            hidden_classes: Vec::new(),
            table: TableScroll::default(),
            is_fresh: true,
            range: None,
            wall_end: None,
            difference: false,
            finding: None,
            reveal_finding: 0,
            program_cut: None,
            check_machine: None,
            check_control: None,
            fly: false,
            section: None,
            closed_section: SectionPlaneLook::default(),
            measure: None,
            panels: Panels::default(),
            tab: Tab::Section,
            edit: EditFields::default(),
            known_goals: KnownGoals::default(),
            followed: None,
            sectional: SectionalLook::default(),
            mouse: MousePreset::default(),
            units: DisplayUnits::default(),
        }
    }
}

impl Look {
    /// The arrangement of the views: only roughing has two sides.
    pub fn shown_arrangement(&self) -> Arrangement {
        if self.operation == Operation::Roughing { self.arrangement } else { Arrangement::One }
    }

    /// Resets the display for another part; layers, panels, tab, mouse preset and units are kept.
    pub fn begin(&mut self) {
        let check_machine = self.check_machine.take();
        let check_control = self.check_control.take();
        let Self { layers, mut panels, tab, mouse, units, play_speed, .. } = *self;
        panels.begin();
        *self = Self {
            layers,
            panels,
            tab,
            mouse,
            units,
            play_speed,
            check_machine,
            check_control,
            ..Self::default()
        };
    }

    /// Shows the section plane, or closes it.
    pub fn switch_section(&mut self) {
        match self.section.take() {
            Some(shown) => self.closed_section = shown,
            None => self.section = Some(self.closed_section),
        }
    }

    /// Selects a position and zooms to it.
    pub fn select_and_zoom(&mut self, position: Option<usize>) {
        self.select(position);
        self.fly = position.is_some();
    }

    /// Selects a position of channel 1 and scrolls the table to it. A timeline that is not at the end moves
    /// along, so that the selected position is the one cut last.
    pub fn select(&mut self, position: Option<usize>) {
        (self.selected, self.selected_channel, self.followed) = (position, 0, None);
        self.reveal_selection = if position.is_some() { REVEAL } else { 0 };
        if let (Some(_), Some(k)) = (self.cut_count, position) {
            self.cut_count = Some(k + 1);
        }
    }
}
