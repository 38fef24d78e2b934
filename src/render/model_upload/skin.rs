//! A model's materials and images, on their way to the device and there.

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::Affine2;

use super::{Arriving, write_set};
use crate::mesh::paint::{Alpha, Material, Wrap};
use crate::mesh::textured::{Layers, Textured};
use crate::render::{
    error::RenderError, frame::Pool, gpu::Gpu, memory::Buffer, pipelines::IMAGE_SAMPLERS,
    texture::Texture,
};

/// `Material` of shaders/textured.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct MaterialData {
    color: [f32; 4],
    across: [f32; 4],
    down: [f32; 4],
    emission: [f32; 4],
    more: [f32; 4],
    layers: [f32; 4],
}

const UNLIT: u16 = 1;
const DOUBLE: u16 = 2;
const WRAPS: u16 = 4;

impl MaterialData {
    fn new(material: &Material) -> Self {
        let images = material.images();
        let lies = images.into_iter().flatten().next();
        let place = lies.map_or(Affine2::IDENTITY, |image| image.image_from_texture);
        // Fewer layers than a float counts.
        #[expect(clippy::cast_precision_loss, reason = "at most 256 layers")]
        let layers = images.map(|image| image.map_or(-1.0, |image| image.image as f32));
        let cutoff = match material.alpha {
            Alpha::Opaque => -1.0,
            Alpha::Mask(cutoff) => cutoff,
            Alpha::Blend => 2.0,
        };
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::Mirror => 1,
            Wrap::Clamp => 2,
        };
        let [across, down] = lies.map_or([0; 2], |image| image.wrap.map(wrap));
        let flag = |on: bool, bit: u16| if on { bit } else { 0 };
        let flags = flag(material.is_unlit, UNLIT)
            + flag(material.is_double_sided, DOUBLE)
            + WRAPS * (across + WRAPS * down);
        let (x, y, moved) = (
            place.matrix2.x_axis,
            place.matrix2.y_axis,
            place.translation,
        );
        let [red, green, blue] = material.emission.to_array();
        Self {
            color: material.base_colour.to_array(),
            across: [x.x, y.x, moved.x, material.normal_scale],
            down: [x.y, y.y, moved.y, cutoff],
            emission: [red, green, blue, material.roughness],
            more: [material.metallic, f32::from(flags), 0.0, 0.0],
            layers,
        }
    }
}

/// Materials and images of one model.
pub(crate) struct Skin {
    materials: Arriving<1>,
    images: Texture,
    set: vk::DescriptorSet,
    pool: Option<Pool>,
}

impl Skin {
    pub(crate) fn new(gpu: &Gpu, textured: &Textured) -> Result<Self, RenderError> {
        let materials: Vec<_> = textured.materials.iter().map(MaterialData::new).collect();
        let part = ("the model's materials", bytemuck::cast_slice(&materials));
        let white = Layers {
            size_px: [1, 1],
            count: 1,
            texels: vec![u8::MAX; 4],
        };
        // Something must be there, also where no material has an image.
        let layers = if textured.layers.count == 0 {
            &white
        } else {
            &textured.layers
        };
        let images = Texture::new(
            gpu,
            ["the model's images", "the model's images on their way"],
            layers,
        )?;
        Ok(Self {
            materials: Arriving::new(gpu, [part])?,
            images,
            set: vk::DescriptorSet::null(),
            pool: None,
        })
    }

    /// Its set, once all is there.
    pub(crate) fn set(&self) -> Option<vk::DescriptorSet> {
        self.pool.as_ref().map(|_| self.set)
    }

    /// Bytes that went up, or go.
    pub(crate) fn bytes(&self) -> u64 {
        self.materials.sizes[0] + self.images.bytes()
    }

    /// Copies up to `budget` bytes more (or one row, where that is more); true when all is there.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        layout: vk::DescriptorSetLayout,
        samplers: &[vk::Sampler; IMAGE_SAMPLERS],
        budget: &mut u64,
    ) -> Result<bool, RenderError> {
        if self.pool.is_some() {
            return Ok(true);
        }
        if !self.materials.copy(gpu, commands, budget) {
            return Ok(false);
        }
        if !self.images.copy(gpu, commands, budget) {
            return Ok(false);
        }
        self.bind(gpu, layout, samplers)?;
        Ok(true)
    }

    fn bind(
        &mut self,
        gpu: &Gpu,
        layout: vk::DescriptorSetLayout,
        samplers: &[vk::Sampler; IMAGE_SAMPLERS],
    ) -> Result<(), RenderError> {
        use vk::DescriptorType as Kind;
        let count = u32::try_from(IMAGE_SAMPLERS).unwrap_or(0);
        let sizes = [
            (Kind::SAMPLED_IMAGE, 1),
            (Kind::SAMPLER, count),
            (Kind::STORAGE_BUFFER, 1),
        ];
        let pool = Pool::new(gpu, 1, &sizes)?;
        self.set = pool.set(layout)?;
        let image = [self.images.described()];
        let samplers = samplers.map(|sampler| vk::DescriptorImageInfo::default().sampler(sampler));
        let write = |binding: u32, kind: Kind| {
            vk::WriteDescriptorSet::default()
                .dst_set(self.set)
                .dst_binding(binding)
                .descriptor_type(kind)
        };
        let mut writes = vec![write(0, Kind::SAMPLED_IMAGE).image_info(&image)];
        let each = (1..).zip(samplers.chunks(1));
        writes.extend(each.map(|(binding, one)| write(binding, Kind::SAMPLER).image_info(one)));
        // SAFETY: the set is new, what it is given lives as long as it.
        unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
        write_set(gpu, self.set, 1 + count, &[&self.materials.parts[0]]);
        self.pool = Some(pool);
        Ok(())
    }

    /// The staging memory, which is not needed any more; the caller frees it when the device is done.
    pub(crate) fn take(&mut self) -> impl Iterator<Item = Buffer> + use<> {
        let materials = self.materials.staging.take();
        [materials, self.images.take()].into_iter().flatten()
    }
}
