//! The impeller: hub, shroud and blades, assembled and validated.

use std::f64::consts::TAU;

use super::blade::{Blade, RawBlade, blade_line};
use super::description::{PartDescription, PartError};
use super::flowpath::{DUCT_FROM, Flowpath, channel_curves, check_channel, orient_normals};
use super::rotation::Rotation;
use super::side::BladeSide;
use crate::error::ErrorCode;
use crate::geometry::{Meridional, wrap_angle};

/// A centrifugal impeller.
#[derive(Clone, Debug)]
pub struct Impeller {
    /// Name of the part.
    pub name: String,
    /// Number of main blades.
    pub blade_count: usize,
    /// Hub.
    pub hub: Flowpath,
    /// Shroud.
    pub shroud: Flowpath,
    /// Main blade.
    pub main: Blade,
    /// Splitters of one pitch, rotated into channel 1.
    pub splitters: Vec<Blade>,
    /// Assumptions made where its file is ambiguous, one line each.
    pub notes: Vec<String>,
    /// As [`PartDescription::roles_by_shape`].
    pub roles_by_shape: bool,
    pitch: f64,
}

/// Valid numbers of main blades.
const BLADE_COUNTS: std::ops::RangeInclusive<usize> = 2..=200;

impl Impeller {
    /// Trims, extends and validates a description.
    ///
    /// ```
    /// # let part = vanecut::io::part_file::read_part("assets/parts/impeller532.toml".as_ref())?;
    /// let part = vanecut::part::Impeller::build(&part)?;
    /// assert_eq!(part.blade_count, 17);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PartError`] with the line of the file, when the description is not a valid centrifugal impeller: hub
    /// and shroud swapped or crossing, blades that miss hub or shroud, no radial outlet, an unsupported
    /// number of blades, overlapping blades.
    pub fn build(description: &PartDescription) -> Result<Self, PartError> {
        Self::build_from(description).map_err(|error| error.of_surfaces(description))
    }

    fn build_from(d: &PartDescription) -> Result<Self, PartError> {
        if !BLADE_COUNTS.contains(&d.blade_count) {
            return Err(PartError::new(
                ErrorCode::BladeCount,
                d.count_line,
                format!("{} main blades", d.blade_count),
                format!("give {} to {}", BLADE_COUNTS.start(), BLADE_COUNTS.end()),
            ));
        }
        let mut notes = d.notes.clone();
        let (hub, shroud) = channel_curves(d, &mut notes)?;
        let (hub, shroud) = orient_normals(hub, shroud, d)?;

        let main = RawBlade::new(&d.main, &hub, &shroud, "main blade", &mut notes)?;
        let mut splitters: Vec<RawBlade> = Vec::with_capacity(d.splitters.len());
        for (k, splitter) in d.splitters.iter().enumerate() {
            let name =
                if d.splitters.len() == 1 { "splitter".to_owned() } else { format!("splitter {}", k + 1) };
            splitters.push(RawBlade::new(splitter, &hub, &shroud, &name, &mut notes)?);
        }
        let hub_ends = main.ends_on(&hub, 0.0);
        let shroud_ends = main.ends_on(&shroud, 1.0);
        for ((start, end), (line, name)) in
            [(hub_ends, (d.hub_line, "hub")), (shroud_ends, (d.shroud_line, "shroud"))]
        {
            if end - start < 1e-3 * hub.length() {
                return Err(PartError::new(
                    ErrorCode::BladeTooShort,
                    line,
                    format!("the main blade does not extend along the {name}"),
                    "check that blade sections run LE to TE and use the units of the curves".to_string(),
                ));
            }
        }
        let hub = Flowpath::of_hub(&hub, hub_ends.0, hub_ends.1);
        let shroud = Flowpath::of_shroud(&shroud, shroud_ends.0, shroud_ends.1);
        check_channel(&hub, &shroud, d)?;
        // A curve in a file may be the wall of the flow; a surface is that of the wheel.
        if d.hub_line != 0 && hub.wheel_from() < -DUCT_FROM {
            notes.push(format!(
                "the hub runs on for {:.1} mm ahead of the blades; all of it counts as part of the wheel",
                hub.arc_at(0.0)
            ));
        }

        let main = main.blade;
        let middle = |side: &BladeSide| {
            let p = side.point(0.6, 0.5);
            p.y.atan2(p.x)
        };
        let towards_suction = wrap_angle(middle(&main.suction) - middle(&main.pressure));
        let pitch = (TAU / d.blade_count as f64).copysign(towards_suction);
        let splitters = splitters
            .into_iter()
            .map(|s| {
                // Rotate the splitter by whole pitches into the channel beside the main suction side.
                let ahead = wrap_angle(splitter_angle(&s.blade, &main)) / pitch;
                s.blade.rotated(-ahead.floor() * pitch)
            })
            .collect();
        let part = Self {
            name: d.name.clone(),
            blade_count: d.blade_count,
            hub,
            shroud,
            main,
            splitters,
            notes,
            roles_by_shape: d.roles_by_shape,
            pitch,
        };
        part.check_passages(blade_line(&d.main))?;
        Ok(part)
    }

    /// Angle between neighbouring main blades, rad; signed: channel 1 lies between the suction side
    /// of `main` and the pressure side of `main` turned about Z by this angle.
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// The number of channels that is nearest to `count`: at least one, at most all.
    pub fn channels_within(&self, count: usize) -> usize {
        count.clamp(1, self.blade_count.max(1))
    }

    /// Unit direction of the axis of rotation that points out of the inlet, away from the back of the wheel.
    pub fn out_of_inlet(&self) -> crate::geometry::Vector {
        crate::geometry::Vector::z() * if self.inlet_up() { 1.0 } else { -1.0 }
    }

    /// Whether the inlet is towards +Z. The hub of a pump wheel may be a plane from the leading edge on,
    /// whose ends differ by rounding only: its shroud says on which side it is open.
    fn inlet_up(&self) -> bool {
        let rim = self.hub.point(1.0).z;
        (self.hub.point(0.0).z - rim) + (self.shroud.point(1.0).z - rim) >= 0.0
    }

    /// Sense of rotation of the wheel, in which its pressure sides lead.
    pub fn rotation(&self) -> Rotation {
        Rotation::about_z(-self.pitch, self.inlet_up())
    }

    /// Outer radius, mm.
    pub fn rim_radius(&self) -> f64 {
        self.hub.point(1.0).r.max(self.shroud.point(1.0).r)
    }

    /// Meridional point at s and η on the straight line from hub (η = 0) to shroud (η = 1).
    pub fn meridional(&self, s: f64, eta: f64) -> Meridional {
        self.hub.point(s).lerp(self.shroud.point(s), eta)
    }

    /// Checks that neighbouring blades do not overlap.
    fn check_passages(&self, line: usize) -> Result<(), PartError> {
        for i in 0..=40 {
            let u = f64::from(i) / 40.0;
            for v in [0.0, 0.5, 1.0] {
                let (a, b) = (self.main.suction.point(u, v), self.main.pressure.point(u, v));
                let thickness = wrap_angle(a.y.atan2(a.x) - b.y.atan2(b.x)) * self.pitch.signum();
                if thickness > 0.9 * self.pitch.abs() {
                    return Err(PartError::new(
                        ErrorCode::BladesOverlap,
                        line,
                        format!(
                            "{} blades overlap: at {:.0} % of the chord a blade is {:.1}° thick \
                             in a pitch of {:.1}°",
                            self.blade_count,
                            100.0 * u,
                            thickness.to_degrees(),
                            self.pitch.abs().to_degrees()
                        ),
                        "give fewer or thinner blades".to_string(),
                    ));
                }
            }
        }
        Ok(())
    }
}

/// Angle of a splitter ahead of the main blade's suction side at the same radius and height, rad.
fn splitter_angle(splitter: &Blade, main: &Blade) -> f64 {
    let p = splitter.suction.point(0.9, 0.5);
    let wanted = Meridional::from_point(&p);
    let nearest = (0..=400)
        .map(|i| main.suction.point(f64::from(i) / 400.0, 0.5))
        .min_by(|a, b| {
            Meridional::from_point(a).distance(wanted).total_cmp(&Meridional::from_point(b).distance(wanted))
        })
        .unwrap_or(p);
    p.y.atan2(p.x) - nearest.y.atan2(nearest.x)
}

/// Both sides of the two main blades around channel 1, then of its splitters: the surfaces that a tool in
/// that channel touches before any other.
pub fn sides_around_channel(part: &Impeller) -> Vec<BladeSide> {
    let other = part.main.rotated(part.pitch());
    let mut sides =
        vec![part.main.suction.clone(), part.main.pressure.clone(), other.suction, other.pressure];
    for splitter in &part.splitters {
        sides.push(splitter.suction.clone());
        sides.push(splitter.pressure.clone());
    }
    sides
}
