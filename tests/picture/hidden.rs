//! What the lenses hide is not drawn, and all else is drawn as ever.

use image::Rgba;
use ramus::render::{DrawReport, Eye, Fov, Gpu, Offscreen, Renderer, RendererParams, StereoMode};

use super::support::{SIDE, Shot, device, mode, silent, stage, standing};

type Triangles = Vec<[f32; 2]>;

/// Eyes that see more to one side and up than to the other and down, as headsets' do.
fn eyes() -> [Eye; 2] {
    let fov = |left, right| Fov {
        left,
        right,
        up: 0.8,
        down: -0.6,
    };
    let [mut left, mut right] = standing();
    (left.fov, right.fov) = (fov(-0.9, 0.7), fov(-0.7, 0.9));
    [left, right]
}

/// The left eye's upper left corner; the right eye's lower right one, and a part of its left edge and beyond.
fn mask() -> [Triangles; 2] {
    [
        vec![[-1.3, 1.1], [-0.2, 1.1], [-1.3, 0.1]],
        vec![
            [1.3, -0.8],
            [0.5, -0.8],
            [1.3, 0.2],
            [-2.0, 0.0],
            [-0.6, 0.3],
            [-0.6, -0.3],
        ],
    ]
}

fn draw(renderer: &mut Renderer, offscreen: &Offscreen) -> (Shot, DrawReport) {
    let report = renderer
        .draw(&stage(), &eyes(), &offscreen.target())
        .unwrap();
    let shot = Shot {
        color: offscreen.read_color().unwrap(),
        depth: offscreen.read_depth().unwrap(),
    };
    (shot, report)
}

/// How far the middle of a pixel lies inside of the nearest triangle that it is in, in pixels; negative outside.
fn inside(triangles: &Triangles, fov: &Fov, x: u32, y: u32) -> f32 {
    let (left, right) = (fov.left.tan(), fov.right.tan());
    let (up, down) = (fov.up.tan(), fov.down.tan());
    let side = SIDE as f32;
    let pixel = |[tx, ty]: [f32; 2]| {
        [
            (tx - left) / (right - left) * side,
            (up - ty) / (up - down) * side,
        ]
    };
    let at = [x as f32 + 0.5, y as f32 + 0.5];
    let one = |triangle: &[[f32; 2]]| {
        let [a, b, c] = [0, 1, 2].map(|corner| pixel(triangle[corner]));
        let turn = |p: [f32; 2], q: [f32; 2], r: [f32; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let side = turn(a, b, c).signum();
        [(a, b), (b, c), (c, a)]
            .into_iter()
            .map(|(p, q)| side * turn(p, q, at) / (q[0] - p[0]).hypot(q[1] - p[1]))
            .fold(f32::INFINITY, f32::min)
    };
    triangles
        .chunks_exact(3)
        .map(one)
        .fold(f32::NEG_INFINITY, f32::max)
}

fn modes(gpu: &Gpu) -> Vec<StereoMode> {
    let mut modes = vec![mode(gpu), StereoMode::PerEye];
    modes.dedup();
    modes
}

#[test]
fn hidden_pixels_stay_black_and_all_others_are_as_without_a_mask() {
    let Some(gpu) = device() else { return };
    let hidden = mask();
    for mode in modes(&gpu) {
        let params = RendererParams::new(SIDE, SIDE, mode);
        let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let (open, plain) = draw(&mut renderer, &offscreen);
        renderer.set_hidden([&hidden[0], &hidden[1]]).unwrap();
        let (masked, more) = draw(&mut renderer, &offscreen);
        let passes = if mode == StereoMode::PerEye { 2 } else { 1 };
        // The shadow of the first frame stands.
        assert!(
            more.draws >= passes && plain.draws > passes,
            "{plain:?} {more:?}"
        );
        for (eye, hidden) in hidden.iter().enumerate() {
            let (mut covered, mut edge) = (0, 0);
            for (x, y, pixel) in masked.color[eye].enumerate_pixels() {
                let at = (y * SIDE + x) as usize;
                let depth = masked.depth[eye][at];
                let within = inside(hidden, &eyes()[eye].fov, x, y);
                if within > 0.8 {
                    covered += 1;
                    assert_eq!(*pixel, Rgba([0, 0, 0, 255]), "{mode:?} {eye}: {x} {y}");
                    assert_eq!(depth, 1.0, "{mode:?} {eye}: {x} {y}");
                } else if within < -0.8 {
                    let same = pixel == open.color[eye].get_pixel(x, y);
                    assert!(same, "{mode:?} {eye}: {x} {y} is another colour");
                    assert_eq!(depth, open.depth[eye][at], "{mode:?} {eye}: {x} {y}");
                } else {
                    edge += 1;
                }
            }
            // The test is about something: a good part is hidden, and the edge is thin.
            assert!(
                covered > 4000 && edge < 800,
                "{mode:?} {eye}: {covered}, {edge}"
            );
        }
        // Without the mask again, all is as it was.
        renderer.set_hidden([&[], &[]]).unwrap();
        let (again, _) = draw(&mut renderer, &offscreen);
        assert!(
            again.color == open.color && again.depth == open.depth,
            "{mode:?}"
        );
    }
    silent(&gpu);
}

#[test]
fn an_empty_mask_draws_nothing_and_a_mask_may_change_in_every_frame() {
    let Some(gpu) = device() else { return };
    for mode in modes(&gpu) {
        let params = RendererParams::new(64, 64, mode);
        let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
        let mut renderer = Renderer::new(&gpu, &params).unwrap();
        let mut draws = |hidden: [&[[f32; 2]]; 2]| {
            renderer.set_hidden(hidden).unwrap();
            // Nobody waits for the frame: the next mask comes while it may still be drawn.
            let report = renderer.draw(&stage(), &eyes(), &offscreen.target());
            report.unwrap().draws
        };
        draws([&[], &[]]);
        let none = draws([&[], &[]]);
        let [left, right] = mask();
        let passes = if mode == StereoMode::PerEye { 2 } else { 1 };
        for _ in 0..4 {
            assert_eq!(draws([&left, &right]), none + passes, "{mode:?}");
            assert_eq!(draws([&left, &[]]), none + passes, "{mode:?}");
            // Less than a triangle is none.
            assert_eq!(draws([&left[..2], &[]]), none, "{mode:?}");
        }
    }
    silent(&gpu);
}
