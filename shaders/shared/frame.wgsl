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
}

@group(0) @binding(0) var<uniform> frame: Frame;
