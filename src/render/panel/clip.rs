//! egui's clip rectangles as Vulkan's scissors.

use ash::vk;

/// A clip rectangle in whole pixels within the picture.
pub(super) fn clip(rect: &egui::Rect, scale: f32, size: [u32; 2]) -> vk::Rect2D {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "clamped to the picture, at most 4096; NaN becomes 0"
    )]
    let pixel = |points: f32, most: u32| (points * scale).round().clamp(0.0, most as f32) as u32;
    let (left, top) = (pixel(rect.min.x, size[0]), pixel(rect.min.y, size[1]));
    let (right, bottom) = (pixel(rect.max.x, size[0]), pixel(rect.max.y, size[1]));
    let whole = |n: u32| i32::try_from(n).unwrap_or(0);
    vk::Rect2D {
        offset: vk::Offset2D {
            x: whole(left),
            y: whole(top),
        },
        extent: vk::Extent2D {
            width: right.saturating_sub(left),
            height: bottom.saturating_sub(top),
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "tests")]
    use super::*;

    #[test]
    fn clips_stay_within_the_picture() {
        let rect = |a: f32, b: f32, c: f32, d: f32| egui::Rect {
            min: egui::pos2(a, b),
            max: egui::pos2(c, d),
        };
        for (given, expected) in [
            (rect(1.0, 2.0, 3.0, 4.0), [2, 4, 4, 4]),
            (rect(-5.0, -5.0, 500.0, 500.0), [0, 0, 100, 50]),
            (
                rect(f32::NEG_INFINITY, 0.0, f32::INFINITY, 1.0),
                [0, 0, 100, 2],
            ),
            (rect(10.0, 10.0, 5.0, 5.0), [20, 20, 0, 0]),
            (rect(f32::NAN, f32::NAN, f32::NAN, f32::NAN), [0, 0, 0, 0]),
        ] {
            let found = clip(&given, 2.0, [100, 50]);
            let [x, y, width, height] = expected;
            assert_eq!(found.offset, vk::Offset2D { x, y }, "{given:?}");
            assert_eq!(
                found.extent,
                vk::Extent2D {
                    width: width.unsigned_abs(),
                    height: height.unsigned_abs()
                },
                "{given:?}"
            );
        }
    }
}
