//! STL, text and bytes, with joined corners.

use super::*;

/// The pyramid as text, in two solids.
pub(super) fn ascii() -> Vec<u8> {
    let mut text = String::from("solid the sides of a solid\n");
    for (number, triangle) in TRIANGLES.iter().enumerate() {
        if number == 4 {
            text += "endsolid the sides\nsolid\n";
        }
        text += "  facet normal 0 0 nan\n    outer loop\n";
        for &corner in triangle {
            let [x, y, z] = POINTS[corner as usize];
            text += &format!("      vertex {x:e} {y} {z}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text += "endsolid\n";
    text.into_bytes()
}

/// The pyramid as bytes, with a header that begins as text does.
pub(super) fn binary() -> Vec<u8> {
    let corners = TRIANGLES.map(|triangle| triangle.map(|corner| POINTS[corner as usize]));
    of_corners(&corners)
}

fn of_corners(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = b"solid pyramid".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0xFF; 12]); // a normal that is no number
        for value in triangle.as_flattened() {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([1, 2]);
    }
    bytes
}

/// The pyramid's corners, in the order of its triangles.
fn expected() -> Vec<[Vec3; 3]> {
    let triangles = TRIANGLES.iter();
    let corner = |&corner: &u32| Vec3::from(POINTS[corner as usize]);
    triangles
        .map(|triangle| triangle.each_ref().map(corner))
        .collect()
}

#[test]
fn corners_of_equal_coordinates_are_joined() {
    let text = String::from_utf8(ascii()).unwrap();
    for (format, bytes) in [
        (Format::AsciiStl, ascii()),
        (Format::AsciiStl, text.to_uppercase().into_bytes()),
        (Format::AsciiStl, text.replace('\n', "\r\n").into_bytes()),
        (Format::BinaryStl, binary()),
    ] {
        let model = read(&bytes).unwrap();
        assert_eq!(model.format, format);
        assert_eq!(model.mesh.positions.len(), 5);
        assert_eq!(corners(&model.mesh), expected());
    }
}

#[test]
fn bytes_behind_the_triangles_are_counted() {
    let bytes = binary();
    assert_eq!(read(&bytes).unwrap().surplus_bytes, 0);
    for surplus in [&b"\0"[..], b"a name\r\n", &[7; 50], &[0xFF; 1000]] {
        let model = read(&[&bytes, surplus].concat()).unwrap();
        assert_eq!(model.format, Format::BinaryStl);
        assert_eq!(corners(&model.mesh), expected());
        assert_eq!(model.surplus_bytes, surplus.len());
    }
}

#[test]
fn minus_zero_is_zero_and_next_to_equal_is_not() {
    let near = f32::from_bits(1.0_f32.to_bits() + 1);
    let bytes = of_corners(&[
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[-0.0, 0.0, -0.0], [near, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ]);
    let mesh = read(&bytes).unwrap().mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 3, 2]]);
}

#[test]
fn long_text_is_read_in_pieces() {
    let count = 30_000_u32;
    let mut text = String::from("solid many\n");
    for facet in 0..count {
        let [a, b] = [facet, facet + 1];
        text += &format!(
            "facet normal 0 0 1\nouter loop\nvertex {a} 0 0\nvertex {b} 0 0\nvertex {a} 1 {a}\nendloop\nendfacet\n"
        );
    }
    let model = read(format!("{text}endsolid many\n").as_bytes()).unwrap();
    assert_eq!(model.mesh.triangles.len(), count as usize);
    assert_eq!(model.mesh.positions.len(), 2 * count as usize + 1);
    assert_eq!(
        model.mesh.triangles[20_000],
        [40_000, 40_002, 40_003].map(|at: u32| match at {
            40_000 => model.mesh.triangles[19_999][1],
            at => at - 1,
        })
    );
    let told = fault(text.as_bytes());
    let lines = text.lines().count();
    assert!(
        told.starts_with(&format!(
            "line {lines} of the ASCII STL file is the end, but the solid has no `endsolid`"
        )),
        "{told}"
    );
    let line = 7 * 25_000 + 5;
    let wrong = text.replace(
        "vertex 25000 0 0\nvertex 25001",
        "vertex 25000 0 0\nvertex _",
    );
    let told = fault(wrong.as_bytes());
    assert!(
        told.starts_with(&format!("line {line} of the ASCII STL file has `_`")),
        "{told}"
    );
}

#[test]
fn faults_are_told_with_their_place() {
    let good = String::from_utf8(ascii()).unwrap();
    let swapped = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let bytes = binary();
    let with = |at: usize, new: [u8; 4]| {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&new);
        bytes
    };
    for (file, told) in [
        (
            swapped("    endloop\n", "vertex 0 0 0\n"),
            "line 7 of the ASCII STL file is a fourth vertex",
        ),
        (
            swapped("      vertex -1e0 -1 0\n", ""),
            "line 7 of the ASCII STL file ends a facet that has not three vertices",
        ),
        (
            swapped("  endfacet\n", ""),
            "line 8 of the ASCII STL file begins while a facet is open",
        ),
        (
            swapped("outer loop", "inner loop"),
            "line 3 of the ASCII STL file begins with no word of STL",
        ),
        (
            swapped("vertex -1e0 -1 0", "vertex -1e0 -1"),
            "line 4 of the ASCII STL file has nothing where a coordinate stands",
        ),
        (
            swapped("vertex -1e0 -1 0", "vertex -1e0 inf 0"),
            "line 4 of the ASCII STL file has the coordinate inf",
        ),
        (
            swapped("  facet normal 0 0 nan\n    outer loop\n", ""),
            "line 2 of the ASCII STL file is a vertex outside",
        ),
        (good[..good.len() - 20].into(), "is the end, amid a facet"),
        (
            b"solid x\nendsolid x\n".to_vec(),
            "has 0 vertices and no triangle",
        ),
        (
            bytes[..bytes.len() - 1].to_vec(),
            "byte 80 of the binary STL file announces 6 triangles",
        ),
        (
            with(80, u32::MAX.to_le_bytes()),
            "announces 4294967295 triangles, which make a file of 214748364834 bytes, but it has 384, enough for 6",
        ),
        (
            with(80, [0; 4]),
            "announces no triangle, but 300 bytes follow",
        ),
        (
            with(84 + 50 + 24, f32::INFINITY.to_le_bytes()),
            "byte 158 of the binary STL file has the coordinate inf",
        ),
        (vec![0; 84], "has 0 vertices and no triangle"),
    ] {
        let found = fault(&file);
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}
