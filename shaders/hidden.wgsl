// What the lenses hide: drawn first and nearest, so that nothing behind it is shaded. Black, as the picture is when it is cleared.

struct Eyes {
    // From tangents to the picture's -1..1, y down: xy scale, zw move.
    left: vec4f,
    right: vec4f,
    // Which eye view 0 is: each eye's own pass has but one view.
    first: u32,
}

var<immediate> eyes: Eyes;

// xy: tangents at which the eye sees the corner, y up; z: the eye.
@vertex
fn hidden_vertex(@location(0) corner: vec4f, @builtin(view_index) view: u32) -> @builtin(position) vec4f {
    let eye = f32(eyes.first + view);
    if corner.z != eye {
        // All three corners are the other eye's: outside of everything.
        return vec4f(2.0, 2.0, 2.0, 1.0);
    }
    let map = select(eyes.left, eyes.right, eye > 0.5);
    // Depth is reversed: 1 is the nearest.
    return vec4f(corner.xy * map.xy + map.zw, 1.0, 1.0);
}

@fragment
fn hidden_fragment() -> @location(0) vec4f {
    return vec4f(0.0, 0.0, 0.0, 1.0);
}
