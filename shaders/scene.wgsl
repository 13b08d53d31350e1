// Renders a part and its plan. World in mm; colours are gamma-encoded throughout, so that the floor shows
// exactly the colours of the legend.

struct Frame {
    clip_from_world: mat4x4f,
    eye: vec4f,       // w: 1 perspective, 0 parallel rays
    right: vec4f,
    up: vec4f,
    back: vec4f,      // towards the viewer
    viewport: vec4f,  // width, height, pixels per line width, unit of `lifted` in mm
    range: vec4f,     // lowest and highest value of the colour table, floor colours on, floor in relief
    look: vec4f,      // walls of the active channel are cut away, floor values are heights, how far below the
                      // blank stock counts as uncut
    plane: vec4f,     // section plane: points beyond w along xyz are clipped; xyz = 0: none
    greys: array<vec4f, 9>,
    lines: array<vec4f, 8>,
    states: array<vec4f, 5>,
    table: array<vec4f, 256>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

const GREY_TOP = 0u;
const GREY_BOTTOM = 1u;
const GREY_UNCUT = 7u;
const GREY_SECTION = 8u;

// Kinds of surface; the grey of a kind is at index 2 + kind.
const SHROUD = 4u;
// Flags of an instance.
const INNER = 1u; // faces the active channel
const ON_HUB = 2u; // lies on the hub

// Surfaces that lie on others are shifted slightly towards the viewer against z-fighting. Shift per draw
// layer, in units of viewport.w (a few tenths of a mm):
const LIFT_CHANNEL = 0.4;
const LIFT_FLOOR = 0.8;
const LIFT_CUTTER = 1.2;
const LIFT_LINE = 1.6;

fn lifted(world: vec3f, layers: f32) -> vec4f {
    return frame.clip_from_world * vec4f(world + to_viewer(world) * frame.viewport.w * layers, 1.0);
}

// Shift along the normal, for lines of sight that graze the surface.
fn off(world: vec3f, normal: vec3f) -> vec3f {
    return world + normal * frame.viewport.w * 0.4;
}

fn to_viewer(world: vec3f) -> vec3f {
    return select(frame.back.xyz, normalize(frame.eye.xyz - world), frame.eye.w > 0.5);
}

// Diffuse shading: a soft key light over the viewer's left shoulder, hemisphere light, ambient occlusion in
// corners (`open`), and darker silhouettes, which show the outline of twisted blades.
fn light(n: vec3f, v: vec3f, open: f32) -> f32 {
    let key = normalize(frame.back.xyz * 0.75 + frame.up.xyz * 0.6 - frame.right.xyz * 0.55);
    let half_turned = dot(n, key) * 0.5 + 0.5;
    let sky = 0.5 + 0.5 * dot(n, frame.up.xyz);
    let outline = mix(0.70, 1.0, smoothstep(0.0, 0.35, abs(dot(n, v))));
    let corner = mix(0.62, 1.0, smoothstep(0.0, 1.0, open));
    return (0.40 + 0.16 * sky + 0.52 * half_turned * half_turned) * outline * corner;
}

// Whether a point lies beyond the section plane.
fn cut_off(world: vec3f) -> bool {
    return dot(frame.plane.xyz, world) > frame.plane.w;
}

fn facing(n: vec3f, v: vec3f) -> vec3f {
    return normalize(select(-n, n, dot(n, v) >= 0.0));
}

// ---- background ---------------------------------------------------------------------------------

struct BackgroundOut {
    @builtin(position) clip: vec4f,
    @location(0) height: f32,
}

@vertex
fn background_vertex(@builtin(vertex_index) i: u32) -> BackgroundOut {
    let p = vec2f(f32((i << 1u) & 2u), f32(i & 2u));
    return BackgroundOut(vec4f(p * 2.0 - 1.0, 1.0, 1.0), p.y);
}

@fragment
fn background_fragment(in: BackgroundOut) -> @location(0) vec4f {
    return vec4f(mix(frame.greys[GREY_BOTTOM].rgb, frame.greys[GREY_TOP].rgb, in.height), 1.0);
}

// ---- hub, floor, blades, shroud -----------------------------------------------------------------

struct SurfaceIn {
    @location(0) position: vec3f,
    @location(1) value: f32,
    @location(2) normal: vec3f,
    @location(3) uncut: f32,
    @location(4) turn: vec2f, // cos, sin
    @location(5) kind: u32,
    @location(6) flags: u32,
}

struct SurfaceOut {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
    @location(3) uncut: f32,
    @location(4) raised: vec3f,
    @location(5) @interpolate(flat) kind: u32,
    @location(6) @interpolate(flat) flags: u32,
}

fn turned(p: vec3f, t: vec2f) -> vec3f {
    return vec3f(p.x * t.x - p.y * t.y, p.x * t.y + p.y * t.x, p.z);
}

@vertex
fn surface_vertex(in: SurfaceIn) -> SurfaceOut {
    var out: SurfaceOut;
    out.world = turned(in.position, in.turn);
    out.normal = turned(in.normal, in.turn);
    out.value = in.value;
    out.uncut = in.uncut;
    out.raised = out.world;
    out.kind = in.kind;
    out.flags = in.flags;
    out.clip = frame.clip_from_world * vec4f(out.world, 1.0);
    if (in.flags & ON_HUB) != 0u {
        out.clip = lifted(off(out.world, out.normal), LIFT_CHANNEL);
    }
    return out;
}

// Clipped points, and walls in front of the active channel, which glass_fragment draws instead.
fn hidden(in: SurfaceOut, v: vec3f) -> bool {
    return cut_off(in.world)
        || (frame.look.x > 0.5 && (in.flags & INNER) != 0u && dot(in.normal, v) < 0.0);
}

@fragment
fn surface_fragment(in: SurfaceOut) -> @location(0) vec4f {
    let v = to_viewer(in.world);
    if hidden(in, v) {
        discard;
    }
    let grey = frame.greys[2u + in.kind].rgb;
    return vec4f(grey * light(facing(in.normal, v), v, in.value), 1.0);
}

// Transparent walls in front of the active channel, and the shroud: more opaque at grazing incidence.
@fragment
fn glass_fragment(in: SurfaceOut) -> @location(0) vec4f {
    let v = to_viewer(in.world);
    let n = normalize(in.normal);
    let along = 1.0 - abs(dot(n, v));
    var alpha = 0.22 + 0.55 * along * along * along;
    if in.kind == SHROUD {
        alpha = 0.10 + 0.40 * along * along;
    } else if dot(n, v) < 0.0 {
        discard;
    }
    if cut_off(in.world) {
        discard;
    }
    let grey = frame.greys[2u + in.kind].rgb;
    return vec4f(grey * light(facing(n, v), v, in.value), alpha);
}

// ---- where the section plane cuts material ---------------------------------------------------------
//
// Parity rule: hub and blades are closed, so a line of sight that meets an odd number of their faces on the
// unclipped side crosses the plane inside them. Each face inverts a stencil bit; the plane is then drawn
// where a bit is set.

@fragment
fn parity_fragment(in: SurfaceOut) {
    if cut_off(in.world) {
        discard;
    }
}

struct CapOut {
    @builtin(position) clip: vec4f,
}

@vertex
fn cap_vertex(@builtin(vertex_index) i: u32) -> CapOut {
    let n = frame.plane.xyz;
    let xy = across(n);
    // A quad of the plane, three wheel radii to each side, as a strip of two triangles.
    let reach = 3.0 * frame.viewport.w / 8e-4;
    let p = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let world = n * frame.plane.w + (xy[0] * p.x + xy[1] * p.y) * reach;
    return CapOut(frame.clip_from_world * vec4f(world, 1.0));
}

// Flat colour with diagonal hatching, as in technical drawings.
@fragment
fn cap_fragment(in: CapOut) -> @location(0) vec4f {
    let stripe = fract((in.clip.x + in.clip.y) / (9.0 * frame.viewport.z));
    let hatch = select(1.0, 0.84, stripe < 0.2);
    return vec4f(frame.greys[GREY_SECTION].rgb * hatch, 1.0);
}

// The floor with its heights; it is not instanced, so the turn is unused.
@vertex
fn floor_vertex(in: SurfaceIn) -> SurfaceOut {
    return floor_corner(in);
}

fn floor_corner(in: SurfaceIn) -> SurfaceOut {
    var out: SurfaceOut;
    out.raised = in.position + in.normal * in.value * frame.look.y;
    out.world = select(in.position, out.raised, frame.range.w > 0.5);
    out.normal = in.normal;
    out.value = in.value;
    out.uncut = in.uncut;
    out.kind = in.kind;
    out.flags = in.flags;
    out.clip = lifted(off(out.world, in.normal * 2.0), LIFT_FLOOR);
    return out;
}

// The floor with heights that the compute kernel left in a buffer of their own. The value of a corner is the
// height of the blank.
@vertex
fn stock_vertex(in: SurfaceIn, @location(7) height: f32) -> SurfaceOut {
    var corner = in;
    corner.value = height;
    corner.uncut = select(0.0, 1.0, height >= in.value - frame.look.z);
    return floor_corner(corner);
}

// The same with the difference of two such buffers.
@vertex
fn difference_vertex(in: SurfaceIn, @location(7) height: f32, @location(8) less: f32) -> SurfaceOut {
    var corner = in;
    corner.value = height - less;
    return floor_corner(corner);
}

@fragment
fn floor_fragment(in: SurfaceOut) -> @location(0) vec4f {
    let v = to_viewer(in.world);
    // Shading from the slopes of the stock, also where it is drawn flat, so that steps between plunges are
    // visible.
    var n = cross(dpdx(in.raised), dpdy(in.raised));
    n = select(in.normal, normalize(n), dot(n, n) > 1e-12);
    n = select(-n, n, dot(n, in.normal) >= 0.0);
    let flat_light = light(facing(in.normal, v), v, 1.0);
    let relief = light(n, v, 1.0) / max(flat_light, 0.2);
    let t = (in.value - frame.range.x) / max(frame.range.y - frame.range.x, 1e-6);
    let entry = u32(clamp(t, 0.0, 1.0) * 255.0 + 0.5);
    let stock = frame.table[entry].rgb * clamp(relief, 0.80, 1.12) * mix(0.90, 1.0, flat_light);
    let uncut = frame.greys[GREY_UNCUT].rgb * flat_light;
    if cut_off(in.world) {
        discard;
    }
    return vec4f(select(stock, uncut, in.uncut > 0.5), 1.0);
}

// ---- the stock as a solid ---------------------------------------------------------------------------

// Kinds of paint, in the upper byte; a colour is in the lower three.
const PAINT_BY_VALUE = 0u;
const PAINT_UNCUT = 1u;
// A colour of something that the section plane does not cut.
const PAINT_WHOLE = 3u;

struct SolidOut {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
    @location(3) @interpolate(flat) paint: u32,
}

@vertex
fn solid_vertex(
    @location(0) position: vec3f,
    @location(1) value: f32,
    @location(2) normal: vec3f,
    @location(3) paint: u32,
) -> SolidOut {
    return SolidOut(frame.clip_from_world * vec4f(position, 1.0), position, normal, value, paint);
}

@fragment
fn solid_fragment(in: SolidOut) -> @location(0) vec4f {
    let v = to_viewer(in.world);
    // Corners on sharp edges have no normal; a triangle of such corners is flat.
    let facet = cross(dpdx(in.world), dpdy(in.world));
    var n = in.normal;
    if dot(n, n) < 0.04 {
        n = facet;
    }
    if in.paint >> 24u != PAINT_WHOLE && cut_off(in.world) {
        discard;
    }
    let bright = light(facing(n, v), v, 1.0);
    let t = (in.value - frame.range.x) / max(frame.range.y - frame.range.x, 1e-6);
    var colour = frame.table[u32(clamp(t, 0.0, 1.0) * 255.0 + 0.5)].rgb;
    switch in.paint >> 24u {
        case PAINT_BY_VALUE: {}
        case PAINT_UNCUT: { colour = frame.greys[2u].rgb; }
        default: { colour = unpack4x8unorm(in.paint).rgb; }
    }
    return vec4f(colour * (0.18 + 0.86 * bright), 1.0);
}

@fragment
fn solid_parity_fragment(in: SolidOut) {
    if cut_off(in.world) {
        discard;
    }
}

// Stock in the section plane, hatched across the hatching of the part in it.
@fragment
fn solid_cap_fragment(in: CapOut) -> @location(0) vec4f {
    let stripe = fract((in.clip.x - in.clip.y) / (9.0 * frame.viewport.z));
    let hatch = select(1.0, 0.84, stripe < 0.2);
    return vec4f(frame.greys[GREY_UNCUT].rgb * hatch, 1.0);
}

@fragment
fn solid_id_fragment(in: SolidOut) -> @location(0) u32 {
    if cut_off(in.world) {
        discard;
    }
    return 0u;
}

// ---- cutters ------------------------------------------------------------------------------------

struct CutterIn {
    @location(0) ring: vec2f,          // cos, sin
    @location(1) reach: vec2f,         // which radius, which height
    @location(2) part: u32,
    @location(3) tip: vec3f,
    @location(4) radius: f32,
    @location(5) axis: vec3f,
    @location(6) height: f32,
    @location(7) core_radius: f32,
    @location(8) corner_radius: f32,
    @location(9) state: u32,
    @location(10) id: u32,
}

struct CutterOut {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) rise: f32, // 0 at the bottom, 1 at the upper end
    @location(3) @interpolate(flat) part: u32,
    @location(4) @interpolate(flat) state: u32,
    @location(5) @interpolate(flat) id: u32,
}

const WALL = 0u;
const CORNER = 1u;
const ANNULUS = 2u;
const CORE_WALL = 3u;
const CORE_DISC = 4u;

// Two unit vectors that form a right-handed frame with the axis (Duff et al. 2017: branchless, no
// singularity).
fn across(a: vec3f) -> mat2x3f {
    let s = select(-1.0, 1.0, a.z >= 0.0);
    let c = -1.0 / (s + a.z);
    let d = a.x * a.y * c;
    return mat2x3f(vec3f(1.0 + s * a.x * a.x * c, s * d, -s * a.x), vec3f(d, s + a.y * a.y * c, -a.y));
}

@vertex
fn cutter_vertex(in: CutterIn) -> CutterOut {
    let xy = across(in.axis);
    let outward = xy[0] * in.ring.x + xy[1] * in.ring.y;
    let c = in.corner_radius;
    // Radii: 0 axis, 1 core, 2 inner end of the corner, 3 its middle, 4 full.
    let radii = array<f32, 5>(0.0, in.core_radius, in.radius - c, in.radius - 0.293 * c, in.radius);
    // Heights: 0 bottom, 1 middle of the corner, 2 end of the corner, 3 upper end.
    let heights = array<f32, 4>(0.0, 0.293 * c, min(c, in.height), in.height);
    let r = radii[u32(in.reach.x)];
    let h = heights[u32(in.reach.y)];
    var out: CutterOut;
    out.world = in.tip + outward * r + in.axis * h;
    switch in.part {
        case WALL, CORE_WALL: { out.normal = outward; }
        case CORNER: { out.normal = outward * (r - in.radius + c + 1e-3) - in.axis * (c - h); }
        default: { out.normal = in.axis * select(-1.0, 1.0, in.reach.y > 2.5); }
    }
    out.rise = h / max(in.height, 1e-6);
    out.part = in.part;
    out.state = in.state;
    out.id = in.id;
    out.clip = lifted(out.world, LIFT_CUTTER);
    return out;
}

// Colour of a cutter: its own (bit 3; R, G and B above the low byte), else that of its state.
fn cutter_colour(state: u32) -> vec3f {
    if (state & 8u) != 0u {
        return unpack4x8unorm(state >> 8u).rgb;
    }
    return frame.states[state & 7u].rgb;
}

@fragment
fn cutter_fragment(in: CutterOut) -> @location(0) vec4f {
    if cut_off(in.world) {
        discard;
    }
    let v = to_viewer(in.world);
    let shade = min(0.25 + 0.80 * light(facing(in.normal, v), v, 1.0), 1.0);
    return vec4f(cutter_colour(in.state) * shade, 1.0);
}

@fragment
fn cutter_glass_fragment(in: CutterOut) -> @location(0) vec4f {
    if cut_off(in.world) {
        discard;
    }
    let v = to_viewer(in.world);
    let n = normalize(in.normal);
    let along = 1.0 - abs(dot(n, v));
    var alpha = (0.07 + 0.50 * along * along * along) * mix(1.0, 0.35, in.rise);
    if in.part == ANNULUS {
        alpha = 0.38;
    }
    let shade = 0.45 + 0.60 * light(facing(n, v), v, 1.0);
    return vec4f(cutter_colour(in.state) * shade, alpha);
}

// ---- where the section plane cuts tools ------------------------------------------------------------

struct CapIn {
    @location(0) tip: vec3f,
    @location(1) low: f32,
    @location(2) axis: vec3f,
    @location(3) high: f32,
    @location(4) radii: vec2f, // at the lower and at the upper end
    @location(5) core_radius: f32,
    @location(6) corner_radius: f32,
    @location(7) state: u32,
}

struct CutterCapOut {
    @builtin(position) clip: vec4f,
    @location(0) from_tip: vec3f,
    @location(1) @interpolate(flat) axis: vec3f,
    @location(2) @interpolate(flat) ends: vec4f, // heights, then radii
    @location(3) @interpolate(flat) core_and_corner: vec2f,
    @location(4) @interpolate(flat) state: u32,
}

// A quad of the plane around what it can cut of a body.
@vertex
fn cutter_cap_vertex(in: CapIn, @builtin(vertex_index) i: u32) -> CutterCapOut {
    let n = frame.plane.xyz;
    let xy = across(n);
    let middle = in.tip + in.axis * 0.5 * (in.low + in.high);
    let centre = middle - n * (dot(n, middle) - frame.plane.w);
    let reach = length(vec2f(0.5 * (in.high - in.low), max(in.radii.x, in.radii.y)));
    let p = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let world = centre + (xy[0] * p.x + xy[1] * p.y) * reach;
    var out: CutterCapOut;
    out.clip = lifted(world, LIFT_CUTTER);
    out.from_tip = world - in.tip;
    out.axis = in.axis;
    out.ends = vec4f(in.low, in.high, in.radii);
    out.core_and_corner = vec2f(in.core_radius, in.corner_radius);
    out.state = in.state;
    return out;
}

// What lies within the body: the core darker, with the hatching of the solid stock.
@fragment
fn cutter_cap_fragment(in: CutterCapOut) -> @location(0) vec4f {
    let h = dot(in.from_tip, in.axis);
    let r = length(in.from_tip - in.axis * h);
    let up = h - in.ends.x;
    let share = up / max(in.ends.y - in.ends.x, 1e-6);
    var most = mix(in.ends.z, in.ends.w, share);
    let corner = in.core_and_corner.y;
    if up < corner {
        let below = corner - up;
        most = most - corner + sqrt(max(corner * corner - below * below, 0.0));
    }
    if share < 0.0 || share > 1.0 || r > most {
        discard;
    }
    let stripe = fract((in.clip.x - in.clip.y) / (6.0 * frame.viewport.z));
    let hatch = select(1.0, 0.86, stripe < 0.25);
    let core = select(1.0, 0.62, r < in.core_and_corner.x);
    return vec4f(cutter_colour(in.state) * hatch * core, 1.0);
}

// ---- ids for picking ------------------------------------------------------------------------------

// The part hides cutters behind it and has no id itself.
@fragment
fn surface_id_fragment(in: SurfaceOut) -> @location(0) u32 {
    if hidden(in, to_viewer(in.world)) {
        discard;
    }
    return 0u;
}

// Walls with values, and the section plane where it cuts material, hide cutters too.
@fragment
fn values_id_fragment(in: SurfaceOut) -> @location(0) u32 {
    if cut_off(in.world) {
        discard;
    }
    return 0u;
}

@fragment
fn cap_id_fragment(in: CapOut) -> @location(0) u32 {
    return 0u;
}

// Id of a position, counted from 1.
@fragment
fn cutter_id_fragment(in: CutterOut) -> @location(0) u32 {
    if cut_off(in.world) {
        discard;
    }
    return in.id + 1u;
}

// ---- lines --------------------------------------------------------------------------------------

struct LineIn {
    @location(0) a: vec3f,
    @location(1) width: f32,
    @location(2) b: vec3f,
    @location(3) colour: u32,
}

struct LineOut {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) colour: u32,
    @location(1) world: vec3f,
}

// Colours up to WALL_EDGE are edges of the part. They, and other lines flagged ON_PART, are clipped by the
// section plane.
const WALL_EDGE = 1u;
const ON_PART = 0x40000000u;
const OWN_COLOUR = 0x80000000u;

@vertex
fn line_vertex(in: LineIn, @builtin(vertex_index) i: u32) -> LineOut {
    let a = lifted(in.a, LIFT_LINE);
    let b = lifted(in.b, LIFT_LINE);
    if min(a.w, b.w) <= 1e-6 {
        return LineOut(vec4f(0.0, 0.0, 2.0, 1.0), 0u, in.a); // behind the viewer
    }
    let size = frame.viewport.xy;
    let way = (b.xy / b.w - a.xy / a.w) * size;
    let along = select(vec2f(1.0, 0.0), normalize(way), dot(way, way) > 1e-6);
    let at_end = i == 1u || i == 2u || i == 4u;
    let left = i == 2u || i == 4u || i == 5u;
    let p = select(a, b, at_end);
    // Square caps of half a line width close the joints of a polyline.
    let offset = vec2f(-along.y, along.x) * select(-1.0, 1.0, left) + along * select(-0.5, 0.5, at_end);
    let clip_xy = p.xy + offset * in.width * frame.viewport.z / size * p.w;
    return LineOut(vec4f(clip_xy, p.zw), in.colour, select(in.a, in.b, at_end));
}

@fragment
fn line_fragment(in: LineOut) -> @location(0) vec4f {
    if (in.colour <= WALL_EDGE || (in.colour & ON_PART) != 0u) && cut_off(in.world) {
        discard;
    }
    // A packed RGB colour, or an index into the table.
    if (in.colour & OWN_COLOUR) != 0u {
        return vec4f(unpack4x8unorm(in.colour).rgb, 1.0);
    }
    return vec4f(frame.lines[in.colour & ~ON_PART].rgb, 1.0);
}
