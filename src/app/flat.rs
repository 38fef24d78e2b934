//! Text, lines and areas painted into a picture without a device: egui lays them out and makes triangles, which are filled here.
//!
//! Pictures of the renderer have no room for captions in a tree's colour; what is painted here is a few hundred letters, for which no device is needed.

use egui::epaint::{Mesh, Primitive, textures::TexturesDelta};
use egui::{Color32, ColorImage, ImageData, Painter, Pos2, Rect, TextureId};
use image::RgbaImage;

/// Paints upon a picture, a point a pixel.
pub(super) fn paint(onto: &mut RgbaImage, draw: impl Fn(&Painter)) {
    let context = egui::Context::default();
    let size = egui::vec2(onto.width() as f32, onto.height() as f32);
    let mut input = egui::RawInput {
        screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size)),
        ..Default::default()
    };
    if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
        viewport.native_pixels_per_point = Some(1.0);
    }
    let output = context.run_ui(input, |ui| draw(ui.painter()));
    let atlas = atlas(&output.textures_delta);
    let primitives = context.tessellate(output.shapes, 1.0);
    for clipped in primitives {
        if let Primitive::Mesh(mesh) = clipped.primitive {
            fill(onto, &mesh, &atlas);
        }
    }
    let mut delta = output.textures_delta;
    delta.clear();
}

/// The letters' image as the first layout has it.
fn atlas(textures: &TexturesDelta) -> ColorImage {
    let mut atlas = ColorImage::filled([1, 1], Color32::WHITE);
    for change in textures
        .set
        .get(&TextureId::default())
        .into_iter()
        .flatten()
    {
        let ImageData::Color(image) = &change.image;
        let Some([left, top]) = change.pos else {
            atlas = (**image).clone();
            continue;
        };
        let [wide, high] = image.size;
        for (row, pixels) in image.pixels.chunks(wide.max(1)).enumerate().take(high) {
            let start = (top + row) * atlas.size[0] + left;
            if let Some(place) = atlas.pixels.get_mut(start..start + pixels.len()) {
                place.copy_from_slice(pixels);
            }
        }
    }
    atlas
}

/// Fills a mesh's triangles, from the first to the last.
fn fill(onto: &mut RgbaImage, mesh: &Mesh, atlas: &ColorImage) {
    for triangle in mesh.indices.chunks_exact(3) {
        let corners = [triangle[0], triangle[1], triangle[2]].map(|index| {
            mesh.vertices
                .get(index as usize)
                .copied()
                .unwrap_or_default()
        });
        let [a, b, c] = corners.map(|corner| corner.pos);
        let twice = cross(a, b, c);
        if twice == 0.0 || !twice.is_finite() {
            continue;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let within = |value: f32, most: u32| value.clamp(0.0, most as f32);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "held within the picture just before"
        )]
        let [left, right, top, bottom] = [
            within(low.x.floor(), onto.width()) as u32,
            within(high.x.ceil(), onto.width()) as u32,
            within(low.y.floor(), onto.height()) as u32,
            within(high.y.ceil(), onto.height()) as u32,
        ];
        for y in top..bottom {
            for x in left..right {
                let at = Pos2::new(x as f32 + 0.5, y as f32 + 0.5);
                let parts =
                    [cross(b, c, at), cross(c, a, at), cross(a, b, at)].map(|part| part / twice);
                // A point on an edge that two triangles share is in one of them.
                let edges = [[b, c], [c, a], [a, b]].map(|edge| is_first(edge, twice));
                let is_in = parts
                    .iter()
                    .zip(edges)
                    .all(|(part, first)| *part > 0.0 || *part == 0.0 && first);
                if is_in {
                    let mix = |of: [f32; 3]| {
                        of.iter()
                            .zip(parts)
                            .map(|(of, part)| of * part)
                            .sum::<f32>()
                    };
                    let uv = [
                        mix(corners.map(|one| one.uv.x)),
                        mix(corners.map(|one| one.uv.y)),
                    ];
                    let texel = texel(atlas, uv);
                    let colour: [f32; 4] = std::array::from_fn(|channel| {
                        let own = mix(corners.map(|one| f32::from(one.color.to_array()[channel])));
                        own * f32::from(texel.to_array()[channel]) / 255.0
                    });
                    blend(onto.get_pixel_mut(x, y), colour);
                }
            }
        }
    }
}

/// Twice the area to the left of a way.
fn cross(a: Pos2, b: Pos2, c: Pos2) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Of two directions of an edge always one, by the side on which the triangle is.
fn is_first([from, to]: [Pos2; 2], twice: f32) -> bool {
    let way = (to - from) * twice.signum();
    way.y > 0.0 || way.y == 0.0 && way.x > 0.0
}

fn texel(atlas: &ColorImage, [u, v]: [f32; 2]) -> Color32 {
    let [wide, high] = atlas.size;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held within the image"
    )]
    let place = |part: f32, most: usize| {
        ((part.clamp(0.0, 1.0) * most as f32) as usize).min(most.saturating_sub(1))
    };
    let at = place(v, high) * wide + place(u, wide);
    atlas.pixels.get(at).copied().unwrap_or(Color32::WHITE)
}

/// Lays a colour, premultiplied, over a pixel.
fn blend(pixel: &mut image::Rgba<u8>, colour: [f32; 4]) {
    let left = 1.0 - colour[3] / 255.0;
    for (under, over) in pixel.0.iter_mut().zip(colour) {
        let mixed = over + f32::from(*under) * left;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "held between 0 and 255"
        )]
        let mixed = mixed.round().clamp(0.0, 255.0) as u8;
        *under = mixed;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use egui::{Align2, FontId};

    fn white() -> RgbaImage {
        RgbaImage::from_pixel(80, 30, image::Rgba([255; 4]))
    }

    fn dark(image: &RgbaImage) -> Vec<[u32; 2]> {
        let pixels = image
            .enumerate_pixels()
            .filter(|(.., pixel)| pixel.0[0] < 128);
        pixels.map(|(x, y, _)| [x, y]).collect()
    }

    #[test]
    fn a_rectangle_covers_its_pixels_and_no_others() {
        let mut image = white();
        let rect = Rect::from_min_max(Pos2::new(10.0, 5.0), Pos2::new(30.0, 15.0));
        paint(&mut image, |painter| {
            painter.rect_filled(rect, 0.0, Color32::BLACK);
        });
        let dark = dark(&image);
        assert_eq!(dark.len(), 200);
        assert!(
            dark.iter()
                .all(|[x, y]| (10..30).contains(x) && (5..15).contains(y))
        );
    }

    #[test]
    fn what_is_seen_through_is_mixed_once_along_edges_too() {
        let mut image = white();
        let rect = Rect::from_min_max(Pos2::new(4.0, 4.0), Pos2::new(60.0, 24.0));
        paint(&mut image, |painter| {
            painter.rect_filled(rect, 0.0, Color32::from_black_alpha(128));
        });
        for x in 6..58 {
            for y in 6..22 {
                assert!((126..=128).contains(&image.get_pixel(x, y).0[0]), "{x} {y}");
            }
        }
    }

    #[test]
    fn letters_are_letters() {
        let text = |said: &'static str| {
            let mut image = white();
            paint(&mut image, |painter| {
                painter.text(
                    Pos2::new(4.0, 4.0),
                    Align2::LEFT_TOP,
                    said,
                    FontId::proportional(16.0),
                    Color32::BLACK,
                );
            });
            dark(&image)
        };
        let (short, long) = (text("I"), text("IIIIII"));
        assert!(!short.is_empty() && text("").is_empty());
        assert!(
            long.len() > 4 * short.len(),
            "{} {}",
            long.len(),
            short.len()
        );
    }
}
