// The tree: tapered tubes pulled from the segments' buffer, eight segments an instance, of as many sides as crown.wgsl has chosen for them.
// The formula is src/tree/mesh.rs's, its twin on the processor. Both rings of a joint are computed
// from the same numbers by the same instructions, so they meet bit for bit.
#include "shared/light.wgsl"
#include "shared/look.wgsl"
#include "shared/wind.wgsl"

struct Segment {
    start: vec3f,
    v_start: f32,
    end: vec3f,
    flags: u32,
    base: vec3f,
    v_end: f32,
    radii: vec4f,
    start_frame: vec2u,
    end_frame: vec2u,
}

@group(1) @binding(0) var<storage, read> segments: array<Segment>;
// sRGB colour, and the height in its fourth part.
@group(1) @binding(3) var bark: texture_2d_array<f32>;
@group(1) @binding(4) var bark_sampler: sampler;

// By instance: the number of a batch of eight segments, and its kind in the bits from 28 on.
@group(2) @binding(0) var<storage, read> list: array<u32>;

// Kinds of src/tree/levels/kinds.rs: tubes, a ribbon that faces the eye, then the ends of the first three.
const SIDES = array<u32, 8>(16u, 8u, 5u, 3u, 2u, 16u, 8u, 5u);
const RIBBON = 4u;
const CAPS = 5u;
// Rings of few corners are so much larger that they look as wide as those of eight, seen from anywhere (a ring's mean width: n/π·sin(π/n)·2).
const LARGER = array<f32, 8>(1.0, 1.0, 1.0415, 1.1782, 0.9745, 1.0, 1.0, 1.0415);
// Of a radius, how deep the middles of their sides lie.
const INSIDE = array<f32, 8>(0.0192, 0.0761, 0.1574, 0.4109, 1.0, 0.0192, 0.0761, 0.1574);
const CAPPED = 2u;
const GROWING = 1u;
// Bits 16 to 31 hold the number of a look.
const PAINTED = 8u;
// A tube's end is a cone of so many radii.
const CAP_HEIGHT = 0.75;
// A tube is drawn no thinner than this many pixels in radius; what is thinner grows faint instead of breaking up.
const FINEST = 0.6;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    // xy: unit circle about the axis; z: how far the flat side of a ring of few corners lies inside of it, metres.
    @location(2) around: vec3f,
    // x: circumferences along the tube; y: its twig's radius in the tree's own metres; z: alpha; w: 1 for the newest step.
    @location(3) bark: vec4f,
    @location(4) @interpolate(flat) eye: vec3f,
    // 0: bark.
    @location(5) @interpolate(flat) look: u32,
}

// A point of a ring, or the tip of the cone over it.
struct Spot {
    world: vec3f,
    outward: vec3f,
    normal: vec3f,
    around: vec2f,
    along: f32,
    radius: f32,
    center: vec3f,
    // Of the radius, how deep its side's middle lies.
    inside: f32,
    // Nothing is to be seen of it.
    is_none: bool,
}

// b itself where g reaches 1: no rounding moves a whole tree.
fn grow(a: f32, b: f32, g: f32) -> f32 {
    return select(a + g * (b - a), b, g >= 1.0);
}

fn grow_point(a: vec3f, b: vec3f, g: f32) -> vec3f {
    return select(a + g * (b - a), b, g >= 1.0);
}

fn turn(q: vec4f, p: vec3f) -> vec3f {
    let t = 2.0 * cross(q.xyz, p);
    return p + q.w * t + cross(q.xyz, t);
}

// Which corner of which segment a vertex is.
struct Corner {
    segment: u32,
    kind: u32,
    // Of the segment's second ring.
    second: bool,
    // On the ring; as many as there are sides: the tip of the cone over it.
    side: u32,
}

fn corner_of(vertex: u32, instance: u32) -> Corner {
    let entry = list[instance];
    var out: Corner;
    out.kind = entry >> 28u;
    let sides = SIDES[out.kind];
    let is_cap = out.kind >= CAPS;
    let each = select(2u * sides, sides + 1u, is_cap);
    out.segment = (entry & 0xfffffffu) * 8u + vertex / each;
    let at = vertex % each;
    out.second = is_cap || at >= sides;
    out.side = select(at % sides, at, is_cap);
    return out;
}

// `toward`: from a place to whoever sees it, by which ribbons turn; w is 1 where that is a place and 0 where it is a direction.
fn spot(segment: Segment, corner: Corner, toward: vec4f) -> Spot {
    let g = frame.tree.x;
    let growing = (segment.flags & GROWING) != 0u;
    let start = select(segment.start, grow_point(segment.base, segment.start, g), growing);
    let end = select(segment.end, grow_point(segment.base, segment.end, g), growing);
    let radius_start = grow(segment.radii.x, segment.radii.y, g);
    let radius_end = grow(segment.radii.z, segment.radii.w, g);
    let slope = clamp((radius_start - radius_end) / max(distance(start, end), 1e-9), -1.0, 1.0);

    let center = select(start, end, corner.second);
    // A batch has ends where any of its segments does; of the others nothing is seen.
    let is_none = corner.kind >= CAPS && (segment.flags & CAPPED) == 0u;
    let radius = select(select(radius_start, radius_end, corner.second) * LARGER[corner.kind], 0.0, is_none);
    let packed = select(segment.start_frame, segment.end_frame, corner.second);
    let q = normalize(vec4f(unpack2x16snorm(packed.x), unpack2x16snorm(packed.y)));
    let sides = SIDES[corner.kind];
    let angle = f32(corner.side % sides) * (6.2831853 / f32(sides));
    let tip = corner.side == sides;
    let around = vec2f(cos(angle), sin(angle));
    let axis = turn(q, vec3f(0.0, 1.0, 0.0));
    let out_of_axis = turn(q, vec3f(around.x, 0.0, around.y));
    let outward = select(out_of_axis, axis, tip);
    let local = center + outward * (radius * select(1.0, CAP_HEIGHT, tip));

    var out: Spot;
    out.is_none = is_none;
    out.inside = INSIDE[corner.kind];
    // A ring is moved as its middle is.
    let rests = (frame.world_from_tree * vec4f(center, 1.0)).xyz;
    out.center = swayed(rests);
    out.world = (frame.world_from_tree * vec4f(local, 1.0)).xyz + (out.center - rests);
    out.outward = normalize((frame.world_from_tree * vec4f(outward, 0.0)).xyz);
    out.normal = normalize((frame.world_from_tree * vec4f(select(out_of_axis + slope * axis, axis, tip), 0.0)).xyz);
    out.around = select(around, vec2f(0.0), tip);
    out.along = select(segment.v_start, segment.v_end, corner.second);
    out.radius = radius;
    if corner.kind == RIBBON {
        // Across the ring's axis, which both segments at a joint share, as whoever looks sees it. Shaded as round: normals lean outwards at the edges.
        let up = normalize((frame.world_from_tree * vec4f(axis, 0.0)).xyz);
        let front = normalize(toward.xyz - out.center * toward.w);
        let across = cross(up, front);
        let side = across * (select(-1.0, 1.0, corner.side == 0u) / max(length(across), 1e-6));
        out.outward = side;
        out.world = out.center + side * (radius * frame.tree.y);
        let facing = cross(side, up) * sign(dot(cross(side, up), front) + 1e-12);
        out.normal = normalize(facing * 0.6 + side * 0.8);
        let x = normalize((frame.world_from_tree * vec4f(turn(q, vec3f(1.0, 0.0, 0.0)), 0.0)).xyz);
        let z = normalize((frame.world_from_tree * vec4f(turn(q, vec3f(0.0, 0.0, 1.0)), 0.0)).xyz);
        out.around = vec2f(dot(out.normal, x), dot(out.normal, z));
    }
    return out;
}

fn seen(s: Spot, flags: u32, view: u32) -> Point {
    let newest = (flags & GROWING) != 0u;
    let v = frame.views[view];
    let radius = s.radius * frame.tree.y;
    let depth = (v.clip_from_world * vec4f(s.center, 1.0)).w;
    let finest = max(depth, 0.0) * v.eye.w * FINEST;
    // Widened from the axis outwards; a zero radius stays a line in the middle with alpha 0.
    let world = s.world + s.outward * select(max(finest - radius, 0.0), 0.0, s.is_none);
    var out: Point;
    out.position = v.clip_from_world * vec4f(world, 1.0);
    out.world = world;
    out.normal = s.normal;
    out.around = vec3f(s.around, s.inside * radius);
    // As thick as the twig that it stands for.
    let twig = s.radius * exp2(f32((flags >> 4u) & 0xffu) * -0.0625);
    out.bark = vec4f(s.along, twig, clamp(radius / max(finest, 1e-9), 0.0, 1.0), select(0.0, 1.0, newest));
    out.eye = v.eye.xyz;
    out.look = select(0u, flags >> 16u, (flags & PAINTED) != 0u);
    return out;
}

@vertex
fn tube_vertex(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let corner = corner_of(vertex, instance);
    let segment = segments[corner.segment];
    return seen(spot(segment, corner, vec4f(frame.views[view].eye.xyz, 1.0)), segment.flags, view);
}

// The same tubes as the sun sees them, at least a texel wide.
@vertex
fn shadow_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    let corner = corner_of(vertex, instance);
    let s = spot(segments[corner.segment], corner, vec4f(frame.sun.xyz, 0.0));
    let radius = s.radius * frame.tree.y;
    let finest = select(0.0, 0.5 * frame.tree.w, radius > 0.02 * frame.tree.w);
    return frame.shadow_from_world * vec4f(s.world + s.outward * max(finest - radius, 0.0), 1.0);
}

// The bark's picture at a place about the tube and along it, in circumferences, so that it looks the same on a trunk and on a twig: colour, and height from 0
// in furrows to 1 on ridges.
fn bark_at(around: vec2f, along: f32) -> vec4f {
    let turn = vec2f(atan2(around.y, around.x) * 0.15915494, along);
    // The angle jumps once round the trunk; its slope does not.
    let dx = vec2f((around.x * dpdx(around.y) - around.y * dpdx(around.x)) * 0.15915494, dpdx(along));
    let dy = vec2f((around.x * dpdy(around.y) - around.y * dpdy(around.x)) * 0.15915494, dpdy(along));
    return textureSampleGrad(bark, bark_sampler, turn, 0, dx, dy);
}

@fragment
fn tree_fragment(point: Point) -> @location(0) vec4f {
    let radius = max(point.bark.y, 1e-5);
    let around = point.around.xy / max(length(point.around.xy), 1e-3);
    let smooth_normal = normalize(point.normal);
    let picture = bark_at(around, point.bark.x);
    let height = picture.a;
    // Relief from the height's slope on the screen; none where the furrows are finer than pixels.
    let dx = dpdx(point.world);
    let dy = dpdy(point.world);
    let pixel = max(length(dx), length(dy));
    let size = radius * frame.tree.y;
    let fine = 1.0 - smoothstep(0.05, 0.6, pixel / max(size, 1e-6));
    // Number 0: young twigs' colour, how deep furrows are, their roughness.
    let young = looks[0];
    let relief = 0.22 * young.color.w * size * fine;
    let across = cross(dy, smooth_normal);
    let down = cross(smooth_normal, dx);
    let det = dot(dx, across);
    let slope = sign(det) * (dpdx(height) * across + dpdy(height) * down) * relief;
    var normal = abs(det) * smooth_normal - slope;
    normal = normalize(normal + smooth_normal * (abs(det) * 0.15 + 1e-20));

    let shoot = mix(vec3f(0.11, 0.17, 0.055), vec3f(0.17, 0.26, 0.085), height);
    var albedo = mix(young.color.rgb * (0.75 + 0.5 * height), picture.rgb, smoothstep(0.003, 0.018, radius));
    albedo = mix(albedo, shoot, point.bark.w * 0.8);

    let offset = point.world - point.eye;
    // Where the round tube is, which throws the shadow.
    let sunny = sunlight_within(point.world + smooth_normal * point.around.z, smooth_normal);
    if point.look != 0u {
        let painted = glossy(looks[point.look], smooth_normal, -normalize(offset), sunny);
        return vec4f(air(painted, offset), coverage(point.bark.z));
    }
    // Furrows lie in their own shade.
    let color = lit(albedo, normal, -normalize(offset), sunny) * (0.72 + 0.28 * height);
    return vec4f(air(color, offset), coverage(point.bark.z));
}
