//! Times of models read from files, each of 1.3 million triangles. `cargo bench --bench mesh [-- NAME]`
//!
//! The files are written into a folder that goes away, and stand in the system's cache when they are read.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error; the surface is made with single precision"
)]

mod ring;

use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use ramus::mesh::display::Display;
use ramus::mesh::write::WriteFormat;
use ramus::mesh::{self, Mesh, ReadLimits};
use ring::{ascii_ply, binary_vtk, new_binary_vtk, raw_vtp, ring, vtp};

fn binary_ply(to: &mut BufWriter<File>, ring: &Mesh) {
    WriteFormat::Ply.write(ring, to).unwrap();
}

fn binary_stl(to: &mut BufWriter<File>, ring: &Mesh) {
    WriteFormat::Stl.write(ring, to).unwrap();
}

fn obj(to: &mut BufWriter<File>, ring: &Mesh) {
    WriteFormat::Obj.write(ring, to).unwrap();
}

fn glb(to: &mut BufWriter<File>, ring: &Mesh) {
    WriteFormat::Glb.write(ring, to).unwrap();
}

fn ascii_stl(to: &mut impl Write, ring: &Mesh) {
    writeln!(to, "solid ring").unwrap();
    for triangle in &ring.triangles {
        writeln!(to, "  facet normal 0 0 0\n    outer loop").unwrap();
        for corner in triangle {
            let Vec3 { x, y, z } = ring.positions[*corner as usize];
            writeln!(to, "      vertex {x} {y} {z}").unwrap();
        }
        writeln!(to, "    endloop\n  endfacet").unwrap();
    }
    writeln!(to, "endsolid ring").unwrap();
}

fn zlib_vtp(to: &mut impl Write, ring: &Mesh) {
    /// Bytes of a block, as VTK has them.
    const BLOCK: usize = 32 << 10;
    vtp(to, ring, "vtkZLibDataCompressor", |array| {
        let blocks = array.chunks(BLOCK).map(|block| {
            let mut room = vec![0; block.len() + 256];
            let config = zlib_rs::DeflateConfig::default();
            zlib_rs::compress_slice(&mut room, block, config).0.to_vec()
        });
        let blocks: Vec<Vec<u8>> = blocks.collect();
        let header = [blocks.len(), BLOCK, array.len() % BLOCK];
        let header = header.into_iter().chain(blocks.iter().map(Vec::len));
        let mut stored: Vec<u8> = header
            .flat_map(|word| (word as u64).to_le_bytes())
            .collect();
        stored.extend(blocks.concat());
        stored
    });
}

fn ascii_vtk(to: &mut impl Write, ring: &Mesh) {
    let (points, triangles) = (ring.positions.len(), ring.triangles.len());
    writeln!(
        to,
        "# vtk DataFile Version 3.0\nring\nASCII\nDATASET POLYDATA\nPOINTS {points} float"
    )
    .unwrap();
    for Vec3 { x, y, z } in &ring.positions {
        writeln!(to, "{x} {y} {z}").unwrap();
    }
    writeln!(to, "POLYGONS {triangles} {}", 4 * triangles).unwrap();
    for [a, b, c] in &ring.triangles {
        writeln!(to, "3 {a} {b} {c}").unwrap();
    }
}

/// Writes the ring in a format.
type Writer = fn(&mut BufWriter<File>, &Mesh);

fn written(folder: &Path, name: &str, ring: &Mesh, write: Writer) -> PathBuf {
    let path = folder.join(name);
    let mut to = BufWriter::new(File::create(&path).unwrap());
    write(&mut to, ring);
    to.flush().unwrap();
    path
}

fn read_benches(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let ring = ring();
    let mut group = criterion.benchmark_group("read");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(4))
        .throughput(Throughput::Elements(ring.triangles.len() as u64));
    let formats: [(&str, &str, Writer); 11] = [
        ("binary PLY", "binary PLY", binary_ply),
        ("ASCII PLY", "ASCII PLY", ascii_ply),
        ("binary STL", "binary STL", binary_stl),
        ("ASCII STL", "ASCII STL", ascii_stl),
        ("OBJ", "OBJ", obj),
        ("GLB", "GLB", glb),
        ("raw VTP", "VTP", raw_vtp),
        ("zlib VTP", "VTP", zlib_vtp),
        ("binary VTK", "legacy VTK", binary_vtk),
        ("binary VTK 5.1", "legacy VTK", new_binary_vtk),
        ("ASCII VTK", "legacy VTK", ascii_vtk),
    ];
    for (name, format, write) in formats {
        let path = written(folder.path(), &name.replace(' ', "-"), &ring, write);
        let never = AtomicBool::new(false);
        let limits = ReadLimits::default();
        let model = mesh::read(&path, &limits, &never).unwrap();
        assert_eq!(model.format.to_string(), format);
        assert_eq!(model.mesh.triangles.len(), ring.triangles.len());
        assert_eq!(model.mesh.positions.len(), ring.positions.len());
        group.bench_function(name, |bencher| {
            bencher.iter_with_large_drop(|| mesh::read(black_box(&path), &limits, &never).unwrap());
        });
        // Vertices of one place joined, normals, box: all that a picture needs.
        group.bench_function(format!("{name}, ready to draw"), |bencher| {
            bencher.iter_with_large_drop(|| {
                let model = mesh::read(black_box(&path), &limits, &never).unwrap();
                Display::bare(Arc::new(model.mesh), &never).unwrap()
            });
        });
        std::fs::remove_file(path).unwrap();
    }
    group.finish();
}

criterion_group!(benches, read_benches);
criterion_main!(benches);
