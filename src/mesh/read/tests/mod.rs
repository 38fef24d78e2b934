//! All formats through the front door: good files of every kind, hostile ones, mutated ones, the models of other programs.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test that fails shows the line; test files are small"
)]

mod gltf;
mod hostile;
mod models;
mod obj;
mod ply;
mod stl;
mod swc;
mod vtk;

use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::*;

/// Reads with the usual limits and never cancelled.
fn read(bytes: &[u8]) -> Result<Model, MeshError> {
    read_bytes(bytes, &ReadLimits::default(), &AtomicBool::new(false))
}

/// What a fault is told as.
fn fault(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// Triangles by their corners' coordinates.
fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let origin = mesh.origin.as_vec3();
    let corner = |number: u32| mesh.positions[number as usize] + origin;
    let triangles = mesh.triangles.iter();
    triangles.map(|triangle| triangle.map(corner)).collect()
}

/// A pyramid with a square foot: four triangles and a polygon.
const POINTS: [[f32; 3]; 5] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, 0.0, 1.5],
];
const FACES: [&[u32]; 5] = [
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
    &[3, 2, 1, 0],
];
const TRIANGLES: [[u32; 3]; 6] = [
    [0, 1, 4],
    [1, 2, 4],
    [2, 3, 4],
    [3, 0, 4],
    [3, 2, 1],
    [3, 1, 0],
];

/// That a model is the pyramid with its vertices in the file's order.
fn assert_pyramid(model: &Model, told: &str) {
    assert_eq!(model.mesh.triangles, TRIANGLES, "{told}");
    assert_eq!(model.mesh.positions, POINTS.map(Vec3::from), "{told}");
}

/// The pyramid in each format.
fn pyramids() -> Vec<(Format, Vec<u8>)> {
    vec![
        (Format::AsciiPly, ply::ascii()),
        (Format::BinaryPly, ply::binary(ply::Kinds::default(), false)),
        (Format::AsciiStl, stl::ascii()),
        (Format::BinaryStl, stl::binary()),
        (Format::Obj, obj::text()),
        (Format::Gltf, gltf::made::Made::with_pyramid().gltf()),
        (Format::Glb, gltf::made::Made::with_pyramid().glb()),
        (Format::Vtp, vtk::xml()),
        (Format::Vtp, vtk::zlib()),
        (Format::Vtk, vtk::legacy::file(true, false, "double")),
        (Format::Vtk, vtk::legacy::file(false, true, "float")),
    ]
}
