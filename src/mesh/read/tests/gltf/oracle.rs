//! The same files through other readers: the crate `gltf`'s own, and Ramus's trees as they were written.

use super::*;
use crate::tree::export::{ExportParams, glb};
use crate::tree::{NO_PARENT, Node, Tree};

/// Positions and triangles as the crate reads well-formed files.
fn by_the_crate(bytes: &[u8]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let gltf = ::gltf::Gltf::from_slice(bytes).unwrap();
    let blob = gltf.blob.clone().unwrap();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut open: Vec<_> = gltf.default_scene().unwrap().nodes().collect();
    open.reverse();
    let mut open: Vec<_> = open
        .into_iter()
        .map(|node| (node, glam::DMat4::IDENTITY))
        .collect();
    while let Some((node, above)) = open.pop() {
        let local = node.transform().matrix();
        let place = above * glam::Mat4::from_cols_array_2d(&local).as_dmat4();
        for primitive in node
            .mesh()
            .into_iter()
            .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>())
        {
            let reader = primitive.reader(|_| Some(&blob));
            let start = positions.len() as u32;
            let points = reader.read_positions().unwrap();
            positions.extend(points.map(|point| {
                place
                    .transform_point3(Vec3::from(point).as_dvec3())
                    .as_vec3()
            }));
            let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            triangles.extend(
                corners
                    .chunks_exact(3)
                    .map(|all| [0, 1, 2].map(|at| start + all[at])),
            );
        }
        let children: Vec<_> = node.children().collect();
        open.extend(children.into_iter().rev().map(|child| (child, place)));
    }
    (positions, triangles)
}

fn assert_as_the_crate_has_it(bytes: &[u8]) -> Model {
    let model = read(bytes).unwrap();
    let (positions, triangles) = by_the_crate(bytes);
    assert_eq!(model.mesh.triangles, triangles);
    assert_eq!(model.mesh.positions.len(), positions.len());
    let origin = model.mesh.origin.as_vec3();
    for (found, expected) in model.mesh.positions.iter().zip(positions) {
        let apart = (*found + origin).distance(expected);
        assert!(
            apart <= 1e-6 * (1.0 + expected.length()),
            "{found} is not {expected}"
        );
    }
    model
}

#[test]
fn scenes_are_as_another_reader_has_them() {
    let mut made = Made::new();
    let mesh = made.pyramid();
    let other = made.pyramid();
    for accessor in made.json["accessors"].as_array_mut().unwrap() {
        // That reader asks for them.
        if accessor["type"] == "VEC3" {
            accessor["min"] = json!([-1, -1, 0]);
            accessor["max"] = json!([1, 1, 1.5]);
        }
    }
    made.json["scenes"] = json!([{ "nodes": [0, 3] }]);
    made.json["scene"] = json!(0);
    made.json["nodes"] = json!([
        { "mesh": mesh, "children": [1, 2], "translation": [1, 2, 3] },
        { "mesh": other, "rotation": [0.0, 0.6, 0.0, 0.8] },
        { "mesh": mesh, "scale": [2, 3, 4], "rotation": [0.6, 0.0, 0.0, 0.8], "translation": [0.5, 0, 0] },
        { "mesh": other, "matrix": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 7, 8, 9, 1] },
    ]);
    let model = assert_as_the_crate_has_it(&made.glb());
    assert_eq!(model.mesh.triangles.len(), 24);
}

#[test]
fn trees_that_were_exported_come_back() {
    let mut tree = Tree {
        letters: vec!["F".into()],
        ..Tree::default()
    };
    for (parent, position, radius) in [
        (NO_PARENT, Vec3::ZERO, 0.1),
        (0, Vec3::Y, 0.08),
        (1, Vec3::new(0.5, 1.6, 0.0), 0.05),
        (1, Vec3::new(-0.4, 1.7, 0.2), 0.04),
    ] {
        tree.push(Node {
            parent,
            position,
            radius,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    let bytes = glb(&tree, &ExportParams::default()).unwrap();
    let model = assert_as_the_crate_has_it(&bytes);
    assert!(
        model.mesh.triangles.len() > 20,
        "{}",
        model.mesh.triangles.len()
    );
    let paint = model.paint.unwrap();
    assert_eq!(paint.texture_coordinates.len(), model.mesh.positions.len());
    assert_eq!(paint.materials[0].name, "bark");
    let texture = paint.materials[0].base_colour_image.unwrap();
    let image = &paint.images[texture.image as usize];
    let pixels = image.decode(&Default::default()).unwrap();
    assert_eq!(pixels.size_px, image.size_px);
    assert!(model.remarks.is_empty(), "{:?}", model.remarks);
}
