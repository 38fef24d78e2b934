//! Bytes that nobody means well with: nothing stops the program, and no more memory is taken than the file can fill.

use std::time::{Duration, Instant};

use proptest::prelude::*;

use super::*;

/// That what was read is whole.
fn check(read: Result<Model, MeshError>) -> Result<(), TestCaseError> {
    let Ok(model) = read else { return Ok(()) };
    let mesh = &model.mesh;
    prop_assert!(!mesh.triangles.is_empty(), "no model without triangles");
    let vertices = mesh.positions.len();
    prop_assert!(
        mesh.triangles
            .as_flattened()
            .iter()
            .all(|&vertex| (vertex as usize) < vertices)
    );
    prop_assert!(mesh.origin.is_finite() && mesh.positions.iter().all(|point| point.is_finite()));
    let Some(paint) = model.paint else {
        return Ok(());
    };
    let is_all = |length: usize, all: usize| length == 0 || length == all;
    prop_assert!(is_all(paint.texture_coordinates.len(), vertices));
    prop_assert!(is_all(paint.colours.len(), vertices));
    prop_assert!(is_all(paint.triangle_materials.len(), mesh.triangles.len()));
    let materials = paint.materials.len().max(1);
    prop_assert!(
        paint
            .triangle_materials
            .iter()
            .all(|&material| usize::from(material) < materials)
    );
    let images = paint
        .materials
        .iter()
        .filter_map(|material| material.base_colour_image);
    for texture in images {
        prop_assert!((texture.image as usize) < paint.images.len());
    }
    Ok(())
}

/// How each format begins.
const STARTS: [&[u8]; 14] = [
    b"",
    b"ply\n",
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n",
    b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty char y\nproperty char z\nelement face 2\nproperty list uchar char vertex_indices\nend_header\n",
    b"solid x\nfacet\n",
    b"v 0 0 0\nv 1 0 0\n",
    &[b' '; 80],
    b"glTF\x02\0\0\0\x40\0\0\0\x2c\0\0\0JSON",
    b"{\"asset\":{\"version\":\"2.0\"},",
    b"<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">",
    b"<VTKFile type=\"PolyData\"><AppendedData encoding=\"raw\">_",
    b"# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 3 char\n0 0 0 0 0 0 0 0 0\nPOLYGONS 1 4\n",
    b"# vtk DataFile Version 3.0\n\nBINARY\nDATASET POLYDATA\nPOINTS 1 char\n000POLYGONS 1 4\nOFFSETS char\n",
    b"1 1 0 0 0 1 -1\n2 1 0 1 0 1 1\n",
];

/// A change of a file.
#[derive(Clone, Debug)]
enum Change {
    Byte(u8),
    Insert(Vec<u8>),
    Remove(usize),
    Repeat(usize),
    Cut,
}

fn change() -> impl Strategy<Value = Change> {
    let words: Vec<&[u8]> = vec![
        b"-1",
        b"4294967295",
        b"18446744073709551615",
        b"1e999",
        b"nan",
        b"-",
        b"\n",
        b"\\\n",
        b" ",
        b"/",
        b"list",
        b"vertex",
        b"face",
        b"element",
        b"double",
        b"end_header\n",
        b"facet",
        b"endsolid",
        b"f ",
        b"v ",
        b"{",
        b"[0,1]",
        b"\"",
        b"\"mesh\":0,",
        b"\"children\":[0],",
        b"\"mode\":5,",
        b"&",
        b"<",
        b"/>",
        b"<Piece>",
        b"<!DOCTYPE a>",
        b"=",
        b"AAAA",
    ];
    prop_oneof![
        any::<u8>().prop_map(Change::Byte),
        prop::sample::select(words).prop_map(|word| Change::Insert(word.to_vec())),
        (1_usize..40).prop_map(Change::Remove),
        (1_usize..40).prop_map(Change::Repeat),
        Just(Change::Cut),
    ]
}

fn apply(bytes: &mut Vec<u8>, at: usize, change: Change) {
    let at = at % (bytes.len() + 1);
    let end = |count: usize| (at + count).min(bytes.len());
    match change {
        Change::Byte(new) => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = new;
            }
        }
        Change::Insert(word) => drop(bytes.splice(at..at, word)),
        Change::Remove(count) => drop(bytes.drain(at..end(count))),
        Change::Repeat(count) => {
            let part = bytes[at..end(count)].to_vec();
            drop(bytes.splice(at..at, part));
        }
        Change::Cut => bytes.truncate(at),
    }
}

/// The pyramids, and a glTF file with all that may be in one.
fn all() -> Vec<(Format, Vec<u8>)> {
    let mut all = pyramids();
    all.push((Format::Gltf, gltf::everything().gltf()));
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_bytes_are_a_model_or_a_fault(start in prop::sample::select(&STARTS[..]), rest in prop::collection::vec(any::<u8>(), 0..300)) {
        check(read(&[start, &rest].concat()))?;
    }

    #[test]
    fn any_words_are_a_model_or_a_fault(start in prop::sample::select(&STARTS[..]), rest in "([-+0-9.e ]{0,4}|[vf] |\n|facet|vertex|/|\\\\){0,60}") {
        check(read(&[start, rest.as_bytes()].concat()))?;
    }

    #[test]
    fn a_changed_file_is_a_model_or_a_fault(which in 0_usize..all().len(), changes in prop::collection::vec((any::<usize>(), change()), 1..6)) {
        let (_, mut bytes) = all().swap_remove(which);
        for (at, change) in changes {
            apply(&mut bytes, at, change);
        }
        check(read(&bytes))?;
    }
}

#[test]
fn every_cut_file_is_a_model_or_a_fault() {
    for (format, bytes) in pyramids() {
        assert_eq!(read(&bytes).unwrap().format, format);
        for end in 0..bytes.len() {
            let cut = read(&bytes[..end]);
            // In text a last number may be shorter, or the last faces missing, and nobody can tell; and a last end of line.
            if !format.is_text() {
                assert!(cut.is_err(), "{format} of {end} bytes");
            }
            check(cut).unwrap();
        }
    }
}

#[test]
fn long_lines_deep_lists_and_announced_gigabytes_are_faults_at_once() {
    let long = |start: &str, part: &str, count: usize| [start, &part.repeat(count)].concat();
    let ply = "ply\nformat ascii 1.0\n";
    for (told, text) in [
        ("a number", long("v 0 0 ", "9", 5_000_000)),
        ("a comment", long("v 0 0 0\n#", "x", 5_000_000)),
        ("a continued line", long("v 0 0 0 ", "\\\n", 3_000_000)),
        ("a face", long("v 0 0 0\nf ", "1 ", 3_000_000) + "x"),
        (
            "corners of slashes",
            long("v 0 0 0\nf 1", "/", 5_000_000) + "x",
        ),
        ("blanks", long("v 0 0 0\n", " ", 5_000_000)),
        ("a solid", long("solid ", "facet ", 1_000_000)),
        ("facets", long("solid\n", "facet\n", 1_000_000)),
        ("elements", long(ply, "element a 9\n", 1_000_000)),
        ("a header", long(ply, "comment ", 1_000_000)),
        (
            "rows",
            format!(
                "{ply}element vertex 9000000000000000000\nproperty char x\nproperty char y\nproperty char z\nend_header\n0 0 0\n"
            ),
        ),
        (
            "lists",
            format!(
                "{ply}element a 9000000000000000000\nproperty list char int x\nend_header\n0 0 0\n"
            ),
        ),
        (
            "a list",
            format!("{ply}element a 1\nproperty list uint int x\nend_header\n4294967295 0\n"),
        ),
        ("a word", long("solid\n", "x", 5_000_000)),
    ] {
        let begun = Instant::now();
        assert!(read(text.as_bytes()).is_err(), "{told}");
        let taken = begun.elapsed();
        assert!(taken < Duration::from_secs(5), "{told} took {taken:?}");
    }
}

#[test]
fn limits_hold() {
    for (format, bytes) in pyramids() {
        let at_most = |bytes_most: u64, vertices: usize, triangles: usize| {
            let limits = ReadLimits {
                bytes: bytes_most,
                vertices,
                triangles,
            };
            read_bytes(&bytes, &limits, &AtomicBool::new(false))
        };
        let length = bytes.len() as u64;
        assert!(at_most(length, 5, 6).is_ok(), "{format}");
        assert!(
            matches!(at_most(length - 1, 5, 6), Err(MeshError::TooLong { .. })),
            "{format}"
        );
        assert!(
            matches!(
                at_most(length, 4, 6),
                Err(MeshError::TooMany {
                    what: "vertices",
                    most: 4
                })
            ),
            "{format}"
        );
        assert!(
            matches!(
                at_most(length, 5, 5),
                Err(MeshError::TooMany {
                    what: "triangles",
                    most: 5
                })
            ),
            "{format}"
        );
    }
}

#[test]
fn what_is_cancelled_ends() {
    for (format, bytes) in pyramids() {
        let read = read_bytes(&bytes, &ReadLimits::default(), &AtomicBool::new(true));
        assert!(matches!(read, Err(MeshError::Cancelled)), "{format}");
    }
}

#[test]
fn files_are_read_and_faults_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let never = AtomicBool::new(false);
    let limits = ReadLimits::default();
    let path = folder.path().join("model.png");
    for (format, bytes) in pyramids() {
        std::fs::write(&path, &bytes).unwrap();
        let model = super::super::read(&path, &limits, &never).unwrap();
        assert_eq!(model, read(&bytes).unwrap(), "{format}");
    }
    std::fs::write(&path, "v 0 0 0\nf 1 1 2\n").unwrap();
    let told = super::super::read(&path, &limits, &never)
        .unwrap_err()
        .to_string();
    assert!(
        told.starts_with("line 2 of the OBJ file") && told.ends_with("model.png"),
        "{told}"
    );
    let told = super::super::read(folder.path(), &limits, &never)
        .unwrap_err()
        .to_string();
    assert!(told.contains("plain file"), "{told}");
    let told = super::super::read(&folder.path().join("none"), &limits, &never)
        .unwrap_err()
        .to_string();
    assert!(told.contains("check that the file is there"), "{told}");
    let read = super::super::read(&path, &limits, &AtomicBool::new(true));
    assert!(matches!(read, Err(MeshError::Cancelled)));
}
