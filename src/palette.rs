//! Colours of pictures and window. Gamma-encoded sRGB, 0…1.

/// Number of entries of a colour table.
pub const TABLE_LEN: usize = 256;

/// Red, green, blue.
pub type Rgb = [f32; 3];

const fn rgb(hex: u32) -> Rgb {
    [((hex >> 16) & 255) as f32 / 255.0, ((hex >> 8) & 255) as f32 / 255.0, (hex & 255) as f32 / 255.0]
}

/// Interfering plunge: vermilion of the Okabe–Ito set.
pub const INTERFERING: Rgb = rgb(0xD55E00);
/// Blocked position: orange.
pub const BLOCKED: Rgb = rgb(0xE69F00);
/// Sound position: bluish green.
pub const SOUND: Rgb = rgb(0x009E73);
/// Position whose contact is not evaluated yet: grey.
pub const UNEVALUATED: Rgb = rgb(0x8C9299);
/// Selected position: blue. The accent of the window is a shade of it that can be read as text.
pub const SELECTED: Rgb = rgb(0x0072B2);

/// Colours of classes without an order: tools, sections, curves. The first four are of the Okabe–Ito set; the
/// others were searched for so that any two, and any one and [`INTERFERING`], stay distinct to viewers with
/// normal sight, with protanopia and with deuteranopia. The test below holds the least distance.
pub const CATEGORIES: [Rgb; 12] = [
    rgb(0x56B4E9),
    rgb(0xF0E442),
    rgb(0xCC79A7),
    rgb(0x0072B2),
    rgb(0x1EE1A5),
    rgb(0x780F00),
    rgb(0x8778FF),
    rgb(0xD2A52D),
    rgb(0xC3005A),
    rgb(0xC3F0FF),
    rgb(0x5A0F87),
    rgb(0x0F00E1),
];

/// Colour of class `index`. More classes than [`CATEGORIES`] begin again.
pub fn category(index: usize) -> Rgb {
    CATEGORIES[index % CATEGORIES.len()]
}

/// Colours of the curves of a chart, in order.
pub const CURVES: [Rgb; 6] = [SELECTED, INTERFERING, SOUND, CATEGORIES[2], CATEGORIES[0], BLOCKED];

/// A colour as bytes, 0…255.
pub fn to_bytes(colour: Rgb) -> [u8; 3] {
    colour.map(|x| (255.0 * x).round() as u8)
}

/// Light or dark theme; the colours of values and states are the same in both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Dark lines on light grey.
    #[default]
    Light,
    /// Light part on a dark background.
    Dark,
}

/// Greys of one theme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Greys {
    /// Background at the top of the picture.
    pub background_top: Rgb,
    /// Background at the bottom.
    pub background_bottom: Rgb,
    /// Hub and body outside the active channel.
    pub hub: Rgb,
    /// Floor of the active channel.
    pub floor: Rgb,
    /// Blades outside the active channel.
    pub blade: Rgb,
    /// Blades of the active channel.
    pub wall: Rgb,
    /// Shroud, drawn transparent.
    pub shroud: Rgb,
    /// Stock that no plunge has cut.
    pub uncut: Rgb,
    /// Material where the section plane cuts it.
    pub section: Rgb,
    /// Edges outside the active channel.
    pub edge: Rgb,
    /// Edges of the active channel.
    pub wall_edge: Rgb,
    /// Axes and retracts.
    pub axis: Rgb,
}

impl Theme {
    /// The greys of this theme.
    pub fn greys(self) -> Greys {
        match self {
            Self::Light => Greys {
                background_top: rgb(0xF7F8F9),
                background_bottom: rgb(0xDDE1E5),
                hub: rgb(0xABB1B7),
                floor: rgb(0xF1EBDA),
                blade: rgb(0xDADDE1),
                wall: rgb(0xEADFBF),
                shroud: rgb(0x9FB8CC),
                uncut: rgb(0xA8A29A),
                section: rgb(0x8C9BB0),
                edge: rgb(0x767D84),
                wall_edge: rgb(0x14181C),
                axis: rgb(0x4A5157),
            },
            Self::Dark => Greys {
                background_top: rgb(0x2A2E33),
                background_bottom: rgb(0x16181B),
                hub: rgb(0x6A7076),
                floor: rgb(0xC9C3B2),
                blade: rgb(0x959CA3),
                wall: rgb(0xC2B693),
                shroud: rgb(0x6F93AD),
                uncut: rgb(0x6E6A64),
                section: rgb(0x667A97),
                edge: rgb(0x33383D),
                wall_edge: rgb(0x08090A),
                axis: rgb(0xB4BAC0),
            },
        }
    }
}

/// A colour map, sampled into a table that picture and legend share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Blue to yellow, safe for colour-blind viewers: residual stock.
    #[default]
    Cividis,
    /// Violet to yellow.
    Viridis,
    /// Light grey to vermilion: depth of contact.
    Contact,
    /// Violet over white to orange: difference of two plans, zero in the middle.
    Difference,
}

impl ColourMap {
    /// The table, lowest value first.
    pub fn table(self) -> [[u8; 3]; TABLE_LEN] {
        std::array::from_fn(|i| {
            let t = i as f64 / (TABLE_LEN - 1) as f64;
            match self {
                Self::Cividis => colorous::CIVIDIS.eval_continuous(t).into_array(),
                Self::Viridis => colorous::VIRIDIS.eval_continuous(t).into_array(),
                Self::Difference => colorous::PURPLE_ORANGE.eval_continuous(1.0 - t).into_array(),
                Self::Contact => {
                    // A step at zero: floor without contact stays pale, any contact is visible.
                    let weight = if i == 0 { 0.0 } else { 0.35 + 0.65 * t as f32 };
                    let pale = rgb(0xF1EBDA);
                    std::array::from_fn(|c| {
                        ((pale[c] + (INTERFERING[c] - pale[c]) * weight) * 255.0).round() as u8
                    })
                }
            }
        })
    }
}

/// Colour of `value` in a table that spans `range`.
pub fn colour_of_value(table: &[[u8; 3]; TABLE_LEN], value: f32, range: (f32, f32)) -> Rgb {
    let t = (value - range.0) / (range.1 - range.0).max(1e-6);
    let entry = (t.clamp(0.0, 1.0) * (TABLE_LEN - 1) as f32).round() as usize;
    table[entry].map(|x| f32::from(x) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_run_from_the_low_to_the_high_end() {
        let table = ColourMap::Cividis.table();
        let brightness = |c: [u8; 3]| c.iter().map(|&v| u32::from(v)).sum::<u32>();
        assert!(brightness(table[0]) < brightness(table[255]), "cividis brightens");
        let contact = ColourMap::Contact.table();
        assert_eq!(contact[255], [0xD5, 0x5E, 0x00]);
        assert_ne!(contact[0], contact[1]);
    }

    /// Product of a 3 × 3 matrix and a vector.
    fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }

    /// Oklab coordinates of a colour as seen through `sight`, a matrix on linear sRGB.
    fn oklab(colour: Rgb, sight: &[[f64; 3]; 3]) -> [f64; 3] {
        let linear = colour.map(|x| {
            let x = f64::from(x);
            if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        });
        let seen = times(sight, linear).map(|x| x.clamp(0.0, 1.0));
        let cones = [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ];
        let lab = [
            [0.2104542553, 0.7936177850, -0.0040720468],
            [1.9779984951, -2.4285922050, 0.4505937099],
            [0.0259040371, 0.7827717662, -0.8086757660],
        ];
        times(&lab, times(&cones, seen).map(f64::cbrt))
    }

    /// Normal sight, protanopia and deuteranopia on linear sRGB: Machado, Oliveira, Fernandes 2009, severity
    /// 1.
    const SIGHTS: [[[f64; 3]; 3]; 3] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    ];

    /// Least distance in Oklab, where black and white are 1 apart. Steps of .02 are just visible side by
    /// side.
    const MIN_DISTANCE: f64 = 0.09;

    #[test]
    fn classes_are_distinct_to_colour_blind_viewers() {
        let all: Vec<Rgb> = CATEGORIES.into_iter().chain([INTERFERING]).collect();
        for sight in &SIGHTS {
            for (k, &a) in all.iter().enumerate() {
                for &b in &all[..k] {
                    let (p, q) = (oklab(a, sight), oklab(b, sight));
                    let distance = p.iter().zip(q).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
                    assert!(distance > MIN_DISTANCE, "{a:?} and {b:?} are {distance:.3} apart");
                }
            }
        }
    }
}
