//! Benchmarks of the residual kernels on a floor like that of an impeller of diameter 532 mm:
//! `cargo bench --bench kernels`.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use vanecut::stock::{FieldCutter, FloorGrid, residual_field, statistics};

/// Length of the hub curve, mm.
const LENGTH: f64 = 200.0;
/// Positions per row, at a step of 8 mm.
const PER_ROW: usize = 25;

/// Point and normal of the floor: a hub that turns from almost axial to almost radial, and a channel that
/// wraps around it and widens from 45 to 75 mm.
fn floor(s: f64, lambda: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (bend, start) = (150.0, 0.15_f64);
    let phi = start + s * LENGTH / bend;
    let r = 131.0 + bend * (start.cos() - phi.cos());
    let z = bend * (start.sin() - phi.sin());
    let theta = 0.9 * s * (1.0 - 0.3 * s) + (lambda - 0.5) * (45.0 + 30.0 * s) / r;
    let radial = Vector3::new(theta.cos(), theta.sin(), 0.0);
    (radial * r + Vector3::z() * z, radial * phi.cos() + Vector3::z() * phi.sin())
}

fn grid(n: usize) -> FloorGrid {
    let cells = || (0..n * n).map(|c| (((c / n) as f64 + 0.5) / n as f64, ((c % n) as f64 + 0.5) / n as f64));
    let single = |v: Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
    FloorGrid {
        rows: n,
        columns: n,
        points: cells().map(|(s, l)| single(floor(s, l).0)).collect(),
        normals: cells().map(|(s, l)| single(floor(s, l).1)).collect(),
        blank_heights: cells().map(|(s, _)| (60.0 - 38.0 * s) as f32).collect(),
        areas: vec![(LENGTH * 60.0 / (n * n) as f64) as f32; n * n],
        floor: vec![true; n * n],
        reachable: vec![true; n * n],
    }
}

/// Rows of plunges from the rim to the inlet, radius 8 mm, axes tilted with the walls.
fn cutters(positions: usize, corner_radius: f32) -> Vec<FieldCutter> {
    let rows = positions.div_ceil(PER_ROW);
    let row_of = |k: usize| k / PER_ROW;
    (0..positions)
        .map(|k| {
            let s = 1.0 - (k % PER_ROW) as f64 * 8.0 / LENGTH;
            let lambda = 0.12 + 0.76 * row_of(k) as f64 / (rows - 1).max(1) as f64;
            let (p, n) = floor(s, lambda);
            let along = (floor(s - 1e-4, lambda).0 - p).normalize();
            let across = n.cross(&along);
            let axis = (n + along * 0.12 + across * 0.35 * (lambda - 0.5)).normalize();
            let tip = p + n * 1.2;
            FieldCutter {
                tip: [tip.x as f32, tip.y as f32, tip.z as f32],
                radius: 8.0,
                axis: [axis.x as f32, axis.y as f32, axis.z as f32],
                core_radius: 3.0,
                corner_radius,
            }
        })
        .collect()
}

fn residual(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("residual");
    group.sample_size(10);
    for (name, n, positions, corner) in
        [("512x150", 512, 150, 0.0), ("512x150 corner 0.8", 512, 150, 0.8), ("1024x1000", 1024, 1000, 0.0)]
    {
        let (grid, cutters) = (grid(n), cutters(positions, corner));
        group.bench_function(format!("cpu {name}"), |b| b.iter(|| residual_field(&grid, &cutters)));
        #[cfg(feature = "gpu")]
        if let Ok(gpu) = vanecut::gpu::Gpu::headless() {
            let kernel = vanecut::gpu::ResidualKernel::new(&gpu).expect("the kernel compiles");
            let label = if gpu.is_software() { "software" } else { "gpu" };
            group.bench_function(format!("{label} {name}"), |b| {
                b.iter(|| kernel.run(&gpu, &grid, &cutters).expect("the kernel runs"));
            });
        }
    }
    let grid = grid(512);
    let field = residual_field(&grid, &cutters(150, 0.0));
    group.bench_function("statistics 512", |b| b.iter(|| statistics(&grid, &field.heights, |_| true)));
    group.finish();
}

criterion_group!(benches, residual);
criterion_main!(benches);
