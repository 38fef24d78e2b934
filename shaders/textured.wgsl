// Scanned models as their files colour them: glTF's materials (section 3.9 of its specification), colours of vertices, images.
// Twins: src/render/model_upload/skin.rs, src/mesh/textured.rs.
#include "shared/model.wgsl"
#include "shared/gloss.wgsl"

struct Material {
    // Linear, with alpha.
    color: vec4f,
    // The image's across and down are dot(across.xyz, (u, v, 1)) and dot(down.xyz, (u, v, 1)).
    // across.w: the layer of the images; -1: none. down.w: what has less alpha is not there; -1: all is; 2: as much as alpha says is there.
    across: vec4f,
    down: vec4f,
    // rgb: what it shines by itself; w: roughness.
    emission: vec4f,
    // x: metallic. y: UNLIT and the following.
    more: vec4f,
}

const UNLIT = 1u;
const DOUBLE = 2u;
// How what is beyond an image's edges is found, across and, four times as much, down: repeated, mirrored each second time, or the edge.
const WRAPS = 4u;
const MIRRORED = 1u;
const CLAMPED = 2u;

@group(3) @binding(0) var images: texture_2d_array<f32>;
// Across and down: repeated or not.
@group(3) @binding(1) var repeated: sampler;
@group(3) @binding(2) var repeated_across: sampler;
@group(3) @binding(3) var repeated_down: sampler;
@group(3) @binding(4) var clamped: sampler;
@group(3) @binding(5) var<storage, read> materials: array<Material>;

struct Painted {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    // How near to each corner: 1 there, 0 on the edge across.
    @location(2) near: vec3f,
    @location(3) @interpolate(flat) material: u32,
    @location(4) @interpolate(flat) eye: vec3f,
    @location(5) color: vec4f,
    // Where in the image.
    @location(6) at: vec2f,
}

// Where the numbers of triangles' materials begin stands first in a chunk's colours, then for each vertex u, v and colour, then these numbers.
fn vertex_word(vertex: u32, which: u32) -> u32 {
    return colours[1u + vertex * 3u + which];
}

@vertex
fn textured_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Painted {
    let triangle = list[index / 3u];
    let corner = index % 3u;
    let number = triangles[triangle * 3u + corner];
    let vertex = vertices[number];
    let v = frame.views[view];
    let color = vertex_word(number, 2u);
    var out: Painted;
    out.world = placed(vertex.place);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turned(unfolded(vertex.normal));
    out.near = vec3f(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u));
    out.material = colours[colours[0] + triangle];
    out.eye = v.eye.xyz;
    out.color = vec4f(linear_from_srgb(color), f32(color >> 24u) / 255.0);
    out.at = vec2f(bitcast<f32>(vertex_word(number, 0u)), bitcast<f32>(vertex_word(number, 1u)));
    return out;
}

// There and back again: mirrored each second time.
fn folded(at: f32) -> f32 {
    return 1.0 - abs(at - 2.0 * floor(at * 0.5) - 1.0);
}

// An image's colour; steps: how much farther along it the next pixels are.
fn image_color(m: Material, at: vec2f, across_step: vec2f, down_step: vec2f) -> vec4f {
    if m.across.w < 0.0 {
        return vec4f(1.0);
    }
    let wrap = u32(m.more.y) / WRAPS;
    let wrap_across = wrap % WRAPS;
    let wrap_down = wrap / WRAPS;
    let place = vec2f(
        select(at.x, folded(at.x), wrap_across == MIRRORED),
        select(at.y, folded(at.y), wrap_down == MIRRORED),
    );
    let layer = i32(m.across.w);
    if wrap_across == 0u && wrap_down == 0u {
        return textureSampleGrad(images, repeated, place, layer, across_step, down_step);
    } else if wrap_across == 0u {
        return textureSampleGrad(images, repeated_across, place, layer, across_step, down_step);
    } else if wrap_down == 0u {
        return textureSampleGrad(images, repeated_down, place, layer, across_step, down_step);
    }
    return textureSampleGrad(images, clamped, place, layer, across_step, down_step);
}

fn material_shade(p: Painted, m: Material, own: vec3f, front: bool) -> vec3f {
    let f = facing(p.world, p.normal, p.eye, front);
    if (u32(m.more.y) & UNLIT) != 0u {
        return air(own, f.offset);
    }
    // What is metal and rough mirrors the stage in all directions, so it looks as stone does.
    let look = Look(vec4f(own, m.emission.w), vec4f(m.more.x * (1.0 - m.emission.w), 0.0, 0.0, 0.0));
    var color = glossy(look, f.normal, f.to_eye, sunlight(p.world, f.normal));
    color += lamp_light(own, f.normal, p.world) + m.emission.rgb;
    return air(color, f.offset);
}

@fragment
fn textured_fragment(p: Painted, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let m = materials[p.material];
    let line = line_cover(p.near);
    let place = vec3f(p.at, 1.0);
    let at = vec2f(dot(m.across.xyz, place), dot(m.down.xyz, place));
    let across_step = dpdx(at);
    let down_step = dpdy(at);
    let color = image_color(m, at, across_step, down_step) * m.color * p.color;
    // An edge as sharp as the pixels are.
    let masked = (color.a - m.down.w) / max(fwidth(color.a), 1e-3) + 0.5;
    let shown = front || (u32(m.more.y) & DOUBLE) != 0u;
    let lit_color = material_shade(p, m, select(INSIDE, color.rgb, shown), front);
    var cover = 1.0;
    if m.down.w > 1.0 {
        cover = coverage(color.a);
    } else if m.down.w >= 0.0 {
        cover = coverage(clamp(masked, 0.0, 1.0));
    }
    if is_cut(p.world) || cover <= 0.0 {
        discard;
    }
    return vec4f(edged(lit_color, line), cover);
}
