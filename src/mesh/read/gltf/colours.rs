//! What stands at the vertices beside their positions: texture coordinates and colours.
//!
//! Where an accessor of them is damaged or of another length its vertices have none, which is remarked on.

use std::collections::BTreeMap;
use std::sync::Arc;

use ::gltf::json::accessor::ComponentType;
use glam::Vec2;

use super::super::points::narrow;
use super::super::{Stop, with_room};
use super::Remarks;
use super::elements::{Accessors, Elements, Number, by_number};
use super::rows::extend;
use super::shape::Block;
use super::surface::Source;
use crate::mesh::paint::{VertexColour, WHITE};
use crate::mesh::srgb::short;

/// Which accessor of a block is meant.
type Which = fn(&Block) -> Option<usize>;

/// Elements of blocks, by their accessor.
type Columns<'a> = BTreeMap<usize, Arc<Elements<'a>>>;

/// Texture coordinates of all vertices; empty where none has any.
pub(super) fn texture_coordinates(
    source: &Source<'_>,
    accessors: &Accessors<'_>,
    remarks: &mut Remarks,
) -> Result<Vec<Vec2>, Stop> {
    fn read<N: Number>(elements: &Elements<'_>, row: usize) -> Vec2 {
        let [u, v] = elements.row::<N, 2>(row);
        let place = Vec2::new(narrow(u), narrow(v));
        if place.is_finite() { place } else { Vec2::ZERO }
    }
    let which: Which = |block| block.texture_coordinates;
    let columns = columns(
        source,
        accessors,
        which,
        "texture coordinates",
        2..=2,
        remarks,
    )?;
    fill(source, &columns, which, Vec2::ZERO, |elements, row| {
        by_number!(elements.layout.kind, read::<_>(elements, row))
    })
}

/// Colours of all vertices; empty where none has any.
pub(super) fn colours(
    source: &Source<'_>,
    accessors: &Accessors<'_>,
    remarks: &mut Remarks,
) -> Result<Vec<VertexColour>, Stop> {
    fn read<N: Number>(elements: &Elements<'_>, row: usize) -> VertexColour {
        let [red, green, blue, alpha] = elements.row::<N, 4>(row);
        [red, green, blue, alpha].map(short)
    }
    fn read_opaque<N: Number>(elements: &Elements<'_>, row: usize) -> VertexColour {
        let [red, green, blue] = elements.row::<N, 3>(row);
        [red, green, blue, 1.0].map(short)
    }
    let which: Which = |block| block.colours;
    let columns = columns(source, accessors, which, "colours", 3..=4, remarks)?;
    fill(source, &columns, which, WHITE, |elements, row| {
        let kind = elements.layout.kind;
        match elements.layout.columns {
            4 => by_number!(kind, read::<_>(elements, row)),
            _ => by_number!(kind, read_opaque::<_>(elements, row)),
        }
    })
}

fn columns<'a>(
    source: &Source<'_>,
    accessors: &Accessors<'a>,
    which: Which,
    what: &str,
    wanted: std::ops::RangeInclusive<usize>,
    remarks: &mut Remarks,
) -> Result<Columns<'a>, Stop> {
    let mut columns = BTreeMap::new();
    for block in source.shapes().flat_map(|shape| &shape.blocks) {
        let Some(number) = which(block) else { continue };
        match accessors.get(number) {
            Ok(elements)
                if elements.layout.rows == block.vertices
                    && elements.layout.kind != ComponentType::U32
                    && wanted.contains(&elements.layout.columns) =>
            {
                columns.insert(number, elements);
            }
            Err(Stop::Cancelled) => return Err(Stop::Cancelled),
            // For one block it may be of the right length and for another of the wrong one.
            _ => {
                columns.remove(&number);
                remarks.add(format!(
                    "the {what} in accessor {number} are damaged and not shown"
                ));
            }
        }
    }
    Ok(columns)
}

fn fill<T: Copy + Send + Sync>(
    source: &Source<'_>,
    columns: &Columns<'_>,
    which: Which,
    none: T,
    read: impl Fn(&Elements<'_>, usize) -> T + Sync + Send,
) -> Result<Vec<T>, Stop> {
    if columns.is_empty() {
        return Ok(Vec::new());
    }
    let mut all = with_room(source.size.vertices)?;
    source.each(|ready, _| {
        for block in &ready.shape.blocks {
            match which(block).and_then(|number| columns.get(&number)) {
                Some(elements) => {
                    extend(&mut all, block.vertices, source.task, |row| {
                        read(elements, row)
                    })?;
                }
                None => all.resize(all.len() + block.vertices, none),
            }
        }
        Ok(())
    })?;
    Ok(all)
}
