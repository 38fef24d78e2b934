// egui's triangles, as egui means them: colours, textures and blending in gamma space, premultiplied alpha.
// The target is a UNORM view of the board's sRGB picture, so nothing converts on the way.

struct Screen {
    // Width and height in egui's points.
    size: vec2f,
}

var<immediate> screen: Screen;

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var image_sampler: sampler;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
    @location(1) color: vec4f,
}

@vertex
fn panel_vertex(@location(0) at: vec2f, @location(1) uv: vec2f, @location(2) color: vec4f) -> Point {
    var out: Point;
    // Both run down from the upper left corner.
    out.position = vec4f(at / screen.size * 2.0 - 1.0, 0.0, 1.0);
    out.uv = uv;
    out.color = color;
    return out;
}

@fragment
fn panel_fragment(point: Point) -> @location(0) vec4f {
    return textureSample(image, image_sampler, point.uv) * point.color;
}
