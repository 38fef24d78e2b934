//! Images (§3.8.2) as they stand in a buffer, in the text, or in a file beside the model.
//!
//! Only those that are shown are taken. What cannot be had or is no image is remarked on, and the surface has its plain colour. Two
//! images may be the same bytes of a buffer, so those are taken once, and all together they may be no longer than what was read.

use std::collections::BTreeMap;
use std::sync::Arc;

use ::gltf::json::Root;

use super::super::Stop;
use super::buffers::{Buffers, decoded, is_data};
use super::elements::view_bytes;
use super::folder::{Folder, Refusal};
use super::{Remarks, shown};
use crate::mesh::paint::{Image, ImageLimits};

/// Images of a file as they are asked for.
pub(super) struct Images<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    folder: &'a Folder<'a>,
    /// Images by their number in the file; None where one cannot be shown.
    numbers: BTreeMap<usize, Option<u32>>,
    views: BTreeMap<usize, Arc<Vec<u8>>>,
    /// Bytes that were taken from buffers.
    taken: usize,
    pub(super) images: Vec<Image>,
}

impl<'a> Images<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, folder: &'a Folder<'a>) -> Self {
        Self {
            root,
            buffers,
            folder,
            numbers: BTreeMap::new(),
            views: BTreeMap::new(),
            taken: 0,
            images: Vec::new(),
        }
    }

    /// Which of the images is the one of this number in the file.
    pub(super) fn number(
        &mut self,
        number: usize,
        remarks: &mut Remarks,
    ) -> Result<Option<u32>, Stop> {
        if let Some(found) = self.numbers.get(&number) {
            return Ok(*found);
        }
        let found = match self.image(number) {
            Ok(image) => {
                self.images.push(image);
                u32::try_from(self.images.len() - 1).ok()
            }
            Err(Refusal::Cancelled) => return Err(Stop::Cancelled),
            Err(Refusal::Problem(problem)) => {
                remarks.add(problem);
                None
            }
        };
        self.numbers.insert(number, found);
        Ok(found)
    }

    fn image(&mut self, number: usize) -> Result<Image, Refusal> {
        let Some(image) = self.root.images.get(number) else {
            return Err(Refusal::Problem(format!("image {number} is not there")));
        };
        let name = image.name.as_deref().filter(|name| !name.is_empty());
        let name = name.map_or_else(|| number.to_string(), shown);
        let about = |refusal| match refusal {
            Refusal::Problem(problem) => Refusal::Problem(format!("image {name} {problem}")),
            cancelled => cancelled,
        };
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) if is_data(uri) => decoded(uri.clone())
                .map(Arc::new)
                .map_err(|problem| about(Refusal::Problem(problem)))?,
            (Some(uri), _) => Arc::new(self.folder.file(uri).map_err(about)?.to_vec()),
            (None, Some(view)) => self.of_view(view.value()).map_err(about)?,
            (None, None) => {
                return Err(about(Refusal::Problem("has no bytes in the file".into())));
            }
        };
        Image::new(name.clone(), bytes, &ImageLimits::default())
            .map_err(|fault| Refusal::Problem(fault.to_string()))
    }

    fn of_view(&mut self, view: usize) -> Result<Arc<Vec<u8>>, Refusal> {
        if let Some(bytes) = self.views.get(&view) {
            return Ok(bytes.clone());
        }
        let bytes = view_bytes(self.root, self.buffers, view).map_err(|stop| match stop {
            Stop::Cancelled => Refusal::Cancelled,
            _ => Refusal::Problem(format!(
                "is in buffer view {view}, which is not in the file"
            )),
        })?;
        let (bytes, _) = bytes;
        self.taken += bytes.len();
        if self.taken > self.buffers.length() {
            return Err(Refusal::Problem(
                "stands on other images' bytes: save the file again".into(),
            ));
        }
        let bytes = Arc::new(bytes.to_vec());
        self.views.insert(view, bytes.clone());
        Ok(bytes)
    }
}
