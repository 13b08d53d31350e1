// Residual stock of plunges on the channel floor. GPU version of src/stock/field.rs and meeting.rs: the same
// operations in the same order, so that both give the same heights. One workgroup per tile of TILE × TILE
// cells, one invocation per cell. Lengths in mm.

struct Grid {
    rows: u32,
    columns: u32,
    tiles_across: u32,
    // Number of plunges that count: the state after n plunges.
    limit: u32,
}

struct Cell {
    foot: vec3<f32>,
    blank: f32,
    normal: vec3<f32>,
    // Units of volume per mm of height; negative if the cell is not floor.
    units: f32,
}

struct Cutter {
    tip: vec3<f32>,
    radius: f32,
    axis: vec3<f32>,
    core_radius: f32,
    corner_radius: f32,
    pad0: f32,
    pad1: f32,
    pad2: f32,
}

struct Trace {
    // Bits of a non-negative f32, which are ordered like the number, so that atomicMax works on them.
    contact_depth: atomic<u32>,
    contact_cells: atomic<u32>,
    swept_cells: atomic<u32>,
    cut_cells: atomic<u32>,
    // In units such that all stock on the floor is at most 2³¹ of them, so that sums do not overflow.
    removed_units: atomic<u32>,
}

@group(0) @binding(0) var<uniform> grid: Grid;
@group(0) @binding(1) var<storage, read> cells: array<Cell>;
@group(0) @binding(2) var<storage, read> cutters: array<Cutter>;
@group(0) @binding(3) var<storage, read> tile_offsets: array<u32>;
@group(0) @binding(4) var<storage, read> tile_cutters: array<u32>;
@group(0) @binding(5) var<storage, read_write> heights: array<f32>;
@group(0) @binding(6) var<storage, read_write> traces: array<Trace>;

// Declared in Rust alone, under the same names, in src/stock/field.rs, meeting.rs and tiles.rs.
override TILE: u32;
override CONTACT_TOLERANCE: f32;
override CUT_TOLERANCE: f32;
override FAR: f32;
override MIN_SQUARED_SINE: f32;
override MIN_COSINE: f32;
override CORNER_STEPS: u32;
override CORNER_TOLERANCE: f32;
// Whether `traces` are wanted besides the heights.
override TRACED: bool;

// Number of cutters whose traces are accumulated in workgroup memory before they are added to `traces`.
const BATCH: u32 = 64u;
var<workgroup> batch_depths: array<atomic<u32>, BATCH>;
var<workgroup> batch_removed: array<atomic<u32>, BATCH>;
// Counts of swept, cut and contact cells in 10 bits each (a tile has 256 cells): one atomic instead of three.
var<workgroup> batch_counts: array<atomic<u32>, BATCH>;
const CUT_SHIFT: u32 = 10u;
const CONTACT_SHIFT: u32 = 20u;
const COUNT_MASK: u32 = 1023u;

struct Meeting {
    z: f32,
    slope: f32,
    squared_sine: f32,
    closing: f32,
    squared_distance: f32,
}

struct Interval {
    entry: f32,
    exit: f32,
}

// Written out because the order of the additions in dot() is not specified.
fn inner_product(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn meeting_of(point: vec3<f32>, normal: vec3<f32>, cutter: Cutter) -> Meeting {
    let from_tip = point - cutter.tip;
    let z = inner_product(from_tip, cutter.axis);
    let slope = inner_product(normal, cutter.axis);
    let start = from_tip - cutter.axis * z;
    let step = normal - cutter.axis * slope;
    return Meeting(
        z,
        slope,
        max(inner_product(step, step), MIN_SQUARED_SINE),
        inner_product(start, step),
        inner_product(start, start),
    );
}

fn discriminant(m: Meeting, squared_radius: f32) -> f32 {
    return m.closing * m.closing - m.squared_sine * (m.squared_distance - squared_radius);
}

fn interval(m: Meeting, squared_radius: f32) -> Interval {
    let half = sqrt(max(discriminant(m, squared_radius), 0.0));
    let inverse = 1.0 / m.squared_sine;
    var enter = (-m.closing - half) * inverse;
    var leave = (-m.closing + half) * inverse;
    let slope = select(m.slope, MIN_COSINE, abs(m.slope) < MIN_COSINE);
    let bottom = -m.z / slope;
    if slope > 0.0 {
        enter = max(enter, bottom);
    } else {
        leave = min(leave, bottom);
    }
    return Interval(max(enter, 0.0), leave);
}

fn contact_depth(m: Meeting, squared_core: f32, height: f32) -> f32 {
    let core = interval(m, squared_core);
    let top = min(height, core.exit);
    let depth = max(m.z + top * m.slope, m.z + core.entry * m.slope);
    let meets = discriminant(m, squared_core) > 0.0 && core.entry < top;
    return select(0.0, max(depth, 0.0), meets);
}

fn ball_entry(m: Meeting, sharp_entry: f32, radius: f32) -> f32 {
    let squared = m.squared_distance + sharp_entry * (2.0 * m.closing + sharp_entry * m.squared_sine);
    let down = max(radius - (m.z + sharp_entry * m.slope), 0.0);
    let outside = squared + down * down - radius * radius;
    if outside <= 2.0 * radius * CORNER_TOLERANCE {
        return sharp_entry;
    }
    let nearing = down * m.slope - (m.closing + sharp_entry * m.squared_sine);
    let discriminant = nearing * nearing - outside;
    if nearing <= 0.0 || discriminant < 0.0 {
        return FAR;
    }
    return sharp_entry + outside / max(nearing + sqrt(discriminant), MIN_COSINE);
}

fn corner_entry(m: Meeting, sharp_entry: f32, cutter: Cutter) -> f32 {
    let inner = cutter.radius - cutter.corner_radius;
    if inner <= 0.0 {
        return ball_entry(m, sharp_entry, cutter.radius);
    }
    var height = sharp_entry;
    for (var i = 0u; i < CORNER_STEPS; i++) {
        let squared = m.squared_distance + height * (2.0 * m.closing + height * m.squared_sine);
        let distance = sqrt(max(squared, MIN_SQUARED_SINE));
        let out = max(distance - inner, 0.0);
        let down = max(cutter.corner_radius - (m.z + height * m.slope), 0.0);
        let length = sqrt(out * out + down * down);
        let gap = length - cutter.corner_radius;
        if gap <= CORNER_TOLERANCE {
            return height;
        }
        let receding = (m.closing + height * m.squared_sine) / distance;
        let rate = (out * receding - down * m.slope) / length;
        if rate >= 0.0 {
            return FAR;
        }
        height -= gap / rate;
    }
    return height;
}

@compute @workgroup_size(TILE, TILE)
fn residual_field(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = tile.y * TILE + local.y;
    let column = tile.x * TILE + local.x;
    let index = row * grid.columns + column;
    let in_grid = row < grid.rows && column < grid.columns;
    // Invocations beyond the edge must reach the barriers too; a negative blank height gives them no stock.
    var point = vec3<f32>(0.0);
    var normal = vec3<f32>(0.0);
    var blank = -1.0;
    var units = -1.0;
    if in_grid {
        point = cells[index].foot;
        normal = cells[index].normal;
        blank = cells[index].blank;
        units = cells[index].units;
    }
    let is_floor = units >= 0.0;
    var height = blank;

    let tile_index = tile.y * grid.tiles_across + tile.x;
    let first = tile_offsets[tile_index];
    let end = tile_offsets[tile_index + 1u];
    for (var start = first; start < end; start += BATCH) {
        // The list of a tile ascends: from here on all plunges are later.
        if tile_cutters[start] >= grid.limit {
            break;
        }
        let count = min(BATCH, end - start);
        if TRACED {
            if lane < BATCH {
                atomicStore(&batch_depths[lane], 0u);
                atomicStore(&batch_counts[lane], 0u);
                atomicStore(&batch_removed[lane], 0u);
            }
            workgroupBarrier();
        }
        for (var i = 0u; i < count; i++) {
            let k = tile_cutters[start + i];
            if k >= grid.limit {
                break;
            }
            let cutter = cutters[k];
            let m = meeting_of(point, normal, cutter);
            let squared_radius = cutter.radius * cutter.radius;
            if !(discriminant(m, squared_radius) > 0.0) {
                continue;
            }
            let met = interval(m, squared_radius);
            var entry = select(FAR, met.entry, met.entry < met.exit);
            if cutter.corner_radius > 0.0 && entry < blank {
                entry = corner_entry(m, entry, cutter);
            }
            if TRACED && is_floor {
                let depth = contact_depth(m, cutter.core_radius * cutter.core_radius, height);
                if depth > 0.0 {
                    atomicMax(&batch_depths[i], bitcast<u32>(depth));
                }
                let swept = u32(entry < blank);
                let left = min(height, entry);
                let cut = u32(height - left > CUT_TOLERANCE);
                let removed = u32(round(height * units)) - u32(round(left * units));
                let contact = u32(depth > CONTACT_TOLERANCE);
                let counts = swept | (cut << CUT_SHIFT) | (contact << CONTACT_SHIFT);
                if counts != 0u {
                    atomicAdd(&batch_counts[i], counts);
                }
                if removed != 0u {
                    atomicAdd(&batch_removed[i], removed);
                }
            }
            height = min(height, entry);
        }
        if !TRACED {
            continue;
        }
        workgroupBarrier();
        if lane < count {
            let k = tile_cutters[start + lane];
            let depth = atomicLoad(&batch_depths[lane]);
            let counts = atomicLoad(&batch_counts[lane]);
            let removed = atomicLoad(&batch_removed[lane]);
            if depth > 0u {
                atomicMax(&traces[k].contact_depth, depth);
            }
            if counts > 0u {
                atomicAdd(&traces[k].contact_cells, counts >> CONTACT_SHIFT);
                atomicAdd(&traces[k].swept_cells, counts & COUNT_MASK);
                atomicAdd(&traces[k].cut_cells, (counts >> CUT_SHIFT) & COUNT_MASK);
            }
            if removed > 0u {
                atomicAdd(&traces[k].removed_units, removed);
            }
        }
        // The next batch clears the entries in the same lanes that read them here, so no barrier is needed.
    }
    if in_grid {
        heights[index] = height;
    }
}
