// How the wind moves what is on a tree: a function of the place at rest and of the time alone. Twin: src/world/scene/weather.rs, which says why.
#include "shared/frame.wgsl"
#include "shared/noise.wgsl"

const ALONG = vec2f(0.937, 0.349);
const ACROSS = vec2f(-0.349, 0.937);
const LEAN = 0.09;
const SHAKE = 0.05;
const STIFF_HEIGHT = 0.6;
const STIFF_REACH = 0.5;
const SHELTERED = 0.4;
const FLUTTER = 0.35;
const WHOLE_TURN = 6.2831853;
// Pixels of a leaf's length: shorter ones do not flutter, longer ones do whole.
const FLUTTERS = vec2f(4.0, 14.0);

// Whole turns are left out: devices promise nothing of the sine of thousands.
fn wave(phase: f32, times: f32) -> f32 {
    return sin(phase - WHOLE_TURN * fract(times * frame.wind.y));
}

fn bent(length: f32, stiff: f32) -> f32 {
    return length * length / (length + stiff);
}

fn gust_at(along: f32, across: f32) -> f32 {
    return 0.62 + 0.26 * wave(0.9 * along, 41.0) + 0.12 * wave(2.1 * along + 0.7 * across + 1.3, 97.0);
}

// Where a place of the world is now.
fn swayed(place: vec3f) -> vec3f {
    let strength = frame.wind.x;
    if strength <= 0.0 {
        return place;
    }
    let height = max(place.y - frame.root.y, 0.0);
    let reach = distance(place.xz, frame.root.xz);
    let along = dot(place.xz, ALONG);
    let across = dot(place.xz, ACROSS);
    let gust = gust_at(along, across);
    let swing = 0.22 * wave(0.6 * height + 0.5 * across, 151.0);
    let aside = 0.20 * wave(0.8 * along + 0.4 * height + 0.5, 113.0);
    let lean = (ALONG * (gust + swing) + ACROSS * aside) * (LEAN * strength * bent(height, STIFF_HEIGHT));
    let drop = 0.5 * dot(lean, lean) / max(height, 1e-4);
    let shake = SHAKE * strength * gust * bent(reach, STIFF_REACH) * height / (height + SHELTERED);
    let up = shake * wave(2.3 * along + 1.7 * across + 1.1 * place.y, 211.0);
    let side = shake * 0.6 * wave(1.9 * across - 2.7 * along + 1.3 * place.y + 2.0, 263.0);
    let moved = lean + ALONG * side;
    return place + vec3f(moved.x, up - drop, moved.y);
}

// How a leaf that hangs at such a place of the world, so long, is turned about where it hangs: a quaternion in its own frame. Each by phases and a pace
// that its place in the grown tree gives; nothing is left of it where the leaf is a few pixels long, as both eyes together see it.
fn fluttered(hangs: vec3f, length: f32, own_place: vec3f) -> vec4f {
    let strength = frame.wind.x;
    if strength <= 0.0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let eye = (frame.views[0].eye.xyz + frame.views[1].eye.xyz) * 0.5;
    let pixel = (frame.views[0].eye.w + frame.views[1].eye.w) * 0.5;
    let pixels = length / max(distance(hangs, eye) * pixel, 1e-9);
    let whole = smoothstep(FLUTTERS.x, FLUTTERS.y, pixels);
    let cell = bitcast<vec3i>(own_place);
    let own = hash(cell);
    let other = hash(cell.zxy);
    let gust = gust_at(dot(hangs.xz, ALONG), dot(hangs.xz, ACROSS));
    // One to two and a half times a second.
    let times = 256.0 + floor(own * 384.0);
    let turn = vec3f(
        wave(other * WHOLE_TURN, times),
        wave(own * 40.0, times + 77.0),
        wave(other * 50.0, floor(times * 0.6)),
    ) * (FLUTTER * strength * whole * gust);
    return normalize(vec4f(turn * 0.5, 1.0));
}
