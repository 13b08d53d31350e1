//! Line charts as SVG.

use super::html::escaped;
use crate::palette::{CURVES, to_bytes};

/// A curve of a chart.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// (x, y), sorted by x.
    pub points: Vec<(f64, f64)>,
    /// Index into the colours; related series share a colour.
    pub colour: usize,
    /// Index into the dash styles: solid, dashed, dotted.
    pub dash: usize,
    /// A point of the curve to mark.
    pub mark: Option<(f64, f64)>,
}

/// A chart.
#[derive(Clone, Debug)]
pub struct LineChart {
    /// Heading.
    pub title: String,
    /// Label of the x axis.
    pub x_label: String,
    /// Label of the y axis.
    pub y_label: String,
    /// The curves.
    pub series: Vec<Series>,
}

const DASHES: [&str; 3] = ["", " stroke-dasharray=\"9 4\"", " stroke-dasharray=\"2 4\""];
const SIZE: (f64, f64) = (900.0, 460.0);
/// Left, top, right, bottom of the plotted field.
const FIELD: (f64, f64, f64, f64) = (70.0, 40.0, 600.0, 405.0);

impl LineChart {
    /// Step of the marks of the y axis, and its upper end, which is a mark; it begins at 0.
    pub fn y_scale(&self) -> (f64, f64) {
        let highest = self.series.iter().flat_map(|s| &s.points).map(|p| p.1).fold(0.0, f64::max);
        let step = tick_step(highest.max(1e-3));
        (step, (highest / step).ceil().max(1.0) * step)
    }

    /// The chart as a complete SVG file. x runs from 0 to 1, y from 0 to just above the highest value.
    pub fn svg(&self) -> String {
        let (left, top, right, bottom) = FIELD;
        let (step, y_max) = self.y_scale();
        let x = |value: f64| left + value * (right - left);
        let y = |value: f64| bottom - value / y_max * (bottom - top);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"sans-serif\" font-size=\"13\">\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n\
             <text x=\"{left}\" y=\"24\" font-size=\"16\">{}</text>\n",
            escaped(&self.title),
            w = SIZE.0,
            h = SIZE.1,
        );
        for i in 0..=10 {
            let value = f64::from(i) / 10.0;
            svg += &format!("<path d=\"M{0:.1} {top}V{bottom}\" stroke=\"#e4e7ea\"/>\n", x(value));
            if i % 2 == 0 {
                let (at, below) = (x(value), bottom + 18.0);
                svg +=
                    &format!("<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{value:.1}</text>\n");
            }
        }
        let decimals = if step < 1.0 { (-step.log10()).ceil() as usize } else { 0 };
        for i in 0..=(y_max / step).round() as usize {
            let value = i as f64 * step;
            svg += &format!("<path d=\"M{left} {0:.1}H{right}\" stroke=\"#e4e7ea\"/>\n", y(value));
            let (at, height) = (left - 8.0, y(value) + 4.5);
            svg += &format!(
                "<text x=\"{at}\" y=\"{height:.1}\" text-anchor=\"end\">{value:.decimals$}</text>\n"
            );
        }
        svg += &format!(
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
            0.5 * (left + right),
            bottom + 40.0,
            escaped(&self.x_label)
        );
        svg += &format!(
            "<text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
            0.5 * (top + bottom),
            escaped(&self.y_label)
        );
        for (k, series) in self.series.iter().enumerate() {
            let [r, g, b] = to_bytes(CURVES[series.colour % CURVES.len()]);
            let colour = format!("#{r:02X}{g:02X}{b:02X}");
            let style = format!(
                "stroke=\"{colour}\" stroke-width=\"2\" fill=\"none\"{}",
                DASHES[series.dash % DASHES.len()]
            );
            let path: Vec<String> =
                series.points.iter().map(|p| format!("{:.1} {:.1}", x(p.0), y(p.1))).collect();
            if !path.is_empty() {
                svg += &format!("<path d=\"M{}\" {style}/>\n", path.join("L"));
            }
            if let Some(mark) = series.mark {
                let (cx, cy) = (x(mark.0), y(mark.1));
                svg += &format!("<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"4\" fill=\"{colour}\"/>\n");
            }
            let line = top + 10.0 + 20.0 * k as f64;
            let (from, to, text) = (right + 15.0, right + 45.0, right + 52.0);
            svg += &format!("<path d=\"M{from} {line}H{to}\" {style}/>\n");
            svg += &format!("<text x=\"{text}\" y=\"{}\">{}</text>\n", line + 4.5, escaped(&series.name));
        }
        svg + "</svg>\n"
    }
}

/// Smallest step of 1, 2 or 5 times a power of ten that divides 0…`highest` into at most ten parts.
fn tick_step(highest: f64) -> f64 {
    let decade = 10f64.powf((highest / 10.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|x| x * decade)
        .into_iter()
        .find(|step| highest / step <= 10.0)
        .unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_few() {
        for (highest, step) in
            [(65.4, 10.0), (80.7, 10.0), (9.9, 1.0), (0.8, 0.1), (0.013, 0.002), (10.0, 1.0)]
        {
            assert!((tick_step(highest) - step).abs() < 1e-12, "{highest}: {}", tick_step(highest));
        }
    }

    #[test]
    fn values_land_on_the_scale() {
        let series = Series {
            name: "a < b".to_owned(),
            points: vec![(0.0, 0.0), (1.0, 10.0)],
            colour: 0,
            dash: 1,
            mark: Some((0.5, 5.0)),
        };
        let chart = LineChart {
            title: "t".to_owned(),
            x_label: "s".to_owned(),
            y_label: "mm".to_owned(),
            series: vec![series],
        };
        let svg = chart.svg();
        assert!(svg.contains("d=\"M70.0 405.0L600.0 40.0\""), "{svg}");
        assert!(svg.contains("cx=\"335.0\" cy=\"222.5\"") && svg.contains("a &lt; b"), "{svg}");
    }
}
