// Leaves, blossoms and fruit: one surface many times, eight an instance, as they are or as kites where crown.wgsl has chosen that. Twin of the buffers:
// src/render/leaf_upload.rs.
#include "shared/light.wgsl"
#include "shared/octahedral.wgsl"
#include "shared/look.wgsl"
#include "shared/wind.wgsl"

struct Leaf {
    place: vec3f,
    scale: f32,
    // Where it unfolds from while it grows.
    base: vec3f,
    look: u32,
    // A quaternion, four snorm16.
    orientation: vec2u,
    // Of the sky's light.
    light: f32,
    // Bit 0: it grows. Bits 8 to 15: how much larger it is than a leaf, where it stands for others: sixteenths of powers of two.
    flags: u32,
}

struct Corner {
    place: vec3f,
    // Octahedral, two snorm16.
    normal: u32,
    // 0: the leaf's look, else a look's number and 1.
    look: u32,
    thin: u32,
}

@group(1) @binding(0) var<storage, read> leaves: array<Leaf>;
// The first one is the crown's middle; its normal: how round normals are; its look: how many corners follow. Then come a kite's four.
@group(1) @binding(1) var<storage, read> corners: array<Corner>;
// By instance: the number of a batch of eight leaves, and its kind in the bits from 28 on; 1: a kite.
@group(2) @binding(0) var<storage, read> list: array<u32>;

const THIN = 0x80000000u;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    // Of the sheet itself.
    @location(1) normal: vec3f,
    // Out of the crown; its length: how much of it.
    @location(2) outward: vec3f,
    @location(3) @interpolate(flat) look: u32,
    @location(4) @interpolate(flat) eye: vec3f,
    @location(5) @interpolate(flat) light: f32,
    // Where a leaf of its own size would be lit.
    @location(6) shaded: vec3f,
}

struct Spot {
    leaf: Leaf,
    corner: Corner,
    q: vec4f,
    world: vec3f,
    shaded: vec3f,
}

fn turn(q: vec4f, p: vec3f) -> vec3f {
    let t = 2.0 * cross(q.xyz, p);
    return p + q.w * t + cross(q.xyz, t);
}

// Where a place is while its leaf grows.
fn unfolded_at(leaf: Leaf, place: vec3f) -> vec3f {
    let grows = (leaf.flags & 1u) != 0u && frame.tree.x < 1.0;
    return select(place, leaf.base + frame.tree.x * (place - leaf.base), grows);
}

// One turn after another.
fn together(a: vec4f, b: vec4f) -> vec4f {
    return vec4f(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn in_world(place: vec3f) -> vec3f {
    return (frame.world_from_tree * vec4f(place, 1.0)).xyz;
}

fn spot(vertex: u32, instance: u32) -> Spot {
    let entry = list[instance];
    let kite = (entry >> 28u) != 0u;
    let whole = corners[0].look;
    let count = select(whole, 4u, kite);
    var out: Spot;
    out.leaf = leaves[(entry & 0xfffffffu) * 8u + vertex / count];
    out.corner = corners[1u + select(0u, whole, kite) + vertex % count];
    let packed = vec4f(unpack2x16snorm(out.leaf.orientation.x), unpack2x16snorm(out.leaf.orientation.y));
    out.q = packed * inverseSqrt(max(dot(packed, packed), 1e-12));
    let smaller = exp2(f32((out.leaf.flags >> 8u) & 0xffu) * -0.0625);
    var moved = vec3f(0.0);
    if frame.wind.x > 0.0 {
        let hangs = in_world(unfolded_at(out.leaf, out.leaf.place));
        moved = swayed(hangs) - hangs;
        // Sheets flutter; fruit and spines are stiff.
        if corners[0].thin != 0u {
            out.q = together(out.q, fluttered(hangs, abs(out.leaf.scale) * smaller * frame.tree.y, out.leaf.place));
        }
    }
    let reach = turn(out.q, out.corner.place) * out.leaf.scale;
    out.world = in_world(unfolded_at(out.leaf, out.leaf.place + reach)) + moved;
    out.shaded = in_world(unfolded_at(out.leaf, out.leaf.place + reach * smaller)) + moved;
    return out;
}

@vertex
fn leaf_vertex(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let s = spot(vertex, instance);
    let v = frame.views[view];
    let header = corners[0];
    // Three axes turned over turn a closed surface inside out; a sheet shows the same side.
    let inside_out = select(1.0, -1.0, s.leaf.scale < 0.0 && header.thin == 0u);
    let outward = s.leaf.place - header.place;
    var out: Point;
    out.world = s.world;
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = (frame.world_from_tree * vec4f(turn(s.q, unfolded(s.corner.normal)) * inside_out, 0.0)).xyz;
    out.outward = normalize((frame.world_from_tree * vec4f(outward, 0.0)).xyz + vec3f(0.0, 1e-6, 0.0))
        * bitcast<f32>(header.normal);
    out.look = select(s.leaf.look, s.corner.look - 1u, s.corner.look != 0u) | select(0u, THIN, header.thin != 0u);
    out.eye = v.eye.xyz;
    out.light = s.leaf.light;
    out.shaded = s.shaded;
    return out;
}

@vertex
fn leaf_shadow_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    return frame.shadow_from_world * vec4f(spot(vertex, instance).world, 1.0);
}

@fragment
fn leaf_fragment(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let look = looks[point.look & ~THIN];
    let thin = (point.look & THIN) != 0u;
    let offset = point.world - point.eye;
    let to_eye = -normalize(offset);
    let sheet = normalize(point.normal);
    let facing = select(sheet, -sheet, thin && !front);
    // Rounded: the crown shades as one body and not as a heap of sheets that flicker.
    let round = length(point.outward);
    let aligned = select(sheet, -sheet, dot(sheet, point.outward) < 0.0);
    let normal = normalize(select(facing, mix(aligned, point.outward / max(round, 1e-6), round), round > 0.0));
    let toward = dot(facing, frame.sun.xyz);
    let sunny = sunlight_within(point.shaded, select(facing, -facing, thin && toward < 0.0));
    // What lies deep in the crown sees little of the sky.
    let open = mix(0.42, 1.0, point.light);
    var color = glossy(look, normal, to_eye, sunny) * open;
    if thin {
        // What shines through a leaf is yellower than the leaf; sky and sun shine through, and light that other leaves let through.
        let through = look.color.rgb * vec3f(1.30, 1.15, 0.45);
        let from_behind = max(-toward, 0.0) * 0.75 + 0.25 * max(dot(-to_eye, frame.sun.xyz), 0.0);
        let among = frame.light.sun.rgb * (0.26 * open);
        color += through * (frame.light.sun.rgb * (from_behind * sunny) + ambient(-normal) * (0.30 * open) + among);
    }
    return vec4f(air(color, offset), 1.0);
}
