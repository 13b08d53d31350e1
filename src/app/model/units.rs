//! Units in which the window shows lengths and feed rates, and takes them. Files and everything inside stay
//! in mm and mm/min. All texts with a length or a feed rate come from here.

use super::number::{self, Quantity, with_minus_signs};
use crate::geometry::without_conversion_error;

/// Length of an inch, mm.
const INCH_MM: f64 = 25.4;

/// Units of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DisplayUnits {
    /// Millimetres, mm/min.
    #[default]
    Metric,
    /// Inches, in/min.
    Inch,
}

/// Decimals, of mm, of lengths beside an allowance: two, or three where it has more than two.
pub fn decimals_beside(allowance: f64) -> usize {
    let hundredths = 100.0 * allowance;
    if (hundredths - hundredths.round()).abs() < 1e-6 { 2 } else { 3 }
}

/// Decimals of deviations of walls, mm.
const DEVIATION_DECIMALS: usize = 4;

impl DisplayUnits {
    /// Unit of lengths.
    pub fn length_unit(self) -> &'static str {
        match self {
            Self::Metric => "mm",
            Self::Inch => "in",
        }
    }

    /// Unit of feed rates.
    pub fn feed_unit(self) -> &'static str {
        match self {
            Self::Metric => "mm/min",
            Self::Inch => "in/min",
        }
    }

    /// `mm` in the unit of lengths; feed rates likewise.
    pub fn of_mm(self, mm: f64) -> f64 {
        match self {
            Self::Metric => mm,
            Self::Inch => mm / INCH_MM,
        }
    }

    /// A length in the unit of the window in mm; feed rates likewise.
    pub fn to_mm(self, shown: f64) -> f64 {
        match self {
            Self::Metric => shown,
            Self::Inch => without_conversion_error(shown * INCH_MM),
        }
    }

    /// Number of decimals with which the unit resolves about as much as mm with `decimals`.
    pub fn decimals(self, decimals: usize) -> usize {
        match (self, decimals) {
            (Self::Metric, _) => decimals,
            (Self::Inch, 1 | 2) => decimals + 2,
            (Self::Inch, _) => decimals + 1,
        }
    }

    /// A length without its unit; `decimals` are those of mm.
    pub fn number(self, mm: f64, decimals: usize) -> String {
        let decimals = self.decimals(decimals);
        with_minus_signs(&format!("{:.decimals$}", self.of_mm(mm)))
    }

    /// As [`Self::number`], without zeros at its end.
    pub fn short(self, mm: f64, decimals: usize) -> String {
        let text = self.number(mm, decimals);
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    }

    /// A length with its unit; `decimals` are those of mm.
    pub fn length(self, mm: f64, decimals: usize) -> String {
        format!("{} {}", self.number(mm, decimals), self.length_unit())
    }

    /// A length with its sign, without its unit; one that is shown as zero has none.
    pub fn signed(self, mm: f64, decimals: usize) -> String {
        let text = self.number(mm.abs(), decimals);
        let is_zero = !text.chars().any(|c| ('1'..='9').contains(&c));
        let sign = match (is_zero, mm < 0.0) {
            (true, _) => "",
            (false, true) => "−",
            (false, false) => "+",
        };
        format!("{sign}{text}")
    }

    /// As [`Self::signed`], with its unit.
    pub fn signed_length(self, mm: f64, decimals: usize) -> String {
        format!("{} {}", self.signed(mm, decimals), self.length_unit())
    }

    /// Stock on a wall above its allowance, overcut where it is negative, with its unit. It has the same
    /// decimals everywhere, those of the command line.
    pub fn deviation(self, mm: f64) -> String {
        self.signed_length(mm, DEVIATION_DECIMALS)
    }

    /// Overcut and undercut of walls with one unit.
    pub fn deviations(self, overcut: f64, undercut: f64) -> String {
        format!("{} / {}", self.signed(-overcut, DEVIATION_DECIMALS), self.deviation(undercut))
    }

    /// Two lengths with one unit, "a to b".
    pub fn range(self, from: f64, to: f64, decimals: usize) -> String {
        format!("{} to {}", self.number(from, decimals), self.length(to, decimals))
    }

    /// A length with its unit; a dash where it is not known.
    pub fn known_length(self, mm: f64, decimals: usize) -> String {
        if mm.is_finite() { self.length(mm, decimals) } else { "-".to_owned() }
    }

    /// The size of a tool, without unit and zeros at its end.
    pub fn size(self, mm: f64) -> String {
        match self {
            Self::Metric => self.short(mm, 3),
            // Thousandths, as tools are named.
            Self::Inch => self.short(mm, 1),
        }
    }

    /// A diameter with its sign, without unit and zeros at its end.
    pub fn diameter(self, mm: f64) -> String {
        format!("Ø{}", self.size(mm))
    }

    /// A feed rate with its unit.
    pub fn feed(self, mm_per_min: f64) -> String {
        format!("{} {}", self.number(mm_per_min, 0), self.feed_unit())
    }

    /// A volume with its unit, from mm³.
    pub fn volume(self, cubic_mm: f64) -> String {
        match self {
            Self::Metric => format!("{:.1} cm³", 1e-3 * cubic_mm),
            Self::Inch => format!("{:.2} in³", cubic_mm / INCH_MM.powi(3)),
        }
    }

    /// Two lengths with one unit, such as mean and percentile of the residual stock; a dash for what is not
    /// known.
    pub fn pair(self, a: f64, b: f64, decimals: usize) -> String {
        let show = |mm: f64| if mm.is_finite() { self.number(mm, decimals) } else { "-".to_owned() };
        format!("{}/{}", show(a), show(b))
    }

    /// The value of typed `text` in mm, mm/min, degrees or whatever the field holds: a number without unit is
    /// in the unit of the window.
    pub fn parse(self, text: &str, quantity: Quantity) -> Option<f64> {
        let value = number::parse(text, quantity)?;
        let is_length = matches!(quantity, Quantity::Length | Quantity::FeedRate);
        // The unit "/min" cannot follow a length: what has a letter, or a sign of inches, has a unit.
        let has_unit = text.chars().any(|c| c.is_alphabetic() || c == '"' || c == '″');
        Some(if is_length && !has_unit { self.to_mm(value) } else { value })
    }
}

#[cfg(test)]
mod tests {
    use super::DisplayUnits::{Inch, Metric};
    use super::{Quantity, decimals_beside};

    #[test]
    fn negative_lengths_have_a_minus_sign_that_is_read_again() {
        assert_eq!((Metric.number(-1.5, 1), Metric.length(-12.0, 0)), ("−1.5".into(), "−12 mm".into()));
        assert_eq!(Metric.parse("−1.5", Quantity::Length), Some(-1.5));
    }

    #[test]
    fn only_what_is_not_shown_as_zero_has_a_sign() {
        let shown = [-0.01, -0.00004, 0.0, 0.00004, 0.01].map(|mm| Metric.signed(mm, 4));
        assert_eq!(shown, ["−0.0100", "0.0000", "0.0000", "0.0000", "+0.0100"]);
        assert_eq!(Inch.signed_length(-0.254, 3), "−0.0100 in");
    }

    #[test]
    fn lengths_and_feed_rates_have_the_unit_of_the_window() {
        assert_eq!((Metric.length(12.7, 2), Inch.length(12.7, 2)), ("12.70 mm".into(), "0.5000 in".into()));
        assert_eq!((Metric.diameter(30.0), Inch.diameter(25.4)), ("Ø30".into(), "Ø1".into()));
        assert_eq!((Metric.size(12.125), Inch.size(30.0)), ("12.125".into(), "1.181".into()));
        assert_eq!((Metric.feed(300.0), Inch.feed(300.0)), ("300 mm/min".into(), "11.8 in/min".into()));
        assert_eq!((Metric.short(0.5, 3), Inch.short(0.5, 3)), ("0.5".into(), "0.0197".into()));
        assert_eq!((Metric.short(300.0, 0), Inch.short(25.4, 0)), ("300".into(), "1".into()));
        assert_eq!(Metric.pair(1.0, f64::NAN, 2), "1.00/-");
    }

    #[test]
    fn lengths_beside_a_fine_allowance_have_a_decimal_more() {
        for (allowance, decimals) in [(0.0, 2), (0.5, 2), (0.29, 2), (1.15, 2), (0.025, 3), (0.0375, 3)] {
            assert_eq!(decimals_beside(allowance), decimals, "{allowance}");
        }
    }

    #[test]
    fn numbers_without_unit_are_in_the_unit_of_the_window() {
        for (units, text, quantity, value) in [
            (Metric, "5", Quantity::Length, 5.0),
            (Inch, "0.5", Quantity::Length, 12.7),
            (Inch, "1/2", Quantity::Length, 12.7),
            (Inch, "5 mm", Quantity::Length, 5.0),
            (Metric, "1\"", Quantity::Length, 25.4),
            (Inch, "1\"", Quantity::Length, 25.4),
            (Inch, "10", Quantity::FeedRate, 254.0),
            (Inch, "254 mm/min", Quantity::FeedRate, 254.0),
            (Inch, "5", Quantity::Angle, 5.0),
            (Inch, "1200", Quantity::SpindleSpeed, 1200.0),
            (Metric, "1.5 h", Quantity::Duration, 90.0),
            (Metric, "90 min", Quantity::Duration, 90.0),
            (Metric, "30", Quantity::Duration, 30.0),
        ] {
            let parsed = units.parse(text, quantity).unwrap_or_else(|| panic!("{text} is a number"));
            assert!((parsed - value).abs() < 1e-12, "{text:?}: {parsed}");
        }
        assert_eq!(Inch.parse("5 °", Quantity::Length), None);
    }
}
