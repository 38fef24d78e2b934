// Surfaces from stone to metal in the stage's light, for shaders that include shared/light.wgsl.

struct Look {
    // rgb: linear; w: roughness.
    color: vec4f,
    // x: metallic.
    material: vec4f,
}

// A surface of this look in this light: matte light, the sun's shine and what it mirrors of the sky.
fn glossy(look: Look, normal: vec3f, to_eye: vec3f, sunny: f32) -> vec3f {
    let albedo = look.color.rgb;
    let roughness = clamp(look.color.w, max(0.06, frame.light.sun.w), 1.0);
    let metallic = look.material.x;
    let matte = lit(albedo * (1.0 - metallic), normal, to_eye, sunny);
    // Blinn's lobe of the same width as the roughness says, kept to one brightness as it narrows.
    let power = 2.0 / (roughness * roughness * roughness * roughness) - 1.0;
    let between = normalize(to_eye + frame.sun.xyz);
    let lobe = pow(max(dot(normal, between), 0.0), power) * (power + 8.0) / 25.0;
    let facing = max(dot(normal, frame.sun.xyz), 0.0);
    let mirror = mix(vec3f(0.04), albedo, metallic);
    let edge = pow(1.0 - max(dot(normal, to_eye), 0.0), 5.0);
    let fresnel = mirror + (vec3f(1.0) - mirror) * edge * (1.0 - roughness);
    let around = ambient(reflect(-to_eye, normal)) * fresnel * (1.0 - 0.7 * roughness);
    return matte + frame.light.sun.rgb * mirror * (min(lobe, 12.0) * facing * sunny) + around;
}
