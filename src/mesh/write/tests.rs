//! Files read back, by our own readers and by one that we did not write.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::sync::atomic::AtomicBool;

use super::*;
use crate::mesh::{Format, ReadLimits, made, read_bytes};

fn written(mesh: &Mesh, format: WriteFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    format.check(mesh).unwrap();
    format.write(mesh, &mut bytes).unwrap();
    bytes
}

#[test]
fn what_is_written_is_read_again() {
    let near = made::torus(9, 7);
    let far = Mesh {
        origin: DVec3::new(4_000_000.125, -700_000.5, 0.0),
        ..made::torus(9, 7)
    };
    for mesh in [&near, &far] {
        for (format, read_as) in [
            (WriteFormat::Ply, Format::BinaryPly),
            (WriteFormat::Obj, Format::Obj),
            (WriteFormat::Stl, Format::BinaryStl),
        ] {
            let bytes = written(mesh, format);
            let model =
                read_bytes(&bytes, &ReadLimits::default(), &AtomicBool::new(false)).unwrap();
            assert_eq!(model.format, read_as);
            let known_exactly = format != WriteFormat::Stl || mesh.origin == DVec3::ZERO;
            let within = if known_exactly { 0.0 } else { 0.5 };
            for (face, again) in mesh.triangles.iter().zip(&model.mesh.triangles) {
                for (vertex, other) in face.iter().zip(again) {
                    let [one, other] = [
                        place(mesh, mesh.positions[*vertex as usize]),
                        place(&model.mesh, model.mesh.positions[*other as usize]),
                    ];
                    assert!(
                        one.distance(other) <= within + 1e-6,
                        "{format:?}: {one} {other}"
                    );
                }
            }
            assert_eq!(model.mesh.triangles.len(), mesh.triangles.len());
        }
    }
}

#[test]
fn glb_is_what_another_reader_takes_for_the_mesh() {
    let mesh = Mesh {
        origin: DVec3::new(1000.0, 0.0, -2.0),
        ..made::cube()
    };
    let bytes = written(&mesh, WriteFormat::Glb);
    assert!(bytes.len().is_multiple_of(4));
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let node = file.nodes().next().unwrap();
    assert_eq!(node.transform().decomposed().0, [1000.0, 0.0, -2.0]);
    let primitive = node.mesh().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
    assert_eq!(positions, mesh.positions);
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, mesh.triangles.as_flattened());
}

#[test]
fn endings_tell_the_format_whatever_their_case() {
    for (name, format) in [
        ("a.glb", WriteFormat::Glb),
        ("a.PLY", WriteFormat::Ply),
        ("b/a.b.Stl", WriteFormat::Stl),
        ("a.obj", WriteFormat::Obj),
    ] {
        assert_eq!(WriteFormat::of(Path::new(name)), Ok(format));
    }
    for name in ["a", "a.vtk", "obj", ""] {
        assert!(WriteFormat::of(Path::new(name)).is_err());
    }
}
