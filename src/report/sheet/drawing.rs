//! Drawings of the setup sheet as SVG: a tool with its dimensions, and the part with its zero point.

use std::fmt::Write;

use crate::geometry::MeridionalCurve;
use crate::part::{Blank, Impeller};
use crate::setup::{OutlineKind, Tool};

/// Height of a tool's drawing, and width beside it for dimensions, px.
const TOOL_HEIGHT: f64 = 230.0;
const TOOL_MARGIN: f64 = 70.0;
/// Size of the part's drawing, px, and the margin in it.
const PART_SIZE: (f64, f64) = (420.0, 320.0);
const PART_MARGIN: f64 = 40.0;
/// Samples of a curve.
const SAMPLES: usize = 60;

/// The tool, tip down, with diameter, overhang and insert width.
pub fn tool_svg(tool: &Tool) -> String {
    let outlines = tool.outline();
    let height = outlines.iter().map(|o| o.from + o.length).fold(tool.overhang, f64::max);
    let radius = outlines.iter().flat_map(|o| o.radii).fold(tool.radius(), f64::max);
    let scale = ((TOOL_HEIGHT - 46.0) / height).min(60.0 / radius);
    let (middle, bottom) = (radius * scale + 12.0, TOOL_HEIGHT - 28.0);
    let width = middle + radius * scale + TOOL_MARGIN;
    let y = |h: f64| bottom - h * scale;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{TOOL_HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"11\" role=\"img\" aria-label=\"tool {}\">",
        tool.number
    );
    for piece in outlines {
        let side = piece.side(tool);
        let right = side.iter().map(|[off, up]| (middle + off * scale, y(*up)));
        let left = side.iter().rev().map(|[off, up]| (middle - off * scale, y(*up)));
        let corners: Vec<String> = right.chain(left).map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        let fill = fill(piece.kind);
        let _ = write!(svg, "<path d=\"M{}Z\" fill=\"{fill}\" stroke=\"#333\"/>", corners.join("L"));
    }
    // The core, which has no edges, in the bottom of the cutter.
    let core = tool.core_radius() * scale;
    if core > 0.5 {
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"6\" fill=\"#d55e00\"/>",
            middle - core,
            bottom - 6.0,
            2.0 * core
        );
    }
    let (side, top) = (middle + radius * scale + 8.0, y(tool.overhang));
    let _ = write!(
        svg,
        "<path d=\"M{side:.1} {top:.1}V{bottom:.1}M{tick:.1} {bottom:.1}h8M{tick:.1} {top:.1}h8\" \
         stroke=\"#333\" fill=\"none\"/><text x=\"{beside:.1}\" y=\"{half:.1}\">{overhang}</text>\
         <text x=\"{middle:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">⌀{diameter}</text></svg>",
        tick = side - 4.0,
        beside = side + 6.0,
        half = 0.5 * (bottom + top),
        overhang = tool.overhang,
        below = bottom + 16.0,
        diameter = tool.diameter,
    );
    svg
}

/// Colour of a piece of a tool.
fn fill(kind: OutlineKind) -> &'static str {
    match kind {
        OutlineKind::Cutter => "#ffe0b2",
        OutlineKind::Body | OutlineKind::Shank | OutlineKind::Holder => "#cfd8dc",
        OutlineKind::AssumedHolder => "#f5f5f5",
    }
}

/// Half a section of the part and its blank through the axis of rotation, with the zero point of the program.
pub fn part_svg(part: &Impeller, blank: &Blank) -> String {
    let curves = [part.hub.curve(), part.shroud.curve(), &blank.hub, &blank.shroud];
    let sampled = |curve: &MeridionalCurve| -> Vec<(f64, f64)> {
        let at = |i: usize| curve.point(curve.length() * i as f64 / SAMPLES as f64);
        (0..=SAMPLES).map(|i| (at(i).r, at(i).z)).collect()
    };
    let outline: Vec<(f64, f64)> = match blank.outline() {
        Some(outline) => outline.points().iter().map(|p| (p.r, p.z)).collect(),
        None => sampled(&blank.hub).into_iter().chain(sampled(&blank.shroud).into_iter().rev()).collect(),
    };
    let all: Vec<(f64, f64)> =
        curves.iter().flat_map(|curve| sampled(curve)).chain(outline.iter().copied()).collect();
    let r_max = all.iter().map(|p| p.0).fold(0.0, f64::max);
    let (low, high) = all.iter().map(|p| p.1).fold((0.0f64, 0.0f64), |(a, b), z| (a.min(z), b.max(z)));
    let (width, height) = PART_SIZE;
    let scale =
        ((width - 2.0 * PART_MARGIN) / r_max).min((height - 2.0 * PART_MARGIN) / (high - low).max(1e-6));
    let at = |(r, z): (f64, f64)| (PART_MARGIN + r * scale, PART_MARGIN + (high - z) * scale);
    let path = |points: &[(f64, f64)]| {
        let shown = points.iter().map(|&p| at(p)).map(|(x, y)| format!("{x:.1} {y:.1}"));
        format!("M{}", shown.collect::<Vec<_>>().join("L"))
    };
    let (zero_x, zero_y) = at((0.0, 0.0));
    let (_, bottom) = at((0.0, low));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\" role=\"img\" aria-label=\"section of part and blank\">\
         <path d=\"{blank}Z\" fill=\"#e3e8ec\" stroke=\"#78909c\"/>\
         <path d=\"{hub}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"2\"/>\
         <path d=\"{shroud}\" fill=\"none\" stroke=\"#78909c\" stroke-dasharray=\"6 3\"/>\
         <path d=\"M{zero_x:.1} 10V{axis_end:.1}\" stroke=\"#333\" stroke-dasharray=\"12 3 3 3\"/>\
         <circle cx=\"{zero_x:.1}\" cy=\"{zero_y:.1}\" r=\"6\" fill=\"none\" \
         stroke=\"#d55e00\" stroke-width=\"2\"/>\
         <path d=\"M{zero_x:.1} {zero_y:.1}m-9 0h18m-9 -9v18\" stroke=\"#d55e00\"/>\
         <text x=\"{label_x:.1}\" y=\"{label_y:.1}\" fill=\"#d55e00\">X0 Y0 Z0</text>\
         <text x=\"{zero_x:.1}\" y=\"10\" dx=\"6\">+Z</text></svg>",
        blank = path(&outline),
        hub = path(&sampled(part.hub.curve())),
        shroud = path(&sampled(part.shroud.curve())),
        axis_end = bottom + 24.0,
        label_x = zero_x + 12.0,
        label_y = zero_y - 10.0,
    )
}
