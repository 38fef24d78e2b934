// Sky, sun and air, shared by everything that is lit. Colours are linear.
#include "shared/frame.wgsl"

@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;

// In levels: in x how much of a texel's area something on the tree hides from the sun, in y how deep that lies, times as much. From shade.wgsl.
@group(0) @binding(5) var shade_map: texture_2d<f32>;
@group(0) @binding(6) var shade_sampler: sampler;

// The same of models that throw a shadow.
@group(0) @binding(7) var wood_map: texture_depth_2d;
@group(0) @binding(8) var wood_shade_map: texture_2d<f32>;

// The sky in a direction; below the horizon it stays the haze that the ground fades into.
fn sky(direction: vec3f) -> vec3f {
    let d = normalize(direction);
    let height = max(d.y, 0.0);
    var color = mix(frame.light.horizon.rgb, frame.light.middle.rgb, smoothstep(0.0, 0.30, height));
    color = mix(color, frame.light.zenith.rgb, smoothstep(0.12, 0.95, height));
    let level = normalize(frame.sun.xz + vec2f(1e-6, 0.0));
    let side = dot(d.xz, level) / max(length(d.xz), 1e-4) * 0.5 + 0.5;
    color += frame.light.toward_sun.rgb * (side * side * (1.0 - smoothstep(0.0, 0.45, height)));
    let toward = max(dot(d, frame.sun.xyz), 0.0);
    // Haze glows around the sun, the more the nearer to the horizon.
    color += frame.light.glow.rgb * pow(toward, 5.0) * (1.0 - 0.6 * height);
    color += frame.light.halo.rgb * pow(toward, 90.0);
    color += frame.light.disc.rgb * smoothstep(0.9990, 0.9997, toward);
    return color;
}

// Light from the whole sky on a surface with this normal.
fn ambient(normal: vec3f) -> vec3f {
    let up = normal.y * 0.5 + 0.5;
    return mix(frame.light.below.rgb, frame.light.above.rgb, up);
}

// What lamps besides the sun add to a surface; the second one is large and reaches around.
fn lamps(normal: vec3f) -> vec3f {
    let fill = max(dot(normal, frame.light.fill.xyz) * 0.7 + 0.3, 0.0);
    let rim = max(dot(normal, frame.light.rim.xyz), 0.0);
    return frame.light.fill_color.rgb * fill + frame.light.rim_color.rgb * rim;
}

#include "shared/shadow.wgsl"

// A matte surface in this light, with a soft rim that parts it from what is behind.
fn lit(albedo: vec3f, normal: vec3f, to_eye: vec3f, sunny: f32) -> vec3f {
    let sun = max(dot(normal, frame.sun.xyz), 0.0);
    let rim = pow(1.0 - max(dot(normal, to_eye), 0.0), 4.0);
    let sky_light = ambient(normal);
    return albedo * (sky_light + lamps(normal) + frame.light.sun.rgb * (sun * sunny * 0.95)) + sky_light * (rim * 0.10);
}

// Air between a point and the eye. Thin: the stage is small.
fn air(color: vec3f, offset: vec3f) -> vec3f {
    if frame.backdrop.w > 0.5 {
        return color;
    }
    let distance = length(offset);
    let haze = 1.0 - exp(-distance * frame.light.horizon.w);
    return mix(color, sky(vec3f(offset.x, max(offset.y, 0.0), offset.z)), haze);
}

// The alpha that makes alpha-to-coverage cover a share of the four samples: whole quarters. A pattern from pixel to pixel
// would give finer steps, but breaks thin twigs into dots.
// (A sample mask would say it plainly, but naga 30 writes that output in a form that is not valid SPIR-V for Vulkan.)
fn coverage(alpha: f32) -> f32 {
    return clamp(round(alpha * 4.0), 0.0, 4.0) / 4.0;
}
