// Scanned models: faces, edges, vertices, what is seen through, what is cut away. One draw a chunk, of the triangles that select.wgsl listed; a vertex
// for each corner of each triangle, so that a pixel knows how far it is from its triangle's edges.
// Twin: src/render/model_upload.rs.
#include "shared/light.wgsl"
#include "shared/octahedral.wgsl"

struct Vertex {
    place: vec3f,
    // Octahedral, two snorm16.
    normal: u32,
}

struct Model {
    // Rows of the similarity to the world.
    rows: array<vec4f, 3>,
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
// Width of a line and of a point in pixels.
const LINE = 1.3;
const POINT = 3.0;
const LINE_COLOR = vec3f(0.010, 0.012, 0.014);
// What is seen of a surface from behind: its inside, or where it is cut.
const OWN = 2.0;
const INSIDE = vec3f(0.42, 0.17, 0.12);

var<immediate> model: Model;

@group(1) @binding(0) var<storage, read> vertices: array<Vertex>;
// Three vertices each.
@group(1) @binding(1) var<storage, read> triangles: array<u32>;
// Of triangles or of vertices: sRGB with alpha; 0: the model's colour.
@group(1) @binding(2) var<storage, read> colours: array<u32>;
// Which triangles are drawn, chunk after chunk.
@group(2) @binding(0) var<storage, read> list: array<u32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    // How near to each corner: 1 there, 0 on the edge across.
    @location(2) near: vec3f,
    @location(3) @interpolate(flat) color: vec4f,
    @location(4) @interpolate(flat) eye: vec3f,
    // The vertices' colour: how much of it there is, and so much of it.
    @location(5) tint: vec4f,
}

fn placed(place: vec3f) -> vec3f {
    let p = vec4f(place, 1.0);
    return vec3f(dot(model.rows[0], p), dot(model.rows[1], p), dot(model.rows[2], p));
}

fn turned(normal: vec3f) -> vec3f {
    return vec3f(
        dot(model.rows[0].xyz, normal),
        dot(model.rows[1].xyz, normal),
        dot(model.rows[2].xyz, normal),
    );
}

fn linear_from_srgb(packed: u32) -> vec3f {
    let c = unpack4x8unorm(packed).rgb;
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn color_of(triangle: u32) -> vec4f {
    if (model.flags & COLOURED) == 0u {
        return model.color;
    }
    let packed = colours[triangle];
    // What has a colour of its own has it on both sides, which OWN tells.
    return select(model.color, vec4f(linear_from_srgb(packed), OWN), (packed >> 24u) != 0u);
}

fn tint_of(vertex: u32) -> vec4f {
    if (model.flags & PAINTED) == 0u {
        return vec4f(0.0);
    }
    let packed = colours[vertex];
    let alpha = f32(packed >> 24u) / 255.0;
    return vec4f(linear_from_srgb(packed) * alpha, alpha);
}

@vertex
fn model_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Corner {
    let triangle = list[index / 3u];
    let corner = index % 3u;
    let number = triangles[triangle * 3u + corner];
    let vertex = vertices[number];
    let v = frame.views[view];
    var out: Corner;
    out.world = placed(vertex.place);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turned(unfolded(vertex.normal));
    out.near = vec3f(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u));
    out.color = color_of(triangle);
    out.eye = v.eye.xyz;
    out.tint = tint_of(number);
    return out;
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

fn facing(corner: Corner, front: bool) -> Facing {
    var out: Facing;
    out.offset = corner.world - corner.eye;
    out.to_eye = -normalize(out.offset);
    let across = cross(dpdx(corner.world), dpdy(corner.world));
    var normal = corner.normal;
    if (model.flags & FLAT) != 0u || dot(normal, normal) < 1e-20 {
        normal = select(-across, across, dot(across, out.to_eye) > 0.0);
    } else if !front {
        normal = -normal;
    }
    out.normal = normalize(normal);
    return out;
}

// A surface's colour, seen from this side.
fn own_color(corner: Corner, front: bool) -> vec3f {
    if (model.flags & PAINTED) != 0u {
        return corner.tint.rgb + select(INSIDE, corner.color.rgb, front) * (1.0 - corner.tint.a);
    }
    return select(INSIDE, corner.color.rgb, front || corner.color.a >= OWN);
}

fn shade(corner: Corner, front: bool) -> vec3f {
    let f = facing(corner, front);
    let own = own_color(corner, front);
    var color: vec3f;
    if (model.flags & MATTE) != 0u {
        color = own * (ambient(f.normal) * 1.25 + 0.10);
    } else {
        color = lit(own, f.normal, f.to_eye, sunlight(corner.world, f.normal));
        let half_way = normalize(f.to_eye + frame.sun.xyz);
        color += SUN_COLOR * (pow(max(dot(f.normal, half_way), 0.0), 48.0) * select(0.0, 0.22, front));
    }
    if model.lamp.w > 0.0 {
        let to_lamp = model.lamp.xyz - corner.world;
        let far = max(dot(to_lamp, to_lamp), 1e-4);
        color += own * (max(dot(f.normal, to_lamp * inverseSqrt(far)), 0.0) * model.lamp.w / (far + 0.05));
    }
    return air(color, f.offset);
}

@fragment
fn face_fragment(corner: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let line = line_cover(corner.near);
    let color = shade(corner, front);
    if is_cut(corner.world) {
        discard;
    }
    let edged = mix(color, LINE_COLOR, select(0.0, line * 0.85, (model.flags & WIRE) != 0u));
    return vec4f(edged, 1.0);
}

// Edges alone.
@fragment
fn wire_fragment(corner: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let cover = coverage(line_cover(corner.near));
    let color = shade(corner, front);
    if is_cut(corner.world) || cover <= 0.0 {
        discard;
    }
    return vec4f(color, cover);
}

// Seen through: the same colour wherever it is, so that it does not matter which face is drawn first. What is seen from the side is thicker.
@fragment
fn x_ray_fragment(corner: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let f = facing(corner, front);
    let line = line_cover(corner.near);
    if is_cut(corner.world) {
        discard;
    }
    let aslant = 1.0 - abs(dot(f.normal, f.to_eye));
    var alpha = 0.14 + 0.74 * aslant * aslant * aslant;
    alpha = max(alpha, select(0.0, line * 0.6, (model.flags & WIRE) != 0u));
    // Bluer and darker than the surface would be: it is to be seen before a bright sky and before paper.
    return vec4f(air(own_color(corner, true) * vec3f(0.30, 0.42, 0.62), f.offset), alpha);
}

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    // Across the point, -1..1.
    @location(1) at: vec2f,
    @location(2) @interpolate(flat) eye: vec3f,
}

// A square of so many pixels that faces the eye.
@vertex
fn point_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Point {
    let vertex = vertices[index / 6u * model.stride];
    let v = frame.views[view];
    let corner = index % 6u;
    // Two triangles: 0 1 2, 2 1 3.
    let which = select(corner - select(0u, 2u, corner == 3u), select(1u, 3u, corner == 5u), corner > 3u);
    let at = vec2f(select(-1.0, 1.0, (which & 1u) != 0u), select(-1.0, 1.0, (which & 2u) != 0u));
    let world = placed(vertex.place);
    let far = max(dot(world - v.eye.xyz, normalize(v.ray.xyz)), 0.0);
    let size = far * v.eye.w * POINT * 0.5;
    // A little nearer than the surface that it lies on.
    let lifted = mix(world, v.eye.xyz, 0.0015);
    var out: Point;
    out.world = world;
    out.at = at;
    out.eye = v.eye.xyz;
    out.position = v.clip_from_world
        * vec4f(lifted + (normalize(v.ray_x.xyz) * at.x + normalize(v.ray_y.xyz) * at.y) * size, 1.0);
    return out;
}

@fragment
fn point_fragment(point: Point) -> @location(0) vec4f {
    if is_cut(point.world) || dot(point.at, point.at) > 1.0 {
        discard;
    }
    return vec4f(air(vec3f(0.02, 0.16, 0.42), point.world - point.eye), 1.0);
}
