//! Round numbers along the scale of a plot.

/// Most marks of a scale.
const MOST: f64 = 6.0;

/// Multiples of the smallest step of 1, 2 or 5 times a power of ten that has at most six within `low`…`high`,
/// with the decimals that tell them apart.
pub fn ticks((low, high): (f64, f64)) -> (Vec<f64>, usize) {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return (Vec::new(), 0);
    }
    let decade = (span / MOST).log10().floor();
    let steps = [1.0, 2.0, 5.0, 10.0].map(|x| x * 10f64.powf(decade));
    let step = steps.into_iter().find(|step| span / step <= MOST).unwrap_or(10f64.powf(decade + 1.0));
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let decimals = (-(step * 1.000_001).log10().floor()).max(0.0) as usize;
    ((first..=last).map(|k| k as f64 * step).collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::ticks;

    #[test]
    fn marks_are_round_and_within_the_scale() {
        assert_eq!(ticks((2.1, 27.4)), (vec![5.0, 10.0, 15.0, 20.0, 25.0], 0));
        assert_eq!(ticks((37.0, 143.0)), (vec![40.0, 60.0, 80.0, 100.0, 120.0, 140.0], 0));
        assert_eq!(ticks((0.0, 4.0)), (vec![0.0, 1.0, 2.0, 3.0, 4.0], 0));
        let (marks, decimals) = ticks((0.61, 0.74));
        assert_eq!((marks.len(), decimals), (2, 2), "{marks:?}");
        assert_eq!(ticks((1.0, 1.0)).0.len(), 0);
    }
}
