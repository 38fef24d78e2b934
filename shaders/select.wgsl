// Which clusters of models are drawn: five steps a frame, each over all models, then a list of triangles and a draw for each chunk.
//   weigh   projects each cluster's errors, and counts at which threshold it would be drawn
//   settle  takes the smallest threshold that fits the budget
//   count   counts the triangles of each group of clusters at that threshold
//   place   says where in the list each group begins
//   write   writes the triangles' numbers and the draws
// No step adds to a common counter where the order would show: the same view makes the same list, so what blends is the same to the last bit.
// Twin: src/mesh/levels/cut.rs.

struct Views {
    // Of each eye, the planes at its picture's edges: normals inwards and distances.
    planes: array<array<vec4f, 4>, 2>,
    // xyz: the eye; w: pixels that a metre has at a metre's distance.
    eyes: array<vec4f, 2>,
}

struct Cluster {
    // Around its triangles.
    sphere: vec4f,
    // From where its own error and its parents' count.
    own: vec4f,
    parent: vec4f,
    // Own error and grain, parents' error and grain; negative: it has no parents.
    errors: vec4f,
    first: u32,
    count: u32,
    pad: vec2u,
}

struct Item {
    // Rows of the similarity to the world.
    rows: array<vec4f, 3>,
    // What lies in front of this plane is cut away; no normal: nothing is.
    cut: vec4f,
    scale: f32,
    // Nothing is nearer.
    near: f32,
    // 1: each triangle has its own look, so the grain counts.
    flags: u32,
    clusters: u32,
    // Its first group of 64 clusters among all, and how many it has; for settle and place: how many there are.
    first_group: u32,
    groups: u32,
    draw: u32,
    // Triangles that all models may have.
    budget: u32,
}

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

struct Draw {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

var<immediate> item: Item;
@group(0) @binding(0) var<uniform> views: Views;
@group(0) @binding(1) var<storage, read_write> state: State;
// By cluster: bins of its own error and its parents'.
@group(0) @binding(2) var<storage, read_write> marks: array<u32>;
// By group: its triangles, then where they begin; one more at the end.
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
@group(0) @binding(5) var<storage, read_write> draws: array<Draw>;
@group(1) @binding(0) var<storage, read> clusters: array<Cluster>;

var<workgroup> changes: array<atomic<i32>, 128>;
var<workgroup> ends: array<u32, 64>;
var<workgroup> firsts: array<u32, 64>;

fn placed(place: vec3f) -> vec3f {
    let p = vec4f(place, 1.0);
    return vec3f(dot(item.rows[0], p), dot(item.rows[1], p), dot(item.rows[2], p));
}

// What is no number has the highest bits.
fn bin(size: f32) -> u32 {
    let bits = bitcast<u32>(size);
    let above = select(0u, bits - ONE, bits > ONE);
    return min(above / EIGHTH + select(0u, 1u, above % EIGHTH != 0u), COARSEST);
}

fn pixels(sphere: vec4f, error: f32) -> f32 {
    let middle = placed(sphere.xyz);
    let radius = sphere.w * item.scale;
    var most = 0.0;
    for (var eye = 0; eye < 2; eye += 1) {
        let at = views.eyes[eye];
        let far = max(distance(middle, at.xyz) - radius, item.near);
        most = max(most, error * item.scale * at.w / far);
    }
    return most;
}

fn is_seen(sphere: vec4f) -> bool {
    let middle = placed(sphere.xyz);
    let radius = sphere.w * item.scale;
    if dot(item.cut.xyz, middle) - item.cut.w > radius * length(item.cut.xyz) {
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

fn mark(cluster: Cluster) -> u32 {
    if !is_seen(cluster.sphere) {
        return HIDDEN;
    }
    let by_grain = (item.flags & 1u) != 0u;
    let own = select(cluster.errors.x, cluster.errors.y, by_grain);
    let parent = select(cluster.errors.z, cluster.errors.w, by_grain);
    let replaced = select(bin(pixels(cluster.parent, parent)), NEVER, parent < 0.0);
    return bin(pixels(cluster.own, own)) | (replaced << 8u);
}

@compute @workgroup_size(64)
fn weigh(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    atomicStore(&changes[lane], 0);
    atomicStore(&changes[lane + 64u], 0);
    workgroupBarrier();
    let number = group.x * 64u + lane;
    if number < item.clusters {
        let cluster = clusters[number];
        let found = mark(cluster);
        marks[item.first_group * 64u + number] = found;
        if found != HIDDEN {
            atomicAdd(&changes[found & 255u], i32(cluster.count));
            let parent = found >> 8u;
            if parent < BINS {
                atomicAdd(&changes[parent], -i32(cluster.count));
            }
        }
    }
    workgroupBarrier();
    for (var half = 0u; half < 2u; half += 1u) {
        let change = atomicLoad(&changes[lane + half * 64u]);
        if change != 0 {
            atomicAdd(&state.changes[lane + half * 64u], change);
        }
    }
}

@compute @workgroup_size(1)
fn settle() {
    var drawn = 0;
    var threshold = COARSEST;
    for (var bin = 0u; bin < BINS; bin += 1u) {
        drawn += atomicLoad(&state.changes[bin]);
        if drawn <= i32(item.budget) && threshold == COARSEST {
            threshold = bin;
        }
    }
    state.threshold = threshold;
}

// Triangles of a cluster that are drawn.
fn drawn(number: u32) -> u32 {
    if number >= item.clusters {
        return 0u;
    }
    let found = marks[item.first_group * 64u + number];
    let own = found & 255u;
    let parent = (found >> 8u) & 255u;
    let is = found != HIDDEN && own <= state.threshold && state.threshold < parent;
    return select(0u, clusters[number].count, is);
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
fn count(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    line_up(lane, drawn(group.x * 64u + lane));
    if lane == 63u {
        sums[item.first_group + group.x] = ends[63];
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

@compute @workgroup_size(64)
fn write(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let room = arrayLength(&list);
    let number = group.x * 64u + lane;
    let mine = drawn(number);
    firsts[lane] = 0u;
    if mine > 0u {
        firsts[lane] = clusters[number].first;
    }
    line_up(lane, mine);
    let start = sums[item.first_group + group.x];
    // All lanes write side by side; each finds whose triangle it has.
    for (var at = lane; at < ends[63]; at += 64u) {
        var low = 0u;
        var high = 63u;
        for (var step = 0; step < 6; step += 1) {
            let middle = (low + high) / 2u;
            if ends[middle] > at {
                high = middle;
            } else {
                low = min(middle + 1u, 63u);
            }
        }
        var before = 0u;
        if high > 0u {
            before = ends[high - 1u];
        }
        if start + at < room {
            list[start + at] = firsts[high] + at - before;
        }
    }
    if group.x == 0u && lane == 0u {
        let begin = min(sums[item.first_group], room);
        let end = min(sums[item.first_group + item.groups], room);
        draws[item.draw] = Draw((end - begin) * 3u, 1u, begin * 3u, 0u);
    }
}
