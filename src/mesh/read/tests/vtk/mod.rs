//! VTK PolyData as XML, in all encodings.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::*;

pub(super) mod legacy;
mod lines;

/// Where arrays stand in an XML file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stand {
    Ascii,
    Inline,
    /// In lines of 76 letters, as others than VTK write it.
    Broken,
    /// The length of an array as base64 by itself, as others than VTK write it.
    Apart,
    Raw,
    Base64,
}

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Way {
    stand: Stand,
    compressor: &'static str,
    is_big: bool,
    has_long_headers: bool,
    point: &'static str,
    index: &'static str,
    /// Bytes of a block.
    block: usize,
}

const PLAIN: Way = Way {
    stand: Stand::Ascii,
    compressor: "",
    is_big: false,
    has_long_headers: false,
    point: "Float32",
    index: "Int64",
    block: 32,
};

const ZLIB: &str = "vtkZLibDataCompressor";
const LZ4: &str = "vtkLZ4DataCompressor";

/// A number as a file has it.
fn number(value: f64, kind: &str, is_big: bool) -> Vec<u8> {
    let whole = value as i64;
    let mut bytes = match kind {
        "Int8" => (whole as i8).to_le_bytes().to_vec(),
        "UInt8" => (whole as u8).to_le_bytes().to_vec(),
        "Int16" => (whole as i16).to_le_bytes().to_vec(),
        "UInt16" => (whole as u16).to_le_bytes().to_vec(),
        "Int32" => (whole as i32).to_le_bytes().to_vec(),
        "UInt32" => (whole as u32).to_le_bytes().to_vec(),
        "Int64" => whole.to_le_bytes().to_vec(),
        "UInt64" => (whole as u64).to_le_bytes().to_vec(),
        "Float32" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    if is_big {
        bytes.reverse();
    }
    bytes
}

fn packed(bytes: &[u8], compressor: &str) -> Vec<u8> {
    if compressor == LZ4 {
        return lz4_flex::block::compress(bytes);
    }
    let mut room = vec![0; bytes.len() + 64];
    let config = zlib_rs::DeflateConfig::default();
    let (made, ended) = zlib_rs::compress_slice(&mut room, bytes, config);
    assert_eq!(ended, zlib_rs::ReturnCode::Ok);
    made.to_vec()
}

impl Way {
    fn word(&self, value: usize) -> Vec<u8> {
        let kind = ["UInt32", "UInt64"][usize::from(self.has_long_headers)];
        number(value as f64, kind, self.is_big)
    }

    /// The bytes of an array, header and all, in the parts that are base64 by themselves.
    fn parts(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        if self.compressor.is_empty() {
            let header = self.word(bytes.len());
            return match self.stand {
                Stand::Apart => vec![header, bytes.to_vec()],
                _ => vec![[&header, bytes].concat()],
            };
        }
        let blocks: Vec<&[u8]> = bytes.chunks(self.block).collect();
        let last = bytes.len() % self.block;
        let packed: Vec<Vec<u8>> = blocks
            .iter()
            .map(|block| packed(block, self.compressor))
            .collect();
        let lengths = packed.iter().map(Vec::len);
        let header = [blocks.len(), self.block, last].into_iter().chain(lengths);
        vec![
            header.flat_map(|word| self.word(word)).collect(),
            packed.concat(),
        ]
    }

    /// An element with numbers, which may go to what is appended.
    fn array(&self, name: &str, kind: &str, values: &[f64], appended: &mut Vec<u8>) -> String {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|&value| number(value, kind, self.is_big))
            .collect();
        let base64 = |bytes: &[u8]| -> String {
            let parts = self.parts(bytes);
            parts.iter().map(|part| STANDARD.encode(part)).collect()
        };
        let components = if name == "Points" { 3 } else { 1 };
        let tag = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\""
        );
        let key = "<InformationKey name=\"a\"> 1 2 </InformationKey>";
        match self.stand {
            Stand::Ascii => {
                let values: Vec<String> = values.iter().map(f64::to_string).collect();
                format!(
                    "{tag} format=\"ascii\">\n{key}\n{}\n</DataArray>\n",
                    values.join(" ")
                )
            }
            Stand::Inline | Stand::Apart => {
                format!(
                    "{tag} format=\"binary\">\n{key}\n{}\n</DataArray>\n",
                    base64(&bytes)
                )
            }
            Stand::Broken => {
                let letters = base64(&bytes).into_bytes();
                let lines = letters.chunks(76).map(String::from_utf8_lossy);
                let lines = lines.collect::<Vec<_>>().join("\n   ");
                format!("{tag} format=\"binary\">\n{lines}\n</DataArray>\n")
            }
            Stand::Raw | Stand::Base64 => {
                let offset = appended.len();
                match self.stand {
                    Stand::Raw => appended.extend(self.parts(&bytes).concat()),
                    _ => appended.extend(base64(&bytes).into_bytes()),
                }
                format!("{tag} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    }

    fn cells(&self, cells: &[&[u32]], appended: &mut Vec<u8>) -> String {
        let points: Vec<f64> = cells.concat().into_iter().map(f64::from).collect();
        let mut end = 0.0;
        let ends = cells.iter().map(|cell| {
            end += cell.len() as f64;
            end
        });
        let ends: Vec<f64> = ends.collect();
        self.array("connectivity", self.index, &points, appended)
            + &self.array("offsets", self.index, &ends, appended)
    }

    fn piece(&self, piece: &Piece<'_>, appended: &mut Vec<u8>) -> String {
        let points: Vec<f64> = piece
            .points
            .as_flattened()
            .iter()
            .map(|&value| value.into())
            .collect();
        let mut text = format!(
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"{}\" NumberOfPolys=\"{}\">\n<PointData>",
            piece.points.len(),
            piece.vertices.len(),
            piece.lines.len(),
            piece.strips.len(),
            piece.polygons.len()
        );
        text += &self.array("connectivity", "Float32", &[0.5, 0.25], appended);
        text += "</PointData><Points>\n";
        text += &self.array("Points", self.point, &points, appended);
        text += "</Points>\n";
        for (name, cells) in [
            ("Verts", piece.vertices),
            ("Lines", piece.lines),
            ("Strips", piece.strips),
            ("Polys", piece.polygons),
        ] {
            text += &format!("<{name}>\n{}</{name}>\n", self.cells(cells, appended));
        }
        text + "</Piece>\n"
    }

    fn file(&self, pieces: &[Piece<'_>]) -> Vec<u8> {
        let mut appended = Vec::new();
        let pieces: String = pieces
            .iter()
            .map(|piece| self.piece(piece, &mut appended))
            .collect();
        let order = ["LittleEndian", "BigEndian"][usize::from(self.is_big)];
        let header = ["UInt32", "UInt64"][usize::from(self.has_long_headers)];
        let mut bytes = format!(
            "<?xml version=\"1.0\"?>\n<!-- made -->\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{order}\" header_type=\"{header}\" compressor=\"{}\">\n<PolyData>\n<FieldData><DataArray type=\"Float64\" format=\"ascii\"> 1 </DataArray></FieldData>\n{pieces}</PolyData>\n",
            self.compressor
        )
        .into_bytes();
        if matches!(self.stand, Stand::Raw | Stand::Base64) {
            let encoding = ["raw", "base64"][usize::from(self.stand == Stand::Base64)];
            bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n   _").into_bytes());
            bytes.extend(appended);
            bytes.extend(b"\n</AppendedData>\n");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }
}

/// A part of a file.
#[derive(Clone, Copy, Default)]
struct Piece<'a> {
    points: &'a [[f32; 3]],
    vertices: &'a [&'a [u32]],
    lines: &'a [&'a [u32]],
    strips: &'a [&'a [u32]],
    polygons: &'a [&'a [u32]],
}

fn pyramid() -> Piece<'static> {
    Piece {
        points: &POINTS,
        polygons: &FACES,
        ..Piece::default()
    }
}

/// The pyramid as XML text.
pub(super) fn xml() -> Vec<u8> {
    PLAIN.file(&[pyramid()])
}

/// The pyramid as XML with compressed blocks behind it.
pub(super) fn zlib() -> Vec<u8> {
    let way = Way {
        stand: Stand::Raw,
        compressor: ZLIB,
        ..PLAIN
    };
    way.file(&[pyramid()])
}

#[test]
fn xml_is_read_in_all_encodings() {
    let three: Vec<&[u32]> = TRIANGLES.iter().map(<[u32; 3]>::as_slice).collect();
    let mut read_ways = 0;
    for stand in [
        Stand::Ascii,
        Stand::Inline,
        Stand::Broken,
        Stand::Apart,
        Stand::Raw,
        Stand::Base64,
    ] {
        for compressor in ["", ZLIB, LZ4] {
            for (is_big, has_long_headers) in
                [(false, false), (false, true), (true, false), (true, true)]
            {
                for (point, index) in [
                    ("Float32", "Int64"),
                    ("Float64", "Int32"),
                    ("Float32", "UInt8"),
                    ("Float64", "UInt16"),
                    ("Float32", "UInt32"),
                    ("Float64", "UInt64"),
                    ("Float32", "Int8"),
                    ("Float64", "Int16"),
                ] {
                    let way = Way {
                        stand,
                        compressor,
                        is_big,
                        has_long_headers,
                        point,
                        index,
                        block: 32,
                    };
                    for polygons in [&FACES[..], &three] {
                        let piece = Piece {
                            polygons,
                            ..pyramid()
                        };
                        let model = read(&way.file(&[piece]));
                        let model = model.unwrap_or_else(|fault| panic!("{way:?}: {fault}"));
                        assert_eq!(model.format, Format::Vtp);
                        assert_pyramid(&model, &format!("{way:?}"));
                        read_ways += 1;
                    }
                }
            }
        }
    }
    assert_eq!(read_ways, 6 * 3 * 4 * 8 * 2);
}

#[test]
fn pieces_strips_lines_and_points_are_told_apart() {
    let strips: [&[u32]; 2] = [&[0, 1, 2, 3, 4], &[1, 2]];
    let lines: [&[u32]; 2] = [&[0, 1, 2], &[3, 4]];
    let vertices: [&[u32]; 1] = [&[0, 1, 2]];
    let second = Piece {
        points: &POINTS[..4],
        polygons: &[&[0, 1, 2], &[1], &[0, 1, 2, 3]],
        ..Piece::default()
    };
    let first = Piece {
        strips: &strips,
        lines: &lines,
        vertices: &vertices,
        ..pyramid()
    };
    let expected: Vec<[u32; 3]> = [
        &TRIANGLES[..],
        &[[0, 1, 2], [2, 1, 3], [2, 3, 4]],
        &[[5, 6, 7], [5, 6, 7], [5, 7, 8]],
    ]
    .concat();
    for stand in [Stand::Ascii, Stand::Inline, Stand::Raw] {
        let way = Way { stand, ..PLAIN };
        let model = read(&way.file(&[first, Piece::default(), second])).unwrap();
        assert_eq!(model.mesh.triangles, expected);
        assert_eq!(model.mesh.positions.len(), 9);
        assert_eq!(model.skipped_faces, 2);
        assert_eq!(model.skipped_lines, 2);
        assert_eq!(model.skipped_points, 1);
    }
    let only_lines = Piece {
        lines: &lines,
        points: &POINTS,
        ..Piece::default()
    };
    let told = fault(&PLAIN.file(&[only_lines]));
    assert!(
        told.starts_with("the VTP file has 2 lines and no triangle, as centerlines"),
        "{told}"
    );
}

#[test]
fn faults_of_xml_are_told_with_their_place() {
    let good = String::from_utf8(xml()).unwrap();
    let swapped = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1).into_bytes()
    };
    let inline = String::from_utf8(
        Way {
            stand: Stand::Inline,
            ..PLAIN
        }
        .file(&[pyramid()]),
    )
    .unwrap();
    let points = good
        .lines()
        .position(|line| line.contains("Name=\"Points\""))
        .unwrap()
        + 1;
    let deep = "<a>".repeat(500_000);
    for (file, told) in [
        (swapped("PolyData\" v", "UnstructuredGrid\" v"), "line 3 of the VTP file begins a VTK file of the type `UnstructuredGrid`, and PolyData is read: extract the surface".to_owned()),
        (swapped("byte_order=\"LittleEndian\"", "byte_order=\"Middle\""), "line 3 of the VTP file has the byte order `Middle`".into()),
        (swapped("header_type=\"UInt32\"", "header_type=\"Int8\""), "has the header type `Int8`".into()),
        (swapped("compressor=\"\"", "compressor=\"vtkLZMADataCompressor\""), "has the compressor `vtkLZMADataCompressor`, and vtkZLibDataCompressor, vtkLZ4DataCompressor or none are read".into()),
        (swapped("<!-- made -->", "<!DOCTYPE a [<!ENTITY b \"c\">]>"), "line 2 of the VTP file has a document type".into()),
        (swapped("<PolyData>", "<PolyData>&b;"), "line 4 of the VTP file has an entity".into()),
        (swapped("NumberOfPoints=\"5\"", "NumberOfPoints=\"-5\""), "line 6 of the VTP file has `-5` as NumberOfPoints".into()),
        (swapped("NumberOfPoints=\"5\"", "NumberOfPoints=\"6\""), "is the end, amid numbers".into()),
        (swapped("NumberOfPoints=\"5\"", "NumberOfPoints=\"4\""), format!("line {points} of the VTP file begins an array of more numbers where 12 are needed")),
        (swapped("NumberOfPoints=\"5\"", "NumberOfPoints=\"99999999\""), format!("line {points} of the VTP file begins an array of fewer numbers where 299999997 are needed")),
        (swapped("NumberOfPoints=\"5\"", "NumberOfPoints=\"18446744073709551615\""), "the model has more than the 100000000 vertices".into()),
        (swapped("Name=\"Points\" NumberOfComponents=\"3\"", "Name=\"Points\" NumberOfComponents=\"2\""), "begins an array of points with 2 components".into()),
        (swapped("-1 -1 0 1", "-1 nan 0 1"), format!("line {} of the VTP file has the coordinate NaN", points + 2)),
        (swapped("-1 -1 0 1", "-1 1e300 0 1"), "has the coordinate 1e300:".into()),
        (swapped("-1 -1 0 1", "-1 x 0 1"), "has `x` where a number stands".into()),
        (swapped("0 1 4 1 2 4", "0 1 5 1 2 4"), "names the point 5, but there are 5, counted from 0".into()),
        (swapped("0 1 4 1 2 4", "0 1 -4 1 2 4"), "has -4 where a cell's end or the number of a point stands".into()),
        (swapped("3 6 9 12 16", "3 9 6 12 16"), "in which cell 2 ends at 6, before it begins".into()),
        (swapped("3 6 9 12 16", "3 6 9 12 17"), "is the end, amid numbers".into()),
        (swapped("3 6 9 12 16", "3 6 9 12 4294967295"), "begins an array of fewer numbers where 4294967295 are needed".into()),
        (good.replace("type=\"Int64\" Name=\"offsets\"", "type=\"Float32\" Name=\"offsets\"").into_bytes(), "no whole numbers".to_owned()),
        (swapped("type=\"Float32\" Name=\"Points\"", "type=\"String\" Name=\"Points\""), "has the type of numbers `String`".into()),
        (swapped("</Points>", "</Pints>"), "is no XML that holds together".into()),
        (swapped("<PolyData>", &deep), "is no XML that holds together".into()),
        (format!("<VTKFile type=\"PolyData\">{deep}").into_bytes(), "is the end, amid the XML".into()),
        (good.as_bytes()[..good.len() - 12].to_vec(), "is the end, amid the XML".into()),
        (good.replace("Polys>", "Cells>").into_bytes(), "announces 5 cells and has not both their arrays".into()),
        (good.replace("<Points>", "<P>").replace("</Points>", "</P>").into_bytes(), "announces 5 points and has no array of them".into()),
        (format!("<VTKFile type=\"PolyData\"><PolyData>{}", "<Piece/>".repeat(70_000)).into_bytes(), "begins one piece more than the 65536".into()),
        (inline.replace("format=\"binary\"", "format=\"appended\"").into_bytes(), "goes on behind the end of its bytes".into()),
        (inline.replace("NumberOfPoints=\"5\"", "NumberOfPoints=\"6\"").into_bytes(), "begins an array of 15 numbers where 18 are needed".into()),
    ] {
        let found = fault(&file);
        assert!(found.contains(&told), "{found}\nis not\n{told}");
    }
}

/// A file of one triangle whose points are raw, given from their header on.
fn raw_points(compressor: &str, count: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = format!(
        "<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"{compressor}\"><PolyData><Piece NumberOfPoints=\"{count}\" NumberOfPolys=\"1\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points><Polys><DataArray type=\"Int8\" Name=\"connectivity\">0 1 2</DataArray><DataArray type=\"Int8\" Name=\"offsets\">3</DataArray></Polys></Piece></PolyData><AppendedData encoding=\"raw\">_"
    )
    .into_bytes();
    file.extend(bytes);
    file
}

fn words(words: &[u64]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn blocks_make_what_is_announced_and_no_more() {
    let corners: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    for compressor in [ZLIB, LZ4] {
        let block = packed(&corners, compressor);
        let length = block.len() as u64;
        let with = |header: &[u64], block: &[u8]| {
            raw_points(compressor, 3, &[&words(header), block].concat())
        };
        assert!(read(&with(&[1, 36, 0, length], &block)).is_ok());
        assert!(read(&with(&[1, 4096, 36, length], &block)).is_ok());
        let long = packed(&[&corners[..], &[0; 4096]].concat(), compressor);
        let short = packed(&corners[..32], compressor);
        for (header, block, told) in [
            (
                vec![1, 36, 0, length - 1],
                &block,
                "block 0 does not hold what is announced",
            ),
            (
                vec![1, 36, 0, long.len() as u64],
                &long,
                "block 0 does not hold",
            ),
            (
                vec![1, 36, 0, short.len() as u64],
                &short,
                "block 0 does not hold",
            ),
            (
                vec![1, 36, 0, length + 1],
                &block,
                "goes on behind the end of its bytes",
            ),
            (
                vec![1, 36, 0, u64::MAX],
                &block,
                "goes on behind the end of its bytes",
            ),
            (
                vec![2, 36, 0, length, length],
                &block,
                "do not make the 36 bytes",
            ),
            (vec![0, 0, 0], &block, "do not make the 36 bytes"),
            (vec![1, 32, 36, length], &block, "do not make the 36 bytes"),
            (
                vec![2, 18, 18, length, length],
                &block,
                "which end amid numbers",
            ),
            (
                vec![2, u64::MAX, 36, length, length],
                &block,
                "do not make the 36 bytes",
            ),
            (
                vec![u64::MAX],
                &block,
                "goes on behind the end of its bytes",
            ),
            (
                vec![u64::MAX / 8],
                &block,
                "goes on behind the end of its bytes",
            ),
        ] {
            let found = fault(&with(&header, block));
            assert!(found.contains(told), "{header:?}: {found}\nis not\n{told}");
        }
        // Gigabytes announced of a few bytes.
        let many = 90_000_000;
        let header = words(&[1, 12 * many, 0, length]);
        let found = fault(&raw_points(
            compressor,
            many as usize,
            &[&header[..], &block].concat(),
        ));
        assert!(
            found.contains("block 0 announces 1080000000 bytes, more than"),
            "{found}"
        );
    }
    let many = raw_points("", 90_000_000, &words(&[1_080_000_000]));
    assert!(fault(&many).contains("goes on behind the end of its bytes"));
}

#[test]
fn arrays_that_share_their_bytes_are_refused() {
    let zeros = vec![0; 12_000_000];
    let block = packed(&zeros, ZLIB);
    let header = words(&[1, 12_000_000, 0, block.len() as u64]);
    let one = raw_points(ZLIB, 1_000_000, &[&header[..], &block].concat());
    assert!(read(&one).is_ok());
    let text = String::from_utf8_lossy(&one).into_owned();
    let from = text.find("<Piece").unwrap();
    let end = text.find("</PolyData>").unwrap();
    let piece = &one[from..end];
    let many = [&one[..from], &piece.repeat(50), &one[end..]].concat();
    let found = fault(&many);
    assert!(found.contains("shares its bytes with others"), "{found}");
}

#[test]
fn large_files_are_read_alike_from_memory_and_from_their_arrays() {
    let points: Vec<[f32; 3]> = (0..60_000_u16)
        .map(|number| [f32::from(number), f32::from(number % 7), 1.5])
        .collect();
    // Without a pattern, so that they stay long when they are packed.
    let corner = |number: u32| number.wrapping_mul(2_654_435_769) % 60_000;
    let triangles: Vec<[u32; 3]> = (0..300_000)
        .map(|number| [0, 1, 2].map(|step| corner(3 * number + step)))
        .collect();
    let mut wrong = triangles.clone();
    wrong[70_000] = [1, 60_000, 2];
    wrong[140_000] = [1, 60_001, 2];
    let whole: Vec<&[u32]> = triangles.iter().map(|cell| &cell[..]).collect();
    let mut mixed = whole.clone();
    mixed[100_000] = &[1, 2, 3, 4];
    let wrong: Vec<&[u32]> = wrong.iter().map(|cell| &cell[..]).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.vtp");
    let alike = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let limits = ReadLimits::default();
        let from_file = super::super::read(&path, &limits, &AtomicBool::new(false));
        match (read(bytes), from_file) {
            (Ok(model), Ok(other)) => {
                assert_eq!(model, other);
                String::new()
            }
            (Err(fault), Err(other)) => {
                let told = fault.to_string();
                assert!(
                    other.to_string().starts_with(&told),
                    "{other} is not {told}"
                );
                told
            }
            (one, other) => panic!("{one:?} is not {other:?}"),
        }
    };
    for compressor in ["", LZ4] {
        for is_big in [false, true] {
            let way = Way {
                stand: Stand::Raw,
                compressor,
                is_big,
                block: 1 << 15,
                ..PLAIN
            };
            for (polygons, told) in [
                (&whole, ""),
                (&mixed, ""),
                (&wrong, "names the point 60000"),
            ] {
                let bytes = way.file(&[Piece {
                    points: &points,
                    polygons,
                    ..pyramid()
                }]);
                assert!(bytes.len() > 4 << 20, "{}", bytes.len());
                let fault = alike(&bytes);
                assert!(
                    fault.contains(told) && fault.is_empty() == told.is_empty(),
                    "{fault}"
                );
                let cut = alike(&bytes[..bytes.len() - (300 << 10)]);
                assert!(!cut.is_empty(), "it is cut short");
            }
        }
    }
}
