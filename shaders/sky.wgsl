// The sky behind everything: one triangle at infinity.
#include "shared/light.wgsl"
#include "shared/noise.wgsl"

struct Point {
    @builtin(position) position: vec4f,
    @location(0) direction: vec3f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Point {
    let at = vec2f(f32((index & 1u) * 4u), f32((index >> 1u) * 4u)) - 1.0;
    let v = frame.views[view];
    var out: Point;
    // Depth 0 is infinitely far.
    out.position = vec4f(at, 0.0, 1.0);
    out.direction = (v.ray + at.x * v.ray_x + at.y * v.ray_y).xyz;
    return out;
}

@fragment
fn sky_fragment(point: Point) -> @location(0) vec4f {
    if frame.backdrop.w > 0.5 {
        return vec4f(frame.backdrop.rgb, 1.0);
    }
    // Half a step of 8 bits of noise, so that the gradient shows no bands.
    let grain = (hash(vec3i(vec2i(point.position.xy), 7)) - 0.5) * 0.004;
    return vec4f(sky(point.direction) + grain, 1.0);
}
