// Scanned models: faces, edges, vertices, what is seen through, what is cut away. One draw a chunk and look, of the triangles that select.wgsl listed of all
// models that have both; a vertex for each corner of each triangle, so that a pixel knows how far it is from its triangle's edges.
// Twin: src/render/model_upload.rs.
#include "shared/model.wgsl"

// In a triangle's alpha: it has a colour of its own, which it has on both sides.
const OWN = 2.0;
// How far before a place in a wood something must be to shade it, metres.
const ON_ITSELF = 0.4;

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

fn color_of(triangle: u32) -> vec4f {
    if (model.flags & COLOURED) == 0u {
        return model.color;
    }
    let packed = colours[triangle];
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
fn model_vertex(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) first: u32,
    @builtin(view_index) view: u32,
) -> Corner {
    let at = listed(index, first);
    let standing = standings[at.standing];
    let vertex = vertices[at.number];
    let v = frame.views[view];
    var out: Corner;
    out.world = placed(standing, vertex.place);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = turned(standing, unfolded(vertex.normal));
    out.near = vec3f(f32(at.corner == 0u), f32(at.corner == 1u), f32(at.corner == 2u));
    out.color = color_of(at.triangle);
    out.eye = v.eye.xyz;
    out.tint = tint_of(at.number);
    return out;
}

// As the sun sees it.
@vertex
fn model_shadow_vertex(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) first: u32,
) -> @builtin(position) vec4f {
    let at = listed(index, first);
    return frame.wood_from_world * vec4f(placed(standings[at.standing], vertices[at.number].place), 1.0);
}

// A surface's colour, seen from this side.
fn own_color(corner: Corner, front: bool) -> vec3f {
    if (model.flags & PAINTED) != 0u {
        return corner.tint.rgb + select(INSIDE, corner.color.rgb, front) * (1.0 - corner.tint.a);
    }
    return select(INSIDE, corner.color.rgb, front || corner.color.a >= OWN);
}

fn shade(corner: Corner, front: bool) -> vec3f {
    let f = facing(corner.world, corner.normal, corner.eye, front);
    let own = own_color(corner, front);
    var color: vec3f;
    if (model.flags & MATTE) != 0u {
        color = own * (ambient(f.normal) * 1.25 + 0.10);
    } else {
        // What throws a shadow is a tree. Leaves let light through to those right behind them, and other levels of detail are in the map than are seen.
        let on_itself = select(0.0, ON_ITSELF, (model.flags & THROWS) != 0u);
        color = lit(own, f.normal, f.to_eye, sunlight(corner.world + frame.sun.xyz * on_itself, f.normal));
        let half_way = normalize(f.to_eye + frame.sun.xyz);
        color += frame.light.sun.rgb * (pow(max(dot(f.normal, half_way), 0.0), 48.0) * select(0.0, 0.22, front));
    }
    color += lamp_light(own, f.normal, corner.world);
    return air(color, f.offset);
}

@fragment
fn face_fragment(corner: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let line = line_cover(corner.near);
    let color = shade(corner, front);
    if is_cut(corner.world) {
        discard;
    }
    return vec4f(edged(color, line), 1.0);
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
    let f = facing(corner.world, corner.normal, corner.eye, front);
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
fn point_vertex(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) number: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let vertex = vertices[index / 6u * model.stride];
    let v = frame.views[view];
    let corner = index % 6u;
    // Two triangles: 0 1 2, 2 1 3.
    let which = select(corner - select(0u, 2u, corner == 3u), select(1u, 3u, corner == 5u), corner > 3u);
    let at = vec2f(select(-1.0, 1.0, (which & 1u) != 0u), select(-1.0, 1.0, (which & 2u) != 0u));
    let world = placed(standings[number], vertex.place);
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
