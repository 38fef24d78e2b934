// What the shadow map hides, level by level coarser: x, how much of a texel's area; y, how deep that lies on average, times as much. Each pass writes a level.

@group(0) @binding(0) var depths: texture_depth_2d;
@group(0) @binding(1) var finer: texture_2d<f32>;

@vertex
fn shade_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32((index & 1u) * 4u), f32((index >> 1u) * 4u)) - 1.0;
    return vec4f(at, 0.0, 1.0);
}

// The finest level: of 4 x 4 depths those that are not as far as nothing is.
@fragment
fn first_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let corner = vec2i(position.xy) * 4;
    var sum = vec2f(0.0);
    for (var y = 0; y < 4; y += 1) {
        for (var x = 0; x < 4; x += 1) {
            let depth = textureLoad(depths, corner + vec2i(x, y), 0);
            sum += select(vec2f(0.0), vec2f(1.0, depth), depth < 1.0);
        }
    }
    return vec4f(sum / 16.0, 0.0, 1.0);
}

@fragment
fn next_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let corner = vec2i(position.xy) * 2;
    let sum = textureLoad(finer, corner, 0).xy
        + textureLoad(finer, corner + vec2i(1, 0), 0).xy
        + textureLoad(finer, corner + vec2i(0, 1), 0).xy
        + textureLoad(finer, corner + vec2i(1, 1), 0).xy;
    return vec4f(sum / 4.0, 0.0, 1.0);
}
