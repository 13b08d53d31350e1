//! How part and plan are looked at: selection, rows of the table, layers, which plans stand side by side, and
//! how far the cut has come. Nothing here changes what is planned.

use crate::gpu::flank::FlankColours;
use crate::gpu::scene::FloorColours;
use crate::part::AxisPolicy;

use super::mouse::MousePreset;
use super::planned::Side;

/// What the 3D view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// Hub, coloured by the stock left.
    pub hub: bool,
    /// Blades.
    pub blades: bool,
    /// Shroud, as glass.
    pub shroud: bool,
    /// Cutters at the end of their plunges.
    pub cutters: bool,
    /// Axes up to the retract points.
    pub axes: bool,
    /// Holders above the overhang of the cutters.
    pub holders: bool,
    /// Rapids from retract point to retract point.
    pub links: bool,
    /// What colours the floor of the channel in work.
    pub floor: FloorColours,
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
            floor: FloorColours::Residual,
        }
    }
}

/// What is shown of the flank plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FlankLook {
    /// Whether its curves are.
    pub shown: bool,
    /// What their colours tell.
    pub colours: FlankColours,
}

/// What rows the table of positions shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// All.
    #[default]
    All,
    /// Those whose core meets stock.
    Interferential,
    /// Those whose axis could not be had.
    Blocked,
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::All, Self::Interferential, Self::Blocked];

    /// Word in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::All => "All positions",
            Self::Interferential => "Interferential only",
            Self::Blocked => "Blocked only",
        }
    }
}

/// Columns of the table of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Column {
    /// Place in the cutting order.
    #[default]
    Order,
    /// Row within its section.
    Row,
    /// Diameter of the cutter.
    Diameter,
    /// Angle between hub normal and axis.
    Alpha,
    /// Depth of contact of the core.
    Contact,
    /// Stock left under the cutter.
    Hub,
}

impl Column {
    /// All columns, left to right.
    pub const ALL: [Self; 6] =
        [Self::Order, Self::Row, Self::Diameter, Self::Alpha, Self::Contact, Self::Hub];

    /// Head of the column.
    pub fn label(self) -> &'static str {
        match self {
            Self::Order => "#",
            Self::Row => "Row",
            Self::Diameter => "D",
            Self::Alpha => "α °",
            Self::Contact => "Contact",
            Self::Hub => "Hub",
        }
    }

    /// What the column holds, in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::Order => "cutting order",
            Self::Row => "row",
            Self::Diameter => "diameter",
            Self::Alpha => "tilt",
            Self::Contact => "contact",
            Self::Hub => "stock",
        }
    }

    /// What the column holds.
    pub fn tip(self) -> &'static str {
        match self {
            Self::Order => "Place in the cutting order",
            Self::Row => "Row within its section, 1 at the suction wall",
            Self::Diameter => "Diameter of the cutter, mm",
            Self::Alpha => "Angle between hub normal and axis, positive towards the inlet",
            Self::Contact => "How far above its final bottom the core meets stock, mm",
            Self::Hub => "Mean stock left on the hub under the cutter, mm",
        }
    }
}

/// Order of the table's rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sort {
    /// By which column.
    pub column: Column,
    /// Largest first.
    pub descending: bool,
}

impl Sort {
    /// What a click on the head of `column` makes of it: that column, and the other way round at the second click.
    /// Contact and stock begin with the largest: that is what one looks for.
    pub fn clicked(self, column: Column) -> Self {
        if self.column == column {
            Self { column, descending: !self.descending }
        } else {
            Self { column, descending: matches!(column, Column::Contact | Column::Hub) }
        }
    }
}

/// How the two plans share the middle of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// One of them.
    #[default]
    One,
    /// Both side by side, one camera.
    Both,
    /// One over the other, with a border to drag.
    Wipe,
}

/// See [`Look::reveal_selection`].
pub const REVEAL: u8 = 3;

/// How everything is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Side that is shown alone, and that table and section speak of.
    pub side: Side,
    /// Policies on either side; `None`: conventional before, the setup's after.
    pub policies: [Option<AxisPolicy>; 2],
    /// How the sides share the view.
    pub arrangement: Arrangement,
    /// Place of the wipe's border, 0…1.
    pub wipe: f32,
    /// Selected position of the shown side, in cutting order.
    pub selected: Option<usize>,
    /// For how many more pictures the table scrolls to the selection: the panel below it may take its height meanwhile.
    pub reveal_selection: u8,
    /// Rows of the table.
    pub filter: Filter,
    /// Their order.
    pub sort: Sort,
    /// Layers of the 3D view.
    pub layers: Layers,
    /// What it shows of the flank plan.
    pub flank: FlankLook,
    /// Number of positions that are cut; `None`: all.
    pub cut: Option<usize>,
    /// While the timeline runs by itself: when it stepped last, in seconds on the window's clock.
    pub playing: Option<f64>,
    /// Ends of the colour scale, mm; `None`: they fit what is shown.
    pub range: Option<(f32, f32)>,
    /// Whether the floor shows how much more the one plan leaves than the other.
    pub difference: bool,
    /// Whether the camera should fly to the selection.
    pub fly: bool,
    /// Plane that cuts the part open, while there is one.
    pub section: Option<Section>,
    /// Points measured between, while measuring, mm; two at most.
    pub measure: Option<Vec<glam::Vec3>>,
    /// Plots along the row.
    pub plots: bool,
    /// What is shown of the selected position.
    pub tab: Tab,
    /// What the mouse does to the camera.
    pub mouse: MousePreset,
}

/// What is shown of the selected position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tab {
    /// The cut through it.
    #[default]
    Section,
    /// Its figures.
    Facts,
}

/// Which way a section plane lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Across {
    /// Through the axis and the feed of the selected position.
    #[default]
    Row,
    /// Across X.
    X,
    /// Across Y.
    Y,
    /// Across the axis of rotation.
    Z,
}

impl Across {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Row, Self::X, Self::Y, Self::Z];

    /// Word in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::Row => "Along the row",
            Self::X => "Across X",
            Self::Y => "Across Y",
            Self::Z => "Across Z",
        }
    }
}

/// A section plane of the 3D view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Section {
    /// Which way it lies.
    pub across: Across,
    /// How far it was moved along its normal, mm.
    pub offset: f32,
    /// Which half is left out.
    pub flipped: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            side: Side::After,
            policies: [None; 2],
            arrangement: Arrangement::One,
            wipe: 0.5,
            selected: None,
            reveal_selection: 0,
            filter: Filter::All,
            sort: Sort::default(),
            layers: Layers::default(),
            flank: FlankLook::default(),
            cut: None,
            playing: None,
            range: None,
            difference: false,
            fly: false,
            section: None,
            measure: None,
            plots: true,
            tab: Tab::Section,
            mouse: MousePreset::default(),
        }
    }
}

impl Look {
    /// Begins anew for another part; layers, plots and the mouse stay as the user likes them.
    pub fn begin(&mut self) {
        let Self { layers, plots, tab, mouse, .. } = *self;
        *self = Self { layers, plots, tab, mouse, ..Self::default() };
    }

    /// Selects a position, and sends the camera there.
    pub fn visit(&mut self, position: Option<usize>) {
        self.select(position);
        self.fly = position.is_some();
    }

    /// Selects a position, and brings it into sight in the table. Where the timeline stands somewhere, it goes
    /// there too: what is selected is what was cut last.
    pub fn select(&mut self, position: Option<usize>) {
        self.selected = position;
        self.reveal_selection = if position.is_some() { REVEAL } else { 0 };
        if let (Some(_), Some(k)) = (self.cut, position) {
            self.cut = Some(k + 1);
        }
    }
}
