//! Files that a model names: those beside it are read, and no others.

use std::fs;
use std::path::Path;

use super::*;

fn open(path: &Path) -> Result<Model, MeshError> {
    super::super::super::read(path, &ReadLimits::default(), &AtomicBool::new(false))
}

#[test]
fn files_beside_the_model_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let made = painted::painted();
    fs::create_dir(folder.path().join("a b")).unwrap();
    fs::write(folder.path().join("a b/tree.bin"), &made.binary).unwrap();
    fs::write(folder.path().join("moss.png"), painted::png()).unwrap();
    let path = folder.path().join("tree.gltf");
    for uri in ["a%20b/tree.bin", "./a b/tree.bin", "a b/tree.bin"] {
        let mut made = made.clone();
        made.json["images"][0] = json!({ "uri": "moss.png", "name": "moss" });
        fs::write(&path, made.gltf_beside(uri)).unwrap();
        let model = open(&path).unwrap();
        let expected = painted::painted().read();
        assert_eq!(model.mesh, expected.mesh);
        assert_eq!(model.paint, expected.paint);
        assert_eq!(model.remarks, expected.remarks);
    }
}

#[test]
fn files_elsewhere_are_refused_in_a_sentence() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("inner");
    fs::create_dir(&folder).unwrap();
    fs::create_dir(folder.join("sub")).unwrap();
    let made = Made::with_pyramid();
    let secret = outer.path().join("secret.bin");
    for path in [&secret, &folder.join("here.bin")] {
        fs::write(path, &made.binary).unwrap();
    }
    fs::write(folder.join("short.bin"), &made.binary[..50]).unwrap();
    let absolute = secret.to_str().unwrap();
    let path = folder.join("tree.gltf");
    let mut table = vec![
        ("here.bin", ""),
        ("../secret.bin", "is outside of the model's own folder"),
        ("%2e%2e/secret.bin", "is outside of the model's own folder"),
        (
            "sub/../../secret.bin",
            "is outside of the model's own folder",
        ),
        (absolute, "is outside of the model's own folder"),
        (
            "http://a.example/b.bin",
            "is at the address http://a.example/b.bin",
        ),
        ("file:///etc/passwd", "is at the address file:///etc/passwd"),
        ("C:\\tree.bin", "is at the address"),
        (
            "none.bin",
            "buffer 0 of the glTF file names the file none.bin, which is not there",
        ),
        ("none\u{1b}[1m.bin", "names the file none?[1m.bin"),
        ("%00.bin", "which is not there"),
        ("%ff.bin", "is no text"),
        ("sub", "cannot be read"),
        ("short.bin", "announces 96 bytes, but has 50"),
        (
            "data:text/plain,abc",
            "is data that is not written in base64",
        ),
        ("data:;base64,AB*D", "fault in its base64"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(outer.path(), folder.join("up")).unwrap();
        std::os::unix::fs::symlink(folder.join("here.bin"), folder.join("sub/back.bin")).unwrap();
        table.push(("link.bin", "is outside of the model's own folder"));
        table.push(("up/secret.bin", "is outside of the model's own folder"));
        table.push(("sub/back.bin", ""));
    }
    for (uri, told) in table {
        fs::write(&path, made.gltf_beside(uri)).unwrap();
        match open(&path) {
            Ok(model) => {
                assert_pyramid(&model, uri);
                assert_eq!(told, "", "{uri}");
            }
            Err(fault) => {
                let fault = fault.to_string();
                assert!(!told.is_empty() && fault.contains(told), "{uri}: {fault}");
                assert!(fault.ends_with("tree.gltf"), "{fault}");
            }
        }
    }
    let told = fault(&made.gltf_beside("here.bin"));
    assert!(
        told.contains("only the model's own bytes are at hand"),
        "{told}"
    );
    // The limit is for all files together.
    fs::write(&path, made.gltf_beside("here.bin")).unwrap();
    let length = fs::metadata(&path).unwrap().len();
    for (more, is_read) in [(96, true), (95, false)] {
        let limits = ReadLimits {
            bytes: length + more,
            ..ReadLimits::default()
        };
        let read = super::super::super::read(&path, &limits, &AtomicBool::new(false));
        assert_eq!(read.is_ok(), is_read, "{read:?}");
    }
}
