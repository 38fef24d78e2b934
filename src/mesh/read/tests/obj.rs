//! Wavefront OBJ.

use super::*;

/// The pyramid as text.
pub(super) fn text() -> Vec<u8> {
    let mut text = String::from("# a pyramid\nmtllib /no/such/file.mtl\no pyramid\n");
    for [x, y, z] in POINTS {
        text += &format!("v {x} {y} {z}\n");
    }
    text += "vt 0 0\nvn 0 0 1\ng sides\nusemtl stone\ns off\n";
    for face in FACES {
        let corners: Vec<String> = face.iter().map(|at| (at + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text.into_bytes()
}

#[test]
fn all_ways_to_write_it_give_the_same() {
    let text = String::from_utf8(text()).unwrap();
    assert_pyramid(&read(text.as_bytes()).unwrap(), "plain");
    for (from, to) in [
        ("f 1 2 5", "f 1/1 2/1 5/1"),
        ("f 1 2 5", "f 1//1 2//1 5//1"),
        ("f 1 2 5", "f 1/1/1 2/1/1 5/-1/-1"),
        ("f 1 2 5", "f -5 -4 -1"),
        ("f 1 2 5", "f -5/-1 2 -1//1"),
        ("f 1 2 5", "f\t1   2\t5  # the first"),
        ("f 1 2 5", "f 1 \\\n2 \\\r\n 5"),
        ("f 1 2 5", "f 1\\\n 2\\\n 5\\\n"),
        ("f 1 2 5", "  f 1 2 5"),
        ("v 0 0 1.5", "v 0 0 1.5 0.5 0.25 1"),
        ("v 0 0 1.5", "v 0 \\\n 0 \\\n 1.5 \\\n 1"),
        ("v 0 0 1.5", "v 0\\\n 0\\\n 1.5\\\n"),
        ("v 0 0 1.5", "v .0 -0e5 +1.5E0"),
        ("# a pyramid", "# C:\\models\\"),
        ("usemtl stone", "l 1 2\np 1\ncurv 0 1 1 2\nwhatever else"),
        ("\n", "\r\n"),
        ("# a pyramid", "\u{FEFF}# a pyramid"),
    ] {
        let told = format!("{from:?} → {to:?}");
        let changed = text.replace(from, to);
        let model = read(changed.as_bytes()).unwrap();
        assert_eq!(model.format, Format::Obj);
        let mut expected = read(text.as_bytes()).unwrap();
        expected.file_bytes = changed.len() as u64;
        assert_eq!(model, expected, "{told}");
    }
}

#[test]
fn faces_of_fewer_than_three_vertices_are_left_out_and_counted() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf\nf 1 2 3\nf 3";
    let model = read(text.as_bytes()).unwrap();
    assert_eq!(model.skipped_faces, 3);
    assert_eq!(model.mesh.triangles, [[0, 1, 2]]);
}

/// A strip of triangles of which faces and vertices alternate, over several pieces; a face counts back or not by its number.
fn strip(counts_back: impl Fn(u32) -> bool) -> String {
    let mut text = String::new();
    for at in 0..60_000_u32 {
        text += &format!("v {at} {} 0.125\n", at % 3);
        if at >= 2 {
            let [a, b, c] = [at - 1, at, at + 1];
            text += &match counts_back(at) {
                true => "f -3 -2 -1\n".to_owned(),
                false => format!("f {a} {b} {c}\n"),
            };
        }
    }
    text
}

#[test]
fn vertices_counted_back_are_found_across_pieces() {
    let forward = read(strip(|_| false).as_bytes()).unwrap().mesh;
    assert_eq!(forward.triangles.len(), 59_998);
    assert_eq!(forward.triangles[50_000], [50_000, 50_001, 50_002]);
    for (told, counts_back) in [
        ("all", (|_| true) as fn(u32) -> bool),
        ("every other", |at| at % 2 == 0),
        ("late", |at| at > 50_000),
    ] {
        assert_eq!(
            read(strip(counts_back).as_bytes()).unwrap().mesh,
            forward,
            "{told}"
        );
    }
}

#[test]
fn faces_may_stand_before_their_vertices() {
    let model = read(b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(model.mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn faults_are_told_with_their_place() {
    let good = String::from_utf8(text()).unwrap();
    let swapped = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let late = format!("{}f 1 60001 2\nf 1 2 3\n", strip(|_| true)).into_bytes();
    for (file, told) in [
        (
            swapped("v 0 0 1.5", "v 0 0"),
            "line 8 of the OBJ file has nothing where a coordinate stands",
        ),
        (
            swapped("v 0 0 1.5", "v 0 0 1,5"),
            "line 8 of the OBJ file has `1,5` where a coordinate stands",
        ),
        (
            swapped("v 0 0 1.5", "v 0 0 nan"),
            "line 8 of the OBJ file has the coordinate NaN",
        ),
        (
            swapped("f 1 2 5", "f 1 2 6"),
            "line 14 of the OBJ file names a vertex that is not there (there are 5 in the file, 5 before this line)",
        ),
        (
            swapped("f 1 2 5", "f 1 2 -6"),
            "line 14 of the OBJ file names a vertex that is not there",
        ),
        (
            swapped("f 1 2 5", "f 0 1 2"),
            "line 14 of the OBJ file has `0` as a face's corner",
        ),
        (
            swapped("f 1 2 5", "f 1 2 x"),
            "line 14 of the OBJ file has `x` as a face's corner",
        ),
        (
            swapped("f 1 2 5", "f 1 2 3.5"),
            "line 14 of the OBJ file has `3.5` as a face's corner",
        ),
        (
            swapped("f 1 2 5", "f 1 2 99999999999999999999"),
            "as a face's corner",
        ),
        (
            format!("{}\0\0\n", strip(|_| true)).into_bytes(),
            "begins with a byte that no text has",
        ),
        (b"v 0 0 0\n".to_vec(), "has 1 vertices and no triangle"),
        (
            late,
            "line 119999 of the OBJ file names a vertex that is not there (there are 60000",
        ),
    ] {
        let found = fault(&file);
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}
