//! PLY of every kind.

use super::*;

/// Types of a file's numbers, by their names.
#[derive(Clone, Copy)]
pub(super) struct Kinds {
    axis: &'static str,
    count: &'static str,
    item: &'static str,
}

impl Default for Kinds {
    fn default() -> Self {
        Self {
            axis: "float",
            count: "uchar",
            item: "int",
        }
    }
}

/// A number in a type, in either order of bytes.
fn put(to: &mut Vec<u8>, value: f64, kind: &str, is_big: bool) {
    let mut bytes = match kind {
        "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    if is_big {
        bytes.reverse();
    }
    to.extend(bytes);
}

/// The pyramid with properties and elements that nobody asked for, faces last or first.
fn rich(kinds: Kinds, is_big: bool, faces_first: bool) -> Vec<u8> {
    let Kinds { axis, count, item } = kinds;
    let order = if is_big { "big" } else { "little" };
    let vertex = format!(
        "element vertex 5\nproperty uchar red\nproperty {axis} z\nproperty list uchar short extra\nproperty {axis} y\nproperty {axis} x\n"
    );
    let face = format!(
        "element face 5\nproperty float quality\nproperty list {count} {item} vertex_index\nproperty list uchar float texcoord\n"
    );
    let other = "element camera 2\nproperty double view\nproperty list int char name\nelement nothing 18446744073709551615\n";
    let [first, last] = if faces_first {
        [&face, &vertex]
    } else {
        [&vertex, &face]
    };
    let mut bytes = format!(
        "ply\r\nformat binary_{order}_endian 1.0\r\ncomment made by a test\r\nobj_info x\r\n{}end_header\r\n",
        format!("{first}{other}{last}").replace('\n', "\r\n")
    )
    .into_bytes();
    let mut put = |value: f64, kind: &str| put(&mut bytes, value, kind, is_big);
    for part in [faces_first, !faces_first] {
        if part {
            for face in FACES {
                put(0.5, "float");
                put(face.len() as f64, count);
                face.iter().for_each(|&vertex| put(vertex.into(), item));
                put(1.0, "uchar");
                put(f64::NAN, "float");
            }
        } else {
            for [x, y, z] in POINTS.map(|point| point.map(f64::from)) {
                put(255.0, "uchar");
                put(2.0 * z, axis);
                put(1.0, "uchar");
                put(-7.0, "short");
                put(2.0 * y, axis);
                put(2.0 * x, axis);
            }
        }
        if part == faces_first {
            for _ in 0..2 {
                put(f64::INFINITY, "double");
                put(3.0, "int");
                (0..3).for_each(|_| put(1.0, "char"));
            }
        }
    }
    bytes
}

fn header(format: &str, kinds: Kinds) -> String {
    let Kinds { axis, count, item } = kinds;
    format!(
        "ply\nformat {format} 1.0\nelement vertex 5\nproperty {axis} x\nproperty {axis} y\nproperty {axis} z\nelement face 5\nproperty list {count} {item} vertex_indices\nend_header\n"
    )
}

/// The pyramid as bytes.
pub(super) fn binary(kinds: Kinds, is_big: bool) -> Vec<u8> {
    let order = if is_big { "big" } else { "little" };
    let mut bytes = header(&format!("binary_{order}_endian"), kinds).into_bytes();
    for value in POINTS.as_flattened() {
        put(&mut bytes, (*value).into(), kinds.axis, is_big);
    }
    for face in FACES {
        put(&mut bytes, face.len() as f64, kinds.count, is_big);
        for &vertex in face {
            put(&mut bytes, vertex.into(), kinds.item, is_big);
        }
    }
    bytes
}

/// The pyramid as text.
pub(super) fn ascii() -> Vec<u8> {
    let mut text = header("ascii", Kinds::default());
    for [x, y, z] in POINTS {
        text += &format!("{x} {y} {z}\n");
    }
    for face in FACES {
        let corners: Vec<String> = face.iter().map(u32::to_string).collect();
        text += &format!("{} {}\n", face.len(), corners.join(" "));
    }
    text.into_bytes()
}

#[test]
fn text_and_bytes_give_the_same() {
    for (format, bytes) in [
        (Format::AsciiPly, ascii()),
        (Format::BinaryPly, binary(Kinds::default(), false)),
        (Format::BinaryPly, binary(Kinds::default(), true)),
    ] {
        let model = read(&bytes).unwrap();
        assert_eq!(model.format, format);
        assert_eq!(model.file_bytes, bytes.len() as u64);
        assert_pyramid(&model, &format.to_string());
    }
    // No end of line after the last number, and all on one line.
    let text = String::from_utf8(ascii()).unwrap();
    assert_pyramid(&read(text.trim_end().as_bytes()).unwrap(), "no end of line");
    let (header, body) = text.split_once("end_header\n").unwrap();
    let one_line = format!("{header}end_header\n{}", body.replace('\n', "  "));
    assert_pyramid(&read(one_line.as_bytes()).unwrap(), "one line");
}

#[test]
fn all_types_in_all_places_and_what_nobody_asked_for() {
    let axes = [
        "char", "int8", "short", "int", "int32", "float", "float32", "double", "float64",
    ];
    let wholes = [
        "char", "uchar", "short", "ushort", "int", "uint", "uint8", "uint16", "float", "double",
    ];
    for axis in axes {
        for count in wholes {
            for item in wholes {
                for (is_big, faces_first) in
                    [(false, false), (false, true), (true, false), (true, true)]
                {
                    let kinds = Kinds { axis, count, item };
                    let told = format!("{axis} {count} {item} {is_big} {faces_first}");
                    let model = read(&rich(kinds, is_big, faces_first)).unwrap();
                    assert_eq!(model.mesh.triangles, TRIANGLES, "{told}");
                    let doubled = POINTS.map(|point| Vec3::from(point) * 2.0);
                    assert_eq!(model.mesh.positions, doubled, "{told}");
                }
            }
        }
    }
}

/// A grid of triangles in rows of one size, more than a thread takes at once.
fn grid(extra_face: Option<[u32; 2]>) -> (Vec<u8>, Vec<[u32; 3]>) {
    let points = 40_000_u32;
    let triangles: Vec<[u32; 3]> = (0..points - 2).map(|at| [at, at + 1, at + 2]).collect();
    let faces = triangles.len() + usize::from(extra_face.is_some());
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {points}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    for point in 0..points {
        for axis in 0..3_u32 {
            put(&mut bytes, f64::from(point % (7 + axis)), "float", false);
        }
    }
    for triangle in &triangles {
        bytes.push(3);
        triangle
            .iter()
            .for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    if let Some(edge) = extra_face {
        bytes.push(2);
        edge.iter()
            .for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    (bytes, triangles)
}

#[test]
fn rows_of_one_size_and_a_row_of_another_give_the_same() {
    let (bytes, triangles) = grid(None);
    let quick = read(&bytes).unwrap();
    assert_eq!(quick.mesh.triangles, triangles);
    let (bytes, _) = grid(Some([0, 1]));
    let walked = read(&bytes).unwrap();
    assert_eq!(walked.skipped_faces, 1);
    assert_eq!(walked.mesh, quick.mesh);
}

#[test]
fn faults_of_rows_of_one_size_have_their_place() {
    let (bytes, triangles) = grid(None);
    let mut wrong = bytes.clone();
    let at = wrong.len() - 4;
    wrong[at..].copy_from_slice(&40_000_u32.to_le_bytes());
    let told = fault(&wrong);
    assert!(
        told.starts_with(&format!(
            "byte {at} of the binary PLY file names the vertex 40000, but there are 40000"
        )),
        "{told}"
    );
    let mut wrong = bytes;
    let at = wrong.len() - triangles.len() * 13 - 12;
    wrong[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let told = fault(&wrong);
    assert!(
        told.starts_with(&format!(
            "byte {at} of the binary PLY file has the coordinate NaN"
        )),
        "{told}"
    );
}

#[test]
fn colours_are_read_as_a_screen_shows_them() {
    // Of sRGB: 0, the half of a byte, 1; and of alpha, which is a part of one.
    let half = 0.215_860_5;
    for (kind, values, alpha) in [
        ("uchar", [0.0, 128.0, 255.0], 51.0),
        ("ushort", [0.0, 32_896.0, 65_535.0], 13_107.0),
        ("float", [0.0, 128.0 / 255.0, 1.0], 0.2),
        ("double", [-1.0, 128.0 / 255.0, 7.0], 0.2),
    ] {
        for (prefix, has_alpha, list) in [
            ("", true, ""),
            ("diffuse_", false, ""),
            ("", true, "property list uchar char more\n"),
        ] {
            let names = ["red", "green", "blue", "alpha"];
            let names = &names[..if has_alpha { 4 } else { 3 }];
            let names: String = names
                .iter()
                .map(|name| format!("property {kind} {prefix}{name}\n"))
                .collect();
            let header = |format: &str| {
                format!(
                    "ply\nformat {format} 1.0\nelement vertex 3\n{names}property float z\nproperty float y\nproperty float x\n{list}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                )
            };
            let mut text = header("ascii");
            let mut bytes = header("binary_big_endian").into_bytes();
            for row in 0..3_u8 {
                let all = [values[0], values[1], values[2], alpha];
                for value in &all[..if has_alpha { 4 } else { 3 }] {
                    text += &format!("{value} ");
                    put(&mut bytes, *value, kind, true);
                }
                for value in [row, 1, row * row] {
                    text += &format!("{value} ");
                    put(&mut bytes, value.into(), "float", true);
                }
                if !list.is_empty() {
                    text += "0\n";
                    bytes.push(0);
                }
            }
            text += "3 0 1 2\n";
            bytes.push(3);
            (0..3).for_each(|corner| put(&mut bytes, corner.into(), "int", true));
            for bytes in [text.into_bytes(), bytes] {
                let paint = read(&bytes).unwrap().paint.unwrap();
                assert_eq!(paint.colours.len(), 3);
                for [red, green, blue, alpha] in paint.colours {
                    assert_eq!([red, blue], [0, u16::MAX], "{kind}");
                    let off = f64::from(green) - half * 65_535.0;
                    assert!(off.abs() < 2.0, "{kind}: {green}");
                    assert_eq!(alpha, if has_alpha { 13_107 } else { u16::MAX }, "{kind}");
                }
            }
        }
    }
}

#[test]
fn doubles_are_counted_from_an_origin() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n4500000.001 0 1\n4500000.002 0 2\n4500000.003 1 2\n3 0 1 2\n";
    let mesh = read(text.as_bytes()).unwrap().mesh;
    let x = |at: usize| mesh.origin.x + f64::from(mesh.positions[at].x);
    assert!((x(2) - x(0) - 0.002).abs() < 1e-7);
    assert!((x(1) - 4_500_000.002).abs() < 1e-6);
}

#[test]
fn faults_are_told_with_their_place() {
    let good = String::from_utf8(ascii()).unwrap();
    let swapped = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let bytes = binary(Kinds::default(), false);
    for (file, told) in [
        (
            swapped("element vertex 5", "element vertex 500000000000"),
            "line 10 of the ASCII PLY file is where 500000000000 rows of vertex follow",
        ),
        (
            swapped("element vertex 5", "element vertex -5"),
            "line 3 of the ASCII PLY file announces no element",
        ),
        (
            swapped("element face 5", "element vertex 5"),
            "line 7 of the ASCII PLY file announces the element vertex a second time",
        ),
        (
            swapped("format ascii", "format morse"),
            "line 2 of the ASCII PLY file names no format",
        ),
        (
            swapped("format ascii 1.0\n", ""),
            "line 8 of the ASCII PLY file ends the header, which has no line `format`",
        ),
        (
            swapped("float y", "half y"),
            "line 5 of the ASCII PLY file names no type of numbers",
        ),
        (
            swapped("float y", "float why"),
            "line 3 of the ASCII PLY file announces vertices without the number y",
        ),
        (
            swapped("vertex_indices", "corners"),
            "line 7 of the ASCII PLY file announces faces without the list vertex_indices",
        ),
        (
            swapped("end_header", "end"),
            "begins with `end`, but a header has",
        ),
        (
            swapped("0 0 1.5", "0 zero 1.5"),
            "line 14 of the ASCII PLY file has `zero` where a number stands",
        ),
        (
            swapped("0 0 1.5", "0 1e16 1.5"),
            "line 14 of the ASCII PLY file has the coordinate 1",
        ),
        (
            swapped("3 0 1 4", "3 0 1 5"),
            "line 15 of the ASCII PLY file names the vertex 5, but there are 5",
        ),
        (
            swapped("3 0 1 4", "3 0 -1 4"),
            "line 15 of the ASCII PLY file has -1 as the number of a vertex",
        ),
        (
            swapped("3 0 1 4", "3 0 1.5 4"),
            "has 1.5 as the number of a vertex",
        ),
        (
            swapped("3 0 1 4", "-3 0 1 4"),
            "has -3 as the number of a face's vertices",
        ),
        (
            swapped("3 2 1 0\n", "3 2 1"),
            "line 19 of the ASCII PLY file is the end, amid a row",
        ),
        (b"ply\n".to_vec(), "ends without `end_header`"),
        (bytes[..bytes.len() - 1].to_vec(), "is the end, amid a row"),
        (
            bytes[..200].to_vec(),
            "of the binary PLY file is where 5 rows of vertex follow",
        ),
        (
            swapped("element face 5", "element face 0"),
            "has 5 vertices and no triangle",
        ),
        (
            b"ply\nformat ascii 1.0\nend_header\n".to_vec(),
            "has 0 vertices and no triangle",
        ),
        (
            b"ply\nformat ascii 1.0\nproperty int x\n".to_vec(),
            "is a property before any element",
        ),
    ] {
        let found = fault(&file);
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}

/// Long text is read by all threads where all faces are triangles, else value by value; both ways lead to the same.
#[test]
fn long_text_is_read_by_all_threads() {
    let count = 60_000_u32;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty uchar red\nproperty float z\nproperty float x\nproperty float y\nelement face FACES\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for vertex in 0..count {
        text += &format!("255 0.{vertex} {vertex} -{vertex}.5\n");
    }
    for face in 0..count {
        let [b, c] = [(face + 1) % count, (face + 2) % count];
        text += &format!("3 {face} {b}\t{c}\n");
    }
    let quick = read(text.replace("FACES", "60000").as_bytes())
        .unwrap()
        .mesh;
    let slowly = text.replace("FACES", "60001") + "4 0 1 2 3\n";
    let mut slow = read(slowly.as_bytes()).unwrap().mesh;
    assert_eq!(slow.triangles.split_off(60_000), [[0, 1, 2], [0, 2, 3]]);
    assert!(quick == slow, "the way is seen");
    assert_eq!(quick.triangles[59_999], [59_999, 0, 1]);
    assert_eq!(quick.positions[40_000], Vec3::new(40_000.0, -40_000.5, 0.4));

    let line = text[..text.find("3 50000 ").unwrap()].lines().count() + 1;
    let wrong = text
        .replace("FACES", "60000")
        .replace("3 50000 50001", "3 50000 60000");
    let told = fault(wrong.as_bytes());
    assert!(
        told.starts_with(&format!(
            "line {line} of the ASCII PLY file names the vertex 60000"
        )),
        "{told}"
    );
}
