//! Pictures and charts of an assessment, and the HTML page that shows them.

use super::assessment_figures::tables;
use super::chart::{LineChart, Series};
use super::html::escaped;
use super::pictures::SIZE;
use super::{PagePicture, ReportPage};
use crate::assess::passage::{PassageMeasure, wall_widths};
use crate::assess::reach::{ReachMap, ReachSides};
use crate::assess::shape::tangents;
use crate::assess::{Assessment, blades_of};
use crate::drawing::floor::floor_mesh;
use crate::drawing::scene_of_part;
use crate::drawing::walls::wall_mesh;
use crate::error::UserError;
use crate::gpu::image::draw_png;
use crate::gpu::mesh::{Mesh, even_steps};
use crate::gpu::{FloorColours, Gpu, Renderer, SceneOptions, View};
use crate::job::assess::AssessedPart;
use crate::part::{Blade, BladeSide, Impeller, Workpiece};
use crate::setup::Setup;
use crate::stock::surface::MAX_LINES;
use crate::stock::{FloorGrid, FloorSource};

/// Number of floor cells along s and along λ.
const FLOOR_CELLS: usize = 256;
/// Number of wall lines along u and v at which the width is measured.
const WALL_LINES: (usize, usize) = (120, 16);

/// The page with its pictures, whose names begin with `prefix`.
///
/// # Errors
/// When no graphics device is available, or when drawing fails.
pub fn assessment_page(assessed: &AssessedPart, prefix: &str) -> Result<ReportPage, UserError> {
    let AssessedPart { workpiece, setup, assessment, .. } = assessed;
    let part = &workpiece.part;
    let gpu = Gpu::headless()?;
    let mut renderer = Renderer::new(&gpu);
    let mut scene = scene_of_part(&gpu, part);
    let mut picture = |mesh: Mesh, range: (f32, f32)| {
        scene.set_values(&gpu, mesh);
        let options = SceneOptions { range_mm: range, ..SceneOptions::for_colours(FloorColours::Values) };
        draw_png(&gpu, &mut renderer, &scene, View::Channel, &options, SIZE, false)
    };
    let mut pictures = Vec::new();
    if let Some(map) = &assessment.reach {
        pictures.push(PagePicture {
            name: format!("{prefix}reach.png"),
            bytes: picture(reach_mesh(workpiece, setup, map), (0.0, 3.0))?,
            caption: "Floor reached by the cutters. Dark blue: not reached; grey: from the inlet only; \
                      sand: from the outlet only; yellow: from both sides."
                .to_owned(),
        });
    }
    let (width, least, most) = width_mesh(workpiece);
    pictures.push(PagePicture {
        name: format!("{prefix}width.png"),
        bytes: picture(width, (least, most))?,
        caption: format!(
            "Distance to the opposite wall, {least:.1} mm (dark) to {most:.1} mm (bright) and more."
        ),
    });
    let (gaps, most) = envelope_mesh(workpiece, assessment);
    pictures.push(PagePicture {
        name: format!("{prefix}envelope.png"),
        bytes: picture(gaps, (0.0, most.max(0.01)))?,
        caption: envelope_caption(most),
    });
    let [passages, twist] = assessment_charts(workpiece, assessment);
    pictures.push(PagePicture {
        name: format!("{prefix}passage.svg"),
        bytes: passages.svg().into_bytes(),
        caption: "Depth, narrowest width and largest cutter along the channel.".to_owned(),
    });
    pictures.push(PagePicture {
        name: format!("{prefix}twist.svg"),
        bytes: twist.svg().into_bytes(),
        caption: "Angle between camber line and rotation axis. Dots: where the line is most curved."
            .to_owned(),
    });
    Ok(ReportPage { page: page(part, &tables(assessed), &pictures), pictures })
}

/// Caption of the picture of the gaps to the envelope, the greatest of which is `most`, mm.
fn envelope_caption(most: f32) -> String {
    /// What rounds to nothing, mm.
    const NO_GAP: f32 = 5e-4;
    match most < NO_GAP {
        true => "The walls have no gap to their one-sided envelope.".to_owned(),
        false => {
            format!("Gap between the walls and their one-sided envelope, 0 (dark) to {most:.3} mm (bright).")
        }
    }
}

/// Charts along the channel: depth, narrowest width and largest cutter; twist of the blades.
pub fn assessment_charts(workpiece: &Workpiece, assessment: &Assessment) -> [LineChart; 2] {
    [passage_chart(assessment), twist_chart(workpiece, assessment)]
}

/// The page with these tables, then the pictures.
fn page(part: &Impeller, tables: &str, pictures: &[PagePicture]) -> String {
    let name = escaped(&part.name);
    let figure = |f: &PagePicture| {
        let caption = escaped(&f.caption);
        format!(
            "<figure><img src=\"{}\" width=\"720\" alt=\"{caption}\">\
             <figcaption>{caption}</figcaption></figure>\n",
            escaped(&f.name)
        )
    };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{name}: machinability</title>\n\
         <style>body{{font-family:sans-serif;margin:2em;max-width:800px}}figure{{margin:2em 0}}\
         table{{border-collapse:collapse}}td,th{{padding:.2em 1em .2em 0;text-align:left;border-bottom:1px solid #ccc}}\
         </style>\n\
         <h1>{name}: machinability</h1>\n{tables}{}</html>\n",
        pictures.iter().map(figure).collect::<String>()
    )
}

/// Floor mesh with the class of access as value: 0 not reached, 1 from the inlet, 1.5 only near the hub
/// normal, 2 from the outlet, 3 from both.
fn reach_mesh(workpiece: &Workpiece, setup: &Setup, map: &ReachMap) -> Mesh {
    let source = FloorSource::of_setup(workpiece, setup, &[]);
    let mut grid = FloorGrid::new(&source, FLOOR_CELLS);
    let class = |sides: ReachSides| match (sides.inlet, sides.outlet) {
        (true, true) => 3.0,
        (false, true) => 2.0,
        (true, false) => 1.0,
        (false, false) => {
            if sides.any {
                1.5
            } else {
                0.0
            }
        }
    };
    let value = |cell: usize| {
        let lambda = ((cell % grid.columns) as f64 + 0.5) / grid.columns as f64;
        map.nearest(grid.s_of_row(cell / grid.columns), lambda).map_or(0.0, |c| class(c.reached))
    };
    let values: Vec<f32> = (0..grid.points.len()).map(value).collect();
    // The values are not heights, so no cell may count as uncut.
    grid.blank_heights.fill(f32::INFINITY);
    floor_mesh(&grid, &values, MAX_LINES).unwrap_or_default()
}

/// The walls of the active channel: each with the other side of its blade and the opposite wall.
fn walls<'a>(workpiece: &'a Workpiece, next: &'a Blade) -> Vec<[&'a BladeSide; 3]> {
    let mut blades: Vec<&Blade> = blades_of(workpiece).into_iter().map(|(_, blade)| blade).collect();
    blades.push(next);
    let between = |pair: &[&'a Blade]| {
        let (low, high) = (pair[0], pair[1]);
        [[&low.suction, &low.pressure, &high.pressure], [&high.pressure, &high.suction, &low.suction]]
    };
    blades.windows(2).flat_map(between).collect()
}

/// Mesh of the walls with the distances to the opposite walls, and a range from minimum to 95th percentile,
/// mm.
fn width_mesh(workpiece: &Workpiece) -> (Mesh, f32, f32) {
    let part = &workpiece.part;
    let (u, v) = (even_steps(WALL_LINES.0), even_steps(WALL_LINES.1));
    let next = part.main.rotated(part.pitch());
    let mut mesh = Mesh::default();
    let mut all = Vec::new();
    for [wall, back, facing] in walls(workpiece, &next) {
        let widths = wall_widths(wall, facing, &u, &v);
        mesh.append(&wall_mesh(wall, back, &u, &v, &widths).unwrap_or_default());
        all.extend(widths);
    }
    all.sort_by(f64::total_cmp);
    let at = |share: usize| all.get((all.len().max(1) - 1) * share / 100).map_or(0.0, |&x| x as f32);
    (mesh, at(0), at(95).max(at(0) + 1e-3))
}

/// Mesh of the walls with the gaps to their envelopes, and the largest gap, mm.
fn envelope_mesh(workpiece: &Workpiece, assessment: &Assessment) -> (Mesh, f32) {
    let part = &workpiece.part;
    let turned = part.main.rotated(part.pitch());
    let mut mesh = Mesh::default();
    let mut most = 0.0f64;
    let mut add = |wall: &BladeSide, back: &BladeSide, envelope: &crate::part::WallEnvelope| {
        mesh.append(&wall_mesh(wall, back, &envelope.u, &envelope.v, &envelope.gaps).unwrap_or_default());
        most = most.max(envelope.max_gap());
    };
    for (number, (measured, (_, blade))) in assessment.blades.iter().zip(blades_of(workpiece)).enumerate() {
        // Of the main blades those walls that bound the channel.
        let other = if number == 0 { &turned } else { blade };
        add(&blade.suction, &blade.pressure, &measured.envelopes[0]);
        add(&other.pressure, &other.suction, &measured.envelopes[1]);
    }
    (mesh, most as f32)
}

fn passage_chart(assessment: &Assessment) -> LineChart {
    let mut series = vec![Series {
        name: "depth".to_owned(),
        points: assessment.depths.clone(),
        colour: 0,
        dash: 0,
        mark: None,
    }];
    for (k, passage) in assessment.passages.iter().enumerate() {
        let place = passage.blades.label();
        let curve = |name: &str, dash: usize, points: Vec<(f64, f64)>| Series {
            name: format!("{name}, {place}"),
            points,
            colour: k + 1,
            dash,
            mark: None,
        };
        series.push(curve("width", 0, narrowest(passage)));
        series.push(curve("cutter", 1, passage.cutters.iter().map(|c| (c.s, c.diameter)).collect()));
    }
    LineChart {
        title: "Depth, width, largest cutter".to_owned(),
        x_label: "s, leading edge to rim".to_owned(),
        y_label: "mm".to_owned(),
        series,
    }
}

/// Narrowest width (mm) along s.
fn narrowest(passage: &PassageMeasure) -> Vec<(f64, f64)> {
    let least = |width: [Option<f64>; 3]| width.into_iter().flatten().reduce(f64::min);
    passage.widths.iter().filter_map(|w| Some((w.s, least(w.width)?))).collect()
}

fn twist_chart(workpiece: &Workpiece, assessment: &Assessment) -> LineChart {
    let mut series = Vec::new();
    for (k, ((name, blade), measure)) in blades_of(workpiece).iter().zip(&assessment.blades).enumerate() {
        for (dash, (twist, place)) in
            measure.shape.hub_mid_tip().iter().zip(["hub", "mid span", "tip"]).enumerate()
        {
            let points: Vec<(f64, f64)> =
                tangents(blade, twist.v).into_iter().map(|(at, angle)| (at, angle.to_degrees())).collect();
            let off = |p: &(f64, f64)| (p.0 - twist.split).abs();
            let mark = points.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)));
            series.push(Series { name: format!("{name}, {place}"), points, colour: k, dash, mark });
        }
    }
    LineChart {
        title: "Twist of the camber lines".to_owned(),
        x_label: "fraction of the length, leading to trailing edge".to_owned(),
        y_label: "angle from the rotation axis, °".to_owned(),
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::envelope_caption;

    #[test]
    fn walls_without_a_gap_have_no_scale() {
        assert_eq!(envelope_caption(4e-4), "The walls have no gap to their one-sided envelope.");
        assert!(envelope_caption(6e-4).ends_with("0 (dark) to 0.001 mm (bright)."));
    }
}
