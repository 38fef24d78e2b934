//! Legacy VTK files of both layouts, as text and as bytes.

use super::*;

/// The pyramid as a legacy file, in the old or the new layout.
pub(in crate::mesh::read) fn file(is_text: bool, is_new: bool, point: &str) -> Vec<u8> {
    let mut bytes = format!(
        "# vtk DataFile Version {}\na pyramid\n{}\nDATASET POLYDATA\nFIELD FieldData 1\ntime 1 1 double\n",
        if is_new { "5.1" } else { "3.0" },
        if is_text { "ASCII" } else { "BINARY" }
    )
    .into_bytes();
    let put = |bytes: &mut Vec<u8>, values: &[f64], kind: &str| {
        for value in values {
            match is_text {
                true => bytes.extend(format!("{value} ").into_bytes()),
                false => bytes.extend(number(*value, kind, true)),
            }
        }
        bytes.push(b'\n');
    };
    put(&mut bytes, &[1.5], "Float64");
    let points: Vec<f64> = POINTS.as_flattened().iter().map(|&v| v.into()).collect();
    bytes.extend(format!("POINTS 5 {point}\n").into_bytes());
    let kind = if point == "double" {
        "Float64"
    } else {
        "Float32"
    };
    put(&mut bytes, &points, kind);
    bytes.extend(b"METADATA\nINFORMATION 1\nNAME L2 LOCATION vtk\nDATA 2 0 1\n\n");
    let cells = |bytes: &mut Vec<u8>, name: &str, cells: &[&[u32]]| {
        let points: usize = cells.iter().map(|cell| cell.len()).sum();
        let flat = |cell: &&[u32]| cell.iter().map(|&p| f64::from(p)).collect::<Vec<f64>>();
        if !is_new {
            let count = points + cells.len();
            bytes.extend(format!("{name} {} {count}\n", cells.len()).into_bytes());
            let lists = cells
                .iter()
                .map(|cell| [vec![cell.len() as f64], flat(cell)].concat());
            put(bytes, &lists.collect::<Vec<_>>().concat(), "Int32");
            return;
        }
        let mut ends = vec![0.0];
        for cell in cells {
            ends.push(ends[ends.len() - 1] + cell.len() as f64);
        }
        bytes
            .extend(format!("{name} {} {points}\nOFFSETS vtktypeint64\n", ends.len()).into_bytes());
        put(bytes, &ends, "Int64");
        bytes.extend(b"CONNECTIVITY vtktypeint64\n");
        put(
            bytes,
            &cells.iter().map(flat).collect::<Vec<_>>().concat(),
            "Int64",
        );
    };
    cells(&mut bytes, "VERTICES", &[&[0], &[1]]);
    cells(&mut bytes, "LINES", &[&[0, 1, 2]]);
    cells(&mut bytes, "POLYGONS", &FACES);
    bytes.extend(b"POINT_DATA 5\nSCALARS a float\nLOOKUP_TABLE default\n");
    put(&mut bytes, &[1.0, 2.0, 3.0, 4.0, 5.0], "Float32");
    bytes
}

#[test]
fn legacy_files_are_read_in_both_layouts() {
    for is_text in [true, false] {
        for is_new in [true, false] {
            for point in ["float", "double"] {
                let told = format!("{is_text} {is_new} {point}");
                let model = read(&file(is_text, is_new, point));
                let model = model.unwrap_or_else(|fault| panic!("{told}: {fault}"));
                assert_eq!(model.format, Format::Vtk);
                assert_pyramid(&model, &told);
                assert_eq!(model.skipped_points, 2);
                assert_eq!(model.skipped_lines, 1);
            }
        }
    }
    let strips = "# vtk DataFile Version 1.0\r\n\r\nascii\r\ndataset polydata\r\npoints 4 float\r\n0 0 0 1 0 0 0 1 0 1 1 0\r\ntriangle_strips 1 5\r\n4 0 1 2 3";
    let model = read(strips.as_bytes()).unwrap();
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn faults_of_legacy_files_are_told_with_their_place() {
    let good = String::from_utf8(file(true, false, "float")).unwrap();
    let new = String::from_utf8(file(true, true, "float")).unwrap();
    let swap = |good: &str, from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1).into_bytes()
    };
    let old = |from: &str, to: &str| swap(&good, from, to);
    let binary = file(false, true, "double");
    for (file, told) in [
        (
            old("3.0", "6.0"),
            "line 1 of the legacy VTK file names no version from 1.0 to 5.1",
        ),
        (
            old("ASCII", "TEXT"),
            "line 3 of the legacy VTK file has neither ASCII nor BINARY",
        ),
        (
            old("DATASET POLYDATA", "DATASET UNSTRUCTURED_GRID"),
            "line 4 of the legacy VTK file has the dataset `UNSTRUCTURED_GRID`, and POLYDATA is read: extract the surface as PolyData",
        ),
        (
            old("POINTS 5", "POINTS 99999999"),
            "line 8 of the legacy VTK file announces 299999997 numbers",
        ),
        (
            old("POINTS 5", "POINTS 123456789012"),
            "the model has more than the 100000000 vertices",
        ),
        (
            old("POINTS 5", "POINTS 4"),
            "line 9 of the legacy VTK file has `0` where a section begins",
        ),
        (
            old("POINTS 5", "POINTS 6"),
            "line 10 of the legacy VTK file has `METADATA` where a number stands",
        ),
        (
            old("POINTS 5 float", "POINTS 5 quad"),
            "line 8 of the legacy VTK file has numbers of the type `quad`",
        ),
        (
            old("-1 -1 0 1", "-1 inf 0 1"),
            "line 9 of the legacy VTK file has the coordinate inf",
        ),
        (
            old("POLYGONS 5 21", "POLYGONS 4 21"),
            "begins a list of 4 cells that goes on behind the last",
        ),
        (
            old("POLYGONS 5 21", "POLYGONS 6 21"),
            "of which cell 5 is longer than the list",
        ),
        (
            old("3 0 1 4 3 1", "3 0 1 5 3 1"),
            "names the point 5, but there are 5, counted from 0",
        ),
        (
            old("3 0 1 4 3 1", "3 0 -1 4 3 1"),
            "has -1 where a cell's end",
        ),
        (
            old("3 0 1 4 3 1", "300 0 1 4 3 1"),
            "of which cell 0 is longer than the list",
        ),
        (
            old("POLYGONS", "TETRAHEDRA"),
            "has `TETRAHEDRA` where a section begins",
        ),
        (
            old("time 1 1 double", "time 1 1 string"),
            "has numbers of the type `string`",
        ),
        (
            old("METADATA", "POINTS 5 float\n"),
            "begins points for a second time",
        ),
        (
            swap(&new, "0 3 6 9 12 16", "0 3 6 9 12 15"),
            "offsets do not run from 0 to the 16 points",
        ),
        (
            swap(&new, "0 3 6 9 12 16", "1 3 6 9 12 16"),
            "offsets do not run from 0 to the 16 points",
        ),
        (
            swap(&new, "0 3 6 9 12 16", "0 9 6 9 12 16"),
            "in which cell 1 ends at 6, before it begins",
        ),
        (
            swap(&new, "CONNECTIVITY", "CONNECTION"),
            "has no CONNECTIVITY",
        ),
        (
            binary[..binary.len() - 200].to_vec(),
            "byte 498 of the legacy VTK file announces 16 numbers",
        ),
        (
            b"# vtk DataFile Version 3.0\n".to_vec(),
            "has neither ASCII nor BINARY",
        ),
        (
            b"# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\n".to_vec(),
            "has 0 vertices and no triangle",
        ),
    ] {
        let found = fault(&file);
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}
