// What the choice of models' clusters (select.wgsl) and of trees' (crown.wgsl) have in common: who sees a sphere, how large something looks there, and
// the steps that need to know nothing else. Twin: src/tree/levels/cut.rs.
#include "shared/standing.wgsl"

struct Views {
    // Of each eye, the planes at its picture's edges: normals inwards and distances.
    planes: array<array<vec4f, 4>, 2>,
    // xyz: the eye; w: pixels that a metre has at a metre's distance.
    eyes: array<vec4f, 2>,
}

// What a dispatch looks at: a chunk of a tree, or a chunk of some models of one mesh, one after the other.
struct Item {
    clusters: u32,
    // Its first group of 64 clusters among all, and how many each of the models has; for place: how many sums there are.
    first_group: u32,
    groups: u32,
    models: u32,
    // The first of the models among all that stand.
    standing: u32,
    draw: u32,
    // Triangles that all may have.
    budget: u32,
    // 1: it is not drawn in this pass.
    absent: u32,
    // What the wind may move it by, metres.
    sway: f32,
}

// Triangles are counted in so many, so that all of them fit 32 bits.
const COUNTED_IN = 8u;
const BINS = 128u;
const COARSEST = 127u;
const NEVER = 255u;
const EIGHTH = 1048576u;
const ONE = 0x3f800000u;
// Of a cluster that neither eye sees.
const HIDDEN = 0xffffffffu;

struct State {
    changes: array<atomic<i32>, 128>,
    threshold: u32,
}

var<immediate> item: Item;
@group(0) @binding(0) var<uniform> views: Views;
@group(0) @binding(1) var<storage, read_write> state: State;
// By cluster: what was found out of it.
@group(0) @binding(2) var<storage, read_write> marks: array<u32>;
// By group (and kind): what it draws, then where that begins; one more at the end.
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
@group(0) @binding(5) var<storage, read> standings: array<Standing>;

var<workgroup> changes: array<atomic<i32>, 128>;
var<workgroup> ends: array<u32, 64>;

// What is no number has the highest bits.
fn bin(size: f32) -> u32 {
    let bits = bitcast<u32>(size);
    let above = select(0u, bits - ONE, bits > ONE);
    return min(above / EIGHTH + select(0u, 1u, above % EIGHTH != 0u), COARSEST);
}

fn pixels(s: Standing, sphere: vec4f, error: f32) -> f32 {
    let middle = placed(s, sphere.xyz);
    let radius = sphere.w * s.scale;
    var most = 0.0;
    for (var eye = 0; eye < 2; eye += 1) {
        let at = views.eyes[eye];
        let far = max(distance(middle, at.xyz) - radius, s.near);
        most = max(most, error * s.scale * at.w / far);
    }
    return most;
}

fn is_seen(s: Standing, sphere: vec4f) -> bool {
    let middle = placed(s, sphere.xyz);
    let radius = sphere.w * s.scale + item.sway;
    if dot(s.cut.xyz, middle) - s.cut.w > radius * length(s.cut.xyz) {
        return false;
    }
    var seen = false;
    for (var eye = 0; eye < 2; eye += 1) {
        var within = true;
        for (var edge = 0; edge < 4; edge += 1) {
            let plane = views.planes[eye][edge];
            within = within && dot(plane.xyz, middle) + plane.w >= -radius;
        }
        seen = seen || within;
    }
    return seen;
}

// Adds a group's changes to those of all.
fn tell_changes(lane: u32) {
    for (var half = 0u; half < 2u; half += 1u) {
        let change = atomicLoad(&changes[lane + half * 64u]);
        if change != 0 {
            atomicAdd(&state.changes[lane + half * 64u], change);
        }
    }
}

// Counts so many triangles from a cluster's own bin to its parents'.
fn change(own: u32, parent: u32, triangles: u32) {
    let counted = i32((triangles + COUNTED_IN - 1u) / COUNTED_IN);
    atomicAdd(&changes[own], counted);
    if parent < BINS {
        atomicAdd(&changes[parent], -counted);
    }
}

// Leaves in `ends` where each lane's run ends when all are put one after the other.
fn line_up(lane: u32, count: u32) {
    ends[lane] = count;
    workgroupBarrier();
    for (var step = 1u; step < 64u; step *= 2u) {
        var before = 0u;
        if lane >= step {
            before = ends[lane - step];
        }
        workgroupBarrier();
        ends[lane] += before;
        workgroupBarrier();
    }
}

@compute @workgroup_size(64)
fn place(@builtin(local_invocation_index) lane: u32) {
    let share = (item.groups + 63u) / 64u;
    let first = min(lane * share, item.groups);
    let end = min(first + share, item.groups);
    var sum = 0u;
    for (var group = first; group < end; group += 1u) {
        sum += sums[group];
    }
    line_up(lane, sum);
    var at = ends[lane] - sum;
    for (var group = first; group < end; group += 1u) {
        let triangles = sums[group];
        sums[group] = at;
        at += triangles;
    }
    if lane == 63u {
        sums[item.groups] = ends[63];
    }
}
