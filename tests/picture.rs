//! Pictures of a sample part, drawn without a window and checked pixel by pixel.

#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests make and read their own files")]
#![cfg(feature = "gpu")]

use std::path::Path;
use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};
use vanecut::cutting::contact::CoreContact;
use vanecut::drawing::cutters::{cutter_set, evaluated_cutters, placed_cutters};
use vanecut::drawing::floor::floor_meshes;
use vanecut::drawing::scene_of_part;
use vanecut::geometry::{Point, Vector};
use vanecut::gpu::mesh::{Mesh, Paint, Vertex};
use vanecut::gpu::{
    Camera, CutterFilter, FloorColours, Gpu, Picture, Renderer, Scene, SceneOptions, SectionPlane, View,
};
use vanecut::io::read_part;
use vanecut::palette::{INTERFERING, SELECTED};
use vanecut::part::Impeller;
use vanecut::plunge::plan::{Evaluation, PlungePlan, Position, SectionPlan, Unevaluated};
use vanecut::setup::{AxisPolicy, CutDirection, SectionKind, Tool};
use vanecut::stock::FloorGrid;

const SIZE: UVec2 = UVec2::new(300, 240);

fn part() -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/impeller532.toml");
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

/// Hub point and normal at `s`, offset from the suction-side wall's foot by `share` of the pitch.
fn on_hub(part: &Impeller, s: f64, share: f64) -> (Point, Vector) {
    let foot = part.main.suction.point(s, 0.0);
    let (sin, cos) = (foot.y.atan2(foot.x) + share * part.pitch()).sin_cos();
    let (m, n) = (part.hub.point(s), part.hub.normal(s));
    (Point::new(m.r * cos, m.r * sin, m.z), Vector::new(n.r * cos, n.r * sin, n.z))
}

/// Two plunges along the hub's normal in the channel, the second one interfering.
fn plan(part: &Impeller) -> PlungePlan {
    let position = |s: f64, depth: f64| {
        let (foot, axis) = on_hub(part, s, 0.5);
        Position {
            tip: foot + axis * 0.5,
            axis,
            section: 0,
            row: 0,
            s,
            lambda: 0.5,
            alpha_rad: 0.0,
            contact_point: foot,
            lift: 0.0,
            blocked: None,
            limited_by: None,
            hub_clearance: 0.5,
            blade_clearance: 5.0,
            evaluation: Evaluation {
                contact: CoreContact { depth, area_share: 0.2 },
                retract: foot + axis * 40.0,
                retract_clearance: 5.0,
                engagement: Default::default(),
                motion: Default::default(),
                breach: None,
            },
        }
    };
    let tool = Tool {
        number: 1,
        diameter: 24.0,
        corner_radius: 1.0,
        insert_width: 8.0,
        overhang: 100.0,
        plunge_feed: 300.0,
        spindle: 2000.0,
        assembly: Default::default(),
    };
    PlungePlan {
        policy: AxisPolicy::Conventional,
        sections: vec![SectionPlan {
            tool,
            from: 1.0,
            to: 0.6,
            feed: CutDirection::OutletToInlet,
            rows: 1,
            kind: SectionKind::Rows,
            added: None,
        }],
        positions: vec![position(0.95, 0.0), position(0.75, 2.0)],
        dropped: Vec::new(),
        iterations: 1,
        converged: true,
    }
}

/// A small grid in the middle of the channel.
fn floor(part: &Impeller) -> FloorGrid {
    let (rows, columns) = (24, 12);
    let mut grid = FloorGrid {
        rows,
        columns,
        points: Vec::new(),
        normals: Vec::new(),
        blank_heights: vec![40.0; rows * columns],
        areas: vec![1.0; rows * columns],
        floor: vec![true; rows * columns],
        reachable: vec![true; rows * columns],
    };
    for i in 0..rows {
        for j in 0..columns {
            let s = 0.5 + 0.5 * i as f64 / (rows - 1) as f64;
            let (p, n) = on_hub(part, s, 0.3 + 0.4 * j as f64 / (columns - 1) as f64);
            grid.points.push([p.x, p.y, p.z].map(|x| x as f32));
            grid.normals.push([n.x, n.y, n.z].map(|x| x as f32));
        }
    }
    grid
}

/// Number of pixels with nearly the hue of `colour`, independent of shading.
fn pixels_like(picture: &Picture, colour: [f32; 3]) -> usize {
    let unit = |c: [f32; 3]| c.map(|x| x / c.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6));
    let wanted = unit(colour);
    let like = |p: &&[u8]| {
        let seen = unit([f32::from(p[0]), f32::from(p[1]), f32::from(p[2])]);
        wanted.iter().zip(seen).map(|(a, b)| a * b).sum::<f32>() > 0.995
    };
    picture.rgba.chunks_exact(4).filter(like).count()
}

struct Studio {
    gpu: Gpu,
    renderer: Renderer,
}

impl Studio {
    fn new() -> Self {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let renderer = Renderer::new(&gpu);
        Self { gpu, renderer }
    }

    fn shot(&mut self, scene: &Scene, view: View, options: &SceneOptions, samples: u32) -> Picture {
        let camera = Camera::standard(view, scene.framing(), SIZE.x as f32 / SIZE.y as f32);
        self.renderer.render(&self.gpu, scene, &camera, options, SIZE, samples);
        let picture = self.renderer.read_rgba(&self.gpu).expect("drawn");
        assert_eq!((picture.width, picture.height), (SIZE.x, SIZE.y));
        picture
    }
}

#[test]
fn a_wheel_fills_the_picture_the_same_every_time() {
    let mut studio = Studio::new();
    let scene = scene_of_part(&studio.gpu, &part());
    assert!(scene.triangles() < 150_000, "{} triangles", scene.triangles());
    let options = SceneOptions::default();
    let picture = studio.shot(&scene, View::Iso, &options, 4);
    assert!(picture.rgba.chunks_exact(4).all(|p| p[3] == 255), "opaque");
    let empty = SceneOptions { show_hub: false, show_blades: false, ..options };
    let background = studio.shot(&scene, View::Iso, &empty, 4);
    let pairs = picture.rgba.chunks_exact(4).zip(background.rgba.chunks_exact(4));
    let share = pairs.filter(|(a, b)| a != b).count() as f32 / (SIZE.x * SIZE.y) as f32;
    assert!((0.3..0.9).contains(&share), "the wheel covers {share} of the picture");
    assert_eq!(picture, studio.shot(&scene, View::Iso, &options, 4), "drawn twice");
    let shroud = SceneOptions { show_shroud: true, ..options };
    assert_ne!(picture, studio.shot(&scene, View::Iso, &shroud, 4), "under glass");
}

#[test]
fn cutters_show_in_the_colour_of_their_state() {
    let mut studio = Studio::new();
    let part = part();
    let mut scene = scene_of_part(&studio.gpu, &part);
    scene.set_cutters(cutter_set(&plan(&part)));
    let hidden = SceneOptions { show_cutters: CutterFilter::Hidden, ..Default::default() };
    let all = SceneOptions { show_cutters: CutterFilter::All, ..hidden };
    let mut red =
        |options: &SceneOptions| pixels_like(&studio.shot(&scene, View::Section(1), options, 4), INTERFERING);
    assert_eq!(red(&hidden), 0);
    assert!(red(&all) > 100);
    assert_eq!(red(&SceneOptions { up_to: Some(1), ..all }), 0, "before the second plunge");
    let selected = SceneOptions { selected: Some(1), ..hidden };
    let picture = studio.shot(&scene, View::Section(1), &selected, 1);
    assert!(pixels_like(&picture, SELECTED) > 100);
}

#[test]
fn the_floor_shows_the_legends_colour() {
    let mut studio = Studio::new();
    let part = part();
    let mut scene = scene_of_part(&studio.gpu, &part);
    let grid = floor(&part);
    let count = grid.points.len();
    scene.set_floor(&studio.gpu, floor_meshes(&grid, &vec![0.0; count]));
    let options = SceneOptions { range_mm: (0.0, 4.0), ..Default::default() };
    let table = options.map.table();
    let lowest = table[0].map(f32::from);
    let highest = table[255].map(f32::from);
    let low = studio.shot(&scene, View::Channel, &options, 4);
    scene.set_heights(&studio.gpu, floor_meshes(&grid, &vec![4.0; count]).expect("it fits"));
    let high = studio.shot(&scene, View::Channel, &options, 4);
    let plain = SceneOptions { show_floor_colours: FloorColours::Plain, ..options };
    let plain = studio.shot(&scene, View::Channel, &plain, 4);
    for (colour, with, without) in [(lowest, &low, &high), (highest, &high, &low)] {
        let seen = pixels_like(with, colour);
        assert!(seen > 500, "{seen} pixels of {colour:?}");
        assert!(pixels_like(without, colour) < 50 && pixels_like(&plain, colour) < 50, "{colour:?}");
    }
}

#[test]
fn the_pointer_finds_the_cutter_that_is_seen() {
    let studio = Studio::new();
    let part = part();
    let mut scene = scene_of_part(&studio.gpu, &part);
    let plan = plan(&part);
    scene.set_cutters(cutter_set(&plan));
    let size = SIZE.as_vec2();
    let camera = Camera::standard(View::Section(1), scene.framing(), size.x / size.y);
    let options = SceneOptions { show_cutters: CutterFilter::All, ..Default::default() };
    for (k, position) in plan.positions.iter().enumerate() {
        let above = position.tip + position.axis * 5.0;
        let above = Vec3::new(above.x as f32, above.y as f32, above.z as f32);
        let pixel = camera.project(above, size).expect("in front");
        let pick = scene.pick(&camera, &options, pixel, size).expect("something there");
        assert_eq!(pick.position, Some(k));
    }
    let far_off = Vec2::new(1e6, 1e6);
    assert_eq!(scene.pick(&camera, &options, far_off, size), None);
}

#[test]
fn where_the_section_plane_cuts_material_it_hides_cutters_and_is_a_place_to_measure() {
    let mut studio = Studio::new();
    let part = part();
    let mut scene = scene_of_part(&studio.gpu, &part);
    scene.set_cutters(cutter_set(&plan(&part)));
    let size = SIZE.as_vec2();
    let (wheel, channel) = (scene.framing().wheel.center, scene.framing().channel.center);
    let (mut cut, mut agree, mut total, mut behind) = (0, 0, 0, 0);
    for (view, through) in [(View::Iso, wheel), (View::Channel, channel), (View::Section(1), channel)] {
        let camera = Camera::standard(view, scene.framing(), size.x / size.y);
        // Across the line of sight: everything in front of the plane is clipped.
        let normal = camera.basis().2;
        let section = SectionPlane { normal, offset: normal.dot(through) };
        let options = SceneOptions { section: Some(section), ..Default::default() };
        let whole = SceneOptions { show_cutters: CutterFilter::Hidden, ..options };
        let picture = studio.shot(&scene, view, &whole, 1);
        let grey = options.theme.greys().section.map(|x| x * 255.0);
        for (x, y) in (2..SIZE.x).step_by(9).flat_map(|x| (2..SIZE.y).step_by(9).map(move |y| (x, y))) {
            let at = 4 * (y * SIZE.x + x) as usize;
            let seen = &picture.rgba[at..at + 3];
            let like =
                |share: f32| seen.iter().zip(grey).all(|(&a, b)| (f32::from(a) - b * share).abs() < 2.0);
            let is_cap = like(1.0) || like(0.84);
            let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let pick = scene.pick(&camera, &whole, pixel, size);
            let on_section = pick.is_some_and(|pick| pick.on_section);
            total += 1;
            agree += usize::from(on_section == is_cap);
            let Some(pick) = pick.filter(|_| on_section && is_cap) else { continue };
            cut += 1;
            let off = normal.dot(pick.point) - section.offset;
            assert!(off.abs() < 0.05, "a point of the plane itself: {off} mm off");
            // Cutters that protrude from the plane may be picked, those behind it may not.
            let picked = studio.renderer.pick(&studio.gpu, &scene, &camera, &options, pixel, size);
            let seen = || scene.pick(&camera, &options, pixel, size).and_then(|pick| pick.position);
            behind += usize::from(picked.expect("the device answers").is_some() && seen().is_none());
        }
    }
    assert!(cut > 100, "{cut} points on the cut");
    assert!(agree * 100 >= total * 98, "picture and pointer agree at {agree} of {total} points");
    // Picking accepts a few pixels beside the edge of a cutter.
    assert!(behind * 50 <= cut, "{behind} of {cut} points on the cut pick a cutter behind it");
}

#[test]
fn cutters_of_a_plan_in_the_making_are_grey_until_they_are_judged_and_no_positions() {
    let mut studio = Studio::new();
    let part = part();
    let mut scene = scene_of_part(&studio.gpu, &part);
    let plan = plan(&part);
    scene.set_cutters(cutter_set(&plan));
    let options = SceneOptions { show_cutters: CutterFilter::All, ..Default::default() };
    let mut red =
        |scene: &Scene| pixels_like(&studio.shot(scene, View::Section(1), &options, 4), INTERFERING);
    assert!(red(&scene) > 100, "the plan before the preview");
    scene.set_preview(Some(placed_cutters(&plan.clone().with_evaluations(|_| Unevaluated)).into()));
    assert_eq!(red(&scene), 0, "not evaluated");
    let size = SIZE.as_vec2();
    let camera = Camera::standard(View::Section(1), scene.framing(), size.x / size.y);
    let above = plan.positions[1].tip + plan.positions[1].axis * 3.0;
    let pixel = camera.project(Vec3::new(above.x as f32, above.y as f32, above.z as f32), size);
    let pixel = pixel.expect("in front");
    let pick = |scene: &Scene| scene.pick(&camera, &options, pixel, size).and_then(|pick| pick.position);
    assert_eq!(pick(&scene), None);
    scene.set_preview(Some(evaluated_cutters(&plan).into()));
    assert!(red(&scene) > 100, "judged");
    scene.set_preview(None);
    assert_eq!(pick(&scene), Some(1), "the plan before can be picked again");
}

/// A tetrahedron about the origin, as a solid stock.
fn tetrahedron(size: f32) -> Mesh {
    let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let vertices =
        corners.map(|corner| Vertex::painted(corner.map(|x| size * x), [0.0; 3], 0.0, Paint::UNCUT));
    let indices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    Mesh { vertices: vertices.to_vec(), indices: indices.to_vec() }
}

#[test]
fn a_solid_in_motion_is_drawn_by_its_coarser_triangles() {
    let mut studio = Studio::new();
    let gpu = studio.gpu.clone();
    let mut scene = scene_of_part(&gpu, &part());
    let mut shot = |scene: &Scene, draft: bool| {
        let options = SceneOptions { show_solid: true, draft, ..SceneOptions::default() };
        studio.shot(scene, View::Iso, &options, 1)
    };
    scene.set_solid(&gpu, Some(Arc::new(tetrahedron(100.0))));
    let small = shot(&scene, true);
    scene.set_solid(&gpu, Some(Arc::new(tetrahedron(200.0))));
    let large = shot(&scene, true);
    assert!(small != large);
    scene.set_solid_draft(&gpu, &tetrahedron(100.0));
    assert!(shot(&scene, true) == small, "in motion");
    assert!(shot(&scene, false) == large, "at rest");
}
