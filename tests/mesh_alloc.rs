//! What reading a model takes from the allocator at most beside the file's bytes: a small multiple of the mesh, and for files that
//! announce what they do not hold next to nothing.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "a test that fails shows the line; its files are small"
)]

#[path = "counting/peak.rs"]
mod peak;

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use ramus::mesh::{Mesh, MeshError, Model, ReadLimits, read_bytes};

/// Corners around a tube, and along it.
const AROUND: u32 = 200;
const ALONG: u32 = 1500;

/// Where tests share a process they take turns.
static TURN: Mutex<()> = Mutex::new(());

/// Reads, and says how many bytes were taken at most.
fn measured(bytes: &[u8]) -> (Result<Model, MeshError>, usize) {
    rayon::join(|| (), || ()); // the pool's threads are there before it is measured
    let before = peak::restart();
    let read = read_bytes(bytes, &ReadLimits::default(), &AtomicBool::new(false));
    (read, peak::most() - before)
}

fn size(mesh: &Mesh) -> usize {
    size_of_val(mesh.positions.as_slice()) + size_of_val(mesh.triangles.as_slice())
}

fn takes_little(name: &str, bytes: &[u8]) {
    let (read, taken) = measured(bytes);
    let size = size(&read.unwrap().mesh);
    let ratio = taken as f64 / size as f64;
    println!("{name}: {taken} bytes for a mesh of {size}, {ratio:.2} times");
    assert!(ratio <= 2.5, "{name} takes {ratio:.2} times its mesh");
}

fn point(number: u32) -> [f32; 3] {
    let angle = (number % AROUND) as f32 / AROUND as f32 * std::f32::consts::TAU;
    [angle.cos(), (number / AROUND) as f32 * 0.01, angle.sin()]
}

fn triangles() -> Vec<[u32; 3]> {
    let quads = (0..AROUND * (ALONG - 1)).map(|here| {
        let beside = here - here % AROUND + (here + 1) % AROUND;
        [here, beside, here + AROUND, beside + AROUND]
    });
    quads
        .flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]])
        .collect()
}

fn ply(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        AROUND * ALONG,
        triangles().len()
    )
}

#[test]
fn ply_takes_little() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut text = ply("ascii").replace("float", "double");
    let mut bytes = ply("binary_little_endian").into_bytes();
    for point in (0..AROUND * ALONG).map(point) {
        writeln!(text, "{} {} {}", point[0], point[1], point[2]).unwrap();
        bytes.extend(point.map(f32::to_le_bytes).as_flattened());
    }
    for [a, b, c] in triangles() {
        writeln!(text, "3 {a} {b} {c}").unwrap();
        bytes.push(3);
        bytes.extend([a, b, c].map(u32::to_le_bytes).as_flattened());
    }
    takes_little("ASCII PLY of doubles", text.as_bytes());
    takes_little("binary PLY", &bytes);
}

#[test]
fn stl_takes_little() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let triangles = triangles();
    let surface = triangles.iter().map(|triangle| triangle.map(point));
    stl("a surface", surface);
    // No two triangles share a corner, and text has double precision: the worst that may come, and no surface.
    let soup = (0..triangles.len()).map(|number| {
        [0.0, 1.0, 2.0].map(|corner| [corner, number as f32, number as f32 * corner])
    });
    stl("a soup", soup);
}

fn stl(name: &str, triangles: impl ExactSizeIterator<Item = [[f32; 3]; 3]>) {
    let mut text = "solid\n".to_owned();
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            bytes.extend([x, y, z].map(f32::to_le_bytes).as_flattened());
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        bytes.extend([0; 2]);
        text += "endloop\nendfacet\n";
    }
    text += "endsolid\n";
    takes_little(&format!("binary STL of {name}"), &bytes);
    takes_little(&format!("ASCII STL of {name}"), text.as_bytes());
}

#[test]
fn obj_takes_little() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let count = AROUND * ALONG;
    let mut text = String::new();
    for [x, y, z] in (0..count).map(point) {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    let mut back = text.clone();
    for triangle in triangles() {
        let [a, b, c] = triangle.map(|corner| corner + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
        let [a, b, c] = triangle.map(|corner| i64::from(corner) - i64::from(count));
        writeln!(back, "f {a} {b} {c}").unwrap();
    }
    takes_little("OBJ", text.as_bytes());
    takes_little("OBJ counted back", back.as_bytes());
}

/// A GLB file of one primitive, with texture coordinates or without.
fn glb(has_uvs: bool, node: &str) -> Vec<u8> {
    let triangles = triangles();
    let count = AROUND * ALONG;
    let mut binary = Vec::new();
    for point in (0..count).map(point) {
        binary.extend(point.map(f32::to_le_bytes).as_flattened());
    }
    for triangle in &triangles {
        binary.extend(triangle.map(u32::to_le_bytes).as_flattened());
    }
    let indices_at = 12 * count as usize;
    let uvs_at = binary.len();
    let mut attributes = "\"POSITION\":0".to_owned();
    if has_uvs {
        binary.resize(uvs_at + 8 * count as usize, 0);
        attributes += ",\"TEXCOORD_0\":2";
    }
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{length}}}],"bufferViews":[{{"buffer":0,"byteLength":{indices_at}}},
        {{"buffer":0,"byteOffset":{indices_at},"byteLength":{indices_bytes}}},{{"buffer":0,"byteOffset":{uvs_at},"byteLength":{uvs_bytes}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{count}}},
        {{"bufferView":1,"componentType":5125,"type":"SCALAR","count":{corners}}},{{"bufferView":2,"componentType":5126,"type":"VEC2","count":{count}}}],
        "meshes":[{{"primitives":[{{"attributes":{{{attributes}}},"indices":1}}]}}],"nodes":[{node}]}}"#,
        length = binary.len(),
        indices_bytes = uvs_at - indices_at,
        uvs_bytes = binary.len() - uvs_at,
        corners = 3 * triangles.len(),
    );
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

#[test]
fn glb_takes_little() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    takes_little("GLB", &glb(false, r#"{"mesh":0}"#));
    let turned = r#"{"mesh":0,"rotation":[0,0.6,0,0.8],"translation":[1e6,0,0]}"#;
    takes_little(
        "GLB, turned and with texture coordinates",
        &glb(true, turned),
    );
}

/// A VTP file with raw arrays behind it.
fn vtp(compressor: &str, counts: [usize; 2], arrays: &[Vec<u8>; 3]) -> Vec<u8> {
    let second = arrays[0].len();
    let third = second + arrays[1].len();
    let mut bytes = format!(
        "<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"{compressor}\"><PolyData><Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"appended\" offset=\"{second}\"/><DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"{third}\"/></Polys></Piece></PolyData><AppendedData encoding=\"raw\">_",
        counts[0], counts[1]
    )
    .into_bytes();
    bytes.extend(arrays.concat());
    bytes
}

/// An array with its header, plain.
fn plain(array: &[u8]) -> Vec<u8> {
    [&(array.len() as u64).to_le_bytes(), array].concat()
}

/// An array in blocks, as VTK makes them.
fn zlib(array: &[u8]) -> Vec<u8> {
    const BLOCK: usize = 32 << 10;
    let blocks = array.chunks(BLOCK).map(|block| {
        let mut room = vec![0; block.len() + 256];
        let config = zlib_rs::DeflateConfig::default();
        zlib_rs::compress_slice(&mut room, block, config).0.to_vec()
    });
    let blocks: Vec<Vec<u8>> = blocks.collect();
    let header = [blocks.len(), BLOCK, array.len() % BLOCK];
    let header = header.into_iter().chain(blocks.iter().map(Vec::len));
    let header: Vec<u8> = header
        .flat_map(|word| (word as u64).to_le_bytes())
        .collect();
    [header, blocks.concat()].concat()
}

#[test]
fn vtk_takes_little() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let triangles = triangles();
    let points: Vec<[f32; 3]> = (0..AROUND * ALONG).map(point).collect();
    let counts = [points.len(), triangles.len()];
    let values = points.as_flattened().iter().map(|&value| f64::from(value));
    let corners = triangles.as_flattened().iter();
    let arrays = [
        values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
        corners
            .flat_map(|&corner| i64::from(corner).to_le_bytes())
            .collect(),
        (1..=triangles.len() as i64)
            .flat_map(|triangle| (3 * triangle).to_le_bytes())
            .collect(),
    ];
    let raw = arrays.each_ref().map(|array| plain(array));
    takes_little("raw VTP", &vtp("", counts, &raw));
    let packed = arrays.each_ref().map(|array| zlib(array));
    takes_little("zlib VTP", &vtp("vtkZLibDataCompressor", counts, &packed));
    let mut text = format!(
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS {} double\n",
        counts[0]
    );
    for point in &points {
        writeln!(text, "{} {} {}", point[0], point[1], point[2]).unwrap();
    }
    writeln!(text, "POLYGONS {} {}", counts[1], 4 * counts[1]).unwrap();
    for [a, b, c] in &triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    takes_little("legacy VTK", text.as_bytes());
}

#[test]
fn what_is_announced_takes_nothing() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut stl = vec![0; 80];
    stl.extend(u32::MAX.to_le_bytes());
    let ply = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 99999999\nproperty float x\nproperty float y\nproperty float z\nelement face 99999999\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 0 0 0 0 0"
        )
    };
    let gltf = |rest: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}],{rest}}}"#
        )
    };
    let sparse = r#""sparse":{"count":99999999,"indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}}"#;
    let accessor = |rest: &str| {
        format!(
            r#""accessors":[{{"componentType":5126,"type":"VEC3","count":99999999{rest}}}],"buffers":[{{"byteLength":4,"uri":"data:;base64,AAAAAA=="}}],
            "bufferViews":[{{"buffer":0,"byteLength":4}}]"#
        )
    };
    // A block of nothing that announces a gigabyte, and one that is announced beyond its file.
    let block = zlib(&[0; 1000]);
    let words =
        |words: &[u64]| -> Vec<u8> { words.iter().flat_map(|word| word.to_le_bytes()).collect() };
    let bomb = [words(&[1, 24 << 25, 0, block.len() as u64]), block].concat();
    let bomb = [bomb, Vec::new(), Vec::new()];
    let far = [words(&[24 << 25]), Vec::new(), Vec::new()];
    for bytes in [
        gltf(&accessor("")).into_bytes(),
        gltf(&accessor(r#","bufferView":0"#)).into_bytes(),
        gltf(&accessor(&format!(",{sparse}"))).into_bytes(),
        gltf(&accessor(&format!(r#","bufferView":0,{sparse}"#))).into_bytes(),
        stl,
        vtp("vtkZLibDataCompressor", [1 << 25, 1 << 25], &bomb),
        vtp("", [1 << 25, 1 << 25], &far),
        b"# vtk DataFile Version 5.1\n\nBINARY\nDATASET POLYDATA\nPOINTS 99999999 double\n"
            .to_vec(),
        ply("ascii").into_bytes(),
        ply("binary_big_endian").into_bytes(),
    ] {
        let (read, taken) = measured(&bytes);
        assert!(read.is_err(), "no such model");
        assert!(taken < 64 << 10, "{taken} bytes were taken");
    }
}
