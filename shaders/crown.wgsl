// Which clusters of trees are drawn, branches and leaves, and as what: select.wgsl's steps (settle is its own), but a cluster has a kind, tubes of more or
// fewer sides or ribbons, by its size on the screen. For each chunk the list has its batches, kind by kind, and for each kind there is a draw.
// Twin: src/tree/levels.
#include "shared/choice.wgsl"

struct Cluster {
    // Around its records.
    sphere: vec4f,
    // From where its own error and its parent's count.
    own: vec4f,
    parent: vec4f,
    own_error: f32,
    // Negative: it has no parent.
    parent_error: f32,
    // What its kind depends on.
    size: f32,
    pad: u32,
    // Its batches of eight records, and how many of these from the first on have ends.
    first: u32,
    batches: u32,
    ends: u32,
    pad_end: u32,
}

struct Kind {
    // Of a batch.
    indices: u32,
    first: u32,
    // Where the size is less than so many pixels; 0: no cluster's kind.
    below: f32,
    // The kind of its ends.
    ends: u32,
}

const KINDS = 8u;
const NONE = 0xffffffffu;
// Words of a draw.
const WORDS = 5u;
// A list's entry: a batch's number, and the kind in the bits above.
const KIND_SHIFT = 28u;

@group(0) @binding(6) var<storage, read_write> draws: array<u32>;
@group(1) @binding(0) var<storage, read> clusters: array<Cluster>;
@group(1) @binding(1) var<storage, read> kinds: array<Kind, 8>;

// As `ends` of shared/choice.wgsl, of two kinds in each part: a group has no more than 512 batches.
var<workgroup> runs: array<vec4u, 64>;

fn mark(cluster: Cluster) -> u32 {
    let s = standings[item.standing];
    if !is_seen(s, cluster.sphere) {
        return HIDDEN;
    }
    let replaced = select(bin(pixels(s, cluster.parent, cluster.parent_error)), NEVER, cluster.parent_error < 0.0);
    let size = pixels(s, cluster.sphere, cluster.size);
    var kind = 0u;
    for (var finer = 1u; finer < KINDS; finer += 1u) {
        if size < kinds[finer].below {
            kind = finer;
        }
    }
    return bin(pixels(s, cluster.own, cluster.own_error)) | (replaced << 8u) | (kind << 16u);
}

fn triangles(cluster: Cluster, kind: u32) -> u32 {
    let ends = kinds[kind].ends;
    var all = cluster.batches * kinds[kind].indices;
    if ends < KINDS {
        all += cluster.ends * kinds[ends].indices;
    }
    return all / 3u;
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
            change(found & 255u, (found >> 8u) & 255u, triangles(cluster, found >> 16u));
        }
    }
    workgroupBarrier();
    tell_changes(lane);
}

struct Drawn {
    first: u32,
    batches: u32,
    ends: u32,
    kind: u32,
    ends_kind: u32,
}

fn drawn(number: u32) -> Drawn {
    var out = Drawn(0u, 0u, 0u, 0u, 0u);
    if number >= item.clusters {
        return out;
    }
    let found = marks[item.first_group * 64u + number];
    let own = found & 255u;
    let parent = (found >> 8u) & 255u;
    if found == HIDDEN || own > state.threshold || state.threshold >= parent {
        return out;
    }
    out.first = clusters[number].first;
    out.batches = clusters[number].batches;
    out.kind = found >> 16u;
    let ends = kinds[out.kind].ends;
    if ends < KINDS {
        out.ends = clusters[number].ends;
        out.ends_kind = ends;
    }
    return out;
}

// A kind's part of a run.
fn part(run: vec4u, kind: u32) -> u32 {
    return (run[kind / 2u] >> ((kind & 1u) * 16u)) & 0xffffu;
}

fn run_of(what: Drawn) -> vec4u {
    var run = vec4u(0u);
    run[what.kind / 2u] += what.batches << ((what.kind & 1u) * 16u);
    run[what.ends_kind / 2u] += what.ends << ((what.ends_kind & 1u) * 16u);
    return run;
}

fn line_up_kinds(lane: u32, run: vec4u) {
    runs[lane] = run;
    workgroupBarrier();
    for (var step = 1u; step < 64u; step *= 2u) {
        var before = vec4u(0u);
        if lane >= step {
            before = runs[lane - step];
        }
        workgroupBarrier();
        runs[lane] += before;
        workgroupBarrier();
    }
}

// Where a group's sum of a kind is.
fn sum_at(kind: u32, group: u32) -> u32 {
    return item.first_group * KINDS + kind * item.groups + group;
}

@compute @workgroup_size(64)
fn count(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    line_up_kinds(lane, run_of(drawn(group.x * 64u + lane)));
    if lane < KINDS {
        sums[sum_at(lane, group.x)] = part(runs[63], lane);
    }
}

@compute @workgroup_size(64)
fn write(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let room = arrayLength(&list);
    let mine = drawn(group.x * 64u + lane);
    let run = run_of(mine);
    line_up_kinds(lane, run);
    let before = runs[lane] - run;
    let at = sums[sum_at(mine.kind, group.x)] + part(before, mine.kind);
    for (var batch = 0u; batch < mine.batches; batch += 1u) {
        if at + batch < room {
            list[at + batch] = (mine.first + batch) | (mine.kind << KIND_SHIFT);
        }
    }
    let ends_at = sums[sum_at(mine.ends_kind, group.x)] + part(before, mine.ends_kind);
    for (var batch = 0u; batch < mine.ends; batch += 1u) {
        if ends_at + batch < room {
            list[ends_at + batch] = (mine.first + batch) | (mine.ends_kind << KIND_SHIFT);
        }
    }
    if group.x == 0u && lane < KINDS {
        let begin = min(sums[sum_at(lane, 0u)], room);
        let end = min(sums[sum_at(lane, item.groups)], room);
        let word = (item.draw + lane) * WORDS;
        draws[word] = kinds[lane].indices;
        draws[word + 1u] = end - begin;
        draws[word + 2u] = kinds[lane].first;
        draws[word + 3u] = 0u;
        draws[word + 4u] = begin;
    }
}
