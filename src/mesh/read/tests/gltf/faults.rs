//! What is wrong is refused in one sentence, at once, and before memory is taken.

use std::time::{Duration, Instant};

use super::*;

/// A change of a good file.
type Wrong = fn(&mut Made);

#[test]
fn faults_are_told_with_their_place() {
    let table: &[(Wrong, &str)] = &[
        (
            |made| made.json["accessors"][0]["count"] = json!(6),
            "accessor 0 of the GLB file announces 6 elements of 12 bytes from byte 0 of buffer view 0 on, which has 60 bytes",
        ),
        (
            |made| made.json["accessors"][0]["count"] = json!(u64::MAX),
            "more than the 100000000 vertices",
        ),
        (
            |made| made.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
            "announces 5 elements",
        ),
        (
            |made| made.json["accessors"][0]["type"] = json!("VEC2"),
            "accessor 0 of the GLB file has no positions",
        ),
        (
            |made| made.json["accessors"][0]["componentType"] = json!(5130),
            "has a type that glTF does not have",
        ),
        (
            |made| made.json["accessors"][0]["bufferView"] = json!(8),
            "buffer view 8 of the GLB file is not there, there are 2",
        ),
        (
            |made| {
                made.json["accessors"][0]
                    .as_object_mut()
                    .unwrap()
                    .remove("bufferView");
                made.json["accessors"][0]["count"] = json!(99_999_999);
            },
            "no buffer view that holds them",
        ),
        (
            |made| made.json["accessors"][1]["componentType"] = json!(FLOAT),
            "accessor 1 of the GLB file has no indices",
        ),
        (
            |made| made.json["accessors"][1]["type"] = json!("VEC3"),
            "has no indices",
        ),
        (
            |made| made.binary[60] = 5,
            "accessor 1 of the GLB file names the vertex 5, but there are 5",
        ),
        (
            |made| made.json["meshes"][0]["primitives"][0]["indices"] = json!(7),
            "accessor 7 of the GLB file is not there, there are 2",
        ),
        (
            |made| made.json["meshes"][0]["primitives"][0]["mode"] = json!(9),
            "mesh 0 of the GLB file has a primitive of a mode",
        ),
        (
            |made| made.binary[28..32].copy_from_slice(&f32::NAN.to_le_bytes()),
            "accessor 0 of the GLB file has the coordinate NaN in element 2",
        ),
        (
            |made| made.json["nodes"][0]["scale"] = json!([1e20, 1, 1]),
            "has the coordinate -100000002004087730000 in element 0",
        ),
        (
            |made| made.json["nodes"][0]["scale"] = json!([1e39, 1, 1]),
            "is no JSON of a glTF file (number out of range)",
        ),
        (
            |made| {
                let node = |child: usize| json!({ "scale": [1e38, 1, 1], "children": [child] });
                let mut nodes: Vec<Value> = (1..10).map(node).collect();
                nodes.push(json!({ "mesh": 0 }));
                made.json["nodes"] = nodes.into();
            },
            "node 8 of the GLB file stands nowhere",
        ),
        (
            |made| made.json["bufferViews"][0]["byteLength"] = json!(1000),
            "buffer view 0 of the GLB file announces 1000 bytes",
        ),
        (
            |made| made.json["bufferViews"][0]["byteStride"] = json!(4),
            "has elements of 12 bytes, one begun 4 bytes behind the other",
        ),
        (
            |made| made.json["bufferViews"][0]["buffer"] = json!(3),
            "buffer 3 of the GLB file is not there, there are 1",
        ),
        (
            |made| made.json["nodes"][0]["mesh"] = json!(3),
            "node 0 of the GLB file shows mesh 3, but there are 1",
        ),
        (
            |made| made.json["nodes"][0]["children"] = json!([0]),
            "node 0 of the GLB file is below itself, as all nodes are",
        ),
        (
            |made| made.json["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]),
            "node 1 of the GLB file is in the scene twice",
        ),
        (
            |made| {
                made.json["nodes"] =
                    json!([{ "children": [2] }, { "children": [2] }, { "mesh": 0 }])
            },
            "node 2 of the GLB file is in the scene twice",
        ),
        (
            |made| {
                made.json["nodes"] = json!([{ "children": [1] }, { "children": [0] }]);
                made.json["scenes"] = json!([{ "nodes": [0] }]);
                made.json["scene"] = json!(0);
            },
            "node 0 of the GLB file is in the scene twice",
        ),
        (
            |made| made.json["nodes"][0]["children"] = json!([9]),
            "node 9 of the GLB file is named, but there are 1",
        ),
        (
            |made| made.json["scene"] = json!(4),
            "scene 4 of the GLB file is to be shown, but there are 0",
        ),
        (
            |made| made.json["asset"]["version"] = json!("1.0"),
            "begins a description in glTF 1.0, and 2.0 is read",
        ),
        (
            |made| made.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
            "needs the extension KHR_draco_mesh_compression, which is not read: export the model without compression",
        ),
        (
            |made| made.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]),
            "EXT_meshopt_compression, which is not read: export the model without compression",
        ),
        (
            |made| made.json["extensionsRequired"] = json!(["KHR_meshopt_compression"]),
            "KHR_meshopt_compression, which is not read: export the model without compression",
        ),
        (
            |made| made.json["extensionsRequired"] = json!(["VENDOR_\u{7}x"]),
            "needs the extension VENDOR_?x, which is not read: export the model without it",
        ),
        (
            |made| {
                made.json["accessors"][0]
                    .as_object_mut()
                    .unwrap()
                    .remove("bufferView");
                made.json["meshes"][0]["primitives"][0]["extensions"] =
                    json!({ "KHR_draco_mesh_compression": {} });
            },
            "KHR_draco_mesh_compression, which is not read",
        ),
        (
            |made| {
                made.json["bufferViews"][0]["buffer"] = json!(1);
                made.json["bufferViews"][0]["extensions"] =
                    json!({ "EXT_meshopt_compression": {} });
            },
            "EXT_meshopt_compression, which is not read",
        ),
        (
            |made| made.json["accessors"][0]["sparse"] = json!({ "count": 99, "indices": { "bufferView": 1, "componentType": UNSIGNED_BYTE }, "values": { "bufferView": 0 } }),
            "accessor 0 of the GLB file announces 99 elements of 1 bytes",
        ),
        (
            |made| made.json["accessors"][0]["sparse"] = json!({ "count": 1, "indices": { "bufferView": 0, "byteOffset": 3, "componentType": UNSIGNED_BYTE }, "values": { "bufferView": 0 } }),
            "has a sparse value for element 191, but there are 5",
        ),
    ];
    for (wrong, told) in table {
        let mut made = Made::with_pyramid();
        wrong(&mut made);
        let found = made.fault();
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
}

#[test]
fn damaged_containers_are_refused_with_the_byte() {
    let good = Made::with_pyramid().glb();
    let with = |at: usize, new: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        bytes
    };
    for (bytes, told) in [
        (
            with(4, &[1]),
            "byte 4 of the GLB file says that this is version 1",
        ),
        (
            good[..good.len() - 4].to_vec(),
            "byte 8 of the GLB file announces a file of",
        ),
        (
            with(12, &[0xFF; 4]),
            "byte 12 of the GLB file announces a chunk of 4294967295 bytes",
        ),
        (
            with(16, b"BIN\0"),
            "byte 12 of the GLB file begins a chunk that is no JSON",
        ),
        (
            with(22, b"\x01"),
            "byte 22 of the GLB file is no JSON of a glTF file",
        ),
        (
            b"glTF\x02\0\0\0".to_vec(),
            "byte 8 of the GLB file is the end",
        ),
        (container(r#"{"asset":{}}"#, &[]), "missing field `version`"),
        (
            container(
                &format!(
                    r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"extensions":{{"x":{}{}}}}}]}}"#,
                    "[".repeat(1000),
                    "]".repeat(1000)
                ),
                &[],
            ),
            "recursion limit",
        ),
    ] {
        let found = fault(&bytes);
        assert!(found.contains(told), "{found}\nis not\n{told}");
    }
    let text = String::from_utf8(Made::with_pyramid().gltf()).unwrap();
    let line = text
        .lines()
        .position(|line| line.contains("\"nodes\""))
        .unwrap()
        + 1;
    let found = fault(text.replace("\"nodes\": [", "\"nodes\": [?").as_bytes());
    assert!(
        found.starts_with(&format!("line {line} of the glTF file is no JSON")),
        "{found}"
    );
    // Bytes behind the announced length are nobody's.
    assert!(read(&[&good[..], b"more"].concat()).is_ok());
}

#[test]
fn what_multiplies_is_refused_before_memory_is_taken() {
    let deep = |count: usize| {
        let mut made = Made::new();
        let mesh = made.pyramid();
        let nodes =
            (0..count).map(|node| json!({ "children": [node + 1], "translation": [1, 0, 0] }));
        made.json["nodes"] = nodes.chain([json!({ "mesh": mesh })]).collect();
        made
    };
    let begun = Instant::now();
    let model = deep(30_000).read();
    assert_eq!(
        model.mesh.origin.x + f64::from(model.mesh.positions[4].x),
        30_000.0
    );
    // A million times a million triangles of a few bytes.
    let mut made = Made::new();
    let points = made.points();
    let indices = made.accessor(UNSIGNED_BYTE, "SCALAR", &vec![0.0; 3000]);
    let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
    let mesh = made.add("meshes", json!({ "primitives": vec![primitive; 1000] }));
    for _ in 0..2000 {
        made.add("nodes", json!({ "mesh": mesh }));
    }
    assert!(
        made.fault().contains("more than the 100000000 triangles"),
        "{}",
        made.fault()
    );
    let mut made = Made::with_pyramid();
    let places = made.accessor(FLOAT, "VEC3", &vec![0.0; 30_000]);
    let instances =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    for _ in 0..2000 {
        made.add("nodes", json!({ "mesh": 0, "extensions": instances }));
    }
    assert!(made.fault().contains("more than the 100000000 vertices"));
    // Sparse accessors that are zeros but for one value, thousands of them.
    let mut made = Made::new();
    made.view(&vec![0; 400_000]);
    let sparse = json!({ "count": 1, "indices": { "bufferView": 0, "componentType": UNSIGNED_BYTE }, "values": { "bufferView": 0 } });
    for number in 0..4000 {
        made.add(
            "accessors",
            json!({ "componentType": BYTE, "type": "VEC3", "count": 300_000, "sparse": sparse }),
        );
        let attributes = json!({ "attributes": { "SCALE": number } });
        made.add(
            "nodes",
            json!({ "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": attributes } }),
        );
    }
    made.add("meshes", json!({ "primitives": [] }));
    assert!(made.fault().contains("one sparse accessor too many"));
    let objects = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{}{{}}]}}"#,
        "{},".repeat(1_100_000)
    );
    assert!(fault(objects.as_bytes()).contains("more than 1048576 objects"));
    let taken = begun.elapsed();
    assert!(taken < Duration::from_secs(30), "took {taken:?}");
}
