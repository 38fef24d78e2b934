// The board: a slab with rounded corners that shows the panel's picture.
#include "shared/light.wgsl"

struct Solid {
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    // x: 1 where the panel was painted.
    color: vec4f,
    // x, y: width and height in metres.
    kind: vec4f,
}

@group(0) @binding(4) var<storage, read> solids: array<Solid>;
@group(1) @binding(0) var panel: texture_2d<f32>;
@group(1) @binding(1) var panel_sampler: sampler;

const CORNER = 0.02;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) at: vec2f,
    @location(1) world: vec3f,
    @location(2) @interpolate(flat) instance: u32,
    @location(3) @interpolate(flat) eye: vec3f,
}

@vertex
fn board_vertex(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let s = solids[instance];
    let corners = array<vec2f, 6>(
        vec2f(-0.5, -0.5), vec2f(0.5, -0.5), vec2f(0.5, 0.5),
        vec2f(-0.5, -0.5), vec2f(0.5, 0.5), vec2f(-0.5, 0.5),
    );
    let at = corners[index] * s.kind.xy;
    let p = vec4f(at, 0.0, 1.0);
    let v = frame.views[view];
    var out: Point;
    out.world = vec3f(dot(s.row_x, p), dot(s.row_y, p), dot(s.row_z, p));
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.at = at;
    out.instance = instance;
    out.eye = v.eye.xyz;
    return out;
}

@fragment
fn board_fragment(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let s = solids[point.instance];
    let size = s.kind.xy;
    // Distance to the rounded edge, in pixels: the mask smooths it.
    let corner = abs(point.at) - (size * 0.5 - CORNER);
    let edge = length(max(corner, vec2f(0.0))) + min(max(corner.x, corner.y), 0.0) - CORNER;
    let pixel = max(fwidth(edge), 1e-6);
    let uv = vec2f(point.at.x / size.x + 0.5, 0.5 - point.at.y / size.y);
    let text = textureSample(panel, panel_sampler, uv);
    let slab = vec3f(0.018, 0.024, 0.030);
    let offset = point.world - point.eye;
    var color = slab;
    if front && s.color.x > 0.5 {
        // Premultiplied: the panel lies over the slab.
        color = text.rgb + slab * (1.0 - text.a);
    }
    let border = smoothstep(-0.004 - pixel, -0.004, edge);
    color = mix(color, vec3f(0.10, 0.13, 0.14), border * 0.8);
    return vec4f(air(color, offset), coverage(clamp(0.5 - edge / pixel, 0.0, 1.0)));
}
