// Scanned models as their files colour them: glTF's materials (section 3.9 of its specification), colours of vertices, images.
// Twins: src/render/model_upload/skin.rs, src/mesh/textured.rs.
#include "shared/model.wgsl"
#include "shared/gloss.wgsl"

struct Material {
    // Linear, with alpha.
    color: vec4f,
    // The images' across and down are dot(across.xyz, (u, v, 1)) and dot(down.xyz, (u, v, 1)).
    // across.w: what normals' red and green are multiplied by. down.w: what has less alpha is not there; -1: all is; 2: as much as alpha says is there.
    across: vec4f,
    down: vec4f,
    // rgb: what it shines by itself; w: roughness.
    emission: vec4f,
    // x: metallic. y: UNLIT and the following.
    more: vec4f,
    // Layers of the images for base colour, emission, metal and roughness, normals; -1: none.
    layers: vec4f,
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
fn textured_vertex(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) first: u32,
    @builtin(view_index) view: u32,
) -> Painted {
    let at = listed(index, first);
    let number = at.number;
    let standing = standings[at.standing];
    let vertex = vertices[number];
    let v = frame.views[view];
    let color = vertex_word(number, 2u);
    var out: Painted;
    out.world = placed(standing, vertex.place);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turned(standing, unfolded(vertex.normal));
    out.near = vec3f(f32(at.corner == 0u), f32(at.corner == 1u), f32(at.corner == 2u));
    out.material = colours[colours[0] + at.triangle];
    out.eye = v.eye.xyz;
    out.color = vec4f(linear_from_srgb(color), f32(color >> 24u) / 255.0);
    out.at = vec2f(bitcast<f32>(vertex_word(number, 0u)), bitcast<f32>(vertex_word(number, 1u)));
    return out;
}

// There and back again: mirrored each second time.
fn folded(at: f32) -> f32 {
    return 1.0 - abs(at - 2.0 * floor(at * 0.5) - 1.0);
}

// Where a pixel is in its images, and how much farther along them the next pixels are.
struct Spot {
    at: vec2f,
    across_step: vec2f,
    down_step: vec2f,
}

// What an image has there; white where there is none.
fn image_color(m: Material, layer: f32, spot: Spot) -> vec4f {
    if layer < 0.0 {
        return vec4f(1.0);
    }
    let wrap = u32(m.more.y) / WRAPS;
    let wrap_across = wrap % WRAPS;
    let wrap_down = wrap / WRAPS;
    let place = vec2f(
        select(spot.at.x, folded(spot.at.x), wrap_across == MIRRORED),
        select(spot.at.y, folded(spot.at.y), wrap_down == MIRRORED),
    );
    let number = i32(layer);
    if wrap_across == 0u && wrap_down == 0u {
        return textureSampleGrad(images, repeated, place, number, spot.across_step, spot.down_step);
    } else if wrap_across == 0u {
        return textureSampleGrad(images, repeated_across, place, number, spot.across_step, spot.down_step);
    } else if wrap_down == 0u {
        return textureSampleGrad(images, repeated_down, place, number, spot.across_step, spot.down_step);
    }
    return textureSampleGrad(images, clamped, place, number, spot.across_step, spot.down_step);
}

// Images of numbers lie among those of colours: the device takes them for sRGB, which is undone.
fn image_numbers(m: Material, layer: f32, spot: Spot) -> vec3f {
    let c = image_color(m, layer, spot).rgb;
    return select(1.055 * pow(max(c, vec3f(0.0)), vec3f(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3f(0.0031308));
}

// A normal that an image turns: the image's right and top on the surface are found from how place and image change from pixel to pixel
// (Schuler 2013, "Normal Mapping Without Precomputed Tangents", in GPU Pro 2).
fn mapped(normal: vec3f, m: Material, spot: Spot, world_across: vec3f, world_down: vec3f) -> vec3f {
    if m.layers.w < 0.0 {
        return normal;
    }
    let packed = image_numbers(m, m.layers.w, spot) * 2.0 - 1.0;
    let tilt = packed.xy * m.across.w;
    let across = cross(world_down, normal);
    let down = cross(normal, world_across);
    let right = across * spot.across_step.x + down * spot.down_step.x;
    // An image's second axis runs down, its normals' green up.
    let top = -(across * spot.across_step.y + down * spot.down_step.y);
    let size = max(dot(right, right), dot(top, top));
    if size < 1e-30 {
        return normal;
    }
    // Pixels may run the other way round than the surface turns.
    let turn = sign(dot(world_across, across)) * inverseSqrt(size);
    return normalize((right * tilt.x + top * tilt.y) * turn + normal * max(packed.z, 0.02));
}

@fragment
fn textured_fragment(p: Painted, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let m = materials[p.material];
    let line = line_cover(p.near);
    let place = vec3f(p.at, 1.0);
    let at = vec2f(dot(m.across.xyz, place), dot(m.down.xyz, place));
    let spot = Spot(at, dpdx(at), dpdy(at));
    let world_across = dpdx(p.world);
    let world_down = dpdy(p.world);
    let f = facing(p.world, p.normal, p.eye, front);
    let color = image_color(m, m.layers.x, spot) * m.color * p.color;
    // An edge as sharp as the pixels are.
    let masked = (color.a - m.down.w) / max(fwidth(color.a), 1e-3) + 0.5;
    let shown = front || (u32(m.more.y) & DOUBLE) != 0u;
    let own = select(INSIDE, color.rgb, shown);
    var lit_color = own;
    if (u32(m.more.y) & UNLIT) == 0u {
        let matter = image_numbers(m, m.layers.z, spot);
        let roughness = m.emission.w * matter.g;
        // What is metal and rough mirrors the stage in all directions, so it looks as stone does.
        let look = Look(vec4f(own, roughness), vec4f(m.more.x * matter.b * (1.0 - roughness), 0.0, 0.0, 0.0));
        let normal = mapped(f.normal, m, spot, world_across, world_down);
        lit_color = glossy(look, normal, f.to_eye, sunlight(p.world, f.normal));
        lit_color += lamp_light(own, normal, p.world) + m.emission.rgb * image_color(m, m.layers.y, spot).rgb;
    }
    lit_color = air(lit_color, f.offset);
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
