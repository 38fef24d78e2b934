// Which clusters of models are drawn: five steps a frame, each over all models, then a list of triangles and a draw for each chunk.
// Models of one mesh and one look are one dispatch and one draw: groups have the model as their second number.
//   weigh   projects each cluster's errors, and counts at which threshold it would be drawn
//   settle  takes the smallest threshold that fits the budget
//   count   counts the triangles of each group of clusters at that threshold
//   place   says where in the list each group begins
//   write   writes the triangles' numbers and the draws
// No step adds to a common counter where the order would show: the same view makes the same list, so what blends is the same to the last bit.
#include "shared/choice.wgsl"

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

struct Draw {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(6) var<storage, read_write> draws: array<Draw>;
@group(1) @binding(0) var<storage, read> clusters: array<Cluster>;

var<workgroup> firsts: array<u32, 64>;

// Each model of a chunk has groups of its own.
fn group_of(group: vec3u) -> u32 {
    return item.first_group + group.y * item.groups + group.x;
}

fn mark(s: Standing, cluster: Cluster) -> u32 {
    if item.absent != 0u || !is_seen(s, cluster.sphere) {
        return HIDDEN;
    }
    let by_grain = s.by_grain != 0u;
    let own = select(cluster.errors.x, cluster.errors.y, by_grain);
    let parent = select(cluster.errors.z, cluster.errors.w, by_grain);
    let replaced = select(bin(pixels(s, cluster.parent, parent)), NEVER, parent < 0.0);
    return bin(pixels(s, cluster.own, own)) | (replaced << 8u);
}

@compute @workgroup_size(64)
fn weigh(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    atomicStore(&changes[lane], 0);
    atomicStore(&changes[lane + 64u], 0);
    workgroupBarrier();
    let number = group.x * 64u + lane;
    if number < item.clusters {
        let cluster = clusters[number];
        let found = mark(standings[item.standing + group.y], cluster);
        marks[group_of(group) * 64u + lane] = found;
        if found != HIDDEN {
            change(found & 255u, found >> 8u, cluster.count);
        }
    }
    workgroupBarrier();
    tell_changes(lane);
}

@compute @workgroup_size(1)
fn settle() {
    var drawn = 0;
    var threshold = COARSEST;
    for (var bin = 0u; bin < BINS; bin += 1u) {
        drawn += atomicLoad(&state.changes[bin]);
        if drawn <= i32(item.budget / COUNTED_IN) && threshold == COARSEST {
            threshold = bin;
        }
    }
    state.threshold = threshold;
}

// Triangles of a cluster that are drawn.
fn drawn(group: vec3u, lane: u32) -> u32 {
    let number = group.x * 64u + lane;
    if number >= item.clusters {
        return 0u;
    }
    let found = marks[group_of(group) * 64u + lane];
    let own = found & 255u;
    let parent = (found >> 8u) & 255u;
    let is = found != HIDDEN && own <= state.threshold && state.threshold < parent;
    return select(0u, clusters[number].count, is);
}

@compute @workgroup_size(64)
fn count(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    line_up(lane, drawn(group, lane));
    if lane == 63u {
        sums[group_of(group)] = ends[63];
    }
}

@compute @workgroup_size(64)
fn write(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let room = arrayLength(&list);
    let number = group.x * 64u + lane;
    let mine = drawn(group, lane);
    firsts[lane] = 0u;
    if mine > 0u {
        firsts[lane] = clusters[number].first;
    }
    line_up(lane, mine);
    let start = sums[group_of(group)];
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
            list[start + at] = (firsts[high] + at - before) | (group.y << MODEL_SHIFT);
        }
    }
    if group.x == 0u && group.y == 0u && lane == 0u {
        let begin = min(sums[item.first_group], room);
        let end = min(sums[item.first_group + item.groups * item.models], room);
        draws[item.draw] = Draw((end - begin) * 3u, 1u, begin * 3u, item.standing);
    }
}
