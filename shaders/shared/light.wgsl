// Sky, sun and air, shared by everything that is lit. Colours are linear.
#include "shared/frame.wgsl"

@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;

const SUN_COLOR = vec3f(1.00, 0.90, 0.74);
const ZENITH = vec3f(0.115, 0.245, 0.50);
const MIDDLE = vec3f(0.33, 0.52, 0.74);
const HORIZON = vec3f(0.74, 0.80, 0.83);
const GROUND_BOUNCE = vec3f(0.20, 0.19, 0.155);

// The sky in a direction; below the horizon it stays the haze that the ground fades into.
fn sky(direction: vec3f) -> vec3f {
    let d = normalize(direction);
    let height = max(d.y, 0.0);
    var color = mix(HORIZON, MIDDLE, smoothstep(0.0, 0.30, height));
    color = mix(color, ZENITH, smoothstep(0.12, 0.95, height));
    let toward = max(dot(d, frame.sun.xyz), 0.0);
    // Haze glows around the sun, the more the nearer to the horizon.
    color += vec3f(0.20, 0.155, 0.09) * pow(toward, 5.0) * (1.0 - 0.6 * height);
    color += vec3f(0.55, 0.44, 0.28) * pow(toward, 90.0);
    color += vec3f(1.0, 0.95, 0.85) * smoothstep(0.9990, 0.9997, toward);
    return color;
}

// Light from the whole sky on a surface with this normal.
fn ambient(normal: vec3f) -> vec3f {
    let up = normal.y * 0.5 + 0.5;
    return mix(GROUND_BOUNCE, vec3f(0.40, 0.47, 0.56), up);
}

// How much of the sun reaches a point: 3 x 3 taps of the tree's shadow map.
fn sunlight(position: vec3f, normal: vec3f) -> f32 {
    if frame.tree.z < 0.5 {
        return 1.0;
    }
    // Lifted off its own surface, so that it does not shade itself.
    let lifted = position + normal * (1.5 * frame.tree.w);
    let p = frame.shadow_from_world * vec4f(lifted, 1.0);
    if any(abs(p.xy) > vec2f(0.99)) {
        return 1.0;
    }
    let uv = p.xy * 0.5 + 0.5;
    let depth = clamp(p.z - 0.0005, 0.0, 1.0);
    let texel = 1.0 / f32(textureDimensions(shadow_map).x);
    var sum = 0.0;
    for (var y = -1; y <= 1; y += 1) {
        for (var x = -1; x <= 1; x += 1) {
            let at = uv + vec2f(f32(x), f32(y)) * (texel * 1.3);
            sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
        }
    }
    return sum / 9.0;
}

// A matte surface in this light, with a soft rim that parts it from what is behind.
fn lit(albedo: vec3f, normal: vec3f, to_eye: vec3f, sunny: f32) -> vec3f {
    let sun = max(dot(normal, frame.sun.xyz), 0.0);
    let rim = pow(1.0 - max(dot(normal, to_eye), 0.0), 4.0);
    let sky_light = ambient(normal);
    return albedo * (sky_light + SUN_COLOR * (sun * sunny * 0.95)) + sky_light * (rim * 0.10);
}

// Air between a point and the eye. Thin: the stage is small.
fn air(color: vec3f, offset: vec3f) -> vec3f {
    if frame.backdrop.w > 0.5 {
        return color;
    }
    let distance = length(offset);
    let haze = 1.0 - exp(-distance * 0.006);
    return mix(color, sky(vec3f(offset.x, max(offset.y, 0.0), offset.z)), haze);
}

// The alpha that makes alpha-to-coverage cover a share of the four samples: whole quarters. A pattern from pixel to pixel
// would give finer steps, but breaks thin twigs into dots.
// (A sample mask would say it plainly, but naga 30 writes that output in a form that is not valid SPIR-V for Vulkan.)
fn coverage(alpha: f32) -> f32 {
    return clamp(round(alpha * 4.0), 0.0, 4.0) / 4.0;
}
