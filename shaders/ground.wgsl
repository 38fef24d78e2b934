// The ground: a large disc with rings and lines that give scale, fading into the haze.
#include "shared/light.wgsl"
#include "shared/noise.wgsl"

const RADIUS = 80.0;
const SECTORS = 48u;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) @interpolate(flat) eye: vec3f,
}

@vertex
fn ground_vertex(@builtin(vertex_index) index: u32, @builtin(view_index) view: u32) -> Point {
    // Sectors of an inner disc of 4 m and three rings about it, so that no triangle is huge.
    let corner = index % 6u;
    let cell = index / 6u;
    let sector = cell % SECTORS;
    let band = cell / SECTORS;
    let radii = array<f32, 5>(0.0, 4.0, 12.0, 32.0, RADIUS);
    let outer = corner == 1u || corner == 2u || corner == 4u;
    let next = corner == 2u || corner == 4u || corner == 5u;
    let angle = f32(sector + select(0u, 1u, next)) * (6.2831853 / f32(SECTORS));
    let radius = radii[band + select(0u, 1u, outer)];
    let v = frame.views[view];
    var out: Point;
    out.world = vec3f(cos(angle) * radius, 0.0, -sin(angle) * radius);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.eye = v.eye.xyz;
    return out;
}

// 1 on a line of `width` about 0, smooth over a pixel, faint where the line is thinner than one.
fn line(distance: f32, width: f32, pixel: f32) -> f32 {
    let w = max(width, pixel);
    return (1.0 - smoothstep(w * 0.5, w * 0.5 + pixel, abs(distance))) * min(width / w, 1.0);
}

@fragment
fn ground_fragment(point: Point) -> @location(0) vec4f {
    let p = point.world.xz;
    let offset = point.world - point.eye;
    let reach = length(p);
    let pixel = max(length(fwidth(p)), 1e-5);

    // Short grass and earth, in large calm patches.
    let patches = noise(vec3f(p * 0.35, 0.0)) * 0.6 + noise(vec3f(p * 1.7, 3.0)) * 0.4;
    let blades = noise(vec3f(p * 23.0, 5.0)) * (1.0 - smoothstep(0.004, 0.03, pixel));
    var albedo = mix(vec3f(0.175, 0.205, 0.120), vec3f(0.275, 0.285, 0.175), patches);
    albedo *= 0.93 + 0.12 * blades;

    // A ring each metre, a stronger one each five; fine lines of a metre's grid near by.
    let metre = reach - round(reach);
    let five = reach - round(reach / 5.0) * 5.0;
    var mark = line(metre, 0.012, pixel) * 0.35 + line(five, 0.03, pixel) * 0.5;
    let grid = p - round(p);
    mark += (line(grid.x, 0.006, pixel) + line(grid.y, 0.006, pixel)) * 0.16;
    mark *= 1.0 - smoothstep(6.0, 22.0, reach);
    if reach < 0.5 {
        mark = 0.0;
    }
    albedo = mix(albedo, vec3f(0.62, 0.63, 0.54), clamp(mark, 0.0, 1.0) * 0.42);
    albedo = select(albedo, frame.light.floor.rgb, frame.light.floor.w > 0.5);

    // Less of the sky reaches the ground close to what stands on it.
    var open = 1.0;
    for (var i = 0; i < 8; i += 1) {
        let spot = frame.spots[i];
        let d = length(p - spot.xy) / max(spot.z, 1e-3);
        open *= 1.0 - spot.w * (1.0 - smoothstep(0.55, 1.9, d));
    }

    let normal = vec3f(0.0, 1.0, 0.0);
    let sunny = sunlight(point.world, normal) * (0.35 + 0.65 * open);
    let color = albedo * ((ambient(normal) + lamps(normal)) * open + frame.light.sun.rgb * (frame.sun.y * sunny * 0.95));

    let far = smoothstep(5.0, 62.0, length(offset));
    let haze = sky(vec3f(offset.x, 0.0, offset.z));
    return vec4f(mix(color, haze, sqrt(far) * far * 0.35 + far * 0.65), 1.0);
}
