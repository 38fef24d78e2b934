//! GLB and OBJ, read back by readers that we did not write.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;

use super::tubes::segments_of;
use super::{any_tree, decent_tree, fork, node, tree_of};
use crate::tree::export::{ExportParams, glb, obj};
use crate::tree::mesh::mesh;
use crate::tree::radii::{RadiusParams, da_vinci};
use crate::tree::{NO_PARENT, Tree, TreeError};

fn thick_fork() -> Tree {
    let mut tree = fork();
    da_vinci(&mut tree, &RadiusParams::default(), 0);
    tree
}

/// Files are written in parts of some thousand segments: together they are the whole surface.
#[test]
fn a_surface_made_in_parts_is_the_whole_surface() {
    let nodes: Vec<_> = (0..10_000_u16)
        .map(|n| {
            let parent = u32::from(n).checked_sub(1).unwrap_or(NO_PARENT);
            let aside = f32::from(n % 7);
            node(
                parent,
                Vec3::new(aside, f32::from(n), 0.5 * aside),
                0.1,
                0,
                0,
            )
        })
        .collect();
    let tree = tree_of(&nodes);
    let expected = mesh(&segments_of(&tree, &[], u32::MAX), 1.0, 8);
    let params = ExportParams::default();
    let bytes = glb(&tree, &params).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| file.blob.as_deref());
    let positions: Vec<_> = reader.read_positions().unwrap().collect();
    let indices: Vec<_> = reader.read_indices().unwrap().into_u32().collect();
    assert!(positions == expected.positions, "positions");
    assert!(indices == expected.indices, "indices");
    let (low, high) = expected.bounds();
    let bounds = primitive.bounding_box();
    assert_eq!((bounds.min, bounds.max), (low, high));

    let text = String::from_utf8(obj(&tree, &params).unwrap()).unwrap();
    let faces = text.lines().filter(|line| line.starts_with("f "));
    let corners: Vec<u32> = faces
        .flat_map(|line| line.split_whitespace().skip(1))
        .map(|corner| corner.split('/').next().unwrap().parse::<u32>().unwrap() - 1)
        .collect();
    assert!(corners == expected.indices, "faces");
}

#[test]
fn a_glb_is_read_back_whole_by_the_gltf_crate() {
    let tree = thick_fork();
    let bytes = glb(&tree, &ExportParams::default()).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let expected = mesh(&segments_of(&tree, &[], u32::MAX), 1.0, 8);
    let blob = file.blob.as_deref().unwrap();

    assert_eq!(file.meshes().count(), 1);
    assert_eq!(file.default_scene().unwrap().nodes().count(), 1);
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(blob));
    assert!(
        reader
            .read_positions()
            .unwrap()
            .eq(expected.positions.iter().copied())
    );
    assert!(
        reader
            .read_normals()
            .unwrap()
            .eq(expected.normals.iter().copied())
    );
    assert!(
        reader
            .read_tex_coords(0)
            .unwrap()
            .into_f32()
            .eq(expected.uvs.iter().copied())
    );
    assert!(
        reader
            .read_indices()
            .unwrap()
            .into_u32()
            .eq(expected.indices.iter().copied())
    );
    let (low, high) = expected.bounds();
    assert_eq!(
        primitive.bounding_box(),
        gltf::mesh::Bounds {
            min: low,
            max: high
        }
    );

    let material = primitive.material();
    assert_eq!(material.name(), Some("bark"));
    let pbr = material.pbr_metallic_roughness();
    assert_eq!(
        (pbr.metallic_factor(), pbr.base_color_factor()),
        (0.0, [1.0; 4])
    );
    let image = pbr
        .base_color_texture()
        .unwrap()
        .texture()
        .source()
        .unwrap()
        .source();
    let gltf::image::Source::View { view, mime_type } = image else {
        panic!("the texture is embedded")
    };
    assert_eq!(mime_type, "image/png");
    let png = image::load_from_memory(&blob[view.offset()..][..view.length()]).unwrap();
    assert_eq!((png.width(), png.height()), (256, 256));
    assert_eq!(
        file.document.as_json().asset.generator.as_deref(),
        Some(concat!("Ramus ", env!("CARGO_PKG_VERSION")))
    );
}

#[test]
fn the_same_tree_gives_the_same_bytes() {
    let tree = thick_fork();
    let params = ExportParams::default();
    assert_eq!(
        glb(&tree, &params).unwrap(),
        glb(&tree.clone(), &params).unwrap()
    );
    assert_eq!(
        obj(&tree, &params).unwrap(),
        obj(&tree.clone(), &params).unwrap()
    );
    assert_ne!(
        glb(&tree, &params).unwrap(),
        glb(&tree, &ExportParams { sides: 5 }).unwrap()
    );
}

#[test]
fn what_cannot_be_written_is_refused_with_a_reason() {
    let bare = tree_of(&[node(NO_PARENT, Vec3::ZERO, 0.1, 0, 0)]);
    for tree in [&bare, &Tree::default()] {
        for (format, result) in [
            ("GLB", glb(tree, &ExportParams::default())),
            ("OBJ", obj(tree, &ExportParams::default())),
        ] {
            let message = result.unwrap_err().to_string();
            assert!(
                message.contains("no segment")
                    && message.contains(format)
                    && message.contains("drawn by `F`"),
                "{message}"
            );
        }
    }
    for sides in [0, 2, 65, u32::MAX] {
        let error = glb(&fork(), &ExportParams { sides }).unwrap_err();
        assert!(
            matches!(error, TreeError::Parameter { most: 64.0, .. }),
            "{error}"
        );
    }
    let mut broken = fork();
    broken.position[3].x = f32::NAN;
    assert!(matches!(
        glb(&broken, &ExportParams::default()),
        Err(TreeError::Position(3))
    ));
    assert!(matches!(
        obj(&broken, &ExportParams::default()),
        Err(TreeError::Position(3))
    ));
}

#[test]
fn a_tree_too_large_for_the_format_is_refused_before_memory_is_taken() {
    let nodes = 1_000_000;
    let mut tree = Tree {
        letters: vec!["A".into()],
        ..Tree::with_capacity(nodes)
    };
    for index in 0..nodes as u32 {
        tree.push(node(
            index.checked_sub(1).unwrap_or(NO_PARENT),
            index as f32 * Vec3::Y,
            0.1,
            0,
            0,
        ));
    }
    for result in [
        glb(&tree, &ExportParams { sides: 64 }),
        obj(&tree, &ExportParams { sides: 64 }),
    ] {
        let message = result.unwrap_err().to_string();
        assert!(
            message.contains("may take up to") && message.contains("written up to 4.3 GB"),
            "{message}"
        );
    }
}

/// A tree whose shape overflows f32 makes no file with infinities in it.
#[test]
fn coordinates_at_the_end_of_f32_do_not_leave_it_silently() {
    let tree = tree_of(&[
        node(NO_PARENT, Vec3::splat(-3e38), 3e38, 0, 0),
        node(0, Vec3::splat(3e38), 3e38, 0, 0),
    ]);
    for result in [
        glb(&tree, &ExportParams::default()),
        obj(&tree, &ExportParams::default()),
    ] {
        let message = result.unwrap_err().to_string();
        assert!(message.contains("large"), "{message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_tree_makes_files_that_others_read(tree in any_tree(), sides in 3_u32..9) {
        prop_assume!(tree.segment_count() > 0);
        let expected = mesh(&segments_of(&tree, &[], u32::MAX), 1.0, sides);
        let params = ExportParams { sides };
        prop_assert!(gltf::Gltf::from_slice(&glb(&tree, &params).unwrap()).is_ok());

        let text = obj(&tree, &params).unwrap();
        let options = tobj::LoadOptions { single_index: false, ..tobj::LoadOptions::default() };
        let (models, _) = tobj::load_obj_buf(&mut &text[..], &options, |_| Err(tobj::LoadError::GenericFailure)).unwrap();
        prop_assert_eq!(models.len(), 1);
        let read = &models[0].mesh;
        prop_assert_eq!(&models[0].name, "tree");
        // The reader numbers vertices anew: compare them corner by corner.
        let corners = |indices: &[u32], values: &[f32], width: usize| -> Vec<f32> {
            indices.iter().flat_map(|&i| values[i as usize * width..][..width].to_vec()).collect()
        };
        let wanted = |values: &[f32], width| corners(&expected.indices, values, width);
        prop_assert_eq!(corners(&read.indices, &read.positions, 3), wanted(expected.positions.as_flattened(), 3));
        prop_assert_eq!(corners(&read.texcoord_indices, &read.texcoords, 2), wanted(expected.uvs.as_flattened(), 2));
        let normals = corners(&read.normal_indices, &read.normals, 3);
        prop_assert_eq!(normals.len(), 3 * expected.indices.len());
        prop_assert!(normals.iter().zip(wanted(expected.normals.as_flattened(), 3)).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}

/// Where npm's validator is: `RAMUS_GLTF_VALIDATOR` (a node_modules folder) or what `npm ci` made in tests/node.
fn validator_modules() -> Option<PathBuf> {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node/node_modules");
    let folder = std::env::var_os("RAMUS_GLTF_VALIDATOR").map_or(installed, PathBuf::from);
    folder.join("gltf-validator").is_dir().then_some(folder)
}

/// The judge of the format itself finds nothing: no error, no warning.
#[test]
fn khronos_validator_finds_nothing() {
    let Some(modules) = validator_modules() else {
        assert!(
            std::env::var_os("CI").is_none(),
            "CI runs `npm ci` in tests/node first"
        );
        println!(
            "skipped: gltf-validator is not installed (run `npm ci` in tests/node, or set RAMUS_GLTF_VALIDATOR)"
        );
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut trees = vec![thick_fork()];
    let mixed = prop_oneof![decent_tree(), any_tree()]
        .prop_filter("a segment", |tree| tree.segment_count() > 0);
    trees.extend((0..12).map(|_| mixed.new_tree(&mut runner).unwrap().current()));
    let files: Vec<PathBuf> = (0..)
        .zip(&trees)
        .map(|(i, tree)| {
            let path = folder.path().join(format!("tree-{i}.glb"));
            std::fs::write(&path, glb(tree, &ExportParams::default()).unwrap()).unwrap();
            path
        })
        .collect();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/validate-glb.mjs");
    let laden = folder.path().join("laden.glb");
    std::fs::write(&laden, super::painted::laden_glb()).unwrap();
    let output = Command::new("node")
        .arg(script)
        .arg("--modules")
        .arg(modules)
        .args(&files)
        .arg(&laden)
        .output()
        .unwrap();
    let report = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{report}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(
        report.matches("0 errors, 0 warnings").count(),
        trees.len() + 1,
        "{report}"
    );
    println!("{report}");
}
