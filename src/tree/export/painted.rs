//! The surface of a drawing as one coloured mesh in memory: what stands on the stage many times over.
//!
//! Its triangles are those that a PLY file would hold. Bark has one colour, the mean of its picture: a tree that is seen from some metres away shows no plates.

use glam::Vec3;

use super::ply::eight_bits;
use super::surface::{Costs, Matter, standing};
use super::{ExportParams, Stand, TREE};
use crate::tree::TreeError;
use crate::tree::bark::Bark;
use crate::tree::organs::{Colour, Drawing, Numbers, bark_colour, from_bytes};

/// Triangles with a colour at each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedMesh {
    /// Metres, Y up.
    pub positions: Vec<Vec3>,
    /// Three vertices each, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// sRGB with alpha, of each vertex.
    pub colours: Vec<[u8; 4]>,
}

/// Bytes of a vertex with its share of triangles.
const VERTEX: u64 = 12 + 4 + 2 * 12;

/// Makes it, with so many corners a ring.
///
/// # Errors
/// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
pub fn painted(drawing: &Drawing, sides: u32) -> Result<PaintedMesh, TreeError> {
    let params = ExportParams { sides };
    let stand = Stand::of(TREE, &drawing.tree, &drawing.organs, &params);
    let costs = Costs {
        vertex: VERTEX,
        instance: 0,
        once: false,
    };
    let bark = opaque(mean(drawing.organs.bark));
    let mut mesh = PaintedMesh::default();
    for one in standing(&stand, "mesh", costs)? {
        for group in &one.surface.groups {
            let first = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
            // Nothing is written, so nothing fails.
            let _ = one
                .surface
                .each(group.matter, Numbers::ALL, |part, before| {
                    mesh.positions
                        .extend(part.positions.iter().map(|at| Vec3::from(*at)));
                    let (triangles, _) = part.indices.as_chunks::<3>();
                    let moved = |corner: u32| corner + before + first;
                    mesh.triangles
                        .extend(triangles.iter().map(|corners| corners.map(moved)));
                    match group.matter {
                        Matter::Bark => mesh.colours.resize(mesh.positions.len(), bark),
                        Matter::Painted(_) => {
                            mesh.colours
                                .extend(part.colours.iter().map(|of| opaque(*of)));
                        }
                    }
                    Ok(())
                });
        }
    }
    Ok(mesh)
}

fn opaque(colour: Colour) -> [u8; 4] {
    let [red, green, blue] = eight_bits(colour);
    [red, green, blue, u8::MAX]
}

/// The mean colour of a bark's picture.
fn mean(bark: Bark) -> Colour {
    let mut sum = [0.0_f32; 3];
    let mut count = 0.0_f32;
    // Each eighth pixel: no bark is so uneven that more would say another colour.
    for pixel in bark.maps().colour.pixels().step_by(8) {
        let [red, green, blue, _] = pixel.0;
        let colour = from_bytes([red, green, blue]);
        sum = std::array::from_fn(|at| sum[at] + colour[at]);
        count += 1.0;
    }
    if count == 0.0 {
        return bark_colour();
    }
    sum.map(|part| part / count)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::tree::organs::{Paint, Sphere};
    use crate::tree::{NO_PARENT, Node, Tree};

    #[test]
    fn a_tree_is_one_mesh_with_the_colours_of_its_bark_and_of_what_it_carries() {
        let mut drawing = Drawing {
            tree: Tree {
                letters: vec!["F".to_owned()],
                ..Tree::default()
            },
            ..Drawing::default()
        };
        for (parent, height) in [(NO_PARENT, 0.0), (0, 1.0), (1, 2.0)] {
            drawing.tree.push(Node {
                parent,
                position: Vec3::Y * height,
                radius: 0.1,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        drawing.organs.palette.set_colour(7, [0.0, 1.0, 0.0]);
        drawing.organs.spheres.push(Sphere {
            center: Vec3::Y * 2.0,
            radius: 0.3,
            paint: Paint {
                colour: 7,
                material: 1,
            },
            birth: 0,
            node: 2,
        });
        let mut pale = drawing.clone();
        pale.organs.bark = Bark::Birch;
        let [mesh, pale] = [drawing, pale].map(|drawing| painted(&drawing, 5).unwrap());
        assert_eq!(mesh.positions.len(), mesh.colours.len());
        let vertices = u32::try_from(mesh.positions.len()).unwrap();
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|corner| *corner < vertices)
        );
        let top = mesh.positions.iter().map(|at| at.y).fold(0.0, f32::max);
        assert!((top - 2.3).abs() < 0.01, "{top}");
        let green = |mesh: &PaintedMesh| {
            mesh.colours
                .iter()
                .filter(|of| **of == [0, 255, 0, 255])
                .count()
        };
        assert!(green(&mesh) > 20 && green(&mesh) == green(&pale));
        // The trunk is first: brown, and of a birch pale.
        let [brown, white] = [&mesh, &pale].map(|mesh| mesh.colours[0]);
        assert!(
            brown[0] > brown[2].saturating_add(10) && white[2] > brown[0],
            "{brown:?} {white:?}"
        );
    }

    #[test]
    fn nothing_is_refused() {
        assert!(painted(&Drawing::default(), 5).is_err());
    }
}
