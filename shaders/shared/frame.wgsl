// What every pass knows of the frame. Twin: src/render/data.rs.

struct View {
    clip_from_world: mat4x4f,
    // xyz: the eye in the world; w: a pixel's width at a distance of 1 m.
    eye: vec4f,
    // The direction through the picture's point (x, y) in -1..1 is ray + x * ray_x + y * ray_y.
    ray: vec4f,
    ray_x: vec4f,
    ray_y: vec4f,
}

// What it is lit by: day, evening or studio. Colours are linear. Twin: src/render/light.rs.
struct Light {
    // rgb: the sun's or the lamp's; w: half the angle under which it is seen, as a tangent.
    sun: vec4f,
    // rgb: the sky at the horizon; w: haze by the metre.
    horizon: vec4f,
    // rgb: what the horizon has besides on the sun's side; w: as far as shadows on the tree itself are blurred, texels.
    toward_sun: vec4f,
    // rgb: the sky at a third of its height, and right above.
    middle: vec4f,
    zenith: vec4f,
    // rgb: haze about the sun, near to it, and the sun itself.
    glow: vec4f,
    halo: vec4f,
    disc: vec4f,
    // rgb: on what faces up, and on what faces down.
    above: vec4f,
    below: vec4f,
    // xyz: towards a second lamp; rgb: its colour.
    fill: vec4f,
    fill_color: vec4f,
    // The same of a third one.
    rim: vec4f,
    rim_color: vec4f,
    // rgb: a plain floor; w: 1 where there is one, 0 where there is grass.
    floor: vec4f,
}

struct Frame {
    // Per-eye passes bind this block so that their eye comes first.
    views: array<View, 2>,
    // xyz: towards the sun.
    sun: vec4f,
    // rgb: a plain backdrop; w: 1 where it takes the stage's place.
    backdrop: vec4f,
    world_from_tree: mat4x4f,
    // x: growth 0..1; y: scale of world_from_tree; z: 1 where the shadow map holds a tree; w: a texel of it in metres.
    tree: vec4f,
    // World to the shadow map's x, y in -1..1 and depth 0 (near the sun) to 1.
    shadow_from_world: mat4x4f,
    // Contact shadows on the ground: x, z, radius, strength.
    spots: array<vec4f, 8>,
    light: Light,
    // x: how strongly it blows, 0..1; y: the wind's clock, 0..1.
    wind: vec4f,
    // xyz: where the tree stands.
    root: vec4f,
    // The same as `shadow_from_world` for the map of models that throw a shadow; x: a texel of it in metres, 0 where there is none.
    wood_from_world: mat4x4f,
    wood: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
