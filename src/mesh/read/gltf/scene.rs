//! Where meshes stand (§3.5): nodes, each in the space of the one above it, and what is repeated in many places.
//!
//! Nodes are walked with a stack of our own, each once, so that neither depth nor circles matter; matrices are multiplied in double
//! precision. A mesh with a skeleton stands where its first joint puts it: in the pose in which it was bound to the skeleton all
//! joints put it there, and its node's own place does not count (§3.7.3.3).

use std::sync::Arc;

use ::gltf::json::{Root, scene::Node};
use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::super::{Stop, Task};
use super::Remarks;
use super::elements::{Accessors, Elements};

/// The extension that repeats a mesh: <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_mesh_gpu_instancing>.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// Nodes between two looks at whether to go on.
const NODES: usize = 1 << 10;

/// A mesh in one place, or in several from there.
pub(super) struct Placement<'a> {
    pub(super) mesh: usize,
    scene_from_mesh: DAffine3,
    instances: Option<Instances<'a>>,
}

/// Places in the space of a node.
struct Instances<'a> {
    count: usize,
    translation: Option<Arc<Elements<'a>>>,
    rotation: Option<Arc<Elements<'a>>>,
    scale: Option<Arc<Elements<'a>>>,
}

impl Placement<'_> {
    /// How many times the mesh is there.
    pub(super) fn count(&self) -> usize {
        self.instances.as_ref().map_or(1, |all| all.count)
    }

    /// The place of one of them.
    pub(super) fn place(&self, number: usize) -> DAffine3 {
        let Some(instances) = &self.instances else {
            return self.scene_from_mesh;
        };
        let row = |column: &Option<Arc<Elements<'_>>>| {
            column
                .as_ref()
                .map(|elements| elements.any_row::<3>(number))
        };
        let rotation = instances.rotation.as_ref();
        let rotation = rotation.map(|elements| elements.any_row::<4>(number));
        self.scene_from_mesh * affine(row(&instances.scale), rotation, row(&instances.translation))
    }
}

/// All meshes of the scene that is shown: the default one, else all nodes; where a file has no node, all meshes.
pub(super) fn read<'a>(
    root: &Root,
    accessors: &Accessors<'a>,
    task: &Task<'_>,
    remarks: &mut Remarks,
) -> Result<Vec<Placement<'a>>, Stop> {
    if root.nodes.is_empty() {
        let meshes = (0..root.meshes.len()).map(|mesh| Placement {
            mesh,
            scene_from_mesh: DAffine3::IDENTITY,
            instances: None,
        });
        return Ok(meshes.collect());
    }
    if root.scene.is_some() && root.scenes.len() > 1 {
        remarks.add("only the default scene is shown, the file has others");
    }
    let (order, places) = walk(root, task)?;
    let mut placements = Vec::new();
    for (at, number) in order.into_iter().enumerate() {
        if at % NODES == 0 {
            task.go_on()?;
        }
        let Some(node) = root.nodes.get(number) else {
            continue;
        };
        let Some(mesh) = node.mesh else { continue };
        if root.meshes.get(mesh.value()).is_none() {
            let problem = format!(
                "shows mesh {}, but there are {}: save the file again",
                mesh.value(),
                root.meshes.len()
            );
            return Err(Stop::item("node", number, problem));
        }
        let bound = node.skin.and_then(|skin| {
            remarks.add("a mesh with a skeleton is shown in the pose in which it was bound to it");
            bound(root, accessors, skin.value(), &places)
        });
        placements.push(Placement {
            mesh: mesh.value(),
            scene_from_mesh: bound.unwrap_or(places[number].unwrap_or(DAffine3::IDENTITY)),
            instances: instances(node, number, accessors)?,
        });
    }
    Ok(placements)
}

/// Nodes of the scene by their number, parents first, and where each stands.
fn walk(root: &Root, task: &Task<'_>) -> Result<(Vec<usize>, Vec<Option<DAffine3>>), Stop> {
    let mut order = Vec::new();
    let mut places: Vec<Option<DAffine3>> = vec![None; root.nodes.len()];
    let mut open: Vec<(usize, DAffine3)> = starts(root)?
        .into_iter()
        .rev()
        .map(|node| (node, DAffine3::IDENTITY))
        .collect();
    while let Some((number, above)) = open.pop() {
        if order.len() % NODES == 0 {
            task.go_on()?;
        }
        let Some(node) = root.nodes.get(number) else {
            let problem = format!(
                "is named, but there are {}: save the file again",
                root.nodes.len()
            );
            return Err(Stop::item("node", number, problem));
        };
        if places[number].is_some() {
            let problem = "is in the scene twice, below two nodes or below itself: a node has one parent, save the file again";
            return Err(Stop::item("node", number, problem));
        }
        let place = above * place(node);
        if !place.is_finite() {
            let problem = "stands nowhere: its matrix, or that of one above it, is not finite";
            return Err(Stop::item("node", number, problem));
        }
        places[number] = Some(place);
        order.push(number);
        let children = node.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), place)));
    }
    Ok((order, places))
}

/// The nodes on top.
fn starts(root: &Root) -> Result<Vec<usize>, Stop> {
    if let Some(number) = root.scene.map(|scene| scene.value()) {
        let Some(scene) = root.scenes.get(number) else {
            let problem = format!(
                "is to be shown, but there are {}: save the file again",
                root.scenes.len()
            );
            return Err(Stop::item("scene", number, problem));
        };
        return Ok(scene.nodes.iter().map(|node| node.value()).collect());
    }
    let mut has_parent = vec![false; root.nodes.len()];
    for child in root
        .nodes
        .iter()
        .flat_map(|node| node.children.iter().flatten())
    {
        if let Some(has_parent) = has_parent.get_mut(child.value()) {
            *has_parent = true;
        }
    }
    let nodes = has_parent.into_iter().enumerate();
    let starts: Vec<usize> = nodes
        .filter_map(|(node, has_parent)| (!has_parent).then_some(node))
        .collect();
    if starts.is_empty() {
        let problem = "is below itself, as all nodes are: save the file again";
        return Err(Stop::item("node", 0, problem));
    }
    Ok(starts)
}

/// Where a node stands in the space of the one above it.
fn place(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    affine(
        node.scale.map(|scale| scale.map(f64::from)),
        node.rotation.map(|rotation| rotation.0.map(f64::from)),
        node.translation
            .map(|translation| translation.map(f64::from)),
    )
}

fn affine(
    scale: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    translation: Option<[f64; 3]>,
) -> DAffine3 {
    // In single or less precision it has not exactly the length 1.
    let rotation = rotation.map(DQuat::from_array);
    let rotation = rotation.filter(|rotation| {
        let length = rotation.length();
        length > 0.0 && length.is_finite()
    });
    DAffine3::from_scale_rotation_translation(
        scale.map_or(DVec3::ONE, DVec3::from_array),
        rotation.map_or(DQuat::IDENTITY, DQuat::normalize),
        translation.map_or(DVec3::ZERO, DVec3::from_array),
    )
}

/// Where a skin puts its mesh; None where it does not say.
fn bound(
    root: &Root,
    accessors: &Accessors<'_>,
    skin: usize,
    places: &[Option<DAffine3>],
) -> Option<DAffine3> {
    let skin = root.skins.get(skin)?;
    let joint = (*places.get(skin.joints.first()?.value())?)?;
    let Some(matrices) = skin.inverse_bind_matrices else {
        return Some(joint);
    };
    let matrices = accessors.get(matrices.value()).ok()?;
    let is_matrices = matrices.layout.columns == 16 && matrices.layout.rows > 0;
    let matrix = is_matrices.then(|| DMat4::from_cols_array(&matrices.any_row::<16>(0)))?;
    let place = joint * DAffine3::from_mat4(matrix);
    place.is_finite().then_some(place)
}

/// The places of a node's mesh, where it has several.
fn instances<'a>(
    node: &Node,
    number: usize,
    accessors: &Accessors<'a>,
) -> Result<Option<Instances<'a>>, Stop> {
    let extensions = node.extensions.as_ref();
    let Some(extension) = extensions.and_then(|all| all.others.get(INSTANCING)) else {
        return Ok(None);
    };
    let fault = |problem: &str| {
        Stop::item(
            "node",
            number,
            format!("has instances ({INSTANCING}) {problem}: save the file again"),
        )
    };
    let mut count = None;
    let mut column = |name: &str, columns: usize| {
        let accessor = extension.get("attributes").and_then(|all| all.get(name));
        let Some(accessor) = accessor else {
            return Ok(None);
        };
        let accessor = accessor.as_u64().and_then(|at| usize::try_from(at).ok());
        let accessor = accessor.ok_or_else(|| fault("that name no accessor"))?;
        let elements = accessors.get(accessor)?;
        if elements.layout.columns != columns {
            return Err(fault("of which an accessor has the wrong type"));
        }
        if *count.get_or_insert(elements.layout.rows) != elements.layout.rows {
            return Err(fault("of which accessors differ in length"));
        }
        Ok(Some(elements))
    };
    let translation = column("TRANSLATION", 3)?;
    let rotation = column("ROTATION", 4)?;
    let scale = column("SCALE", 3)?;
    let count = count.ok_or_else(|| fault("without a place"))?;
    Ok(Some(Instances {
        count,
        translation,
        rotation,
        scale,
    }))
}
