//! PLY, the format of scanners: <https://paulbourke.net/dataformats/ply/>.
//!
//! A header names elements in any order, each with properties of any number type or lists of them. What is wanted are the vertices'
//! `x y z` and colours, and the faces' `vertex_indices`; all else is passed over. Two ways lead through the body: one walks from value to value
//! and takes anything (`rows`), the other looks at rows of one size on all cores (`same_size`, in text by `numerals`) and gives up where they are not, or
//! where anything is wrong: then the first goes through the same rows and finds the place.

mod colours;
mod header;
mod rows;
mod same_size;

use super::points::{Coordinate, mesh};
use super::{Stop, Surface, Task};
use header::{Body, Header, Role};
use rows::{Binary, Faces, Source, Text, Vertices};

use crate::mesh::paint::Paint;

/// Reads a PLY file.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let header = header::read(bytes, task)?;
    if header.has_doubles() {
        read_as::<f64>(bytes, &header, task)
    } else {
        read_as::<f32>(bytes, &header, task)
    }
}

fn read_as<C: Coordinate>(bytes: &[u8], header: &Header, task: &Task<'_>) -> Result<Surface, Stop> {
    match header.body {
        Body::Text => elements::<C, _>(Text::new(bytes, header.end), header, task),
        Body::Binary { is_big } => {
            elements::<C, _>(Binary::new(bytes, header.end, is_big), header, task)
        }
    }
}

/// Reads element after element.
fn elements<C: Coordinate, S: Source>(
    mut source: S,
    header: &Header,
    task: &Task<'_>,
) -> Result<Surface, Stop> {
    let mut all: Vertices<C> = Vertices::default();
    let mut faces = Faces::default();
    let vertices = header.vertices();
    for element in &header.elements {
        source.check_room(element)?;
        match element.role {
            Role::Vertices(axes) => {
                task.check_vertices(vertices)?;
                let quick = source.same_size_points(element, axes, task)?;
                all = match quick {
                    Some(vertices) => vertices,
                    None => rows::points(&mut source, element, axes, task)?,
                };
            }
            Role::Faces(list) => {
                let quick = source.same_size_faces(element, list, vertices, task)?;
                faces = match quick {
                    Some(triangles) => Faces {
                        triangles,
                        skipped: 0,
                    },
                    None => rows::faces(&mut source, element, list, vertices, task)?,
                };
            }
            Role::Other => rows::skip(&mut source, element, task)?,
        }
    }
    Ok(Surface {
        mesh: mesh(all.points, faces.triangles),
        skipped_faces: faces.skipped,
        paint: (!all.colours.is_empty()).then(|| Paint {
            colours: all.colours,
            ..Paint::default()
        }),
        ..Surface::default()
    })
}
