//! The reader of SWC files: no bytes may stop it, and what it read is a tree that can be written.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::tree::{NO_PARENT, export, import};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(tree) = import::swc(bytes) {
        tree.validate().expect("what was read is a whole tree");
        if tree.parent.iter().all(|parent| *parent == NO_PARENT) {
            return; // no segment: nothing to take home
        }
        let written = export::swc(&tree).expect("what was read can be written");
        let again = import::swc(&written).expect("what was written can be read");
        assert_eq!(tree.parent.len(), again.parent.len(), "no node is lost");
    }
});
