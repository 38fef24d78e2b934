// How much of the sun reaches a point. The tree on the platform throws one shadow, all models that do (planted trees) another; each has a map of its own.
// On the tree itself: taps of its shadow map. On all else: the same where what throws the shadow is near, and farther
// off a blur as wide as the sun is large and that is distant, read from the levels of a map of what is hidden (shade.wgsl), so that it needs no more taps
// and has no grain. It is exact behind the tree, where the ground is.

// Texels of the shadow map in one of the finest level of the shade map, and that one's levels.
const SHADE_TEXELS = 4.0;
const SHADE_LEVELS = 7u;
const SHADE_SIDE = 512u;
const SHADE_ROOM = vec2f(772.0, 516.0);
// Blurs of a smaller radius, in texels of the shadow map, are taps of it; of a larger one, levels.
const SHARP = 3.0;
const SOFT = 7.0;
// A disc of radius 1 is as wide as a cubic spline over texels of this size.
const SPLINE = 0.775;

// 3 x 3 taps so many texels apart.
fn taps(map: texture_depth_2d, uv: vec2f, depth: f32, apart: f32) -> f32 {
    let texel = 1.0 / f32(textureDimensions(map).x);
    var sum = 0.0;
    for (var y = -1; y <= 1; y += 1) {
        for (var x = -1; x <= 1; x += 1) {
            let at = uv + vec2f(f32(x), f32(y)) * (texel * apart);
            sum += textureSampleCompareLevel(map, shadow_sampler, at, depth);
        }
    }
    return sum / 9.0;
}

// Where a point is in a map: x and y in 0..1, z its depth. It is lifted off its own surface, so that it does not shade itself.
fn in_map(map_from_world: mat4x4f, position: vec3f, lift: vec3f) -> vec3f {
    let p = map_from_world * vec4f(position + lift, 1.0);
    return vec3f(p.xy * 0.5 + 0.5, p.z);
}

fn is_inside(at: vec3f) -> bool {
    return all(abs(at.xy - 0.5) <= vec2f(0.495));
}

fn level_of(radius: f32) -> f32 {
    return clamp(log2(max(radius, 1e-3) / SHADE_TEXELS), 0.0, f32(SHADE_LEVELS) - 1.0);
}

// What is hidden at a place of a level. All levels lie in one image, each with an edge of nothing: some drivers choose one level for four pixels at once.
// Twin: src/render/shade.rs.
fn shade_at(shades: texture_2d<f32>, uv: vec2f, level: u32) -> vec2f {
    let size = f32(SHADE_SIDE >> level);
    let below = f32(SHADE_SIDE) - 2.0 * size + 2.0 * f32(level) - 1.0;
    let corner = select(vec2f(f32(SHADE_SIDE) + 3.0, below), vec2f(1.0), level == 0u);
    let place = clamp(uv * size, vec2f(-0.5), vec2f(size + 0.5));
    return textureSampleLevel(shades, shade_sampler, (corner + place) / SHADE_ROOM, 0.0).xy;
}

// x: the radius in texels that a blur has at such a place, from how far away what hides the sun is on average, as far around as `radius` says; y: how much of
// that is hidden at all.
fn blur_at(shades: texture_2d<f32>, at: vec3f, radius: f32) -> vec2f {
    let level = level_of(radius);
    let lower = u32(level);
    let upper = min(lower + 1u, SHADE_LEVELS - 1u);
    let shade = mix(shade_at(shades, at.xy, lower), shade_at(shades, at.xy, upper), level - f32(lower));
    let texels = SHADE_TEXELS * f32(SHADE_SIDE);
    let away = max(at.z - shade.y / max(shade.x, 1e-6), 0.0) * texels;
    return vec2f(away * frame.light.sun.w, shade.x);
}

// A level smoothed by a cubic spline: four taps between texels (Sigg and Hadwiger 2005, "Fast Third-Order Texture Filtering", GPU Gems 2).
fn smooth_level(shades: texture_2d<f32>, uv: vec2f, level: u32) -> f32 {
    let size = f32(SHADE_SIDE >> level);
    let place = uv * size - 0.5;
    let cell = floor(place);
    let f = place - cell;
    let g = 1.0 - f;
    let w0 = g * g * g / 6.0;
    let w1 = 2.0 / 3.0 - 0.5 * f * f * (2.0 - f);
    let w2 = 2.0 / 3.0 - 0.5 * g * g * (2.0 - g);
    let w3 = f * f * f / 6.0;
    let before = w0 + w1;
    let after = w2 + w3;
    let a = (cell - 0.5 + w1 / before) / size;
    let b = (cell + 1.5 + w3 / after) / size;
    let top = before.x * shade_at(shades, a, level).x + after.x * shade_at(shades, vec2f(b.x, a.y), level).x;
    let bottom = before.x * shade_at(shades, vec2f(a.x, b.y), level).x + after.x * shade_at(shades, b, level).x;
    return before.y * top + after.y * bottom;
}

// How much is hidden around a place, so many texels about.
fn blurred(shades: texture_2d<f32>, uv: vec2f, radius: f32) -> f32 {
    let level = level_of(radius * SPLINE);
    let lower = u32(level);
    let part = level - f32(lower);
    let hidden = smooth_level(shades, uv, lower);
    if part < 0.01 {
        return hidden;
    }
    return mix(hidden, smooth_level(shades, uv, min(lower + 1u, SHADE_LEVELS - 1u)), part);
}

// What a map leaves of the sun at a place in it.
fn left_of_sun(map: texture_depth_2d, shades: texture_2d<f32>, at: vec3f) -> f32 {
    let texels = SHADE_TEXELS * f32(SHADE_SIDE);
    // From the nearest that could be in the way to what is.
    let farthest = blur_at(shades, at, max(at.z * texels * frame.light.sun.w, SOFT));
    if farthest.y <= 0.0 {
        return 1.0;
    }
    // Once more, no farther around than that; but a single leaf there does not say how wide the shadow of a crown is.
    let nearer = blur_at(shades, at, farthest.x);
    let radius = mix(farthest.x, nearer.x, min(nearer.y * 6.0, 1.0));
    let soft = smoothstep(SHARP, SOFT, radius);
    var sunny = 1.0;
    if soft < 1.0 && is_inside(at) {
        sunny = taps(map, at.xy, clamp(at.z - 0.0005, 0.0, 1.0), clamp(radius * 0.6, 1.3, 3.0));
    }
    if soft > 0.0 {
        sunny = mix(sunny, 1.0 - min(blurred(shades, at.xy, radius), 1.0), soft);
    }
    return sunny;
}

// What models that throw a shadow leave of it.
fn through_wood(position: vec3f, normal: vec3f) -> f32 {
    if frame.wood.x <= 0.0 {
        return 1.0;
    }
    let at = in_map(frame.wood_from_world, position, normal * (1.5 * frame.wood.x));
    return left_of_sun(wood_map, wood_shade_map, at);
}

fn through_tree(position: vec3f, normal: vec3f) -> f32 {
    if frame.tree.z < 0.5 {
        return 1.0;
    }
    let at = in_map(frame.shadow_from_world, position, normal * (1.5 * frame.tree.w));
    return left_of_sun(shadow_map, shade_map, at);
}

// On what does not belong to the tree.
fn sunlight(position: vec3f, normal: vec3f) -> f32 {
    return through_tree(position, normal) * through_wood(position, normal);
}

// On a part of the tree.
fn sunlight_within(position: vec3f, normal: vec3f) -> f32 {
    let of_wood = through_wood(position, normal);
    if frame.tree.z < 0.5 {
        return of_wood;
    }
    let at = in_map(frame.shadow_from_world, position, normal * (1.5 * frame.tree.w));
    if !is_inside(at) {
        return of_wood;
    }
    var apart = 1.3;
    if frame.light.toward_sun.w > apart {
        apart = clamp(blur_at(shade_map, at, 32.0).x * 0.6, apart, frame.light.toward_sun.w);
    }
    return of_wood * taps(shadow_map, at.xy, clamp(at.z - 0.0005, 0.0, 1.0), apart);
}
