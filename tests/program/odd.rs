//! `ramus analyze` on odd and hostile models: a result or one clear sentence, and the same result where only the way differs in which a
//! surface is written.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;
use serde_json::Value;

use super::*;

/// A surface before it is a file.
#[derive(Clone, Default)]
struct Surface {
    corners: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
}

impl Surface {
    /// Quadrilaterals over a grid, of which `at` gives the place of a corner.
    fn grid(
        [rows, columns]: [usize; 2],
        corner: impl Fn(usize, usize) -> DVec3,
        [around, along]: [usize; 2],
        at: impl Fn(usize, usize) -> usize,
    ) -> Self {
        let corners = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let cells = (0..along).flat_map(|row| (0..around).map(move |column| (row, column)));
        let faces = cells.flat_map(|(row, column)| {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
            [[a, b, c], [a, c, d]]
        });
        Self {
            corners: corners.map(|(row, column)| corner(row, column)).collect(),
            faces: faces.collect(),
        }
    }

    /// Along x from 0, open at both ends.
    fn tube(length: f64, radius: f64, rows: usize, round: usize) -> Self {
        let corner = |row: usize, column: usize| {
            let (sin, cos) = (column as f64 / round as f64 * TAU).sin_cos();
            let x = length * row as f64 / (rows - 1) as f64;
            DVec3::new(x, radius * cos, radius * sin)
        };
        let at = |row: usize, column: usize| row * round + column % round;
        Self::grid([rows, round], corner, [round, rows - 1], at)
    }

    /// Around the origin; poles are rings of no width.
    fn sphere(radius: f64) -> Self {
        let corner = |row: usize, column: usize| {
            let [tilt, turn] = [PI * row as f64 / 16.0, TAU * column as f64 / 32.0];
            radius * DVec3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos())
        };
        Self::grid([17, 32], corner, [32, 16], |row, column| {
            row * 32 + column % 32
        })
    }

    fn torus() -> Self {
        let corner = |row: usize, column: usize| {
            let [large, small] = [TAU * row as f64 / 80.0, TAU * column as f64 / 24.0];
            let from_axis = 10.0 + 2.0 * small.cos();
            DVec3::new(
                from_axis * large.cos(),
                from_axis * large.sin(),
                2.0 * small.sin(),
            )
        };
        Self::grid([80, 24], corner, [24, 80], |row, column| {
            row % 80 * 24 + column % 24
        })
    }

    fn sheet() -> Self {
        let corner = |row: usize, column: usize| DVec3::new(row as f64, column as f64, 0.0);
        Self::grid([20, 20], corner, [19, 19], |row, column| row * 20 + column)
    }

    /// A strip with half a turn in it, by Möbius.
    fn strip() -> Self {
        let corner = |row: usize, column: usize| {
            let turn = TAU * row as f64 / 60.0;
            let across = 2.0 * (column as f64 / 3.0 - 1.0);
            let from_axis = 10.0 + across * (turn / 2.0).cos();
            let high = across * (turn / 2.0).sin();
            DVec3::new(from_axis * turn.cos(), from_axis * turn.sin(), high)
        };
        Self::grid([60, 7], corner, [6, 60], |row, column| match row {
            60 => 6 - column,
            _ => row * 7 + column,
        })
    }

    /// Klein's bottle as a figure of eight that turns: no inside, and it passes through itself.
    fn bottle() -> Self {
        let corner = |row: usize, column: usize| {
            let [turn, across] = [TAU * row as f64 / 80.0, TAU * column as f64 / 24.0];
            let (sin, cos) = (turn / 2.0).sin_cos();
            let from_axis = 3.0 + cos * across.sin() - sin * (2.0 * across).sin();
            let high = sin * across.sin() + cos * (2.0 * across).sin();
            3.0 * DVec3::new(from_axis * turn.cos(), from_axis * turn.sin(), high)
        };
        Self::grid([80, 24], corner, [24, 80], |row, column| match row {
            80 => (24 - column % 24) % 24,
            _ => row * 24 + column % 24,
        })
    }

    fn and(mut self, other: &Self) -> Self {
        let first = self.corners.len();
        self.corners.extend(&other.corners);
        let faces = other.faces.iter();
        self.faces
            .extend(faces.map(|face| face.map(|corner| corner + first)));
        self
    }

    fn moved(mut self, place: impl Fn(DVec3) -> DVec3) -> Self {
        self.corners
            .iter_mut()
            .for_each(|corner| *corner = place(*corner));
        self
    }

    /// With both ends of [`tube`] closed, flat.
    fn capped(mut self) -> Self {
        for (row, x) in [(0, 0.0), (40, 40.0)] {
            let middle = self.corners.len();
            self.corners.push(DVec3::new(x, 0.0, 0.0));
            for column in 0..36 {
                let [one, other] = [column, (column + 1) % 36].map(|column| 36 * row + column);
                self.faces.push(match row {
                    0 => [middle, other, one],
                    _ => [middle, one, other],
                });
            }
        }
        self
    }

    /// With each triangle's other side outwards, of those that are chosen.
    fn turned(mut self, which: impl Fn(usize) -> bool) -> Self {
        for (place, face) in self.faces.iter_mut().enumerate() {
            if which(place) {
                face.reverse();
            }
        }
        self
    }

    fn write(&self, folder: &Path, name: &str) -> PathBuf {
        let mut text = String::new();
        for DVec3 { x, y, z } in &self.corners {
            writeln!(text, "v {x:?} {y:?} {z:?}").unwrap();
        }
        for [a, b, c] in self.faces.iter().map(|face| face.map(|corner| corner + 1)) {
            writeln!(text, "f {a} {b} {c}").unwrap();
        }
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path
    }
}

/// Tetrahedra of a tenth, away from the tube.
fn debris(count: usize) -> Surface {
    let mut all = Surface::default();
    for place in 0..count {
        let [x, y, z] = [place % 10, place / 10 % 10, place / 100].map(|one| one as f64);
        let at = DVec3::new(4.0 * x, 10.0 + 3.0 * y, 3.0 * z);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|one| at + one / 10.0);
        all = all.and(&Surface {
            corners: corners.to_vec(),
            faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        });
    }
    all
}

fn tube() -> Surface {
    Surface::tube(40.0, 2.0, 41, 36)
}

fn analysis(model: &Path, args: &[&str]) -> Value {
    let json = succeed(ramus().arg("analyze").arg(model).args(args).arg("--json"));
    serde_json::from_str(&json).unwrap()
}

/// How long the only branch is, its mean radius, and the line from surface to surface.
fn measured(analysis: &Value) -> [f64; 3] {
    assert_eq!(
        analysis["branches"].as_array().map(Vec::len),
        Some(1),
        "{analysis}"
    );
    let places = [
        "/branches/0/length",
        "/branches/0/radius/mean",
        "/centerlines/0/length_to_surface",
    ];
    places.map(|place| analysis.pointer(place).and_then(Value::as_f64).unwrap())
}

#[test]
fn what_has_no_ends_or_is_no_model_is_said_in_one_sentence() {
    let folder = folder();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let with_corner =
        |number: &str| format!("v 0 0 0\nv 1 0 0\nv 0 {number} 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
    let surface = |name: &str, surface: Surface| surface.write(folder.path(), name);
    let nowhere = "no ends were found on its surface: give some with --source and --targets";
    let far = |ball: Surface| ball.moved(|place| place + DVec3::X * 1e5);
    let ball = Surface::sphere(5.0);
    let triangle = Surface {
        corners: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        faces: vec![[0, 1, 2]],
    };
    let table = [
        (file("empty.obj", ""), "the file is empty"),
        (file("empty.stl", ""), "the file is empty"),
        (file("empty.ply", ""), "the file is empty"),
        (
            file("nan.obj", &with_corner("nan")),
            "line 3 of the OBJ file has the coordinate NaN",
        ),
        (
            file("inf.obj", &with_corner("inf")),
            "line 3 of the OBJ file has the coordinate inf",
        ),
        (
            file("huge.obj", &with_corner("2e30")),
            "coordinates are numbers up to ±1e15",
        ),
        (file("corners.obj", "v 0 0 0\nv 1 0 0\n"), "corners.obj"),
        (file("point.obj", "v 1 1 1\nf 1 1 1\n"), "point.obj"),
        (surface("triangle.obj", triangle.clone()), nowhere),
        (
            surface("nothing.obj", triangle.moved(|_| DVec3::ONE)),
            nowhere,
        ),
        (
            surface("two.obj", ball.clone().and(&far(ball.clone()))),
            nowhere,
        ),
        (surface("ball.obj", ball), nowhere),
        (surface("torus.obj", Surface::torus()), nowhere),
        (surface("sheet.obj", Surface::sheet()), nowhere),
        (surface("strip.obj", Surface::strip()), nowhere),
        (surface("bottle.obj", Surface::bottle()), nowhere),
    ];
    for (model, expected) in table {
        for args in [&[][..], &["--cap"]] {
            let output = ramus().arg("analyze").arg(&model).args(args).output();
            let output = output.unwrap();
            refused(&output, &[expected]);
            assert_eq!(text(&output.stdout), "", "{}", model.display());
        }
    }
}

#[test]
fn how_a_surface_is_written_changes_no_measure() {
    let folder = folder();
    let first = tube();
    let expected = measured(&analysis(&first.write(folder.path(), "first.obj"), &[]));
    let twice = |other: Surface| {
        let mut both = first.clone();
        both.faces.extend(other.faces);
        both
    };
    let all = |_: usize| true;
    let mut holed = first.clone();
    // Two rows of six quadrilaterals in the middle.
    holed.faces.retain(|face| {
        let [row, column] = [face[0] / 36, face[0] % 36];
        !([20, 21].contains(&row) && column < 6)
    });
    // What is rounded otherwise differs by what single precision has of it; a hole by the wall that is missing.
    let (exact, rounded) = (1e-12, 2e-5);
    let table: Vec<(&str, Surface, f64, f64)> = vec![
        ("each triangle twice", twice(first.clone()), 1.0, exact),
        (
            "twice, once turned",
            twice(first.clone().turned(all)),
            1.0,
            exact,
        ),
        ("all turned", first.clone().turned(all), 1.0, exact),
        (
            "half of them turned",
            first.clone().turned(|place| place % 2 == 0),
            1.0,
            exact,
        ),
        ("with debris", first.clone().and(&debris(200)), 1.0, rounded),
        (
            "in the mirror",
            first
                .clone()
                .moved(|place| place * DVec3::new(1.0, -1.0, 1.0)),
            1.0,
            rounded,
        ),
        (
            "in metres",
            first.clone().moved(|place| place * 1e-3),
            1e-3,
            rounded,
        ),
        (
            "in micrometres",
            first.clone().moved(|place| place * 1e3),
            1e3,
            rounded,
        ),
        (
            "next to nothing",
            first.clone().moved(|place| place * 1e-9),
            1e-9,
            rounded,
        ),
        (
            "twice as large",
            first.clone().moved(|place| place * 2.0),
            2.0,
            exact,
        ),
        (
            "far away",
            first.clone().moved(|place| place + 1e6),
            1.0,
            rounded,
        ),
        (
            "farther away",
            first.clone().moved(|place| place + 1e9),
            1.0,
            rounded,
        ),
        ("with a hole", holed, 1.0, 1e-3),
    ];
    for (name, surface, scale, within) in table {
        let found = analysis(&surface.write(folder.path(), &format!("{name}.obj")), &[]);
        for (found, expected) in measured(&found).into_iter().zip(expected) {
            let off = (found / scale / expected - 1.0).abs();
            assert!(off <= within, "{name}: {found}, {expected} of the first");
        }
    }
}

#[test]
fn caps_that_are_turned_against_their_tube_change_no_measure() {
    let folder = folder();
    let closed = tube().capped();
    let (caps, all) = (tube().faces.len(), closed.faces.len());
    let expected = measured(&analysis(&closed.write(folder.path(), "closed.obj"), &[]));
    for (name, turned) in [("both", caps..all), ("one", caps..caps + 36)] {
        let surface = closed.clone().turned(|place| turned.contains(&place));
        let found = analysis(&surface.write(folder.path(), &format!("{name}.obj")), &[]);
        for (found, expected) in measured(&found).into_iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{name}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn a_tube_of_ten_thousand_radii_is_one_branch() {
    let folder = folder();
    for (name, rows) in [("coarse.obj", 2), ("fine.obj", 1001)] {
        let model = Surface::tube(1e4, 1.0, rows, 12).write(folder.path(), name);
        let [length, radius, whole] = measured(&analysis(&model, &[]));
        // The balls touch the middles of twelve flat sides at least, and the corners at most.
        assert!((0.96..=1.0).contains(&radius), "{name}: {radius}");
        assert!((length - 9998.0).abs() < 0.2, "{name}: {length}");
        assert!((whole - 1e4).abs() < 0.01, "{name}: {whole}");
    }
}

#[test]
fn odd_endpoints_are_used_or_refused_by_their_names() {
    let folder = folder();
    let model = tube().write(folder.path(), "tube.obj");
    let ends = |text: &str| {
        let path = folder.path().join("ends.csv");
        fs::write(&path, text).unwrap();
        ramus()
            .arg("analyze")
            .arg(&model)
            .arg("--json")
            .arg("--targets")
            .arg(&path)
            .output()
            .unwrap()
    };
    for (rows, expected) in [
        (
            "kind,x,y,z\nsource,0,0,0\ntarget,0,0,0\n",
            "tube.obj: target 1 is where the source is",
        ),
        (
            "kind,x,y,z\nsource,0,0,0\ntarget,40,0,0\ntarget,1e9,0,0\n",
            "tube.obj: target 2 at (1000000000, 0, 0) is",
        ),
        (
            "kind,x,y,z\nsource,1e12,0,0\ntarget,40,0,0\n",
            "tube.obj: source at (1000000000000, 0, 0) is",
        ),
        (
            "kind,x,y,z\nsource,nan,0,0\ntarget,40,0,0\n",
            "line 2 of the endpoints has the coordinate NaN",
        ),
        ("a,b,c\n1,2,3\n", "has no column x"),
        ("", "ends.csv"),
    ] {
        refused(&ends(rows), &[expected]);
    }
    // Columns that nobody knows are passed over.
    let output = ends("weight,kind,x,y,z,colour\n1,source,0,0,0,red\n2,target,40,0,0,blue\n");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["centerlines"][0]["name"], "target 1");
    assert!((measured(&found)[2] - 40.0).abs() < 0.01, "{found}");
}

#[test]
fn nothing_is_capped_where_nothing_is_open() {
    let folder = folder();
    let mut closed = tube();
    for (ring, middle) in [(0, 0.0), (40 * 36, 40.0)] {
        let centre = closed.corners.len();
        closed.corners.push(DVec3::new(middle, 0.0, 0.0));
        let cap = (0..36).map(|place| [centre, ring + place, ring + (place + 1) % 36]);
        // Both show the same side to the outside as the wall.
        let cap = Surface {
            corners: Vec::new(),
            faces: cap.collect(),
        };
        closed.faces.extend(cap.turned(|_| ring == 0).faces);
    }
    let model = closed.write(folder.path(), "closed.obj");
    let output = ramus()
        .arg("analyze")
        .arg(&model)
        .args(["--cap", "--json"])
        .output();
    let output = output.unwrap();
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("--cap changes nothing"), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["endpoints"]["capped"], 0);
    assert_eq!(measured(&found), measured(&analysis(&model, &[])));
}
