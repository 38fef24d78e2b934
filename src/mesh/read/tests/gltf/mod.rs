//! glTF and GLB: accessors of every kind, scenes, what hangs on them, and Ramus's own files.

mod beside;
mod faults;
pub(super) mod made;
mod oracle;
mod painted;

use glam::{DAffine3, DQuat, DVec3};
use serde_json::{Value, json};

use self::made::*;
use super::*;

fn values(points: &[[f32; 3]]) -> Vec<f64> {
    points
        .as_flattened()
        .iter()
        .map(|&value| value.into())
        .collect()
}

/// Primitives of one mesh in one node.
fn one_mesh(mut made: Made, primitives: &[Value]) -> Made {
    let mesh = made.add("meshes", json!({ "primitives": primitives }));
    made.add("nodes", json!({ "mesh": mesh }));
    made
}

#[test]
fn the_pyramid_is_read_with_indices_of_each_type() {
    for kind in [UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT] {
        let mut made = Made::new();
        let (points, indices) = (made.points(), made.indices(kind));
        let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
        let model = one_mesh(made, &[primitive]).read();
        assert_pyramid(&model, &kind.to_string());
        assert_eq!(model.scale(), Some(Scale::stated(Unit::Metres)));
        assert_eq!((model.paint, model.remarks), (None, vec![]));
    }
}

#[test]
fn positions_of_each_type_are_read() {
    // What a value of the pyramid, −1, 0, 1 or 1.5, is written as and read back as.
    let table = [
        (FLOAT, false, 1.0, 1.0),
        (BYTE, false, 2.0, 2.0),
        (SHORT, false, 200.0, 200.0),
        (BYTE, true, 84.0, 84.0 / 127.0),
        (SHORT, true, 21_844.0, 21_844.0 / 32_767.0),
    ];
    for (kind, normalized, times, expected) in table {
        let mut made = Made::new();
        let points: Vec<f64> = values(&POINTS).iter().map(|value| value * times).collect();
        let points = made.accessor(kind, "VEC3", &points);
        made.json["accessors"][points]["normalized"] = json!(normalized);
        made.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let indices = made.indices(UNSIGNED_SHORT);
        let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
        let mesh = one_mesh(made, &[primitive]).read().mesh;
        for (found, point) in mesh.positions.iter().zip(POINTS) {
            let point = Vec3::from(point) * expected as f32;
            assert!(found.distance(point) < 1e-6, "{kind} {normalized}: {found}");
        }
    }
    // The lowest of signed parts is not less than −1.
    let mut made = Made::new();
    let points = made.accessor(
        BYTE,
        "VEC3",
        &[-128.0, 0.0, 0.0, 127.0, 0.0, 0.0, 0.0, -127.0, 0.0],
    );
    made.json["accessors"][points]["normalized"] = json!(true);
    let mesh = one_mesh(made, &[json!({ "attributes": { "POSITION": points } })])
        .read()
        .mesh;
    assert_eq!(mesh.positions, [-Vec3::X, Vec3::X, -Vec3::Y]);
}

#[test]
fn vertices_in_rows_with_others_are_found() {
    let mut made = Made::new();
    let mut bytes = vec![0xFF; 8];
    for point in POINTS {
        bytes.extend(point.map(f32::to_le_bytes).as_flattened());
        bytes.extend([0x7F; 8]);
    }
    // The last row has nothing behind its position.
    bytes.truncate(bytes.len() - 8);
    let view = made.view(&bytes);
    made.json["bufferViews"][view]["byteStride"] = json!(20);
    let points = made.add(
        "accessors",
        json!({ "bufferView": view, "byteOffset": 8, "componentType": FLOAT, "type": "VEC3", "count": 5 }),
    );
    let indices = made.indices(UNSIGNED_INT);
    let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
    assert_pyramid(&one_mesh(made, &[primitive]).read(), "in rows of 20 bytes");
}

#[test]
fn sparse_accessors_are_written_out() {
    for has_view in [true, false] {
        let mut made = Made::new();
        let points = made.points();
        if has_view {
            // The top is wrong in the buffer and right in the sparse values.
            let length = made.binary.len();
            made.binary[length - 4..].copy_from_slice(&9_f32.to_le_bytes());
        } else {
            made.json["accessors"][points]
                .as_object_mut()
                .unwrap()
                .remove("bufferView");
        }
        let which = if has_view { 4..5 } else { 0..5 };
        let at: Vec<u8> = which.clone().map(|at| at as u8).collect();
        let at = made.view(&at);
        let new: Vec<u8> = POINTS[which.clone()]
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let new = made.view(&new);
        made.json["accessors"][points]["sparse"] = json!({
            "count": which.len(),
            "indices": { "bufferView": at, "componentType": UNSIGNED_BYTE },
            "values": { "bufferView": new },
        });
        let indices = made.indices(UNSIGNED_BYTE);
        let primitive = json!({ "attributes": { "POSITION": points }, "indices": indices });
        assert_pyramid(
            &one_mesh(made, &[primitive]).read(),
            &format!("view: {has_view}"),
        );
    }
}

#[test]
fn lists_strips_and_fans_make_triangles_and_points_and_lines_are_counted() {
    let table: [(u32, &[[u32; 3]], usize); 7] = [
        (0, &[], 5),
        (1, &[], 2),
        (2, &[], 5),
        (3, &[], 4),
        (4, &[[0, 1, 2]], 0),
        (5, &[[0, 1, 2], [1, 3, 2], [2, 3, 4]], 0),
        (6, &[[1, 2, 0], [2, 3, 0], [3, 4, 0]], 0),
    ];
    for has_indices in [false, true] {
        for (mode, triangles, skipped) in table {
            let mut made = Made::new();
            let points = made.points();
            let mut primitive = json!({ "attributes": { "POSITION": points }, "mode": mode });
            if has_indices {
                let all = made.accessor(UNSIGNED_BYTE, "SCALAR", &[4.0, 3.0, 2.0, 1.0, 0.0]);
                primitive["indices"] = json!(all);
            }
            let made = one_mesh(made, &[primitive]);
            if triangles.is_empty() {
                assert!(
                    made.fault().contains("has 0 vertices and no triangle"),
                    "{mode}"
                );
            } else {
                let model = made.read();
                let corner = |corner: u32| if has_indices { 4 - corner } else { corner };
                let expected: Vec<_> = triangles.iter().map(|all| all.map(corner)).collect();
                assert_eq!(model.mesh.triangles, expected, "{mode}");
            }
            // With a triangle beside it the rest is told.
            let mut made = made;
            let mesh = made.pyramid();
            made.add("nodes", json!({ "mesh": mesh }));
            assert_eq!(made.read().skipped_faces, skipped, "{mode}");
        }
    }
}

#[test]
fn primitives_of_the_same_vertices_share_them() {
    let mut made = Made::new();
    let points = made.points();
    let parts = [[0.0, 1.0, 4.0], [1.0, 2.0, 4.0], [2.0, 3.0, 4.0]];
    let primitives: Vec<Value> = parts
        .iter()
        .map(|corners| {
            let indices = made.accessor(UNSIGNED_BYTE, "SCALAR", corners);
            json!({ "attributes": { "POSITION": points }, "indices": indices })
        })
        .collect();
    let mesh = one_mesh(made, &primitives).read().mesh;
    assert_eq!(mesh.positions.len(), 5);
    assert_eq!(mesh.triangles, TRIANGLES[..3]);
}

/// A node's members, and what moves its points.
fn places() -> Vec<(Value, DAffine3)> {
    let turn = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(1.0);
    let [x, y, z, w] = turn.to_array();
    let translation = DVec3::new(1.0, -2.0, 3.5);
    let scale = DVec3::new(2.0, -0.5, 1.5);
    let matrix = DAffine3::from_scale_rotation_translation(scale, turn, translation);
    let columns = glam::DMat4::from(matrix).to_cols_array();
    vec![
        (json!({}), DAffine3::IDENTITY),
        (
            json!({ "translation": translation.to_array() }),
            DAffine3::from_translation(translation),
        ),
        (
            // Of length 2.
            json!({ "rotation": [2.0 * x, 2.0 * y, 2.0 * z, 2.0 * w] }),
            DAffine3::from_quat(turn),
        ),
        (
            json!({ "scale": scale.to_array() }),
            DAffine3::from_scale(scale),
        ),
        (
            json!({ "translation": translation.to_array(), "scale": scale.to_array(), "rotation": [x, y, z, w] }),
            matrix,
        ),
        (json!({ "matrix": columns }), matrix),
    ]
}

/// That the mesh is pyramids in these places, those that are mirrored with their corners turned.
fn assert_places(mesh: &Mesh, places: &[DAffine3]) {
    assert_eq!(mesh.positions.len(), 5 * places.len());
    assert_eq!(mesh.triangles.len(), 6 * places.len());
    let found = corners(mesh);
    for (found, place) in found.chunks(6).zip(places) {
        for (found, triangle) in found.iter().zip(TRIANGLES) {
            let [a, b, c] = triangle.map(|corner| {
                place.transform_point3(Vec3::from(POINTS[corner as usize]).as_dvec3())
            });
            let is_mirrored = place.matrix3.determinant() < 0.0;
            let expected = if is_mirrored { [a, c, b] } else { [a, b, c] };
            for (found, expected) in found.iter().zip(expected) {
                let apart = found.as_dvec3().distance(expected);
                assert!(apart < 1e-5, "{found} is not {expected}");
            }
        }
    }
}

#[test]
fn nodes_move_what_is_below_them() {
    for (outer, first) in places() {
        for (inner, second) in places() {
            let mut made = Made::new();
            let mesh = made.pyramid();
            let mut inner = inner.clone();
            inner["mesh"] = json!(mesh);
            let mut outer = outer.clone();
            outer["children"] = json!([1]);
            outer["mesh"] = json!(mesh);
            made.json["nodes"] = json!([outer, inner]);
            assert_places(&made.read().mesh, &[first, first * second]);
        }
    }
}

#[test]
fn the_default_scene_is_shown_else_all_nodes_else_all_meshes() {
    let mut made = Made::new();
    let mesh = made.pyramid();
    let at = |x: f64| json!({ "mesh": mesh, "translation": [x, 0, 0] });
    made.json["nodes"] = json!([at(1.0), at(2.0), { "children": [0] }]);
    made.json["scenes"] = json!([{ "nodes": [2] }, { "nodes": [1] }]);
    let moved = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    assert_places(&made.read().mesh, &[moved(2.0), moved(1.0)]);
    made.json["scene"] = json!(1);
    let model = made.read();
    assert_places(&model.mesh, &[moved(2.0)]);
    assert_eq!(
        model.remarks,
        ["only the default scene is shown, the file has others"]
    );
    made.json["scene"] = json!(0);
    assert_places(&made.read().mesh, &[moved(1.0)]);
    made.json["nodes"] = json!([]);
    made.json["scenes"] = json!([]);
    made.json.as_object_mut().unwrap().remove("scene");
    assert_places(&made.read().mesh, &[DAffine3::IDENTITY]);
}

#[test]
fn instances_are_repeated() {
    let mut made = Made::new();
    let mesh = made.pyramid();
    let turn = DQuat::from_rotation_y(0.7);
    let moves = [[1.0, 2.0, 3.0], [-4.0, 0.5, 0.0]];
    let translation = made.accessor(FLOAT, "VEC3", moves.as_flattened());
    let rotations = [DQuat::IDENTITY.to_array(), turn.to_array()];
    let rotation = made.accessor(FLOAT, "VEC4", rotations.as_flattened());
    let scale = made.accessor(FLOAT, "VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, -2.0]);
    made.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let attributes = json!({ "TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale });
    made.json["nodes"] = json!([{
        "mesh": mesh, "translation": [0, 0, 9],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } },
    }]);
    let above = DAffine3::from_translation(DVec3::new(0.0, 0.0, 9.0));
    let places = [
        above * DAffine3::from_translation(DVec3::from(moves[0])),
        above
            * DAffine3::from_scale_rotation_translation(
                DVec3::new(2.0, 2.0, -2.0),
                turn,
                DVec3::from(moves[1]),
            ),
    ];
    assert_places(&made.read().mesh, &places);
    made.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({});
    assert!(
        made.fault()
            .contains("node 0 of the GLB file has instances")
    );
}

#[test]
fn skins_and_morph_targets_are_shown_at_rest() {
    let mut made = Made::new();
    let mesh = made.pyramid();
    made.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    // The joint stands at 5, and was bound at 3: the mesh was moved by 2 with its skeleton.
    let mut inverse = glam::DMat4::IDENTITY;
    inverse.w_axis.x = -3.0;
    let matrices = made.accessor(FLOAT, "MAT4", &inverse.to_cols_array());
    made.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": matrices }]);
    made.json["nodes"] = json!([
        { "mesh": mesh, "skin": 0, "translation": [100, 0, 0] },
        { "translation": [5, 0, 0] },
    ]);
    let model = made.read();
    assert_places(&model.mesh, &[DAffine3::from_translation(DVec3::X * 2.0)]);
    assert_eq!(model.remarks.len(), 2, "{:?}", model.remarks);
    // A skin without use leaves the node's place.
    made.json["skins"] = json!([{ "joints": [] }]);
    assert_places(
        &made.read().mesh,
        &[DAffine3::from_translation(DVec3::X * 100.0)],
    );
}

#[test]
fn models_far_from_zero_keep_their_detail() {
    let mut made = Made::with_pyramid();
    made.json["nodes"][0]["translation"] = json!([4.5e6, 0, 0]);
    let mesh = made.read().mesh;
    assert!(mesh.origin.x > 4e6, "{}", mesh.origin);
    let sizes = [
        mesh.positions[1] - mesh.positions[0],
        mesh.positions[4] - mesh.positions[0],
    ];
    assert_eq!(sizes, [Vec3::X * 2.0, Vec3::new(1.0, 1.0, 1.5)]);
}

/// A file with something of everything, to be changed at random.
pub(super) fn everything() -> Made {
    let mut made = painted::painted();
    let mesh = made.pyramid();
    let places = made.accessor(FLOAT, "VEC3", &[0.0, 0.0, 1.0, 0.0, 2.0, 0.0]);
    let attributes = json!({ "TRANSLATION": places });
    made.add(
        "nodes",
        json!({ "mesh": mesh, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } }),
    );
    let points = made.json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"].clone();
    let at = made.view(&[4]);
    let new = made.view(&[0; 12]);
    made.json["accessors"][points.as_u64().unwrap() as usize]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": at, "componentType": UNSIGNED_BYTE },
        "values": { "bufferView": new },
    });
    made.add(
        "nodes",
        json!({ "mesh": mesh, "skin": 0, "children": [0, 1], "scale": [1, -1, 1] }),
    );
    made.json["skins"] = json!([{ "joints": [0] }]);
    made.json["scenes"] = json!([{ "nodes": [2] }]);
    made.json["scene"] = json!(0);
    made
}
