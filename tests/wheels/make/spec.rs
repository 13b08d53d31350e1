//! Random parameters of a wheel, by kind.

use super::dice::Dice;

/// Kind of a wheel: it fixes some characteristics, all others are random.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Axial inlet with an inducer, radial outlet, usually splitters.
    Compressor,
    /// Leading edge swept, slanted and curved, trailing edge slanted.
    Swept,
    /// Few blades, wrap up to 180°, blade angles up to 88° from the meridional direction.
    Wrapped,
    /// Cylindrical blades: the same camber line at every height, leading edge along the axis.
    Cylindrical,
    /// Bowed and compound-leaned blades.
    Bowed,
    /// Thick blades with round or blunt edges.
    Thick,
    /// Diameters of 15 to 40 mm.
    Micro,
    /// Diameters of 400 to 900 mm, up to 30 blades.
    Large,
    /// Two rows of splitters.
    Splitters,
    /// Cylindrical blades without height at the leading edge, where hub and shroud meet.
    Meeting,
}

impl Kind {
    pub const ALL: [Self; 10] = [
        Self::Compressor,
        Self::Swept,
        Self::Wrapped,
        Self::Cylindrical,
        Self::Bowed,
        Self::Thick,
        Self::Micro,
        Self::Large,
        Self::Splitters,
        Self::Meeting,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Compressor => "compressor",
            Self::Swept => "swept",
            Self::Wrapped => "wrapped",
            Self::Cylindrical => "cylindrical",
            Self::Bowed => "bowed",
            Self::Thick => "thick",
            Self::Micro => "micro",
            Self::Large => "large",
            Self::Splitters => "splitters",
            Self::Meeting => "meeting",
        }
    }

    /// Whether the blades are cylindrical, parallel to the axis.
    pub fn is_flat(self) -> bool {
        matches!(self, Self::Cylindrical | Self::Meeting)
    }
}

/// Shape of a trailing edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tail {
    /// Semicircle or half ellipse; its length in half thicknesses.
    Round(f64),
    /// Cut off at right angles to the camber line.
    Blunt,
    /// Turned on a lathe with the rim: both sides end at the same s.
    Turned,
}

/// An edge across the span: s at hub and shroud, and its downstream bulge in between.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    pub hub: f64,
    pub shroud: f64,
    pub bulge: f64,
}

impl Edge {
    fn straight(s: f64) -> Self {
        Self { hub: s, shroud: s, bulge: 0.0 }
    }

    pub fn at(&self, eta: f64) -> f64 {
        self.hub + (self.shroud - self.hub) * eta + 4.0 * self.bulge * eta * (1.0 - eta)
    }
}

/// A row of splitters: its relative position in the pitch and its leading edge.
#[derive(Clone, Copy, Debug)]
pub struct SplitterRow {
    pub place: f64,
    pub edge: Edge,
}

/// All parameters of a wheel. Lengths are shares of the rim's radius unless noted; angles are in degrees.
#[derive(Clone, Debug)]
pub struct Spec {
    pub kind: Kind,
    /// Radius of the rim, mm.
    pub rim: f64,
    /// Radius of the hub at the inlet.
    pub eye: f64,
    /// Radius of the shroud at the inlet.
    pub tip: f64,
    pub depth: f64,
    /// Height of the blades at the rim.
    pub outlet: f64,
    /// Inclination of the flow at the rim from the radial direction.
    pub incline: f64,
    pub blades: usize,
    pub splitters: Vec<SplitterRow>,
    /// Blade angle from the meridional direction at the leading edge, hub and shroud.
    pub inlet_angle: [f64; 2],
    pub outlet_angle: f64,
    /// Blade angle midway on the mean surface.
    pub middle_angle: f64,
    pub rake: f64,
    /// Bow of the blade between hub and shroud, as a share of its height.
    pub bow: f64,
    /// S-shaped bow, as a share of its height.
    pub compound: f64,
    pub leading: Edge,
    pub trailing: Edge,
    /// Thickness at hub and shroud.
    pub thickness: [f64; 2],
    /// Thickness at the trailing edge relative to that of the blade.
    pub taper: f64,
    /// Length of the nose in half thicknesses, and the exponent of its superellipse (2: ellipse, 4: blunt).
    pub nose: (f64, f64),
    pub tail: Tail,
    /// Extension of hub and shroud beyond s = 0 and s = 1.
    pub runs_on: [(f64, f64); 2],
    /// Extension of the sections beyond hub and shroud; negative where they end before.
    pub overrun: [f64; 2],
    pub sections: usize,
    pub inlet_up: bool,
    /// +1 or −1: θ of the blades grows or falls downstream.
    pub turn: f64,
}

impl Spec {
    pub fn draw(kind: Kind, dice: &mut Dice) -> Self {
        let mut spec = Self::any(kind, dice);
        match kind {
            Kind::Compressor => {}
            Kind::Swept => {
                let (hub, shroud) = (dice.between(0.0, 0.3), dice.between(0.0, 0.3));
                spec.leading = Edge { hub, shroud, bulge: dice.between(-0.06, 0.06) };
                spec.trailing = Edge {
                    hub: dice.between(0.9, 1.0),
                    shroud: dice.between(0.82, 1.0),
                    bulge: dice.between(-0.02, 0.02),
                };
            }
            Kind::Wrapped => {
                spec.blades = dice.whole(4, 7);
                spec.splitters.clear();
                spec.inlet_angle = [dice.between(50.0, 80.0), dice.between(72.0, 88.0)];
                spec.middle_angle = dice.between(65.0, 82.0);
                spec.outlet_angle = dice.between(50.0, 75.0);
                spec.leading.hub = dice.between(0.0, 0.2);
                spec.leading.shroud = dice.between(0.0, 0.25);
                spec.thickness = [dice.between(0.01, 0.03), dice.between(0.008, 0.025)];
            }
            Kind::Cylindrical | Kind::Meeting => spec.flatten(dice),
            Kind::Bowed => {
                spec.bow = dice.between(0.04, 0.14) * if dice.chance(0.5) { 1.0 } else { -1.0 };
                spec.compound = dice.between(-0.06, 0.06);
                spec.rake = dice.between(-35.0, 35.0);
                spec.sections = dice.whole(7, 11);
            }
            Kind::Thick => {
                spec.blades = dice.whole(4, 9);
                spec.splitters.clear();
                spec.thickness = [dice.between(0.05, 0.1), dice.between(0.035, 0.07)];
                spec.taper = dice.between(0.7, 1.0);
                spec.nose = (dice.between(1.0, 1.6), if dice.chance(0.5) { 2.0 } else { 4.0 });
                spec.tail = if dice.chance(0.6) { Tail::Round(1.0) } else { Tail::Blunt };
            }
            Kind::Micro => spec.rim = dice.sized(7.5, 20.0),
            Kind::Large => {
                spec.rim = dice.sized(200.0, 450.0);
                spec.eye = dice.between(0.3, 0.5);
                spec.tip = spec.eye + dice.between(0.18, 0.28);
                spec.depth = dice.between(0.35, 0.6);
                spec.blades = dice.whole(14, 30);
            }
            Kind::Splitters => {
                spec.blades = dice.whole(4, 8);
                let edge = |from: f64, to: f64, dice: &mut Dice| {
                    let hub = dice.between(from, to);
                    Edge { hub, shroud: hub + dice.between(-0.08, 0.1), bulge: 0.0 }
                };
                let long = edge(0.22, 0.4, dice);
                if dice.chance(0.5) {
                    let short = edge(0.5, 0.65, dice);
                    spec.splitters = [(0.25, short), (0.5, long), (0.75, short)]
                        .map(|(place, edge)| SplitterRow { place, edge })
                        .to_vec();
                } else {
                    let short = edge(0.4, 0.55, dice);
                    spec.splitters = [(1.0 / 3.0, long), (2.0 / 3.0, short)]
                        .map(|(place, edge)| SplitterRow { place, edge })
                        .to_vec();
                }
            }
        }
        spec
    }

    /// Random parameters of a wheel with an axial inlet.
    fn any(kind: Kind, dice: &mut Dice) -> Self {
        let eye = dice.between(0.16, 0.34);
        let tip = (eye + dice.between(0.2, 0.42)).min(0.72);
        let mut splitters = Vec::new();
        if dice.chance(0.45) {
            let hub = dice.between(0.22, 0.5);
            let edge = Edge { hub, shroud: hub + dice.between(-0.1, 0.12), bulge: dice.between(-0.03, 0.03) };
            splitters.push(SplitterRow { place: dice.between(0.46, 0.54), edge });
        }
        let mut leading = Edge::straight(0.0);
        if dice.chance(0.5) {
            leading = Edge {
                hub: dice.between(0.0, 0.08),
                shroud: dice.between(0.0, 0.1),
                bulge: dice.between(-0.02, 0.02),
            };
        }
        let mut trailing = Edge::straight(1.0);
        if dice.chance(0.3) {
            trailing.shroud = dice.between(0.93, 1.0);
        }
        let tail = match dice.whole(0, 3) {
            0 => Tail::Round(1.0),
            1 => Tail::Blunt,
            _ => Tail::Turned,
        };
        let knife = dice.chance(0.25);
        let share = dice.between(0.008, 0.02);
        let overrun = |dice: &mut Dice| match dice.whole(0, 2) {
            0 => 0.0,
            1 => dice.between(0.01, 0.1),
            _ => dice.between(-0.04, -0.005),
        };
        let runs_on = |dice: &mut Dice| {
            let on = |dice: &mut Dice| if dice.chance(0.6) { dice.between(0.02, 0.3) } else { 0.0 };
            (on(dice), 0.4 * on(dice))
        };
        Self {
            kind,
            rim: dice.sized(15.0, 300.0),
            eye,
            tip,
            depth: dice.between(0.4, 0.8),
            outlet: 0.5 * (tip * tip - eye * eye) * dice.between(0.5, 1.1),
            incline: if dice.chance(0.3) { dice.between(5.0, 40.0) } else { 0.0 },
            blades: dice.whole(5, 16),
            splitters,
            inlet_angle: [dice.between(15.0, 45.0), dice.between(45.0, 66.0)],
            outlet_angle: dice.between(0.0, 50.0),
            middle_angle: dice.between(15.0, 50.0),
            rake: dice.between(-20.0, 20.0),
            bow: 0.0,
            compound: 0.0,
            leading,
            trailing,
            thickness: [share * dice.between(1.0, 2.0), share],
            taper: if knife { dice.between(0.12, 0.3) } else { dice.between(0.5, 1.0) },
            nose: (if knife { dice.between(4.0, 8.0) } else { dice.between(1.0, 3.0) }, 2.0),
            tail: if knife { Tail::Turned } else { tail },
            runs_on: [runs_on(dice), runs_on(dice)],
            overrun: [overrun(dice), overrun(dice)],
            sections: dice.whole(5, 9),
            inlet_up: dice.chance(0.5),
            turn: if dice.chance(0.5) { 1.0 } else { -1.0 },
        }
    }

    /// Changes the parameters to those of a pump or blower with blades between two discs.
    fn flatten(&mut self, dice: &mut Dice) {
        self.eye = dice.between(0.3, 0.6);
        self.tip = self.eye;
        self.depth = dice.between(0.0, 0.25);
        self.outlet = dice.between(0.06, 0.22);
        self.incline = 0.0;
        self.blades = dice.whole(4, 12);
        if dice.chance(0.7) {
            self.splitters.clear();
        }
        for row in &mut self.splitters {
            row.edge = Edge::straight(row.edge.hub);
        }
        self.inlet_angle = [dice.between(40.0, 75.0); 2];
        self.middle_angle = dice.between(40.0, 72.0);
        self.outlet_angle = dice.between(20.0, 70.0);
        (self.rake, self.bow, self.compound) = (0.0, 0.0, 0.0);
        (self.leading, self.trailing) = (Edge::straight(0.0), Edge::straight(1.0));
        self.thickness = [dice.between(0.015, 0.05); 2];
        if self.kind == Kind::Meeting {
            // Noses extend upstream of the edge by at most half the thickness, so that they stay in the
            // channel.
            let nose = 0.5 * self.thickness[0] / (1.0 - self.eye);
            let behind = if dice.chance(0.5) { dice.between(0.02, 0.06) } else { 0.0 };
            self.leading = Edge::straight(nose + behind);
        }
    }
}
