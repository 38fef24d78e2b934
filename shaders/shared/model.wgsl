// What every look of scanned models has: a draw's immediates, where its models stand, a chunk's buffers, what is cut away, edges, the light in a hand.
// Twin: src/render/model_upload.rs.
#include "shared/light.wgsl"
#include "shared/octahedral.wgsl"
#include "shared/standing.wgsl"

struct Vertex {
    place: vec3f,
    // Octahedral, two snorm16.
    normal: u32,
}

struct Model {
    // Linear.
    color: vec4f,
    // What lies in front of this plane of the world is cut away: normal and distance; no normal: nothing is.
    cut: vec4f,
    // A light in a hand: where, and how bright.
    lamp: vec4f,
    // MATTE and the following.
    flags: u32,
    // Vertices are drawn each so many.
    stride: u32,
}

const MATTE = 1u;
const WIRE = 2u;
const COLOURED = 4u;
const FLAT = 8u;
const PAINTED = 16u;
const THROWS = 32u;
// Width of a line and of a point in pixels.
const LINE = 1.3;
const POINT = 3.0;
const LINE_COLOR = vec3f(0.010, 0.012, 0.014);
// What is seen of a surface from behind: its inside, or where it is cut.
const INSIDE = vec3f(0.42, 0.17, 0.12);

var<immediate> model: Model;

@group(1) @binding(0) var<storage, read> vertices: array<Vertex>;
// Three vertices each.
@group(1) @binding(1) var<storage, read> triangles: array<u32>;
// Of triangles or of vertices: sRGB with alpha; 0: the model's colour. Where it has materials, what textured.wgsl says.
@group(1) @binding(2) var<storage, read> colours: array<u32>;
// Which triangles are drawn, chunk after chunk.
@group(2) @binding(0) var<storage, read> list: array<u32>;
// Where the models stand; a draw's instance is the first of its own.
@group(2) @binding(1) var<storage, read> standings: array<Standing>;

// A draw's vertex: a corner of a triangle that the list has.
struct Listed {
    triangle: u32,
    // Which of the triangle's corners.
    corner: u32,
    // The vertex there.
    number: u32,
    // Where its model stands.
    standing: u32,
}

fn listed(index: u32, first: u32) -> Listed {
    let entry = list[index / 3u];
    let triangle = triangle_of(entry);
    let corner = index % 3u;
    return Listed(triangle, corner, triangles[triangle * 3u + corner], first + model_of(entry));
}

fn linear_from_srgb(packed: u32) -> vec3f {
    let c = unpack4x8unorm(packed).rgb;
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn is_cut(world: vec3f) -> bool {
    return dot(model.cut.xyz, world) > model.cut.w && any(model.cut.xyz != vec3f(0.0));
}

// How much of a pixel the triangle's edges cover. Where triangles are smaller than lines are wide, all of them would be line: there it stays the
// share that lines of a grid have, so that distant meshes do not turn black, and nothing shimmers.
fn line_cover(near: vec3f) -> f32 {
    let step = max(fwidth(near), vec3f(1e-9));
    let pixels = near / step;
    let line = 1.0 - smoothstep(LINE * 0.5 - 0.5, LINE * 0.5 + 0.5, min(pixels.x, min(pixels.y, pixels.z)));
    let dense = max(step.x, max(step.y, step.z));
    return mix(line, 0.30, smoothstep(0.30, 0.70, dense));
}

struct Facing {
    normal: vec3f,
    to_eye: vec3f,
    offset: vec3f,
}

fn facing(world: vec3f, vertices_normal: vec3f, eye: vec3f, front: bool) -> Facing {
    var out: Facing;
    out.offset = world - eye;
    out.to_eye = -normalize(out.offset);
    let across = cross(dpdx(world), dpdy(world));
    var normal = vertices_normal;
    if (model.flags & FLAT) != 0u || dot(normal, normal) < 1e-20 {
        normal = select(-across, across, dot(across, out.to_eye) > 0.0);
    } else if !front {
        normal = -normal;
    }
    out.normal = normalize(normal);
    return out;
}

// What the light in a hand adds to a surface of this colour.
fn lamp_light(own: vec3f, normal: vec3f, world: vec3f) -> vec3f {
    if model.lamp.w <= 0.0 {
        return vec3f(0.0);
    }
    let to_lamp = model.lamp.xyz - world;
    let far = max(dot(to_lamp, to_lamp), 1e-4);
    return own * (max(dot(normal, to_lamp * inverseSqrt(far)), 0.0) * model.lamp.w / (far + 0.05));
}

// With the triangle's edges over it, where they are drawn.
fn edged(color: vec3f, line: f32) -> vec3f {
    return mix(color, LINE_COLOR, select(0.0, line * 0.85, (model.flags & WIRE) != 0u));
}
