//! Takes a tree's upload over: copies it piece by piece, binds what its shaders read, and shows it when all is there.

use std::sync::Arc;

use ash::vk;

use super::{Garbage, Renderer, whole_buffer};
use crate::mesh::{paint::Pixels, textured::Layers};
use crate::render::{
    error::RenderError, frame::Pool, gpu::Gpu, memory::Buffer, model_upload::write_set,
    texture::Texture, tree_upload::COPY_BYTES,
};
use crate::tree::bark::Bark;

impl Renderer {
    /// Copies the due part of the coming tree; true when it became the shown one.
    pub(super) fn copy_tree(&mut self, commands: vk::CommandBuffer) -> Result<bool, RenderError> {
        let Some(coming) = &mut self.coming else {
            return Ok(false);
        };
        if !coming.copy(&self.gpu, commands, COPY_BYTES) {
            return Ok(false);
        }
        let layout = self
            .pipelines
            .tree_layout
            .sets
            .get(1)
            .copied()
            .unwrap_or_default();
        let bark = coming.bark;
        let picture = match &self.bark {
            Some((known, picture)) if *known == bark => Arc::clone(picture),
            _ => {
                let (picture, staging) = bark_picture(&self.gpu, commands, bark)?;
                self.garbage
                    .extend(staging.map(|buffer| (self.frame, Garbage::Buffer(buffer))));
                picture
            }
        };
        let chunks = coming.chunks.len() + coming.organs.len() + coming.leaves.len();
        let count = u32::try_from(chunks).unwrap_or(u32::MAX).max(1);
        let pool = Pool::new(
            &self.gpu,
            2 * count,
            &[
                (vk::DescriptorType::STORAGE_BUFFER, 5 * count),
                (vk::DescriptorType::SAMPLED_IMAGE, count),
                (vk::DescriptorType::SAMPLER, count),
            ],
        )?;
        let image = [picture.described()];
        let repeated = self.pipelines.image_samplers.handles[0];
        let sampler = [vk::DescriptorImageInfo::default().sampler(repeated)];
        let looks = coming.looks.handle;
        // Only leaves have something at the corners' place: records stand there again.
        let tubes = coming.chunks.iter_mut().map(|chunk| {
            let records = chunk.records.handle;
            (&mut chunk.set, records, records)
        });
        let organs = coming.organs.iter_mut().map(|chunk| {
            let vertices = chunk.vertices.handle;
            (&mut chunk.set, vertices, vertices)
        });
        let leaves = coming.leaves.iter_mut().map(|chunk| {
            let records = chunk.crown.records.handle;
            (&mut chunk.crown.set, records, chunk.corners.handle)
        });
        for (set, first, second) in tubes.chain(organs).chain(leaves) {
            *set = pool.set(layout)?;
            let buffers = [first, second, looks].map(whole_buffer);
            let writes = [0, 1, 2].map(|binding| {
                vk::WriteDescriptorSet::default()
                    .dst_set(*set)
                    .dst_binding(binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .buffer_info(std::slice::from_ref(&buffers[binding as usize]))
            });
            let write = |binding: u32, kind, info| {
                vk::WriteDescriptorSet::default()
                    .dst_set(*set)
                    .dst_binding(binding)
                    .descriptor_type(kind)
                    .image_info(info)
            };
            let images = [
                write(3, vk::DescriptorType::SAMPLED_IMAGE, &image),
                write(4, vk::DescriptorType::SAMPLER, &sampler),
            ];
            // SAFETY: the set is new; buffers, image and sampler live as long as it.
            unsafe {
                self.gpu.device.update_descriptor_sets(&writes, &[]);
                self.gpu.device.update_descriptor_sets(&images, &[]);
            }
        }
        let choice = self.selection.crowns.layout.sets.get(1).copied();
        let choice = choice.unwrap_or_default();
        let leaves = coming.leaves.iter_mut().map(|chunk| &mut chunk.crown);
        for chunk in coming.chunks.iter_mut().chain(leaves) {
            chunk.choice = pool.set(choice)?;
            write_set(&self.gpu, chunk.choice, 0, &[&chunk.clusters, &chunk.kinds]);
        }
        // Known from here on: until now something could fail, and its copy would never be made.
        self.bark = Some((bark, Arc::clone(&picture)));
        coming.picture = Some(picture);
        coming.pool = Some(pool);
        self.garbage.extend(
            coming
                .take_staging()
                .map(|buffer| (self.frame, Garbage::Buffer(buffer))),
        );
        let before = coming.take_before();
        let before = before.map(|before| (self.frame, Garbage::Resident(before)));
        self.garbage.extend(before);
        self.came = self.frame;
        self.sent = coming.sent();
        if let Some(old) = std::mem::replace(&mut self.tree, self.coming.take()) {
            self.garbage.push((self.frame, Garbage::Tree(old)));
        }
        Ok(true)
    }
}

/// A bark's picture on the device once these commands are done, and the memory that they copy it from.
fn bark_picture(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    bark: Bark,
) -> Result<(Arc<Texture>, Option<Buffer>), RenderError> {
    let colour = &bark.maps().colour;
    let layers = Layers::of(Pixels {
        size_px: [colour.width(), colour.height()],
        rgba: colour.as_raw().clone(),
    });
    let mut picture = Texture::new(gpu, ["the bark", "the bark on its way"], &layers)?;
    let mut all = u64::MAX;
    picture.copy(gpu, commands, &mut all);
    let staging = picture.take();
    Ok((Arc::new(picture), staging))
}
