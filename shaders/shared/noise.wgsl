// Value noise without tables.

fn hash(cell: vec3i) -> f32 {
    var v = bitcast<vec3u>(cell) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    return f32(v.x >> 8u) / 16777216.0;
}

// 0..1, smooth.
fn noise(p: vec3f) -> f32 {
    let cell = vec3i(floor(p));
    let f = p - floor(p);
    let w = f * f * (3.0 - 2.0 * f);
    let a = mix(hash(cell), hash(cell + vec3i(1, 0, 0)), w.x);
    let b = mix(hash(cell + vec3i(0, 1, 0)), hash(cell + vec3i(1, 1, 0)), w.x);
    let c = mix(hash(cell + vec3i(0, 0, 1)), hash(cell + vec3i(1, 0, 1)), w.x);
    let d = mix(hash(cell + vec3i(0, 1, 1)), hash(cell + vec3i(1, 1, 1)), w.x);
    return mix(mix(a, b, w.y), mix(c, d, w.y), w.z);
}
