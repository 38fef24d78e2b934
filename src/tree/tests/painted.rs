//! Drawings with organs as GLB and OBJ, read back by readers that we did not write.

use glam::{Quat, Vec3, vec3};

use super::fork;
use crate::tree::export::{ExportParams, Extras, Glb, Obj, Stand, glb};
use crate::tree::organs::{
    Material, OrganMesh, Organist, Paint, Placed, Polygon, Smooth, Sphere, Surface,
};
use crate::tree::{NO_PARENT, Organs, Tree};

/// One of everything, on the fork.
pub(super) fn laden() -> (Tree, Organs) {
    let tree = fork();
    let mut organs = Organs {
        surfaces: vec![
            Surface::built_in("leaf").unwrap(),
            Surface::built_in("flower").unwrap(),
        ],
        ..Organs::default()
    };
    let paint = |colour, material| Paint { colour, material };
    organs.set_paint(4, paint(3, 0));
    organs.set_paint(5, paint(4, 2));
    organs.palette.set_material(
        2,
        Material {
            roughness: 0.25,
            metallic: 0.5,
        },
    );
    organs.polygons.push(Polygon {
        first: 0,
        paint: paint(2, 0),
        birth: 0,
        node: 3,
    });
    organs.corners = vec![
        Vec3::Y,
        vec3(1.0, 1.0, 0.0),
        vec3(0.3, 1.3, 0.0),
        vec3(0.0, 2.0, 0.0),
    ];
    organs.spheres.push(Sphere {
        center: Vec3::Y * 3.0,
        radius: 0.2,
        paint: paint(5, 2),
        birth: 1,
        node: NO_PARENT,
    });
    for (surface, scale) in [(0, 1.0), (1, 0.5), (1, -0.5)] {
        organs.placed.push(Placed {
            surface,
            paint: paint(0, 0),
            position: Vec3::Y * 2.0,
            orientation: Quat::from_rotation_x(0.4),
            scale,
            birth: 1,
            node: 2,
            light: 1.0,
        });
    }
    organs.smooth = [1, 2, 4, 5]
        .map(|node| Smooth {
            node,
            cylinder: if node < 4 { 1 } else { 4 },
        })
        .to_vec();
    organs.validate(&tree).unwrap();
    (tree, organs)
}

pub(super) fn laden_glb() -> Vec<u8> {
    let (tree, organs) = laden();
    let file = Glb::new(&tree, &organs, &ExportParams::default()).unwrap();
    let mut bytes = Vec::new();
    file.write(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_glb_holds_a_node_for_bark_and_one_for_each_material() {
    let bytes = laden_glb();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref();
    let primitives: Vec<_> = file
        .meshes()
        .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>())
        .collect();
    let names: Vec<_> = primitives
        .iter()
        .map(|p| p.material().name().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["bark", "material 0", "material 2"]);
    let root = file.default_scene().unwrap().nodes().next().unwrap();
    let parts: Vec<_> = root
        .children()
        .map(|node| node.name().unwrap().to_owned())
        .collect();
    assert_eq!(
        (root.name(), parts),
        (
            Some("tree"),
            ["wood", "painted", "painted-2"].map(str::to_owned).to_vec()
        )
    );
    let wet = primitives[2].material();
    let pbr = wet.pbr_metallic_roughness();
    assert_eq!((pbr.roughness_factor(), pbr.metallic_factor()), (0.25, 0.5));
    assert!(wet.double_sided() && pbr.base_color_texture().is_none());

    let (_, organs) = laden();
    let colours_of = |at: usize| -> Vec<[f32; 3]> {
        let reader = primitives[at].reader(|_| blob);
        let colours = reader
            .read_colors(0)
            .unwrap()
            .into_rgb_f32()
            .collect::<Vec<_>>();
        assert_eq!(colours.len(), reader.read_positions().unwrap().count());
        assert_eq!(colours.len(), reader.read_normals().unwrap().count());
        let most = reader.read_indices().unwrap().into_u32().max().unwrap();
        assert!((most as usize) < colours.len());
        colours
    };
    let has = |colours: &[[f32; 3]], index: u16| {
        let wanted = organs.palette.colour(index).unwrap();
        let near = |c: &[f32; 3]| c.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4);
        colours.iter().filter(|c| near(c)).count()
    };
    let (matte, wet) = (colours_of(1), colours_of(2));
    assert_eq!(has(&matte, 2), 4, "the polygon's corners");
    assert!(has(&matte, 3) >= 18 && has(&matte, 4) == 0, "a red segment");
    assert!(has(&wet, 4) >= 18, "a yellow segment of the wet material");
    assert!(has(&wet, 5) > 50, "the sphere");
    assert!(primitives[0].reader(|_| blob).read_colors(0).is_none());
}

#[test]
fn an_obj_has_colours_once_something_is_painted() {
    let (tree, organs) = laden();
    let mut text = Vec::new();
    let file = Obj::new(&tree, &organs, &ExportParams::default()).unwrap();
    file.write(&mut text).unwrap();
    let options = tobj::LoadOptions {
        single_index: false,
        ..tobj::LoadOptions::default()
    };
    let none = |_: &std::path::Path| Err(tobj::LoadError::GenericFailure);
    let (models, _) = tobj::load_obj_buf(&mut &text[..], &options, none).unwrap();
    let mesh = &models[0].mesh;
    assert_eq!(
        mesh.vertex_color.len(),
        mesh.positions.len(),
        "for every vertex"
    );
    let glb = gltf::Gltf::from_slice(&laden_glb()).unwrap();
    let indices: usize = glb
        .meshes()
        .flat_map(|mesh| {
            mesh.primitives()
                .map(|p| p.indices().unwrap().count())
                .collect::<Vec<_>>()
        })
        .sum();
    assert_eq!(mesh.indices.len(), indices, "the same triangles");
    let red = [190.0, 38.0, 30.0].map(|part: f32| part / 255.0);
    let near = |c: &[f32]| c.iter().zip(red).all(|(a, b)| (a - b).abs() < 1e-3);
    assert!(
        mesh.vertex_color.chunks_exact(3).any(near),
        "sRGB as it is given"
    );
}

#[test]
fn organs_alone_make_files_and_none_make_the_file_of_the_tree() {
    let (tree, organs) = laden();
    let bare = Tree {
        letters: tree.letters.clone(),
        ..Tree::default()
    };
    let alone = Organs {
        spheres: organs.spheres.clone(),
        ..Organs::default()
    };
    let file = Glb::new(&bare, &alone, &ExportParams::default()).unwrap();
    let mut bytes = Vec::new();
    file.write(&mut bytes).unwrap();
    let read = gltf::Gltf::from_slice(&bytes).unwrap();
    assert_eq!((read.materials().count(), read.images().count()), (1, 0));

    let plain = glb(&tree, &ExportParams::default()).unwrap();
    let read = gltf::Gltf::from_slice(&plain).unwrap();
    assert_eq!((read.materials().count(), read.images().count()), (1, 3));
    let mut broken = organs.clone();
    broken.spheres[0].center = Vec3::NAN;
    let error = Glb::new(&tree, &broken, &ExportParams::default()).unwrap_err();
    assert!(error.to_string().contains("sphere 0"), "{error}");
}

/// Rows of floats, or of 16-bit parts of 1, of the accessor of a number.
fn rows(file: &gltf::Gltf, number: usize) -> Vec<Vec<f32>> {
    let accessor = file.accessors().nth(number).unwrap();
    let view = accessor.view().unwrap();
    let bytes = &file.blob.as_ref().unwrap()[view.offset()..][..view.length()];
    let number = |bytes: &[u8]| match bytes {
        [a, b] => f32::from(i16::from_le_bytes([*a, *b])) / 32767.0,
        four => f32::from_le_bytes(four.try_into().unwrap()),
    };
    let rows = bytes.chunks_exact(accessor.size());
    let size = accessor.data_type().size();
    rows.map(|row| row.chunks_exact(size).map(number).collect())
        .collect()
}

/// Each instance puts its surface where the mesh of the whole has it, turned inside out where that is.
#[test]
fn instances_stand_where_their_surfaces_would() {
    let (tree, organs) = laden();
    let params = ExportParams::default();
    let mut stand = Stand::of("laden", &tree, &organs, &params);
    stand.extras = Extras {
        instances: true,
        ..Extras::default()
    };
    let mut bytes = Vec::new();
    let glb = Glb::of(&stand).unwrap();
    glb.write(&mut bytes).unwrap();
    assert_eq!(glb.bytes(), bytes.len() as u64);
    let file = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
    let mut found = Vec::new();
    for node in file.nodes() {
        let Some(extension) = node.extension_value("EXT_mesh_gpu_instancing") else {
            continue;
        };
        let column = |name: &str| {
            let number = extension["attributes"][name].as_u64().unwrap();
            rows(&file, usize::try_from(number).unwrap())
        };
        let places = column("TRANSLATION").into_iter().zip(column("ROTATION"));
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| file.blob.as_deref());
        let leaf: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
        for ((place, turn), scale) in places.zip(column("SCALE")) {
            let turn = Quat::from_slice(&turn).normalize();
            let all = leaf
                .iter()
                .map(|p| Vec3::from_slice(&place) + turn * (Vec3::from_slice(&scale) * *p));
            found.push(all.collect::<Vec<_>>());
        }
    }
    assert_eq!(found.len(), organs.placed.len());
    let mut organist = Organist::new(&organs);
    let first = organs.polygons.len() + organs.spheres.len();
    for (index, found) in (first..organs.len()).zip(&found) {
        let mut mesh = OrganMesh::default();
        organist.add(index, &mut mesh);
        assert_eq!(mesh.positions.len(), found.len());
        for (one, other) in mesh.positions.iter().zip(found) {
            assert!(Vec3::from(*one).distance(*other) < 1e-3);
        }
    }
}
