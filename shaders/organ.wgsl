// What a tree carries besides its tubes: polygons, spheres, leaves and flowers, as triangles with a look for each vertex.
// Twin of the vertices: src/render/organ_upload.rs.
#include "shared/light.wgsl"
#include "shared/octahedral.wgsl"
#include "shared/look.wgsl"
#include "shared/wind.wgsl"

struct Vertex {
    place: vec3f,
    // The look's number; the highest bit: a sheet with two sides.
    look: u32,
    // Where the vertex unfolds from while it grows; `place` itself where it is whole.
    base: vec3f,
    // Octahedral, two snorm16.
    normal: u32,
}

@group(1) @binding(0) var<storage, read> vertices: array<Vertex>;

const THIN = 0x80000000u;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat) look: u32,
    @location(3) @interpolate(flat) eye: vec3f,
}

fn world_of(vertex: Vertex) -> vec3f {
    let g = frame.tree.x;
    let place = select(vertex.base + g * (vertex.place - vertex.base), vertex.place, g >= 1.0);
    return swayed((frame.world_from_tree * vec4f(place, 1.0)).xyz);
}

@vertex
fn organ_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Point {
    let vertex = vertices[index];
    let v = frame.views[view];
    var out: Point;
    out.world = world_of(vertex);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = (frame.world_from_tree * vec4f(unfolded(vertex.normal), 0.0)).xyz;
    out.look = vertex.look;
    out.eye = v.eye.xyz;
    return out;
}

@vertex
fn organ_shadow_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return frame.shadow_from_world * vec4f(world_of(vertices[index]), 1.0);
}

@fragment
fn organ_fragment(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let look = looks[point.look & ~THIN];
    let thin = (point.look & THIN) != 0u;
    let offset = point.world - point.eye;
    let to_eye = -normalize(offset);
    var normal = normalize(point.normal);
    if thin && !front {
        normal = -normal;
    }
    // Lifted towards the sun, on whichever side it stands.
    let toward = dot(normal, frame.sun.xyz);
    let sunny = sunlight_within(point.world, select(normal, -normal, thin && toward < 0.0));
    var color = glossy(look, normal, to_eye, sunny);
    if thin {
        // What shines through a leaf is yellower than the leaf.
        let through = look.color.rgb * vec3f(1.10, 1.05, 0.55) * (1.0 - look.material.x);
        color += through * frame.light.sun.rgb * (max(-toward, 0.0) * sunny * 0.55);
    }
    return vec4f(air(color, offset), 1.0);
}
