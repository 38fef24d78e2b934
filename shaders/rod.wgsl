// Rods with round ends and balls (a ball is a rod without length).
#include "shared/light.wgsl"

struct Rod {
    start: vec3f,
    radius: f32,
    end: vec3f,
    pad: f32,
    color: vec4f,
}

@group(0) @binding(3) var<storage, read> rods: array<Rod>;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat) color: vec4f,
    @location(3) @interpolate(flat) eye: vec3f,
}

// `place` is a point of the unit sphere; its upper half sits at the rod's end, the lower at its start.
@vertex
fn rod_vertex(
    @location(0) place: vec4f,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let rod = rods[instance];
    let along = rod.end - rod.start;
    let extent = length(along);
    let axis = select(vec3f(0.0, 1.0, 0.0), along / max(extent, 1e-9), extent > 1e-6);
    let helper = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(axis.x) > 0.7);
    let side = normalize(cross(helper, axis));
    let third = cross(side, axis);
    let normal = side * place.x + axis * place.y + third * place.z;
    let v = frame.views[view];
    var out: Point;
    out.world = select(rod.start, rod.end, place.w > 0.5) + normal * rod.radius;
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = normal;
    out.color = rod.color;
    out.eye = v.eye.xyz;
    return out;
}

fn shade(point: Point) -> vec3f {
    // What is wholly black is the dark edge of the view: there the sun must not shine back.
    if all(point.color.rgb == vec3f(0.0)) {
        return vec3f(0.0);
    }
    let normal = normalize(point.normal);
    let offset = point.world - point.eye;
    let to_eye = -normalize(offset);
    // Marks and lines must be read in any light: half of their colour is their own.
    let surface = lit(point.color.rgb, normal, to_eye, sunlight(point.world, normal));
    let gloss = pow(max(dot(normal, normalize(to_eye + frame.sun.xyz)), 0.0), 40.0) * 0.18;
    return air(point.color.rgb * 0.35 + surface * 0.70 + gloss, offset);
}

@fragment
fn rod_fragment(point: Point) -> @location(0) vec4f {
    return vec4f(shade(point), 1.0);
}

// Ghosts cover some samples only: nothing needs sorting, and overlaps do not add up.
@fragment
fn ghost_fragment(point: Point) -> @location(0) vec4f {
    // Never nothing.
    return vec4f(shade(point), max(coverage(point.color.a), 0.25));
}
