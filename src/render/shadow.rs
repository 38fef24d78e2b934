//! Shadows: depth maps as the sun sees them. The tree has one, drawn again only when the tree, its place or its growth changed; all [models that stand for
//! good](crate::world::scene::ModelLook::shadow), planted trees, have one together ([`Wood`]), drawn again when one comes, goes or becomes another. So the tree's
//! is as fine however wide the wood is.

use ash::vk;
use glam::{Affine3A, BVec3, Mat3, Mat4, Vec3, Vec4};

use super::{
    error::{RenderError, Trying as _},
    frame::{full_barrier, run_now, transition},
    gpu::Gpu,
    memory::{Image, ImageDesc, View},
    pipelines::SHADOW_FORMAT,
    selection::sun_views,
    shade::Shade,
    tree_upload::Bounds,
};
use crate::mesh::display::Display;
use crate::tree::levels::cut::Views;
use crate::world::scene::{PlacedModel, weather::Sway};

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
    pub(crate) shade: Shade,
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
            shade: Shade::new(gpu, &view)?,
            image,
            view,
            sampler,
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
    Some(map_of(sun, center.extend(radius)))
}

/// World to the map of a cube along the sun's axes, of which middle and half the side are given, and a texel's size in metres.
fn map_of(sun: Vec3, cube: Vec4) -> (Mat4, f32) {
    let (center, radius) = (cube.truncate(), cube.w);
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
    (rows.transpose(), texel)
}

/// A model that throws a shadow: which one, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Standing {
    revision: u64,
    world_from_model: Affine3A,
}

/// All models that throw a shadow, and the sun that makes them do so.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Throwing {
    models: Vec<Standing>,
    /// Towards it.
    sun: Vec3,
    /// A cube along the sun's axes around all of them: middle, and half its side in metres; 0 where there is nothing.
    cube: Vec4,
}

impl Throwing {
    /// These are there, under this sun.
    pub(crate) fn follow<'a>(&mut self, sun: Vec3, models: impl Iterator<Item = &'a PlacedModel>) {
        let (right, up) = sun.any_orthonormal_pair();
        let stage_from_axes = Mat3::from_cols(right, up, sun);
        let axes_from_stage = stage_from_axes.transpose();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        self.models.clear();
        self.models.extend(models.map(|placed| {
            for corner in corners(&placed.display) {
                let at = axes_from_stage * placed.world_from_model.transform_point3(corner);
                (low, high) = (low.min(at), high.max(at));
            }
            Standing {
                revision: placed.revision,
                world_from_model: placed.world_from_model,
            }
        }));
        self.sun = sun;
        let half = ((high - low) * 0.5).max_element() * 1.02;
        let cube = (stage_from_axes * ((low + high) * 0.5)).extend(half);
        self.cube = if half > 1e-4 && cube.is_finite() {
            cube
        } else {
            Vec4::ZERO
        };
    }

    /// World to the map, and a texel's size in metres; nothing where no model throws a shadow.
    pub(crate) fn projection(&self) -> Option<(Mat4, f32)> {
        (self.cube.w > 0.0).then(|| map_of(self.sun, self.cube))
    }
}

/// The map of all models that throw a shadow.
pub(crate) struct Wood {
    pub(crate) shadow: Shadow,
    pub(crate) now: Throwing,
    drawn: Throwing,
}

impl Wood {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        Ok(Self {
            shadow: Shadow::new(gpu)?,
            now: Throwing::default(),
            drawn: Throwing::default(),
        })
    }

    /// Whether the map must be drawn anew.
    pub(crate) fn is_due(&self) -> bool {
        self.now != self.drawn
    }

    /// The sun as the choice takes it, where the map must be drawn anew; it is taken to be from then on.
    pub(crate) fn due(&mut self) -> Option<Views> {
        if !self.is_due() {
            return None;
        }
        self.drawn.models.clone_from(&self.now.models);
        (self.drawn.sun, self.drawn.cube) = (self.now.sun, self.now.cube);
        let (_, texel) = self.now.projection()?;
        let half = self.now.cube.w;
        let sphere = self.now.cube.truncate().extend(half * 3.0_f32.sqrt());
        Some(sun_views(self.now.sun, sphere, texel))
    }
}

fn corners(display: &Display) -> [Vec3; 8] {
    let (low, high) = (display.low, display.high);
    std::array::from_fn(|corner| {
        let far = BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
        Vec3::select(far, high, low)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use std::sync::Arc;

    use super::*;
    use crate::world::scene::ModelLook;

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

    #[test]
    fn the_map_of_a_wood_holds_all_of_it_and_no_more() {
        let sun = Vec3::new(0.4, 0.8, 0.2).normalize();
        let display = Arc::new(Display {
            low: Vec3::new(-2.0, 0.0, -1.0),
            high: Vec3::new(2.0, 9.0, 1.0),
            ..Display::default()
        });
        let placed = |x: f32| PlacedModel {
            display: Arc::clone(&display),
            revision: 1,
            world_from_model: Affine3A::from_rotation_translation(
                glam::Quat::from_rotation_y(x),
                Vec3::new(x, 0.0, -5.0),
            ),
            look: ModelLook::default(),
        };
        let models = [placed(0.0), placed(7.0), placed(-3.0)];
        let mut wood = Throwing::default();
        wood.follow(sun, models.iter());
        let (map, texel) = wood.projection().unwrap();
        let places = models.iter().flat_map(|placed| {
            let at = |corner| placed.world_from_model.transform_point3(corner);
            corners(&placed.display).map(at)
        });
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for place in places {
            let at = map.project_point3(place) * Vec3::new(0.5, 0.5, 1.0);
            (low, high) = (low.min(at), high.max(at));
        }
        let (low, high) = (
            low + Vec3::new(0.5, 0.5, 0.0),
            high + Vec3::new(0.5, 0.5, 0.0),
        );
        assert!(low.cmpge(Vec3::ZERO).all() && high.cmple(Vec3::ONE).all());
        let widest = (high - low).max_element();
        assert!((widest - 1.0 / 1.02).abs() < 1e-3, "{widest}");
        assert!((texel * 2048.0 - 2.0 * wood.cube.w).abs() < 1e-3);
        // Nothing, and nonsense, are not there.
        wood.follow(sun, [].into_iter());
        assert_eq!(wood.projection(), None);
        let far = PlacedModel {
            world_from_model: Affine3A::from_translation(Vec3::NAN),
            ..placed(0.0)
        };
        wood.follow(sun, [far].iter());
        assert_eq!(wood.projection(), None);
    }
}
