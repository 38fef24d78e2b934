//! The hierarchy in a file, so that a model that was picked once is picked at once the next time.
//!
//! The file holds which boxes are in which and the order of the triangles, but no box: boxes are made anew from the mesh when it is read, in a
//! tenth of the time that building takes. So a file can be old, damaged or made to do harm, and still nothing wrong is found: it is taken
//! only if it is of this very mesh (by a hash of its content), whole (by a checksum), and a tree that holds each triangle once and
//! is not too deep to be walked. Else the hierarchy is built, and nobody is bothered.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::build::{depth, usable_triangles};
use super::node::{Child, Node};
use super::{DEPTH_MOST, Hierarchy, Picker};
use crate::mesh::Mesh;
use crate::tree::TreeError;
use crate::tree::file::write_atomically_with;

/// Begins each file; the last two bytes are the version.
const MAGIC: [u8; 8] = *b"RamusB01";
/// Numbers are in the machine's order of bytes, and others do not see this one.
const ORDER: u32 = 0x0102_0304;

/// What a file begins with.
#[derive(Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Header {
    magic: [u8; 8],
    order: u32,
    /// How many nodes.
    nodes: u32,
    /// How many triangles.
    triangles: u32,
    rest: u32,
    /// Of the mesh.
    hash: [u64; 2],
    /// Of all that follows.
    checksum: u64,
}

const HEADER: usize = size_of::<Header>();

/// Where a picker came from.
#[derive(Debug)]
pub enum Cache {
    /// It was read from the file.
    Read,
    /// It was built and written.
    Written,
    /// It was built, and could not be written, which does it no harm.
    Failed(TreeError),
}

impl Picker {
    /// Reads the hierarchy from a file, or builds it, as [`Picker::new`], and writes it there, whole or not at all. None when `cancel` was set.
    pub fn cached(
        mesh: Arc<Mesh>,
        path: &Path,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Option<(Self, Cache)> {
        let hash = hash(&mesh);
        if let Some(picker) = Self::load(&mesh, hash, path, cancel) {
            return Some((picker, Cache::Read));
        }
        let picker = Self::new(mesh, cancel, progress)?;
        let told = match picker.save(hash, path) {
            Ok(()) => Cache::Written,
            Err(error) => Cache::Failed(error),
        };
        Some((picker, told))
    }

    /// What a file that keeps a mesh's hierarchy may be called: the same for the same mesh, whatever it is called.
    #[must_use]
    pub fn name_of(mesh: &Mesh) -> String {
        let [one, other] = hash(mesh);
        format!("{one:016x}{other:016x}")
    }

    fn load(mesh: &Arc<Mesh>, hash: [u64; 2], path: &Path, cancel: &AtomicBool) -> Option<Self> {
        // What is no plain file may never end, or never begin.
        if !path.metadata().ok()?.is_file() {
            return None;
        }
        let most = HEADER + (16 + 4) * (mesh.triangles.len() + 1);
        let mut bytes = Vec::new();
        let mut file = File::open(path).ok()?.take(u64::try_from(most).ok()?);
        file.read_to_end(&mut bytes).ok()?;
        let mut hierarchy = Hierarchy::from_bytes(mesh, hash, &bytes)?;
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        hierarchy.fit(mesh);
        Some(Self::of(Arc::clone(mesh), hierarchy))
    }

    fn save(&self, hash: [u64; 2], path: &Path) -> Result<(), TreeError> {
        let bytes = self.hierarchy.to_bytes(hash);
        write_atomically_with(path, |out| out.write_all(&bytes))
    }
}

/// A hash of what picking depends on.
fn hash(mesh: &Mesh) -> [u64; 2] {
    let mut hash = Xxh3::new();
    hash.update(&mesh.positions.len().to_ne_bytes());
    hash.update(bytemuck::cast_slice(&mesh.positions));
    hash.update(bytemuck::cast_slice(&mesh.triangles));
    let hash = hash.digest128().to_ne_bytes();
    bytemuck::cast(hash)
}

impl Hierarchy {
    fn to_bytes(&self, hash: [u64; 2]) -> Vec<u8> {
        let topology: Vec<[u32; 4]> = self.nodes.iter().map(|node| node.children).collect();
        let mut bytes = vec![0; HEADER];
        bytes.extend_from_slice(bytemuck::cast_slice(&topology));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.order));
        let count = |len: usize| u32::try_from(len).unwrap_or(u32::MAX);
        let header = Header {
            magic: MAGIC,
            order: ORDER,
            nodes: count(self.nodes.len()),
            triangles: count(self.order.len()),
            rest: 0,
            hash,
            checksum: xxh3_64(&bytes[HEADER..]),
        };
        bytes[..HEADER].copy_from_slice(bytemuck::bytes_of(&header));
        bytes
    }

    /// Without boxes. None unless it is whole, of this mesh, and as it must be to be walked.
    fn from_bytes(mesh: &Mesh, hash: [u64; 2], bytes: &[u8]) -> Option<Self> {
        let (header, body) = bytes.split_at_checked(HEADER)?;
        let header: Header = bytemuck::pod_read_unaligned(header);
        let of_this_mesh = header.magic == MAGIC && header.order == ORDER && header.hash == hash;
        if !of_this_mesh || header.checksum != xxh3_64(body) {
            return None;
        }
        let (topology, order) = body.split_at_checked(16 * header.nodes as usize)?;
        if order.len() != 4 * header.triangles as usize {
            return None;
        }
        let topology: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(topology);
        let order: Vec<u32> = bytemuck::pod_collect_to_vec(order);
        (is_tree(&topology, order.len()) && is_order(mesh, &order)).then(|| Self {
            nodes: topology.into_iter().map(Node::new).collect(),
            order,
            corners: Vec::new(),
        })
    }
}

/// Every node but the first is below one other, every place of a triangle is in one run, and it is not too deep.
fn is_tree(topology: &[[u32; 4]], triangles: usize) -> bool {
    let mut below = vec![false; topology.len()];
    let mut covered = vec![false; triangles];
    let once = |seen: &mut [bool], place: usize| {
        seen.get_mut(place)
            .is_some_and(|seen| !std::mem::replace(seen, true))
    };
    let is_once = topology
        .as_flattened()
        .iter()
        .all(|child| match Child::new(*child) {
            Child::Empty => true,
            Child::Node(node) => once(&mut below, node as usize),
            Child::Run { start, length } => (start as usize..start as usize + length as usize)
                .all(|place| once(&mut covered, place)),
        });
    // The first node is below none; if no node stands before its parent, the others are all reached from it.
    is_once
        && below.iter().skip(1).all(|below| *below)
        && covered.iter().all(|covered| *covered)
        && depth(topology).is_some_and(|depth| depth <= DEPTH_MOST)
}

/// Each triangle that can be picked once, and no other.
fn is_order(mesh: &Mesh, order: &[u32]) -> bool {
    let mut left = vec![false; mesh.triangles.len()];
    let usable = usable_triangles(mesh);
    usable
        .iter()
        .for_each(|triangle| left[*triangle as usize] = true);
    usable.len() == order.len()
        && order
            .iter()
            .all(|triangle| left.get_mut(*triangle as usize).is_some_and(std::mem::take))
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that stops says enough by stopping"
    )]
    use glam::Vec3;
    use proptest::prelude::*;

    use super::super::tests::picker;
    use super::*;
    use crate::mesh::made;

    fn cached(mesh: &Arc<Mesh>, path: &Path) -> (Picker, Cache) {
        let never = AtomicBool::new(false);
        Picker::cached(Arc::clone(mesh), path, &never, &mut |_, _| {}).unwrap()
    }

    #[test]
    fn a_file_is_written_once_and_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.bvh");
        let mesh = Arc::new(made::torus(40, 20));
        assert!(matches!(cached(&mesh, &path).1, Cache::Written));
        let (read, cache) = cached(&mesh, &path);
        assert!(matches!(cache, Cache::Read));
        let built = picker((*mesh).clone());
        for point in &mesh.positions {
            let asked = *point * 1.3 + Vec3::new(0.1, 0.2, 0.3);
            assert_eq!(read.nearest(asked, 9.0), built.nearest(asked, 9.0));
            assert_eq!(read.ray(asked, -asked, 9.0), built.ray(asked, -asked, 9.0));
        }
        // Of another mesh: built, and the file is of that one then.
        let mut other = (*mesh).clone();
        other.positions[7].x += 0.001;
        let other = Arc::new(other);
        assert!(matches!(cached(&other, &path).1, Cache::Written));
        assert!(matches!(cached(&other, &path).1, Cache::Read));
        // An empty mesh has a file, too.
        let nothing = Arc::new(Mesh::default());
        assert!(matches!(cached(&nothing, &path).1, Cache::Written));
        assert!(matches!(cached(&nothing, &path).1, Cache::Read));
    }

    #[test]
    fn a_place_that_cannot_be_written_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = Arc::new(made::cube());
        for path in [
            folder.path().to_owned(),
            folder.path().join("no/such/folder/x"),
        ] {
            let (picker, cache) = cached(&mesh, &path);
            assert!(matches!(cache, Cache::Failed(_)), "{cache:?}");
            assert!(picker.nearest(Vec3::ZERO, 1.0).is_some());
        }
    }

    #[test]
    fn files_cut_short_or_changed_anywhere_are_not_taken() {
        let mesh = made::sphere(1);
        let hash = hash(&mesh);
        let whole = picker(mesh.clone()).hierarchy.to_bytes(hash);
        assert!(Hierarchy::from_bytes(&mesh, hash, &whole).is_some());
        for place in 0..whole.len() {
            assert!(Hierarchy::from_bytes(&mesh, hash, &whole[..place]).is_none());
            let mut changed = whole.clone();
            changed[place] ^= 0x10;
            // Bytes that mean nothing may change.
            let header: Header = bytemuck::pod_read_unaligned(&changed[..HEADER]);
            assert!(
                header.rest != 0 || Hierarchy::from_bytes(&mesh, hash, &changed).is_none(),
                "{place}"
            );
        }
        let longer = [whole.as_slice(), &[0; 4]].concat();
        assert!(Hierarchy::from_bytes(&mesh, hash, &longer).is_none());
    }

    proptest! {
        /// With a right checksum: whatever is taken finds what it should.
        #[test]
        fn hostile_trees_are_not_walked(changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![0_u32..70, any::<u32>(), (0_u32..80).prop_map(|n| n | 1 << 31)]), 1..4)) {
            let mesh = made::sphere(1);
            let hash = hash(&mesh);
            let mut bytes = picker(mesh.clone()).hierarchy.to_bytes(hash);
            let numbers = (bytes.len() - HEADER) / 4;
            for (place, number) in changes {
                let at = HEADER + 4 * place.index(numbers);
                bytes[at..at + 4].copy_from_slice(&number.to_ne_bytes());
            }
            let checksum = xxh3_64(&bytes[HEADER..]);
            bytes[HEADER - 8..HEADER].copy_from_slice(&checksum.to_ne_bytes());
            if let Some(mut taken) = Hierarchy::from_bytes(&mesh, hash, &bytes) {
                taken.fit(&mesh);
                let built = picker(mesh.clone());
                let taken = Picker::of(Arc::new(mesh), taken);
                for point in &built.mesh.positions {
                    let asked = *point * 1.7;
                    prop_assert_eq!(taken.nearest(asked, 9.0), built.nearest(asked, 9.0));
                    prop_assert_eq!(taken.ray(asked, -*point, 9.0), built.ray(asked, -*point, 9.0));
                }
            }
        }
    }
}
