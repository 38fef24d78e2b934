// Where and how a model or a tree stands. Twin: src/render/selection/standings.rs.
struct Standing {
    // Rows of the similarity to the world.
    rows: array<vec4f, 3>,
    // What lies in front of this plane is cut away; no normal: nothing is.
    cut: vec4f,
    scale: f32,
    // Nothing is nearer.
    near: f32,
    // 1: each triangle has its own look, so the grain counts.
    by_grain: u32,
}

fn placed(s: Standing, place: vec3f) -> vec3f {
    let p = vec4f(place, 1.0);
    return vec3f(dot(s.rows[0], p), dot(s.rows[1], p), dot(s.rows[2], p));
}

fn turned(s: Standing, normal: vec3f) -> vec3f {
    return vec3f(dot(s.rows[0].xyz, normal), dot(s.rows[1].xyz, normal), dot(s.rows[2].xyz, normal));
}

// An entry of the list of triangles: a triangle's number in its chunk, and above it whose of the draw's models it is.
const MODEL_SHIFT = 24u;

fn triangle_of(entry: u32) -> u32 {
    return entry & ((1u << MODEL_SHIFT) - 1u);
}

fn model_of(entry: u32) -> u32 {
    return entry >> MODEL_SHIFT;
}
