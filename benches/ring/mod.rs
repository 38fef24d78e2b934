//! A surface of 1.3 million triangles and writers of it, which the benches of readers here and beside other programs share.

use std::f32::consts::TAU;
use std::io::Write;

use glam::Vec3;
use ramus::mesh::Mesh;

/// Corners around the ring, and along it: two triangles for each pair.
const AROUND: u32 = 650;
const ALONG: u32 = 1000;

/// A bent tube that closes, uneven so that no two coordinates agree.
pub(crate) fn ring() -> Mesh {
    let mut ring = Mesh::default();
    for along in 0..ALONG {
        let turn = along as f32 / ALONG as f32 * TAU;
        for around in 0..AROUND {
            let angle = around as f32 / AROUND as f32 * TAU;
            let radius = 10.0 + (5.0 * turn).sin() + 0.3 * (7.0 * angle + turn).cos();
            let from_middle = 60.0 + radius * angle.cos();
            ring.positions.push(Vec3::new(
                from_middle * turn.cos(),
                from_middle * turn.sin(),
                radius * angle.sin(),
            ));
            let next = (along + 1) % ALONG * AROUND;
            let beside = (around + 1) % AROUND;
            let here = along * AROUND;
            let quad = [here + around, next + around, next + beside, here + beside];
            ring.triangles.push([quad[0], quad[1], quad[2]]);
            ring.triangles.push([quad[0], quad[2], quad[3]]);
        }
    }
    ring
}

fn ply_header(to: &mut impl Write, ring: &Mesh, format: &str) {
    write!(
        to,
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        ring.positions.len(),
        ring.triangles.len()
    )
    .unwrap();
}

pub(crate) fn ascii_ply(to: &mut impl Write, ring: &Mesh) {
    ply_header(to, ring, "ascii");
    for Vec3 { x, y, z } in &ring.positions {
        writeln!(to, "{x} {y} {z}").unwrap();
    }
    for [a, b, c] in &ring.triangles {
        writeln!(to, "3 {a} {b} {c}").unwrap();
    }
}

/// The arrays of a VTP file: points, connectivity and offsets, as bytes.
fn vtp_arrays(ring: &Mesh) -> [Vec<u8>; 3] {
    let points = ring.positions.iter().flat_map(|point| point.to_array());
    let corners = ring.triangles.as_flattened().iter();
    let ends = (1..=ring.triangles.len()).map(|triangle| 3 * triangle as i64);
    [
        points.flat_map(f32::to_le_bytes).collect(),
        corners
            .flat_map(|&corner| i64::from(corner).to_le_bytes())
            .collect(),
        ends.flat_map(i64::to_le_bytes).collect(),
    ]
}

/// A VTP file with its arrays behind it, each as `stored` makes it of its bytes.
pub(crate) fn vtp(
    to: &mut impl Write,
    ring: &Mesh,
    compressor: &str,
    stored: fn(&[u8]) -> Vec<u8>,
) {
    let arrays = vtp_arrays(ring).map(|array| stored(&array));
    let second = arrays[0].len();
    let third = second + arrays[1].len();
    write!(
        to,
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"{compressor}\">\n<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<Points><DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n<Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"appended\" offset=\"{second}\"/><DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"{third}\"/></Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">_",
        ring.positions.len(),
        ring.triangles.len()
    )
    .unwrap();
    for array in arrays {
        to.write_all(&array).unwrap();
    }
    writeln!(to, "</AppendedData></VTKFile>").unwrap();
}

pub(crate) fn raw_vtp(to: &mut impl Write, ring: &Mesh) {
    vtp(to, ring, "", |array| {
        [&(array.len() as u64).to_le_bytes(), array].concat()
    });
}

/// A legacy VTK file up to its cells.
fn vtk_points(to: &mut impl Write, ring: &Mesh, version: &str) {
    let points = ring.positions.len();
    writeln!(
        to,
        "# vtk DataFile Version {version}\nring\nBINARY\nDATASET POLYDATA\nPOINTS {points} float"
    )
    .unwrap();
    for value in ring.positions.iter().flat_map(|point| point.to_array()) {
        to.write_all(&value.to_be_bytes()).unwrap();
    }
}

/// A legacy VTK file whose cells are lists, as they were up to version 5.0.
pub(crate) fn binary_vtk(to: &mut impl Write, ring: &Mesh) {
    let triangles = ring.triangles.len();
    vtk_points(to, ring, "3.0");
    writeln!(to, "\nPOLYGONS {triangles} {}", 4 * triangles).unwrap();
    for [a, b, c] in &ring.triangles {
        for value in [3, *a, *b, *c] {
            to.write_all(&value.to_be_bytes()).unwrap();
        }
    }
}

/// A legacy VTK file with offsets, as VTK has written them since version 5.1.
pub(crate) fn new_binary_vtk(to: &mut impl Write, ring: &Mesh) {
    let triangles = ring.triangles.len() as i64;
    vtk_points(to, ring, "5.1");
    writeln!(
        to,
        "\nPOLYGONS {} {}\nOFFSETS vtktypeint64",
        triangles + 1,
        3 * triangles
    )
    .unwrap();
    for triangle in 0..=triangles {
        to.write_all(&(3 * triangle).to_be_bytes()).unwrap();
    }
    writeln!(to, "\nCONNECTIVITY vtktypeint64").unwrap();
    for &corner in ring.triangles.as_flattened() {
        to.write_all(&i64::from(corner).to_be_bytes()).unwrap();
    }
}
