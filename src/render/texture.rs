//! Images with mip levels on their way to the device and there: so many rows a frame.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{
    error::RenderError,
    frame::{full_barrier, transition},
    gpu::Gpu,
    memory::{Buffer, Image, ImageDesc, View},
};
use crate::mesh::textured::Layers;

/// sRGB, so that the device averages light and not bytes; every device filters it.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Layers of one image.
pub(crate) struct Texture {
    image: Image,
    view: View,
    /// What has not been copied yet.
    staging: Option<Buffer>,
    /// Of which layers and levels; rows from the top.
    left: Vec<Rows>,
    begun: bool,
}

/// Rows of an image that go together, and where they are in the staging memory.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rows {
    layer: u32,
    level: u32,
    width: u32,
    first: u32,
    count: u32,
    offset: u64,
}

impl Texture {
    /// Room for these layers, at most as large as the device takes them; named, and on their way.
    pub(crate) fn new(
        gpu: &Gpu,
        [name, on_its_way]: [&'static str; 2],
        layers: &Layers,
    ) -> Result<Self, RenderError> {
        let (base, [width, height]) = base(layers, gpu.limits.max_image_dimension2_d);
        let extent = vk::Extent2D { width, height };
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::new(
            gpu,
            ImageDesc {
                layers: layers.count,
                mips: layers.levels() - base,
                ..ImageDesc::stereo(name, FORMAT, extent, usage)
            },
        )?;
        let view = View::array(gpu, &image)?;
        let bytes = layers.texels.len() as u64;
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let mut staging = Buffer::new(gpu, on_its_way, bytes, usage, MemoryLocation::CpuToGpu)?;
        staging.write(0, &layers.texels);
        Ok(Self {
            image,
            view,
            staging: Some(staging),
            left: rows(layers, base),
            begun: false,
        })
    }

    /// Bytes that went up, or go.
    pub(crate) fn bytes(&self) -> u64 {
        let desc = &self.image.desc;
        let texels = u64::from(desc.extent.width) * u64::from(desc.extent.height);
        // Smaller levels are a third of the largest.
        texels * u64::from(desc.layers) * 4 * 4 / 3
    }

    /// Copies up to `budget` bytes more (or one row, where that is more); true when all is there and may be read.
    pub(crate) fn copy(
        &mut self,
        gpu: &Gpu,
        commands: vk::CommandBuffer,
        budget: &mut u64,
    ) -> bool {
        if self.begun && self.left.is_empty() {
            return true;
        }
        let copied_to = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let color = vk::ImageAspectFlags::COLOR;
        let image = self.image.handle;
        if !std::mem::replace(&mut self.begun, true) {
            let to = transition(image, color, vk::ImageLayout::UNDEFINED, copied_to);
            full_barrier(gpu, commands, &[to]);
        }
        let regions = due(&mut self.left, budget);
        if let Some(staging) = &self.staging {
            // SAFETY: the regions are rows of the image, and the staging memory holds them.
            unsafe {
                gpu.device.cmd_copy_buffer_to_image(
                    commands,
                    staging.handle,
                    image,
                    copied_to,
                    &regions,
                );
            }
        }
        if !self.left.is_empty() {
            return false;
        }
        let read = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        full_barrier(gpu, commands, &[transition(image, color, copied_to, read)]);
        true
    }

    /// What a descriptor set is told of it.
    pub(crate) fn described(&self) -> vk::DescriptorImageInfo {
        vk::DescriptorImageInfo::default()
            .image_view(self.view.handle)
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
    }

    /// The staging memory, which is not needed any more; the caller frees it when the device is done.
    pub(crate) fn take(&mut self) -> Option<Buffer> {
        self.staging.take()
    }
}

/// The first level that is no larger than a device takes, and its size.
fn base(layers: &Layers, side_px: u32) -> (u32, [u32; 2]) {
    let mut parts = layers.parts();
    let fits = |size_px: [u32; 2]| size_px.iter().all(|side| *side <= side_px);
    let first = parts.find(|part| fits(part.size_px));
    first.map_or((0, layers.size_px), |part| (part.level, part.size_px))
}

/// All rows of all layers and of the levels from this one on, in the order of the texels.
fn rows(layers: &Layers, base: u32) -> Vec<Rows> {
    let parts = layers.parts().filter(|part| part.level >= base);
    parts
        .map(|part| Rows {
            layer: part.layer,
            level: part.level - base,
            width: part.size_px[0],
            first: 0,
            count: part.size_px[1],
            offset: part.bytes.start as u64,
        })
        .collect()
}

/// Takes the first of these rows, as many as the budget has room for, and one at least.
fn due(left: &mut Vec<Rows>, budget: &mut u64) -> Vec<vk::BufferImageCopy> {
    let mut regions = Vec::new();
    let mut whole = 0;
    for rows in left.iter_mut() {
        let row_bytes = 4 * u64::from(rows.width);
        let room = *budget / row_bytes.max(1);
        let least = u64::from(regions.is_empty());
        let count = u32::try_from(room.max(least)).unwrap_or(u32::MAX);
        let count = count.min(rows.count);
        if count == 0 {
            break;
        }
        let bytes = row_bytes * u64::from(count);
        regions.push(region(&Rows { count, ..*rows }));
        *budget = budget.saturating_sub(bytes);
        rows.first += count;
        rows.count -= count;
        rows.offset += bytes;
        if rows.count > 0 {
            break;
        }
        whole += 1;
    }
    left.drain(..whole);
    regions
}

fn region(rows: &Rows) -> vk::BufferImageCopy {
    vk::BufferImageCopy::default()
        .buffer_offset(rows.offset)
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: rows.level,
            base_array_layer: rows.layer,
            layer_count: 1,
        })
        .image_offset(vk::Offset3D {
            x: 0,
            y: i32::try_from(rows.first).unwrap_or(0),
            z: 0,
        })
        .image_extent(vk::Extent3D {
            width: rows.width,
            height: rows.count,
            depth: 1,
        })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn rows_go_as_the_budget_allows_each_once() {
        let layers = Layers {
            size_px: [8, 4],
            count: 2,
            texels: Vec::new(),
        };
        let all = rows(&layers, 0);
        assert_eq!(all.len(), 8, "8 × 4, 4 × 2, 2 × 1 and 1 × 1, twice");
        // A device that takes no more than 2 a side.
        assert_eq!(base(&layers, 2), (2, [2, 1]));
        let small = rows(&layers, 2);
        assert_eq!((small.len(), small[0].level), (4, 0));
        assert_eq!(small[0].offset, 4 * (8 * 4 + 4 * 2));
        for budget in [1, 40, 100, 1000] {
            let mut left = all.clone();
            let mut seen = Vec::new();
            for _ in 0..100 {
                let mut budget = budget;
                let regions = due(&mut left, &mut budget);
                seen.extend(regions.iter().flat_map(|region| {
                    let place = region.image_subresource;
                    let first = region.image_offset.y;
                    let rows = 0..region.image_extent.height;
                    rows.map(move |row| {
                        let y = first.cast_unsigned() + row;
                        (place.base_array_layer, place.mip_level, y)
                    })
                }));
                if left.is_empty() {
                    break;
                }
            }
            let expected: Vec<_> = (0..2)
                .flat_map(|layer| {
                    let levels = [(0, 4), (1, 2), (2, 1), (3, 1)];
                    let of = move |(level, rows)| (0..rows).map(move |row| (layer, level, row));
                    levels.into_iter().flat_map(of)
                })
                .collect();
            assert_eq!(seen, expected, "{budget} bytes a frame");
        }
    }
}
