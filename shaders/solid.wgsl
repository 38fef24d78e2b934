// Plates and controllers: meshes with their own pose.
#include "shared/light.wgsl"
#include "shared/noise.wgsl"

struct Solid {
    // Rows of the affine map from model to world.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    color: vec4f,
    // x: 0 plate, 1 controller; y: trigger 0..1; z: 1 mirrors x (left hand).
    kind: vec4f,
}

@group(0) @binding(4) var<storage, read> solids: array<Solid>;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) model: vec3f,
    @location(3) @interpolate(flat) instance: u32,
    @location(4) @interpolate(flat) eye: vec3f,
    @location(5) @interpolate(flat) part: f32,
}

fn linear(s: Solid, p: vec3f) -> vec3f {
    return vec3f(dot(s.row_x.xyz, p), dot(s.row_y.xyz, p), dot(s.row_z.xyz, p));
}

// `place.w`: part of the model (0 body, 1 trigger, 2 dark, 3 light).
@vertex
fn solid_vertex(
    @location(0) place: vec4f,
    @location(1) facing: vec4f,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let s = solids[instance];
    var p = place.xyz;
    var n = facing.xyz;
    if place.w == 1.0 {
        // The trigger turns about its hinge.
        let angle = s.kind.y * 0.35;
        let hinge = vec3f(0.0, -0.008, -0.028);
        let c = cos(angle);
        let k = sin(angle);
        let r = p - hinge;
        p = hinge + vec3f(r.x, c * r.y - k * r.z, k * r.y + c * r.z);
        n = vec3f(n.x, c * n.y - k * n.z, k * n.y + c * n.z);
    }
    if s.kind.z > 0.5 {
        p.x = -p.x;
        n.x = -n.x;
    }
    // Normals go through the cofactors, so that stretched plates are lit right.
    let a = linear(s, vec3f(1.0, 0.0, 0.0));
    let b = linear(s, vec3f(0.0, 1.0, 0.0));
    let c = linear(s, vec3f(0.0, 0.0, 1.0));
    let v = frame.views[view];
    var out: Point;
    out.world = linear(s, p) + vec3f(s.row_x.w, s.row_y.w, s.row_z.w);
    out.position = v.clip_from_world * vec4f(out.world, 1.0);
    out.normal = cross(b, c) * n.x + cross(c, a) * n.y + cross(a, b) * n.z;
    out.model = p;
    out.instance = instance;
    out.eye = v.eye.xyz;
    out.part = place.w;
    return out;
}

@fragment
fn solid_fragment(point: Point) -> @location(0) vec4f {
    let s = solids[point.instance];
    let normal = normalize(point.normal);
    let offset = point.world - point.eye;
    let to_eye = -normalize(offset);
    var albedo = s.color.rgb;
    var gloss = 0.05;
    if s.kind.x < 0.5 {
        // A turned wooden disc: rings in the model, rim and grooves by its size in the world.
        let radius = length(linear(s, vec3f(1.0, 0.0, 0.0)));
        let reach = length(point.model.xz) * radius;
        let pixel = max(fwidth(reach), 1e-6);
        let wobble = noise(vec3f(point.model.xz * 3.0, 1.0)) * 0.012;
        let grain = noise(vec3f((reach + wobble) * 160.0, 2.0, 0.5)) * 0.6 + noise(vec3f(point.model.xz * 40.0, 8.0)) * 0.4;
        let fade = 1.0 - smoothstep(0.002, 0.010, pixel);
        albedo *= 1.0 + (grain - 0.5) * 0.22 * fade;
        if normal.y > 0.7 {
            let rim = radius - reach;
            let groove = 1.0 - smoothstep(0.0015, 0.0015 + pixel * 1.5, abs(rim - 0.014));
            albedo *= 1.0 - 0.45 * groove;
        }
    } else {
        gloss = 0.22;
        if point.part == 1.0 {
            albedo = mix(vec3f(0.10, 0.11, 0.12), vec3f(0.95, 0.45, 0.10), s.kind.y);
        } else if point.part == 2.0 {
            albedo = vec3f(0.028, 0.030, 0.034);
        } else if point.part == 3.0 {
            albedo = vec3f(0.55, 0.56, 0.58);
        }
    }
    let surface = lit(albedo, normal, to_eye, sunlight(point.world, normal));
    let shine = pow(max(dot(normal, normalize(to_eye + frame.sun.xyz)), 0.0), 60.0) * gloss;
    return vec4f(air(surface + shine, offset), 1.0);
}
