//! Names of the walls of a channel and of the regions between them.
//!
//! A region is a passage between two walls: at the inlet the one between the main blades. Where a splitter
//! begins, the passage that it stands in is divided, and one on either side of it goes on.

use std::cmp::Reverse;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A wall of the channel. Walls are ordered from the first to the second main blade.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WallName {
    /// At λ = 0: the suction side of a main blade.
    Low,
    /// A splitter, by its number across the channel, 0 next to `Low`.
    Splitter(usize),
    /// At λ = 1: the pressure side of a main blade.
    High,
}

/// A region of the channel [flank paper, fig. 6]: the passage between two walls. In order, regions come
/// before those into which they are divided, and these from `Low` to `High`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Region {
    /// The wall on the side of [`WallName::Low`], or that itself.
    pub low: WallName,
    /// The wall on the side of [`WallName::High`], or that itself.
    pub high: WallName,
}

/// What a name is not, as a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownName(&'static str);

impl Region {
    /// From the inlet to the first leading edge of a splitter; without splitters the whole channel.
    pub const INLET: Self = Self { low: WallName::Low, high: WallName::High };
    /// Beside the only splitter, at the suction side of the main blade.
    pub const LOW_SIDE: Self = Self { low: WallName::Low, high: WallName::Splitter(0) };
    /// Beside the only splitter, at the pressure side of the main blade.
    pub const HIGH_SIDE: Self = Self { low: WallName::Splitter(0), high: WallName::High };

    /// The wall opposite `wall`; `None` where `wall` does not bound the region.
    pub fn facing(self, wall: WallName) -> Option<WallName> {
        match wall {
            _ if wall == self.low => Some(self.high),
            _ if wall == self.high => Some(self.low),
            _ => None,
        }
    }

    /// Whether this region becomes the `other` one, or that and others, where splitters divide it.
    pub fn contains(self, other: Self) -> bool {
        self.low <= other.low && other.high <= self.high
    }

    /// Whether `wall` bounds this region and the `other` with the same of its sides.
    pub fn shares_side(self, other: Self, wall: WallName) -> bool {
        self.low == wall && other.low == wall || self.high == wall && other.high == wall
    }
}

impl PartialOrd for Region {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Region {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.low, Reverse(self.high)).cmp(&(other.low, Reverse(other.high)))
    }
}

impl fmt::Display for WallName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Low => f.write_str("low"),
            Self::High => f.write_str("high"),
            Self::Splitter(0) => f.write_str("splitter"),
            Self::Splitter(number) => write!(f, "splitter-{}", number + 1),
        }
    }
}

/// Separates the walls in the name of a region that has none of its own.
const TO: &str = "..";

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::INLET => f.write_str("inlet"),
            Self::LOW_SIDE => f.write_str("low-side"),
            Self::HIGH_SIDE => f.write_str("high-side"),
            Self { low, high } => write!(f, "{low}{TO}{high}"),
        }
    }
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not the name of a {}", self.0)
    }
}

impl FromStr for WallName {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let number = |digits: &str| digits.parse::<u16>().ok().filter(|number| *number > 1);
        match (name, name.strip_prefix("splitter-").and_then(number)) {
            ("low", _) => Ok(Self::Low),
            ("high", _) => Ok(Self::High),
            ("splitter", _) => Ok(Self::Splitter(0)),
            (_, Some(number)) => Ok(Self::Splitter(usize::from(number) - 1)),
            _ => Err(UnknownName("wall")),
        }
    }
}

impl FromStr for Region {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name {
            "inlet" => return Ok(Self::INLET),
            "low-side" => return Ok(Self::LOW_SIDE),
            "high-side" => return Ok(Self::HIGH_SIDE),
            _ => {}
        }
        let (low, high) = name.split_once(TO).ok_or(UnknownName("region"))?;
        let region = Self { low: low.parse()?, high: high.parse()? };
        if region.low < region.high { Ok(region) } else { Err(UnknownName("region")) }
    }
}

impl Serialize for WallName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Serialize for Region {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for WallName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

impl<'de> Deserialize<'de> for Region {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::WallName::{High, Low, Splitter};
    use super::*;

    fn region(low: WallName, high: WallName) -> Region {
        Region { low, high }
    }

    #[test]
    fn names_are_read_back_and_those_of_one_splitter_stay() {
        for (region, name) in [
            (Region::INLET, "inlet"),
            (Region::LOW_SIDE, "low-side"),
            (Region::HIGH_SIDE, "high-side"),
            (region(Splitter(0), Splitter(1)), "splitter..splitter-2"),
            (region(Low, Splitter(1)), "low..splitter-2"),
            (region(Splitter(2), High), "splitter-3..high"),
        ] {
            assert_eq!(region.to_string(), name);
            assert_eq!(name.parse(), Ok(region));
        }
        assert_eq!("splitter-2".parse(), Ok(Splitter(1)));
        for wrong in ["splitter-0", "splitter-1", "splitter-", "side", "splitter-70000"] {
            assert!(wrong.parse::<WallName>().is_err(), "{wrong}");
        }
        for wrong in ["high..low", "splitter-2..splitter", "low", "low..low", ".."] {
            assert!(wrong.parse::<Region>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn regions_come_before_those_that_divide_them() {
        // The splitter in the middle begins first, the other two divide the passages beside it.
        let nested = [
            Region::INLET,
            region(Low, Splitter(1)),
            region(Low, Splitter(0)),
            region(Splitter(0), Splitter(1)),
            region(Splitter(1), High),
            region(Splitter(1), Splitter(2)),
            region(Splitter(2), High),
        ];
        assert!(nested.is_sorted(), "{nested:?}");
        assert!(Region::INLET < Region::LOW_SIDE && Region::LOW_SIDE < Region::HIGH_SIDE);
    }

    #[test]
    fn a_wall_faces_the_other_one_of_its_region() {
        let between = region(Splitter(0), Splitter(1));
        assert_eq!(between.facing(Splitter(1)), Some(Splitter(0)));
        assert_eq!(between.facing(Low), None);
        assert!(Region::INLET.contains(between) && !Region::LOW_SIDE.contains(between));
        let before = region(Splitter(0), High);
        assert!(between.shares_side(before, Splitter(0)));
        assert!(!between.shares_side(before, Splitter(1)) && !before.shares_side(between, High));
        assert!(!before.shares_side(Region::LOW_SIDE, Splitter(0)), "the other side of the splitter");
    }
}
