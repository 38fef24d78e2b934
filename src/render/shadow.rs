//! The tree's shadow: one depth map as the sun sees it, drawn again only when the tree, its place or its growth changed.

use ash::vk;
use glam::{Affine3A, Mat4, Vec3, Vec4};

use super::{
    error::{RenderError, Trying as _},
    frame::{full_barrier, run_now, transition},
    gpu::Gpu,
    memory::{Image, ImageDesc, View},
    pipelines::SHADOW_FORMAT,
    tree_upload::Bounds,
};
use crate::world::scene::weather::Sway;

/// Texels along a side.
pub(crate) const SIZE: u32 = 2048;

/// What the map was drawn for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShadowKey {
    pub(crate) revision: u64,
    pub(crate) growth: f32,
    pub(crate) world_from_tree: Affine3A,
    /// Towards the sun.
    pub(crate) sun: Vec3,
    pub(crate) sway: Sway,
}

pub(crate) struct Shadow {
    pub(crate) image: Image,
    pub(crate) view: View,
    pub(crate) sampler: vk::Sampler,
    pub(crate) drawn: Option<ShadowKey>,
    gpu: Gpu,
}

impl Shadow {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let extent = vk::Extent2D {
            width: SIZE,
            height: SIZE,
        };
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let image = Image::new(
            gpu,
            ImageDesc {
                layers: 1,
                ..ImageDesc::stereo("the shadow", SHADOW_FORMAT, extent, usage)
            },
        )?;
        let view = View::new(
            gpu,
            image.handle,
            SHADOW_FORMAT,
            vk::ImageAspectFlags::DEPTH,
            0..1,
            0..1,
        )?;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .compare_enable(true)
            .compare_op(vk::CompareOp::LESS_OR_EQUAL);
        // SAFETY: a plain sampler; linear filtering of depth comparisons falls back to nearest where a driver has none.
        let sampler = unsafe { gpu.device.create_sampler(&info, None) }
            .trying("making the shadow's sampler")?;
        let shadow = Self {
            image,
            view,
            sampler,
            drawn: None,
            gpu: gpu.clone(),
        };
        run_now(gpu, |commands| {
            full_barrier(
                gpu,
                commands,
                &[shadow.barrier(
                    vk::ImageLayout::UNDEFINED,
                    vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                )],
            );
        })?;
        Ok(shadow)
    }

    pub(crate) fn barrier(
        &self,
        from: vk::ImageLayout,
        to: vk::ImageLayout,
    ) -> vk::ImageMemoryBarrier2<'static> {
        transition(self.image.handle, vk::ImageAspectFlags::DEPTH, from, to)
    }

    pub(crate) fn extent(&self) -> vk::Extent2D {
        self.image.desc.extent
    }
}

impl Drop for Shadow {
    fn drop(&mut self) {
        // SAFETY: the renderer waits for the device before it drops its parts.
        unsafe { self.gpu.device.destroy_sampler(self.sampler, None) };
    }
}

/// World to the map (x, y in −1…1; depth 0 near the sun, 1 far) for a tree within `bounds` that the wind moves by `sway` metres at most, and a texel's size in
/// metres.
/// `None` where there is nothing that could throw a shadow.
pub(crate) fn projection(
    sun: Vec3,
    bounds: &Bounds,
    world_from_tree: &Affine3A,
    sway: f32,
) -> Option<(Mat4, f32)> {
    let scale = world_from_tree.x_axis.length();
    let still = bounds.radius * scale;
    let radius = still * 1.02 + sway;
    let center = world_from_tree.transform_point3(bounds.center);
    if !(still > 1e-4 && radius.is_finite() && center.is_finite()) {
        return None;
    }
    let (right, up) = sun.any_orthonormal_pair();
    let row =
        |axis: Vec3, size: f32, middle: f32| (axis / size).extend(middle - axis.dot(center) / size);
    let rows = Mat4::from_cols(
        row(right, radius, 0.0),
        row(up, radius, 0.0),
        row(-sun, 2.0 * radius, 0.5),
        Vec4::W,
    );
    // 2 metres of radius over 2048 texels: 2 mm.
    #[allow(clippy::cast_precision_loss, reason = "a power of two")]
    let texel = 2.0 * radius / SIZE as f32;
    Some((rows.transpose(), texel))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;

    #[test]
    fn the_map_holds_the_whole_tree_and_depth_grows_away_from_the_sun() {
        let sun = Vec3::new(0.4, 0.8, 0.2).normalize();
        let bounds = Bounds {
            center: Vec3::new(0.0, 1.0, 0.0),
            radius: 1.5,
            foot: 0.1,
            root: Vec3::ZERO,
        };
        let place = Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            glam::Quat::from_rotation_y(1.0),
            Vec3::new(3.0, 0.0, -5.0),
        );
        let (map, texel) = projection(sun, &bounds, &place, 0.0).unwrap();
        assert!((texel - 6.0 * 1.02 / 2048.0).abs() < 1e-6);
        for direction in [
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ] {
            let point = place.transform_point3(bounds.center + direction * bounds.radius);
            let at = map.project_point3(point);
            assert!(
                at.x.abs() <= 1.0 && at.y.abs() <= 1.0 && (0.0..=1.0).contains(&at.z),
                "{at}"
            );
            let nearer = map.project_point3(point + sun * 0.1);
            assert!(nearer.z < at.z && (nearer.truncate() - at.truncate()).length() < 1e-5);
        }
        // What sways is in it, too.
        let (map, _) = projection(sun, &bounds, &place, 0.4).unwrap();
        let aside = place.transform_point3(bounds.center + Vec3::Y * bounds.radius) + Vec3::X * 0.4;
        let at = map.project_point3(aside);
        assert!(at.x.abs() <= 1.0 && at.y.abs() <= 1.0 && (0.0..=1.0).contains(&at.z));
        assert_eq!(projection(sun, &Bounds::default(), &place, 0.0), None);
    }
}
