// Unit vectors as two snorm16. Twin: src/mesh/display.rs.

fn unfolded(packed: u32) -> vec3f {
    let p = unpack2x16snorm(packed);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let side = vec2f(select(-1.0, 1.0, p.x >= 0.0), select(-1.0, 1.0, p.y >= 0.0));
    let xy = select((vec2f(1.0) - abs(p.yx)) * side, p, z >= 0.0);
    return normalize(vec3f(xy, z));
}
